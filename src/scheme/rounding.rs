//! What rounding leaves of a state at rest.

use crate::fem::Space;

/// A change of φ, over the size of φ and at least 1, that is no more than rounding: a correction of Newton's method
/// carries the rounding of some three products with K.
pub(super) const CHANGE: f64 = 64.0 * f64::EPSILON;

/// The strictest tolerance of the energy law that [`Least`] follows: the law closes to 1e-14 or so of the
/// energies of a vesicle.
const STRICTEST_LAW: f64 = 1e-12;

/// What is left of ω, μ and the energy where φ = ±1 to rounding: below that they say nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Least {
    /// ω₀ = eps ‖|K|/M_L + 1/ε²‖ in L2.
    pub(super) omega: f64,
    /// μ₀ = eps ‖ε (|K|/M_L + 1/ε²)²‖ in L2.
    pub(super) mu: f64,
    /// The lower bound of S. The law of a state with the energy E = ε/2 ‖ω‖² misses by the product of ω and what
    /// rounding has made of it, ε ‖ω‖ω₀/√N for N nodes whose errors are independent. That is no more than the
    /// tolerance of the law allows from
    ///   E = ε ω₀²/(2N tolerance²)
    /// on.
    pub(super) energy: f64,
}

impl Least {
    pub(super) fn new(space: &Space, width: f64, law_tolerance: f64) -> Self {
        let weights = space.nodal_weights();
        let (mut omega, mut mu) = (0.0, 0.0);
        for (diagonal, weight) in space.stiffness().diagonal().into_iter().zip(weights) {
            // A row of K has the sum 0, nearly all of its negative part off the diagonal.
            let local = 2.0 * diagonal / weight + width.powi(-2);
            omega += weight * local.powi(2);
            mu += weight * (width * local.powi(2)).powi(2);
        }
        let tolerance = law_tolerance.max(STRICTEST_LAW);
        let relative = f64::EPSILON / tolerance;
        let energy = 0.5 * width * omega * relative * relative / weights.len() as f64;
        Self {
            omega: least(f64::EPSILON * omega.sqrt()),
            mu: least(f64::EPSILON * mu.sqrt()),
            energy: least(energy),
        }
    }
}

/// More than nothing. Where it overflows so does everything else.
fn least(value: f64) -> f64 {
    if value.is_finite() {
        value.max(f64::MIN_POSITIVE)
    } else {
        f64::MIN_POSITIVE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Mesh, QuadratureRule};
    use std::sync::Arc;

    /// Far below the energies of vesicles, which are of the order of 10, and far above those of rounding.
    #[test]
    fn the_least_energy_is_small() {
        let mesh = Arc::new(Mesh::structured(120, 0.0, 0).expect("a mesh"));
        let space = Space::new(mesh, QuadratureRule::Lumped);
        let energy = Least::new(&space, 0.01, 1e-8).energy;
        assert!(energy > 1e-14 && energy < 1e-10, "{energy:e}");
        assert!(Least::new(&space, 0.01, 1e-300).energy < 1e-2);
        let least = Least::new(&space, 1e-200, 1e-8);
        assert_eq!(least.energy, f64::MIN_POSITIVE);
    }
}
