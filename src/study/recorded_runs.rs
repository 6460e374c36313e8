//! Finished runs that take part in a study: read from their folders, not made again.

use super::discretisation::Discretisation;
use super::errors::Solution;
use super::measure::Measurement;
use crate::record::{CheckpointError, Found, LoadError, Resumption, load_run_scene};
use crate::scene::Scene;
use crate::simulation::{Simulation, SimulationError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A run that has come to its end.
#[derive(Debug)]
pub struct ComparedRun {
    /// Of its folder.
    pub(super) name: String,
    pub(super) choice: Discretisation,
    pub(super) measurement: Measurement,
    /// Whether it is the studied scene itself.
    pub(super) is_own: bool,
}

/// The finished runs of a study.
#[derive(Debug, Default)]
pub struct ComparedRuns {
    /// Those that are to be compared with the others.
    pub beside: Vec<ComparedRun>,
    /// The one that the errors are measured against, in place of a finer run.
    pub against: Option<ComparedRun>,
}

/// Why a run cannot take part.
#[derive(Debug, Error)]
pub enum ComparedRunError {
    /// It has no scene, or a wrong one.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// Its state is lost.
    #[error(transparent)]
    State(#[from] CheckpointError),
    /// There is no state.
    #[error("there is no run in {}", .path.display())]
    Nothing {
        /// The folder.
        path: PathBuf,
    },
    /// Its scene cannot be set up.
    #[error("{}: {source}", .path.display())]
    SetUp {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: SimulationError,
    },
    /// It is elsewhere than the study will be.
    #[error(
        "the run in {} is at t = {t:e}, but errors are measured at t = {end:e}: {}give --set time.end={t:e}",
        .path.display(),
        if t < end { format!("go on with it (`vesica run {} --resume`), or ", .path.display()) } else { String::new() }
    )]
    Elsewhere {
        /// The folder.
        path: PathBuf,
        /// Where the run is.
        t: f64,
        /// Where the studied scene ends.
        end: f64,
    },
    /// Its φ is a function of other coordinates.
    #[error(
        "the run in {} and the scene are not both planar or both by rotation (domain.geometry): their fields cannot be \
         compared",
        .path.display()
    )]
    OtherGeometry {
        /// The folder.
        path: PathBuf,
    },
}

impl ComparedRun {
    /// Reads a run of any scene that has come to where `scene` ends. Its time is what its steps and its
    /// set-up took on the clock when it was made.
    ///
    /// # Errors
    /// [`ComparedRunError`]: it cannot be read, or is elsewhere.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, ComparedRunError> {
        if !path.join("scene.toml").is_file() {
            let path = path.to_owned();
            return Err(ComparedRunError::Nothing { path });
        }
        let own = load_run_scene(path, &[])?.scene;
        if own.geometry != scene.geometry {
            let path = path.to_owned();
            return Err(ComparedRunError::OtherGeometry { path });
        }
        let Found::Run(resumption) = Resumption::find(path, &own)? else {
            let path = path.to_owned();
            return Err(ComparedRunError::Nothing { path });
        };
        let mut simulation = Simulation::new(&own).map_err(|source| ComparedRunError::SetUp {
            path: path.to_owned(),
            source,
        })?;
        let summary = resumption.look(&own, &mut simulation)?;
        let (t, end) = (simulation.report().t, scene.time.end);
        if (t - end).abs() > 1e-9 * end {
            let path = path.to_owned();
            return Err(ComparedRunError::Elsewhere { path, t, end });
        }
        let name = path.file_name().unwrap_or(path.as_os_str());
        Ok(Self {
            name: name.to_string_lossy().into_owned(),
            choice: Discretisation::of(&own),
            is_own: own == *scene,
            measurement: Measurement {
                seconds: summary.setup_seconds + summary.seconds,
                share: 1.0,
                memory: None,
                nodes: simulation.mesh().nodes().len(),
                steps: summary.steps,
                refused: summary.refused,
                newton: summary.newton,
                krylov: summary.krylov,
                underway: None,
                estimates: summary.errors,
                outcome: Ok(Solution::of(&simulation)),
            },
        })
    }
}
