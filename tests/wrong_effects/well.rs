//! An effect of its own, for the membrane.

use vesica::internal::fem::Space;
use vesica::internal::physics::potentials::double_well;
use vesica::internal::scene::TimeScheme;
use vesica::{
    Effect, Iteration, Kept, MembraneForce, MembraneJacobian, Patch, PatchFields, PatchStep, Room,
};

/// A function of the new and the old φ.
pub type OfTwo = fn(f64, f64) -> f64;

/// A secant of F, right or wrong, and its derivative.
pub type Secant = [OfTwo; 2];

/// The energy w ∫F(φ) with a secant for each scheme.
#[derive(Debug)]
pub struct Well {
    weight: f64,
    first_order: Secant,
    second_order: Secant,
    /// w ∫F(φ⁰).
    at_start: f64,
}

impl Well {
    /// With the energy 0 at the start.
    pub fn new([first_order, second_order]: [Secant; 2], space: &Space, phi: &[f64]) -> Self {
        let mut well = Self {
            weight: 300.0,
            first_order,
            second_order,
            at_start: 0.0,
        };
        let mut start = PatchFields::default();
        start.set_phi(&space.whole(), phi);
        well.at_start = well.integral(&space.whole(), &start, &mut Room::default());
        well
    }

    fn secant(&self, scheme: TimeScheme) -> Secant {
        match scheme {
            TimeScheme::FirstOrder => self.first_order,
            TimeScheme::Secant => self.second_order,
        }
    }
}

impl Effect for Well {
    fn name(&self) -> &'static str {
        "well"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        let density: Vec<f64> = at.phi.iter().map(|phi| double_well(*phi)).collect();
        self.weight * patch.integrate(&density)
    }

    fn energy(&self, integral: f64) -> f64 {
        integral - self.at_start
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let [secant, _] = self.secant(scheme);
        let values = new.phi.iter().zip(&old.phi);
        for (load, (new, old)) in force.load.iter_mut().zip(values) {
            *load += self.weight * secant(*new, *old);
        }
    }

    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let [_, slope] = self.secant(scheme);
        let values = new.phi.iter().zip(&old.phi);
        for (reaction, (new, old)) in jacobian.reaction.iter_mut().zip(values) {
            *reaction += self.weight * slope(*new, *old);
        }
    }
}
