//! The method of conjugate gradients with a diagonal preconditioner.

use super::{LinalgError, LinearOperator, vector};

/// Scratch vectors of the method, kept between solves.
#[derive(Debug)]
pub struct ConjugateGradients {
    residual: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// Iterations made.
    pub iterations: usize,
    /// ‖b − A x‖ / ‖b‖ by the method's own recurrence.
    pub residual: f64,
}

impl ConjugateGradients {
    /// For systems of `size` unknowns.
    pub fn new(size: usize) -> Self {
        Self {
            residual: vec![0.0; size],
            direction: vec![0.0; size],
            product: vec![0.0; size],
        }
    }

    /// b − A x of the last solve, by the method's own recurrence.
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Solves A x = b for a symmetric positive definite A, from the guess in `x`, until
    /// ‖b − A x‖ ≤ `tolerance`·‖b‖ in the norm of the preconditioner's inverse, where
    /// `inverse_diagonal` holds 1/A_ii.
    ///
    /// # Errors
    /// `NotConverged` after `limit` iterations, `NotFinite` when a NaN or an infinity comes up.
    pub fn solve(
        &mut self,
        matrix: &mut impl LinearOperator,
        inverse_diagonal: &[f64],
        b: &[f64],
        x: &mut [f64],
        tolerance: f64,
        limit: usize,
    ) -> Result<Solution, LinalgError> {
        let scaled_norm = |v: &[f64]| vector::weighted_square(v, inverse_diagonal);
        let goal = tolerance * tolerance * scaled_norm(b);
        matrix.apply(x, &mut self.product);
        for ((r, b), p) in self.residual.iter_mut().zip(b).zip(&self.product) {
            *r = b - p;
        }
        for ((p, r), d) in self
            .direction
            .iter_mut()
            .zip(&self.residual)
            .zip(inverse_diagonal)
        {
            *p = r * d;
        }
        let mut rho = scaled_norm(&self.residual);
        let reference = scaled_norm(b).max(f64::MIN_POSITIVE);
        for iterations in 0..=limit {
            // Where the norm of b overflows, infinity is no goal.
            if rho <= goal && goal.is_finite() {
                return Ok(Solution {
                    iterations,
                    residual: (rho / reference).sqrt(),
                });
            }
            if !rho.is_finite() {
                return Err(LinalgError::NotFinite {
                    place: "the conjugate gradients",
                    iteration: iterations,
                });
            }
            matrix.apply(&self.direction, &mut self.product);
            let alpha = rho / vector::dot(&self.direction, &self.product);
            vector::add_scaled(x, alpha, &self.direction);
            vector::add_scaled(&mut self.residual, -alpha, &self.product);
            let next = scaled_norm(&self.residual);
            let beta = next / rho;
            for ((p, r), d) in self
                .direction
                .iter_mut()
                .zip(&self.residual)
                .zip(inverse_diagonal)
            {
                *p = r * d + beta * *p;
            }
            rho = next;
        }
        Err(LinalgError::NotConverged {
            method: "the method of conjugate gradients",
            iterations: limit,
            residual: (rho / reference).sqrt(),
            tolerance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second difference plus a shift, with Dirichlet ends.
    struct Shifted(f64);

    impl LinearOperator for Shifted {
        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            for i in 0..x.len() {
                let left = if i > 0 { x[i - 1] } else { 0.0 };
                let right = x.get(i + 1).copied().unwrap_or(0.0);
                y[i] = (2.0 + self.0) * x[i] - left - right;
            }
        }
    }

    #[test]
    fn solves_a_definite_system_and_reports_an_indefinite_limit() {
        let exact: Vec<f64> = (0..50).map(|i| f64::from(i).sin()).collect();
        let mut b = vec![0.0; 50];
        Shifted(0.5).apply(&exact, &mut b);
        let mut x = vec![0.0; 50];
        let mut method = ConjugateGradients::new(50);
        let diagonal = vec![1.0 / 2.5; 50];
        let solution = method
            .solve(&mut Shifted(0.5), &diagonal, &b, &mut x, 1e-13, 100)
            .expect("a definite system");
        assert!(solution.iterations > 3 && solution.residual <= 1e-13);
        assert!(x.iter().zip(&exact).all(|(x, e)| (x - e).abs() < 1e-11));
        x.fill(0.0);
        let huge = method.solve(&mut Shifted(0.5), &diagonal, &[1e300; 50], &mut x, 1e-13, 9);
        assert!(matches!(huge, Err(LinalgError::NotFinite { .. })));
        x.fill(0.0);
        assert!(matches!(
            method.solve(&mut Shifted(0.5), &diagonal, &b, &mut x, 1e-13, 3),
            Err(LinalgError::NotConverged { iterations: 3, .. })
        ));
        b[7] = f64::NAN;
        assert!(matches!(
            method.solve(&mut Shifted(0.5), &diagonal, &b, &mut x, 1e-13, 3),
            Err(LinalgError::NotFinite { .. })
        ));
    }
}
