//! What can go wrong in one time step.

use thiserror::Error;

use crate::fem::FemError;
use crate::linalg::LinalgError;

/// A step that was not solved. The state is as it was before the step.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StepError {
    /// Substep 1 has no solution to the tolerance.
    #[error("the linear system of the director (substep 1) was not solved: {0}")]
    Director(LinalgError),
    /// The part of the mesh on which substep 1 is solved cannot be made.
    #[error("the part of the mesh for the director (substep 1) cannot be made: {0}")]
    ActiveRegion(FemError),
    /// Substep 2 did not converge.
    #[error(
        "the iteration of the membrane (substep 2) did not converge: after {iterations} iterations the relative changes of phi, omega, mu are {:.1e}, {:.1e}, {:.1e} (tolerance {tolerance:.1e}), the energy law misses by {law:.1e} (tolerance {law_tolerance:.1e}), and the residual is {residual:.3e}; a smaller time.step helps",
        changes[0], changes[1], changes[2]
    )]
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// Relative L2 changes of φ, ω, μ in the last one.
        changes: [f64; 3],
        /// solver.tolerance.
        tolerance: f64,
        /// The algebraic part of the law's residual, over S.
        law: f64,
        /// solver.law_tolerance.
        law_tolerance: f64,
        /// Norm of the residual of the first equation of (3.21).
        residual: f64,
    },
    /// A linear system of substep 2 could not be treated.
    #[error("a linear system of the membrane (substep 2, iteration {iteration}) failed: {source}")]
    Membrane {
        /// Which iteration.
        iteration: u32,
        /// What the solver says.
        source: LinalgError,
    },
    /// A NaN or an infinity.
    #[error("a value that is not finite came up in {place} (iteration {iteration})")]
    NotFinite {
        /// In which field or phase.
        place: &'static str,
        /// In which iteration of substep 2; 0 before it.
        iteration: u32,
    },
    /// The step was solved, but Δt is too long for the tolerance.
    #[error(
        "the estimated error of phi in the step is {error:.2e}; time.tolerance is {tolerance:.1e}"
    )]
    Inaccurate {
        /// The estimate, in L2.
        error: f64,
        /// time.tolerance.
        tolerance: f64,
    },
    /// What an attempt failed with before the run was resumed.
    #[error("{0}")]
    Earlier(String),
    /// The step converged but the energy law (3.26) does not close.
    #[error(
        "the energy law misses by {residual:.2e} of the energy; solver.law_tolerance is {tolerance:.1e}"
    )]
    LawBroken {
        /// law_residual.
        residual: f64,
        /// solver.law_tolerance.
        tolerance: f64,
    },
}
