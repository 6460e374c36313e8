//! The two quadrature rules of SPEC's scheme, as barycentric points and weights.

/// Which rule every integral of a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuadratureRule {
    /// Seven points a triangle, exact to degree 5 (Radon 1948): what the paper's FreeFem++ does.
    Consistent,
    /// The three vertices: the mass matrix is diagonal, nonlinear terms are nodal.
    Lumped,
}

/// Points a triangle of the consistent rule.
pub(super) const POINTS: usize = 7;

/// The barycentric coordinates and the weights (their sum is 1) of the seven-point rule.
pub(super) fn seven_points() -> ([[f64; 3]; POINTS], [f64; POINTS]) {
    let root = 15.0_f64.sqrt();
    let (near, far) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (near_weight, far_weight) = ((155.0 - root) / 1200.0, (155.0 + root) / 1200.0);
    let third = 1.0 / 3.0;
    let coordinates = [
        [third, third, third],
        [1.0 - 2.0 * near, near, near],
        [near, 1.0 - 2.0 * near, near],
        [near, near, 1.0 - 2.0 * near],
        [1.0 - 2.0 * far, far, far],
        [far, 1.0 - 2.0 * far, far],
        [far, far, 1.0 - 2.0 * far],
    ];
    let weights = [
        9.0 / 40.0,
        near_weight,
        near_weight,
        near_weight,
        far_weight,
        far_weight,
        far_weight,
    ];
    (coordinates, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// ∫ λ_a^p λ_b^q λ_c^r = 2|T| p! q! r! / (p + q + r + 2)!
    #[test]
    fn the_seven_points_are_exact_to_degree_five_and_no_further() {
        let (coordinates, weights) = seven_points();
        let worst = |degree: i32| {
            let mut worst = 0.0_f64;
            for p in 0..=degree {
                for q in 0..=degree - p {
                    let r = degree - p - q;
                    let exact =
                        2.0 * factorial(p) * factorial(q) * factorial(r) / factorial(degree + 2);
                    let sum: f64 = coordinates
                        .iter()
                        .zip(weights)
                        .map(|(c, w)| w * c[0].powi(p) * c[1].powi(q) * c[2].powi(r))
                        .sum();
                    worst = worst.max((sum - exact).abs());
                }
            }
            worst
        };
        for degree in 0..=5 {
            assert!(worst(degree) < 1e-16, "degree {degree}: {}", worst(degree));
        }
        assert!(worst(6) > 1e-6);
    }
}
