//! The same scene, finer: the runs that the error of a run is measured against.

use super::clock::Stopwatch;
use super::discretisation::{fixed_mesh, scale_mesh};
use super::measured_error::Sample;
use crate::record::{FinerRun, ShortNumber};
use crate::scene::{Scene, Time, TimeScheme};
use crate::simulation::{Schedule, Simulation, SimulationError};

/// The tolerance of the finer run of a scene whose steps have one length, times f²: at f = 2 the steps' error is a few
/// hundredths of the mesh's on the paper's grid (docs/guide/accuracy.md). Chosen steps take a small part of the time
/// that fixed ones take.
const OF_FIXED_STEPS: f64 = 1.2e-3;

/// The same scene twice more: finer by a factor f in the mesh and by f² in the error of the steps, and half way between,
/// by √f and f. Both errors are of second order in f, so that the distances of the three runs show the order.
#[derive(Debug, Clone, PartialEq)]
pub struct FinerRuns {
    factor: f64,
    scenes: [Scene; 2],
    same_mesh: Option<String>,
}

/// What a finer run reports.
#[derive(Debug)]
pub enum FinerNews<'a> {
    /// How much is done of the two runs together, from 0 to 1.
    Share(f64),
    /// A state at one of the times: the number of the run, 0 for the one between, and that of the time.
    Sample(usize, usize, &'a Simulation),
}

impl FinerRuns {
    /// How much finer, unless the user says otherwise.
    pub const FACTOR: f64 = 2.0;

    /// What a user may ask for: less shows no difference, more has no end.
    pub const FACTORS: [f64; 2] = [1.5, 8.0];

    /// The finer runs of a scene.
    pub fn of(scene: &Scene, factor: f64) -> Self {
        let same_mesh = fixed_mesh(scene);
        let finer = |factor: f64| {
            let mut finer = scene.clone();
            if same_mesh.is_none() {
                scale_mesh(&mut finer.mesh, factor.recip());
            }
            let (tolerance, scheme) = match scene.time.tolerance {
                Some(tolerance) => (tolerance, scene.time.scheme),
                None => (OF_FIXED_STEPS, TimeScheme::Secant),
            };
            finer.time = Time {
                tolerance: Some(tolerance / (factor * factor)),
                scheme,
                ..finer.time
            };
            finer
        };
        Self {
            factor,
            scenes: [finer(factor.sqrt()), finer(factor)],
            same_mesh,
        }
    }

    /// f.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// The scenes: half way between, and finer.
    pub fn scenes(&self) -> &[Scene; 2] {
        &self.scenes
    }

    /// Why the mesh is the same, so that the error of the steps alone is measured; `None`: it is finer.
    pub fn same_mesh(&self) -> Option<&str> {
        self.same_mesh.as_deref()
    }

    /// How much finer, in words.
    pub fn words(&self) -> String {
        let factor = ShortNumber(self.factor);
        match &self.same_mesh {
            None => format!("{factor} times finer in mesh and steps"),
            Some(reason) => format!(
                "{factor} times finer in steps; the mesh is the same, for {reason}, and its error is not measured"
            ),
        }
    }

    /// Computes both runs, the one between first. Both meet all of `times`, which rise. `take` gets the states and says
    /// whether to go on.
    ///
    /// `None`: it was ended.
    ///
    /// # Errors
    /// [`SimulationError`]: one of the runs cannot be set up or continued.
    pub fn compute(
        &self,
        times: &[f64],
        take: &mut dyn FnMut(FinerNews<'_>) -> bool,
    ) -> Result<Option<[FinerRun; 2]>, SimulationError> {
        // By the time that they are expected to take: nodes and steps.
        let work = |factor: f64| factor.powi(if self.same_mesh.is_some() { 1 } else { 3 });
        let works = [work(self.factor.sqrt()), work(self.factor)];
        let mut begun = 0.0;
        let mut runs = Vec::with_capacity(2);
        for (index, scene) in self.scenes.iter().enumerate() {
            let part = works[index] / (works[0] + works[1]);
            let factor = [self.factor.sqrt(), self.factor][index];
            let mut tell = |news: FinerNews<'_>| match news {
                FinerNews::Share(share) => take(FinerNews::Share(begun + part * share)),
                FinerNews::Sample(_, time, state) => take(FinerNews::Sample(index, time, state)),
            };
            match run(scene, factor, times, &mut tell)? {
                None => return Ok(None),
                Some(run) => runs.push(run),
            }
            begun += part;
        }
        Ok(runs.try_into().ok())
    }
}

/// Computes one of them.
fn run(
    scene: &Scene,
    factor: f64,
    times: &[f64],
    take: &mut dyn FnMut(FinerNews<'_>) -> bool,
) -> Result<Option<FinerRun>, SimulationError> {
    let watch = Stopwatch::start();
    let simulation = Simulation::new_unless(scene, &mut |_| !take(FinerNews::Share(0.0)));
    let mut simulation = match simulation {
        Err(SimulationError::Ended) => return Ok(None),
        result => result?,
    };
    let end = times.last().copied().unwrap_or(0.0);
    for (index, &time) in times.iter().enumerate() {
        let is_there = advance_to(&mut simulation, time, end, take)?;
        if !is_there || !take(FinerNews::Sample(0, index, &simulation)) {
            return Ok(None);
        }
    }
    Ok(Some(FinerRun {
        factor,
        nodes: simulation.mesh().nodes().len(),
        tolerance: scene.time.tolerance,
        steps: simulation.report().step,
        seconds: watch.elapsed().as_secs_f64(),
    }))
}

/// Advances to exactly this time; returns whether it is there, and was not ended before.
fn advance_to(
    simulation: &mut Simulation,
    time: f64,
    end: f64,
    take: &mut dyn FnMut(FinerNews<'_>) -> bool,
) -> Result<bool, SimulationError> {
    let until = Time {
        end: time,
        ..simulation.scene().time
    };
    let schedule = Schedule::new(&until, 1, 1);
    simulation.follow(&schedule);
    loop {
        let report = simulation.report();
        if report.t >= time {
            return Ok(true);
        }
        let share = (report.t / end).clamp(0.0, 1.0);
        if !take(FinerNews::Share(share)) {
            return Ok(false);
        }
        let mut is_ended = false;
        simulation.advance_unless(&mut |_| {
            is_ended |= !take(FinerNews::Share(share));
            is_ended
        })?;
        simulation.drain_events();
        if is_ended {
            return Ok(false);
        }
    }
}

impl Sample {
    /// The state of a simulation.
    pub fn of(simulation: &Simulation) -> Self {
        Self::new(simulation.mesh(), simulation.state(), simulation.report())
    }
}
