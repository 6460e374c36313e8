//! Linear algebra that knows nothing of what it solves: sparse matrices on a fixed pattern, Krylov
//! methods, sparse LDLᵀ factors (faer) and transforms of a grid.

mod conjugate_gradients;
mod error;
mod factor;
mod gmres;
mod grid_transform;
mod lower_triangle;
pub(crate) mod op_counts;
mod ordering;
pub mod parallel;
mod shifted_cholesky;
mod sparse;
mod supernodal;
pub mod vector;

pub use conjugate_gradients::ConjugateGradients;
pub use error::LinalgError;
pub use factor::Ldlt;
pub use gmres::Gmres;
pub use grid_transform::{Basis, GridTransform, Multiplier};
pub use ordering::minimum_degree;
pub use shifted_cholesky::ShiftedFactors;
pub use sparse::{Block, Pattern, SparseMatrix};

/// A linear map between vectors of the same length: a matrix, a matrix-free product, or a
/// preconditioner.
pub trait LinearOperator {
    /// y ← A x. Takes `&mut self` so that an operator can own its scratch vectors.
    fn apply(&mut self, x: &[f64], y: &mut [f64]);
}
