//! Solves with a supernodal factor L D Lᵀ in single precision, L's diagonal being 1.
//!
//! A *supernode* is some columns that follow each other and share the rows below them; its entries are a
//! dense matrix. To solve is to read the factor twice, and it is too large to stay in a cache. So it
//! is packed once into the order in which a solve reads it, for the processor to fetch ahead: the columns
//! of a supernode by fours, *panels*; of a panel first the square on the diagonal, then the rows below it
//! by eights, *tiles*; of each the columns one after the other. What a supernode needs of the solution is
//! gathered once.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// Columns of a panel; the last one of a supernode may have fewer.
const COLUMNS: usize = 4;

/// Rows of a tile; the last one of a panel may have fewer.
const ROWS: usize = 8;

/// A factor's entries, as the library leaves them or packed, with what solves need beside them.
pub(super) struct Supernodes {
    /// The first column of each; one more at the end.
    start: Vec<u32>,
    /// The rows below each, one after the other, and where they begin; one more at the end.
    below: Vec<u32>,
    below_start: Vec<u32>,
    /// Where the entries of each begin; one more at the end.
    entries_start: Vec<u32>,
    /// Of one supernode: its entries, and its part of a solution.
    entries: Vec<f32>,
    local: Vec<f32>,
}

impl Supernodes {
    /// The structure that the library found.
    pub(super) fn new(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let mut start = symbolic.supernode_begin().to_vec();
        start.push(symbolic.ncols() as u32);
        let (mut below, mut below_start) = (Vec::new(), vec![0]);
        let (mut most_rows, mut most_entries) = (0, 0);
        for (number, ends) in start.windows(2).enumerate() {
            let rows = symbolic.supernode(number).pattern();
            below.extend_from_slice(rows);
            below_start.push(below.len() as u32);
            let columns = (ends[1] - ends[0]) as usize;
            most_rows = most_rows.max(columns + rows.len());
            most_entries = most_entries.max(columns * (columns + rows.len()));
        }
        Self {
            start,
            below,
            below_start,
            entries_start: symbolic.col_ptr_for_val().to_vec(),
            entries: vec![0.0; most_entries],
            local: vec![0.0; most_rows],
        }
    }

    fn count(&self) -> usize {
        self.start.len() - 1
    }

    fn columns(&self, number: usize) -> std::ops::Range<usize> {
        self.start[number] as usize..self.start[number + 1] as usize
    }

    fn below(&self, number: usize) -> std::ops::Range<usize> {
        self.below_start[number] as usize..self.below_start[number + 1] as usize
    }

    fn entries(&self, number: usize) -> std::ops::Range<usize> {
        self.entries_start[number] as usize..self.entries_start[number + 1] as usize
    }

    /// Packs a factor that the library has just made, in its place.
    pub(super) fn pack(&mut self, factor: &mut [f32]) {
        for number in 0..self.count() {
            let columns = self.columns(number).len();
            let height = columns + self.below(number).len();
            let place = &mut factor[self.entries(number)];
            let entries = &mut self.entries[..place.len()];
            entries.copy_from_slice(place);
            let mut free = place;
            let mut put = |rows: std::ops::Range<usize>, panel: std::ops::Range<usize>| {
                for column in panel {
                    let from = &entries[column * height..][rows.clone()];
                    let (to, rest) = std::mem::take(&mut free).split_at_mut(from.len());
                    match (to.first_chunk_mut::<ROWS>(), from.first_chunk::<ROWS>()) {
                        // Of a size that is known: one instruction, not a call.
                        (Some(to), Some(from)) => *to = *from,
                        _ => to.copy_from_slice(from),
                    }
                    free = rest;
                }
            };
            for first in (0..columns).step_by(COLUMNS) {
                let end = (first + COLUMNS).min(columns);
                put(first..end, first..end);
                for row in (end..height).step_by(ROWS) {
                    put(row..(row + ROWS).min(height), first..end);
                }
            }
        }
    }

    /// x ← (L D Lᵀ)⁻¹ x with a packed factor, in the order of its rows.
    pub(super) fn solve_in_place(&mut self, factor: &[f32], x: &mut [f32]) {
        let mut local = std::mem::take(&mut self.local);
        for number in 0..self.count() {
            let (columns, below) = (self.columns(number), &self.below[self.below(number)]);
            let local = &mut local[..columns.len() + below.len()];
            let (own, sums) = local.split_at_mut(columns.len());
            own.copy_from_slice(&x[columns.clone()]);
            sums.fill(0.0);
            forward(&factor[self.entries(number)], columns.len(), local);
            x[columns.clone()].copy_from_slice(&local[..columns.len()]);
            for (row, sum) in below.iter().zip(&local[columns.len()..]) {
                x[*row as usize] += sum;
            }
        }
        for number in (0..self.count()).rev() {
            let (columns, below) = (self.columns(number), &self.below[self.below(number)]);
            let local = &mut local[..columns.len() + below.len()];
            let (own, rest) = local.split_at_mut(columns.len());
            own.copy_from_slice(&x[columns.clone()]);
            for (value, row) in rest.iter_mut().zip(below) {
                *value = x[*row as usize];
            }
            backward(&factor[self.entries(number)], columns.len(), local);
            x[columns.clone()].copy_from_slice(&local[..columns.len()]);
        }
        self.local = local;
    }
}

/// A supernode's panels from the first to the last: x ← D⁻¹ L⁻¹ x in its columns, with which `local`
/// begins, and in the rows below them x ← x − L x.
fn forward(mut entries: &[f32], columns: usize, local: &mut [f32]) {
    let mut open = local;
    let mut left = columns;
    while left > 0 {
        let width = left.min(COLUMNS);
        let (panel, rest) = entries.split_at(width * open.len());
        match width {
            4 => forward_panel::<4>(panel, open),
            3 => forward_panel::<3>(panel, open),
            2 => forward_panel::<2>(panel, open),
            _ => forward_panel::<1>(panel, open),
        }
        (entries, open, left) = (rest, &mut open[width..], left - width);
    }
}

/// A supernode's panels from the last to the first: x ← L⁻ᵀ x in its columns.
fn backward(entries: &[f32], columns: usize, local: &mut [f32]) {
    let height = local.len();
    // Where the entries of the panel end that begins with this column.
    let mut end = {
        let whole = columns / COLUMNS * COLUMNS;
        let before: usize = (0..whole)
            .step_by(COLUMNS)
            .map(|first| COLUMNS * (height - first))
            .sum();
        before + (columns - whole) * (height - whole)
    };
    let mut left = columns;
    while left > 0 {
        let first = (left - 1) / COLUMNS * COLUMNS;
        let width = left - first;
        let begin = end - width * (height - first);
        let (panel, open) = (&entries[begin..end], &mut local[first..]);
        match width {
            4 => backward_panel::<4>(panel, open),
            3 => backward_panel::<3>(panel, open),
            2 => backward_panel::<2>(panel, open),
            _ => backward_panel::<1>(panel, open),
        }
        (end, left) = (begin, first);
    }
}

/// The square of a panel, its whole tiles, and the rest.
#[inline(always)]
fn parts_of<const W: usize>(panel: &[f32], rows: usize) -> (&[f32], &[[f32; ROWS]], &[f32]) {
    let (square, below) = panel.split_at(W * W);
    let (tiles, rest) = below.split_at(rows / ROWS * ROWS * W);
    (square, tiles.as_chunks().0, rest)
}

#[inline(always)]
fn forward_panel<const W: usize>(panel: &[f32], local: &mut [f32]) {
    let (own, rows) = local.split_at_mut(W);
    let (square, tiles, rest) = parts_of::<W>(panel, rows.len());
    let mut values = [0.0; W];
    values.copy_from_slice(own);
    for column in 0..W {
        for row in column + 1..W {
            values[row] -= square[W * column + row] * values[column];
        }
        own[column] = values[column] / square[W * column + column];
    }
    let (chunks, last) = rows.as_chunks_mut::<ROWS>();
    for (tile, chunk) in tiles.chunks_exact(W).zip(chunks) {
        for column in 0..W {
            for row in 0..ROWS {
                chunk[row] -= tile[column][row] * values[column];
            }
        }
    }
    for (column, value) in rest.chunks_exact(last.len().max(1)).zip(values) {
        for (row, entry) in last.iter_mut().zip(column) {
            *row -= entry * value;
        }
    }
}

#[inline(always)]
fn backward_panel<const W: usize>(panel: &[f32], local: &mut [f32]) {
    let (own, rows) = local.split_at_mut(W);
    let (square, tiles, rest) = parts_of::<W>(panel, rows.len());
    let mut lanes = [[0.0_f32; ROWS]; W];
    let (chunks, last) = rows.as_chunks::<ROWS>();
    for (tile, chunk) in tiles.chunks_exact(W).zip(chunks) {
        for column in 0..W {
            for row in 0..ROWS {
                lanes[column][row] += tile[column][row] * chunk[row];
            }
        }
    }
    for (column, lanes) in rest.chunks_exact(last.len().max(1)).zip(&mut lanes) {
        for ((lane, entry), row) in lanes.iter_mut().zip(column).zip(last) {
            *lane += entry * row;
        }
    }
    for column in (0..W).rev() {
        let mut sum = lanes[column].iter().sum::<f32>();
        for row in column + 1..W {
            sum += square[W * column + row] * own[row];
        }
        own[column] -= sum;
    }
}

#[cfg(test)]
mod tests {
    use crate::linalg::{Ldlt, Pattern};

    /// How far the solution is off whose matrix couples those of `size` unknowns that `couples` says.
    fn error_of(size: usize, couples: impl Fn(usize, usize) -> bool) -> f64 {
        let columns = |row: usize| (0..size).filter(move |column| *column != row);
        let rows: Vec<Vec<u32>> = (0..size)
            .map(|row| {
                let others = columns(row).filter(|column| couples(row, *column));
                let mut row: Vec<u32> = others.chain([row]).map(|column| column as u32).collect();
                row.sort_unstable();
                row
            })
            .collect();
        let pattern = Pattern::from_rows(rows);
        let mut values = vec![0.0; pattern.stored()];
        for row in 0..size {
            let degree = pattern.row(row).count();
            for (position, column) in pattern.row(row) {
                let (low, high) = (row.min(column as usize), row.max(column as usize));
                values[position] = if low == high {
                    // Of both signs: LDLᵀ, not LLᵀ.
                    degree as f64 * if row % 3 == 0 { -1.0 } else { 1.0 }
                } else {
                    ((7 * low + 3 * high) as f64).sin()
                };
            }
        }
        let exact: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
        let mut x = vec![0.0; size];
        pattern.multiply(&values, &exact, &mut x);
        let mut factor = Ldlt::analyse(&pattern).expect("a small pattern");
        factor.refactor(&values).expect("no zero pivot");
        factor.solve_in_place(&mut x);
        let errors = x.iter().zip(&exact).map(|(x, exact)| (x - exact).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn one_supernode_of_any_width_is_solved_with() {
        for size in 1..=21 {
            let error = error_of(size, |_, _| true);
            assert!(error < 1e-5, "{size}: {error:e}");
        }
    }

    #[test]
    fn supernodes_with_rows_below_are_solved_with() {
        for n in [5, 12, 23] {
            let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
            let couples = |a: usize, b: usize| near(a / n, b / n) && near(a % n, b % n);
            let error = error_of(n * n, couples);
            assert!(error < 1e-5, "{n}: {error:e}");
        }
    }
}
