//! Noise with a part of its work in the books.

use vesica::internal::physics::Noise;
use vesica::internal::scene;
use vesica::{
    DirectorCoupling, DirectorForm, Effect, Interval, Kept, LedgerTerms, Patch, PatchFields,
    PatchStep, Room,
};

/// Noise of which the books have this share of the work: 1 is right.
#[derive(Debug)]
pub struct Booked {
    noise: Noise,
    share: f64,
}

impl Booked {
    pub fn new(share: f64) -> Self {
        let settings = scene::Noise {
            strength: 0.1,
            seed: 5,
        };
        Self {
            noise: Noise::new(&settings, 0.5),
            share,
        }
    }
}

impl Effect for Booked {
    fn name(&self) -> &'static str {
        "noise"
    }

    fn has_energy(&self) -> bool {
        false
    }

    fn integral(&self, _: &Patch<'_>, _: &PatchFields, _: &mut Room) -> f64 {
        0.0
    }

    fn set_interval(&mut self, interval: Interval) {
        self.noise.set_interval(interval);
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        self.noise.director_coupling()
    }

    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, room: &mut Room) {
        self.noise.add_director_force(step, form, room);
    }

    fn does_work(&self) -> bool {
        true
    }

    fn work(&self, step: &PatchStep<'_>, room: &mut Room) -> f64 {
        self.share * self.noise.work(step, room)
    }

    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        terms: &mut LedgerTerms,
        room: &mut Room,
    ) {
        terms.add("noise_work", -self.work(step, room));
    }
}
