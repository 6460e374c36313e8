//! Why a run cannot start or continue.

use thiserror::Error;

use super::claim::Shortage;
use super::presence::NoVesicle;
use super::step_effort::Tried;
use crate::fem::FemError;
use crate::linalg::LinalgError;
use crate::scene::SceneError;
use crate::scheme::{InitialError, RestoreError, StepError, TransferError};

/// Why a run cannot start or continue.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// The run would need more memory than there is.
    #[error("a mesh {mesh} would need {shortage}: {remedy}")]
    Memory {
        /// How large the mesh is, in words.
        mesh: String,
        /// What it needs, and what there is.
        shortage: Shortage,
        /// What can be done.
        remedy: &'static str,
    },
    /// The set-up was ended by its caller.
    #[error("the set-up was ended")]
    Ended,
    /// The mesh cannot be made.
    #[error("the mesh: {0}")]
    Mesh(#[source] FemError),
    /// The initial fields cannot be made.
    #[error("the initial state: {0}")]
    Initial(#[from] InitialError),
    /// There is no vesicle to simulate.
    #[error(transparent)]
    NoVesicle(#[from] NoVesicle),
    /// The initial state has values that are not finite.
    #[error(
        "the initial state has a {place} that is not finite, for {}: give one nearer to 1",
        match &values[..] {
            [] => "a value or a weight of the scene is too large or too small to compute with".to_owned(),
            [value] => format!("{value} is too large or too small to compute with"),
            values => format!("one of {} is too large or too small to compute with", values.join(", ")),
        }
    )]
    NotFinite {
        /// What is not finite.
        place: &'static str,
        /// The values of the scene that may be to blame, as `key = value`.
        values: Vec<String>,
    },
    /// The sparse factor cannot be set up.
    #[error("the linear solver: {0}")]
    Factor(LinalgError),
    /// The state to continue from is of another scene.
    #[error("the state to resume from cannot be used: {0}")]
    Restore(#[from] RestoreError),
    /// A change that the scene cannot have.
    #[error(transparent)]
    Change(Box<SceneError>),
    /// The mesh that follows the membrane cannot be made again.
    #[error("the mesh cannot follow the membrane after step {step}, at t = {t:e}: {source}")]
    Transfer {
        /// The last step.
        step: u64,
        /// The time at its end.
        t: f64,
        /// What went wrong.
        source: TransferError,
    },
    /// A step was not solved, nor any part of it.
    #[error("step {step} to t = {t:e} failed; tried were {tried}; the last one: {source}")]
    Step {
        /// The number of the step.
        step: u64,
        /// The time at its end.
        t: f64,
        /// What was tried.
        tried: Box<Tried>,
        /// What went wrong at last.
        source: StepError,
    },
}

impl SimulationError {
    /// Whether the scene asks for what cannot be, for its mesh, its vesicle, its size or a value.
    pub fn is_of_scene(&self) -> bool {
        matches!(
            self,
            Self::Mesh(_) | Self::NoVesicle(_) | Self::Memory { .. } | Self::NotFinite { .. }
        )
    }
}

impl From<FemError> for SimulationError {
    fn from(error: FemError) -> Self {
        match error {
            FemError::Ended => Self::Ended,
            error => Self::Mesh(error),
        }
    }
}
