//! Substep 2: the nonlinear system (3.21) for (φ, μ, ω), by Newton's method, damped, or by the
//! iteration (4.35), which leaves out of the derivative what it takes from the last iterate.
//!
//! ω always solves its equation exactly. With the natural boundary μ solves the second equation
//! exactly too, and what is left is the residual of the first,
//!   r₁ = M(φ − φⁿ) + Δtγ_ben K μ(φ).
//! With the clamped boundary there is no second equation at the wall, μ is an unknown of its own and
//! the residual is (r₁, r₂).

mod iteration;
mod linear;

use crate::fem::{LoadEntries, MassInverse, Space};
use crate::linalg::{LinalgError, LinearOperator, vector};
use crate::physics::{Effects, PatchStep};
use crate::scene::{Iteration, LinearMethod, Membrane, TimeScheme};

use super::fault_injection;
use super::jacobian::Jacobian;
use super::rounding::{self, Least};
use super::solvers::grid::ReducedOperator;
use super::strips::{Strip, Strips};
use super::{Phase, State, StepError};

use linear::{LinearSolver, Path};

pub(super) use iteration::{NewtonOptions, StoppingCriterion, Work};
pub(super) use linear::LinearCheckpoint;

/// Accuracy of the solves with the mass matrix, over the tolerance of the energy law: so far below it
/// that the second and the third equation of (3.21) may be taken as exact.
const MASS_ACCURACY: f64 = 1e-2;

/// Substep 2 with its matrices and vectors.
#[derive(Debug)]
pub(super) struct MembraneStep {
    /// γ_ben.
    mobility: f64,
    /// ε.
    interface_width: f64,
    /// What ω, μ and the energy are at least where they say something.
    least: Least,
    /// Relative accuracy of the solves with the mass matrix.
    mass_tolerance: f64,
    /// Nodes where φ is given (clamped boundary).
    fixed: Vec<bool>,
    clamped: bool,
    linear: LinearSolver,
    /// The other one, while both are in use in turn.
    standby: Option<LinearSolver>,
    mass_inverse: MassInverse,
    jacobian: Jacobian,
    entries: Vec<LoadEntries>,
    /// The integrals that forces need, at φⁿ and at the iterate.
    integrals: [Vec<f64>; 2],
    /// r₁ and r₂; r₂ stays zero with the natural boundary.
    residual: [Vec<f64>; 2],
    load: Vec<f64>,
    /// ω_θ.
    implicit: Vec<f64>,
    /// φ, ω, μ of the last iterate.
    last: [Vec<f64>; 3],
    /// Newton's correction at the last iterate, while that of a trial takes its place.
    correction: Vec<f64>,
    scratch: Vec<f64>,
    root_weights: Vec<f64>,
    /// A bound of the eigenvalues of M_L⁻¹ K.
    largest_eigenvalue: f64,
}

/// The places of a step: what it starts from, where it goes.
pub(super) struct StepContext<'a> {
    pub(super) space: &'a Space,
    pub(super) effects: &'a mut Effects,
    pub(super) strips: &'a mut Strips,
    pub(super) from: &'a State,
    pub(super) to: &'a mut State,
    pub(super) dt: f64,
    pub(super) scheme: TimeScheme,
    /// Whether the state hardly bends, and may be at rest.
    pub(super) is_faint: bool,
    /// S, the scale of the energy law.
    pub(super) energy_scale: f64,
    /// Told of every phase that ends.
    pub(super) watch: &'a mut (dyn FnMut(Phase) + Send),
}

impl StepContext<'_> {
    /// Takes the last state as the guess, in place of an iterate that diverged.
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
        membrane: &Membrane,
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
        let linear = LinearSolver::of(space, method, clamped, &fixed)?;
        Ok(Self {
            mobility: membrane.mobility,
            interface_width: membrane.interface_width,
            least: Least::new(space, membrane.interface_width, law_tolerance),
            mass_tolerance: (MASS_ACCURACY * law_tolerance).clamp(1e-15, 1e-10),
            clamped,
            linear,
            standby: None,
            mass_inverse: MassInverse::new(space),
            jacobian: Jacobian::new(space),
            entries: vec![LoadEntries::default(); space.groups()],
            integrals: [Vec::new(), Vec::new()],
            residual: [vector(), vector()],
            load: vector(),
            implicit: vector(),
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

    /// Another γ_ben.
    pub(super) fn set_mobility(&mut self, mobility: f64) {
        self.mobility = mobility;
    }

    /// ε.
    pub(super) fn interface_width(&self) -> f64 {
        self.interface_width
    }

    /// The least energy that the law can resolve.
    pub(super) fn least_energy(&self) -> f64 {
        self.least.energy
    }

    /// Prepares the effects for substep 2 from φⁿ with the new director.
    pub(super) fn begin(
        &mut self,
        space: &Space,
        effects: &Effects,
        strips: &mut Strips,
        state: (&[f64], Option<&[Vec<f64>; 2]>),
        scheme: TimeScheme,
    ) {
        let [integrals, _] = &mut self.integrals;
        integrals.clear();
        integrals.extend(strips.begin_membrane(space, effects, state, scheme));
    }

    /// ω(φ) from the third equation of (3.21); tells the effects the integrals at φ.
    pub(super) fn solve_omega(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        strips: &mut Strips,
        phi: &[f64],
        omega: &mut [f64],
    ) {
        let all: &Effects = effects;
        let entries = ([&mut self.entries[..]], all.count());
        let sums = strips.sum_over(space, entries, |patch, _, strip, [entries]| {
            let Strip {
                new,
                room,
                force,
                sums,
                ..
            } = strip;
            new.begin();
            new.set_phi(patch, phi);
            all.add_integrals(patch, new, sums, room);
            all.bending.omega_density(patch, new, &mut force.load);
            patch.load_entries(&force.load, &new.phi_gradient, entries);
        });
        let [old_integrals, integrals] = &mut self.integrals;
        integrals.clear();
        integrals.extend(sums);
        effects.set_integrals(old_integrals, integrals);
        self.load.fill(0.0);
        space.collect_load(&self.entries, &strips.first().force.load, &mut self.load);
        self.mass_inverse
            .solve(space, &self.load, omega, self.mass_tolerance);
    }

    /// The membrane force of all effects from φⁿ to φ with ω_θ, as a load.
    fn assemble_force(
        &mut self,
        space: &Space,
        effects: &Effects,
        strips: &mut Strips,
        [phi_old, phi]: [&[f64]; 2],
        scheme: TimeScheme,
    ) {
        let omega = &self.implicit;
        let entries = [&mut self.entries[..]];
        strips.over(space, entries, |patch, number, strip, [entries]| {
            let Strip {
                old,
                new,
                force,
                kept,
                ..
            } = strip;
            old.begin();
            old.set_phi(patch, phi_old);
            new.begin();
            new.set_phi(patch, phi);
            new.set_omega(patch, omega);
            force.clear(patch);
            let step = PatchStep {
                patch,
                old,
                new,
                scheme,
            };
            for (effect, kept) in effects.iter().zip(&kept[number]) {
                effect.add_membrane_force(&step, kept, force);
            }
            patch.load_entries(&force.load, &force.flux, entries);
        });
        self.load.fill(0.0);
        space.collect_load(&self.entries, &strips.first().force.load, &mut self.load);
    }

    /// ω and μ of a state at rest: (μ, ψ) = ⟨δE/δφ, ψ⟩.
    pub(super) fn solve_at_rest(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        strips: &mut Strips,
        state: &mut State,
    ) {
        let State {
            phi,
            omega,
            mu,
            director,
        } = state;
        let scheme = TimeScheme::FirstOrder;
        self.begin(space, effects, strips, (phi, director.as_ref()), scheme);
        self.solve_omega(space, effects, strips, phi, omega);
        self.implicit.copy_from_slice(omega);
        self.assemble_force(space, effects, strips, [phi, phi], scheme);
        self.mass_inverse
            .solve(space, &self.load, mu, self.mass_tolerance);
    }

    /// Assembles the linearised equations at the iterate in `to`.
    pub(super) fn assemble_jacobian(
        &mut self,
        context: &mut StepContext<'_>,
        iteration: Iteration,
    ) {
        let StepContext {
            space,
            effects,
            strips,
            from,
            to,
            scheme,
            ..
        } = context;
        self.jacobian.assemble(
            space,
            effects,
            strips,
            [&from.phi, &to.phi, &self.implicit],
            self.interface_width,
            (iteration, *scheme),
        );
    }

    /// How many unknowns the linear systems have.
    pub(super) fn unknowns(&self) -> usize {
        self.linear.increment.len()
    }

    /// One application of the preconditioner, as the last solve left it.
    pub(super) fn precondition(&mut self, x: &[f64], y: &mut [f64]) {
        match &mut self.linear.path {
            Path::Reduced { preconditioner, .. } => preconditioner.apply(x, y),
            Path::Factor { preconditioner } => preconditioner.apply(x, y),
        }
    }

    /// A new factor of the linearised equations; nothing on the fast path.
    pub(super) fn refactor(&mut self, space: &Space, dt: f64) -> Result<(), LinalgError> {
        if let Path::Factor { preconditioner } = &mut self.linear.path {
            preconditioner.expire();
            let step_mobility = dt * self.mobility;
            let width = self.interface_width;
            preconditioner.prepare(space, &self.jacobian, step_mobility, width, [1.0; 3])?;
        }
        Ok(())
    }

    /// One application of the linearised operator of the fast path; nothing on the other one.
    pub(super) fn product(&mut self, space: &Space, dt: f64, x: &[f64], y: &mut [f64]) {
        if let Path::Reduced { scratch, .. } = &mut self.linear.path {
            let mut operator = ReducedOperator {
                space,
                jacobian: &self.jacobian,
                mass_inverse: &mut self.mass_inverse,
                step_mobility: dt * self.mobility,
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
        context: &mut StepContext<'_>,
        iteration: u32,
    ) -> Result<f64, StepError> {
        let space = context.space;
        let State { phi, omega, mu, .. } = &mut *context.to;
        let (effects, strips) = (&mut *context.effects, &mut *context.strips);
        fault_injection::tap(fault_injection::Place::Phi, phi);
        self.solve_omega(space, effects, strips, phi, omega);
        fault_injection::tap(fault_injection::Place::Omega, omega);
        let scheme = context.scheme;
        for ((implicit, old), new) in self
            .implicit
            .iter_mut()
            .zip(&context.from.omega)
            .zip(&*omega)
        {
            *implicit = scheme.implicit(*old, *new);
        }
        self.assemble_force(space, effects, strips, [&context.from.phi, phi], scheme);
        if !self.clamped {
            self.mass_inverse
                .solve(space, &self.load, mu, self.mass_tolerance);
        }
        fault_injection::tap(fault_injection::Place::Mu, mu);
        let step_mobility = context.dt * self.mobility;
        for ((step, phi), old) in self.scratch.iter_mut().zip(&*phi).zip(&context.from.phi) {
            *step = phi - old;
        }
        let [first, second] = &mut self.residual;
        space.mass().multiply(&self.scratch, first);
        space.stiffness().multiply_add(step_mobility, mu, first);
        fault_injection::tap(fault_injection::Place::Residual, first);
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
                .multiply_add(step_mobility, &self.load, &mut self.scratch);
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
}
