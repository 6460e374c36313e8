//! The heap of a program that lasts for days: what was freed is given back.

/// Bytes from which on a block is asked of the system by itself, and given back to it: what the library
/// begins with. Not less, for such blocks begin at a page's start, and products of fields that all do are
/// 12 % slower; those of Table 1's mesh have 117 kB each.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: i32 = 128 << 10;

/// Makes the C library's allocator always give large blocks back to the system when they are freed. By
/// itself it raises the size from which it does to that of the largest block freed so far, 32 MiB at
/// most. Pictures and fields then lie in the heaps of the threads, among small blocks that last, and though
/// no more is in use than before, the app takes more and more of the machine's memory. Called once,
/// before there are other threads. Other allocators do without.
pub(super) fn give_back_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: mallopt takes two numbers and is safe to call; that no other thread allocates meanwhile
        // is only for the setting to hold for all of them.
        let set = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE) };
        debug_assert_eq!(set, 1, "the size is allowed");
    }
}
