//! The heap of the program: one for all threads.

/// Has the C library's allocator keep one heap for all threads. By itself it makes some for each, and
/// reserves 64 MiB of the address space for every one, which `ulimit -v` counts. Threads seldom
/// allocate at the same time here: a step allocates nothing. Called once, before there are other threads.
/// Other allocators do without.
pub(super) fn share_one() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: mallopt takes two numbers and is safe to call; that no other thread allocates meanwhile
        // is only for the setting to hold for all of them.
        let set = unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
        debug_assert_eq!(set, 1, "the number is allowed");
    }
}
