//! Signals and the terminal's hang-up, waited for by a thread of its own.
//!
//! A terminal that goes away sends SIGHUP, but not to everybody: it may be blocked, and an input
//! thread may be busy. So the thread also polls the terminal for nothing but its hang-up, which
//! costs nothing while it is there.

use std::io;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use signal_hook::consts::{SIGCONT, SIGHUP, SIGINT, SIGQUIT, SIGTSTP, SIGWINCH};
use signal_hook::iterator::backend::{Handle, SignalDelivery};
use signal_hook::iterator::exfiltrator::SignalOnly;

use super::event::{AppEvent, spawn};
use super::message::Message;
use super::modes::Modes;
use crate::signals::{ending, survive_file_size_limit};

/// Those that concern the terminal alone.
const OF_TERMINAL: [i32; 3] = [SIGTSTP, SIGCONT, SIGWINCH];

/// How long the app may take to end by itself once a signal asked for it.
const PATIENCE: Duration = Duration::from_millis(1600);
/// How long the terminal may take to be put back after that.
const LAST_PATIENCE: Duration = Duration::from_millis(100);

/// The watching thread. Dropping it ends it.
#[derive(Debug)]
pub(super) struct Watch {
    handle: Handle,
}

impl Watch {
    /// Starts to watch. Where the app does not end in time after the terminal has gone or a signal
    /// that nobody types has come, the thread ends the process, with the terminal restored by `modes`.
    ///
    /// # Errors
    /// The system gives no handler, socket or thread.
    pub fn start(incoming: Sender<AppEvent>, modes: Arc<Modes>) -> io::Result<Self> {
        let (read, write) = UnixStream::pair()?;
        let ending = ending().into_iter().map(|signal| signal.number);
        let watched: Vec<i32> = ending.chain(OF_TERMINAL).collect();
        let mut signals = SignalDelivery::with_pipe(read, write, SignalOnly, watched)?;
        survive_file_size_limit()?;
        let handle = signals.handle();
        let sink = incoming.clone();
        spawn("signals", incoming, move || {
            if let Some(signal) = watch(&mut signals, &sink) {
                modes.begin_to_restore();
                modes.settle(Instant::now() + LAST_PATIENCE);
                std::process::exit(128 + signal);
            }
        })?;
        Ok(Self { handle })
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.handle.close();
    }
}

/// Watches until it is closed, or until the app should have ended: by which signal.
fn watch(
    signals: &mut SignalDelivery<UnixStream, SignalOnly>,
    sink: &Sender<AppEvent>,
) -> Option<i32> {
    let terminal = rustix::stdio::stdin();
    // Until when the app should end, and by which signal.
    let mut doom: Option<(Instant, i32)> = None;
    let mut is_there = true;
    loop {
        let wait = match doom {
            None => None,
            Some((until, signal)) => match until.checked_duration_since(Instant::now()) {
                None => return Some(signal),
                // A duration of seconds fits.
                Some(left) => Timespec::try_from(left).ok(),
            },
        };
        let hung_up = {
            let mut ready = [
                PollFd::new(signals.get_read(), PollFlags::IN),
                PollFd::new(&terminal, PollFlags::empty()),
            ];
            // A terminal that has gone is always ready.
            let count = if is_there { 2 } else { 1 };
            match poll(&mut ready[..count], wait.as_ref()) {
                Ok(_) => ready[1].revents(),
                Err(Errno::INTR) => continue,
                Err(_) => PollFlags::HUP,
            }
            .intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL)
        };
        for signal in signals.pending() {
            let incoming = match signal {
                SIGWINCH => AppEvent::SizeChanged,
                SIGTSTP => AppEvent::Stop,
                SIGCONT => AppEvent::Continued,
                _ => AppEvent::Message(Message::Signal(signal)),
            };
            // If the loop has ended, so will the process.
            let _ = sink.send(incoming);
            let is_typed = matches!(signal, SIGINT | SIGQUIT);
            if !is_typed && !OF_TERMINAL.contains(&signal) {
                doom.get_or_insert((Instant::now() + PATIENCE, signal));
            }
        }
        if signals.handle().is_closed() {
            return None;
        }
        if is_there && hung_up {
            is_there = false;
            let _ = sink.send(AppEvent::Message(Message::HungUp));
            doom.get_or_insert((Instant::now() + PATIENCE, SIGHUP));
        }
    }
}
