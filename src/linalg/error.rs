//! What can go wrong in a linear solve.

use thiserror::Error;

/// A linear system that could not be solved.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LinalgError {
    /// An iteration stopped short of its tolerance.
    #[error(
        "{method} stopped after {iterations} iterations at a relative residual of {residual:.3e}; {tolerance:.1e} was wanted"
    )]
    NotConverged {
        /// Which method.
        method: &'static str,
        /// Iterations made.
        iterations: usize,
        /// ‖b − A x‖ / ‖b‖ at the end.
        residual: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// A value that is not finite came up.
    #[error("a value that is not finite came up in {place} (iteration {iteration})")]
    NotFinite {
        /// Which method.
        place: &'static str,
        /// In which of its iterations.
        iteration: usize,
    },
    /// The factorisation could not be made.
    #[error("the sparse LDLT factorisation of a matrix of {size} unknowns failed: {reason}")]
    Factorisation {
        /// Rows of the matrix.
        size: usize,
        /// The library's words.
        reason: String,
    },
    /// The eigenvectors of a chain could not be computed.
    #[error("the eigenvectors of a chain of {size} values could not be computed: {reason}")]
    Eigenvectors {
        /// Values of a vector.
        size: usize,
        /// What the library says.
        reason: String,
    },
}
