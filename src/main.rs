//! The `vesica` program: arguments in, exit status out.

use std::process::ExitCode;

/// Counts what each thread holds, for `vesica effects`.
#[global_allocator]
static ALLOCATOR: vesica::study::CountingAllocator = vesica::study::CountingAllocator;

fn main() -> ExitCode {
    vesica::cli::main()
}
