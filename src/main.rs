//! The `vesica` program: arguments in, exit status out.

use std::process::ExitCode;

fn main() -> ExitCode {
    vesica::cli::main()
}
