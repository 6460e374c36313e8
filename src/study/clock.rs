//! What a run takes of the machine: time of its thread, and memory.

use std::fs;
use std::time::{Duration, Instant};

/// Measures the computing time of the thread that it is asked on: what the processor spent on it,
/// so that other programs on the machine do not count. Where the system does not tell, the time of
/// the clock on the wall.
#[derive(Debug)]
pub(super) struct Stopwatch {
    begun: Instant,
    computed: Option<Duration>,
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
        match (self.computed, thread_time()) {
            (Some(before), Some(now)) => now.saturating_sub(before),
            _ => self.begun.elapsed(),
        }
    }

    /// Since the start, on the wall.
    pub(super) fn wall(&self) -> Duration {
        self.begun.elapsed()
    }
}

/// Linux tells it in nanoseconds: the first number of the file.
fn thread_time() -> Option<Duration> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = text.split_whitespace().next()?.parse().ok()?;
    Some(Duration::from_nanos(nanoseconds))
}

/// Has the peak of this process's memory counted anew; returns whether the system does that.
pub(super) fn forget_peak_memory() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// The most memory that this process has had since then, in bytes.
pub(super) fn peak_memory() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}
