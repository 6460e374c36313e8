//! The fast path for structured meshes with the natural boundary: one field, cosine transform.
//!
//! With ω and μ eliminated the linearised substep 2 is J δφ = −r₁,
//!   J = M + Δtγ_ben K M⁻¹ (A M⁻¹ T + C + rank one),
//! applied without being formed; with the consistent mass matrix M⁻¹ is a fixed Chebyshev
//! polynomial, so that J stays a linear map (Newton's method forgives its small error).
//!
//! Both wells have the same stiffness F''(±1) = 2, so away from the membrane J is a function of the
//! stiffness matrix alone. On the grid K is the five-point stencil, which the cosine transform
//! diagonalises: with κ its eigenvalue over the lumped mass and m that of the consistent mass over
//! the lumped one (the mean of the two diagonals' stencils; 1 with the lumped rule), J has the
//! eigenvalue m + Δtγ_ben ε κ (κ + 2m/ε²)²/m³. Its inverse preconditions GMRES from the right.
//! (The lumped mass of the four corners is another than the product grid's; a preconditioner may
//! ignore that, but for the constants: there it is made exact, 1ᵀM P⁻¹r = 1ᵀr. As 1ᵀK = 0, every
//! residual that GMRES leaves then has the sum 0 that r₁ starts with, and ∫φ is conserved to rounding
//! however loosely the system is solved.)

use crate::fem::{Grid, MassForm, MassInverse, QuadratureRule, Space};
use crate::linalg::{CosineTransform, LinalgError, LinearOperator, Multiplier, vector};

use super::super::fault_injection::{self, Place};
use super::super::jacobian::Jacobian;
use super::BulkInverse;

/// Products of the Chebyshev polynomial that stands for M⁻¹ in J: an error of at most 2/3⁴ = 2.5 %,
/// less than what an iteration of Newton's method leaves in a step that starts from a good guess.
const MASS_PRODUCTS: usize = 4;

/// J, in the scaled unknowns of GMRES: D^(−1/2) J with D the lumped mass.
pub(in crate::scheme) struct ReducedOperator<'a> {
    pub(in crate::scheme) space: &'a Space,
    pub(in crate::scheme) jacobian: &'a Jacobian,
    pub(in crate::scheme) mass_inverse: &'a mut MassInverse,
    /// Δt γ_ben.
    pub(in crate::scheme) step_mobility: f64,
    pub(in crate::scheme) root_weights: &'a [f64],
    pub(in crate::scheme) scratch: &'a mut [Vec<f64>; 4],
}

impl LinearOperator for ReducedOperator<'_> {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let [first, second, omega, mu] = self.scratch;
        let (space, jacobian) = (self.space, self.jacobian);
        let matrices = [&jacobian.tangent.values[..], &jacobian.local.values[..]];
        space
            .assembly()
            .pattern
            .multiply_both(matrices, x, first, second);
        self.mass_inverse.apply(space, first, omega, MASS_PRODUCTS);
        jacobian.secant.multiply_add(1.0, omega, second);
        for term in &jacobian.rank_one {
            let along = term.scale * vector::dot(&term.row, x);
            vector::add_scaled(second, along, &term.column);
        }
        self.mass_inverse.apply(space, second, mu, MASS_PRODUCTS);
        let stiffness = space.stiffness();
        match space.mass() {
            MassForm::Nodal(diagonal) => {
                stiffness.multiply(mu, y);
                let rows = y.iter_mut().zip(diagonal).zip(x).zip(self.root_weights);
                for (((y, m), x), root) in rows {
                    *y = (m * x + self.step_mobility * *y) / root;
                }
            }
            MassForm::Sparse(mass) => {
                space.assembly().pattern.multiply_sum(
                    &mass.values,
                    x,
                    self.step_mobility,
                    &stiffness.values,
                    mu,
                    y,
                );
                y.iter_mut()
                    .zip(self.root_weights)
                    .for_each(|(y, root)| *y /= root);
            }
        }
        fault_injection::tap(Place::Product, y);
    }
}

/// The inverse of the bulk operator.
#[derive(Debug)]
pub(in crate::scheme) struct CosineInverse {
    transform: CosineTransform,
    multiplier: Multiplier,
    grid: Grid,
    rule: QuadratureRule,
    /// Δtγ_ben and ε of the multiplier.
    made_for: [f64; 2],
    scaled: Vec<f64>,
    root_weights: Vec<f64>,
    nodal_weights: Vec<f64>,
}

impl CosineInverse {
    pub(in crate::scheme) fn new(space: &Space, grid: Grid) -> Self {
        let transform = CosineTransform::new(grid.cells);
        let multiplier = transform.multiplier(|_, _| 1.0);
        Self {
            transform,
            multiplier,
            grid,
            rule: space.rule(),
            made_for: [f64::NAN; 2],
            scaled: vec![0.0; space.nodes()],
            root_weights: space
                .nodal_weights()
                .iter()
                .map(|weight| weight.sqrt())
                .collect(),
            nodal_weights: space.nodal_weights().to_vec(),
        }
    }
}

impl BulkInverse for CosineInverse {
    fn prepare(&mut self, _: &Space, step_mobility: f64, width: f64) -> Result<(), LinalgError> {
        if self.made_for == [step_mobility, width] {
            return Ok(());
        }
        self.made_for = [step_mobility, width];
        let n = self.grid.cells as f64;
        let (transform, rule) = (&self.transform, self.rule);
        let multiplier = &mut self.multiplier;
        transform.set_multiplier(multiplier, |k, l| {
            let [a, b] = [k, l].map(|k| (std::f64::consts::PI * k as f64 / n).cos());
            let kappa = 2.0 * n * n * (2.0 - a - b);
            let mass = match rule {
                QuadratureRule::Lumped => 1.0,
                QuadratureRule::Consistent => 0.5 + (a + b + a * b) / 6.0,
            };
            let bulk = kappa / mass + 2.0 / (width * width);
            let eigenvalue = mass + step_mobility * width * kappa / mass * bulk * bulk;
            (eigenvalue * transform.squared_norm(k) * transform.squared_norm(l) / (n * n)).recip()
        });
        Ok(())
    }

    fn name(&self) -> &'static str {
        "transform"
    }

    fn method(&self) -> &'static str {
        "GMRES with the cosine transform"
    }
}

impl LinearOperator for CosineInverse {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        for ((scaled, x), root) in self.scaled.iter_mut().zip(x).zip(&self.root_weights) {
            *scaled = x * root;
        }
        self.transform.filter(&self.multiplier, &self.scaled, y);
        let missing = vector::sum(&self.scaled) - vector::dot(&self.nodal_weights, y);
        let shift = missing / vector::sum(&self.nodal_weights);
        y.iter_mut().for_each(|y| *y += shift);
        fault_injection::tap(Place::Preconditioner, y);
    }
}
