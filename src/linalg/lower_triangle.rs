//! The lower triangle of a symmetric pattern by columns, as the factorisations of faer want it.

use std::ops::Range;

use faer::sparse::SymbolicSparseColMatRef;

use super::Pattern;

/// The lower triangle, with its diagonal.
pub(super) struct LowerTriangle {
    column_start: Vec<u32>,
    rows: Vec<u32>,
    /// Where its entries stand among the values of the pattern.
    sources: Vec<u32>,
}

impl LowerTriangle {
    /// Of a symmetric pattern.
    pub(super) fn of(pattern: &Pattern) -> Self {
        let mut lower = Self {
            column_start: vec![0],
            rows: Vec::new(),
            sources: Vec::new(),
        };
        // The pattern is symmetric, so the upper part of row i is the lower part of column i.
        for column in 0..pattern.size() {
            let start = lower.rows.len();
            for (position, row) in pattern.row(column) {
                if row as usize >= column {
                    lower.rows.push(row);
                    lower.sources.push(position as u32);
                }
            }
            debug_assert!(lower.rows[start..].is_sorted());
            lower.column_start.push(lower.rows.len() as u32);
        }
        lower
    }

    /// The rows of the entries, column by column.
    pub(super) fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Which entries are those of a column.
    pub(super) fn column(&self, column: usize) -> Range<usize> {
        self.column_start[column] as usize..self.column_start[column + 1] as usize
    }

    /// As the library has it.
    pub(super) fn structure(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let size = self.column_start.len() - 1;
        SymbolicSparseColMatRef::new_checked(size, size, &self.column_start, None, &self.rows)
    }

    /// Its entries, of a matrix whose values on the pattern are these; of each pair of mirrored ones that in the upper
    /// triangle.
    pub(super) fn gather(&self, value: impl Fn(usize) -> f64, entries: &mut [f64]) {
        for (entry, &source) in entries.iter_mut().zip(&self.sources) {
            *entry = value(source as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_part_of_a_row_is_the_lower_part_of_a_column() {
        // [1 2 .; 2 3 4; . 4 5]
        let pattern = Pattern::from_rows(vec![vec![0, 1], vec![0, 1, 2], vec![1, 2]]);
        let lower = LowerTriangle::of(&pattern);
        assert_eq!(lower.rows(), [0, 1, 1, 2, 2]);
        assert_eq!(
            [0, 1, 2].map(|column| lower.column(column)),
            [0..2, 2..4, 4..5]
        );
        let mut values = vec![0.0; pattern.stored()];
        for (row, column, value) in [
            (0, 0, 1.0),
            (0, 1, 2.0),
            (1, 1, 3.0),
            (1, 2, 4.0),
            (2, 2, 5.0),
        ] {
            values[pattern.position(row, column).expect("an entry")] = value;
        }
        let mut entries = [0.0; 5];
        lower.gather(|entry| values[entry], &mut entries);
        assert_eq!(entries, [1.0, 2.0, 3.0, 4.0, 5.0]);
    }
}
