//! Everything that happens to the app, and everything that it wants done.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crossterm::event::KeyEvent;

use super::autosave::Kept;
use super::measuring::MeasuringJob;
use super::state::{Keeping, MeasuringNews, Slot};
use crate::scene::Scene;
use crate::simulation::{Command, Message as WorkerMessage, RunId, RunSnapshot, WorkerConfig};
use crate::theory::ShapeAtRest;

/// What happens to the app.
#[derive(Debug)]
pub enum Message {
    /// A key was pressed.
    Key(KeyEvent),
    /// The terminal has another size: columns, rows.
    Resized(u16, u16),
    /// The terminal is back after Ctrl-Z.
    Continued,
    /// WorkerEvent of a worker.
    Solver(WorkerMessage),
    /// The latest fields of a run, fetched from its mailbox.
    Fields(Arc<RunSnapshot>),
    /// Seconds of computing of a run so far.
    Computing(RunId, Duration),
    /// Whether the state of a run is kept.
    Kept(RunId, Keeping),
    /// A scene was loaded from a name, or why not.
    Loaded(Result<Box<Slot>, String>),
    /// The prices of effects as a table, or how far measuring them is, or why they cannot be had.
    Prices(String),
    /// What a scene of this name would take, in words, or why it cannot be run.
    Expected(String, Option<Result<String, String>>),
    /// Something about the measured error of a run.
    Measured(RunId, MeasuringNews),
    /// The shape at rest that theory foresees for a run, or why there is none.
    Foreseen(RunId, Result<Arc<ShapeAtRest>, String>),
    /// What was to be saved is saved, or why not.
    Saved(Result<PathBuf, String>),
    /// A signal asks the process to end.
    Signal(i32),
    /// The terminal is gone.
    HungUp,
    /// This many bytes of memory are available.
    FreeMemory(u64),
    /// A scene was left as it is in the editor.
    NotEdited,
    /// Something to say in passing.
    Remark(String),
    /// This much time has passed, which counts only while [`time_counts`](super::update::time_counts).
    Passed(Duration),
    /// Nothing has happened: the app begins.
    Tick,
}

/// What the app wants done.
#[derive(Debug)]
pub enum Effect {
    /// Start a worker.
    Start(WorkerConfig, Arc<Scene>),
    /// Send a worker a command.
    Tell(RunId, Command),
    /// End a worker and forget it; its state stays kept.
    Drop(RunId),
    /// End a worker, and remove what is kept of it.
    Discard(RunId),
    /// Put kept runs of slots aside, under other names, so that new ones take their places.
    PutAside(Vec<(usize, Arc<Kept>)>),
    /// Load a scene by a preset's name or a path, in the background.
    Load(String),
    /// Measure what each effect of a scene costs, in the background, as long as that is shown.
    Price(Arc<Scene>),
    /// Measure what a scene would take on this machine: a given one, or that of the name; in the background.
    Expect(String, Option<Arc<Scene>>),
    /// Solve for the shape at rest of the run of a picture, in the background.
    Foresee(Arc<RunSnapshot>, Box<TheoryJob>),
    /// Measure the error of a run, in the background, until it is measured or the run says that it is not to be.
    Measure(RunId, Box<MeasuringJob>),
    /// Edit the scene of the slot in $EDITOR and load it again. A preset is written to a file first.
    Edit(usize),
    /// Save one view: PNG, SVG, CSV, VTU.
    SaveView(Arc<RunSnapshot>, usize),
    /// Save the report's whole set of the slot.
    SaveSet(usize),
    /// Put a text into the terminal's clipboard (OSC 52).
    Copy(String),
    /// Stop the process as Ctrl-Z does.
    Suspend,
    /// Leave.
    Quit,
}

/// What the shape at rest of a run is solved for from, beside a picture.
#[derive(Debug)]
pub struct TheoryJob {
    /// The scene with the parameters of that time.
    pub scene: Scene,
    /// B(φ⁰).
    pub surface_area: f64,
}
