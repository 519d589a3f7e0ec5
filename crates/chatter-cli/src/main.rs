//! The `chatter` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    chatter_cli::main()
}
