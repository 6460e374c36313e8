//! The heap of a program that lasts for days: what was freed is given back.

/// Bytes from which on a block is asked of the system by itself, and given back to it: what the library
/// begins with. Not less, for such blocks begin at a page's start, and products of fields that all do are
/// 12 % slower; those of Table 1's mesh have 117 kB each.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: i32 = 128 << 10;

/// Heaps that all threads share. By itself the library makes up to eight for a core, and what one of a
/// run's threads has freed is of no use to another.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const HEAPS: i32 = 2;

/// Has the C library's allocator give back what was freed. By itself it raises the size from which blocks
/// are given back to that of the largest one freed so far, 32 MiB at most. Pictures and fields then lie in the
/// heaps of the threads, among small blocks that last, and though no more is in use than before, the app
/// takes up more and more of the machine's memory. Called once, before there are other threads. Other
/// allocators do without.
pub(super) fn give_back_what_is_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (what, value) in [(libc::M_MMAP_THRESHOLD, LARGE), (libc::M_ARENA_MAX, HEAPS)] {
        // SAFETY: mallopt takes two numbers and is safe to call; that no other thread allocates meanwhile
        // is only for the setting to hold for all of them.
        let set = unsafe { libc::mallopt(what, value) };
        debug_assert_eq!(set, 1, "the value is allowed");
    }
}
