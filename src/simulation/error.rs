//! Why a run cannot start or go on.

use thiserror::Error;

use super::ladder::Tried;
use crate::fem::FemError;
use crate::linalg::LinalgError;
use crate::scheme::{InitialError, StepError};

/// Why a run cannot start or go on.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// The mesh cannot be made.
    #[error("the mesh: {0}")]
    Mesh(#[from] FemError),
    /// The initial fields cannot be made.
    #[error("the initial state: {0}")]
    Initial(#[from] InitialError),
    /// The sparse factor cannot be set up.
    #[error("the linear solver: {0}")]
    Factor(LinalgError),
    /// Anchoring without anything to anchor.
    #[error("the scene has no director to anchor: give it a table [nematic]")]
    NoDirector,
    /// A step was not solved, nor any part of it.
    #[error("step {step} to t = {t:e} failed; tried were {tried}; the last one: {source}")]
    Step {
        /// The number of the step.
        step: u64,
        /// The time at its end.
        t: f64,
        /// What was tried.
        tried: Tried,
        /// What went wrong at last.
        source: StepError,
    },
}
