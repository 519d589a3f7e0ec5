//! Motions of shipped models with any values of their parameters, from any state.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::cell::RefCell;

#[path = "../../crates/chatter/tests/laws/motion.rs"]
mod motion;

thread_local! {
    static PREPARED: RefCell<Vec<motion::Prepared>> = RefCell::new(motion::prepared());
}

fuzz_target!(|bytes: &[u8]| PREPARED.with_borrow_mut(|prepared| motion::law(prepared, bytes)));
