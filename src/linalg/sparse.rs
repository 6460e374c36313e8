//! Square sparse matrices on a shared, fixed pattern: the pattern is made once, the values are
//! refilled without allocation.
//!
//! Rows are stored in blocks of [`LANES`] consecutive ones, slot by slot, so that a product works on
//! all rows of a block at once (a "sliced ELLPACK" format). Where the slots of a block can be chosen
//! so that each has the same column offset in all its rows, as with a mesh that is numbered line by
//! line, a slot reads x in one contiguous piece; otherwise it gathers. Nothing else depends on how a
//! mesh is numbered. Slots that a row does not use hold the value zero.

use std::sync::Arc;

use wide::f64x8;

use super::{op_counts, parallel};

/// Rows of a block: one 512-bit register of f64.
const LANES: usize = 8;

/// A value for each row of a block. (An array is worked on number by number in what is done with the products: the Krylov iterations of
/// case 3 took 1.15 times as long.)
pub type Block = f64x8;

/// The numbers of a block as they are stored.
type Rows = [f64; LANES];

/// Marks a slot whose columns are not consecutive.
const GATHER: u32 = u32::MAX;

/// A block may have this many slots more, relative to its longest row, to have them contiguous.
const SLOT_ALLOWANCE: f64 = 1.5;

/// Which entries of a square matrix may be different from zero.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    size: usize,
    entries: usize,
    /// For each block, its first slot; one more at the end.
    block_start: Vec<u32>,
    /// For each slot, the column of its first row where the columns are consecutive, else [`GATHER`].
    runs: Vec<u32>,
    /// For each slot, the columns of its rows (of an unused entry: any valid one).
    columns: Vec<[u32; LANES]>,
    /// For each slot, which of its rows use it.
    used: Vec<u8>,
}

impl Pattern {
    /// The pattern with the given columns in each row; they are sorted and made unique.
    pub fn from_rows(mut rows: Vec<Vec<u32>>) -> Self {
        let size = rows.len();
        let mut pattern = Self {
            size,
            entries: 0,
            block_start: vec![0],
            runs: Vec::new(),
            columns: Vec::new(),
            used: Vec::new(),
        };
        for (block, rows) in rows.chunks_mut(LANES).enumerate() {
            for row in rows.iter_mut() {
                row.sort_unstable();
                row.dedup();
                assert!(row.last().is_none_or(|&last| (last as usize) < size));
                pattern.entries += row.len();
            }
            pattern.add_block(block * LANES, rows);
            pattern.block_start.push(pattern.runs.len() as u32);
        }
        pattern
    }

    /// Appends the slots of a block of sorted rows.
    fn add_block(&mut self, first_row: usize, rows: &[Vec<u32>]) {
        let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
        let offset = |lane: usize, column: u32| i64::from(column) - (first_row + lane) as i64;
        let mut offsets: Vec<i64> = rows
            .iter()
            .enumerate()
            .flat_map(|(lane, row)| row.iter().map(move |&column| offset(lane, column)))
            .collect();
        offsets.sort_unstable();
        offsets.dedup();
        if offsets.len() as f64 <= SLOT_ALLOWANCE * longest as f64 {
            for shift in offsets {
                let columns = rows.iter().enumerate().map(|(lane, row)| {
                    let column = (first_row + lane) as i64 + shift;
                    row.iter()
                        .copied()
                        .find(|&entry| i64::from(entry) == column)
                });
                self.add_slot(first_row as i64 + shift, columns);
            }
        } else {
            for slot in 0..longest {
                let columns = rows.iter().map(|row| row.get(slot).copied());
                self.add_slot(-1, columns);
            }
        }
    }

    /// Appends a slot. `run` is the first column if they were consecutive.
    fn add_slot(&mut self, run: i64, columns: impl Iterator<Item = Option<u32>>) {
        let mut slot = [0; LANES];
        let mut used = 0;
        for (lane, column) in columns.enumerate() {
            if let Some(column) = column {
                slot[lane] = column;
                used |= 1 << lane;
            }
        }
        let fits = run >= 0 && run as usize + LANES <= self.size;
        self.runs.push(if fits { run as u32 } else { GATHER });
        self.columns.push(slot);
        self.used.push(used);
    }

    /// Rows (and columns) of the matrix.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Entries of the matrix that may be different from zero.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// How many values a matrix on this pattern stores, unused slots included.
    pub fn stored(&self) -> usize {
        LANES * self.runs.len()
    }

    /// The entries of a row: where each is stored, and its column.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, u32)> + '_ {
        let (block, lane) = (row / LANES, row % LANES);
        let slots = self.block_start[block] as usize..self.block_start[block + 1] as usize;
        slots
            .filter(move |&slot| self.used[slot] & (1 << lane) != 0)
            .map(move |slot| (LANES * slot + lane, self.columns[slot][lane]))
    }

    /// Where the entry (row, column) is stored, if it is.
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        self.row(row)
            .find(|&(_, entry)| entry as usize == column)
            .map(|(position, _)| position)
    }

    /// What N matrices make of N vectors in a block of rows: the loop that all products share.
    #[inline(always)]
    fn block<const N: usize>(
        &self,
        block: usize,
        values: &[&[Rows]; N],
        vectors: &[&[f64]; N],
    ) -> [Block; N] {
        let slots = self.block_start[block] as usize..self.block_start[block + 1] as usize;
        let mut sums = [Block::ZERO; N];
        let values = values.map(|values| &values[slots.clone()]);
        let slots = self.runs[slots.clone()].iter().zip(&self.columns[slots]);
        for (slot, (&run, columns)) in slots.enumerate() {
            for matrix in 0..N {
                let vector = vectors[matrix];
                let x = match vector.get(run as usize..).and_then(<[f64]>::first_chunk) {
                    Some(x) => *x,
                    None => columns.map(|column| vector[column as usize]),
                };
                sums[matrix] += Block::new(values[matrix][slot]) * Block::new(x);
            }
        }
        sums
    }

    /// For every block of rows, outputs ← each(products, inputs, outputs), with what N matrices make of N vectors there and the
    /// rows of other vectors: for operators that are a combination of several, in one sweep. The rows that the last block
    /// does not have are zero.
    #[inline(always)]
    pub fn sweep<const N: usize, const K: usize, const M: usize>(
        &self,
        (matrices, vectors): ([&[f64]; N], [&[f64]; N]),
        inputs: [&[f64]; K],
        outputs: [&mut [f64]; M],
        each: impl Fn([Block; N], [Block; K], [Block; M]) -> [Block; M] + Sync,
    ) {
        op_counts::products(N as u64);
        let values = matrices.map(|values| values.as_chunks::<LANES>().0);
        parallel::over_pieces(outputs, |first, outputs| {
            let length = outputs.first().map_or(0, |output| output.len());
            let inputs = inputs.map(|input| in_blocks(&input[first..first + length]));
            let mut outputs = outputs.map(|output| {
                let (blocks, rest) = output.as_chunks_mut();
                let last = filled(rest);
                (blocks, rest, last)
            });
            let first = first / LANES;
            // In one place, so that what is done with the products is compiled into the loop; and by value, so that the
            // compiler knows that no row is another.
            for block in 0..length.div_ceil(LANES) {
                let products = self.block(first + block, &values, &vectors);
                let inputs = inputs
                    .each_ref()
                    .map(|(blocks, last)| Block::new(*blocks.get(block).unwrap_or(last)));
                let places = outputs
                    .each_mut()
                    .map(|(blocks, _, last)| blocks.get_mut(block).unwrap_or(last));
                let before = places.each_ref().map(|place| Block::new(**place));
                for (place, rows) in places.into_iter().zip(each(products, inputs, before)) {
                    *place = rows.to_array();
                }
            }
            for (_, rest, last) in &mut outputs {
                let rows = rest.len();
                rest.copy_from_slice(&last[..rows]);
            }
        });
    }

    /// y ← A x.
    pub fn multiply(&self, a: &[f64], x: &[f64], y: &mut [f64]) {
        self.sweep(([a], [x]), [], [y], |[sums], [], _| [sums]);
    }

    /// y ← y + s A x.
    pub fn multiply_add(&self, s: f64, a: &[f64], x: &[f64], y: &mut [f64]) {
        self.sweep(([a], [x]), [], [y], |[sums], [], [y]| {
            [y + Block::splat(s) * sums]
        });
    }

    /// (A x, B x) in one sweep.
    pub fn multiply_both(&self, matrices: [&[f64]; 2], x: &[f64], ax: &mut [f64], bx: &mut [f64]) {
        self.sweep((matrices, [x, x]), [], [ax, bx], |both, [], _| both);
    }

    /// y ← A x + s B z in one sweep.
    pub fn multiply_sum(&self, a: &[f64], x: &[f64], s: f64, b: &[f64], z: &[f64], y: &mut [f64]) {
        self.sweep(([a, b], [x, z]), [], [y], |[a, b], [], _| {
            [a + Block::splat(s) * b]
        });
    }
}

/// Whole blocks of rows, and the last rows with zeros.
fn in_blocks(rows: &[f64]) -> (&[Rows], Rows) {
    let (blocks, rest) = rows.as_chunks();
    (blocks, filled(rest))
}

/// The last rows, and zeros.
fn filled(rows: &[f64]) -> Rows {
    let mut block = [0.0; LANES];
    block[..rows.len()].copy_from_slice(rows);
    block
}

/// A square sparse matrix.
#[derive(Debug, Clone)]
pub struct SparseMatrix {
    /// Its pattern.
    pub pattern: Arc<Pattern>,
    /// The stored values, in the pattern's order; those of unused slots must stay zero.
    pub values: Vec<f64>,
}

impl SparseMatrix {
    /// The zero matrix on a pattern.
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![0.0; pattern.stored()];
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
        op_counts::products(1);
        let values = [self.values.as_chunks::<LANES>().0];
        let mut lanes = [0.0; LANES];
        for (number, rows) in x.chunks(LANES).enumerate() {
            let [sums] = self.pattern.block(number, &values, &[x]);
            for ((lane, sum), x) in lanes.iter_mut().zip(sums.to_array()).zip(rows) {
                *lane += sum * x;
            }
        }
        lanes.iter().sum()
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

    /// Row, column, value.
    type Entry = (usize, usize, f64);

    /// A matrix with the given entries.
    fn matrix(size: usize, entries: &[Entry]) -> SparseMatrix {
        let mut rows = vec![Vec::new(); size];
        entries
            .iter()
            .for_each(|&(row, column, _)| rows[row].push(column as u32));
        let mut matrix = SparseMatrix::zeros(Arc::new(Pattern::from_rows(rows)));
        for &(row, column, value) in entries {
            let position = matrix
                .pattern
                .position(row, column)
                .expect("in the pattern");
            matrix.values[position] += value;
        }
        matrix
    }

    /// A band matrix (contiguous slots), and one with columns all over the place (gathered slots);
    /// sizes that do and do not fill the last block.
    fn examples() -> Vec<(usize, Vec<Entry>)> {
        let mut examples = Vec::new();
        for size in [3_usize, 16, 29] {
            let value = |row: usize, column: usize| 1.0 + (3 * row + 7 * column) as f64;
            let band = (0..size).flat_map(|row| {
                let near = row.saturating_sub(1)..=(row + 1).min(size - 1);
                near.map(move |column| (row, column, value(row, column)))
            });
            examples.push((size, band.collect()));
            let scattered = (0..size).flat_map(|row| {
                let columns = (0..=row % 4).map(move |j| (row * row + 5 * j) % size);
                columns.map(move |column| (row, column, value(row, column)))
            });
            examples.push((size, scattered.collect()));
        }
        examples
    }

    fn dense_product(entries: &[Entry], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        entries
            .iter()
            .for_each(|&(row, column, value)| y[row] += value * x[column]);
        y
    }

    #[test]
    fn products_agree_with_the_dense_ones() {
        for (size, entries) in examples() {
            let a = matrix(size, &entries);
            let x: Vec<f64> = (0..size).map(|i| (i % 5) as f64 - 1.0).collect();
            let z: Vec<f64> = (0..size).map(|i| (i % 3) as f64).collect();
            let (ax, az) = (dense_product(&entries, &x), dense_product(&entries, &z));
            let mut y = vec![7.0; size];
            a.multiply(&x, &mut y);
            assert_eq!(y, ax);
            a.multiply_add(2.0, &x, &mut y);
            assert!(y.iter().zip(&ax).all(|(y, ax)| *y == 3.0 * ax));
            let mut other = vec![7.0; size];
            let doubled: Vec<f64> = a.values.iter().map(|a| 2.0 * a).collect();
            a.pattern
                .multiply_both([&a.values, &doubled], &x, &mut y, &mut other);
            assert_eq!(y, ax);
            assert!(other.iter().zip(&ax).all(|(y, ax)| *y == 2.0 * ax));
            a.pattern
                .multiply_sum(&a.values, &x, 3.0, &doubled, &z, &mut y);
            for (y, (ax, az)) in y.iter().zip(ax.iter().zip(&az)) {
                assert_eq!(*y, ax + 6.0 * az);
            }
            let mut y = vec![1.0; size];
            let of_both = ([&a.values[..], &doubled], [&x[..], &z]);
            a.pattern
                .sweep(of_both, [&x, &z], [&mut y], |[ax, az], [x, z], [y]| {
                    [y + (ax + az + Block::splat(3.0) * x - z)]
                });
            for row in 0..size {
                let expected = 1.0 + (ax[row] + 2.0 * az[row] + 3.0 * x[row] - z[row]);
                assert_eq!(y[row], expected);
            }
            let form: f64 = ax.iter().zip(&x).map(|(ax, x)| ax * x).sum();
            assert_eq!(a.quadratic_form(&x), form);
        }
    }

    #[test]
    fn a_band_is_contiguous_and_a_scattered_matrix_is_not_padded_much() {
        let examples = examples();
        let band = matrix(29, &examples[4].1);
        let contiguous = band
            .pattern
            .runs
            .iter()
            .filter(|run| **run != GATHER)
            .count();
        assert_eq!((band.pattern.runs.len(), contiguous), (12, 8));
        let scattered = matrix(29, &examples[5].1);
        assert_eq!(scattered.pattern.runs.len(), 16);
    }

    #[test]
    fn rows_list_what_was_given() {
        for (size, entries) in examples() {
            let a = matrix(size, &entries);
            let mut found = 0;
            for row in 0..size {
                for (position, column) in a.pattern.row(row) {
                    assert!(entries.iter().any(|e| (e.0, e.1) == (row, column as usize)));
                    assert_eq!(a.pattern.position(row, column as usize), Some(position));
                    found += 1;
                }
            }
            assert_eq!(found, a.pattern.entries());
        }
        let (size, entries) = &examples()[2];
        assert_eq!(matrix(*size, entries).pattern.position(0, 9), None);
    }
}
