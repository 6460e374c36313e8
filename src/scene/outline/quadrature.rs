//! Integrals over an interval to rounding, by the double-exponential (tanh-sinh) rule.

use std::f64::consts::FRAC_PI_2;

/// Beyond this |t| the weights of the rule are below the rounding of a double.
const REACH: f64 = 3.5;

/// Halvings of the step before the value is taken as it is (28,000 points).
const MOST_HALVINGS: usize = 12;

/// ∫₀^`end` f, for f analytic on the open interval.
///
/// The points crowd doubly exponentially towards both ends, so that a singularity beside an end,
/// such as the tight bend at the waist of a Cassini oval whose ratio is nearly 1, does no harm. The
/// step is halved until the value stays the same to rounding: each halving doubles the number of
/// right digits.
pub(super) fn integrate(end: f64, integrand: impl Fn(f64) -> f64) -> f64 {
    let term = |t: f64| {
        // The logistic function of π sinh t, and its derivative.
        let exponent = 2.0 * FRAC_PI_2 * t.sinh();
        let below = (-exponent).exp();
        let fraction = 1.0 / (1.0 + below);
        let density = fraction * fraction * below * 2.0 * FRAC_PI_2 * t.cosh();
        end * density * integrand(end * fraction)
    };
    let sum_of = |count: usize, step: f64, offset: f64| -> f64 {
        (0..count)
            .map(|k| term(-REACH + step * (k as f64 + offset)))
            .sum()
    };
    let mut count = 7;
    let mut step = 2.0 * REACH / count as f64;
    let mut value = step * (sum_of(count, step, 0.0) + term(REACH));
    for _ in 0..MOST_HALVINGS {
        let refined = 0.5 * (value + step * sum_of(count, step, 0.5));
        let change = (refined - value).abs();
        value = refined;
        count *= 2;
        step *= 0.5;
        if change <= 4.0 * f64::EPSILON * value.abs() {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::integrate;

    #[test]
    fn smooth_and_nearly_singular_integrals_are_exact_to_rounding() {
        let cosine = integrate(PI / 2.0, f64::cos);
        assert!((cosine - 1.0).abs() < 4e-16, "{cosine}");
        let width = 1e-6;
        let peak = integrate(1.0, |x| width / (x * x + width * width));
        let exact = (1.0 / width).atan();
        assert!((peak / exact - 1.0).abs() < 1e-14, "{peak} against {exact}");
    }
}
