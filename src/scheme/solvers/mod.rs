//! The linear systems of substep 2: a preconditioner a file, and which of them is used when.
//!
//! - [`grid`]: ω and μ eliminated, the bulk operator inverted by a transform of the grid; on a grid.
//! - [`shifted`]: the same by factors of shifted Laplacians; on any mesh.
//! - [`ldlt`]: a sparse factor of all three fields; for a clamped boundary, and for long steps.
//! - [`selection`]: when the fast preconditioner is replaced by the factor, and when it is tried again.

pub(in crate::scheme) mod grid;
pub(in crate::scheme) mod ldlt;
pub(in crate::scheme) mod selection;
pub(in crate::scheme) mod shifted;

use crate::fem::Space;
use crate::linalg::{LinalgError, LinearOperator};

/// The inverse of the bulk operator, by which one of the fast ways preconditions GMRES.
pub(in crate::scheme) trait BulkInverse:
    LinearOperator + Send + std::fmt::Debug
{
    /// Makes it for Δtγ_ben (θ times that in the secant scheme) and ε, if it is not that already.
    fn prepare(&mut self, space: &Space, step_mobility: f64, width: f64)
    -> Result<(), LinalgError>;

    /// What a scene calls it.
    fn name(&self) -> &'static str;

    /// What it is called in messages.
    fn method(&self) -> &'static str;
}
