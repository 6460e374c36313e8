//! Steps whose length is chosen. What a correction of Newton's method takes is measured on the scene's own mesh, with
//! its first steps. How many further ones there will be does not depend much on the mesh; so they are counted in a run
//! to the end, or as far as time permits, on a coarse one.

use super::{CALIBRATION, Patience, RunEstimate, coarse, has_factor, is_over};
use crate::record::Settings;
use crate::scene::{LinearMethod, Scene};
use crate::simulation::{Report, Schedule, Simulation, SimulationError, memory_held};
use crate::study::clock::{Stopwatch, median};
use std::time::Duration;

/// How many times more steps and corrections a finer mesh takes. At 120 cells cases 3 and 4 take 1.03 to 1.35 times the
/// corrections at 48, and 0.9 to 1.04 times the steps, with tolerances of 1e-2, 1e-3 and 3e-4 (`vesica run case3 --set
/// time.tolerance=…`: `newton` and `steps` in `run.json`).
const MORE_ON_A_FINER_MESH: f64 = 1.2;

/// A relaxation slows down, and its steps grow about as this power of the time: those of cases 3 and 4 do from t = 1e-5 on.
const GROWTH: f64 = 0.8;

/// The coarse run may take as long as so many corrections on the own mesh, of some 500 in a whole run,
const COARSE_CORRECTIONS: f64 = 25.0;

/// but at most this long.
const COARSE_LIMIT: Duration = Duration::from_secs(5);

/// What a run will take; `None` where no step was solved in time.
pub(super) fn price(
    scene: &Scene,
    patience: &mut Patience<'_>,
) -> Result<Option<RunEstimate>, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = recorded(scene)?;
    let setup = watch.elapsed();
    let end = scene.time.end;
    let mut a_correction = Vec::new();
    let mut made = 0.0;
    let mut before = setup;
    let mut last = None;
    while simulation.report().t < end && (a_correction.is_empty() || !is_over(&watch)) {
        if !patience.step(&mut simulation)? {
            break;
        }
        let step = Step::of(simulation.report());
        let now = watch.elapsed();
        let seconds = (now - before).as_secs_f64();
        a_correction.push(seconds / step.corrections.max(1.0));
        made += seconds;
        before = now;
        last = Some(step);
    }
    let Some(last) = last else {
        return Ok(None);
    };
    let a_correction = median(a_correction, f64::total_cmp);
    let steps = simulation.report().step;
    let memory = memory_held(scene, has_factor(&simulation));
    let further = if last.t < end {
        let limit = Duration::from_secs_f64(COARSE_CORRECTIONS * a_correction);
        let limit = limit.clamp(CALIBRATION, COARSE_LIMIT);
        let coarse = coarse(scene, LinearMethod::Automatic);
        // A coarse mesh on which the scene cannot be run tells nothing.
        let on_coarse = coarse.and_then(|coarse| {
            let simulation = recorded(&coarse).ok()?;
            Further::of(simulation, last, limit, patience).ok()
        });
        match on_coarse {
            Some(further) => further.on_a_finer_mesh(),
            None => Further::of(simulation, last, limit, patience)?,
        }
    } else {
        Further::default()
    };
    Ok(Some(RunEstimate {
        steps: steps + further.steps.ceil() as u64,
        seconds: setup.as_secs_f64() + made + further.corrections * a_correction,
        memory,
    }))
}

/// A step that was made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Its end.
    pub(super) t: f64,
    pub(super) dt: f64,
    pub(super) corrections: f64,
}

impl Step {
    pub(super) fn of(report: &Report) -> Self {
        Self {
            t: report.t,
            dt: report.dt,
            corrections: report.newton.into(),
        }
    }
}

/// A simulation whose chosen steps end where a run's snapshots are taken.
fn recorded(scene: &Scene) -> Result<Simulation, SimulationError> {
    let mut simulation = Simulation::new(scene)?;
    let Settings {
        every, snapshots, ..
    } = Settings::default();
    simulation.follow(&Schedule::new(&scene.time, every, snapshots));
    Ok(simulation)
}

/// What a run still takes from a time on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Further {
    pub(super) steps: f64,
    /// Of Newton's method, with those of refused steps.
    pub(super) corrections: f64,
}

impl Further {
    /// From the end of the step `made` on, as this simulation shows it, which may be another one.
    pub(super) fn of(
        mut simulation: Simulation,
        made: Step,
        limit: Duration,
        patience: &mut Patience<'_>,
    ) -> Result<Self, SimulationError> {
        let watch = Stopwatch::start();
        let end = simulation.scene().time.end;
        let mut further = Self::default();
        let mut last = None;
        while simulation.report().t < end {
            let is_over = last.is_some() && watch.elapsed() > limit;
            if is_over || !patience.step(&mut simulation)? {
                let Step { t, dt, corrections } = last.unwrap_or(made);
                let from = simulation.report().t.max(made.t);
                // The integral of 1/Δt.
                let power = |t: f64| t.powf(1.0 - GROWTH) / (1.0 - GROWTH);
                let steps = (power(end) - power(from)).max(0.0) * t.powf(GROWTH) / dt;
                further.steps += steps;
                further.corrections += steps * corrections;
                break;
            }
            let step = Step::of(simulation.report());
            if step.t > made.t {
                further.steps += 1.0;
                further.corrections += step.corrections;
            }
            last = Some(step);
        }
        Ok(further)
    }

    /// What it will be on a finer mesh than that of the simulation.
    fn on_a_finer_mesh(self) -> Self {
        Self {
            steps: MORE_ON_A_FINER_MESH * self.steps,
            corrections: MORE_ON_A_FINER_MESH * self.corrections,
        }
    }
}
