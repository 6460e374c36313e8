//! Substep 2: the nonlinear system (3.21) for (φ, μ, ω), by Newton's method, damped, or by the
//! iteration (4.35), which leaves out of the derivative what it takes from the last iterate.
//!
//! ω always solves its equation exactly. With the natural boundary μ solves the second equation
//! exactly too, and what is left is the residual of the first,
//!   r₁ = M(φ − φⁿ) + Δtγ_ben K μ(φ).
//! With the clamped boundary there is no second equation at the wall, μ is an unknown of its own and
//! the residual is (r₁, r₂).

mod iteration;

use serde::{Deserialize, Serialize};

use crate::fem::{MassInverse, Space};
use crate::linalg::{Gmres, LinalgError, LinearOperator, vector};
use crate::physics::{Effects, MembraneForce, Sample};
use crate::scene::{Iteration, LinearMethod};

use super::factored::{FactorMemory, FactoredPreconditioner, ThreeFieldOperator};
use super::faults;
use super::linearised::Linearised;
use super::shifted::ShiftedPreconditioner;
use super::transform::{BulkPreconditioner, ReducedOperator};
use super::{Phase, State, StepError};

pub(super) use iteration::{Limits, Work};

/// Limit of GMRES's iterations in one solve.
const KRYLOV_LIMIT: usize = 200;

/// Vectors that GMRES keeps.
const RESTART: usize = 60;

/// Accuracy of the solves with the mass matrix, over the tolerance of the energy law: so far below it
/// that the second and the third equation of (3.21) may be taken as exact.
const MASS_ACCURACY: f64 = 1e-4;

/// The inverse of the bulk operator.
#[derive(Debug)]
enum Bulk {
    /// By cosine transforms, on a grid.
    Transform(Box<BulkPreconditioner>),
    /// By factors of shifted Laplacians, on any mesh.
    Shifted(Box<ShiftedPreconditioner>),
}

impl Bulk {
    fn prepare(&mut self, space: &Space, mobility: f64, width: f64) -> Result<(), LinalgError> {
        match self {
            Self::Transform(transform) => {
                transform.prepare(mobility, width);
                Ok(())
            }
            Self::Shifted(shifted) => shifted.prepare(space, mobility, width),
        }
    }

    /// What it is called in messages.
    fn method(&self) -> &'static str {
        match self {
            Self::Transform(_) => "GMRES with the cosine transform",
            Self::Shifted(_) => "GMRES with the shifted Laplacians",
        }
    }
}

impl LinearOperator for Bulk {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Transform(transform) => transform.apply(x, y),
            Self::Shifted(shifted) => shifted.apply(x, y),
        }
    }
}

/// How a linear system is solved.
#[derive(Debug)]
enum Path {
    /// One field, preconditioned by the bulk operator: the fast path.
    Reduced {
        preconditioner: Bulk,
        scratch: [Vec<f64>; 4],
    },
    Factor {
        preconditioner: Box<FactoredPreconditioner>,
    },
}

/// A way to solve the linear systems, with its vectors.
#[derive(Debug)]
struct LinearSolver {
    path: Path,
    gmres: Gmres,
    right_side: Vec<f64>,
    increment: Vec<f64>,
}

impl LinearSolver {
    /// For so many unknowns.
    fn new(path: Path, unknowns: usize) -> Self {
        Self {
            path,
            gmres: Gmres::new(unknowns, RESTART),
            right_side: vec![0.0; unknowns],
            increment: vec![0.0; unknowns],
        }
    }

    fn reduced(space: &Space, bulk: Bulk) -> Self {
        let vector = || vec![0.0; space.nodes()];
        let path = Path::Reduced {
            preconditioner: bulk,
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
pub(super) struct LinearMemory {
    is_fast: bool,
    factor: FactorMemory,
}

#[cfg(test)]
impl LinearMemory {
    pub(super) fn has_no_factor(&self) -> bool {
        self.factor.is_empty()
    }

    pub(super) fn forget_factor(&mut self) {
        self.factor.clear();
    }
}

/// Substep 2 with its matrices and vectors.
#[derive(Debug)]
pub(super) struct MembraneStep {
    /// γ_ben.
    mobility: f64,
    /// Relative accuracy of the solves with the mass matrix.
    mass_tolerance: f64,
    /// Nodes where φ is given (clamped boundary).
    fixed: Vec<bool>,
    clamped: bool,
    linear: LinearSolver,
    /// The other one, once both have been in use.
    spare: Option<LinearSolver>,
    mass_inverse: MassInverse,
    linearised: Linearised,
    force: MembraneForce,
    /// The integrals that forces need, at φⁿ and at the iterate.
    integrals: [Vec<f64>; 2],
    /// r₁ and r₂; r₂ stays zero with the natural boundary.
    residual: [Vec<f64>; 2],
    load: Vec<f64>,
    /// φ, ω, μ of the last iterate.
    last: [Vec<f64>; 3],
    /// Newton's correction at the last iterate, while that of a trial takes its place.
    correction: Vec<f64>,
    scratch: Vec<f64>,
    root_weights: Vec<f64>,
    /// A bound of the eigenvalues of M_L⁻¹ K.
    largest_eigenvalue: f64,
}

/// Room for the old and the new state on a patch.
#[derive(Debug)]
pub(super) struct Samples {
    pub(super) old: Sample,
    pub(super) new: Sample,
}

impl Samples {
    pub(super) fn new(with_director: bool) -> Self {
        Self {
            old: Sample::new(with_director),
            new: Sample::new(with_director),
        }
    }
}

/// The places of a step: what it starts from, where it goes.
pub(super) struct Places<'a> {
    pub(super) space: &'a Space,
    pub(super) effects: &'a mut Effects,
    pub(super) samples: &'a mut Samples,
    pub(super) from: &'a State,
    pub(super) to: &'a mut State,
    pub(super) dt: f64,
    /// S, the sum of the absolute energies.
    pub(super) energy_scale: f64,
    /// Told of every phase that ends.
    pub(super) watch: &'a mut dyn FnMut(Phase),
}

impl Places<'_> {
    /// Takes the last state as the guess, in place of an iterate that went astray.
    pub(super) fn restart(&mut self) {
        self.to.phi.copy_from_slice(&self.from.phi);
        self.to.omega.copy_from_slice(&self.from.omega);
        self.to.mu.copy_from_slice(&self.from.mu);
    }
}

impl MembraneStep {
    /// For a space; `method` says how the linear systems are to be solved, where it can be.
    pub(super) fn new(
        space: &Space,
        mobility: f64,
        law_tolerance: f64,
        clamped: bool,
        method: LinearMethod,
    ) -> Result<Self, LinalgError> {
        let size = space.nodes();
        let fixed: Vec<bool> = space
            .mesh()
            .on_boundary()
            .iter()
            .map(|on| clamped && *on)
            .collect();
        let vector = || vec![0.0; size];
        let linear = match (method, space.mesh().grid()) {
            (LinearMethod::Factor, _) => LinearSolver::factor(space, &fixed)?,
            _ if clamped => LinearSolver::factor(space, &fixed)?,
            (LinearMethod::Automatic | LinearMethod::Transform, Some(grid)) => {
                let transform = BulkPreconditioner::new(space, grid);
                LinearSolver::reduced(space, Bulk::Transform(Box::new(transform)))
            }
            _ => {
                let shifted = ShiftedPreconditioner::new(space)?;
                LinearSolver::reduced(space, Bulk::Shifted(Box::new(shifted)))
            }
        };
        Ok(Self {
            mobility,
            mass_tolerance: (MASS_ACCURACY * law_tolerance).clamp(1e-15, 1e-10),
            clamped,
            linear,
            spare: None,
            mass_inverse: MassInverse::new(space),
            linearised: Linearised::new(space),
            force: MembraneForce::default(),
            integrals: [Vec::new(), Vec::new()],
            residual: [vector(), vector()],
            load: vector(),
            last: [vector(), vector(), vector()],
            correction: Vec::new(),
            scratch: vector(),
            root_weights: space
                .nodal_weights()
                .iter()
                .map(|weight| weight.sqrt())
                .collect(),
            largest_eigenvalue: space.stiffness().eigenvalue_bound(space.nodal_weights()),
            fixed,
        })
    }

    /// γ_ben.
    pub(super) fn mobility(&self) -> f64 {
        self.mobility
    }

    /// Whether the fast path is in use.
    pub(super) fn is_fast(&self) -> bool {
        self.linear.is_fast()
    }

    /// How the linear systems are solved at present, in a word.
    pub(super) fn linear_method(&self) -> &'static str {
        match &self.linear.path {
            Path::Factor { .. } => "factor",
            Path::Reduced { preconditioner, .. } => match preconditioner {
                Bulk::Transform(_) => "transform",
                Bulk::Shifted(_) => "shifted",
            },
        }
    }

    /// Leaves the fast path for the factor.
    pub(super) fn fall_back(&mut self, space: &Space) -> Result<(), LinalgError> {
        if self.is_fast() {
            let factor = match self.spare.take() {
                Some(factor) => factor,
                None => LinearSolver::factor(space, &self.fixed)?,
            };
            self.spare = Some(std::mem::replace(&mut self.linear, factor));
        }
        Ok(())
    }

    /// Goes back to the fast path, if it was left.
    pub(super) fn return_to_fast(&mut self) {
        if let Some(spare) = self.spare.as_mut().filter(|spare| spare.is_fast()) {
            std::mem::swap(spare, &mut self.linear);
        }
    }

    /// How the linear systems are solved at present. All else is made anew in every step.
    pub(super) fn remember(&self, memory: &mut LinearMemory) {
        memory.is_fast = self.is_fast();
        let mut solvers = std::iter::once(&self.linear).chain(&self.spare);
        match solvers.find_map(LinearSolver::preconditioner) {
            Some(factor) => factor.remember(&mut memory.factor),
            None => memory.factor.clear(),
        }
    }

    /// Whether this step can solve the linear systems as another did.
    pub(super) fn can_recall(&self, memory: &LinearMemory) -> bool {
        let mut solvers = std::iter::once(&self.linear).chain(&self.spare);
        !memory.is_fast || solvers.any(LinearSolver::is_fast)
    }

    /// Solves the linear systems from now on as they were then, with the same factor.
    ///
    /// # Errors
    /// What a factor may run into.
    pub(super) fn recall(
        &mut self,
        space: &Space,
        memory: &LinearMemory,
    ) -> Result<(), LinalgError> {
        if memory.is_fast {
            self.return_to_fast();
        } else {
            self.fall_back(space)?;
        }
        let solvers = std::iter::once(&mut self.linear).chain(&mut self.spare);
        let mut factors = solvers.filter_map(LinearSolver::preconditioner_mut);
        match factors.next() {
            Some(factor) => factor.recall(&memory.factor),
            None if memory.factor.is_empty() => Ok(()),
            None => {
                let mut solver = LinearSolver::factor(space, &self.fixed)?;
                if let Some(factor) = solver.preconditioner_mut() {
                    factor.recall(&memory.factor)?;
                }
                self.spare = Some(solver);
                Ok(())
            }
        }
    }

    /// Prepares the effects for substep 2 from φⁿ with the new director.
    pub(super) fn begin(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        samples: &mut Samples,
        phi: &[f64],
        director: Option<&[Vec<f64>; 2]>,
    ) {
        let Samples { old, new } = samples;
        let [integrals, _] = &mut self.integrals;
        integrals.clear();
        for patch in space.patches() {
            old.begin();
            old.set_phi(&patch, phi);
            effects.add_integrals(&patch, old, integrals);
            new.begin();
            if let Some(director) = director {
                new.set_director(&patch, director);
            }
            for effect in effects.iter_mut() {
                effect.begin_membrane(&patch, old, new);
            }
        }
    }

    /// ω(φ) from the third equation of (3.21); tells the effects the integrals at φ.
    pub(super) fn solve_omega(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        sample: &mut Sample,
        phi: &[f64],
        omega: &mut [f64],
    ) {
        let [old_integrals, integrals] = &mut self.integrals;
        integrals.clear();
        self.load.fill(0.0);
        for patch in space.patches() {
            sample.begin();
            sample.set_phi(&patch, phi);
            effects.add_integrals(&patch, sample, integrals);
            effects
                .bending
                .add_omega_load(&patch, sample, &mut self.load);
        }
        effects.set_integrals(old_integrals, integrals);
        self.mass_inverse
            .solve(space, &self.load, omega, self.mass_tolerance);
    }

    /// The membrane force of all effects from φⁿ to φ, as a load.
    fn assemble_force(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        samples: &mut Samples,
        [phi_old, phi, omega]: [&[f64]; 3],
    ) {
        let Samples { old, new } = samples;
        self.load.fill(0.0);
        for patch in space.patches() {
            old.begin();
            old.set_phi(&patch, phi_old);
            new.begin();
            new.set_phi(&patch, phi);
            new.set_omega(&patch, omega);
            self.force.clear(&patch);
            for effect in effects.iter_mut() {
                effect.add_membrane_force(&patch, old, new, &mut self.force);
            }
            patch.add_load(&self.force.load, &self.force.flux, &mut self.load);
        }
    }

    /// ω and μ of a state at rest: (μ, ψ) = ⟨δE/δφ, ψ⟩.
    pub(super) fn solve_at_rest(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        samples: &mut Samples,
        state: &mut State,
    ) {
        let State {
            phi,
            omega,
            mu,
            director,
        } = state;
        self.begin(space, effects, samples, phi, director.as_ref());
        self.solve_omega(space, effects, &mut samples.new, phi, omega);
        self.assemble_force(space, effects, samples, [phi, phi, omega]);
        self.mass_inverse
            .solve(space, &self.load, mu, self.mass_tolerance);
    }

    /// Assembles the linearised equations at the iterate in `to`.
    pub(super) fn linearise(&mut self, places: &mut Places<'_>, iteration: Iteration) {
        let Places {
            space,
            effects,
            samples,
            from,
            to,
            ..
        } = places;
        self.linearised.assemble(
            space,
            effects,
            [&mut samples.old, &mut samples.new],
            [&from.phi, &to.phi, &to.omega],
            iteration,
        );
    }

    /// One application of the preconditioner of the fast path; nothing on the other one.
    pub(super) fn precondition(&mut self, x: &[f64], y: &mut [f64]) {
        if let Path::Reduced { preconditioner, .. } = &mut self.linear.path {
            preconditioner.apply(x, y);
        }
    }

    /// A new factor of the linearised equations; nothing on the fast path.
    pub(super) fn refactor(
        &mut self,
        space: &Space,
        dt: f64,
        width: f64,
    ) -> Result<(), LinalgError> {
        if let Path::Factor { preconditioner } = &mut self.linear.path {
            preconditioner.expire();
            let mobility = dt * self.mobility;
            preconditioner.prepare(space, &self.linearised, mobility, width, [1.0; 3])?;
        }
        Ok(())
    }

    /// One application of the linearised operator of the fast path; nothing on the other one.
    pub(super) fn product(&mut self, space: &Space, dt: f64, x: &[f64], y: &mut [f64]) {
        if let Path::Reduced { scratch, .. } = &mut self.linear.path {
            let mut operator = ReducedOperator {
                space,
                linearised: &self.linearised,
                mass_inverse: &mut self.mass_inverse,
                mobility: dt * self.mobility,
                root_weights: &self.root_weights,
                scratch,
            };
            operator.apply(x, y);
        }
    }

    /// ω, (natural boundary) μ, and the residuals at the iterate in `to`; returns the norm of
    /// r₁ + Δtγ K M_L⁻¹ r₂ in the norm of M_L⁻¹.
    pub(super) fn evaluate(
        &mut self,
        places: &mut Places<'_>,
        iteration: u32,
    ) -> Result<f64, StepError> {
        let space = places.space;
        let State { phi, omega, mu, .. } = &mut *places.to;
        let (effects, samples) = (&mut *places.effects, &mut *places.samples);
        faults::tap(faults::Place::Phi, phi);
        self.solve_omega(space, effects, &mut samples.new, phi, omega);
        faults::tap(faults::Place::Omega, omega);
        self.assemble_force(space, effects, samples, [&places.from.phi, phi, omega]);
        if !self.clamped {
            self.mass_inverse
                .solve(space, &self.load, mu, self.mass_tolerance);
        }
        faults::tap(faults::Place::Mu, mu);
        let mobility = places.dt * self.mobility;
        for ((step, phi), old) in self.scratch.iter_mut().zip(&*phi).zip(&places.from.phi) {
            *step = phi - old;
        }
        let [first, second] = &mut self.residual;
        space.mass().multiply(&self.scratch, first);
        space.stiffness().multiply_add(mobility, mu, first);
        faults::tap(faults::Place::Residual, first);
        self.scratch.copy_from_slice(first);
        if self.clamped {
            second.copy_from_slice(&self.load);
            space.mass().multiply_add(-1.0, mu, second);
            second
                .iter_mut()
                .zip(&self.fixed)
                .filter(|(_, fixed)| **fixed)
                .for_each(|(r, _)| *r = 0.0);
            let inverse = self.mass_inverse.inverse_weights();
            let scaled = self.load.iter_mut().zip(&*second).zip(inverse);
            scaled.for_each(|((load, r), inverse)| *load = r * inverse);
            space
                .stiffness()
                .multiply_add(mobility, &self.load, &mut self.scratch);
        }
        let norm =
            vector::weighted_square(&self.scratch, self.mass_inverse.inverse_weights()).sqrt();
        if norm.is_finite() {
            return Ok(norm);
        }
        let finite = |field: &[f64]| field.iter().all(|value| value.is_finite());
        let place = match (finite(phi), finite(omega), finite(mu)) {
            (false, _, _) => "phi",
            (true, false, _) => "omega",
            (true, true, false) => "mu",
            _ => "the residual of substep 2",
        };
        Err(StepError::NotFinite { place, iteration })
    }

    /// To what norm the linearised system is solved: to what the energy law allows (by
    /// the inequality of Cauchy and Schwarz for r₁ᵀμ), but at least by a factor of ten and not
    /// further than Newton's method can use.
    fn linear_goal(&mut self, places: &Places<'_>, limits: Limits, norm: f64) -> f64 {
        let weights = places.space.nodal_weights();
        let domain = vector::sum(weights);
        let mean = vector::dot(weights, &places.to.mu) / domain;
        let square = vector::weighted_square(&places.to.mu, weights) - mean * mean * domain;
        let potential = square.max(0.0).sqrt().max(f64::MIN_POSITIVE);
        let wanted = limits.law_tolerance * places.energy_scale / potential;
        wanted.clamp(1e-8 * norm, 0.1 * norm)
    }

    /// Solves for the increment; returns the Krylov iterations.
    fn solve_linearised(&mut self, places: &Places<'_>, goal: f64) -> Result<u32, LinalgError> {
        let space = places.space;
        let mobility = places.dt * self.mobility;
        let width = places.effects.bending.interface_width();
        let size = space.nodes();
        let floor = self.rounding_floor(places);
        let (r1, rest) = self.linear.right_side.split_at_mut(size);
        let rows = r1.iter_mut().zip(&self.residual[0]).zip(&self.root_weights);
        rows.for_each(|((b, r), root)| *b = -r / root);
        let outcome = match &mut self.linear.path {
            Path::Reduced {
                preconditioner,
                scratch,
            } => {
                preconditioner.prepare(space, mobility, width)?;
                let mut operator = ReducedOperator {
                    space,
                    linearised: &self.linearised,
                    mass_inverse: &mut self.mass_inverse,
                    mobility,
                    root_weights: &self.root_weights,
                    scratch,
                };
                let (b, x) = (&self.linear.right_side, &mut self.linear.increment);
                let outcome = self.linear.gmres.solve(
                    &mut operator,
                    preconditioner,
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
                let size_of = |field: &[f64]| {
                    vector::weighted_square(field, weights)
                        .sqrt()
                        .max(f64::MIN_POSITIVE)
                };
                let row_scales = [
                    1.0,
                    size_of(&places.to.mu).recip(),
                    (width * size_of(&places.to.omega)).recip(),
                ];
                let rows = r2.iter_mut().zip(&self.residual[1]).zip(&self.root_weights);
                rows.for_each(|((b, r), root)| *b = -row_scales[1] * r / root);
                r3.fill(0.0);
                let mut operator = ThreeFieldOperator {
                    space,
                    linearised: &self.linearised,
                    mobility,
                    width,
                    fixed: &self.fixed,
                    row_scales,
                    root_weights: &self.root_weights,
                };
                let (b, x) = (&self.linear.right_side, &mut self.linear.increment);
                let goal = goal.min(1e-2 * vector::norm(b));
                loop {
                    let linearised = &self.linearised;
                    let fresh =
                        preconditioner.prepare(space, linearised, mobility, width, row_scales)?;
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
        faults::tap(faults::Place::Increment, &mut self.linear.increment);
        if !self.linear.increment.iter().all(|value| value.is_finite()) {
            return Err(LinalgError::NotFinite {
                place: "GMRES",
                iteration: outcome.iterations,
            });
        }
        self.conserve(places);
        Ok(outcome.iterations as u32)
    }

    /// Shifts φ's increment by a constant such that ∫φ = ∫φⁿ to rounding after it, however
    /// loosely the system was solved and however large a μ rounding has had to deal with in Kμ, whose
    /// sum is 0. At the wall a given φ stays.
    fn conserve(&mut self, places: &Places<'_>) {
        let weights = places.space.nodal_weights();
        let increment = &mut self.linear.increment[..places.space.nodes()];
        let (mut missing, mut free) = (0.0, 0.0);
        for (node, weight) in weights.iter().enumerate() {
            missing -= weight * (places.to.phi[node] - places.from.phi[node] + increment[node]);
            free += if self.fixed[node] { 0.0 } else { *weight };
        }
        let shift = missing / free;
        for (step, fixed) in increment.iter_mut().zip(&self.fixed) {
            *step += if *fixed { 0.0 } else { shift };
        }
    }

    /// About what rounding makes of r₁: three products with the stiffness matrix lie between φ and it.
    fn rounding_floor(&self, places: &Places<'_>) -> f64 {
        let space = places.space;
        let bulk = places.dt * self.mobility * places.effects.bending.interface_width();
        let weights = space.nodal_weights();
        let phi = vector::weighted_square(&places.to.phi, weights).sqrt();
        10.0 * f64::EPSILON * (1.0 + bulk * self.largest_eigenvalue.powi(3)) * phi
    }

    /// Has the next step make a new factor.
    pub(super) fn forget(&mut self) {
        if let Path::Factor { preconditioner } = &mut self.linear.path {
            preconditioner.expire();
        }
    }
}
