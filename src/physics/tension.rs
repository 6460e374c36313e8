//! A line tension, E_tension = ½ σ ∫ |∇φ|². (The example of the guide's page "Adding an effect".)

use super::{
    DirectorCoupling, Effect, EffectContext, Kept, LedgerTerms, MembraneForce, MembraneJacobian,
    PatchFields, PatchStep, Room,
};
use crate::fem::Patch;
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{self, Iteration};

/// The effect, where the scene has its table.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let tension = context.scene.tension.as_ref()?;
    Some(Box::new(Tension::new(tension)))
}

/// A line tension.
#[derive(Debug)]
pub struct Tension {
    /// σ.
    weight: f64,
}

impl Tension {
    /// σ of a scene.
    pub fn new(tension: &scene::Tension) -> Self {
        Self {
            weight: tension.weight,
        }
    }
}

impl Effect for Tension {
    /// The column E_tension.
    fn name(&self) -> &'static str {
        "tension"
    }

    /// The energy: ½ σ |∇φ|².
    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        let squares = at.phi_gradient.iter().map(Vector::norm_squared);
        0.5 * self.weight * patch.integrate_elements_of(squares)
    }

    /// It leaves the director alone.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    /// The force: σ (∇φ_θ, ∇ψ), with φ_θ the new φ in the scheme of first order, for the energy is convex, and the mean of
    /// both in the secant scheme.
    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let gradients = old.phi_gradient.iter().zip(&new.phi_gradient);
        for (flux, (old, new)) in force.flux.iter_mut().zip(gradients) {
            *flux += self.weight * scheme.implicit(*old, *new);
        }
    }

    /// Its derivative: θσ times the unit tensor.
    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        for tensor in &mut jacobian.tensor {
            *tensor += SymmetricTensor::isotropic(step.scheme.weight() * self.weight);
        }
    }

    /// What that loses in the scheme of first order: Δt ND = ½ σ ∫ |∇(φ − φⁿ)|² ≥ 0.
    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        terms: &mut LedgerTerms,
        _: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let squares = gradients.map(|(new, old)| (new - old).norm_squared());
        let loss = patch.integrate_elements_of(squares);
        terms.add("ND_tension", 0.5 * self.weight * loss);
    }
}
