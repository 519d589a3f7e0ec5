//! A file of any bytes, read as a journal.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::PathBuf;
use std::sync::LazyLock;

#[path = "../../crates/chatter-files/tests/laws/journal.rs"]
mod law;

/// The same file again and again, one for each process.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    std::env::temp_dir().join(format!("chatter-fuzz-journal-{}", std::process::id()))
});

fuzz_target!(|bytes: &[u8]| law::law(&FILE, bytes));
