//! The memory that a thread holds, counted by the allocator of the program.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Bytes taken and not given back by this thread. Constant at the start and without a destructor,
    /// so that the allocator may use it at any time.
    static HELD: Cell<i64> = const { Cell::new(0) };
    /// The most of them since [`forget_most`].
    static MOST: Cell<i64> = const { Cell::new(0) };
}

/// The system's allocator, which counts the bytes that each thread holds. A program that declares it as
/// its global allocator lets a study tell what a run or an effect takes; without it the study has no such column.
/// A step allocates nothing, so counting costs it nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct CountingAllocator;

fn add(bytes: usize) {
    let now = held() + bytes as i64;
    HELD.with(|held| held.set(now));
    MOST.with(|most| most.set(most.get().max(now)));
}

fn subtract(bytes: usize) {
    HELD.with(|held| held.set(held.get() - bytes as i64));
}

// SAFETY: every call is handed to the system's allocator as it came.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size);
        subtract(layout.size());
        // SAFETY: as above.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        subtract(layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Bytes that this thread holds, counted from an arbitrary origin; always the same where the program's
/// allocator is another one.
pub(crate) fn held() -> i64 {
    HELD.with(Cell::get)
}

/// Has the most that this thread holds counted again from what it holds now, which is returned.
pub(crate) fn forget_most() -> i64 {
    let now = held();
    MOST.with(|most| most.set(now));
    now
}

/// The most bytes that this thread has held since then, counted as [`held`] counts.
pub(crate) fn most() -> i64 {
    MOST.with(Cell::get)
}
