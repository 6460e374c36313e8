//! The `vesica` program: arguments in, exit status out.

#[cfg(all(target_arch = "x86_64", target_os = "linux", target_feature = "avx2"))]
mod processor;

use std::process::ExitCode;

/// Counts what each thread holds, for `vesica effects`.
#[global_allocator]
static ALLOCATOR: vesica::internal::CountingAllocator = vesica::internal::CountingAllocator;

fn main() -> ExitCode {
    vesica::internal::main()
}
