//! Steps of one length. The later ones are cheaper than the first, for their guesses are better: by how much is found
//! by the iterations that steps on a coarse mesh come down to.

use super::{Patience, RunEstimate, coarse, has_factor, is_over};
use crate::scene::{LinearMethod, Scene};
use crate::simulation::{Phase, Report, Simulation, SimulationError, memory_held};
use crate::study::clock::{Stopwatch, median};
use std::time::Duration;

/// Steps that are made at most on the own mesh.
const SETTLED: u64 = 64;

/// After so many steps the guesses are as good as they get: those of `circle` from the 130th on (`krylov` in
/// `history.csv`).
const SETTLED_COARSE: u64 = 256;

/// The last steps of a calibration count.
const LAST: usize = 8;

/// It has so many steps at least, for the first ones are more expensive than the others: up to the 35th of case 3
/// takes two iterations of Newton's method, every later one a single one,
const FEWEST: usize = 48;

/// unless they take longer than this.
const LONG: Duration = Duration::from_secs(5);

/// What a run of so many steps will take; `None` where no step was solved in time.
pub(super) fn price(
    scene: &Scene,
    steps: u64,
    patience: &mut Patience<'_>,
) -> Result<Option<RunEstimate>, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(scene)?;
    let setup = watch.elapsed();
    let mut made: Vec<TimedStep> = Vec::new();
    let mut before = setup;
    while (made.len() as u64) < steps.min(SETTLED)
        && (made.is_empty() || !is_over(&watch) || (made.len() < FEWEST && watch.elapsed() < LONG))
    {
        if !patience.step(&mut simulation)? {
            break;
        }
        let now = watch.elapsed();
        let seconds = (now - before).as_secs_f64();
        made.push(TimedStep::of(simulation.report(), seconds));
        before = now;
    }
    if made.is_empty() && steps > 0 {
        return Ok(None);
    }
    let left = steps - made.len() as u64;
    let later = if left > 0 {
        Later::of(scene, steps, simulation.linear_method(), patience)
    } else {
        Later::default()
    };
    let last = &made[made.len().saturating_sub(LAST)..];
    let a_step = last.iter().map(|step| match later.work {
        Some(work) => step.seconds_with(work),
        None => step.seconds,
    });
    let a_step = median(a_step, f64::total_cmp);
    let seconds: f64 = made.iter().map(|step| step.seconds).sum();
    let with_factor = has_factor(&simulation) || later.with_factor;
    Ok(Some(RunEstimate {
        steps,
        seconds: setup.as_secs_f64() + seconds + left as f64 * a_step,
        memory: memory_held(scene, with_factor),
    }))
}

/// What substep 2 of a step takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Work {
    /// Of Newton's method.
    pub(super) corrections: f64,
    /// Of Krylov's, in all of them.
    pub(super) iterations: f64,
}

impl Work {
    fn of(report: &Report) -> Self {
        Self {
            corrections: report.newton.into(),
            iterations: report.krylov.into(),
        }
    }
}

/// A step that was made, and what it took.
pub(super) struct TimedStep {
    /// Of the processor.
    pub(super) seconds: f64,
    pub(super) work: Work,
    /// On the clock: of its residuals, its linearisations, its Krylov iterations, and all of it.
    pub(super) parts: [f64; 4],
}

impl TimedStep {
    fn of(report: &Report, seconds: f64) -> Self {
        let part = |phase| report.costs.of(phase).as_secs_f64();
        let all = Phase::ALL.into_iter().map(part).sum();
        Self {
            seconds,
            work: Work::of(report),
            parts: [
                part(Phase::Residual),
                part(Phase::Linearisation),
                part(Phase::Krylov),
                all,
            ],
        }
    }

    /// What it would have taken with other work.
    pub(super) fn seconds_with(&self, work: Work) -> f64 {
        let had = self.work;
        let [residual, linearisation, iterations, all] = self.parts;
        if had.corrections == 0.0 || had.iterations == 0.0 || all == 0.0 {
            return self.seconds;
        }
        // There is a residual before the first correction.
        let change = residual * ((work.corrections + 1.0) / (had.corrections + 1.0) - 1.0)
            + linearisation * (work.corrections / had.corrections - 1.0)
            + iterations * (work.iterations / had.iterations - 1.0);
        self.seconds * (1.0 + change / all)
    }
}

/// What the steps of a run come to once the guesses are as good as they get.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Later {
    /// Where a coarse mesh can tell.
    pub(super) work: Option<Work>,
    /// Whether the sparse factor was in use on the way.
    pub(super) with_factor: bool,
}

impl Later {
    /// For a scene whose linear systems are solved by this method after its first steps. A coarse mesh on which the
    /// scene cannot be run tells nothing.
    pub(super) fn of(scene: &Scene, steps: u64, method: &str, patience: &mut Patience<'_>) -> Self {
        let linear = match method {
            "factor" => LinearMethod::Factor,
            "shifted" => LinearMethod::Shifted,
            _ => LinearMethod::Automatic,
        };
        let Some(coarse) = coarse(scene, linear) else {
            return Self::default();
        };
        let watch = Stopwatch::start();
        let Ok(mut simulation) = Simulation::new(&coarse) else {
            return Self::default();
        };
        let mut work = Vec::new();
        let mut with_factor = false;
        while work.is_empty()
            || ((work.len() as u64) < steps.min(SETTLED_COARSE) && !is_over(&watch))
        {
            match patience.step(&mut simulation) {
                Ok(true) => {}
                Ok(false) => break,
                Err(_) => return Self::default(),
            }
            work.push(Work::of(simulation.report()));
            with_factor |= has_factor(&simulation);
        }
        let last = &work[work.len().saturating_sub(LAST)..];
        let mean = |part: fn(&Work) -> f64| last.iter().map(part).sum::<f64>() / last.len() as f64;
        // Another method takes other iterations.
        let is_alike = simulation.linear_method() == method && !last.is_empty();
        Self {
            work: is_alike.then(|| Work {
                corrections: mean(|work| work.corrections),
                iterations: mean(|work| work.iterations),
            }),
            with_factor,
        }
    }
}
