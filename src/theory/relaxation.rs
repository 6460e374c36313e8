//! How fast a nearly round vesicle becomes round.

use std::f64::consts::{PI, SQRT_2};

use super::MEMBRANE_FACTOR;

/// 3 G₄ of the lattice of images of the vesicle behind natural walls of the unit square (G₄ = Σ 1/z⁴ = 3.15121 over the Gaussian
/// integers z ≠ 0): the walls slow the mode n = 2 down by 1 + 9.4536 R⁴. G₆ of the lattice is 0, so the mode n = 3 does not feel
/// them in this order.
const IMAGES: f64 = 9.4536;

/// A circle whose radius is R(1 + a cos nθ) with a small a, and its membrane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundVesicle {
    /// R.
    pub radius: f64,
    /// γ_ben.
    pub mobility: f64,
    /// ε; 0: the sharp interface.
    pub interface_width: f64,
    /// σ = c(B − β)/η; 0 where the area is free.
    pub tension: f64,
    /// Whether it lies in the middle of the unit square with natural walls, its mode along the sides; otherwise the walls are
    /// taken to be far away.
    pub is_in_unit_square: bool,
}

impl RoundVesicle {
    /// The rate at which a of the mode n ≥ 2 decays as exp(−rate·t):
    ///
    /// γ n (n² − 1) [c (n² − 3/2)/R³ + σ/R] / (2R²) · 1/(1 − √2 ε n/R), over 1 + 9.4536 R⁴ for n = 2 in the unit square.
    ///
    /// The first factor is that of a sharp interface: its normal velocity V obeys 2V = γ [∂μ/∂n] for a harmonic μ that is half
    /// of the force c(−κ'' − κ³/2) + σκ on the membrane. The second is the mean distance of two points of the profile,
    /// √2 ε, against the wave length. Negative where the mode grows; `None` where ε is no longer small, for √2 ε n ≥ R.
    pub fn decay_rate(&self, mode: u32) -> Option<f64> {
        let n = f64::from(mode);
        let Self {
            radius,
            mobility,
            interface_width,
            tension,
            ..
        } = *self;
        let force = MEMBRANE_FACTOR * (n * n - 1.5) / radius.powi(3) + tension / radius;
        let sharp = mobility * n * (n * n - 1.0) * force / (2.0 * radius * radius);
        let diffuse = 1.0 - SQRT_2 * interface_width * n / radius;
        let walls = match (self.is_in_unit_square, mode) {
            (true, 2) => 1.0 + IMAGES * radius.powi(4),
            _ => 1.0,
        };
        (diffuse > 0.0).then(|| sharp / (diffuse * walls))
    }
}

/// A sphere whose radius is R(1 + a P_l(cos θ)) with a small a, and its membrane; walls are taken to be far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundBody {
    /// R.
    pub radius: f64,
    /// γ_ben.
    pub mobility: f64,
    /// ε; 0: the sharp interface.
    pub interface_width: f64,
    /// σ = c(B − β)/η; 0 where the area is free.
    pub tension: f64,
}

impl RoundBody {
    /// The rate at which a of the mode l ≥ 2 decays as exp(−rate·t):
    ///
    /// γ (2l + 1)(l − 1)(l + 2) [l(l + 1) c/R⁴ + σ/R²] / (4R) · 1/(1 − √2 ε (2l + 1)/(2R)).
    ///
    /// As for a [circle](RoundVesicle::decay_rate), with harmonics r^l and r^(−l − 1) in place of r^n and r^(−n). `None` where ε is no longer small.
    pub fn decay_rate(&self, mode: u32) -> Option<f64> {
        let l = f64::from(mode);
        let Self {
            radius,
            mobility,
            interface_width,
            tension,
        } = *self;
        let force = l * (l + 1.0) * MEMBRANE_FACTOR / radius.powi(4) + tension / (radius * radius);
        let factor = (2.0 * l + 1.0) * (l - 1.0) * (l + 2.0);
        let sharp = mobility * factor * force / (4.0 * radius);
        let diffuse = 1.0 - SQRT_2 * interface_width * (l + 0.5) / radius;
        (diffuse > 0.0).then(|| sharp / diffuse)
    }
}

/// R⁵/(30 γ c): the time in which the slowest mode of a sphere of this radius, l = 2 without tension, decays by e, for a sharp
/// interface and far walls.
pub fn relaxation_time_of_sphere(radius: f64, mobility: f64) -> f64 {
    radius.powi(5) / (30.0 * mobility * MEMBRANE_FACTOR)
}

/// 2R⁵/(15 γ c): the time in which the slowest mode of a round vesicle of this area, n = 2 without tension, decays by e, for a sharp
/// interface and far walls.
pub fn relaxation_time(enclosed: f64, mobility: f64) -> f64 {
    let radius = (enclosed / PI).sqrt();
    radius.powi(5) / (7.5 * mobility * MEMBRANE_FACTOR)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ over the images m + in at distances up to 300: 3 Σ 1/z⁴.
    #[test]
    fn the_constant_of_the_images_is_the_lattice_sum() {
        let reach = -300..=300_i32;
        let mut sum = 0.0;
        for x in reach.clone() {
            for y in reach.clone() {
                let (x, y) = (f64::from(x), f64::from(y));
                let square = x * x + y * y;
                if square > 0.0 {
                    // Re z⁻⁴ = Re (z̄⁴)/|z|⁸.
                    sum += (x.powi(4) - 6.0 * x * x * y * y + y.powi(4)) / square.powi(4);
                }
            }
        }
        assert!((3.0 * sum / IMAGES - 1.0).abs() < 1e-4, "{}", 3.0 * sum);
    }

    #[test]
    fn rates_have_their_limits() {
        let sharp = RoundVesicle {
            radius: 0.25,
            mobility: 0.01,
            interface_width: 0.0,
            tension: 0.0,
            is_in_unit_square: false,
        };
        let rate = sharp.decay_rate(2).expect("it is sharp");
        assert!((rate * relaxation_time(PI * 0.0625, 0.01) - 1.0).abs() < 1e-12);
        // The slowest of T's that the paper has: 14 of them.
        assert!((1.0 / rate / 1e-3 - 13.8).abs() < 0.1, "{rate}");
        // The mode n = 2 is marginal at σ = −5c/(2R²), and grows below.
        let marginal = -2.5 * MEMBRANE_FACTOR / 0.0625;
        for (tension, sign) in [(0.99 * marginal, 1.0), (1.01 * marginal, -1.0)] {
            let rate = RoundVesicle { tension, ..sharp }.decay_rate(2);
            assert_eq!(rate.map(f64::signum), Some(sign));
        }
        let sphere = RoundBody {
            radius: 0.25,
            mobility: 0.01,
            interface_width: 0.0,
            tension: 0.0,
        };
        let of_sphere = sphere.decay_rate(2).expect("it is sharp");
        let time = relaxation_time_of_sphere(0.25, 0.01);
        assert!((of_sphere * time - 1.0).abs() < 1e-12);
        // Marginal at σ = −6c/R², the tension at which prolate and oblate shapes branch off from it.
        for (part, sign) in [(0.99, 1.0), (1.01, -1.0)] {
            let tension = -6.0 * part * MEMBRANE_FACTOR / 0.0625;
            let rate = RoundBody { tension, ..sphere }.decay_rate(2);
            assert_eq!(rate.map(f64::signum), Some(sign));
        }
        let thick = RoundBody {
            interface_width: 0.06,
            ..sphere
        };
        assert!(thick.decay_rate(2).is_some() && thick.decay_rate(3).is_none());
        let thick = RoundVesicle {
            interface_width: 0.1,
            ..sharp
        };
        assert_eq!(thick.decay_rate(2), None);
        let diffuse = RoundVesicle {
            interface_width: 0.01,
            is_in_unit_square: true,
            ..sharp
        };
        let ratio = diffuse.decay_rate(2).expect("ε is small") / rate;
        assert!(
            (ratio - 1.0 / (1.0 - SQRT_2 * 0.08) / (1.0 + 9.4536 / 256.0)).abs() < 1e-12,
            "{ratio}"
        );
    }
}
