//! The fields of a run at one time, and what is known about a step.

use serde::{Deserialize, Serialize};

use super::StepError;
use crate::physics::NamedValue;

/// The fields: nodal values on the mesh.
#[derive(Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// φ: +1 inside the vesicle, −1 outside.
    pub phi: Vec<f64>,
    /// ω, the bending variable.
    pub omega: Vec<f64>,
    /// μ = δE/δφ.
    pub mu: Vec<f64>,
    /// d: its x and its y components; `None` without the table `nematic`.
    pub director: Option<[Vec<f64>; 2]>,
}

impl Clone for State {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Allocates only where there is no room yet.
    fn clone_from(&mut self, source: &Self) {
        self.phi.clone_from(&source.phi);
        self.omega.clone_from(&source.omega);
        self.mu.clone_from(&source.mu);
        self.director.clone_from(&source.director);
    }
}

impl State {
    /// Whether it has the same fields as another, with as many values.
    pub fn fits(&self, other: &Self) -> bool {
        let lengths = |state: &Self| {
            let director = state.director.as_ref();
            let director = director.map(|director| director.each_ref().map(Vec::len));
            (
                [&state.phi, &state.omega, &state.mu].map(Vec::len),
                director,
            )
        };
        lengths(self) == lengths(other)
    }

    /// The first field with a value that is not finite.
    pub fn first_not_finite(&self) -> Option<&'static str> {
        let fields = [("phi", &self.phi), ("omega", &self.omega), ("mu", &self.mu)];
        let director = self.director.iter().flatten().map(|field| ("d", field));
        fields
            .into_iter()
            .chain(director)
            .find(|(_, field)| !field.iter().all(|value| value.is_finite()))
            .map(|(name, _)| name)
    }
}

/// What a step was: energies, the energy law, the work done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepReport {
    /// The energy of each effect, weighted as in E_tot.
    pub energies: Vec<NamedValue>,
    /// E_tot.
    pub total_energy: f64,
    /// A = ∫φ.
    pub phase_integral: f64,
    /// B, the surface area.
    pub surface_area: f64,
    /// Every term of (3.26) times Δt.
    pub ledger: Vec<NamedValue>,
    /// Δt·(left side of 3.26)/S, S the sum of the absolute energies and of the work from outside.
    pub law_residual: f64,
    /// Iterations of substep 2.
    pub newton: u32,
    /// Products with the linearised operator, all iterations together.
    pub krylov: u32,
    /// What is left of the algebraic error of φ at most, relative, in L2: its change in the last iteration of
    /// substep 2, or in the secant scheme the changes that would follow.
    pub algebraic_error: f64,
    /// Iterations of the conjugate gradients of substep 1.
    pub director_iterations: u32,
    /// The work that changes of parameters have done before the step: by how much the energy of that state became another
    /// one.
    pub change_work: Option<f64>,
    /// Why the transform failed in this step and the factor took over, if that happened.
    pub fallback: Option<StepError>,
    /// Why the lagged iteration failed in this step and Newton's method took over, if that happened.
    pub newton_took_over: Option<StepError>,
    /// How many ways to solve substep 2 failed before the one that did it.
    pub refused_ways: u32,
    /// The smallest damping factor of Newton's method; 1: it was not damped.
    pub damping: f64,
}

impl StepReport {
    /// Takes in the part of the same step before this one.
    pub(super) fn add(&mut self, before: Self) {
        self.newton += before.newton;
        self.krylov += before.krylov;
        self.director_iterations += before.director_iterations;
        self.refused_ways += before.refused_ways;
        self.damping = self.damping.min(before.damping);
        if let Some(work) = before.change_work {
            *self.change_work.get_or_insert(0.0) += work;
        }
        self.fallback = before.fallback.or(self.fallback.take());
        self.newton_took_over = before.newton_took_over.or(self.newton_took_over.take());
        if before.law_residual.abs() > self.law_residual.abs() {
            self.law_residual = before.law_residual;
        }
        NamedValue::add_all(&mut self.ledger, before.ledger);
    }
}

/// A part of a step, reported when it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Substep 1.
    Director,
    /// ω, μ and the residual of substep 2 at an iterate.
    Residual,
    /// The linearised equations, assembled.
    Linearisation,
    /// The linear system of substep 2, solved.
    Krylov,
    /// The energies and the energy law.
    Ledger,
}

impl Phase {
    /// All of them, in the order of a step.
    pub const ALL: [Self; 5] = [
        Self::Director,
        Self::Residual,
        Self::Linearisation,
        Self::Krylov,
        Self::Ledger,
    ];
}
