//! The functions of φ and d that the energies are made of, with the secants of the scheme.
//! Written for one point; all of them are polynomials or piecewise polynomials.

use std::ops::{Mul, Sub};

use crate::geometry::Vector;

/// F(φ) = ¼ (φ² − 1)², of one number or of eight.
#[inline(always)]
pub fn double_well<T: Copy + From<f64> + Mul<Output = T> + Sub<Output = T>>(phi: T) -> T {
    let square = phi * phi - T::from(1.0);
    T::from(0.25) * square * square
}

/// F_sec = ¼ (φ + φⁿ)(φ² + (φⁿ)² − 2), (3.24): F_sec·(φ − φⁿ) = F(φ) − F(φⁿ).
#[inline(always)]
pub fn double_well_secant(phi: f64, old: f64) -> f64 {
    0.25 * (phi + old) * (phi * phi + old * old - 2.0)
}

/// ∂F_sec/∂φ.
#[inline(always)]
pub fn double_well_secant_derivative(phi: f64, old: f64) -> f64 {
    0.25 * (3.0 * phi * phi + 2.0 * phi * old + old * old - 2.0)
}

/// F'(φ) = φ³ − φ.
#[inline(always)]
pub fn double_well_derivative(phi: f64) -> f64 {
    phi * phi * phi - phi
}

/// G(φ) = F'(φ) − ε k H'(φ) = φ³ − φ − ε k (φ² − 1), (2.2); `curved` is ε k.
#[inline(always)]
pub fn bending_derivative(phi: f64, curved: f64) -> f64 {
    double_well_derivative(phi) - curved * (phi * phi - 1.0)
}

/// G'(φ) = 3 φ² − 1 − 2 ε k φ.
#[inline(always)]
pub fn bending_tangent(phi: f64, curved: f64) -> f64 {
    3.0 * phi * phi - 1.0 - 2.0 * curved * phi
}

/// G_sec = (φ − φⁿ)² + 3 φ φⁿ − 1 − ε k (φ + φⁿ): G_sec·(φ − φⁿ) = G(φ) − G(φⁿ). The paper's
/// (3.24) prints the bracket wrongly, as 3(φ φⁿ − 1 − …).
#[inline(always)]
pub fn bending_secant(phi: f64, old: f64, curved: f64) -> f64 {
    let difference = phi - old;
    difference * difference + 3.0 * phi * old - 1.0 - curved * (phi + old)
}

/// ∂G_sec/∂φ = 2 (φ − φⁿ) + 3 φⁿ − ε k.
#[inline(always)]
pub fn bending_secant_derivative(phi: f64, old: f64, curved: f64) -> f64 {
    2.0 * phi + old - curved
}

/// I(φ) = (φ + 1)³ (3 φ² − 9 φ + 8)/16 on (−1, 1), 0 below, 1 above: 1 inside the vesicle.
#[inline(always)]
pub fn phase_indicator(phi: f64) -> f64 {
    let phi = phi.clamp(-1.0, 1.0);
    let up = phi + 1.0;
    up * up * up * (3.0 * phi * phi - 9.0 * phi + 8.0) / 16.0
}

/// i(φ) = I'(φ) = 15/16 (φ² − 1)² on (−1, 1), else 0.
#[inline(always)]
pub fn phase_indicator_derivative(phi: f64) -> f64 {
    let square = (phi * phi - 1.0).min(0.0);
    15.0 / 16.0 * square * square
}

/// Half the maximum of |I''|, at φ = ±1/√3: the constant of i_Δt.
pub const INDICATOR_CONVEXITY: f64 = 5.0 * 1.732_050_807_568_877_2 / 12.0;

/// i_Δt = i(φⁿ) + (5√3/12)(φ − φⁿ): at least the secant of I, times the sign of φ − φⁿ.
#[inline(always)]
pub fn indicator_secant_bound(phi: f64, old: f64) -> f64 {
    phase_indicator_derivative(old) + INDICATOR_CONVEXITY * (phi - old)
}

/// (I(φ) − I(φⁿ))/(φ − φⁿ), without a division by a small number where both are near each other.
#[inline(always)]
pub fn indicator_secant(phi: f64, old: f64) -> f64 {
    let [a, b] = [phi, old].map(|phi| phi.clamp(-1.0, 1.0));
    share_within(phi, old) * polynomial_secant(a, b)
}

/// ∂/∂φ of [`indicator_secant`].
#[inline(always)]
pub fn indicator_secant_derivative(phi: f64, old: f64) -> f64 {
    let [a, b] = [phi, old].map(|phi| phi.clamp(-1.0, 1.0));
    let share = share_within(phi, old);
    let inside = f64::from(u8::from(a == phi));
    let slope = 15.0 / 16.0
        * ((4.0 * a * a * a + 3.0 * a * a * b + 2.0 * a * b * b + b * b * b) / 5.0
            - (4.0 * a + 2.0 * b) / 3.0);
    let of_share = if phi == old {
        0.0
    } else {
        (inside - share) / (phi - old)
    };
    inside * share * slope + of_share * polynomial_secant(a, b)
}

/// What part of the way from φⁿ to φ lies in [−1, 1].
#[inline(always)]
fn share_within(phi: f64, old: f64) -> f64 {
    if phi == old {
        return 1.0;
    }
    (phi.clamp(-1.0, 1.0) - old.clamp(-1.0, 1.0)) / (phi - old)
}

/// The divided difference of I on [−1, 1], where I(φ) = ½ + 15/16 (φ − ⅔ φ³ + φ⁵/5).
#[inline(always)]
fn polynomial_secant(a: f64, b: f64) -> f64 {
    let (squares, product) = (a * a + b * b, a * b);
    let cubic = squares + product;
    let quintic = squares * squares - product * product + product * squares;
    15.0 / 16.0 * (1.0 - 2.0 / 3.0 * cubic + 0.2 * quintic)
}

/// η_d² (P(d) − P(dⁿ))/(|d|² − |dⁿ|²): times d + dⁿ it is p_sec, with p_sec·(d − dⁿ) = P(d) − P(dⁿ).
#[inline(always)]
pub fn unit_length_penalty_slope(d: Vector, old: Vector) -> f64 {
    let [a, b] = [d, old].map(|d| d.norm_squared());
    let (least, most) = (a.min(b), a.max(b));
    // P as a function of |d|² on either side of 1.
    let below = |a: f64, b: f64| 0.25 * (a + b - 2.0);
    let above = |a: f64, b: f64| 1.0 - 2.0 / (a.sqrt() + b.sqrt());
    if most <= 1.0 {
        below(a, b)
    } else if least >= 1.0 {
        above(a, b)
    } else {
        ((most - 1.0) * above(most, 1.0) + (1.0 - least) * below(1.0, least)) / (most - least)
    }
}

/// η_d² P(d) with the truncated potential P(d) = (|d|² − 1)²/(4 η_d²) for |d| ≤ 1 and
/// (|d| − 1)²/η_d² for |d| ≥ 1, whose gradient is p̃ of (3.34).
#[inline(always)]
pub fn unit_length_penalty(d: Vector) -> f64 {
    let square = d.norm_squared();
    let short = 0.25 * (square - 1.0) * (square - 1.0);
    let excess = square.sqrt() - 1.0;
    if square <= 1.0 {
        short
    } else {
        excess * excess
    }
}

/// η_d² p̃(d) = η_d² ∇P(d): (|d|² − 1) d for |d| ≤ 1, 2 (1 − 1/|d|) d for |d| ≥ 1, (3.34).
#[inline(always)]
pub fn unit_length_penalty_derivative(d: Vector) -> Vector {
    let square = d.norm_squared();
    let factor = if square <= 1.0 {
        square - 1.0
    } else {
        2.0 - 2.0 / square.sqrt()
    };
    factor * d
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of values on both sides of the wells.
    fn pairs() -> impl Iterator<Item = (f64, f64)> {
        let values: Vec<f64> = (-15..=15).map(|i| f64::from(i) * 0.1).collect();
        values
            .clone()
            .into_iter()
            .flat_map(move |a| values.clone().into_iter().map(move |b| (a, b)))
    }

    #[test]
    fn secants_are_secants() {
        for (phi, old) in pairs() {
            let step = phi - old;
            let change = double_well(phi) - double_well(old);
            assert!((double_well_secant(phi, old) * step - change).abs() < 1e-15);
            for curved in [0.0, 0.3] {
                let change = bending_derivative(phi, curved) - bending_derivative(old, curved);
                assert!((bending_secant(phi, old, curved) * step - change).abs() < 1e-14);
            }
            let change = phase_indicator(phi) - phase_indicator(old);
            assert!((indicator_secant(phi, old) * step - change).abs() < 1e-15);
            // At equal arguments a secant is the derivative.
            let slope = phase_indicator_derivative(phi);
            assert!((indicator_secant(phi, phi) - slope).abs() < 1e-15);
            assert!((indicator_secant(phi, phi + 1e-9) - slope).abs() < 1e-8);
            assert!((double_well_secant(phi, phi) - double_well_derivative(phi)).abs() < 1e-15);
            assert!((bending_secant(phi, phi, 0.3) - bending_tangent(phi, 0.3)).abs() < 1e-15);
        }
        for ((x, y), (u, v)) in pairs().step_by(5).zip(pairs().step_by(3)) {
            let (old, new) = (1.3 * Vector::new(x, y), 1.3 * Vector::new(v, u));
            let work = unit_length_penalty_slope(new, old) * (new + old).dot(&(new - old));
            let change = unit_length_penalty(new) - unit_length_penalty(old);
            assert!((work - change).abs() < 1e-14, "{old} {new}");
            let twice = 2.0 * unit_length_penalty_slope(new, new) * new;
            assert!((twice - unit_length_penalty_derivative(new)).norm() < 1e-14);
        }
        // The printed bracket is no secant.
        let printed = |phi: f64, old: f64| (phi - old).powi(2) + 3.0 * (phi * old - 1.0);
        assert!(
            (printed(0.5, 0.2) * 0.3
                - (bending_derivative(0.5, 0.0) - bending_derivative(0.2, 0.0)))
            .abs()
                > 0.1
        );
    }

    #[test]
    fn derivatives_are_derivatives() {
        let h = 1e-5;
        for (phi, old) in pairs() {
            let central = |f: &dyn Fn(f64) -> f64| (f(phi + h) - f(phi - h)) / (2.0 * h);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-8;
            assert!(close(central(&double_well), double_well_derivative(phi)));
            assert!(close(
                central(&|phi| bending_derivative(phi, 0.3)),
                bending_tangent(phi, 0.3)
            ));
            assert!(close(
                central(&phase_indicator),
                phase_indicator_derivative(phi)
            ));
            assert!(close(
                central(&|phi| double_well_secant(phi, old)),
                double_well_secant_derivative(phi, old)
            ));
            assert!(close(
                central(&|phi| bending_secant(phi, old, 0.3)),
                bending_secant_derivative(phi, old, 0.3)
            ));
            // At ±1 the second derivative of I has a kink.
            let slope = central(&|phi| indicator_secant(phi, old));
            assert!((slope - indicator_secant_derivative(phi, old)).abs() < h);
            let slope = unit_length_penalty_derivative(Vector::new(phi, old));
            let along_x = |x| unit_length_penalty(Vector::new(x, old));
            assert!(close(central(&along_x), slope.x));
        }
    }

    #[test]
    fn the_indicator_goes_from_nought_to_one_with_its_steepest_bend_as_stated() {
        assert_eq!(
            (
                phase_indicator(-1.0),
                phase_indicator(0.0),
                phase_indicator(1.0)
            ),
            (0.0, 0.5, 1.0)
        );
        assert_eq!((phase_indicator(-1.7), phase_indicator(1.7)), (0.0, 1.0));
        let bend = |phi: f64| (15.0 / 4.0 * phi * (phi * phi - 1.0)).abs();
        let largest = (0..=100_000)
            .map(|i| bend(f64::from(i) * 1e-5))
            .fold(0.0, f64::max);
        assert!((0.5 * largest - INDICATOR_CONVEXITY).abs() < 1e-9);
    }

    /// ND_interp ≥ 0 and ND_penal ≥ 0 at a point, and the constants are sharp: with the smaller ones
    /// and with the potential of (3.34) left untruncated they turn negative.
    #[test]
    fn the_majorants_dissipate_and_smaller_ones_do_not() {
        let interpolation = |constant: f64, phi: f64, old: f64| {
            let majorant = phase_indicator_derivative(old) + constant * (phi - old);
            majorant * (phi - old) - (phase_indicator(phi) - phase_indicator(old))
        };
        let least = |constant: f64| {
            pairs()
                .map(|(phi, old)| interpolation(constant, phi, old))
                .fold(f64::INFINITY, f64::min)
        };
        assert!(least(INDICATOR_CONVEXITY) >= -1e-16);
        assert!(least(0.9 * INDICATOR_CONVEXITY) < -1e-5);

        type Potential = fn(Vector) -> f64;
        type Slope = fn(Vector) -> Vector;
        let least = |constant: f64, potential: Potential, slope: Slope| {
            let mut least = f64::INFINITY;
            for (x, y) in pairs() {
                for (u, v) in pairs().step_by(7) {
                    let (old, new) = (2.0 * Vector::new(x, y), 2.0 * Vector::new(u, v));
                    let step = new - old;
                    let work = (slope(old) + constant * step).dot(&step);
                    least = least.min(work - (potential(new) - potential(old)));
                }
            }
            least
        };
        assert!(least(1.0, unit_length_penalty, unit_length_penalty_derivative) >= -1e-14);
        assert!(least(0.9, unit_length_penalty, unit_length_penalty_derivative) < -1e-3);
        let untruncated: Potential = |d| 0.25 * (d.norm_squared() - 1.0).powi(2);
        let slope: Slope = |d| (d.norm_squared() - 1.0) * d;
        assert!(least(1.0, untruncated, slope) < -1.0);
    }
}
