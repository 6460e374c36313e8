//! What a run will cost, before it is begun.
//!
//! **Fixed steps.** The scene's own first steps are made for a second or two, until the guesses of the
//! iteration are as good as they get; the last of them tell what every further step takes.
//!
//! **Chosen steps.** How many there will be does not depend much on the mesh, so the scene is run to its
//! end on a coarse one. What a step takes is measured on the scene's own mesh, with its first steps.
//!
//! **Memory** is what [`memory_held`] says, with the sparse factor where the calibration turned to it or
//! long chosen steps will.

use super::choice::{Choice, can_change_mesh};
use super::clock::Stopwatch;
use crate::scene::Scene;
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

/// It has so many steps at least, for the first ones are dearer than the others,
const FEWEST: usize = 20;

/// unless they take longer than this.
const LONGEST: Duration = Duration::from_secs(5);

/// Cells of the coarse mesh, as a part of the scene's.
const COARSER: usize = 4;

/// With fewer cells the physics is another one.
const FEWEST_CELLS: usize = 48;

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
    let own = Choice::of(scene);
    let cells = if can_change_mesh(scene) {
        (own.cells / COARSER).max(FEWEST_CELLS).min(own.cells)
    } else {
        own.cells
    };
    let coarse = Choice { cells, ..own }.applied_to(scene);
    let schedule = Schedule::new(&coarse.time, 1, 1);
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(&coarse)?;
    let mut steps = Vec::new();
    let mut attempts = 0_u64;
    let share = loop {
        let report = simulation.report();
        let share = schedule.share(report.step, report.t);
        if share >= 1.0 || (is_over(&watch) && !steps.is_empty()) {
            break share;
        }
        let report = simulation.advance()?;
        steps.push(report.dt);
        attempts += 1 + u64::from(report.refused);
    };
    // A relaxation slows down, and its steps grow about as √t: that is what case 3 shows.
    let (t, end) = (simulation.report().t, scene.time.end);
    let missing = match steps.last() {
        Some(last) if share < 1.0 => {
            (2.0 * (end.sqrt() - t.sqrt()).max(0.0) * t.sqrt() / last).ceil() as u64
        }
        _ => 0,
    };
    let number = steps.len() as u64 + missing;
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
    let made: f64 = times.iter().sum();
    let further = (attempts + missing).saturating_sub(times.len() as u64);
    // The first steps are dearer than the others.
    let a_step = middle(&times[times.len() / 2..]);
    Ok(RunPrice {
        steps: number,
        seconds: setup.as_secs_f64() + made + further as f64 * a_step,
        memory: memory_held(scene, true),
    })
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
