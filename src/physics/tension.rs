//! A line tension, E_tension = ½ σ ∫ |∇φ|². (The example of the guide's page "Adding an effect".)

use super::{
    DirectorCoupling, Effect, EffectContext, LedgerTerms, MembraneForce, MembraneJacobian,
    PatchFields,
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
    fn integral(&mut self, patch: &Patch<'_>, at: &PatchFields) -> f64 {
        let squares = at.phi_gradient.iter().map(Vector::norm_squared);
        0.5 * self.weight * patch.integrate_elements_of(squares)
    }

    /// It leaves the director alone.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    /// The force: σ (∇φ, ∇ψ), at the new φ, for the energy is convex.
    fn add_membrane_force(
        &mut self,
        _patch: &Patch<'_>,
        _old: &PatchFields,
        new: &PatchFields,
        force: &mut MembraneForce,
    ) {
        for (flux, gradient) in force.flux.iter_mut().zip(&new.phi_gradient) {
            *flux += self.weight * gradient;
        }
    }

    /// Its derivative: σ times the unit tensor.
    fn add_membrane_jacobian(
        &mut self,
        _patch: &Patch<'_>,
        _old: &PatchFields,
        _new: &PatchFields,
        _iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        for tensor in &mut jacobian.tensor {
            *tensor += SymmetricTensor::isotropic(self.weight);
        }
    }

    /// What that loses: Δt ND = ½ σ ∫ |∇(φ − φⁿ)|² ≥ 0.
    fn add_dissipation(
        &mut self,
        patch: &Patch<'_>,
        old: &PatchFields,
        new: &PatchFields,
        terms: &mut LedgerTerms,
    ) {
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let squares = gradients.map(|(new, old)| (new - old).norm_squared());
        let loss = patch.integrate_elements_of(squares);
        terms.add("ND_tension", 0.5 * self.weight * loss);
    }
}
