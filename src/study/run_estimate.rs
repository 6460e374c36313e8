//! What a run will cost, before it is begun.
//!
//! The scene's own first steps are made for a second or two. What they do not show is found by a run on a coarse mesh:
//! how many iterations later steps take ([`fixed`] steps), and how many steps there will be ([`chosen`] ones). A step
//! that is hard is left in its midst when the time is over, or whoever asked has gone.
//!
//! **Memory** is what [`memory_held`](crate::simulation::memory_held) says, with the sparse factor where one of the runs
//! came to it.

mod chosen;
mod fixed;
mod patience;
#[cfg(test)]
mod tests;

use super::clock::Stopwatch;
use super::discretisation::fixed_mesh;
use super::measure::{is_hopeless, is_stuck};
use crate::scene::{LinearMethod, Mesh, Scene};
use crate::simulation::{Simulation, SimulationError, StepProgress, node_count, step_count};
use patience::Patience;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// What the first steps of a scene tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Foresight {
    /// The mesh is too large for steps in passing: it has about so many nodes.
    TooLarge(usize),
    /// A step was solved: what the run will take.
    Price(RunEstimate),
    /// No step was solved in the time.
    Unsolved(Unsolved),
    /// Whoever asked did not want to wait.
    Ended,
}

/// A first step that was not solved in the time that there was for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unsolved {
    /// How long it was tried, in seconds.
    pub seconds: f64,
    /// Where it stood; `None`: before its second attempt.
    pub underway: Option<StepProgress>,
}

impl Unsolved {
    /// Whether no part of the step was solved, though it was tried.
    pub fn is_stuck(&self) -> bool {
        self.underway.as_ref().is_some_and(is_stuck)
    }

    /// Whether it was tried so often that it will not be.
    pub fn is_hopeless(&self) -> bool {
        self.underway.as_ref().is_some_and(is_hopeless)
    }
}

impl fmt::Display for Unsolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the first step was not solved in {:.0} s", self.seconds)?;
        if let Some(underway) = &self.underway {
            let StepProgress {
                t,
                end,
                dt,
                parts,
                refused,
                ..
            } = underway;
            write!(
                f,
                ": it is at t = {t:.2e} of {end:.2e}, after {parts} parts and {refused} attempts that failed, \
                 with \u{394}t = {dt:.1e} next"
            )?;
        }
        Ok(())
    }
}

/// What a run will take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunEstimate {
    /// Steps, known or estimated.
    pub steps: u64,
    /// Computing time of all of them, with set-up, in seconds.
    pub seconds: f64,
    /// Memory, in bytes.
    pub memory: u64,
}

impl fmt::Display for RunEstimate {
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

/// and all of it no longer than this where a step is hard, or the machine is busy with other things.
pub(super) const LONGEST: Duration = Duration::from_secs(10);

/// A set-up or a single attempt at a step that takes so much longer still is not waited for.
const GRACE: Duration = Duration::from_secs(2);

/// Whoever asked is asked so often whether to go on.
const PAUSE: Duration = Duration::from_millis(20);

/// Cells of the coarse mesh: with fewer the physics is another one.
const COARSE_CELLS: usize = 48;

/// Steps are tried on meshes of up to so many nodes: a set-up and a step then take a second or two.
pub const MOST_NODES: usize = 60_000;

/// What a run of the scene will take on this machine. Takes a second or two, and at most some ten where a
/// step is hard: it is measured on a thread of its own, for a single attempt at a step cannot be left. `go_on`
/// is asked all the time whether to.
///
/// # Errors
/// [`SimulationError`]: the scene cannot be set up, or one of its first steps fails.
pub fn run_estimate(
    scene: &Scene,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Foresight, SimulationError> {
    run_price_within(scene, LONGEST, go_on)
}

/// [`run_estimate`] in so much time at most, but for the attempt at a step in hand.
///
/// # Errors
/// Those of [`run_estimate`].
pub(super) fn run_price_within(
    scene: &Scene,
    limit: Duration,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Foresight, SimulationError> {
    // The cast saturates.
    let nodes = node_count(scene) as usize;
    if nodes > MOST_NODES {
        return Ok(Foresight::TooLarge(nodes));
    }
    let begun = Instant::now();
    let is_wanted = Arc::new(AtomicBool::new(true));
    let (tell, told) = mpsc::channel();
    let thread = {
        let (scene, is_wanted) = (scene.clone(), Arc::clone(&is_wanted));
        let is_wanted = move || is_wanted.load(Ordering::Relaxed);
        let name = "price".to_owned();
        thread::Builder::new().name(name).spawn(move || {
            // If it took too long there is nobody who hears it.
            let _ = tell.send(calibrate(&scene, limit, &mut || is_wanted()));
        })
    };
    let Ok(thread) = thread else {
        // Here, then: where a single attempt at a step takes long, so does this.
        return calibrate(scene, limit, go_on);
    };
    let foresight = loop {
        if !go_on() {
            break Foresight::Ended;
        }
        match told.recv_timeout(PAUSE) {
            Ok(foresight) => return foresight,
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => break Foresight::Ended,
            },
            Err(RecvTimeoutError::Timeout) if begun.elapsed() > limit + GRACE => {
                break Foresight::Unsolved(Unsolved {
                    seconds: begun.elapsed().as_secs_f64(),
                    underway: None,
                });
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
    };
    // The thread ends with the attempt at a step that it is in, or with the process.
    is_wanted.store(false, Ordering::Relaxed);
    Ok(foresight)
}

/// Makes the first steps, and what else tells of a run's price.
fn calibrate(
    scene: &Scene,
    limit: Duration,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Foresight, SimulationError> {
    let mut patience = Patience::new(limit, go_on);
    let price = match step_count(&scene.time) {
        Some(steps) => fixed::price(scene, steps, &mut patience)?,
        None => chosen::price(scene, &mut patience)?,
    };
    Ok(match price {
        _ if patience.is_ended() => Foresight::Ended,
        Some(price) => Foresight::Price(price),
        None => Foresight::Unsolved(patience.unsolved()),
    })
}

/// The scene on a coarser mesh, where it is not as coarse itself.
fn coarse(scene: &Scene, linear: LinearMethod) -> Option<Scene> {
    let is_finer = match &scene.mesh {
        Mesh::Structured { cells, .. } => *cells > COARSE_CELLS,
        // Of the same square.
        Mesh::Delaunay { .. } | Mesh::Adaptive { .. } => true,
        Mesh::File(_) => false,
    };
    (fixed_mesh(scene).is_none() && is_finer).then(|| {
        let mut coarse = scene.clone();
        coarse.mesh = Mesh::Structured {
            cells: COARSE_CELLS,
            jitter: 0.0,
            seed: 1,
        };
        coarse.solver.linear = linear;
        coarse
    })
}

fn has_factor(simulation: &Simulation) -> bool {
    simulation.linear_method() == "factor"
}

fn is_over(watch: &Stopwatch) -> bool {
    watch.elapsed() > CALIBRATION
}
