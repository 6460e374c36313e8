//! A run on a thread of its own: commands in, scalars and life-cycle events out on a channel that
//! loses nothing, fields through a mailbox in which the latest wins.
//!
//! The worker never waits for its observer: events go to a *sink* that must not block, and a field
//! that nobody has fetched is overwritten. What a watched run computes is, bit for bit, what
//! [`Simulation`](super::Simulation) computes without a worker.

mod mailbox;
mod message;
mod runner;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::SimulationCheckpoint;
use crate::scene::Scene;

pub use mailbox::Mailbox;
pub use message::{
    Command, Failure, Message, RunId, RunSnapshot, Setting, WorkerConfig, WorkerEvent,
};

use runner::Runner;
pub(crate) use runner::panic_words;

/// How a run hangs together with those before and after it.
#[derive(Debug, Default)]
pub struct Continuity {
    /// The state to continue from; `None`: φ⁰ and d⁰ of the scene.
    pub from: Option<Box<SimulationCheckpoint>>,
    /// How often [`WorkerEvent::State`] is reported; `None`: never.
    pub keep: Option<Duration>,
}

/// A run on a thread of its own. Dropping it ends the run and waits for the thread: until the step
/// in hand, or the part of the set-up, is done.
#[derive(Debug)]
pub struct Worker {
    run: RunId,
    commands: Sender<Command>,
    mailbox: Mailbox,
    computing: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// The name of every worker's thread begins with this: a panic there is caught, and reported as
    /// [`WorkerEvent::Failed`].
    pub const THREAD_NAME: &str = "vesica run";

    /// Starts a run. `sink` is called on the run's thread with all its events and must not block.
    ///
    /// Every failure is reported to the sink, also a thread that cannot be started.
    pub fn start(
        config: WorkerConfig,
        scene: Arc<Scene>,
        sink: impl Fn(Message) + Send + 'static,
    ) -> Self {
        Self::start_from(config, scene, Continuity::default(), sink)
    }

    /// Starts a run that continues another, or that can be resumed later.
    pub fn start_from(
        config: WorkerConfig,
        scene: Arc<Scene>,
        continuity: Continuity,
        sink: impl Fn(Message) + Send + 'static,
    ) -> Self {
        let run = config.run;
        let (commands, received) = mpsc::channel();
        let mailbox = Mailbox::default();
        let computing = Arc::new(AtomicU64::new(0));
        // Shared until the thread has it, so that a thread that cannot be started can be reported.
        let sink = Arc::new(Mutex::new(Some(sink)));
        let taken = {
            let (sink, mailbox, computing) = (sink.clone(), mailbox.clone(), computing.clone());
            move || {
                if let Some(sink) = take(&sink) {
                    Runner::new(config, received, sink, mailbox, computing).run(&scene, continuity);
                }
            }
        };
        let thread = thread::Builder::new()
            .name(format!("{} {}", Self::THREAD_NAME, run.0))
            .spawn(taken);
        let thread = match thread {
            Ok(thread) => Some(thread),
            Err(reason) => {
                if let Some(sink) = take(&sink) {
                    let text = format!("the system starts no thread for the run: {reason}");
                    let event = WorkerEvent::Failed(Failure::other(text));
                    sink(Message { run, event });
                }
                None
            }
        };
        Self {
            run,
            commands,
            mailbox,
            computing,
            thread,
        }
    }

    /// The run's number.
    pub fn run(&self) -> RunId {
        self.run
    }

    /// Sends the worker a command. A run that has ended ignores it.
    pub fn tell(&self, command: Command) {
        // An error means that the thread has ended, which it has reported to its sink.
        let _ = self.commands.send(command);
    }

    /// Where its latest picture can be fetched.
    pub fn mailbox(&self) -> Mailbox {
        self.mailbox.clone()
    }

    /// Whether its thread has ended.
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// The time that its steps took so far, without set-up and pauses.
    pub fn computing(&self) -> Duration {
        Duration::from_nanos(self.computing.load(Ordering::Relaxed))
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.tell(Command::End);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was caught and reported.
            let _ = thread.join();
        }
    }
}

fn take<T>(shared: &Mutex<Option<T>>) -> Option<T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner).take()
}
