//! The linear systems of substep 2: by which of several ways they are solved, and how accurately.
//!
//! On the fast path ω and μ are eliminated, and GMRES works on φ alone, preconditioned by the inverse of the
//! bulk operator: by a transform on a grid, by factors of shifted Laplacians on any mesh. The other
//! way is a sparse factor of all three fields.

use serde::{Deserialize, Serialize};

use crate::fem::Space;
use crate::linalg::{Gmres, LinalgError, vector};
use crate::scene::LinearMethod;

use super::super::fault_injection;
use super::super::solvers::BulkInverse;
use super::super::solvers::grid::{GridInverse, ReducedOperator};
use super::super::solvers::ldlt::{FactorCheckpoint, FactoredPreconditioner, ThreeFieldOperator};
use super::super::solvers::shifted::ShiftedInverse;
use super::{MembraneStep, NewtonOptions, StepContext, StoppingCriterion};

/// Limit of GMRES's iterations in one solve.
const KRYLOV_LIMIT: usize = 200;

/// The steps of the secant scheme are long: a correction leaves 1e-3 of the residual, nearly, for the
/// system is not linear, and to solve the linearised one to less than this part of it is of no use. At 1e-4 there
/// are more corrections, and some systems are solved so poorly that the residual does not fall.
const LEAST_OF_A_LONG_STEP: f64 = 1e-5;

/// What the relative residuals of the equations for μ and ω count in GMRES's norm, over that of the first one.
/// Both fields are computed again from the new φ, but what is left in their equations is in φ too, where two products with the
/// stiffness matrix magnify it: with 0.3 and 0.01 `redcell` took 175 steps in place of 75. Shares that are larger by three
/// take more iterations; where they are too small, a correction makes them [stricter](LinearSolver::strictness).
const SHARE_OF_MU: f64 = 3.0;
const SHARE_OF_OMEGA: f64 = 0.3;

/// Vectors that GMRES keeps.
const RESTART: usize = 60;

/// How a linear system is solved.
#[derive(Debug)]
pub(super) enum Path {
    /// One field, preconditioned by the bulk operator: the fast path.
    Reduced {
        preconditioner: Box<dyn BulkInverse>,
        scratch: [Vec<f64>; 4],
    },
    Factor {
        preconditioner: Box<FactoredPreconditioner>,
    },
}

/// A way to solve the linear systems, with its vectors.
#[derive(Debug)]
pub(super) struct LinearSolver {
    pub(super) path: Path,
    gmres: Gmres,
    right_side: Vec<f64>,
    pub(super) increment: Vec<f64>,
    /// With the factor: by how much the residuals of the equations for μ and ω count more than by their shares.
    pub(super) strictness: f64,
}

impl LinearSolver {
    /// By the method that a scene asks for, where it can be had: on a grid, on any mesh, or with a clamped
    /// wall.
    pub(super) fn of(
        space: &Space,
        method: LinearMethod,
        clamped: bool,
        fixed: &[bool],
    ) -> Result<Self, LinalgError> {
        match (method, space.mesh().grid()) {
            (LinearMethod::Factor, _) => Self::factor(space, fixed),
            _ if clamped => Self::factor(space, fixed),
            (LinearMethod::Automatic | LinearMethod::Transform, Some(grid)) => {
                Ok(Self::reduced(space, GridInverse::new(space, grid)?))
            }
            _ => Ok(Self::reduced(space, ShiftedInverse::new(space))),
        }
    }

    /// For so many unknowns.
    fn new(path: Path, unknowns: usize) -> Self {
        Self {
            path,
            gmres: Gmres::new(unknowns, RESTART),
            right_side: vec![0.0; unknowns],
            increment: vec![0.0; unknowns],
            strictness: 1.0,
        }
    }

    fn reduced(space: &Space, bulk: impl BulkInverse + 'static) -> Self {
        let vector = || vec![0.0; space.nodes()];
        let path = Path::Reduced {
            preconditioner: Box::new(bulk),
            scratch: [vector(), vector(), vector(), vector()],
        };
        Self::new(path, space.nodes())
    }

    fn factor(space: &Space, fixed: &[bool]) -> Result<Self, LinalgError> {
        let preconditioner = Box::new(FactoredPreconditioner::new(space, fixed.to_vec())?);
        Ok(Self::new(
            Path::Factor { preconditioner },
            3 * space.nodes(),
        ))
    }

    /// Whether it is the fast path.
    fn is_fast(&self) -> bool {
        matches!(self.path, Path::Reduced { .. })
    }

    fn preconditioner(&self) -> Option<&FactoredPreconditioner> {
        match &self.path {
            Path::Reduced { .. } => None,
            Path::Factor { preconditioner } => Some(preconditioner),
        }
    }

    fn preconditioner_mut(&mut self) -> Option<&mut FactoredPreconditioner> {
        match &mut self.path {
            Path::Reduced { .. } => None,
            Path::Factor { preconditioner } => Some(preconditioner),
        }
    }
}

/// How the linear systems are solved at present, and the factor that is kept.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(in crate::scheme) struct LinearCheckpoint {
    is_fast: bool,
    factor: FactorCheckpoint,
}

#[cfg(test)]
impl LinearCheckpoint {
    pub(in crate::scheme) fn has_no_factor(&self) -> bool {
        self.factor.is_empty()
    }

    pub(in crate::scheme) fn forget_factor(&mut self) {
        self.factor.clear();
    }
}

impl MembraneStep {
    /// Whether the fast path is in use.
    pub(in crate::scheme) fn is_fast(&self) -> bool {
        self.linear.is_fast()
    }

    /// How the linear systems are solved at present, in a word.
    pub(in crate::scheme) fn linear_method(&self) -> &'static str {
        match &self.linear.path {
            Path::Factor { .. } => "factor",
            Path::Reduced { preconditioner, .. } => preconditioner.name(),
        }
    }

    /// What the fast path is called in messages, in use or not; `None` where there is none.
    pub(in crate::scheme) fn fast_method(&self) -> Option<&'static str> {
        let mut solvers = std::iter::once(&self.linear).chain(&self.standby);
        solvers.find_map(|solver| match &solver.path {
            Path::Factor { .. } => None,
            Path::Reduced { preconditioner, .. } => Some(preconditioner.method()),
        })
    }

    /// Leaves the fast path for the factor.
    pub(in crate::scheme) fn fall_back(&mut self, space: &Space) -> Result<(), LinalgError> {
        if self.is_fast() {
            let factor = match self.standby.take() {
                Some(factor) => factor,
                None => LinearSolver::factor(space, &self.fixed)?,
            };
            self.standby = Some(std::mem::replace(&mut self.linear, factor));
        }
        Ok(())
    }

    /// Goes back to the fast path, if it was left.
    pub(in crate::scheme) fn return_to_fast(&mut self) {
        if let Some(standby) = self.standby.as_mut().filter(|standby| standby.is_fast()) {
            std::mem::swap(standby, &mut self.linear);
        }
    }

    /// Forgets the factor where it is not in use.
    pub(in crate::scheme) fn drop_factor(&mut self) {
        if self.is_fast() {
            self.standby = None;
        }
    }

    /// How the linear systems are solved at present. All else is rebuilt in every step.
    pub(in crate::scheme) fn save(&self, checkpoint: &mut LinearCheckpoint) {
        checkpoint.is_fast = self.is_fast();
        let mut solvers = std::iter::once(&self.linear).chain(&self.standby);
        match solvers.find_map(LinearSolver::preconditioner) {
            Some(factor) => factor.save(&mut checkpoint.factor),
            None => checkpoint.factor.clear(),
        }
    }

    /// Whether this step can solve the linear systems as another did.
    pub(in crate::scheme) fn can_restore(&self, checkpoint: &LinearCheckpoint) -> bool {
        let mut solvers = std::iter::once(&self.linear).chain(&self.standby);
        !checkpoint.is_fast || solvers.any(LinearSolver::is_fast)
    }

    /// Solves the linear systems from now on as they were then, with the same factor.
    ///
    /// # Errors
    /// What a factor may run into.
    pub(in crate::scheme) fn restore(
        &mut self,
        space: &Space,
        checkpoint: &LinearCheckpoint,
    ) -> Result<(), LinalgError> {
        if checkpoint.is_fast {
            self.return_to_fast();
        } else {
            self.fall_back(space)?;
        }
        let solvers = std::iter::once(&mut self.linear).chain(&mut self.standby);
        let mut factors = solvers.filter_map(LinearSolver::preconditioner_mut);
        match factors.next() {
            Some(factor) => factor.restore(&checkpoint.factor),
            None if checkpoint.factor.is_empty() => Ok(()),
            None => {
                let mut solver = LinearSolver::factor(space, &self.fixed)?;
                if let Some(factor) = solver.preconditioner_mut() {
                    factor.restore(&checkpoint.factor)?;
                }
                self.standby = Some(solver);
                Ok(())
            }
        }
    }

    /// To what norm the linearised system is solved: to what the energy law allows (by
    /// the inequality of Cauchy and Schwarz for r₁ᵀμ), but at least by a factor of ten and not
    /// further than Newton's method can use.
    pub(super) fn linear_goal(
        &mut self,
        context: &StepContext<'_>,
        options: NewtonOptions,
        norm: f64,
    ) -> f64 {
        let weights = context.space.nodal_weights();
        let domain = vector::sum(weights);
        let mean = vector::dot(weights, &context.to.mu) / domain;
        let square = vector::weighted_square(&context.to.mu, weights) - mean * mean * domain;
        let potential = square.max(0.0).sqrt().max(f64::MIN_POSITIVE);
        let wanted = options.law_tolerance * context.energy_scale / potential;
        let least = match options.stopping {
            StoppingCriterion::LastChange => 1e-8,
            StoppingCriterion::ChangesToCome => LEAST_OF_A_LONG_STEP,
        };
        wanted.clamp(least * norm, 0.1 * norm)
    }

    /// Solves for the increment; returns the Krylov iterations.
    pub(super) fn solve_newton_system(
        &mut self,
        context: &StepContext<'_>,
        goal: f64,
    ) -> Result<u32, LinalgError> {
        let space = context.space;
        let step_mobility = context.dt * self.mobility;
        let width = self.interface_width;
        let size = space.nodes();
        let floor = self.rounding_floor(context);
        let (r1, rest) = self.linear.right_side.split_at_mut(size);
        let rows = r1.iter_mut().zip(&self.residual[0]).zip(&self.root_weights);
        rows.for_each(|((b, r), root)| *b = -r / root);
        let outcome = match &mut self.linear.path {
            Path::Reduced {
                preconditioner,
                scratch,
            } => {
                preconditioner.prepare(space, self.jacobian.weight * step_mobility, width)?;
                let mut operator = ReducedOperator {
                    space,
                    jacobian: &self.jacobian,
                    mass_inverse: &mut self.mass_inverse,
                    step_mobility,
                    root_weights: &self.root_weights,
                    scratch,
                };
                let (b, x) = (&self.linear.right_side, &mut self.linear.increment);
                let outcome = self.linear.gmres.solve(
                    &mut operator,
                    &mut **preconditioner,
                    b,
                    x,
                    goal,
                    KRYLOV_LIMIT,
                )?;
                if !outcome.converged && outcome.residual > floor {
                    return Err(LinalgError::NotConverged {
                        method: preconditioner.method(),
                        iterations: outcome.iterations,
                        residual: outcome.residual / vector::norm(b),
                        tolerance: goal / vector::norm(b),
                    });
                }
                outcome
            }
            Path::Factor { preconditioner } => {
                let (r2, r3) = rest.split_at_mut(size);
                let weights = space.nodal_weights();
                let size_of = |field: &[f64], least: f64| {
                    vector::weighted_square(field, weights).sqrt().max(least)
                };
                let [mu, omega] = [self.least.mu, self.least.omega];
                let strictness = self.linear.strictness;
                let row_scales = [
                    1.0,
                    strictness * SHARE_OF_MU / size_of(&context.to.mu, mu),
                    strictness * SHARE_OF_OMEGA / (width * size_of(&context.to.omega, omega)),
                ];
                let rows = r2.iter_mut().zip(&self.residual[1]).zip(&self.root_weights);
                rows.for_each(|((b, r), root)| *b = -row_scales[1] * r / root);
                r3.fill(0.0);
                let mut operator = ThreeFieldOperator {
                    space,
                    jacobian: &self.jacobian,
                    step_mobility,
                    width,
                    fixed: &self.fixed,
                    row_scales,
                    root_weights: &self.root_weights,
                };
                let (b, x) = (&self.linear.right_side, &mut self.linear.increment);
                let goal = goal.min(1e-2 * vector::norm(b));
                loop {
                    let jacobian = &self.jacobian;
                    let fresh = preconditioner.prepare(
                        space,
                        jacobian,
                        step_mobility,
                        width,
                        row_scales,
                    )?;
                    let outcome = self.linear.gmres.solve(
                        &mut operator,
                        &mut **preconditioner,
                        b,
                        x,
                        goal,
                        KRYLOV_LIMIT,
                    )?;
                    preconditioner.used(outcome.iterations);
                    // A new factor that misses the goal still gives a direction; the damping judges it.
                    if outcome.converged || fresh {
                        break outcome;
                    }
                    preconditioner.expire();
                }
            }
        };
        fault_injection::tap(
            fault_injection::Place::Increment,
            &mut self.linear.increment,
        );
        if !self.linear.increment.iter().all(|value| value.is_finite()) {
            return Err(LinalgError::NotFinite {
                place: "GMRES",
                iteration: outcome.iterations,
            });
        }
        self.conserve(context);
        Ok(outcome.iterations as u32)
    }

    /// Shifts φ's increment by a constant such that ∫φ = ∫φⁿ to rounding after it, however
    /// loosely the system was solved and however large a μ rounding has had to deal with in Kμ, whose
    /// sum is 0. At the wall a given φ stays.
    fn conserve(&mut self, context: &StepContext<'_>) {
        let increment = &self.linear.increment;
        let shift = self.conserving_shift(context, |node| increment[node]);
        let free = self.fixed.iter().zip(&mut self.linear.increment);
        free.filter(|(fixed, _)| !**fixed)
            .for_each(|(_, step)| *step += shift);
    }

    /// The same for the guess: a damped correction would leave a part of what is missing there, and
    /// the guesses of later steps are made from this one's φ.
    pub(super) fn conserve_guess(&self, context: &mut StepContext<'_>) {
        let shift = self.conserving_shift(context, |_| 0.0);
        let free = self.fixed.iter().zip(&mut context.to.phi);
        free.filter(|(fixed, _)| !**fixed)
            .for_each(|(_, phi)| *phi += shift);
    }

    /// The constant by which φ must be shifted where it is free, such that ∫φ = ∫φⁿ after this increment.
    fn conserving_shift(&self, context: &StepContext<'_>, increment: impl Fn(usize) -> f64) -> f64 {
        let (mut missing, mut free) = (0.0, 0.0);
        for (node, weight) in context.space.nodal_weights().iter().enumerate() {
            missing -= weight * (context.to.phi[node] - context.from.phi[node] + increment(node));
            free += if self.fixed[node] { 0.0 } else { *weight };
        }
        missing / free
    }

    /// About what rounding makes of r₁: three products with the stiffness matrix lie between φ and it.
    pub(super) fn rounding_floor(&self, context: &StepContext<'_>) -> f64 {
        let space = context.space;
        let bulk = context.dt * self.mobility * self.interface_width;
        let weights = space.nodal_weights();
        let phi = vector::weighted_square(&context.to.phi, weights).sqrt();
        10.0 * f64::EPSILON * (1.0 + bulk * self.largest_eigenvalue.powi(3)) * phi
    }

    /// Has the next step make a new factor.
    pub(in crate::scheme) fn forget(&mut self) {
        if let Path::Factor { preconditioner } = &mut self.linear.path {
            preconditioner.expire();
        }
    }
}
