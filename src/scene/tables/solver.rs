//! `[solver]`.

use super::{Boundary, Rules, Scene};
use crate::scene::error::{Problem, SceneError};
use crate::scene::parameter::choice;
use crate::scene::reader::{POSITIVE, Reader};

table! {
    /// How the equations are solved.
    #[derive(Copy)]
    pub struct Solver {
        /// The rule of every integral: seven points a triangle, or its corners.
        quadrature: Quadrature = Quadrature::Consistent;
        /// The iteration for (3.21).
        iteration: Iteration = Iteration::Newton;
        /// How the linear systems of substep 2 are solved.
        linear: LinearMethod = LinearMethod::Automatic;
        /// Bound of the relative L2 change of each field in the last iteration.
        tolerance: f64 = 1e-5, POSITIVE;
        /// Bound of the residual of the energy law, in size.
        law_tolerance: f64 = 1e-8, POSITIVE;
    }
}

impl Rules for Solver {
    /// The transform is for the regular mesh and the natural boundary, the shifted Laplacians for the latter.
    fn check_scene(&self, scene: &Scene, table: &Reader<'_>) -> Result<(), SceneError> {
        let is_natural = scene.boundary == Boundary::Natural;
        let problem = match self.linear {
            LinearMethod::Transform if !(is_natural && scene.mesh.is_grid()) => {
                Problem::TransformDoesNotApply
            }
            LinearMethod::Shifted if !is_natural => Problem::ShiftedDoesNotApply,
            _ => return Ok(()),
        };
        table
            .get("linear")
            .map_or(Ok(()), |linear| Err(linear.error(problem)))
    }
}

choice! {
    /// The rule of every integral.
    pub enum Quadrature {
        /// Seven points a triangle, exact to degree 5.
        Consistent = "consistent",
        /// The three vertices of a triangle.
        Lumped = "lumped",
    }
}

choice! {
    /// The iteration for the nonlinear system (3.21).
    pub enum Iteration {
        /// Newton's method, damped.
        Newton = "newton",
        /// (4.35): G_sec and B are those of the last iterate.
        Lagged = "lagged",
    }
}

choice! {
    /// How the linear systems of substep 2 are solved.
    pub enum LinearMethod {
        /// The fast one where it applies, the factor where it does not or fails.
        Automatic = "automatic",
        /// Krylov iteration, preconditioned by a transform of the grid: structured meshes, the natural boundary.
        Transform = "transform",
        /// Krylov iteration, preconditioned by sparse factors of three shifted Laplacians: any mesh, the
        /// natural boundary.
        Shifted = "shifted",
        /// Krylov iteration, preconditioned by a sparse LDLᵀ factor: any mesh.
        Factor = "factor",
    }
}
