//! What a run will cost, before it is begun.
//!
//! **Fixed steps.** The scene's own first steps are made for a second or two, until the guesses of the
//! iteration are as good as they get; the last of them tell what every further step takes.
//!
//! **Chosen steps.** What a step takes is measured on the scene's own mesh, with its first steps, by the cheapest
//! of them. How many there will be does not depend much on the mesh; so the scene is run to its end, or as far
//! as time permits, on a coarse one, and where that is coarser than its own, with a larger tolerance, from
//! which the number is extrapolated.
//!
//! **Memory** is what [`memory_held`] says, with the sparse factor where the calibration came to it.

use super::choice::can_change_mesh;
use super::clock::Stopwatch;
use crate::scene::{LinearMethod, Mesh, Scene};
use crate::simulation::{Schedule, Simulation, SimulationError, memory_held, step_count};
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
            s if s < 1.0 => f.write_str("a second")?,
            s if s < 120.0 => write!(f, "{s:.0} s")?,
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

/// After so many steps the guesses are as good as they get.
const SETTLED: u64 = 64;

/// The last steps of a calibration count.
const LAST: usize = 8;

/// It has so many steps at least, for the first ones are dearer than the others: up to the 35th of case 3
/// takes two iterations of Newton's method, every later one a single one,
const FEWEST: usize = 48;

/// unless they take longer than this.
const LONGEST: Duration = Duration::from_secs(5);

/// Cells of the coarse mesh: with fewer the physics is another one.
const COARSE_CELLS: usize = 48;

/// By how much the tolerance is larger there.
const LOOSER: f64 = 8.0;

/// The number of steps falls with the tolerance to this power over the order. In theory 1; with a larger
/// tolerance more steps are cut off at the times that must be met, or refused. What case 3 shows at 32, 48
/// and 60 cells with third order: 2.4 times the steps for an eighth of the tolerance.
const NUMBER_EXPONENT: f64 = 1.26;

/// A step so many times as long as the one before is as long as it may be: it does not depend on the
/// tolerance.
const FREE_GROWTH: f64 = 4.0;

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
    let mut times = Vec::new();
    let mut before = watch.elapsed();
    while (times.len() as u64) < steps.min(SETTLED)
        && (!is_over(&watch) || (times.len() < FEWEST && watch.elapsed() < LONGEST))
    {
        simulation.advance()?;
        let now = watch.elapsed();
        times.push((now - before).as_secs_f64());
        before = now;
    }
    let made: f64 = times.iter().sum();
    let last = &times[times.len().saturating_sub(LAST)..];
    let further = (steps - times.len() as u64) as f64 * middle(last);
    Ok(RunPrice {
        steps,
        seconds: setup.as_secs_f64() + made + further,
        memory: memory_held(scene, simulation.linear_method() == "factor"),
    })
}

fn chosen(scene: &Scene) -> Result<RunPrice, SimulationError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(scene)?;
    let setup = watch.elapsed();
    let mut times = Vec::new();
    let mut before = setup;
    while times.is_empty() || !is_over(&watch) {
        let report = simulation.report();
        if report.t >= scene.time.end {
            break;
        }
        simulation.advance()?;
        let now = watch.elapsed();
        times.push((now - before).as_secs_f64());
        before = now;
    }
    // While what is stiff dies away steps are dearer than those that follow, and that is some of the first.
    let a_step = times.iter().copied().fold(f64::INFINITY, f64::min);
    let is_done = simulation.report().t >= scene.time.end;
    let number = match is_done {
        true => Steps::of(times.len() as u64),
        false => Steps::foreseen(scene, 50.0 * a_step)?,
    };
    let made: f64 = times.iter().sum();
    let further = number.attempted.saturating_sub(times.len() as u64);
    Ok(RunPrice {
        steps: number.accepted,
        seconds: setup.as_secs_f64() + made + further as f64 * a_step,
        memory: memory_held(scene, simulation.linear_method() == "factor"),
    })
}

/// How many steps there will be.
#[derive(Debug, Clone, Copy)]
struct Steps {
    accepted: u64,
    /// With those that are refused.
    attempted: u64,
}

impl Steps {
    fn of(number: u64) -> Self {
        Self {
            accepted: number,
            attempted: number,
        }
    }

    /// For a scene whose run takes about so many seconds.
    fn foreseen(scene: &Scene, seconds: f64) -> Result<Self, SimulationError> {
        let coarse = coarse(scene);
        let limit = Duration::from_secs_f64(COARSE_SHARE * seconds)
            .max(CALIBRATION)
            .min(COARSE_LIMIT);
        let schedule = Schedule::new(&coarse.time, 1, 1);
        let watch = Stopwatch::start();
        let mut simulation = Simulation::new(&coarse)?;
        let (mut number, mut free, mut refused) = (0.0, 0.0, 0.0);
        let mut last = 0.0;
        let share = loop {
            let report = simulation.report();
            let share = schedule.share(report.step, report.t);
            let is_over = watch.elapsed() > limit || watch.wall() > PATIENCE;
            if share >= 1.0 || (is_over && last > 0.0) {
                break share;
            }
            let report = simulation.advance()?;
            number += 1.0;
            refused += f64::from(report.refused);
            if report.dt >= FREE_GROWTH * last {
                free += 1.0;
            }
            last = report.dt;
        };
        // A relaxation slows down, and its steps grow about as √t: that is what case 3 shows.
        let (t, end) = (simulation.report().t, scene.time.end);
        let missing = if share < 1.0 {
            2.0 * (end.sqrt() - t.sqrt()).max(0.0) * t.sqrt() / last
        } else {
            0.0
        };
        let growth = match (coarse.time.tolerance, scene.time.tolerance) {
            (Some(coarse), Some(own)) => {
                (coarse / own).powf(NUMBER_EXPONENT / scene.time.order.chains() as f64)
            }
            _ => 1.0,
        };
        let accepted = free + growth * (number - free + missing);
        // Refusals are the coarse mesh's own affair where there is a finer one.
        let attempted = if growth > 1.0 {
            accepted
        } else {
            accepted + refused
        };
        let whole = |number: f64| number.ceil() as u64;
        Ok(Self {
            accepted: whole(accepted),
            attempted: whole(attempted),
        })
    }
}

/// The scene as it is run to count its steps.
fn coarse(scene: &Scene) -> Scene {
    let mut coarse = scene.clone();
    let is_finer = match &scene.mesh {
        Mesh::Structured { cells, .. } => *cells > COARSE_CELLS,
        // Of the same square.
        Mesh::Delaunay { .. } => true,
        Mesh::File(_) => false,
    };
    if can_change_mesh(scene) && is_finer {
        coarse.mesh = Mesh::Structured {
            cells: COARSE_CELLS,
            jitter: 0.0,
            seed: 1,
        };
        coarse.solver.linear = LinearMethod::Automatic;
        coarse.time.tolerance = scene.time.tolerance.map(|tolerance| LOOSER * tolerance);
    }
    coarse
}

fn is_over(watch: &Stopwatch) -> bool {
    watch.elapsed() > CALIBRATION || watch.wall() > PATIENCE
}

/// The median: a step that was held up by something says nothing of the others.
fn middle(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
