//! A run that is one of many: it is set up and simulated without words of its own.

use super::progress::Progress;
use super::run::{Events, Stop, simulate};
use super::signals::EndSignal;
use crate::record::{Ending, RecordError, Recorder};
use crate::scene::Scene;
use crate::signals::EndingSignal;
use crate::simulation::{Simulation, SimulationError, threads_that_pay};

/// How such a run ended.
pub(super) enum Ended {
    Done,
    Stopped(EndingSignal),
    Failed(String),
}

impl Ended {
    /// How its record is to end.
    pub fn ending(&self) -> Ending {
        match self {
            Self::Done => Ending::Done,
            Self::Stopped(signal) => Ending::Interrupted(signal.name),
            Self::Failed(reason) => Ending::Failed(reason.clone()),
        }
    }
}

/// Sets it up, on this thread.
///
/// # Errors
/// It was stopped by a signal, or failed.
pub(super) fn set_up(scene: &Scene, signal: &EndSignal) -> Result<Simulation, Ended> {
    let mut received = None;
    let simulation = Simulation::new_unless(scene, &mut |_| {
        received = signal.received();
        received.is_some()
    });
    simulation.map_err(|error| match (error, received) {
        (SimulationError::Ended, Some(signal)) => Ended::Stopped(signal),
        (error, _) => Ended::Failed(error.to_string()),
    })
}

/// Simulates what is left of it, in at most `threads` threads, and ends its record.
///
/// # Errors
/// The record of a run that did not fail could not be ended.
pub(super) fn complete(
    mut simulation: Simulation,
    mut recorder: Recorder,
    threads: usize,
    signal: &EndSignal,
    progress: Progress,
) -> Result<Ended, RecordError> {
    let nodes = simulation.mesh().nodes().len();
    simulation.set_threads(threads_that_pay(nodes, threads));
    simulation.follow(recorder.schedule());
    let told = Events::Untold;
    let stop = simulate(&mut simulation, &mut recorder, signal, progress, told);
    let finished = recorder.finish(&mut simulation, stop.ending());
    match stop {
        Stop::Failed(error) => Ok(Ended::Failed(error.to_string())),
        Stop::Signal(signal) => finished.map(|_| Ended::Stopped(signal)),
        Stop::Done => finished.map(|_| Ended::Done),
    }
}
