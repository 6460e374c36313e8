//! The signals that ask the process to end.

use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGPROF, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU,
    SIGXFSZ,
};
use std::io;
use std::sync::Arc;

/// A signal that asks the process to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct EndingSignal {
    /// Its number.
    pub number: i32,
    /// For people.
    pub name: &'static str,
    /// Whether a second one means: at once. A warning that is repeated does not: the system sends SIGXCPU
    /// every second once the limit is reached.
    pub insists: bool,
}

const fn insisting(number: i32, name: &'static str) -> EndingSignal {
    EndingSignal {
        number,
        name,
        insists: true,
    }
}

const fn warning(number: i32, name: &'static str) -> EndingSignal {
    EndingSignal {
        number,
        name,
        insists: false,
    }
}

/// Those that would end the process by themselves, but for those that tell of a mistake in it. Batch systems
/// warn with SIGUSR1, SIGUSR2 and SIGXCPU before they kill.
const ENDING: &[EndingSignal] = &[
    insisting(SIGINT, "Ctrl-C"),
    insisting(SIGQUIT, "SIGQUIT"),
    insisting(SIGTERM, "SIGTERM"),
    insisting(SIGHUP, "SIGHUP (the terminal is gone)"),
    warning(SIGUSR1, "SIGUSR1"),
    warning(SIGUSR2, "SIGUSR2"),
    warning(SIGXCPU, "SIGXCPU (the limit of processor time)"),
    warning(SIGALRM, "SIGALRM"),
    warning(SIGVTALRM, "SIGVTALRM"),
    warning(SIGPROF, "SIGPROF"),
    #[cfg(any(target_os = "linux", target_os = "android"))]
    warning(libc::SIGPWR, "SIGPWR (the power fails)"),
];

/// The signals to end for: not those that the parent had ignored, as `nohup` has SIGHUP and a shell's script
/// SIGINT for what it starts in the background. To be asked before any is listened to.
pub(crate) fn ending() -> Vec<EndingSignal> {
    let listened = ENDING.iter().filter(|signal| !is_ignored(signal.number));
    listened.copied().collect()
}

/// Has a file that may not grow any more be an error of the write, like a full disk, and no reason to die.
///
/// # Errors
/// The system's.
pub(crate) fn survive_file_size_limit() -> io::Result<()> {
    // The flag itself is of no interest.
    signal_hook::flag::register(SIGXFSZ, Arc::default()).map(|_| ())
}

/// Whether a signal is ignored.
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::uninit();
    // SAFETY: without a new action the call changes nothing, and it writes the present one to where there is
    // room for it.
    unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) == 0
            && action.assume_init().sa_sigaction == libc::SIG_IGN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ignored_is_known() {
        // The standard library has SIGPIPE ignored; nobody ignores SIGWINCH, which does nothing by itself.
        assert!(is_ignored(libc::SIGPIPE));
        assert!(!is_ignored(libc::SIGWINCH));
    }
}
