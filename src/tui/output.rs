//! Bytes to the terminal, written by a thread of its own.
//!
//! A write to a terminal waits until the other side has read, and the other side may be a slow
//! link. Polling for writability does not help: it says that some bytes fit, not that a frame
//! does. So a thread writes, and only the thread waits: keys, signals and the solvers' events are
//! answered meanwhile.
//!
//! One buffer goes back and forth between the main loop and the writer. The one that does not have it
//! cannot draw: frames are skipped while the link is busy, and never queued.

use std::io::{self, Write};
use std::os::fd::AsFd;
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};

use super::event::{AppEvent, spawn};

/// What the buffer of a frame has room for from the start: the largest frame of a large terminal.
pub(super) const FRAME_BYTES: usize = 128 << 10;

/// The writing thread.
#[derive(Debug)]
pub(super) struct Output {
    jobs: Sender<Job>,
}

#[derive(Debug)]
enum Job {
    /// A frame: its buffer is given back.
    Frame(Vec<u8>),
    /// Bytes that somebody waits for.
    Awaited(Vec<u8>, SyncSender<io::Result<()>>),
}

impl Output {
    /// Starts the thread; it ends when the `Output` is dropped and all is written.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        mut terminal: impl Write + AsFd + Send + 'static,
        incoming: Sender<AppEvent>,
    ) -> io::Result<Self> {
        let (jobs, queue) = mpsc::channel();
        let written = incoming.clone();
        spawn("output", incoming, move || {
            for job in queue {
                match job {
                    Job::Frame(mut bytes) => {
                        let result = write_whole(&mut terminal, &bytes).map(|()| {
                            bytes.clear();
                            bytes
                        });
                        // If the loop has ended, nobody waits for the buffer.
                        let _ = written.send(AppEvent::Written(result));
                    }
                    Job::Awaited(bytes, done) => {
                        // The receiver may have given up waiting.
                        let _ = done.send(write_whole(&mut terminal, &bytes));
                    }
                }
            }
        })?;
        Ok(Self { jobs })
    }

    /// Sends a frame; [`AppEvent::Written`] follows when it is out.
    pub fn send(&self, frame: Vec<u8>) {
        // If the thread has ended, its panic was reported.
        let _ = self.jobs.send(Job::Frame(frame));
    }

    /// Writes bytes after what is under way; the answer comes when they are out.
    ///
    /// # Errors
    /// `BrokenPipe` where the thread has gone.
    pub fn begin(&self, bytes: &[u8]) -> io::Result<Receiver<io::Result<()>>> {
        let (done, wait) = mpsc::sync_channel(1);
        self.jobs
            .send(Job::Awaited(bytes.to_owned(), done))
            .map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))?;
        Ok(wait)
    }

    /// Writes bytes after what is under way, and waits for it no longer than `patience`: a dead
    /// link is not to hold up the end of the process.
    ///
    /// # Errors
    /// The system's; `TimedOut` where patience ran out.
    pub fn write_within(&self, bytes: &[u8], patience: Duration) -> io::Result<()> {
        self.begin(bytes)?
            .recv_timeout(patience)
            .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
    }
}

/// Writes all bytes, in one call where the terminal takes them at once. It may have been left in
/// non-blocking mode by another program; then its readiness is waited for.
fn write_whole(terminal: &mut (impl Write + AsFd), bytes: &[u8]) -> io::Result<()> {
    let mut rest = bytes;
    while !rest.is_empty() {
        match terminal.write(rest) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(count) => rest = &rest[count..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                let mut ready = [PollFd::new(terminal, PollFlags::OUT)];
                match poll(&mut ready, None) {
                    Ok(_) | Err(rustix::io::Errno::INTR) => {}
                    Err(error) => return Err(error.into()),
                }
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::Read;
    use std::os::unix::net::UnixStream;

    const LIMIT: Duration = Duration::from_secs(20);

    fn start() -> (Output, UnixStream, Receiver<AppEvent>) {
        let (near, far) = UnixStream::pair().unwrap();
        let (incoming, event) = mpsc::channel();
        (Output::start(near, incoming).unwrap(), far, event)
    }

    #[test]
    fn the_buffer_comes_back_empty_and_as_large_as_it_was() {
        let (output, mut far, event) = start();
        let mut frame = Vec::with_capacity(FRAME_BYTES);
        frame.extend_from_slice(b"frame");
        output.send(frame);
        let Ok(AppEvent::Written(Ok(buffer))) = event.recv_timeout(LIMIT) else {
            panic!("the frame is written");
        };
        assert!(buffer.is_empty() && buffer.capacity() == FRAME_BYTES);
        let mut read = [0; 5];
        far.read_exact(&mut read).unwrap();
        assert_eq!(&read, b"frame");
    }

    #[test]
    fn a_link_that_takes_nothing_is_not_waited_for() {
        let (output, mut far, event) = start();
        // More than a socket holds: the writer waits for a reader.
        output.send(vec![b'x'; 8 << 20]);
        let waited = output.write_within(b"end", Duration::from_millis(20));
        assert_eq!(waited.unwrap_err().kind(), io::ErrorKind::TimedOut);
        assert!(event.try_recv().is_err(), "the frame is still under way");

        let reader = std::thread::spawn(move || {
            let mut all = Vec::new();
            far.read_to_end(&mut all).map(|_| all)
        });
        let Ok(AppEvent::Written(Ok(_))) = event.recv_timeout(LIMIT) else {
            panic!("the frame is written once it is read");
        };
        drop(output);
        let all = reader.join().unwrap().unwrap();
        assert_eq!(all.len(), (8 << 20) + 3);
        assert!(all.ends_with(b"xend"), "in the order of the calls");
    }

    #[test]
    fn a_link_that_is_gone_is_an_error() {
        let (output, far, event) = start();
        drop(far);
        output.send(b"frame".to_vec());
        let Ok(AppEvent::Written(Err(error))) = event.recv_timeout(LIMIT) else {
            panic!("the error is told");
        };
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
        assert!(output.write_within(b"end", LIMIT).is_err());
    }

    #[test]
    fn a_full_device_is_an_error() {
        let (incoming, _news) = mpsc::channel();
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = Output::start(full, incoming).unwrap();
        let error = output.write_within(b"frame", LIMIT).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }

    #[test]
    fn a_terminal_that_does_not_block_is_waited_for() {
        let (near, mut far) = UnixStream::pair().unwrap();
        near.set_nonblocking(true).unwrap();
        let (incoming, _news) = mpsc::channel();
        let output = Output::start(near, incoming).unwrap();
        let reader = std::thread::spawn(move || {
            let mut all = Vec::new();
            far.read_to_end(&mut all).map(|_| all.len())
        });
        output.write_within(&vec![b'x'; 4 << 20], LIMIT).unwrap();
        drop(output);
        assert_eq!(reader.join().unwrap().unwrap(), 4 << 20);
    }
}
