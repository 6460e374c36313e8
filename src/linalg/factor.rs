//! A sparse LDLᵀ factor (faer) of a symmetric matrix on a fixed pattern: analysed once, refactored
//! without allocation.
//!
//! No pivoting: indefinite matrices are factored as they come, after a symmetric scaling that
//! brings every row to a largest entry of about 1, with what is too small for a pivot made larger, and in
//! single precision; solves read it in half precision. That is good for a preconditioner, of a method
//! that does not ask for a linear one, and for nothing else: the caller must check the residual of what
//! it solves.
//! Everything runs in sequence (`Par::Seq`): faer 0.24 has open reports of wrong results from its
//! parallel sparse factorisations.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::perm::PermRef;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};
use faer::{Par, Side};

use super::lower_triangle::LowerTriangle;
use super::supernodal::Supernodes;
use super::{LinalgError, Pattern};

/// Adjacent supernodes become one if together they have at most so many columns, and less than this part of
/// their entries is zero. The library's own choice allows more zeros, which is good where products of small
/// matrices are slow; here the solves are longer with it, and the factor takes the same time
/// (`cargo bench --bench step -- factor`).
const RELAXATION: [(usize, f64); 4] = [(4, 0.3), (16, 0.2), (48, 0.1), (usize::MAX, 0.05)];

/// The library's own "always" is 0, which a factor that takes no operations does not exceed.
const ALWAYS_SUPERNODES: SupernodalThreshold = SupernodalThreshold(-1.0);

/// A pivot that is no larger than this is rounding, the entries being about 1; one of this size takes its
/// place. The matrix is then another by a matrix of rank one, for which a Krylov method needs one iteration
/// more.
const NO_PIVOT: f32 = f32::EPSILON;
const LEAST_PIVOT: f32 = 3.5e-4;

/// A factored symmetric matrix.
pub struct Ldlt {
    size: usize,
    lower: LowerTriangle,
    values: Vec<f64>,
    /// S of the scaled matrix S A S.
    scaling: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f32>,
    /// The scaled matrix, and a scaled right-hand side and its solution, in single precision.
    scaled: Vec<f32>,
    scaled_side: Vec<f32>,
    /// For each row of the factor the row of the matrix.
    order: Vec<u32>,
    factor_memory: MemBuffer,
    supernodes: Supernodes,
}

impl std::fmt::Debug for Ldlt {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Ldlt")
            .field("size", &self.size)
            .field("factor_entries", &self.factor.len())
            .finish_non_exhaustive()
    }
}

impl Ldlt {
    /// Analyses a symmetric pattern whose rows are eliminated in this order, each once.
    ///
    /// # Errors
    /// `Factorisation` when the library cannot (out of memory, index overflow).
    pub fn analyse(pattern: &Pattern, order: Vec<u32>) -> Result<Self, LinalgError> {
        let size = pattern.size();
        let mut inverse = vec![0; size];
        for (place, row) in (0..).zip(&order) {
            inverse[*row as usize] = place;
        }
        let lower = LowerTriangle::of(pattern);
        let failed = |reason: String| LinalgError::Factorisation { size, reason };
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: ALWAYS_SUPERNODES,
            supernodal_params: SymbolicSupernodalParams {
                relax: Some(&RELAXATION),
            },
            ..CholeskySymbolicParams::default()
        };
        let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, size));
        let symbolic =
            factorize_symbolic_cholesky(lower.structure(), Side::Lower, ordering, parameters)
                .map_err(|error| failed(error.to_string()))?;
        let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
            return Err(failed("the factor has no supernodes".to_owned()));
        };
        // What follows takes its numbers twice: where that is not to be had, here is a word for it, and further on
        // the end of the program.
        let mut probe: Vec<f32> = Vec::new();
        probe
            .try_reserve_exact(2 * symbolic.len_val())
            .map_err(|_| failed("not enough memory".to_owned()))?;
        drop(probe);
        let supernodes = Supernodes::new(supernodes);
        let memory = |request: StackReq| {
            MemBuffer::try_new(request).map_err(|_| failed("not enough memory".to_owned()))
        };
        let factor_memory =
            memory(symbolic.factorize_numeric_ldlt_scratch::<f32>(Par::Seq, Default::default()))?;
        let factor = vec![0.0; symbolic.len_val()];
        let scaled = vec![0.0; lower.rows().len()];
        let values = vec![0.0; lower.rows().len()];
        Ok(Self {
            size,
            lower,
            values,
            scaling: vec![1.0; size],
            symbolic,
            factor,
            scaled,
            scaled_side: vec![0.0; size],
            order,
            factor_memory,
            supernodes,
        })
    }

    /// Factors the matrix with these values on the pattern that was analysed; of each pair of
    /// mirrored entries the one in the upper triangle is read.
    ///
    /// # Errors
    /// `Factorisation` where the factor overflows, `NotFinite` where the matrix is not finite.
    pub fn refactor(&mut self, values: &[f64]) -> Result<(), LinalgError> {
        self.lower.gather(|entry| values[entry], &mut self.values);
        self.equilibrate();
        if !self.values.iter().all(|value| value.is_finite()) {
            return Err(LinalgError::NotFinite {
                place: "the matrix to factor",
                iteration: 0,
            });
        }
        for (scaled, value) in self.scaled.iter_mut().zip(&self.values) {
            *scaled = *value as f32;
        }
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.factor,
                SparseColMatRef::new(self.lower.structure(), &self.scaled),
                Side::Lower,
                LdltRegularization {
                    dynamic_regularization_epsilon: NO_PIVOT,
                    dynamic_regularization_delta: LEAST_PIVOT,
                    ..LdltRegularization::default()
                },
                Par::Seq,
                MemStack::new(&mut self.factor_memory),
                Default::default(),
            )
            .map_err(|error| LinalgError::Factorisation {
                size: self.size,
                reason: error.to_string(),
            })?;
        self.supernodes.pack(&self.factor);
        Ok(())
    }

    /// Scales the matrix symmetrically, twice, by the square root of each row's largest entry.
    fn equilibrate(&mut self) {
        self.scaling.fill(1.0);
        let mut largest = vec![0.0_f64; self.size];
        for _ in 0..2 {
            largest.fill(0.0);
            for column in 0..self.size {
                for position in self.lower.column(column) {
                    let row = self.lower.rows()[position] as usize;
                    let value = self.values[position].abs();
                    largest[row] = largest[row].max(value);
                    largest[column] = largest[column].max(value);
                }
            }
            for value in &mut largest {
                *value = if *value > 0.0 {
                    value.sqrt().recip()
                } else {
                    1.0
                };
            }
            for column in 0..self.size {
                for position in self.lower.column(column) {
                    self.values[position] *=
                        largest[column] * largest[self.lower.rows()[position] as usize];
                }
                self.scaling[column] *= largest[column];
            }
        }
    }

    /// x ← A⁻¹ x, nearly: to what half precision makes of it.
    pub fn solve_in_place(&mut self, x: &mut [f64]) {
        let mut largest = 0.0_f64;
        for (x, s) in x.iter_mut().zip(&self.scaling) {
            *x *= s;
            largest = largest.max(x.abs());
        }
        // So that nothing is too small or too large for single precision.
        let unit = if largest > 0.0 { largest } else { 1.0 };
        for (side, row) in self.scaled_side.iter_mut().zip(&self.order) {
            *side = (x[*row as usize] / unit) as f32;
        }
        self.supernodes.solve_in_place(&mut self.scaled_side);
        for (side, row) in self.scaled_side.iter().zip(&self.order) {
            let row = *row as usize;
            x[row] = unit * self.scaling[row] * f64::from(*side);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::minimum_degree;

    fn analysed(pattern: &Pattern) -> Ldlt {
        let order = minimum_degree(pattern).expect("a small pattern");
        Ldlt::analyse(pattern, order).expect("a small pattern")
    }

    /// An indefinite saddle-point matrix [A B; Bᵀ −I] of 2n unknowns, badly scaled.
    fn saddle(n: usize) -> (Pattern, Vec<f64>) {
        let rows: Vec<Vec<u32>> = (0..2 * n)
            .map(|row| {
                let node = row % n;
                let near = node.saturating_sub(1)..=(node + 1).min(n - 1);
                near.flat_map(|other| [other as u32, (other + n) as u32])
                    .collect()
            })
            .collect();
        let pattern = Pattern::from_rows(rows);
        let mut values = vec![0.0; pattern.stored()];
        for row in 0..2 * n {
            for (position, column) in pattern.row(row) {
                let column = column as usize;
                let same = row % n == column % n;
                values[position] = match (row < n, column < n) {
                    (true, true) => {
                        if same {
                            3.0
                        } else {
                            -1.0
                        }
                    }
                    (false, false) => {
                        if same {
                            -1e-8
                        } else {
                            0.0
                        }
                    }
                    _ => 1e-4 * if same { 2.0 } else { 0.5 },
                };
            }
        }
        (pattern, values)
    }

    #[test]
    fn solves_an_indefinite_system_and_can_be_refactored() {
        let (pattern, mut values) = saddle(30);
        let mut factor = analysed(&pattern);
        for _ in 0..2 {
            factor.refactor(&values).expect("no zero pivot");
            let exact: Vec<f64> = (0..60).map(|i| f64::from(i).sin()).collect();
            let mut b = vec![0.0; 60];
            pattern.multiply(&values, &exact, &mut b);
            // By improving on it with the residual in double precision: each solve adds some digits.
            let mut x = vec![0.0; 60];
            let mut errors = Vec::new();
            for _ in 0..6 {
                let mut rest = vec![0.0; 60];
                pattern.multiply(&values, &x, &mut rest);
                rest.iter_mut().zip(&b).for_each(|(r, b)| *r = b - *r);
                factor.solve_in_place(&mut rest);
                x.iter_mut().zip(&rest).for_each(|(x, r)| *x += r);
                let differences = x.iter().zip(&exact).map(|(x, e)| (x - e).abs());
                errors.push(differences.fold(0.0, f64::max));
            }
            // The first solve has a digit; the second, with the residual, some four more.
            assert!(errors[0] < 0.2 && errors[1] < 1e-4, "{errors:?}");
            assert!(errors[5] < 1e-10, "{errors:?}");
            values.iter_mut().for_each(|value| *value *= 2.0);
        }
    }

    #[test]
    fn a_pivot_of_zero_makes_a_factor_that_is_less_exact() {
        // [0 1; 1 0], twice: no order of its rows has other pivots.
        let rows = (0..4_u32).map(|row| vec![row / 2 * 2, row / 2 * 2 + 1]);
        let pattern = Pattern::from_rows(rows.collect());
        let mut values = vec![0.0; pattern.stored()];
        for row in 0..4 {
            let other = row ^ 1;
            let position = pattern.position(row, other).expect("an entry");
            values[position] = 1.0;
        }
        let mut factor = analysed(&pattern);
        factor.refactor(&values).expect("a small pivot");
        let mut x = [1.0, 2.0, 3.0, 4.0];
        factor.solve_in_place(&mut x);
        for (x, exact) in x.into_iter().zip([2.0, 1.0, 4.0, 3.0]) {
            assert!((x - exact).abs() < 2e-3, "{x} {exact}");
        }
    }

    #[test]
    fn what_is_not_finite_is_an_error() {
        let (pattern, mut values) = saddle(5);
        let corner = pattern.position(0, 0).expect("a diagonal entry");
        values[corner] = f64::INFINITY;
        let mut factor = analysed(&pattern);
        assert!(factor.refactor(&values).is_err());
    }
}
