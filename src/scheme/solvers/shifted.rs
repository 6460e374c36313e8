//! The preconditioner of the reduced system on any mesh with the natural boundary.
//!
//! The bulk operator of `transform`, with c = Δtγ_ben ε and b = 2/ε²,
//!
//!   M + c K M⁻¹ (K + bM) M⁻¹ (K + bM) = M (1 + c κ(κ + b)²),   κ = M⁻¹K,
//!
//! is a cubic in κ, and so a product of three shifted Laplacians: 1 + cκ(κ + b)² = c Π(κ + s_j), where
//! c s(s − b)² = 1. One root s is real in any case. The other two are real if Δt is long enough
//! (c ≥ 27/(4b³)) and complex otherwise; both have the product 1/(cs) = σ², and in their place stands
//! (κ + σ)², which is off by a factor between 1/4 and 9/8 for any κ ≥ 0:
//!
//!   P = (K + sM) M⁻¹ (K + σM) M⁻¹ (K + σM)/(sσ²).
//!
//! That takes two factors and three solves. Shifts are rounded to a geometric sequence, so that steps
//! whose lengths are chosen share factors; c is then off by less than a fifth. The mass is that of the
//! run's own rule.

use crate::fem::{MassForm, Space};
use crate::linalg::{LinalgError, LinearOperator, ShiftedFactors, vector};

use super::super::fault_injection::{self, Place};
use super::BulkInverse;

/// Factors that are kept: of two shifts, for this step and for the last one.
const MOST_KEPT: usize = 4;

/// Shifts in a factor of two.
const FINENESS: f64 = 4.0;

/// The inverse of the bulk operator by sparse factors.
#[derive(Debug)]
pub(in crate::scheme) struct ShiftedInverse {
    /// Analysed when they are first used: most runs with chosen steps never do.
    factors: Option<ShiftedFactors>,
    mass: MassForm,
    /// s and σ.
    shifts: [f64; 2],
    /// Δtγ_ben and ε of the shifts.
    made_for: [f64; 2],
    /// The mass matrix on the pattern of the stiffness matrix.
    mass_values: Vec<f64>,
    scratch: Vec<f64>,
    root_weights: Vec<f64>,
    nodal_weights: Vec<f64>,
}

impl ShiftedInverse {
    /// The mass matrix, and no factor yet.
    pub(in crate::scheme) fn new(space: &Space) -> Self {
        let assembly = space.assembly();
        let mut mass_values = vec![0.0; assembly.pattern.stored()];
        space
            .mass()
            .add_to(1.0, &assembly.diagonal, &mut mass_values);
        let weights = space.nodal_weights();
        Self {
            factors: None,
            mass: space.mass().clone(),
            shifts: [f64::NAN; 2],
            made_for: [f64::NAN; 2],
            mass_values,
            scratch: vec![0.0; space.nodes()],
            root_weights: weights.iter().map(|weight| weight.sqrt()).collect(),
            nodal_weights: weights.to_vec(),
        }
    }
}

impl BulkInverse for ShiftedInverse {
    fn prepare(
        &mut self,
        space: &Space,
        step_mobility: f64,
        width: f64,
    ) -> Result<(), LinalgError> {
        if self.made_for == [step_mobility, width] {
            return Ok(());
        }
        self.made_for = [f64::NAN; 2];
        self.shifts = shifts(step_mobility * width, 2.0 / (width * width)).map(rounded);
        let factors = match &mut self.factors {
            Some(factors) => factors,
            none => none.insert(ShiftedFactors::analyse(
                &space.assembly().pattern,
                MOST_KEPT,
            )?),
        };
        for shift in self.shifts {
            factors.prepare(shift, &space.stiffness().values, &self.mass_values)?;
        }
        self.made_for = [step_mobility, width];
        Ok(())
    }

    fn name(&self) -> &'static str {
        "shifted"
    }

    fn method(&self) -> &'static str {
        "GMRES with the shifted Laplacians"
    }
}

impl LinearOperator for ShiftedInverse {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        for ((y, x), root) in y.iter_mut().zip(x).zip(&self.root_weights) {
            *y = x * root;
        }
        let sum = vector::sum(y);
        let [single, double] = self.shifts;
        // `prepare` comes first.
        if let Some(factors) = &mut self.factors {
            factors.solve_in_place(single, y);
            for _ in 0..2 {
                self.mass.multiply(y, &mut self.scratch);
                y.copy_from_slice(&self.scratch);
                factors.solve_in_place(double, y);
            }
        }
        vector::scale(y, single * double * double);
        // As in `transform`: 1ᵀM P⁻¹r = 1ᵀr exactly.
        let shift = (sum - vector::dot(&self.nodal_weights, y)) / vector::sum(&self.nodal_weights);
        y.iter_mut().for_each(|y| *y += shift);
        fault_injection::tap(Place::Preconditioner, y);
    }
}

/// The root s of c s(s − b)² = 1 that is real in any case, and σ = 1/√(cs).
fn shifts(c: f64, b: f64) -> [f64; 2] {
    let excess = |s: f64| c * s * (s - b) * (s - b) - 1.0;
    // Up to b/3 the cubic rises; if it does not reach 1 there, it does so beyond b alone.
    let (mut low, mut high) = if excess(b / 3.0) >= 0.0 {
        (0.0, b / 3.0)
    } else {
        (b, b + c.recip().cbrt())
    };
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    [high, (c * high).sqrt().recip()]
}

/// The nearest number of the geometric sequence.
fn rounded(shift: f64) -> f64 {
    ((FINENESS * shift.log2()).round() / FINENESS).exp2()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fem::{Mesh, QuadratureRule};

    #[test]
    fn the_shifts_make_the_cubic_up_to_a_small_factor() {
        let b = 2e4;
        for c in [1e-20, 1e-16, 8e-13, 8.5e-13, 1e-11, 1e-7, 1e-3] {
            let [s, sigma] = shifts(c, b);
            assert!((c * s * (s - b).powi(2) - 1.0).abs() < 1e-9, "{c:e}: {s}");
            for power in 0..160 {
                let kappa = 1e-3 * 10.0_f64.powf(0.1 * f64::from(power));
                let exact = 1.0 + c * kappa * (kappa + b).powi(2);
                let product = c * (kappa + s) * (kappa + sigma).powi(2);
                let ratio = exact / product;
                assert!((0.249..1.126).contains(&ratio), "{c:e} {kappa:e}: {ratio}");
            }
        }
    }

    /// P is applied as the formula says, and keeps the sum.
    #[test]
    fn the_inverse_is_that_of_the_product() {
        let mesh = Arc::new(Mesh::structured(7, 0.2, 3).expect("a fair mesh"));
        for rule in [QuadratureRule::Lumped, QuadratureRule::Consistent] {
            let space = Space::new(mesh.clone(), rule);
            let size = space.nodes();
            let mut preconditioner = ShiftedInverse::new(&space);
            preconditioner
                .prepare(&space, 1e-9, 0.05)
                .expect("definite");
            let shifts = preconditioner.shifts;
            let exact: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
            // The other way: P x, each M⁻¹ solved by what is known of M.
            let mut inverse = crate::fem::MassInverse::new(&space);
            let (mut x, mut next) = (exact.clone(), vec![0.0; size]);
            for (number, shift) in [shifts[1], shifts[1], shifts[0]].into_iter().enumerate() {
                if number > 0 {
                    let right = x.clone();
                    inverse.solve(&space, &right, &mut x, 1e-14);
                }
                space.stiffness().multiply(&x, &mut next);
                space.mass().multiply_add(shift, &x, &mut next);
                x.iter_mut()
                    .zip(&next)
                    .for_each(|(x, next)| *x = next / shift);
            }
            let sum = vector::sum(&x);
            let scaled: Vec<f64> = x
                .iter()
                .zip(space.nodal_weights())
                .map(|(x, weight)| x / weight.sqrt())
                .collect();
            let mut found = vec![0.0; size];
            preconditioner.apply(&scaled, &mut found);
            let errors = found.iter().zip(&exact).map(|(a, b)| (a - b).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(error < 1e-4, "{rule:?}: {error:e}");
            let kept = vector::dot(space.nodal_weights(), &found);
            assert!((kept - sum).abs() < 1e-12 * sum.abs().max(1.0));
        }
    }
}
