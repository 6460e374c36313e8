//! What a run takes of the machine: time of its thread, and memory.

use rustix::time::{ClockId, clock_gettime};
use std::fs;
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
