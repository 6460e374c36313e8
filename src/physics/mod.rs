//! The energies: potentials, and one file an effect.

mod bending;
mod effect;
mod patch_fields;
pub mod potentials;
#[cfg(test)]
mod tests;

/// Declares the modules of the effects, and from it what makes them: `of_scene` of each.
macro_rules! effects {
    ($($(#[cfg($cfg:meta)])? $name:ident,)*) => {
        $($(#[cfg($cfg)])? mod $name;)*

        /// Each gives its effect, if the scene names it.
        const MAKERS: &[fn(&EffectContext<'_>) -> Option<Box<dyn Effect>>] =
            &[$($(#[cfg($cfg)])? $name::of_scene),*];

        /// For each, whether its table is the same in two scenes.
        const COMPARERS: &[fn(&Scene, &Scene) -> bool] =
            &[$($(#[cfg($cfg)])? |one, other| one.$name == other.$name),*];

        /// The names of the effects, in the order of their energies in `history.csv`.
        pub const EFFECTS: &[&str] = &[$($(#[cfg($cfg)])? stringify!($name)),*];

        // Every effect has its table and every table of an effect its file here, or this does not compile.
        const _: scene::EachEffect<()> = scene::EachEffect {
            $($(#[cfg($cfg)])? $name: (),)*
        };
    };
}

// One line an effect, in the order of their energies in `history.csv`. Bending is not among them, for
// every membrane has it; the last one is the guide's example. (`cargo fmt` does not look into a macro: `.ci/run`
// formats these files by name.)
effects! {
    area,
    nematic,
    noise,
    field,
    pull,
    anchoring,
    #[cfg(test)]
    tension,
}

use crate::fem::{Patch, Space};
use crate::scene::{self, Scene};

pub use anchoring::Anchoring;
pub use area::{Area, area_integral, surface_area};
pub use bending::{Bending, bending_energy_density};
pub use effect::{
    DirectorCoupling, DirectorForm, Effect, Interval, Kept, LedgerTerms, MembraneForce,
    MembraneJacobian, NamedValue, PatchStep, RankOne, Room,
};
pub use field::Field;
pub use nematic::Nematic;
pub use noise::Noise;
pub use patch_fields::{DirectorFields, PatchFields};

// Named by unit tests only.
#[cfg(test)]
pub(crate) use pull::Pull;

/// What effects are made from.
#[derive(Debug, Clone, Copy)]
pub struct EffectContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where its fields live.
    pub space: &'a Space,
    /// B(φ⁰) by the run's quadrature.
    pub initial_area: f64,
}

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

    /// Where a scene becomes effects, given B(φ⁰).
    pub fn from_scene(scene: &Scene, space: &Space, initial_area: f64) -> Self {
        let context = EffectContext {
            scene,
            space,
            initial_area,
        };
        let others = MAKERS.iter().filter_map(|make| make(&context));
        Self {
            bending: Bending::new(&scene.membrane, space),
            others: others.collect(),
        }
    }

    /// Makes each effect again whose parameters differ between `before` and the scene of `context`. The effects keep the
    /// order that a scene with these parameters would have from the start.
    pub fn change(&mut self, before: &Scene, context: &EffectContext<'_>) {
        let EffectContext { scene, space, .. } = context;
        if scene.membrane != before.membrane {
            self.bending = Bending::new(&scene.membrane, space);
        }
        let mut present = std::mem::take(&mut self.others);
        for (number, name) in EFFECTS.iter().enumerate() {
            let place = present.iter().position(|effect| effect.name() == *name);
            let effect = place.map(|place| present.remove(place));
            // Noise needs a parameter of the nematic.
            let is_same = COMPARERS[number](before, scene) && before.nematic == scene.nematic;
            self.others.extend(match is_same {
                true => effect,
                false => MAKERS[number](context),
            });
        }
        // Those that came by themselves.
        self.others.append(&mut present);
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

    /// Tells all effects the time of the step that comes.
    pub fn set_interval(&mut self, interval: Interval) {
        self.iter_mut()
            .for_each(|effect| effect.set_interval(interval));
    }

    /// How strongly all effects together act on the director; `None`: nobody knows.
    pub fn director_coupling(&self) -> Option<DirectorCoupling> {
        self.iter().try_fold(DirectorCoupling::NONE, |sum, effect| {
            effect.director_coupling().map(|reach| sum + reach)
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        1 + self.others.len()
    }

    /// sums ← sums + the patch's shares of the integrals that forces need, effect by effect.
    pub fn add_integrals(
        &self,
        patch: &Patch<'_>,
        at: &PatchFields,
        sums: &mut [f64],
        room: &mut Room,
    ) {
        for (effect, sum) in self.iter().zip(sums) {
            if effect.needs_integrals() {
                *sum += effect.integral(patch, at, room);
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
