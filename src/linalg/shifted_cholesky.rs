//! Sparse Cholesky factors of A + s B for several shifts s > 0, A and B symmetric on one pattern and such
//! that every sum is positive definite: what a rational function of B⁻¹A is applied with.
//!
//! The structure is analysed once (faer, simplicial, AMD ordering). A factor is computed in double
//! precision and kept in single precision: to solve is to read it twice, and half the bytes take half
//! the time. The arithmetic of a solve is in double precision, so that it stays a linear map to that
//! precision: the inverse of a matrix that differs from A + s B by some 1e-7. That is good for a
//! preconditioner and for nothing else.
//!
//! Columns that follow each other and have the same rows below them are a *supernode*: in a solve they
//! work on contiguous numbers, and what they do to those rows is gathered first.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Par, Side};

use super::lower_triangle::LowerTriangle;
use super::{LinalgError, Pattern};

/// The structure of the factors, and the last few factors that were used.
pub struct ShiftedFactors {
    size: usize,
    lower: LowerTriangle,
    values: Vec<f64>,
    symbolic: SymbolicCholesky<u32>,
    memory: MemBuffer,
    /// The factor in double precision, while it is made.
    scratch: Vec<f64>,
    /// For each column of the factors where its entries begin, the diagonal first and the rows
    /// ascending; one more at the end.
    start: Vec<u32>,
    /// The first column of each supernode; one more at the end.
    supernodes: Vec<u32>,
    /// The rows below each supernode, one after the other, and where they begin; one more at the end.
    below: Vec<u32>,
    below_start: Vec<u32>,
    /// For each row of the factors the row of the matrix.
    order: Vec<u32>,
    /// The last used last.
    kept: Vec<Factor>,
    most_kept: usize,
    permuted: Vec<f64>,
    gathered: Vec<f64>,
}

/// One factor L D Lᵀ, L's diagonal being 1.
struct Factor {
    shift: f64,
    /// The entries of L by columns, the diagonal's places unused.
    entries: Vec<f32>,
    /// D⁻¹.
    inverse_diagonal: Vec<f64>,
}

impl std::fmt::Debug for ShiftedFactors {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("ShiftedFactors")
            .field("size", &self.size)
            .field("entries", &self.entries())
            .field("kept", &self.kept.len())
            .finish_non_exhaustive()
    }
}

impl ShiftedFactors {
    /// Analyses a symmetric pattern; so many factors will be kept.
    ///
    /// # Errors
    /// `Factorisation` when the library cannot (out of memory, index overflow).
    pub fn analyse(pattern: &Pattern, most_kept: usize) -> Result<Self, LinalgError> {
        let size = pattern.size();
        let failed = |reason: String| LinalgError::Factorisation { size, reason };
        let lower = LowerTriangle::of(pattern);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let ordering = SymmetricOrdering::Amd;
        let symbolic =
            factorize_symbolic_cholesky(lower.structure(), Side::Lower, ordering, parameters)
                .map_err(|error| failed(error.to_string()))?;
        let SymbolicCholeskyRaw::Simplicial(simplicial) = symbolic.raw() else {
            return Err(failed("the factor is not simplicial".to_owned()));
        };
        let start = simplicial.col_ptr().to_vec();
        let rows_of = |column: usize| {
            &simplicial.row_idx()[start[column] as usize..start[column + 1] as usize]
        };
        let mut supernodes = vec![0];
        let (mut below, mut below_start) = (Vec::new(), vec![0]);
        let mut most_below = 0;
        for column in 0..size {
            let rows = rows_of(column);
            debug_assert!(rows.is_sorted() && rows.first() == Some(&(column as u32)));
            if column + 1 < size && rows[1..] == *rows_of(column + 1) {
                continue;
            }
            supernodes.push(column as u32 + 1);
            below.extend_from_slice(&rows[1..]);
            below_start.push(below.len() as u32);
            most_below = most_below.max(rows.len() - 1);
        }
        let order = match symbolic.perm() {
            Some(permutation) => permutation.arrays().0.to_vec(),
            None => (0..size as u32).collect(),
        };
        let request = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let memory =
            MemBuffer::try_new(request).map_err(|_| failed("not enough memory".to_owned()))?;
        Ok(Self {
            size,
            values: vec![0.0; lower.rows().len()],
            lower,
            scratch: vec![0.0; symbolic.len_val()],
            symbolic,
            memory,
            start,
            supernodes,
            below,
            below_start,
            gathered: vec![0.0; most_below],
            order,
            kept: Vec::with_capacity(most_kept.max(1)),
            most_kept: most_kept.max(1),
            permuted: vec![0.0; size],
        })
    }

    /// Entries of a factor, its diagonal included.
    pub fn entries(&self) -> usize {
        self.start.last().map_or(0, |end| *end as usize)
    }

    /// Makes the factor of A + s B, if it is not kept.
    ///
    /// # Errors
    /// `Factorisation` where a pivot is not positive, `NotFinite` where the matrix is not finite.
    pub fn prepare(&mut self, shift: f64, a: &[f64], b: &[f64]) -> Result<(), LinalgError> {
        let known = self.kept.iter().position(|factor| factor.shift == shift);
        if let Some(known) = known {
            let factor = self.kept.remove(known);
            self.kept.push(factor);
            return Ok(());
        }
        let sum = |entry: usize| a[entry] + shift * b[entry];
        self.lower.gather(sum, &mut self.values);
        if !self.values.iter().all(|value| value.is_finite()) {
            return Err(LinalgError::NotFinite {
                place: "the matrix to factor",
                iteration: 0,
            });
        }
        let size = self.size;
        let failed = |reason: String| LinalgError::Factorisation { size, reason };
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.scratch,
                SparseColMatRef::new(self.lower.structure(), &self.values),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .map_err(|error| failed(error.to_string()))?;
        // The memory of the one that was not used for the longest time.
        let mut factor = if self.kept.len() >= self.most_kept {
            self.kept.remove(0)
        } else {
            Factor {
                shift,
                entries: vec![0.0; self.scratch.len()],
                inverse_diagonal: vec![0.0; size],
            }
        };
        factor.shift = shift;
        for (entry, value) in factor.entries.iter_mut().zip(&self.scratch) {
            *entry = *value as f32;
        }
        for (inverse, start) in factor.inverse_diagonal.iter_mut().zip(&self.start) {
            let pivot = self.scratch[*start as usize];
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(failed(format!("the pivot {pivot:e} is not positive")));
            }
            *inverse = pivot.recip();
        }
        self.kept.push(factor);
        Ok(())
    }

    /// x ← (A + s B)⁻¹ x; nothing where that factor was not [prepared](Self::prepare).
    pub fn solve_in_place(&mut self, shift: f64, x: &mut [f64]) {
        let Some(factor) = self.kept.iter().find(|factor| factor.shift == shift) else {
            return;
        };
        let permuted = &mut self.permuted[..];
        for (value, row) in permuted.iter_mut().zip(&self.order) {
            *value = x[*row as usize];
        }
        let entries_of = |column: usize| {
            &factor.entries[self.start[column] as usize + 1..self.start[column + 1] as usize]
        };
        let below_of = |number: usize| {
            &self.below[self.below_start[number] as usize..self.below_start[number + 1] as usize]
        };
        let columns_of =
            |number: usize| self.supernodes[number] as usize..self.supernodes[number + 1] as usize;
        let count = self.supernodes.len() - 1;
        for number in 0..count {
            let (columns, below) = (columns_of(number), below_of(number));
            let gathered = &mut self.gathered[..below.len()];
            gathered.fill(0.0);
            for column in columns.clone() {
                let (inner, outer) = entries_of(column).split_at(columns.end - 1 - column);
                let value = permuted[column];
                subtract(&mut permuted[column + 1..columns.end], inner, value);
                subtract(gathered, outer, value);
            }
            for (row, sum) in below.iter().zip(gathered) {
                permuted[*row as usize] += *sum;
            }
        }
        for number in (0..count).rev() {
            let (columns, below) = (columns_of(number), below_of(number));
            let gathered = &mut self.gathered[..below.len()];
            for (row, value) in below.iter().zip(&mut *gathered) {
                *value = permuted[*row as usize];
            }
            for column in columns.clone().rev() {
                let (inner, outer) = entries_of(column).split_at(columns.end - 1 - column);
                let sum = dot(inner, &permuted[column + 1..columns.end]) + dot(outer, gathered);
                permuted[column] = permuted[column] * factor.inverse_diagonal[column] - sum;
            }
        }
        for (value, row) in permuted.iter().zip(&self.order) {
            x[*row as usize] = *value;
        }
    }
}

/// x ← x − s a.
#[inline(always)]
fn subtract(x: &mut [f64], a: &[f32], s: f64) {
    for (x, a) in x.iter_mut().zip(a) {
        *x -= f64::from(*a) * s;
    }
}

/// Numbers that are added up side by side.
const LANES: usize = 8;

/// aᵀx, in lanes.
#[inline(always)]
fn dot(a: &[f32], x: &[f64]) -> f64 {
    let ((a, a_rest), (x, x_rest)) = (a.as_chunks::<LANES>(), x.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, x) in a.iter().zip(x) {
        for lane in 0..LANES {
            sums[lane] += f64::from(a[lane]) * x[lane];
        }
    }
    let rest = a_rest.iter().zip(x_rest).map(|(a, x)| f64::from(*a) * x);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The five-point stencil on a square of n × n places.
    fn laplacian(n: usize) -> (Pattern, Vec<f64>, Vec<f64>) {
        let neighbours = |row: usize| {
            let (i, j) = (row / n, row % n);
            let mut columns = vec![row as u32];
            columns.extend((i > 0).then(|| (row - n) as u32));
            columns.extend((i + 1 < n).then(|| (row + n) as u32));
            columns.extend((j > 0).then(|| (row - 1) as u32));
            columns.extend((j + 1 < n).then(|| (row + 1) as u32));
            columns
        };
        let pattern = Pattern::from_rows((0..n * n).map(neighbours).collect());
        let (mut a, mut b) = (vec![0.0; pattern.stored()], vec![0.0; pattern.stored()]);
        for row in 0..n * n {
            let degree = pattern.row(row).count() - 1;
            for (position, column) in pattern.row(row) {
                let is_diagonal = column as usize == row;
                a[position] = if is_diagonal { degree as f64 } else { -1.0 };
                b[position] = if is_diagonal {
                    1.0 + 0.1 * (row % 3) as f64
                } else {
                    0.0
                };
            }
        }
        (pattern, a, b)
    }

    #[test]
    fn factors_are_those_of_their_shifts_to_single_precision() {
        let (pattern, a, b) = laplacian(17);
        let mut factors = ShiftedFactors::analyse(&pattern, 2).expect("a small pattern");
        let exact: Vec<f64> = (0..289).map(|i| f64::from(i).sin()).collect();
        for shift in [0.3, 20.0, 0.3, 5.0, 20.0] {
            factors.prepare(shift, &a, &b).expect("positive definite");
            let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + shift * b).collect();
            let mut x = vec![0.0; 289];
            pattern.multiply(&sum, &exact, &mut x);
            factors.solve_in_place(shift, &mut x);
            let errors = x.iter().zip(&exact).map(|(x, exact)| (x - exact).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(
                error < 1e-5 && factors.kept.len() <= 2,
                "{shift}: {error:e}"
            );
        }
    }

    /// To double precision, however roughly the factor is kept: GMRES relies on it.
    #[test]
    fn a_solve_is_a_linear_map() {
        let (pattern, a, b) = laplacian(11);
        let mut factors = ShiftedFactors::analyse(&pattern, 1).expect("a small pattern");
        factors.prepare(1e-3, &a, &b).expect("positive definite");
        let mut solve = |x: &dyn Fn(f64) -> f64| {
            let mut x: Vec<f64> = (0..121).map(|i| x(f64::from(i))).collect();
            factors.solve_in_place(1e-3, &mut x);
            x
        };
        let (one, other) = (solve(&f64::sin), solve(&|i| (0.7 * i).cos()));
        let both = solve(&|i| 3.0 * i.sin() - 2.0 * (0.7 * i).cos());
        for (both, (one, other)) in both.iter().zip(one.iter().zip(&other)) {
            assert!((both - (3.0 * one - 2.0 * other)).abs() < 1e-11);
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_an_error() {
        let (pattern, a, b) = laplacian(5);
        let mut factors = ShiftedFactors::analyse(&pattern, 1).expect("a small pattern");
        assert!(factors.prepare(-1.0, &a, &b).is_err());
        assert!(factors.prepare(f64::NAN, &a, &b).is_err());
        assert!(factors.prepare(1.0, &a, &b).is_ok());
    }
}
