//! Signals that end a run cleanly.

use super::error::CliError;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

const SIGNALS: [(i32, &str); 3] = [
    (SIGINT, "Ctrl-C"),
    (SIGTERM, "SIGTERM"),
    (SIGHUP, "SIGHUP (the terminal is gone)"),
];

/// A signal that asked the process to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Signal {
    /// For people.
    pub name: &'static str,
    /// For the exit status.
    pub number: i32,
}

/// Remembers that a signal came, for a loop to look at. A second signal ends the process at once.
#[derive(Debug)]
pub(super) struct EndSignal {
    /// The number of the signal that came, or 0.
    received: Arc<AtomicUsize>,
}

impl EndSignal {
    /// Listens for Ctrl-C, SIGTERM and SIGHUP; not for SIGHUP where it is ignored, as under
    /// `nohup`: such a run is to outlive its terminal.
    ///
    /// # Errors
    /// [`CliError::Signals`].
    pub fn listen() -> Result<EndSignal, CliError> {
        let received = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        for (number, _) in SIGNALS {
            if number == SIGHUP && is_ignored(number) {
                continue;
            }
            // In this order: the first signal finds `again` false, and sets it.
            flag::register_conditional_shutdown(number, 128 + number, Arc::clone(&again))
                .and_then(|_| flag::register(number, Arc::clone(&again)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&received), number as usize))
                .map_err(CliError::Signals)?;
        }
        // A file that may not grow any more is an error of the write, like a full disk, and no reason to
        // die: the flag itself is of no interest.
        flag::register(SIGXFSZ, Arc::default()).map_err(CliError::Signals)?;
        Ok(EndSignal { received })
    }

    /// The signal that came, if one came.
    pub fn received(&self) -> Option<Signal> {
        let received = self.received.load(Ordering::Relaxed);
        SIGNALS
            .into_iter()
            .find(|&(number, _)| number as usize == received)
            .map(|(number, name)| Signal { name, number })
    }
}

/// Whether the process was started with this signal ignored. Known on Linux only; elsewhere no
/// signal counts as ignored.
fn is_ignored(signal: i32) -> bool {
    std::fs::read_to_string("/proc/self/status")
        .is_ok_and(|status| ignored_in(&status) >> (signal - 1) & 1 == 1)
}

/// The set of ignored signals, a bit each, in the text of /proc/self/status.
fn ignored_in(status: &str) -> u64 {
    status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ignored_signals_are_read_from_the_status() {
        let status = "Name:\tvesica\nSigBlk:\t0000000000000003\nSigIgn:\t0000000000001001\n";
        assert_eq!(ignored_in(status), 0x1001);
        assert_eq!(ignored_in("Name:\tvesica\n"), 0);
        assert_eq!(ignored_in("SigIgn:\tnonsense\n"), 0);
    }
}
