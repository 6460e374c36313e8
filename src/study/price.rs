//! What a run will cost, before it is begun.
//!
//! The scene's own first steps are made for a second or two. What they do not tell is told by a run on a coarse mesh:
//! how many iterations later steps take ([`fixed`] steps), and how many steps there will be ([`chosen`] ones).
//!
//! **Memory** is what [`memory_held`](crate::simulation::memory_held) says, with the sparse factor where one of the runs
//! came to it.

mod chosen;
mod fixed;
#[cfg(test)]
mod tests;

use super::choice::fixed_mesh;
use super::clock::Stopwatch;
use crate::scene::{LinearMethod, Mesh, Scene};
use crate::simulation::{Simulation, SimulationError, step_count};
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

/// Cells of the coarse mesh: with fewer the physics is another one.
const COARSE_CELLS: usize = 48;

/// What a run of the scene will take on this machine. Takes a second or two, and longer only where a
/// single step does.
///
/// # Errors
/// [`SimulationError`]: the scene cannot be set up, or its first steps fail.
pub fn run_price(scene: &Scene) -> Result<RunPrice, SimulationError> {
    match step_count(&scene.time) {
        Some(steps) => fixed::price(scene, steps),
        None => chosen::price(scene),
    }
}

/// The scene on a coarser mesh, where it is not as coarse itself.
fn coarse(scene: &Scene, linear: LinearMethod) -> Option<Scene> {
    let is_finer = match &scene.mesh {
        Mesh::Structured { cells, .. } => *cells > COARSE_CELLS,
        // Of the same square.
        Mesh::Delaunay { .. } => true,
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
    watch.elapsed() > CALIBRATION || watch.wall() > PATIENCE
}

/// The median: a step that was held up by something says nothing of the others.
fn middle(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
