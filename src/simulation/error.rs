//! Why a run cannot start or go on.

use thiserror::Error;

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
    #[error(
        "step {step} to t = {t:e} failed: it was solved neither whole nor in parts down to \u{394}t = {smallest:.1e}; the last attempt: {source}"
    )]
    Step {
        /// The number of the step.
        step: u64,
        /// The time at its end.
        t: f64,
        /// The smallest Δt that was tried.
        smallest: f64,
        /// What went wrong at last.
        source: StepError,
    },
}
