//! The `chatter` command.

fn main() {}
