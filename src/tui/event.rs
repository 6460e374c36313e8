//! What reaches the main loop: the app's messages, and what concerns the loop alone.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::thread::{self, JoinHandle};

use super::message::Message;
use crate::simulation::panic_words;

/// What reaches the main loop.
#[derive(Debug)]
pub(super) enum AppEvent {
    /// Something for the app's state.
    Message(Message),
    /// The terminal has a new size, to be asked for.
    SizeChanged,
    /// A text was pasted.
    Pasted(String),
    /// A frame was written, or not; its buffer comes back.
    Written(io::Result<Vec<u8>>),
    /// The process is asked to stop, as by Ctrl-Z.
    Stop,
    /// The process continues after a stop.
    Continued,
    /// The editor of a scene has ended; the file to load again (none: nothing was changed), or why that failed.
    Edited(Result<Option<PathBuf>, String>),
    /// A thread of the app's own has panicked: these were its words.
    Crashed(String),
}

/// Starts a thread whose panic reaches the main loop.
///
/// # Errors
/// The system gives no thread.
pub(super) fn spawn(
    name: &str,
    incoming: Sender<AppEvent>,
    body: impl FnOnce() + Send + 'static,
) -> io::Result<JoinHandle<()>> {
    let told_name = name.to_owned();
    thread::Builder::new().name(name.to_owned()).spawn(move || {
        if let Err(payload) = catch_unwind(AssertUnwindSafe(body)) {
            let words = panic_words(payload.as_ref());
            // If the loop has ended, nobody is left to report to.
            let _ = incoming.send(AppEvent::Crashed(format!("{told_name}: {words}")));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_panic_of_a_thread_is_told() {
        let (incoming, told) = mpsc::channel();
        let number = 7;
        let thread = spawn("input", incoming, move || panic!("lost {number}")).unwrap();
        thread.join().unwrap();
        let Ok(AppEvent::Crashed(words)) = told.try_recv() else {
            panic!("the panic is told");
        };
        assert_eq!(words, "input: lost 7");
    }
}
