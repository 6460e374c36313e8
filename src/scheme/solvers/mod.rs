//! The linear systems of substep 2: a preconditioner a file, and which of them is used when.
//!
//! - [`cosine`]: ω and μ eliminated, the bulk operator inverted by cosine transforms; on a grid.
//! - [`shifted`]: the same by factors of shifted Laplacians; on any mesh.
//! - [`ldlt`]: a sparse factor of all three fields; for a clamped boundary, and for long steps.
//! - [`selection`]: when the fast preconditioner is replaced by the factor, and when it is tried again.

pub(in crate::scheme) mod cosine;
pub(in crate::scheme) mod ldlt;
pub(in crate::scheme) mod selection;
pub(in crate::scheme) mod shifted;
