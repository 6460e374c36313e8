//! What a run will cost, before it is begun.
//!
//! **Fixed steps.** The scene's own first steps are made for a second or two. Later ones are cheaper, for their guesses
//! are better: by how much is told by the iterations that steps on a coarse mesh come down to.
//!
//! **Chosen steps.** What a correction of Newton's method takes is measured on the scene's own mesh, with its
//! first steps. How many further ones there will be does not depend much on the mesh; so they are counted in a
//! run to the end, or as far as time permits, on a coarse one.
//!
//! **Memory** is what [`memory_held`] says, with the sparse factor where the calibration came to it.

use super::choice::can_change_mesh;
use super::clock::Stopwatch;
use crate::record::Settings;
use crate::scene::{LinearMethod, Mesh, Scene};
use crate::simulation::{
    Phase, Report, Schedule, Simulation, SimulationError, memory_held, step_count,
};
use std::fmt;
use std::time::Duration;

/// What a run will take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunPrice {
    /// Steps, known or estimated.
    pub steps: u64,
    /// Computing time of all of them, with set-up, in seconds.
    pub seconds: f64,
    /// Memory, in bytes.
    pub memory: u64,
}

impl fmt::Display for RunPrice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("about ")?;
        match self.seconds {
            s if s < 9.5 => write!(f, "{s:.1} s")?,
            s if s < 600.0 => write!(f, "{s:.0} s")?,
            s if s < 7200.0 => write!(f, "{:.0} min", s / 60.0)?,
            s => write!(f, "{:.1} h", s / 3600.0)?,
        }
        let megabytes = self.memory as f64 / 1e6;
        write!(f, " and {megabytes:.0} MB, {} steps", self.steps)
    }
}

/// A calibration takes about so much computing,
const CALIBRATION: Duration = Duration::from_millis(1500);

/// and no longer than this where the machine is busy with other things.
const PATIENCE: Duration = Duration::from_secs(15);

/// Steps that are made at most on the own mesh.
const SETTLED: u64 = 64;

/// After so many steps the guesses are as good as they get: those of `circle` from the 130th on.
const SETTLED_COARSE: u64 = 256;

/// The last steps of a calibration count.
const LAST: usize = 8;

/// It has so many steps at least, for the first ones are dearer than the others: up to the 35th of case 3
/// takes two iterations of Newton's method, every later one a single one,
const FEWEST: usize = 48;

/// unless they take longer than this.
const LONGEST: Duration = Duration::from_secs(5);

/// Cells of the coarse mesh: with fewer the physics is another one.
const COARSE_CELLS: usize = 48;

/// How many times more steps and corrections a finer mesh takes. Case 3 at 120 cells takes 1.31, 1.33, 1.19 and 1.07
/// times the corrections at 48 with tolerances of 1e-2, 1e-3, 1.5e-4 and 7e-5, case 4 at 90 cells 1.41 times with 1e-3,
/// and 1.22, 1.26, 1.06, 1.09 and 0.95 times the steps (`vesica run case3 --set time.tolerance=…`: `newton` and `steps`
/// in `run.json`).
const MORE_ON_A_FINER_MESH: f64 = 1.2;

/// Corrections of Newton's method in a run with chosen steps, about.
const USUAL_CORRECTIONS: f64 = 500.0;

/// The coarse run may take this part of what the whole is expected to,
const COARSE_SHARE: f64 = 0.05;

/// but at most this long.
const COARSE_LIMIT: Duration = Duration::from_secs(5);

/// What a run of the scene will take on this machine. Takes a second or two, and longer only where a
/// single step does.
///
/// # Errors
/// [`SimulationError`]: the scene cannot be set up, or its first steps fail.
pub fn run_price(scene: &Scene) -> Result<RunPrice, SimulationError> {
    match step_count(&scene.time) {
        Some(steps) => fixed(scene, steps),
        None => chosen(scene),
    }
}

fn fixed(scene: &Scene, steps: u64) -> Result<RunPrice, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(scene)?;
    let setup = watch.elapsed();
    let mut made: Vec<Made> = Vec::new();
    let mut before = setup;
    while (made.len() as u64) < steps.min(SETTLED)
        && (!is_over(&watch) || (made.len() < FEWEST && watch.elapsed() < LONGEST))
    {
        let report = simulation.advance()?;
        let now = watch.elapsed();
        made.push(Made::of(report, (now - before).as_secs_f64()));
        before = now;
    }
    let left = steps - made.len() as u64;
    let last = &made[made.len().saturating_sub(LAST)..];
    let a_step = match coarse(scene) {
        Some(coarse) if left > 0 => {
            let work = later_work(&coarse, steps)?;
            middle(last.iter().map(|made| made.with(work)))
        }
        _ => middle(last.iter().map(|made| made.seconds)),
    };
    let seconds: f64 = made.iter().map(|made| made.seconds).sum();
    Ok(RunPrice {
        steps,
        seconds: setup.as_secs_f64() + seconds + left as f64 * a_step,
        memory: memory_held(scene, simulation.linear_method() == "factor"),
    })
}

/// Corrections of Newton's method and Krylov iterations of a step.
type StepWork = [f64; 2];

fn work_of(report: &Report) -> StepWork {
    [report.newton, report.krylov].map(f64::from)
}

/// What a step that was made took.
struct Made {
    seconds: f64,
    work: StepWork,
    /// On the clock: of its residuals, its linearisations, its Krylov iterations, and all of it.
    parts: [f64; 4],
}

impl Made {
    fn of(report: &Report, seconds: f64) -> Self {
        let part = |phase| report.costs.of(phase).as_secs_f64();
        let all = Phase::ALL.into_iter().map(part).sum();
        Self {
            seconds,
            work: work_of(report),
            parts: [
                part(Phase::Residual),
                part(Phase::Linearisation),
                part(Phase::Krylov),
                all,
            ],
        }
    }

    /// What a step with other work would take.
    fn with(&self, [newton, krylov]: StepWork) -> f64 {
        let [had_newton, had_krylov] = self.work;
        let [residual, linearisation, iterations, all] = self.parts;
        if had_newton == 0.0 || had_krylov == 0.0 || all == 0.0 {
            return self.seconds;
        }
        // There is a residual before the first correction.
        let change = residual * ((newton + 1.0) / (had_newton + 1.0) - 1.0)
            + linearisation * (newton / had_newton - 1.0)
            + iterations * (krylov / had_krylov - 1.0);
        self.seconds * (1.0 + change / all)
    }
}

/// The work of a step once the guesses are as good as they get, as a coarse mesh shows it.
fn later_work(coarse: &Scene, steps: u64) -> Result<StepWork, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(coarse)?;
    let mut work = Vec::new();
    while (work.len() as u64) < steps.min(SETTLED_COARSE) && !is_over(&watch) {
        work.push(work_of(simulation.advance()?));
    }
    let last = &work[work.len().saturating_sub(LAST)..];
    Ok([0, 1].map(|kind| last.iter().map(|work| work[kind]).sum::<f64>() / last.len() as f64))
}

fn chosen(scene: &Scene) -> Result<RunPrice, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = recorded(scene)?;
    let setup = watch.elapsed();
    let end = scene.time.end;
    let mut times = Vec::new();
    let mut made = 0.0;
    let mut before = setup;
    while simulation.report().t < end && (times.is_empty() || !is_over(&watch)) {
        let newton = f64::from(simulation.advance()?.newton);
        let now = watch.elapsed();
        let time = (now - before).as_secs_f64();
        times.push(time / newton.max(1.0));
        made += time;
        before = now;
    }
    let a_correction = middle(times.into_iter());
    let report = simulation.report();
    let (steps, t) = (report.step, report.t);
    let memory = memory_held(scene, simulation.linear_method() == "factor");
    let further = if t < end {
        let limit = COARSE_SHARE * a_correction * USUAL_CORRECTIONS;
        let limit = Duration::from_secs_f64(limit).clamp(CALIBRATION, COARSE_LIMIT);
        match coarse(scene) {
            Some(coarse) => Further::of(recorded(&coarse)?, t, limit)?.on_a_finer_mesh(),
            None => Further::of(simulation, t, limit)?,
        }
    } else {
        Further::default()
    };
    Ok(RunPrice {
        steps: steps + further.steps.ceil() as u64,
        seconds: setup.as_secs_f64() + made + further.corrections * a_correction,
        memory,
    })
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
struct Further {
    steps: f64,
    /// Of Newton's method, with those of refused steps.
    corrections: f64,
}

impl Further {
    /// From the time `from` on, as this simulation shows it.
    fn of(mut simulation: Simulation, from: f64, limit: Duration) -> Result<Self, SimulationError> {
        let watch = Stopwatch::start();
        let end = simulation.scene().time.end;
        let mut further = Self::default();
        let (mut t, mut last) = (simulation.report().t, None);
        while t < end {
            let is_over = watch.elapsed() > limit || watch.wall() > PATIENCE;
            if let Some((dt, corrections)) = last.filter(|_| is_over) {
                // A relaxation slows down, and its steps grow about as √t: that is what case 3 shows.
                let steps = 2.0 * (end.sqrt() - t.max(from).sqrt()).max(0.0) * t.sqrt() / dt;
                further.steps += steps;
                further.corrections += steps * corrections;
                break;
            }
            let report = simulation.advance()?;
            t = report.t;
            let corrections = f64::from(report.newton);
            if t > from {
                further.steps += 1.0;
                further.corrections += corrections;
            }
            last = Some((report.dt, corrections));
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

/// The scene on a coarser mesh, where it is not as coarse itself.
fn coarse(scene: &Scene) -> Option<Scene> {
    let is_finer = match &scene.mesh {
        Mesh::Structured { cells, .. } => *cells > COARSE_CELLS,
        // Of the same square.
        Mesh::Delaunay { .. } => true,
        Mesh::File(_) => false,
    };
    (can_change_mesh(scene) && is_finer).then(|| {
        let mut coarse = scene.clone();
        coarse.mesh = Mesh::Structured {
            cells: COARSE_CELLS,
            jitter: 0.0,
            seed: 1,
        };
        coarse.solver.linear = LinearMethod::Automatic;
        coarse
    })
}

fn is_over(watch: &Stopwatch) -> bool {
    watch.elapsed() > CALIBRATION || watch.wall() > PATIENCE
}

/// The median: a step that was held up by something says nothing of the others.
fn middle(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_run_still_takes_is_counted_from_where_it_stands() {
        let text = "
            mesh.cells = 16
            vesicle = { shape = 'ellipse', half_axes = [0.3, 0.2], angle = 70 }
            time = { tolerance = 1e-3, end = 1e-4 }
            membrane.interface_width = 0.08
            area.target = 1.1
        ";
        let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        let scene = Scene::parse(text, "the test", &[], &mut no_files).expect("a scene");
        assert_eq!(coarse(&scene), None, "it is coarse itself");
        let new = || Simulation::new(&scene).expect("a simulation");
        let mut whole = new();
        let mut steps = Vec::new();
        while whole.report().t < scene.time.end {
            let report = whole.advance().expect("a step");
            steps.push((report.t, f64::from(report.newton)));
        }
        let (from, _) = steps[2];
        let rest = &steps[3..];
        let all = Further::of(new(), from, Duration::MAX).expect("solved");
        assert_eq!(all.steps, rest.len() as f64);
        let corrections: f64 = rest.iter().map(|(_, newton)| newton).sum();
        assert_eq!(all.corrections, corrections);
        let begun = |steps: usize| {
            let mut simulation = new();
            for _ in 0..steps {
                simulation.advance().expect("a step");
            }
            simulation
        };
        let more = Further::of(begun(3), from, Duration::MAX).expect("solved");
        assert_eq!((more.steps, more.corrections), (all.steps, all.corrections));
        // Without time the rest is extrapolated.
        let cut = Further::of(begun(steps.len() / 2), from, Duration::ZERO).expect("solved");
        let left = (steps.len() - steps.len() / 2) as f64;
        assert!(
            cut.steps > 0.3 * left && cut.steps < 3.0 * left,
            "{cut:?} {left}"
        );
    }

    #[test]
    fn seconds_are_told_to_two_digits() {
        let told = |seconds: f64| {
            let price = RunPrice {
                steps: 7,
                seconds,
                memory: 50_000_000,
            };
            price.to_string()
        };
        assert_eq!(told(0.34), "about 0.3 s and 50 MB, 7 steps");
        assert_eq!(told(1.43), "about 1.4 s and 50 MB, 7 steps");
        assert_eq!(told(11.6), "about 12 s and 50 MB, 7 steps");
        assert_eq!(told(900.0), "about 15 min and 50 MB, 7 steps");
    }

    #[test]
    fn a_later_step_is_cheaper_by_the_work_that_it_does_not_do() {
        let made = Made {
            seconds: 2.0,
            work: [2.0, 20.0],
            // Half of the time on the clock was somebody else's; a fifth of it is for other parts.
            parts: [0.6, 0.6, 2.0, 4.0],
        };
        assert_eq!(made.with([2.0, 20.0]), 2.0);
        // A residual of three, a linearisation of two, and half of the iterations less.
        let wanted = 2.0 * (1.0 - (0.2 + 0.3 + 1.0) / 4.0);
        assert!((made.with([1.0, 10.0]) - wanted).abs() < 1e-12);
    }
}
