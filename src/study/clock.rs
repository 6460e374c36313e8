//! The time that a run takes of the machine: that of its thread.

use rustix::time::{ClockId, clock_gettime};
use std::cmp::Ordering;
use std::time::{Duration, Instant};

/// Measures the computing time of the thread that it is asked on: what the processor spent on it,
/// so that other programs on the machine do not count.
#[derive(Debug)]
pub(super) struct Stopwatch {
    begun: Instant,
    computed: Duration,
}

impl Stopwatch {
    pub(super) fn start() -> Self {
        Self {
            begun: Instant::now(),
            computed: thread_time(),
        }
    }

    /// Since the start.
    pub(super) fn elapsed(&self) -> Duration {
        thread_time().saturating_sub(self.computed)
    }

    /// Since the start, on the wall.
    pub(super) fn wall(&self) -> Duration {
        self.begun.elapsed()
    }
}

fn thread_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    // Neither is negative, and there are fewer than 10⁹ nanoseconds.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// The median of what was measured: a step that was held up by something says nothing of the others.
pub(super) fn median<T: Copy + Default>(
    values: impl IntoIterator<Item = T>,
    order: impl FnMut(&T, &T) -> Ordering,
) -> T {
    let mut values: Vec<T> = values.into_iter().collect();
    values.sort_by(order);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
