//! What can go wrong in building a finite-element space.

use thiserror::Error;

use crate::linalg::LinalgError;

/// A mesh or a projection that could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FemError {
    /// A triangle that is turned round or has no area.
    #[error(
        "triangle {triangle} (nodes {nodes:?}) has the signed area {area:.3e}; every triangle must have a positive one"
    )]
    DegenerateTriangle {
        /// Its number.
        triangle: usize,
        /// Its nodes.
        nodes: [u32; 3],
        /// Its area, negative where it is turned round.
        area: f64,
    },
    /// The nodes could not be triangulated.
    #[error("{nodes} nodes could not be triangulated: {reason}")]
    Triangulation {
        /// How many.
        nodes: usize,
        /// What the library says.
        reason: String,
    },
    /// It was left before it was done.
    #[error("the making of the mesh was ended")]
    Ended,
    /// The linear system of a projection could not be solved.
    #[error("a projection of the phase field failed")]
    Projection(#[from] LinalgError),
}
