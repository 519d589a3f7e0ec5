//! Whole conversations with the program: what was typed, what came back, the exit code.
//!
//! After a change that is meant to change them, run `TRYCMD=overwrite cargo test --release -p chatter-cli`, and read the
//! difference.

#[test]
fn transcripts() {
    trycmd::TestCases::new().case("tests/transcripts/*.trycmd");
}
