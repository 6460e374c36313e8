//! What the app changes in the terminal, and putting it back: from every thread, through a link that stalls,
//! and when the process is aborted.

use std::io;
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use crossterm::cursor::{Hide, Show};
use crossterm::event::{DisableBracketedPaste, DisableMouseCapture, EnableBracketedPaste};
use crossterm::queue;
use crossterm::style::{Attribute, SetAttribute};
use crossterm::terminal::{
    Clear, ClearType, EndSynchronizedUpdate, EnterAlternateScreen, LeaveAlternateScreen,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::stdio::{stdin, stdout};
use rustix::termios::{
    Action, OptionalActions, QueueSelector, Termios, tcflow, tcflush, tcgetattr, tcsetattr,
};

use super::output::Output;

/// How long a terminal may take to be taken over or put back before the app continues without.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often room is made in a terminal that takes nothing, and how long the writer may take to use it.
const ROUNDS: u32 = 10;
const ROUND: Duration = Duration::from_millis(20);
/// The same, for a process that is being aborted.
const SHORT: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 10_000_000,
};

/// The terminal as it was before the app took it over; null while it is as it was. It belongs to the process,
/// as the terminal does. What was put here is never freed: an abort may be reading it.
static BEFORE: AtomicPtr<Before> = AtomicPtr::new(ptr::null_mut());

#[derive(Debug)]
struct Before {
    modes: Termios,
    /// What is written to put it back.
    bytes: Vec<u8>,
}

impl Before {
    fn modes_back(&self) {
        // A terminal that is gone needs nothing back.
        let _ = tcsetattr(stdin(), OptionalActions::Now, &self.modes);
    }
}

/// What is changed in the terminal (raw mode, alternate screen, cursor, bracketed paste), and the way to put
/// it back from anywhere.
#[derive(Debug)]
pub(super) struct Modes {
    pub output: Output,
    /// The answer of the writer to what puts the terminal back, until somebody has waited for it.
    restoring: Mutex<Option<Receiver<io::Result<()>>>>,
}

impl Modes {
    /// Of a terminal that is not taken over yet.
    pub fn new(output: Output) -> Self {
        put_back_at_aborts();
        Self {
            output,
            restoring: Mutex::new(None),
        }
    }

    /// Whether the app has the terminal, and not an editor or a shell.
    pub fn are_changed(&self) -> bool {
        !BEFORE.load(Ordering::Acquire).is_null()
    }

    /// Takes the terminal over, if it is not.
    ///
    /// # Errors
    /// What the system says; the terminal is then as it was.
    pub fn enter(&self) -> io::Result<()> {
        if self.are_changed() {
            return Ok(());
        }
        let modes = tcgetattr(stdin())?;
        // A frame may have been cut off in its middle.
        let bytes = sequence(|bytes| {
            queue!(
                bytes,
                EndSynchronizedUpdate,
                SetAttribute(Attribute::Reset),
                DisableBracketedPaste,
                LeaveAlternateScreen,
                Show
            )
        });
        BEFORE.store(
            Box::into_raw(Box::new(Before { modes, bytes })),
            Ordering::Release,
        );
        let entered = self.make_raw().and_then(|()| {
            let bytes = sequence(|bytes| {
                queue!(
                    bytes,
                    EnterAlternateScreen,
                    DisableMouseCapture,
                    EnableBracketedPaste,
                    Hide,
                    Clear(ClearType::All)
                )
            });
            self.output.write_within(&bytes, PATIENCE)
        });
        if entered.is_err() {
            self.restore();
        }
        entered
    }

    /// Has every key reach the app at once and unchanged. Also where somebody else has changed that.
    ///
    /// # Errors
    /// What the system says.
    pub fn make_raw(&self) -> io::Result<()> {
        // SAFETY: what was put there is never freed or changed.
        let before = unsafe { BEFORE.load(Ordering::Acquire).as_ref() };
        if let Some(before) = before {
            let mut modes = before.modes.clone();
            modes.make_raw();
            tcsetattr(stdin(), OptionalActions::Now, &modes)?;
        }
        Ok(())
    }

    /// Begins to put everything back, if that has not begun yet.
    pub fn begin_to_restore(&self) {
        let Some(before) = take_before() else {
            return;
        };
        before.modes_back();
        match self.output.begin(&before.bytes) {
            Ok(written) => *self.restoring() = Some(written),
            // The writer itself has gone, by a mistake of its own.
            Err(_) => drop(rustix::io::write(stdout(), &before.bytes)),
        }
    }

    /// Waits until the terminal has taken what puts it back. Where it has taken nothing by `until`, what it has
    /// not read of the app's screen is thrown away, to make room.
    pub fn settle(&self, until: Instant) {
        let Some(written) = self.restoring().take() else {
            return;
        };
        let wait = |limit| {
            let answer = written.recv_timeout(limit);
            matches!(answer, Err(RecvTimeoutError::Timeout))
        };
        let mut is_stalled = wait(until.saturating_duration_since(Instant::now()));
        for _ in 0..ROUNDS {
            if !is_stalled {
                break;
            }
            // Where there is room the writer is about to use it.
            if !has_room() {
                make_room();
            }
            is_stalled = wait(ROUND);
        }
    }

    /// Puts everything back, if it was not yet.
    pub fn restore(&self) {
        self.begin_to_restore();
        self.settle(Instant::now() + PATIENCE);
    }

    fn restoring(&self) -> std::sync::MutexGuard<'_, Option<Receiver<io::Result<()>>>> {
        self.restoring
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// What must be put back; from then on nobody else does it.
fn take_before() -> Option<&'static Before> {
    // SAFETY: what was put there is never freed or changed.
    unsafe { BEFORE.swap(ptr::null_mut(), Ordering::AcqRel).as_ref() }
}

/// Whether the terminal takes some bytes at once.
fn has_room() -> bool {
    let terminal = stdout();
    let mut ready = [PollFd::new(&terminal, PollFlags::OUT)];
    let now = Timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    matches!(poll(&mut ready, Some(&now)), Ok(1))
}

/// Throws away what the terminal has not read yet. Allocates nothing.
fn make_room() {
    let _ = tcflush(stdout(), QueueSelector::OFlush);
    // A write that waits for room learns of it only so.
    let _ = tcflow(stdout(), Action::OOff);
    let _ = tcflow(stdout(), Action::OOn);
}

/// The bytes of commands.
pub(super) fn sequence(commands: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail.
    let _ = commands(&mut bytes);
    bytes
}

/// The signals of a process that cannot continue: memory that is refused, a stack that is full, a mistake.
const ABORTS: [i32; 7] = [
    libc::SIGABRT,
    libc::SIGSEGV,
    libc::SIGBUS,
    libc::SIGILL,
    libc::SIGFPE,
    libc::SIGSYS,
    libc::SIGTRAP,
];

/// What was done at them before.
static HANDLERS: OnceLock<[Option<libc::sigaction>; ABORTS.len()]> = OnceLock::new();

/// The library's own words for memory that is refused are lost with the app's screen.
const ABORTED: &[u8] =
    b"vesica was aborted: memory was refused, or the program has a mistake. What was kept of \
                         its runs is offered at the next start.\n";

/// Has the terminal be put back where the process is aborted, once and for all.
fn put_back_at_aborts() {
    HANDLERS.get_or_init(|| {
        ABORTS.map(|signal| {
            // SAFETY: a `sigaction` may be all zeros, and the handler does only what one may do.
            unsafe {
                let mut action: libc::sigaction = std::mem::zeroed();
                let handler: extern "C" fn(i32, *const libc::siginfo_t, *const libc::c_void) =
                    aborted;
                action.sa_sigaction = handler as libc::sighandler_t;
                // A stack that is full has no room for it.
                action.sa_flags = libc::SA_ONSTACK | libc::SA_SIGINFO;
                let mut before = std::mem::zeroed();
                (libc::sigaction(signal, &raw const action, &raw mut before) == 0).then_some(before)
            }
        })
    });
}

/// Puts the terminal back, and has done what would have been done otherwise. It may take no lock and no
/// memory.
extern "C" fn aborted(signal: i32, info: *const libc::siginfo_t, _context: *const libc::c_void) {
    if let Some(before) = take_before() {
        before.modes_back();
        // SAFETY: plain system calls. The link must not hold up the end.
        unsafe {
            let flags = libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFL);
            libc::fcntl(libc::STDOUT_FILENO, libc::F_SETFL, flags | libc::O_NONBLOCK);
            for _ in 0..ROUNDS {
                // While the writer is at it nobody else can be.
                make_room();
                match rustix::io::write(stdout(), &before.bytes) {
                    Err(Errno::AGAIN | Errno::INTR) => drop(poll(&mut [], Some(&SHORT))),
                    _ => break,
                }
            }
            if signal == libc::SIGABRT {
                let _ = rustix::io::write(rustix::stdio::stderr(), ABORTED);
            }
            libc::fcntl(libc::STDOUT_FILENO, libc::F_SETFL, flags);
        }
    }
    // The handler before takes a fault for one that comes again when it returns. One that was sent does not.
    // SAFETY: the system gives the information.
    let is_sent = unsafe { info.as_ref() }.is_some_and(|info| info.si_code <= 0);
    let place = ABORTS.iter().position(|abort| *abort == signal);
    let before = place.and_then(|place| HANDLERS.get()?.get(place)?.as_ref());
    // SAFETY: plain system calls; the action is one that the system gave.
    unsafe {
        match before.filter(|_| !is_sent) {
            Some(action) => {
                libc::sigaction(signal, action, ptr::null_mut());
            }
            None => {
                libc::signal(signal, libc::SIG_DFL);
            }
        }
        // Delivered when this function returns.
        libc::raise(signal);
    }
}
