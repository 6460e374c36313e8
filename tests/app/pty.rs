//! A program in a terminal: what it writes is seen as a screen and counted in bytes.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, native_pty_system};
use std::fs;
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How long anything may take before a test gives up: generous, for a busy machine.
pub const LIMIT: Duration = Duration::from_secs(60);

/// Begins and ends of frames, and of the alternate screen.
pub const FRAME: &[u8] = b"\x1b[?2026h";
pub const ENTER: &[u8] = b"\x1b[?1049h";
pub const LEAVE: &[u8] = b"\x1b[?1049l";

/// What a program has written so far.
pub struct Seen {
    pub terminal: vt100::Parser,
    /// All bytes, but for those that were forgotten.
    pub bytes: Vec<u8>,
    /// How many bytes, forgotten ones too.
    pub count: usize,
    hold: bool,
    stop: bool,
    ended: bool,
}

impl Seen {
    pub fn text(&self) -> String {
        self.terminal.screen().contents()
    }

    pub fn shows(&self, text: &str) -> bool {
        self.text().contains(text)
    }

    pub fn times(&self, sequence: &[u8]) -> usize {
        occurrences(&self.bytes, sequence)
    }
}

pub fn occurrences(bytes: &[u8], sequence: &[u8]) -> usize {
    bytes
        .windows(sequence.len())
        .filter(|window| *window == sequence)
        .count()
}

/// A program in a terminal of its own.
pub struct Pty {
    master: Option<Box<dyn MasterPty + Send>>,
    keys: Option<Box<dyn Write + Send>>,
    pub child: Box<dyn Child + Send + Sync>,
    shared: Arc<(Mutex<Seen>, Condvar)>,
    reader: Option<JoinHandle<()>>,
    /// The terminal's modes before the program began.
    modes: String,
}

impl Pty {
    /// Starts a program in a terminal of so many columns and rows.
    pub fn start(
        (columns, rows): (u16, u16),
        folder: &Path,
        program: &[&str],
        variables: &[(&str, &str)],
    ) -> Self {
        let pair = native_pty_system()
            .openpty(size(columns, rows))
            .expect("a pseudo-terminal");
        let mut command = CommandBuilder::new(program[0]);
        command.args(&program[1..]);
        command.cwd(folder);
        for name in [
            "NO_COLOR",
            "COLORTERM",
            "LC_ALL",
            "LC_CTYPE",
            "VISUAL",
            "EDITOR",
        ] {
            command.env_remove(name);
        }
        command.env("TERM", "xterm-256color");
        command.env("LANG", "C.UTF-8");
        for (name, value) in variables {
            command.env(name, value);
        }
        let modes = modes(pair.master.as_ref());
        let child = pair
            .slave
            .spawn_command(command)
            .expect("the program starts");
        drop(pair.slave);
        let seen = Seen {
            terminal: vt100::Parser::new(nonzero(rows), nonzero(columns), 1000),
            bytes: Vec::new(),
            count: 0,
            hold: false,
            stop: false,
            ended: false,
        };
        let shared = Arc::new((Mutex::new(seen), Condvar::new()));
        let reader = pair.master.try_clone_reader().expect("a reader");
        let keys = pair.master.take_writer().expect("a writer");
        let reader = thread::spawn({
            let shared = Arc::clone(&shared);
            move || read(reader, &shared)
        });
        Self {
            master: Some(pair.master),
            keys: Some(keys),
            child,
            shared,
            reader: Some(reader),
            modes,
        }
    }

    pub fn seen(&self) -> MutexGuard<'_, Seen> {
        self.shared
            .0
            .lock()
            .expect("no test has panicked meanwhile")
    }

    /// Waits until what is seen is as it should be.
    #[track_caller]
    pub fn wait(&self, what: &str, as_it_should_be: impl Fn(&Seen) -> bool) {
        assert!(
            self.wait_for(LIMIT, as_it_should_be),
            "waited in vain for {what}; the screen:\n{}",
            self.seen().text()
        );
    }

    /// Waits for so long at most; whether it came.
    pub fn wait_for(&self, limit: Duration, as_it_should_be: impl Fn(&Seen) -> bool) -> bool {
        let begun = Instant::now();
        let mut seen = self.seen();
        while !as_it_should_be(&seen) {
            let left = limit.saturating_sub(begun.elapsed());
            if left.is_zero() || seen.ended {
                return false;
            }
            let waited = self.shared.1.wait_timeout(seen, left);
            seen = waited.expect("no test has panicked meanwhile").0;
        }
        true
    }

    #[track_caller]
    pub fn wait_text(&self, text: &str) {
        self.wait(text, |seen| seen.shows(text));
    }

    /// Waits until nothing is written for a while.
    #[track_caller]
    pub fn wait_quiet(&self) {
        let begun = Instant::now();
        loop {
            let count = self.seen().count;
            if !self.wait_for(Duration::from_millis(400), |seen| seen.count != count) {
                return;
            }
            assert!(begun.elapsed() < LIMIT, "it never stops writing");
        }
    }

    pub fn type_keys(&mut self, keys: &str) {
        let writer = self.keys.as_mut().expect("the terminal is there");
        writer.write_all(keys.as_bytes()).expect("keys are taken");
        writer.flush().expect("keys are taken");
    }

    pub fn resize(&self, columns: u16, rows: u16) {
        self.seen()
            .terminal
            .screen_mut()
            .set_size(nonzero(rows), nonzero(columns));
        self.claim_size(columns, rows);
    }

    /// The terminal says that it has this size.
    pub fn claim_size(&self, columns: u16, rows: u16) {
        let master = self.master.as_ref().expect("the terminal is there");
        master.resize(size(columns, rows)).expect("another size");
    }

    /// Whether the link stands still: nothing that the program writes is read.
    pub fn hold(&self, hold: bool) {
        self.seen().hold = hold;
        self.shared.1.notify_all();
    }

    pub fn forget_bytes(&self) {
        self.seen().bytes.clear();
    }

    pub fn pid(&self) -> u32 {
        self.child.process_id().expect("a process")
    }

    pub fn signal(&self, signal: Signal) {
        send(self.pid(), signal);
    }

    /// Takes the terminal away, as when a window is closed.
    pub fn hang_up(&mut self) {
        self.read_no_more();
        self.keys = None;
        self.master = None;
    }

    /// The terminal goes away while the program stands still; the system continues it then.
    pub fn hang_up_stopped(&mut self) {
        self.read_no_more();
        self.signal(Signal::SIGSTOP);
        self.keys = None;
        self.master = None;
    }

    fn read_no_more(&mut self) {
        self.seen().stop = true;
        // So that the reader's read returns and it lets go.
        self.resize(101, 35);
        if let Some(reader) = self.reader.take() {
            reader.join().expect("the reader does not panic");
        }
    }

    /// The exit status, once the program has ended.
    #[track_caller]
    pub fn exit_status(&mut self, limit: Duration) -> u32 {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status.exit_code();
            }
            assert!(begun.elapsed() < limit, "it has not ended after {limit:?}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// The program has ended with this status and left the terminal as it was before.
    #[track_caller]
    pub fn assert_restored(&mut self, status: u32) {
        assert_eq!(self.exit_status(LIMIT), status, "{}", self.seen().text());
        if let Some(reader) = self.reader.take() {
            reader.join().expect("the reader does not panic");
        }
        let seen = self.seen();
        if seen.bytes.len() == seen.count {
            assert_eq!(seen.times(ENTER), seen.times(LEAVE), "as often as entered");
        }
        let screen = seen.terminal.screen();
        assert!(!screen.alternate_screen(), "the first screen is back");
        assert!(!screen.hide_cursor(), "the cursor is shown");
        assert!(!screen.bracketed_paste(), "pasting is as before");
        let master = self.master.as_ref().expect("the terminal is there");
        assert_eq!(
            modes(master.as_ref()),
            self.modes,
            "the modes are as before"
        );
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // A test that fails leaves no program behind.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if let Ok(mut seen) = self.shared.0.lock() {
            seen.stop = true;
            seen.hold = false;
        }
        self.shared.1.notify_all();
    }
}

/// The child of a process that has this name.
pub fn child_named(parent: u32, name: &str) -> Option<u32> {
    let parent = parent.to_string();
    let processes = fs::read_dir("/proc").expect("the process table");
    processes.flatten().find_map(|process| {
        let stat = fs::read_to_string(process.path().join("stat")).ok()?;
        let (before, after) = stat.rsplit_once(')')?;
        let (pid, command) = before.split_once(" (")?;
        let is_it = command == name && after.split_whitespace().nth(1)? == parent;
        is_it.then(|| pid.parse().ok())?
    })
}

/// Sends a signal.
pub fn send(pid: u32, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(pid).expect("a process"));
    kill(pid, signal).expect("the process is there");
}

/// The processor time of those threads of a process whose names begin so.
pub fn computed(pid: u32, name: &str) -> Duration {
    let read = |task: PathBuf| fs::read_to_string(task.join("schedstat")).ok();
    let nanoseconds = threads(pid, name)
        .into_iter()
        .filter_map(read)
        .filter_map(|text| text.split_whitespace().next()?.parse::<u64>().ok())
        .sum();
    Duration::from_nanos(nanoseconds)
}

/// The folders in `/proc` of those threads of a process whose names begin so.
pub fn threads(pid: u32, name: &str) -> Vec<PathBuf> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task"))
        .into_iter()
        .flatten();
    let is_named = |task: &PathBuf| {
        fs::read_to_string(task.join("comm")).is_ok_and(|comm| comm.starts_with(name))
    };
    tasks
        .flatten()
        .map(|task| task.path())
        .filter(is_named)
        .collect()
}

/// The memory that a process has, in bytes.
pub fn resident(pid: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).expect("the process is there");
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB"));
    let kilobytes: u64 = kilobytes
        .and_then(|text| text.parse().ok())
        .expect("its memory");
    kilobytes << 10
}

fn read(mut reader: Box<dyn Read + Send>, (seen, changed): &(Mutex<Seen>, Condvar)) {
    let mut bytes = [0; 1 << 16];
    loop {
        let count = reader.read(&mut bytes).unwrap_or(0);
        let Ok(mut seen) = seen.lock() else { return };
        seen.bytes.extend_from_slice(&bytes[..count]);
        seen.count += count;
        seen.terminal.process(&bytes[..count]);
        seen.ended = count == 0;
        changed.notify_all();
        while seen.hold && !seen.stop {
            let Ok(woken) = changed.wait(seen) else {
                return;
            };
            seen = woken;
        }
        if seen.stop || seen.ended {
            return;
        }
    }
}

fn modes(master: &(dyn MasterPty + Send)) -> String {
    let modes = master.get_termios().expect("modes");
    format!(
        "{:?} {:?} {:?} {:?}",
        modes.input_flags, modes.output_flags, modes.control_flags, modes.local_flags
    )
}

fn size(cols: u16, rows: u16) -> PtySize {
    PtySize {
        rows,
        cols,
        pixel_width: 0,
        pixel_height: 0,
    }
}

fn nonzero(number: u16) -> NonZeroU16 {
    NonZeroU16::new(number).expect("a size")
}
