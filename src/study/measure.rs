//! A scene computed one way, with what it took.

use super::clock::Stopwatch;
use super::discretisation::Discretisation;
use super::errors::Solution;
use super::memory;
use crate::scene::Scene;
use crate::simulation::{ErrorEstimates, Schedule, Simulation, SimulationError, StepProgress};
use std::time::Duration;

/// What a run took, and what came out.
#[derive(Debug)]
pub(super) struct Measurement {
    /// Computing time of the run, set-up and steps.
    pub(super) seconds: f64,
    /// How far it came: 1 is the end.
    pub(super) share: f64,
    /// The most memory that the run had, in bytes, without what the program holds besides; `None` where the
    /// program's allocator does not count.
    pub(super) memory: Option<u64>,
    /// Nodes of its mesh; 0 where that was not made.
    pub(super) nodes: usize,
    pub(super) steps: u64,
    pub(super) refused: u64,
    pub(super) newton: u64,
    pub(super) krylov: u64,
    /// Where the step stood that was left before its end.
    pub(super) underway: Option<StepProgress>,
    /// The errors that the run itself estimated.
    pub(super) estimates: ErrorEstimates,
    /// The state at T, or why there is none.
    pub(super) outcome: Result<Solution, Failure>,
}

/// Why there is no state at T.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Failure {
    /// The run failed.
    Failed(SimulationError),
    /// It took longer than it was allowed to.
    TooLong,
    /// Whoever watches has it ended.
    Ended,
}

/// A first step of which no part is solved in so many attempts, each shorter than the one before, will not be.
const HOPELESS: u64 = 20;

/// Whether nothing of a run was solved, though it was tried.
pub(super) fn is_stuck(underway: &StepProgress) -> bool {
    underway.step <= 1 && underway.parts == 0 && underway.refused > 0
}

/// Whether nothing of a run will be solved.
pub(super) fn is_hopeless(underway: &StepProgress) -> bool {
    is_stuck(underway) && underway.refused >= HOPELESS
}

/// Computes the scene this way for at most so long; `go_on` is asked at every step, and within one that takes
/// long.
pub(super) fn measure(
    scene: &Scene,
    choice: &Discretisation,
    limit: Duration,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Measurement {
    let scene = choice.applied_to(scene);
    let before = memory::forget_most();
    let watch = Stopwatch::start();
    let mut measurement = Measurement {
        seconds: 0.0,
        share: 0.0,
        memory: None,
        nodes: 0,
        steps: 0,
        refused: 0,
        newton: 0,
        krylov: 0,
        underway: None,
        estimates: ErrorEstimates::default(),
        outcome: Err(Failure::Ended),
    };
    measurement.outcome = advance(&scene, &watch, limit, go_on, &mut measurement);
    measurement.seconds = watch.elapsed().as_secs_f64();
    let bytes = u64::try_from(memory::most() - before);
    measurement.memory = bytes.ok().filter(|bytes| *bytes > 0);
    measurement
}

fn advance(
    scene: &Scene,
    watch: &Stopwatch,
    limit: Duration,
    go_on: &mut dyn FnMut(f64) -> bool,
    measurement: &mut Measurement,
) -> Result<Solution, Failure> {
    let schedule = Schedule::new(&scene.time, 1, 1);
    let mut simulation =
        Simulation::new_unless(scene, &mut |_| !go_on(0.0)).map_err(|error| match error {
            SimulationError::Ended => Failure::Ended,
            error => Failure::Failed(error),
        })?;
    simulation.follow(&schedule);
    measurement.nodes = simulation.mesh().nodes().len();
    loop {
        let report = simulation.report();
        let share = schedule.share(report.step, report.t);
        measurement.share = share;
        if schedule.is_done(report) {
            return Ok(Solution::of(&simulation));
        }
        let mut failure = None;
        let mut leave = |underway: Option<&StepProgress>| {
            let is_hopeless = underway.is_some_and(is_hopeless);
            failure = match go_on(share) {
                false => Some(Failure::Ended),
                true => (is_hopeless || watch.wall() > limit).then_some(Failure::TooLong),
            };
            failure.is_some()
        };
        let is_whole = !leave(None)
            && simulation
                .advance_unless(&mut |underway| {
                    measurement.underway = Some(*underway);
                    leave(Some(underway))
                })
                .map_err(Failure::Failed)?;
        match (is_whole, failure) {
            (true, _) => {}
            (false, Some(failure)) => return Err(failure),
            // It was left for an event, which nobody reads here.
            (false, None) => continue,
        }
        measurement.underway = None;
        let report = simulation.report();
        measurement.steps = report.step;
        measurement.refused += u64::from(report.refused);
        measurement.newton += u64::from(report.newton);
        measurement.krylov += u64::from(report.krylov);
        measurement.estimates = report.budget;
    }
}
