//! The phases of a step, one at a time, for benchmarks. None of them moves the state, so each can be
//! repeated.

use crate::linalg::LinalgError;
use crate::scene::{Iteration, TimeScheme};

use super::director::SolveOptions;
use super::membrane::{MembraneStep, StepContext};
use super::{Scheme, StepError, director_tolerance};

/// A scheme that stands at the guess of its next step.
#[derive(Debug)]
pub struct Phases {
    scheme: Scheme,
    dt: f64,
    vectors: [Vec<f64>; 2],
}

impl Phases {
    /// Goes to the guess of the next step of length Δt, where everything is evaluated and linearised
    /// once.
    ///
    /// # Errors
    /// [`StepError`]: a phase failed.
    pub fn new(scheme: Scheme, dt: f64) -> Result<Self, StepError> {
        let values = scheme.state.phi.iter().copied().cycle();
        let vector: Vec<f64> = values.take(scheme.membrane.unknowns()).collect();
        let vectors = [vector.clone(), vector];
        let mut phases = Self {
            scheme,
            dt,
            vectors,
        };
        phases.director()?;
        let Scheme {
            space,
            effects,
            strips,
            membrane,
            state,
            next,
            history,
            t,
            ..
        } = &mut phases.scheme;
        let director = next.director.as_ref();
        membrane.begin(
            space,
            effects,
            strips,
            (&state.phi, director),
            TimeScheme::FirstOrder,
        );
        history.extrapolate(*t + dt, TimeScheme::FirstOrder, next);
        phases.evaluate()?;
        phases.assemble_jacobian();
        Ok(phases)
    }

    /// Substep 1; returns the iterations.
    ///
    /// # Errors
    /// `Director`: the conjugate gradients failed.
    pub fn director(&mut self) -> Result<u32, StepError> {
        let energy_scale = self.scheme.energy_scale(&self.scheme.report.energies);
        let Scheme {
            space,
            effects,
            state,
            next,
            director,
            solver,
            ..
        } = &mut self.scheme;
        match (director, &state.director, &mut next.director) {
            (Some(step), Some(from), Some(to)) => {
                let options = SolveOptions {
                    scheme: TimeScheme::FirstOrder,
                    is_second: false,
                    dt: self.dt,
                    tolerance: director_tolerance(solver, TimeScheme::FirstOrder),
                    law_tolerance: solver.law_tolerance,
                    is_faint: false,
                    energy_scale,
                };
                let from = (&state.phi[..], from);
                step.solve(space, effects, options, from, to)
            }
            _ => Ok(0),
        }
    }

    /// ω, μ and the residual of substep 2 at the guess; returns the residual's norm.
    ///
    /// # Errors
    /// `NotFinite`.
    pub fn evaluate(&mut self) -> Result<f64, StepError> {
        self.at_guess(|membrane, context| membrane.evaluate(context, 0))
    }

    /// The assembly of the linearised equations.
    pub fn assemble_jacobian(&mut self) {
        self.at_guess(|membrane, context| membrane.assemble_jacobian(context, Iteration::Newton));
    }

    /// One application of the preconditioner.
    pub fn precondition(&mut self) {
        let [x, y] = &mut self.vectors;
        self.scheme.membrane.precondition(x, y);
    }

    /// One product of the Krylov iteration.
    pub fn product(&mut self) {
        let [x, y] = &mut self.vectors;
        let Scheme {
            space, membrane, ..
        } = &mut self.scheme;
        membrane.product(space, self.dt, x, y);
    }

    /// A new sparse factor of the three fields' system, where the factor is in use.
    ///
    /// # Errors
    /// The system is singular.
    pub fn refactor(&mut self) -> Result<(), LinalgError> {
        let Scheme {
            space, membrane, ..
        } = &mut self.scheme;
        membrane.refactor(space, self.dt)
    }

    fn at_guess<R>(
        &mut self,
        phase: impl FnOnce(&mut MembraneStep, &mut StepContext<'_>) -> R,
    ) -> R {
        let scheme = &mut self.scheme;
        let energy_scale = scheme.energy_scale(&scheme.report.energies);
        let mut context = StepContext {
            space: &scheme.space,
            effects: &mut scheme.effects,
            strips: &mut scheme.strips,
            from: &scheme.state,
            to: &mut scheme.next,
            dt: self.dt,
            scheme: TimeScheme::FirstOrder,
            is_faint: false,
            energy_scale,
            watch: &mut |_| (),
        };
        phase(&mut scheme.membrane, &mut context)
    }
}
