//! The energies: potentials, and one file an effect.

mod anchoring;
mod area;
mod bending;
mod effect;
mod nematic;
pub mod potentials;
mod sample;
#[cfg(test)]
mod tests;

use crate::fem::Space;
use crate::scene::{self, AnchoringKind, Scene};

use anchoring::NAME as ANCHORING;

pub use anchoring::Anchoring;
pub use area::{Area, surface_area};
pub use bending::{Bending, bending_energy_density};
pub use effect::{DirectorForm, Effect, MembraneForce, MembraneLinearisation, NamedValue, RankOne};
pub use nematic::Nematic;
pub use sample::{DirectorSample, Sample};

/// The effects of a scene: bending, which every membrane has and whose ω is an unknown of the
/// scheme, and those that the scene names.
#[derive(Debug)]
pub struct Effects {
    /// The bending energy.
    pub bending: Bending,
    others: Vec<Box<dyn Effect>>,
}

impl Effects {
    /// Only bending.
    pub fn new(bending: Bending) -> Self {
        Self {
            bending,
            others: Vec::new(),
        }
    }

    /// Where a scene becomes effects. `initial` is φ⁰ (and d⁰) on the space.
    pub fn from_scene(scene: &Scene, space: &Space, initial: &Sample) -> Self {
        let width = scene.membrane.interface_width;
        let mut effects = Self::new(Bending::new(&scene.membrane, space));
        if let Some(area) = &scene.area {
            effects.add(Area::new(area, width, space, initial));
        }
        if let Some(nematic) = &scene.nematic {
            effects.add(Nematic::new(nematic, space));
        }
        effects.set_anchoring(scene.anchoring.as_ref(), space);
        effects
    }

    /// Puts an anchoring in the place of the present one; of the kind "none" it is no effect.
    pub fn set_anchoring(&mut self, anchoring: Option<&scene::Anchoring>, space: &Space) {
        self.others.retain(|effect| effect.name() != ANCHORING);
        if let Some(anchoring) = anchoring
            && anchoring.kind != AnchoringKind::None
        {
            self.add(Anchoring::new(anchoring, space));
        }
    }

    /// Adds an effect.
    pub fn add(&mut self, effect: impl Effect + 'static) {
        self.others.push(Box::new(effect));
    }

    /// All effects, bending first.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut (dyn Effect + 'static)> {
        let bending: &mut dyn Effect = &mut self.bending;
        std::iter::once(bending).chain(self.others.iter_mut().map(|effect| &mut **effect))
    }

    /// All effects, bending first.
    pub fn iter(&self) -> impl Iterator<Item = &(dyn Effect + 'static)> {
        let bending: &dyn Effect = &self.bending;
        std::iter::once(bending).chain(self.others.iter().map(|effect| &**effect))
    }
}
