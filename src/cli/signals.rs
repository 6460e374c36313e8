//! Signals that end a run cleanly.

use super::error::CliError;
use crate::signals::{EndingSignal, ending, survive_file_size_limit};
use signal_hook::consts::SIGTERM;
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Remembers that a signal came, for a loop to look at. A second one of a person or of a system that shuts
/// down ends the process at once.
#[derive(Debug, Clone)]
pub(super) struct EndSignal {
    /// Those that are listened to.
    signals: Vec<EndingSignal>,
    /// The number of the signal that came, or 0.
    received: Arc<AtomicUsize>,
}

impl EndSignal {
    /// Listens for Ctrl-C, SIGTERM and what else asks the process to end, but not for what the parent had
    /// ignored, such as SIGHUP under `nohup`: such a run is to outlive its terminal.
    ///
    /// # Errors
    /// [`CliError::Signals`].
    pub fn listen() -> Result<EndSignal, CliError> {
        Self::listen_to(ending())
    }

    /// The same in a batch job, where a second SIGTERM is no reason to hurry: the system sends it to the job's
    /// script and to its programs, and the script passes it on.
    ///
    /// # Errors
    /// [`CliError::Signals`].
    pub fn listen_in_batch() -> Result<EndSignal, CliError> {
        let mut signals = ending();
        for signal in &mut signals {
            signal.insists &= signal.number != SIGTERM;
        }
        Self::listen_to(signals)
    }

    fn listen_to(signals: Vec<EndingSignal>) -> Result<EndSignal, CliError> {
        let received = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        for &EndingSignal {
            number, insists, ..
        } in &signals
        {
            if insists {
                // In this order: the first signal finds `again` false, and sets it.
                flag::register_conditional_shutdown(number, 128 + number, Arc::clone(&again))
                    .and_then(|_| flag::register(number, Arc::clone(&again)))
                    .map_err(CliError::Signals)?;
            }
            flag::register_usize(number, Arc::clone(&received), number as usize)
                .map_err(CliError::Signals)?;
        }
        survive_file_size_limit().map_err(CliError::Signals)?;
        Ok(EndSignal { signals, received })
    }

    /// The signal that came, if one came.
    pub fn received(&self) -> Option<EndingSignal> {
        let received = self.received.load(Ordering::Relaxed);
        let mut signals = self.signals.iter();
        signals
            .find(|signal| signal.number as usize == received)
            .copied()
    }
}
