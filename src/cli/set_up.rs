//! Setting a run up, on a thread of its own: a signal is answered at once, whatever the set-up is
//! doing, and a person sees what that is.

use super::error::CliError;
use super::output;
use super::signals::EndSignal;
use crate::scene::Scene;
use crate::signals::EndingSignal;
use crate::simulation::{SetUp, Simulation, SimulationError};
use indicatif::{ProgressBar, ProgressStyle};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// How often it is looked whether a signal came.
const INTERVAL: Duration = Duration::from_millis(50);

/// A set-up that takes longer is shown.
const SHOWN_AFTER: Duration = Duration::from_millis(500);

/// What became of a set-up.
pub(super) enum Outcome {
    /// It is done.
    Ready(Box<Simulation>),
    /// It was ended by a signal.
    Signal(EndingSignal),
    /// It failed.
    Failed(SimulationError),
}

/// What the thread sends.
enum WorkerEvent {
    Doing(SetUp),
    Done(Result<Box<Simulation>, SimulationError>),
}

/// Sets a run up, until that is done or a signal comes. What is being done is shown on the standard
/// error where that is a terminal.
///
/// # Errors
/// [`CliError::Thread`].
pub(super) fn set_up(scene: &Scene, signal: &EndSignal) -> Result<Outcome, CliError> {
    let (sender, event) = mpsc::channel();
    let ended = Arc::new(AtomicBool::new(false));
    let worker = {
        let (scene, ended) = (scene.clone(), Arc::clone(&ended));
        let set_up = move || {
            let mut last = None;
            let result = Simulation::new_unless(&scene, &mut |part| {
                if last.replace(part) != Some(part) {
                    // If nobody listens, `ended` is set.
                    let _ = sender.send(WorkerEvent::Doing(part));
                }
                ended.load(Ordering::Relaxed)
            });
            let _ = sender.send(WorkerEvent::Done(result.map(Box::new)));
        };
        thread::Builder::new()
            .name("set-up".to_owned())
            .spawn(set_up)
    };
    let worker = worker.map_err(CliError::Thread)?;
    let mut display = Display::new();
    loop {
        if let Some(signal) = signal.received() {
            // A factor in hand is not waited for: the thread ends with the process.
            ended.store(true, Ordering::Relaxed);
            return Ok(Outcome::Signal(signal));
        }
        match event.recv_timeout(INTERVAL) {
            Ok(WorkerEvent::Doing(part)) => display.part = part,
            Ok(WorkerEvent::Done(Ok(simulation))) => return Ok(Outcome::Ready(simulation)),
            Ok(WorkerEvent::Done(Err(error))) => return Ok(Outcome::Failed(error)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                // It has panicked, and its message is printed.
                if let Err(panic) = worker.join() {
                    resume_unwind(panic);
                }
                return Ok(Outcome::Failed(SimulationError::Ended));
            }
        }
        display.show();
    }
}

/// A line that says what is being done, and for how long.
struct Display {
    bar: ProgressBar,
    part: SetUp,
    begun: Instant,
}

impl Display {
    fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, output::progress_target());
        // The template is right; if it ever were not, the plain bar serves.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}  {elapsed}") {
            bar.set_style(style);
        }
        Self {
            bar,
            part: SetUp::Mesh,
            begun: Instant::now(),
        }
    }

    fn show(&self) {
        if self.begun.elapsed() >= SHOWN_AFTER {
            self.bar.set_message(self.part.words());
            self.bar.tick();
        }
    }
}

/// Takes the line away.
impl Drop for Display {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
