//! An effect of its own, for the membrane.

use vesica::fem::{Patch, Space};
use vesica::physics::potentials::double_well;
use vesica::physics::{Effect, MembraneForce, MembraneJacobian, PatchFields};
use vesica::scene::Iteration;

/// A function of the new and the old φ.
pub type OfTwo = fn(f64, f64) -> f64;

/// The energy w ∫F(φ) with a secant of F, right or wrong.
#[derive(Debug)]
pub struct Well {
    weight: f64,
    secant: OfTwo,
    secant_slope: OfTwo,
    /// w ∫F(φ⁰).
    at_start: f64,
}

impl Well {
    /// With the energy 0 at the start.
    pub fn new(secant: OfTwo, secant_slope: OfTwo, space: &Space, phi: &[f64]) -> Self {
        let mut well = Self {
            weight: 300.0,
            secant,
            secant_slope,
            at_start: 0.0,
        };
        let mut start = PatchFields::default();
        start.set_phi(&space.whole(), phi);
        well.at_start = well.integral(&space.whole(), &start);
        well
    }
}

impl Effect for Well {
    fn name(&self) -> &'static str {
        "well"
    }

    fn integral(&mut self, patch: &Patch<'_>, at: &PatchFields) -> f64 {
        let density: Vec<f64> = at.phi.iter().map(|phi| double_well(*phi)).collect();
        self.weight * patch.integrate(&density)
    }

    fn energy(&self, integral: f64) -> f64 {
        integral - self.at_start
    }

    fn add_membrane_force(
        &mut self,
        _patch: &Patch<'_>,
        old: &PatchFields,
        new: &PatchFields,
        force: &mut MembraneForce,
    ) {
        let values = new.phi.iter().zip(&old.phi);
        for (load, (new, old)) in force.load.iter_mut().zip(values) {
            *load += self.weight * (self.secant)(*new, *old);
        }
    }

    fn add_membrane_jacobian(
        &mut self,
        _patch: &Patch<'_>,
        old: &PatchFields,
        new: &PatchFields,
        _iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let values = new.phi.iter().zip(&old.phi);
        for (reaction, (new, old)) in jacobian.reaction.iter_mut().zip(values) {
            *reaction += self.weight * (self.secant_slope)(*new, *old);
        }
    }
}
