//! A short run of a model made from any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/chatter/tests/laws/motion.rs"]
mod motion;
#[path = "../../crates/chatter/tests/laws/simulation.rs"]
mod simulation;

fuzz_target!(|bytes: &[u8]| simulation::law(bytes));
