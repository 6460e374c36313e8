//! Solving with the mass matrix.

use super::{MassForm, Space};
use crate::linalg::{Block, SparseMatrix, vector};

/// M⁻¹: a division with the lumped rule, Chebyshev's iteration with the consistent one.
///
/// For P1 elements the eigenvalues of M_L⁻¹ M, where M_L is the lumped matrix, lie in [a, 1] on
/// any mesh, with a = 1/4 in the plane and 1/5 by rotation ([`Space::least_mass_eigenvalue`]). So the
/// iteration needs no inner products, its error falls by a known factor with each product, 3 in the plane, and how
/// many it takes is known beforehand.
#[derive(Debug)]
pub struct MassInverse {
    /// The centre and half the width of the interval [a, 1].
    centre: f64,
    radius: f64,
    inverse_weights: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    next: Vec<f64>,
}

impl MassInverse {
    /// For the mass matrix of a space.
    pub fn new(space: &Space) -> Self {
        let size = match space.mass() {
            MassForm::Nodal(_) => 0,
            MassForm::Sparse(_) => space.nodes(),
        };
        let least = space.least_mass_eigenvalue();
        Self {
            centre: 0.5 * (1.0 + least),
            radius: 0.5 * (1.0 - least),
            inverse_weights: space
                .nodal_weights()
                .iter()
                .map(|weight| weight.recip())
                .collect(),
            residual: vec![0.0; size],
            direction: vec![0.0; size],
            next: vec![0.0; size],
        }
    }

    /// 1/∫ψ_i.
    pub fn inverse_weights(&self) -> &[f64] {
        &self.inverse_weights
    }

    /// x ← M⁻¹ b, from the guess in x, to ‖b − M x‖ ≤ tolerance·‖b‖ in the norm of M_L⁻¹. Where b is so
    /// large that its norm overflows x becomes NaN: nothing is a solution to within infinity.
    pub fn solve(&mut self, space: &Space, b: &[f64], x: &mut [f64], tolerance: f64) {
        match space.mass() {
            MassForm::Nodal(_) => self.divide(b, x),
            MassForm::Sparse(matrix) => {
                let mut start = self.residual_of(matrix, b, x);
                if !start.is_finite() {
                    // What a failed step has left behind is no guess.
                    x.fill(0.0);
                    start = self.residual_of(matrix, b, x);
                }
                let goal = tolerance * vector::weighted_square(b, &self.inverse_weights).sqrt();
                if !goal.is_finite() {
                    x.fill(f64::NAN);
                } else if start > goal {
                    // The error after k products is at most 1/T_k(σ) ≤ 2/ρ^k of that before, with ρ = σ + √(σ² − 1);
                    // the residual may be larger by the condition number 1/a.
                    let sigma = self.centre / self.radius;
                    let rate = sigma + (sigma * sigma - 1.0).sqrt();
                    let excess = 2.0 / (self.centre - self.radius);
                    let wanted = (excess * start / goal.max(f64::MIN_POSITIVE)).ln() / rate.ln();
                    self.iterate(matrix, x, wanted.clamp(1.0, 60.0).ceil() as usize);
                }
            }
        }
    }

    /// Takes the residual b − M x; its norm.
    fn residual_of(&mut self, matrix: &SparseMatrix, b: &[f64], x: &[f64]) -> f64 {
        let product = ([&matrix.values[..]], [x]);
        let pattern = &matrix.pattern;
        pattern.sweep(product, [b], [&mut self.residual], |[p], [b], _| [b - p]);
        vector::weighted_square(&self.residual, &self.inverse_weights).sqrt()
    }

    /// x ← p(M) b with p the Chebyshev polynomial of `products` products: a fixed linear map, close
    /// to M⁻¹ to 2/3^products in the plane.
    pub fn apply(&mut self, space: &Space, b: &[f64], x: &mut [f64], products: usize) {
        match space.mass() {
            MassForm::Nodal(_) => self.divide(b, x),
            MassForm::Sparse(matrix) => {
                x.fill(0.0);
                self.residual.copy_from_slice(b);
                self.iterate(matrix, x, products);
            }
        }
    }

    fn divide(&self, b: &[f64], x: &mut [f64]) {
        for ((x, b), inverse) in x.iter_mut().zip(b).zip(&self.inverse_weights) {
            *x = b * inverse;
        }
    }

    /// Adds to x what `products` products of Chebyshev's iteration make of the residual.
    fn iterate(&mut self, matrix: &SparseMatrix, x: &mut [f64], products: usize) {
        let inverse = &self.inverse_weights;
        let triples = self.direction.iter_mut().zip(&self.residual).zip(inverse);
        triples.for_each(|((d, r), inverse)| *d = r * inverse / self.centre);
        let (sigma, radius) = (self.centre / self.radius, self.radius);
        let mut rho = sigma.recip();
        for _ in 0..products {
            let after = (2.0 * sigma - rho).recip();
            let [keep, add] = [after * rho, 2.0 * after / radius].map(Block::splat);
            rho = after;
            let direction = &self.direction[..];
            let product = ([&matrix.values[..]], [direction]);
            let outputs = [&mut *x, &mut self.residual, &mut self.next];
            let pattern = &matrix.pattern;
            let inputs = [direction, inverse];
            pattern.sweep(product, inputs, outputs, |[p], [d, inverse], [x, r, _]| {
                let r = r - p;
                [x + d, r, keep * d + add * r * inverse]
            });
            std::mem::swap(&mut self.direction, &mut self.next);
        }
        vector::add_scaled(x, 1.0, &self.direction);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fem::{Mesh, QuadratureRule};

    #[test]
    fn solves_to_the_tolerance_on_a_distorted_mesh() {
        let mesh = Arc::new(Mesh::structured(9, 0.3, 7).expect("a fair mesh"));
        for rule in [QuadratureRule::Consistent, QuadratureRule::Lumped] {
            let space = Space::new(mesh.clone(), rule);
            let exact: Vec<f64> = (0..100).map(|i| f64::from(i * i).sin()).collect();
            let mut b = vec![0.0; 100];
            space.mass().multiply(&exact, &mut b);
            let mut inverse = MassInverse::new(&space);
            for tolerance in [1e-3, 1e-14] {
                let mut x = vec![0.0; 100];
                inverse.solve(&space, &b, &mut x, tolerance);
                let error = x
                    .iter()
                    .zip(&exact)
                    .map(|(x, e)| (x - e).abs())
                    .fold(0.0, f64::max);
                assert!(error < 20.0 * tolerance, "{error}");
            }
            let mut x = vec![0.0; 100];
            inverse.apply(&space, &b, &mut x, 12);
            let error = x
                .iter()
                .zip(&exact)
                .map(|(x, e)| (x - e).abs())
                .fold(0.0, f64::max);
            assert!(error < 1e-4, "{error}");
        }
    }

    #[test]
    fn what_overflows_has_no_solution() {
        let mesh = Arc::new(Mesh::structured(4, 0.0, 0).expect("a fair mesh"));
        let space = Space::new(mesh, QuadratureRule::Consistent);
        let mut x = vec![0.0; 25];
        MassInverse::new(&space).solve(&space, &[1e300; 25], &mut x, 1e-10);
        assert!(x.iter().all(|x| x.is_nan()));
    }
}
