//! Any bytes, read as a request to the explorer: one that is accepted has everything that the page's have.

#![no_main]

use chatter_explorer::{Guard, Method, Token, read_request};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static GUARD: LazyLock<Guard> =
    LazyLock::new(|| Guard::new(Token::drawn().expect("random numbers"), 4000));

fuzz_target!(|bytes: &[u8]| {
    let Ok(request) = read_request(&mut &*bytes) else {
        return;
    };
    assert!(request.path.starts_with('/'));
    assert!(request.method == Method::Post || request.method == Method::Get);
    // Nobody guesses a token.
    assert!(GUARD.check(&request).is_err());
});
