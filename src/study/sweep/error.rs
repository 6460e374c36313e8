//! Why a sweep is refused.

use super::plan::Assignment;
use crate::record::{LoadError, RecordError};
use crate::scene::SceneError;
use crate::simulation::SimulationError;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Errors of points that are shown one by one.
const SHOWN: usize = 5;

/// Why a sweep is refused.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The plan cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// The plan is wrong.
    #[error(transparent)]
    Plan(#[from] SceneError),
    /// Its scene cannot be had.
    #[error("the plan's scene: {0}")]
    Scene(#[from] LoadError),
    /// Points are wrong.
    #[error("{}", wrong_points(errors, *points))]
    Points {
        /// What is wrong with each.
        errors: Vec<PointError>,
        /// How many points there are in all.
        points: usize,
    },
    /// The folder holds a sweep.
    #[error(
        "{0} holds a sweep already: --resume continues it; or give another folder with --out",
        folder.display()
    )]
    Occupied {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder holds no sweep.
    #[error("{} holds no sweep: it has no sweep.json", folder.display())]
    NoSweep {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder's sweep is of another plan.
    #[error(
        "the sweep in {} has other points ({difference}): the plan, its scene or the version of vesica has \
         changed. Give another folder with --out",
        folder.display()
    )]
    Changed {
        /// The folder.
        folder: PathBuf,
        /// A difference.
        difference: String,
    },
    /// A file is where a folder is to be.
    #[error(
        "{} is a file, where a folder of the sweep is to be: remove it or give it another name, and then: vesica sweep {} \
         --resume",
        path.display(),
        folder.display()
    )]
    NotAFolder {
        /// The file.
        path: PathBuf,
        /// The sweep's folder.
        folder: PathBuf,
    },
    /// sweep.json is damaged.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: serde_json::Error,
    },
    /// There is no such point.
    #[error("the sweep in {} has no point '{name}'; it has {points}, from {first} to {last}", folder.display())]
    NoPoint {
        /// The folder.
        folder: PathBuf,
        /// What was asked for.
        name: String,
        /// How many there are.
        points: usize,
        /// The name of the first.
        first: String,
        /// The name of the last.
        last: String,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// What is wrong with a point.
#[derive(Debug, thiserror::Error)]
#[error("point {number} ({}): {reason}", Values(values))]
pub struct PointError {
    /// Which point, from 1.
    pub number: usize,
    /// Its values.
    pub values: Vec<Assignment>,
    /// Why.
    #[source]
    pub reason: PointProblem,
}

/// Why a point cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum PointProblem {
    /// Its scene is wrong.
    #[error(transparent)]
    Scene(SceneError),
    /// It would make no step.
    #[error(
        "the end, t = {end:e}, comes before the first step of length {step:e}: raise time.end, or lower time.step"
    )]
    NoStep {
        /// T.
        end: f64,
        /// Δt.
        step: f64,
    },
    /// It cannot be set up.
    #[error(transparent)]
    SetUp(SimulationError),
}

/// Assignments in words.
pub struct Values<'a>(pub &'a [Assignment]);

impl fmt::Display for Values<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("the scene as it is");
        }
        for (number, Assignment { key, value }) in self.0.iter().enumerate() {
            let comma = if number == 0 { "" } else { ", " };
            write!(f, "{comma}{key} = {value}")?;
        }
        Ok(())
    }
}

fn wrong_points(errors: &[PointError], points: usize) -> String {
    // Repetitions of a point whose seeds are not known have the same values, and the same is wrong with them.
    let same = errors.chunk_by(|one, next| one.values == next.values);
    let mut text = String::new();
    let mut shown = 0;
    for same in same.take(SHOWN) {
        shown += same.len();
        if let Some(error) = same.first() {
            text += &format!("{error}\n");
        }
    }
    if errors.len() > shown {
        text += &format!("… and {} more\n", errors.len() - shown);
    }
    text + &format!(
        "{} of {points} points cannot be run; nothing was started",
        errors.len()
    )
}
