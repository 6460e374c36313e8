//! Keys, read by a thread of its own.
//!
//! The bytes are read here and only taken apart by a library: crossterm's own reader never returns
//! once the terminal is gone (it reads the end of the file again and again), waits for the rest of
//! a sequence with no way to interrupt it, and cannot be made to let go of the terminal for an
//! editor.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::mpsc::Sender;
use std::thread::JoinHandle;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use terminput::Event;
use terminput_crossterm::to_crossterm;

use super::incoming::{Incoming, spawn};
use super::message::Message;

/// How long the rest of an escape sequence may take before Escape counts as the key: links cut
/// sequences in two.
const SEQUENCE: Timespec = milliseconds(40);
/// How long the rest of a pasted text may take.
const PASTE: Timespec = milliseconds(1000);
const PASTE_BEGIN: &[u8] = b"\x1b[200~";
/// A sequence that is longer than this is none: a text that is pasted may be.
const LONGEST: usize = 1 << 20;

const fn milliseconds(count: i64) -> Timespec {
    Timespec {
        tv_sec: count / 1000,
        tv_nsec: count % 1000 * 1_000_000,
    }
}

/// The reading thread. Dropping it ends it: nothing is read after that.
#[derive(Debug)]
pub(super) struct Input {
    /// Closed to end the thread.
    stop: Option<OwnedFd>,
    thread: Option<JoinHandle<()>>,
}

impl Input {
    /// Starts to read the standard input, which is a terminal.
    ///
    /// # Errors
    /// The system gives no pipe or no thread.
    pub fn start(incoming: Sender<Incoming>) -> io::Result<Self> {
        let (stopped, stop) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC)?;
        let sink = incoming.clone();
        let thread = spawn("input", incoming, move || {
            // If the loop has ended, nobody wants the keys.
            read(rustix::stdio::stdin(), &stopped, &mut |told| {
                let _ = sink.send(told);
            });
        })?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }
}

impl Drop for Input {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // Its panic was told already.
            let _ = thread.join();
        }
    }
}

/// Reads until the terminal is gone or the other end of `stopped` is closed.
fn read(
    terminal: impl std::os::fd::AsFd,
    stopped: impl std::os::fd::AsFd,
    sink: &mut dyn FnMut(Incoming),
) {
    let mut decoder = Decoder::default();
    let mut bytes = [0; 4096];
    loop {
        let mut ready = [
            PollFd::new(&terminal, PollFlags::IN),
            PollFd::new(&stopped, PollFlags::IN),
        ];
        match poll(&mut ready, decoder.patience().as_ref()) {
            Err(Errno::INTR) => continue,
            Err(_) => return sink(Incoming::Message(Message::HungUp)),
            Ok(0) => {
                decoder.lose_patience(sink);
                continue;
            }
            Ok(_) => {}
        }
        if !ready[1].revents().is_empty() {
            return;
        }
        match rustix::io::read(&terminal, &mut bytes) {
            Err(Errno::INTR | Errno::AGAIN) => {}
            Ok(0) | Err(_) => return sink(Incoming::Message(Message::HungUp)),
            Ok(count) => decoder.take(&bytes[..count], sink),
        }
    }
}

/// Takes keys out of a stream of bytes.
#[derive(Debug, Default)]
struct Decoder {
    /// A sequence that has begun and not ended.
    pending: Vec<u8>,
}

impl Decoder {
    fn take(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Incoming)) {
        for &byte in bytes {
            self.pending.push(byte);
            if self.pending == [0x1b] {
                // A key or the begin of a sequence: what follows tells, or that nothing follows.
                continue;
            }
            match Event::parse_from(&self.pending) {
                Ok(Some(event)) => {
                    self.pending.clear();
                    tell(event, sink);
                }
                Ok(None) if self.pending.len() < LONGEST => {}
                Ok(None) | Err(_) => {
                    self.pending.clear();
                    // A sequence that was broken off by another one.
                    if byte == 0x1b {
                        self.pending.push(byte);
                    }
                }
            }
        }
    }

    /// How long to wait for the rest of what is pending.
    fn patience(&self) -> Option<Timespec> {
        match &self.pending[..] {
            [] => None,
            pending if pending.starts_with(PASTE_BEGIN) => Some(PASTE),
            _ => Some(SEQUENCE),
        }
    }

    /// No rest came: a single Escape is the key, anything else is nothing.
    fn lose_patience(&mut self, sink: &mut dyn FnMut(Incoming)) {
        if let Ok(Some(event)) = Event::parse_from(&self.pending) {
            tell(event, sink);
        }
        self.pending.clear();
    }
}

fn tell(event: Event, sink: &mut dyn FnMut(Incoming)) {
    if let Event::Paste(text) = event {
        return sink(Incoming::Pasted(text));
    }
    if let Ok(crossterm::event::Event::Key(key)) = to_crossterm(event)
        && key.kind != crossterm::event::KeyEventKind::Release
    {
        sink(Incoming::Message(Message::Key(key)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
    use std::io::Write;
    use std::os::unix::net::UnixStream;
    use std::sync::mpsc;
    use std::time::Duration;

    fn keys(decoder: &mut Decoder, bytes: &[u8]) -> Vec<KeyEvent> {
        let mut keys = Vec::new();
        decoder.take(bytes, &mut |told| {
            if let Incoming::Message(Message::Key(key)) = told {
                keys.push(key);
            }
        });
        keys
    }

    fn codes(bytes: &[u8]) -> Vec<KeyCode> {
        let keys = keys(&mut Decoder::default(), bytes);
        keys.into_iter().map(|key| key.code).collect()
    }

    #[test]
    fn keys_of_all_kinds_are_known() {
        assert_eq!(codes(b"a "), [KeyCode::Char('a'), KeyCode::Char(' ')]);
        assert_eq!(
            codes("Gφ".as_bytes()),
            [KeyCode::Char('G'), KeyCode::Char('φ')]
        );
        assert_eq!(codes(b"\x1b[D\x1bOC"), [KeyCode::Left, KeyCode::Right]);
        assert_eq!(
            codes(b"\x1b[H\x1b[F\x1b[4~"),
            [KeyCode::Home, KeyCode::End, KeyCode::End]
        );
        assert_eq!(
            codes(b"\r\t\x7f\x1b[Z"),
            [
                KeyCode::Enter,
                KeyCode::Tab,
                KeyCode::Backspace,
                KeyCode::BackTab,
            ]
        );
        let stop = keys(&mut Decoder::default(), b"\x1a\x03");
        assert_eq!(
            stop[0],
            KeyEvent::new(KeyCode::Char('z'), KeyModifiers::CONTROL)
        );
        assert_eq!(
            stop[1],
            KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)
        );
    }

    #[test]
    fn a_sequence_may_come_in_pieces_and_escape_alone_is_a_key() {
        let mut decoder = Decoder::default();
        for piece in [&b"\x1b"[..], b"[", b"1;5"] {
            assert_eq!(keys(&mut decoder, piece), []);
            assert_eq!(decoder.patience(), Some(SEQUENCE));
        }
        assert_eq!(keys(&mut decoder, b"C")[0].code, KeyCode::Right);
        assert_eq!(decoder.patience(), None);

        assert_eq!(keys(&mut decoder, b"\x1b"), []);
        let mut told = Vec::new();
        decoder.lose_patience(&mut |incoming| told.push(incoming));
        assert!(
            matches!(&told[..], [Incoming::Message(Message::Key(key))] if key.code == KeyCode::Esc)
        );
    }

    #[test]
    fn nonsense_does_not_hide_what_follows() {
        let nonsense: [&[u8]; 4] = [b"\xff\xfe", b"\x1b[999;;;\x07", b"\x1b[?1;2c", b"\x1bOz"];
        for bytes in nonsense {
            let mut decoder = Decoder::default();
            keys(&mut decoder, bytes);
            decoder.lose_patience(&mut |_| {});
            let last = keys(&mut decoder, b"q").pop();
            assert_eq!(
                last.map(|key| key.code),
                Some(KeyCode::Char('q')),
                "{bytes:?}"
            );
        }
    }

    #[test]
    fn a_pasted_text_is_no_keys() {
        let mut told = Vec::new();
        let mut decoder = Decoder::default();
        decoder.take(b"\x1b[200~q\ny", &mut |incoming| told.push(incoming));
        assert_eq!(decoder.patience(), Some(PASTE));
        decoder.take(b"\x1b[201~n", &mut |incoming| told.push(incoming));
        let [Incoming::Pasted(text), Incoming::Message(Message::Key(key))] = &told[..] else {
            panic!("{told:?}");
        };
        assert_eq!((text.as_str(), key.code), ("q\ny", KeyCode::Char('n')));
    }

    #[test]
    fn the_end_of_the_terminal_is_told_once_and_a_stop_is_not() {
        let (near, mut far) = UnixStream::pair().unwrap();
        let (stopped, stop) = rustix::pipe::pipe().unwrap();
        let (sink, told) = mpsc::channel();
        let reader = std::thread::spawn(move || {
            read(near, &stopped, &mut |incoming| sink.send(incoming).unwrap());
        });
        far.write_all(b"n").unwrap();
        let key = told.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(matches!(key, Incoming::Message(Message::Key(_))));
        drop(far);
        reader.join().unwrap();
        let all: Vec<Incoming> = told.iter().collect();
        assert!(
            matches!(&all[..], [Incoming::Message(Message::HungUp)]),
            "{all:?}"
        );
        drop(stop);

        let (near, _far) = UnixStream::pair().unwrap();
        let (stopped, stop) = rustix::pipe::pipe().unwrap();
        drop(stop);
        read(near, &stopped, &mut |incoming| panic!("{incoming:?}"));
    }
}
