//! The `boxwood` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    boxwood::cli::main()
}
