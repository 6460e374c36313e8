//! Keys, read by a thread of its own.
//!
//! The bytes are read here, and the decoder takes them apart: crossterm's own reader never returns
//! once the terminal is gone (it reads the end of the file again and again), waits for the rest of
//! a sequence with no way to interrupt it, and cannot be made to let go of the terminal for an
//! editor.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::mpsc::Sender;
use std::thread::JoinHandle;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

use super::decoder::Decoder;
use super::event::{AppEvent, spawn};
use super::message::Message;

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
    pub fn start(incoming: Sender<AppEvent>) -> io::Result<Self> {
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
            // Its panic was reported already.
            let _ = thread.join();
        }
    }
}

/// Reads until the terminal is gone or the other end of `stopped` is closed.
fn read(
    terminal: impl std::os::fd::AsFd,
    stopped: impl std::os::fd::AsFd,
    sink: &mut dyn FnMut(AppEvent),
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
            Err(_) => return sink(AppEvent::Message(Message::HungUp)),
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
            Ok(0) | Err(_) => return sink(AppEvent::Message(Message::HungUp)),
            Ok(count) => decoder.take(&bytes[..count], sink),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::os::unix::net::UnixStream;
    use std::sync::mpsc;
    use std::time::Duration;

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
        assert!(matches!(key, AppEvent::Message(Message::Key(_))));
        drop(far);
        reader.join().unwrap();
        let all: Vec<AppEvent> = told.iter().collect();
        assert!(
            matches!(&all[..], [AppEvent::Message(Message::HungUp)]),
            "{all:?}"
        );
        drop(stop);

        let (near, _far) = UnixStream::pair().unwrap();
        let (stopped, stop) = rustix::pipe::pipe().unwrap();
        drop(stop);
        read(near, &stopped, &mut |incoming| panic!("{incoming:?}"));
    }
}
