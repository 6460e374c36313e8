//! The terminal's life cycle, and frames for it.
//!
//! [`Terminal`] is a guard: what it changes (raw mode, alternate screen, cursor, bracketed paste) is
//! put back exactly once, however the app ends. A panic of the thread that owns the guard puts it
//! back before the panic's words are printed; a panic of any other thread leaves the screen as it
//! is, for the app lives on and shows it.

use std::fs::File;
use std::io;
use std::panic::{self, PanicHookInfo};
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::thread;
use std::time::Duration;

use crossterm::cursor::Hide;
use crossterm::event::EnableBracketedPaste;
use crossterm::queue;
use crossterm::terminal::{Clear, ClearType};
use ratatui::Frame;

use super::event::AppEvent;
use super::modes::{Modes, sequence};
use super::output::{FRAME_BYTES, Output};
use super::surface::{Bytes, Surface, Synchronized};

/// How long the last line may take. There is room for it, unless the terminal is gone.
const LAST_WORDS: Duration = Duration::from_millis(100);
/// The size of a terminal that does not report one.
const USUAL_SIZE: (u16, u16) = (80, 24);
/// The most columns and rows that are drawn on: more than the largest screens have in the smallest letters.
/// What some programs claim, 65535 of each, would take more memory than there is.
const MOST: (u16, u16) = (1600, 600);

/// The terminal as the app uses it.
pub(super) struct Terminal {
    modes: Arc<Modes>,
    frames: ratatui::Terminal<Surface>,
    bytes: Bytes,
    /// The buffer of the next frame; away while the last one is being written.
    buffer: Option<Vec<u8>>,
    /// What is written with the next frame.
    unsent: Vec<u8>,
    hook: Arc<Hook>,
}

type Hook = dyn Fn(&PanicHookInfo<'_>) + Send + Sync;

impl Terminal {
    /// Takes over the terminal that the standard input and output are.
    ///
    /// # Errors
    /// What the system says; the terminal is then as it was.
    pub fn open(incoming: Sender<AppEvent>) -> io::Result<Self> {
        // FrameHistory the standard library's buffer, which ends at every line.
        let file = File::from(rustix::stdio::stdout().try_clone_to_owned()?);
        let modes = Arc::new(Modes::new(Output::start(file, incoming)?));
        let bytes = Bytes::default();
        let frames = ratatui::Terminal::new(Surface::new(bytes.clone(), size()))?;
        let hook = guard_panics(Arc::clone(&modes));
        let terminal = Self {
            modes,
            frames,
            bytes,
            buffer: Some(Vec::with_capacity(FRAME_BYTES)),
            unsent: Vec::new(),
            hook,
        };
        terminal.modes.enter()?;
        Ok(terminal)
    }

    /// Leaves a line in the scrollback, once the terminal was given away. A link that takes nothing
    /// is not waited for.
    pub fn leave_behind(&self, line: &str) {
        if !self.is_ours() {
            // Nobody is there to report this failure to.
            let line = format!("{line}\n");
            let _ = self.modes.output.write_within(line.as_bytes(), LAST_WORDS);
        }
    }

    /// The way to put the terminal back from another thread.
    pub fn modes(&self) -> Arc<Modes> {
        Arc::clone(&self.modes)
    }

    /// Whether the app has the terminal, and not an editor or a shell.
    pub fn is_ours(&self) -> bool {
        self.modes.are_changed()
    }

    /// Whether a frame can be drawn: the one before is out.
    pub fn is_free(&self) -> bool {
        self.buffer.is_some() && self.is_ours()
    }

    /// The buffer of a frame is back from the writer.
    pub fn written(&mut self, buffer: Vec<u8>) {
        self.buffer = Some(buffer);
    }

    /// Draws a frame of a size, if the terminal is free. Where nothing has changed, nothing is
    /// written.
    pub fn draw(&mut self, size: (u16, u16), render: impl FnOnce(&mut Frame<'_>)) {
        if !self.is_ours() {
            return;
        }
        let Some(buffer) = self.buffer.take() else {
            return;
        };
        self.bytes.begin(buffer);
        {
            let _synchronized = Synchronized::begin(&self.bytes);
            self.bytes.push(&std::mem::take(&mut self.unsent));
            self.frames.backend_mut().set_size(size);
            // Drawing into memory cannot fail.
            let _ = self.frames.draw(render);
        }
        let frame = self.bytes.end();
        if frame.is_empty() {
            self.buffer = Some(frame);
        } else {
            self.modes.output.send(frame);
        }
    }

    /// Puts a text into the terminal's clipboard with the next frame (OSC 52).
    pub fn copy(&mut self, text: &str) {
        use base64::Engine;
        let encoded = base64::engine::general_purpose::STANDARD.encode(text);
        self.unsent
            .extend_from_slice(format!("\x1b]52;c;{encoded}\x07").as_bytes());
    }

    /// Gives the terminal away, as it was before.
    pub fn give_away(&self) {
        self.modes.restore();
    }

    /// Takes the terminal back; the next frame fills it again.
    ///
    /// # Errors
    /// What the system says.
    pub fn take_back(&mut self) -> io::Result<()> {
        if self.is_ours() {
            // The process was stopped by force, and somebody else may have used the terminal.
            self.modes.make_raw()?;
            let bytes = sequence(|bytes| queue!(bytes, EnableBracketedPaste, Hide));
            self.unsent.extend_from_slice(&bytes);
        } else {
            self.modes.enter()?;
        }
        // The next frame begins with an empty screen and is drawn whole.
        self.unsent
            .extend_from_slice(&sequence(|bytes| queue!(bytes, Clear(ClearType::All))));
        let size = self.frames.size()?;
        self.frames =
            ratatui::Terminal::new(Surface::new(self.bytes.clone(), (size.width, size.height)))?;
        Ok(())
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.modes.restore();
        if !thread::panicking() {
            let hook = Arc::clone(&self.hook);
            panic::set_hook(Box::new(move |info| hook(info)));
        }
    }
}

/// Columns and rows of the terminal.
pub(super) fn size() -> (u16, u16) {
    match rustix::termios::tcgetwinsize(rustix::stdio::stdout()) {
        Ok(size) if size.ws_col > 0 && size.ws_row > 0 => bounded((size.ws_col, size.ws_row)),
        _ => USUAL_SIZE,
    }
}

fn bounded((columns, rows): (u16, u16)) -> (u16, u16) {
    (columns.min(MOST.0), rows.min(MOST.1))
}

/// From here on a panic of the current thread restores the terminal before it speaks, and a panic
/// of another one, which its own thread must catch and report, is silent. Returns the hook before.
fn guard_panics(modes: Arc<Modes>) -> Arc<Hook> {
    let owner = thread::current().id();
    let before: Arc<Hook> = Arc::from(panic::take_hook());
    let hook = Arc::clone(&before);
    panic::set_hook(Box::new(move |info| {
        if thread::current().id() == owner {
            modes.restore();
            before(info);
        } else if !modes.are_changed() {
            before(info);
        }
    }));
    hook
}

#[cfg(test)]
mod tests {
    use super::*;
    use portable_pty::{CommandBuilder, ExitStatus, PtySize, native_pty_system};
    use rustix::termios::LocalModes;
    use std::io::Read;
    use std::sync::mpsc;

    /// Set for the process in which the terminal is used.
    const INSIDE: &str = "VESICA_TEST_INSIDE_TERMINAL";

    /// What a test writes that runs in a terminal of its own: the test binary is started again in
    /// one, to run that test alone.
    fn in_a_terminal(test: &str) -> String {
        ending_in_a_terminal(test).0
    }

    /// The same, and how the process ended.
    fn ending_in_a_terminal(test: &str) -> (String, ExitStatus) {
        let pair = native_pty_system().openpty(PtySize::default()).unwrap();
        let modes = pair.master.get_termios().unwrap();
        let mut command = CommandBuilder::new(std::env::current_exe().unwrap());
        command.args(["--exact", test, "--nocapture", "--test-threads=1"]);
        command.env(INSIDE, "1");
        command.env("RUST_BACKTRACE", "0");
        let mut child = pair.slave.spawn_command(command).unwrap();
        drop(pair.slave);
        let mut written = Vec::new();
        // The end of the terminal may be reported as an error.
        let _ = pair
            .master
            .try_clone_reader()
            .unwrap()
            .read_to_end(&mut written);
        let status = child.wait().unwrap();
        let written = String::from_utf8_lossy(&written).into_owned();
        assert_eq!(pair.master.get_termios().unwrap(), modes, "{written}");
        (written, status)
    }

    fn is_inside() -> bool {
        std::env::var_os(INSIDE).is_some()
    }

    fn open() -> (Terminal, mpsc::Receiver<AppEvent>) {
        let (incoming, event) = mpsc::channel();
        let terminal = Terminal::open(incoming).unwrap();
        // Otherwise there would be nothing to put back.
        let modes = rustix::termios::tcgetattr(rustix::stdio::stdin()).unwrap();
        assert!(!modes.local_modes.contains(LocalModes::ICANON));
        (terminal, event)
    }

    fn draw(terminal: &mut Terminal, event: &mpsc::Receiver<AppEvent>, word: &'static str) {
        terminal.draw((20, 2), |frame| {
            frame.render_widget(ratatui::text::Line::raw(word), frame.area());
        });
        let Ok(AppEvent::Written(Ok(buffer))) = event.recv() else {
            panic!("the frame is written");
        };
        terminal.written(buffer);
    }

    const LEAVE: &str = "\x1b[?1049l";

    #[test]
    fn panics_restore_the_terminal_if_they_are_its_owners() {
        if is_inside() {
            let (mut terminal, event) = open();
            let worker = thread::spawn(|| panic!("words of a worker"));
            assert!(worker.join().is_err());
            draw(&mut terminal, &event, "still-here");
            panic!("words of the owner");
        }
        let written = in_a_terminal(
            "tui::terminal::tests::panics_restore_the_terminal_if_they_are_its_owners",
        );
        assert_eq!(written.matches(LEAVE).count(), 1, "{written}");
        let (screen, after) = written.split_once(LEAVE).unwrap();
        assert!(screen.contains("still-here"), "{written}");
        assert!(
            after.contains("\x1b[?25h"),
            "the cursor is shown: {written}"
        );
        assert!(after.contains("words of the owner"), "{written}");
        // Restored first, then said; and the worker's was not said over the screen.
        assert!(!screen.contains("words of"), "{written}");
        assert!(!written.contains("words of a worker"), "{written}");
    }

    #[test]
    fn memory_that_is_refused_leaves_the_terminal_as_it_was() {
        if is_inside() {
            let (mut terminal, event) = open();
            draw(&mut terminal, &event, "still-here");
            let worker = || std::alloc::handle_alloc_error(std::alloc::Layout::new::<u64>());
            let _ = thread::spawn(worker).join();
            return;
        }
        let (written, status) = ending_in_a_terminal(
            "tui::terminal::tests::memory_that_is_refused_leaves_the_terminal_as_it_was",
        );
        assert_eq!(written.matches(LEAVE).count(), 1, "{written}");
        // What the terminal had not read of the screen was thrown away.
        let (_, after) = written.split_once(LEAVE).unwrap();
        assert!(after.contains("\x1b[?25h"), "{written}");
        assert!(after.contains("memory was refused"), "{written}");
        assert!(!after.contains("passed"), "{written}");
        let signal = status.signal().expect("ended by a signal");
        assert!(signal.starts_with("Abort"), "{signal}");
    }

    #[test]
    fn an_immense_terminal_is_used_in_part() {
        assert_eq!(bounded((u16::MAX, u16::MAX)), MOST);
        assert_eq!(bounded((640, u16::MAX)), (640, MOST.1));
        assert_eq!(bounded((1, 1)), (1, 1));
    }

    #[test]
    fn what_is_given_away_is_taken_back_and_drawn_whole() {
        if is_inside() {
            let (mut terminal, event) = open();
            draw(&mut terminal, &event, "one");
            terminal.give_away();
            terminal.give_away();
            assert!(!terminal.is_ours() && !terminal.is_free());
            terminal.draw((20, 2), |_| panic!("nothing is drawn on another's screen"));
            println!("elsewhere");
            terminal.take_back().unwrap();
            draw(&mut terminal, &event, "one");
            terminal.copy("path");
            draw(&mut terminal, &event, "one");
            drop(terminal);
            let panicked = thread::spawn(|| panic!("words after the end")).join();
            assert!(panicked.is_err());
            return;
        }
        let written =
            in_a_terminal("tui::terminal::tests::what_is_given_away_is_taken_back_and_drawn_whole");
        let parts: Vec<&str> = written.split(LEAVE).collect();
        assert_eq!(parts.len(), 3, "{written}");
        assert!(parts[1].contains("elsewhere"), "{written}");
        assert_eq!(written.matches("\x1b[?1049h").count(), 2, "{written}");
        assert_eq!(parts[0].matches("one").count(), 1, "{written}");
        assert_eq!(parts[1].matches("one").count(), 1, "drawn again: {written}");
        assert!(parts[1].contains("\x1b]52;c;cGF0aA==\x07"), "{written}");
        // The panic hook of before is back.
        assert!(parts[2].contains("words after the end"), "{written}");
        assert!(parts[2].contains("1 passed"), "{written}");
    }
}
