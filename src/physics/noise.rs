//! Thermal noise on the director, inside the vesicle.
//!
//! Substep 1 gets a random force ξ at the quadrature points, white in time and space with the variance
//! of the fluctuation-dissipation theorem: at a point of weight w
//!   ξ = sqrt(2 T I(φⁿ)/(γ_nem Δt w)) η,   η standard normal, another one for each point, component and step,
//! so that (ξ, e) has the covariance 2T/(γ_nem Δt) ∫ I(φⁿ) e·e by the rule: temperature T inside the
//! vesicle, none outside, where nothing would hold the director back.
//!
//! **What the energy law means then.** Noise has no energy; it does work. The ledger gets the term
//! `noise_work` = −∫ ξ·(d − dⁿ), minus the work done on the director, and with it closes to rounding as
//! before: the sum is zero, every ND is ≥ 0, but E may rise, by no more than that work. Without the noise
//! the law is (3.26). The work of a step is about 2T for every value of d phase_indicator, however short the step,
//! and may be far larger than the energy: it is part of the scale S of the law.
//!
//! **Reproducible.** A random number is a function of the seed, the time at which the step begins, the
//! point and the component; no generator runs along with the simulation. So a run gives the same bits
//! each time, also after it was taken up from a checkpoint, and a step that is refused and divided
//! starts from the numbers of its own time.

use super::potentials::phase_indicator;
use super::{
    DirectorCoupling, DirectorForm, Effect, EffectContext, Interval, Kept, LedgerTerms,
    PatchFields, PatchStep, Room,
};
use crate::fem::Patch;
use crate::geometry::Vector;
use crate::scene;

/// The effect, where the scene has it.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let noise = context.scene.noise.as_ref()?;
    let nematic = context.scene.nematic.as_ref()?;
    Some(Box::new(Noise::new(noise, nematic.mobility)))
}

/// Thermal noise on the director.
#[derive(Debug)]
pub struct Noise {
    /// T.
    temperature: f64,
    /// γ_nem.
    mobility: f64,
    seed: u64,
    interval: Interval,
}

impl Noise {
    /// T and the seed of a scene, with γ_nem of its `[nematic]`.
    pub fn new(noise: &scene::Noise, mobility: f64) -> Self {
        Self {
            temperature: noise.strength,
            mobility,
            seed: noise.seed,
            interval: Interval {
                begin: 0.0,
                length: 1.0,
            },
        }
    }

    /// Calls f(point of the patch, ξ) where ξ is not zero.
    fn at_points(
        &self,
        patch: &Patch<'_>,
        phi: &[f64],
        numbers: &mut Vec<u32>,
        mut f: impl FnMut(usize, Vector),
    ) {
        patch.point_numbers(numbers);
        let key = mixed(self.seed ^ mixed(self.interval.begin.to_bits()));
        let variance = 2.0 * self.temperature / (self.mobility * self.interval.length);
        let points = numbers.iter().zip(patch.weights()).zip(phi);
        for (point, ((number, weight), phi)) in points.enumerate() {
            let inside = phase_indicator(*phi);
            if inside > 0.0 && *weight > 0.0 {
                let size = (variance * inside / weight).sqrt();
                f(point, size * normal_pair(key, *number));
            }
        }
    }
}

/// The odd constant of SplitMix64: 2⁶⁴ over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64 (Steele, Lea and Flood, 2014), whose n-th number is
/// mixed(seed + n·GOLDEN): any of them without those before.
fn mixed(state: u64) -> u64 {
    let mut z = state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Two independent standard normal numbers that belong to a key and a place, by Box and Muller.
fn normal_pair(key: u64, number: u32) -> Vector {
    let uniform = |index: u64| {
        let index = 2 * u64::from(number) + index;
        let bits = mixed(key.wrapping_add(index.wrapping_add(1).wrapping_mul(GOLDEN)));
        // In (0, 1]: 53 bits, and never 0, of which there is no logarithm.
        ((bits >> 11) + 1) as f64 * (0.5 * f64::EPSILON)
    };
    let radius = (-2.0 * uniform(0).ln()).sqrt();
    let (sine, cosine) = (std::f64::consts::TAU * uniform(1)).sin_cos();
    radius * Vector::new(cosine, sine)
}

impl Effect for Noise {
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
        self.interval = interval;
    }

    /// None of its own: where nothing else acts on the director, noise is left out too.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    /// −(ξ, e).
    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, room: &mut Room) {
        let (patch, old) = (step.patch, step.old);
        let [load_x, load_y] = &mut form.load;
        self.at_points(patch, &old.phi, &mut room.numbers, |point, xi| {
            load_x[point] -= xi.x;
            load_y[point] -= xi.y;
        });
    }

    fn does_work(&self) -> bool {
        true
    }

    /// ∫ ξ·(d − dⁿ).
    fn work(&self, step: &PatchStep<'_>, room: &mut Room) -> f64 {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return 0.0;
        };
        let density = &mut room.points;
        density.clear();
        density.resize(patch.points(), 0.0);
        self.at_points(patch, &old.phi, &mut room.numbers, |point, xi| {
            density[point] = xi.dot(&(new_director.at(point) - old_director.at(point)));
        });
        patch.integrate(density)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Mesh, QuadratureRule, Space};
    use crate::scene::TimeScheme;
    use std::sync::Arc;

    #[test]
    fn the_numbers_are_normal_and_independent() {
        let count = 100_000;
        let pairs: Vec<Vector> = (0..count).map(|n| normal_pair(7, n)).collect();
        let mean = |f: &dyn Fn(&Vector) -> f64| pairs.iter().map(f).sum::<f64>() / f64::from(count);
        let error = 4.0 / f64::from(count).sqrt();
        assert!(mean(&|p| p[0]).abs() < error && mean(&|p| p[1]).abs() < error);
        assert!((mean(&|p| p[0] * p[0]) - 1.0).abs() < 1.5 * error);
        assert!((mean(&|p| p[1].powi(4)) - 3.0).abs() < 10.0 * error);
        assert!(mean(&|p| p[0] * p[1]).abs() < error);
        let next: f64 = pairs.windows(2).map(|w| w[0][0] * w[1][0]).sum();
        assert!((next / f64::from(count)).abs() < error);
        assert_ne!(normal_pair(7, 3), normal_pair(8, 3));
        assert_eq!(normal_pair(7, 3), normal_pair(7, 3));
    }

    /// The load of a P1 test function has the variance 2T/(γΔt) ∫ I e², for both rules.
    #[test]
    fn the_force_has_the_variance_of_the_theorem() {
        for rule in [QuadratureRule::Consistent, QuadratureRule::Lumped] {
            let mesh = Arc::new(Mesh::structured(8, 0.2, 4).expect("a fair mesh"));
            let space = Space::new(mesh, rule);
            let settings = scene::Noise {
                strength: 0.3,
                seed: 5,
            };
            let mut noise = Noise::new(&settings, 0.5);
            let phi: Vec<f64> = space
                .mesh()
                .nodes()
                .iter()
                .map(|n| 2.0 * n[0] - 1.0)
                .collect();
            let e: Vec<f64> = space.mesh().nodes().iter().map(|n| 1.0 + n[1]).collect();
            let patch = space.whole();
            let mut old = PatchFields::new(true);
            old.set_phi(&patch, &phi);
            old.set_director(&patch, &[e.clone(), e.clone()]);
            let mut at_points = vec![0.0; space.points()];
            patch.interpolate(&e, &mut at_points);
            let squares: Vec<f64> = at_points
                .iter()
                .zip(&old.phi)
                .map(|(e, phi)| phase_indicator(*phi) * e * e)
                .collect();
            let length = 1e-3;
            let expected = 2.0 * 0.3 / (0.5 * length) * patch.integrate(&squares);
            let (mut sum, times) = (0.0, 4000);
            let mut form = DirectorForm::default();
            for step in 0..times {
                let begin = f64::from(step) * length;
                noise.set_interval(Interval { begin, length });
                form.clear(&patch);
                let step = PatchStep {
                    patch: &patch,
                    old: &old,
                    new: &old,
                    scheme: TimeScheme::FirstOrder,
                };
                noise.add_director_force(&step, &mut form, &mut Room::default());
                let [x, _] = &form.load;
                let density: Vec<f64> = x.iter().zip(&at_points).map(|(f, e)| f * e).collect();
                sum += patch.integrate(&density).powi(2);
            }
            let ratio = sum / f64::from(times) / expected;
            assert!(
                (ratio - 1.0).abs() < 4.0 * (2.0 / f64::from(times)).sqrt(),
                "{ratio}"
            );
        }
    }
}
