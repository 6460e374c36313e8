//! The messages to and from a worker.

use std::sync::Arc;
use std::time::Duration;

use super::super::{Event, Report, SetUp, SimulationCheckpoint, SimulationError, StepProgress};
use crate::fem::Mesh;
use crate::scene::{AnchoringKind, Assignment, Change, Scene, Warning};
use crate::scheme::State;

/// Identifies a run of a process: events of a run that was ended may still arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RunId(pub u64);

/// How a worker is started.
#[derive(Debug, Clone)]
pub struct WorkerConfig {
    /// The run's number.
    pub run: RunId,
    /// Whether it waits for `Resume` at step 0.
    pub paused: bool,
    /// The run does not go beyond the first grid time at or after this one until another command:
    /// a common clock for runs that are watched side by side. `None`: it runs to T.
    pub horizon: Option<f64>,
    /// Reports are gathered for this long before they are sent.
    pub gathering: Duration,
    /// This many states, evenly from t = 0 to T, are sent as [`WorkerEvent::Snapshot`]: none is lost.
    pub snapshots: u64,
    /// The largest number of threads that compute its steps; fewer do where more would not pay.
    pub threads: usize,
}

/// What can be asked of a worker. Commands are carried out between two steps, in the order in which they
/// are sent. After T is reached only `Change` and `Until` are answered, because no step is left to be
/// taken.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Stop after the current step. Always answered by [`WorkerEvent::Paused`], even when it is paused
    /// already.
    Pause,
    /// Continue.
    Resume,
    /// Take one step, even beyond the horizon, and pause. Answered by [`WorkerEvent::Paused`].
    Step,
    /// Other parameters for the present state, from the next step on. Answered by [`WorkerEvent::Changed`] or
    /// [`WorkerEvent::ChangeRefused`].
    Change {
        /// The parameters and their values.
        set: Vec<Assignment>,
        /// How long it takes to get there.
        over: f64,
    },
    /// Move the horizon (see [`WorkerConfig`]).
    Horizon(Option<f64>),
    /// Another T. A run that had reached its end is then paused: answered by
    /// [`WorkerEvent::Paused`].
    Until(f64),
    /// Report the state now. Answered by [`WorkerEvent::State`] if states are reported at all.
    Keep,
    /// End the run. Dropping the worker does the same.
    End,
}

/// An event of a run.
#[derive(Debug, Clone)]
pub struct Message {
    /// Whose.
    pub run: RunId,
    /// What.
    pub event: WorkerEvent,
}

/// What a worker reports.
#[derive(Debug, Clone)]
pub enum WorkerEvent {
    /// A part of the set-up begins.
    SettingUp(SetUp),
    /// The run was set up: the first event after those.
    Ready(Arc<Setting>),
    /// The scalars of steps, in order, none left out; the first is step 0.
    Reports(Vec<Report>),
    /// How far a step is that takes long: after a second, and every half second from then on.
    StepProgress(StepProgress),
    /// Something happened.
    Event(Event),
    /// The scene has this change now.
    Changed(Change),
    /// It cannot have it, and why.
    ChangeRefused(String),
    /// One of the evenly spaced states that were ordered.
    Snapshot(Arc<RunSnapshot>),
    /// The state from which the run can be resumed: if ordered, at regular intervals, when it is
    /// asked for, and before the worker ends, also within a step; unless asked for, only if something
    /// was computed since the last time.
    State(Box<SimulationCheckpoint>),
    /// The worker is paused, as asked: the answer to every `Pause` and every `Step`, and reported at
    /// the start if it was ordered to wait.
    Paused,
    /// The worker computes again, after a pause or at a moved horizon.
    Resumed,
    /// The worker waits at its horizon.
    AtHorizon,
    /// T is reached: all reports were sent before. Reported once, and again at a later T.
    Done,
    /// The run cannot start or continue, and why; the last good state is kept. After this the
    /// thread has ended. A panic of the thread arrives here too.
    Failed(Failure),
}

/// Why a run cannot start or continue.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{words}")]
pub struct Failure {
    /// In words.
    pub words: String,
    /// Whether the scene asks for what cannot be; else the solver failed, or the system.
    pub is_of_scene: bool,
}

impl Failure {
    /// One that the scene is not to blame for.
    pub(super) fn other(words: String) -> Self {
        Self {
            words,
            is_of_scene: false,
        }
    }
}

impl From<SimulationError> for Failure {
    fn from(error: SimulationError) -> Self {
        Self {
            words: error.to_string(),
            is_of_scene: error.is_of_scene(),
        }
    }
}

/// What does not change over a run.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The scene.
    pub scene: Scene,
    /// Steps to T; `None` where Δt is chosen.
    pub steps: Option<u64>,
    /// What is allowed in the scene but probably not meant.
    pub warnings: Vec<Warning>,
}

/// The fields of a run at one time with the scalars of that time.
#[derive(Debug, Clone)]
pub struct RunSnapshot {
    /// The run.
    pub run: RunId,
    /// The anchoring at that time, `None` where the scene has no director.
    pub anchoring: Option<AnchoringKind>,
    /// The scalars.
    pub report: Report,
    /// The mesh at that time.
    pub mesh: Arc<Mesh>,
    /// The fields; a saved figure shares them.
    pub state: Arc<State>,
}
