//! Square sparse matrices in compressed rows on a shared, fixed pattern: the pattern is made once,
//! the values are refilled without allocation.

use std::sync::Arc;

/// Which entries of a square matrix may be different from zero, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    row_start: Vec<u32>,
    columns: Vec<u32>,
}

impl Pattern {
    /// The pattern with the given columns in each row; they are sorted and made unique.
    pub fn from_rows(mut rows: Vec<Vec<u32>>) -> Self {
        let size = rows.len();
        let mut row_start = Vec::with_capacity(size + 1);
        let mut columns = Vec::new();
        row_start.push(0);
        for row in &mut rows {
            row.sort_unstable();
            row.dedup();
            assert!(row.last().is_none_or(|&last| (last as usize) < size));
            columns.extend_from_slice(row);
            row_start.push(columns.len() as u32);
        }
        Self { row_start, columns }
    }

    /// Rows (and columns) of the matrix.
    pub fn size(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Entries that are stored.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// The range of stored entries of a row.
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_start[row] as usize..self.row_start[row + 1] as usize
    }

    /// The columns of the stored entries, row after row.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Where the entry (row, column) is stored, if it is.
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.row(row);
        let found = self.columns[range.clone()].binary_search(&(column as u32));
        found.ok().map(|offset| range.start + offset)
    }

    /// Calls `each(row, value, column entries)` for every row of a product: the loop that all
    /// products share.
    #[inline(always)]
    fn for_each_row<const N: usize>(
        &self,
        values: [&[f64]; N],
        mut each: impl FnMut(usize, &[u32], [&[f64]; N]),
    ) {
        let mut start = 0;
        for (row, &end) in self.row_start[1..].iter().enumerate() {
            let range = start..end as usize;
            let entries = values.map(|values| &values[range.clone()]);
            each(row, &self.columns[range.clone()], entries);
            start = range.end;
        }
    }

    /// y ← A x.
    pub fn multiply(&self, a: &[f64], x: &[f64], y: &mut [f64]) {
        self.for_each_row([a], |row, columns, [a]| {
            let mut total = 0.0;
            for (&column, a) in columns.iter().zip(a) {
                total += a * x[column as usize];
            }
            y[row] = total;
        });
    }

    /// y ← y + s A x.
    pub fn multiply_add(&self, s: f64, a: &[f64], x: &[f64], y: &mut [f64]) {
        self.for_each_row([a], |row, columns, [a]| {
            let mut total = 0.0;
            for (&column, a) in columns.iter().zip(a) {
                total += a * x[column as usize];
            }
            y[row] += s * total;
        });
    }

    /// (A x, B x) in one sweep.
    pub fn multiply_both(&self, [a, b]: [&[f64]; 2], x: &[f64], ax: &mut [f64], bx: &mut [f64]) {
        self.for_each_row([a, b], |row, columns, [a, b]| {
            let (mut sum_a, mut sum_b) = (0.0, 0.0);
            for ((&column, a), b) in columns.iter().zip(a).zip(b) {
                let x = x[column as usize];
                sum_a += a * x;
                sum_b += b * x;
            }
            ax[row] = sum_a;
            bx[row] = sum_b;
        });
    }

    /// A x + s B z in one sweep.
    pub fn multiply_sum(&self, a: &[f64], x: &[f64], s: f64, b: &[f64], z: &[f64], y: &mut [f64]) {
        self.for_each_row([a, b], |row, columns, [a, b]| {
            let (mut sum_a, mut sum_b) = (0.0, 0.0);
            for ((&column, a), b) in columns.iter().zip(a).zip(b) {
                sum_a += a * x[column as usize];
                sum_b += b * z[column as usize];
            }
            y[row] = sum_a + s * sum_b;
        });
    }
}

/// A square sparse matrix.
#[derive(Debug, Clone)]
pub struct SparseMatrix {
    /// Its pattern.
    pub pattern: Arc<Pattern>,
    /// The stored entries, in the pattern's order.
    pub values: Vec<f64>,
}

impl SparseMatrix {
    /// The zero matrix on a pattern.
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![0.0; pattern.entries()];
        Self { pattern, values }
    }

    /// y ← A x.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        self.pattern.multiply(&self.values, x, y);
    }

    /// y ← y + s A x.
    pub fn multiply_add(&self, s: f64, x: &[f64], y: &mut [f64]) {
        self.pattern.multiply_add(s, &self.values, x, y);
    }

    /// xᵀ A x.
    pub fn quadratic_form(&self, x: &[f64]) -> f64 {
        let mut total = 0.0;
        self.pattern
            .for_each_row([&self.values], |row, columns, [a]| {
                let mut product = 0.0;
                for (&column, a) in columns.iter().zip(a) {
                    product += a * x[column as usize];
                }
                total += product * x[row];
            });
        total
    }

    /// The largest ratio of a diagonal entry to a weight, doubled: a bound of the eigenvalues of a
    /// diagonally dominant matrix over the diagonal matrix of the weights.
    pub fn eigenvalue_bound(&self, weights: &[f64]) -> f64 {
        let ratios = self
            .diagonal()
            .into_iter()
            .zip(weights)
            .map(|(d, weight)| d / weight);
        2.0 * ratios.fold(0.0, f64::max)
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.pattern.size())
            .map(|row| {
                self.pattern
                    .position(row, row)
                    .map_or(0.0, |position| self.values[position])
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [2 −1 0; −1 2 −1; 0 −1 2]
    fn second_difference() -> SparseMatrix {
        let pattern = Pattern::from_rows(vec![vec![0, 1], vec![2, 1, 0, 1], vec![1, 2]]);
        SparseMatrix {
            pattern: Arc::new(pattern),
            values: vec![2.0, -1.0, -1.0, 2.0, -1.0, -1.0, 2.0],
        }
    }

    #[test]
    fn products_agree_with_the_dense_ones() {
        let a = second_difference();
        let (x, z) = ([1.0, 2.0, 4.0], [0.5, -1.0, 3.0]);
        let mut y = [0.0; 3];
        a.multiply(&x, &mut y);
        assert_eq!(y, [0.0, -1.0, 6.0]);
        a.multiply_add(2.0, &x, &mut y);
        assert_eq!(y, [0.0, -3.0, 18.0]);
        assert_eq!(a.quadratic_form(&x), 22.0);
        assert_eq!(a.diagonal(), [2.0; 3]);
        let (mut first, mut second) = ([0.0; 3], [0.0; 3]);
        let doubled: Vec<f64> = a.values.iter().map(|a| 2.0 * a).collect();
        a.pattern
            .multiply_both([&a.values, &doubled], &x, &mut first, &mut second);
        assert_eq!((first, second), ([0.0, -1.0, 6.0], [0.0, -2.0, 12.0]));
        a.pattern
            .multiply_sum(&a.values, &x, 3.0, &doubled, &z, &mut y);
        assert_eq!(y, [12.0, -34.0, 48.0]);
    }

    #[test]
    fn an_entry_outside_the_pattern_has_no_position() {
        let a = second_difference();
        assert_eq!(a.pattern.position(0, 2), None);
        assert_eq!(a.pattern.position(1, 2), Some(4));
    }
}
