//! A pull on the membrane, E_pull = −∫ φ U with a given potential U(x): the vesicle is drawn to where
//! U is large. U = −g y is a weight, U = −½ κ |x − a|² a harmonic tweezer at a.
//!
//! The energy is linear in φ: its force −U does not depend on the state, and nothing is dissipated
//! numerically. Since ∫φ is conserved, a constant added to U changes the energy by a constant.

use super::patch_fields::at_points;
use super::{
    DirectorCoupling, Effect, EffectContext, Kept, MembraneForce, PatchFields, PatchStep, Room,
};
use crate::fem::{Patch, Space};
use crate::scene;

/// The effect, where the scene has it.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let pull = context.scene.pull.as_ref()?;
    Some(Box::new(Pull::new(pull, context.space)))
}

/// A pull on the membrane.
#[derive(Debug)]
pub struct Pull {
    /// U at the points.
    potential: Vec<f64>,
}

impl Pull {
    /// U of a scene.
    pub fn new(pull: &scene::Pull, space: &Space) -> Self {
        Self {
            potential: at_points(&pull.potential, space),
        }
    }
}

impl Effect for Pull {
    fn name(&self) -> &'static str {
        "pull"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, room: &mut Room) -> f64 {
        let potential = &self.potential[patch.point_range()];
        let density = &mut room.points;
        density.clear();
        density.extend(potential.iter().zip(&at.phi).map(|(u, phi)| -u * phi));
        patch.integrate(density)
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    /// (−U, ψ).
    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let patch = step.patch;
        let potential = &self.potential[patch.point_range()];
        for (load, u) in force.load.iter_mut().zip(potential) {
            *load -= u;
        }
    }
}
