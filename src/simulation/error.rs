//! Why a run cannot start or go on.

use std::fmt;

use thiserror::Error;

use super::free_memory::FreeMemory;
use super::ladder::Tried;
use super::presence::NoVesicle;
use crate::fem::FemError;
use crate::linalg::LinalgError;
use crate::scheme::{InitialError, RecallError, StepError};

/// Bytes in words: three digits.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let megabytes = self.0 as f64 / 1e6;
        let (value, unit) = if megabytes < 999.5 {
            (megabytes, "MB")
        } else {
            (megabytes / 1e3, "GB")
        };
        let decimals = match value {
            value if value < 9.995 => 2,
            value if value < 99.95 => 1,
            _ => 0,
        };
        write!(f, "{value:.decimals$} {unit}")
    }
}

/// Why a run cannot start or go on.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimulationError {
    /// The run would need more memory than there is.
    #[error(
        "a mesh {mesh} would need about {}, and {} {}: {remedy}",
        Bytes(*needed),
        Bytes(free.bytes),
        free.bound
    )]
    Memory {
        /// How large the mesh is, in words.
        mesh: String,
        /// Bytes, estimated.
        needed: u64,
        /// What there is.
        free: FreeMemory,
        /// What can be done.
        remedy: &'static str,
    },
    /// The set-up was ended by whoever watched it.
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
        "the initial state has a {place} that is not finite, for a value or a weight of the scene is too \
         large to compute with: make it smaller"
    )]
    TooLarge {
        /// What is not finite.
        place: &'static str,
    },
    /// The sparse factor cannot be set up.
    #[error("the linear solver: {0}")]
    Factor(LinalgError),
    /// The state to go on from is of another scene.
    #[error("the state to go on from cannot be used: {0}")]
    Recall(#[from] RecallError),
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
        tried: Box<Tried>,
        /// What went wrong at last.
        source: StepError,
    },
}

impl SimulationError {
    /// Whether the scene asks for what cannot be, for its mesh, its vesicle or its size.
    pub fn is_of_scene(&self) -> bool {
        matches!(
            self,
            Self::Mesh(_) | Self::NoVesicle(_) | Self::Memory { .. }
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
