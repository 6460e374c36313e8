//! The energies: potentials, and one file an effect.

mod anchoring;
mod area;
mod bending;
mod effect;
mod field;
mod nematic;
mod noise;
pub mod potentials;
mod pull;
mod sample;
#[cfg(test)]
mod tests;

use crate::fem::{Patch, Space};
use crate::scene::{self, AnchoringKind, Scene};

use anchoring::NAME as ANCHORING;

pub use anchoring::Anchoring;
pub use area::{Area, area_integral, surface_area};
pub use bending::{Bending, bending_energy_density};
pub use effect::{
    DirectorForm, DirectorReach, Effect, Interval, MembraneForce, MembraneLinearisation,
    NamedValue, RankOne, Terms,
};
pub use field::Field;
pub use nematic::Nematic;
pub use noise::Noise;
pub use pull::Pull;
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

    /// Where a scene becomes effects. φ⁰ is given at the nodes.
    pub fn from_scene(scene: &Scene, space: &Space, phi: &[f64]) -> Self {
        let width = scene.membrane.interface_width;
        let mut effects = Self::new(Bending::new(&scene.membrane, space));
        if let Some(area) = &scene.area {
            effects.add(Area::new(
                area,
                width,
                surface_area(space, phi, width),
                space,
            ));
        }
        if let Some(nematic) = &scene.nematic {
            effects.add(Nematic::new(nematic, space));
            if let Some(noise) = &scene.noise {
                effects.add(Noise::new(noise, nematic.mobility));
            }
        }
        if let Some(field) = &scene.field {
            effects.add(Field::new(field, space));
        }
        if let Some(pull) = &scene.pull {
            effects.add(Pull::new(pull, space));
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

    /// Tells all effects the time of the step that comes. Whether the energy of a state is another one
    /// now, as that of a field that was switched on.
    pub fn set_interval(&mut self, interval: Interval) -> bool {
        let mut changed = false;
        for effect in self.iter_mut() {
            changed |= effect.set_interval(interval);
        }
        changed
    }

    /// How strongly all effects together act on the director; `None`: nobody knows.
    pub fn director_reach(&self) -> Option<DirectorReach> {
        self.iter().try_fold(DirectorReach::NOWHERE, |sum, effect| {
            effect.director_reach().map(|reach| sum + reach)
        })
    }

    /// sums ← sums + the patch's shares of the integrals that forces need, effect by effect.
    pub fn add_integrals(&mut self, patch: &Patch<'_>, at: &Sample, sums: &mut Vec<f64>) {
        sums.resize(1 + self.others.len(), 0.0);
        for (effect, sum) in self.iter_mut().zip(sums) {
            if effect.needs_integrals() {
                *sum += effect.integral(patch, at);
            }
        }
    }

    /// Tells the effects whose forces need them the integrals at φⁿ and at φ.
    pub fn set_integrals(&mut self, old: &[f64], new: &[f64]) {
        for (effect, (old, new)) in self.iter_mut().zip(old.iter().zip(new)) {
            if effect.needs_integrals() {
                effect.set_integrals(*old, *new);
            }
        }
    }
}
