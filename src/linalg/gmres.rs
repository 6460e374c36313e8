//! GMRES, preconditioned from the right, so that the residual that it minimises is the true one.
//!
//! P⁻¹ of every vector of the basis is kept (Saad's flexible variant): the solution takes no further
//! application of P⁻¹, and that P⁻¹ is linear to some seven digits only, where it is applied in single
//! precision, does no harm.

use super::{LinalgError, LinearOperator, vector};

/// The method's basis and scratch vectors, allocated once for a size and a restart length.
#[derive(Debug)]
pub struct Gmres {
    /// Orthonormal vectors of the Krylov space, one more than the restart length.
    basis: Vec<Vec<f64>>,
    /// Columns of the Hessenberg matrix, turned into an upper triangle by the rotations.
    hessenberg: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    /// The right-hand side of the least-squares problem.
    target: Vec<f64>,
    coefficients: Vec<f64>,
    /// P⁻¹ of the basis.
    directions: Vec<Vec<f64>>,
    product: Vec<f64>,
}

/// How a solve ended. That the goal was missed is not an error here: the caller knows whether what was
/// reached is good enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Products with the matrix (and with the preconditioner).
    pub iterations: usize,
    /// ‖b − A x‖ by the method's recurrence.
    pub residual: f64,
    /// Whether `residual` is at most what was asked for.
    pub converged: bool,
}

impl Gmres {
    /// For systems of `size` unknowns, restarted after `restart` iterations.
    pub fn new(size: usize, restart: usize) -> Self {
        Self {
            basis: vec![vec![0.0; size]; restart + 1],
            hessenberg: (0..restart).map(|column| vec![0.0; column + 2]).collect(),
            rotations: vec![(1.0, 0.0); restart],
            target: vec![0.0; restart + 1],
            coefficients: vec![0.0; restart],
            directions: vec![vec![0.0; size]; restart],
            product: vec![0.0; size],
        }
    }

    /// Solves A x = b to ‖b − A x‖ ≤ `goal`, with x = 0 as the guess and at most `limit` products.
    ///
    /// # Errors
    /// `NotFinite` when a NaN or an infinity comes up, or is the goal.
    pub fn solve(
        &mut self,
        matrix: &mut impl LinearOperator,
        preconditioner: &mut (impl LinearOperator + ?Sized),
        b: &[f64],
        x: &mut [f64],
        goal: f64,
        limit: usize,
    ) -> Result<Outcome, LinalgError> {
        // A residual is neither above nor below NaN, so no iteration would be made and none would end.
        if !goal.is_finite() {
            return Err(LinalgError::NotFinite {
                place: "the goal of GMRES",
                iteration: 0,
            });
        }
        let restart = self.hessenberg.len();
        x.fill(0.0);
        self.basis[0].copy_from_slice(b);
        let mut residual = vector::norm(b);
        let mut iterations = 0;
        loop {
            if !residual.is_finite() {
                return Err(LinalgError::NotFinite {
                    place: "GMRES",
                    iteration: iterations,
                });
            }
            if residual <= goal || iterations >= limit {
                return Ok(Outcome {
                    iterations,
                    residual,
                    converged: residual <= goal,
                });
            }
            vector::scale(&mut self.basis[0], 1.0 / residual);
            self.target.fill(0.0);
            self.target[0] = residual;
            let mut columns = 0;
            while columns < restart && iterations < limit && residual > goal {
                self.extend(matrix, preconditioner, columns);
                residual = self.rotate(columns);
                columns += 1;
                iterations += 1;
                if !residual.is_finite() {
                    return Err(LinalgError::NotFinite {
                        place: "GMRES",
                        iteration: iterations,
                    });
                }
            }
            self.add_combination(columns, x);
            if residual > goal && iterations < limit {
                matrix.apply(x, &mut self.product);
                for ((r, b), p) in self.basis[0].iter_mut().zip(b).zip(&self.product) {
                    *r = b - p;
                }
                residual = vector::norm(&self.basis[0]);
            }
        }
    }

    /// Appends A P⁻¹ v to the basis, made orthogonal to it by modified Gram–Schmidt.
    fn extend(
        &mut self,
        matrix: &mut impl LinearOperator,
        preconditioner: &mut (impl LinearOperator + ?Sized),
        column: usize,
    ) {
        let (old, new) = self.basis.split_at_mut(column + 1);
        let next = &mut new[0];
        let direction = &mut self.directions[column];
        preconditioner.apply(&old[column], direction);
        matrix.apply(direction, next);
        let entries = &mut self.hessenberg[column];
        let mut along = vector::dot(next, &old[0]);
        let mut length = 0.0;
        for (number, v) in old.iter().enumerate() {
            entries[number] = along;
            match old.get(number + 1) {
                Some(other) => along = vector::add_scaled_and_dot(next, -along, v, other),
                None => length = vector::add_scaled_and_norm(next, -along, v),
            }
        }
        entries[column + 1] = length;
        if length > 0.0 {
            vector::scale(next, 1.0 / length);
        }
    }

    /// Brings the newest column to triangular form; returns the norm of the residual.
    fn rotate(&mut self, column: usize) -> f64 {
        let entries = &mut self.hessenberg[column];
        for (row, &(cosine, sine)) in self.rotations[..column].iter().enumerate() {
            let (upper, lower) = (entries[row], entries[row + 1]);
            entries[row] = cosine * upper + sine * lower;
            entries[row + 1] = cosine * lower - sine * upper;
        }
        let (upper, lower) = (entries[column], entries[column + 1]);
        let length = upper.hypot(lower);
        let (cosine, sine) = if length > 0.0 {
            (upper / length, lower / length)
        } else {
            (1.0, 0.0)
        };
        self.rotations[column] = (cosine, sine);
        entries[column] = length;
        let target = self.target[column];
        self.target[column] = cosine * target;
        self.target[column + 1] = -sine * target;
        self.target[column + 1].abs()
    }

    /// x ← x + P⁻¹ V y with the y that minimises the residual.
    fn add_combination(&mut self, columns: usize, x: &mut [f64]) {
        for row in (0..columns).rev() {
            let known: f64 = (row + 1..columns)
                .map(|column| self.hessenberg[column][row] * self.coefficients[column])
                .sum();
            let pivot = self.hessenberg[row][row];
            // A zero pivot means that the space stopped growing: that direction adds nothing.
            self.coefficients[row] = if pivot == 0.0 {
                0.0
            } else {
                (self.target[row] - known) / pivot
            };
        }
        for (coefficient, direction) in self.coefficients[..columns].iter().zip(&self.directions) {
            vector::add_scaled(x, *coefficient, direction);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A non-symmetric tridiagonal matrix.
    struct Convection;

    impl LinearOperator for Convection {
        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            for i in 0..x.len() {
                let left = if i > 0 { x[i - 1] } else { 0.0 };
                let right = x.get(i + 1).copied().unwrap_or(0.0);
                y[i] = 3.0 * x[i] - 1.5 * left - 0.5 * right;
            }
        }
    }

    struct Identity;

    impl LinearOperator for Identity {
        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            y.copy_from_slice(x);
        }
    }

    /// 1/3: the inverse of the diagonal.
    struct Third;

    impl LinearOperator for Third {
        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            for (y, x) in y.iter_mut().zip(x) {
                *y = x / 3.0;
            }
        }
    }

    fn residual(x: &[f64], b: &[f64]) -> f64 {
        let mut y = vec![0.0; x.len()];
        Convection.apply(x, &mut y);
        y.iter()
            .zip(b)
            .map(|(y, b)| (y - b).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    #[test]
    fn the_reported_residual_is_the_true_one_with_and_without_restarts() {
        let b: Vec<f64> = (0..40).map(|i| 1.0 + f64::from(i % 7)).collect();
        for restart in [5, 60] {
            let mut x = vec![0.0; 40];
            let mut method = Gmres::new(40, restart);
            let outcome = method
                .solve(&mut Convection, &mut Third, &b, &mut x, 1e-10, 500)
                .expect("finite");
            assert!(outcome.converged, "{outcome:?}");
            assert!(residual(&x, &b) <= 1.1e-10, "{}", residual(&x, &b));
        }
    }

    #[test]
    fn a_limit_is_kept_and_said() {
        let b = vec![1.0; 40];
        let mut x = vec![0.0; 40];
        let outcome = Gmres::new(40, 30)
            .solve(&mut Convection, &mut Identity, &b, &mut x, 1e-12, 4)
            .expect("finite");
        assert_eq!((outcome.iterations, outcome.converged), (4, false));
        assert!((residual(&x, &b) - outcome.residual).abs() < 1e-12);
    }

    #[test]
    fn an_exact_solution_in_the_space_ends_the_iteration() {
        let mut x = vec![0.0; 3];
        let outcome = Gmres::new(3, 3)
            .solve(
                &mut Identity,
                &mut Identity,
                &[1.0, 2.0, 3.0],
                &mut x,
                1e-14,
                10,
            )
            .expect("finite");
        assert_eq!(outcome.iterations, 1);
        assert!(
            x.iter()
                .zip([1.0, 2.0, 3.0])
                .all(|(x, e)| (x - e).abs() < 1e-15)
        );
    }

    #[test]
    fn what_is_not_finite_is_an_error() {
        let mut x = vec![0.0; 3];
        let b = [1.0, f64::NAN, 3.0];
        let outcome = Gmres::new(3, 3).solve(&mut Identity, &mut Identity, &b, &mut x, 0.1, 10);
        assert!(matches!(outcome, Err(LinalgError::NotFinite { .. })));
    }

    #[test]
    fn a_goal_that_is_not_finite_is_an_error_and_not_an_iteration_without_end() {
        let mut x = vec![0.0; 3];
        for goal in [f64::NAN, f64::INFINITY] {
            let mut method = Gmres::new(3, 3);
            let outcome = method.solve(&mut Convection, &mut Identity, &[1.0; 3], &mut x, goal, 10);
            assert!(
                matches!(outcome, Err(LinalgError::NotFinite { .. })),
                "{goal}: {outcome:?}"
            );
        }
    }
}
