//! Checksums of the parts of a table, by which the place is found of a number that somebody has changed.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Blocks of rows that have a checksum each: as many, however many rows there are.
const BLOCKS: usize = 128;

/// Sums of the checksums of cells and of rows. Empty cells do not count: in the rows before it a column
/// that comes later is empty.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Checks {
    /// Of each column.
    columns: Vec<[u8; 4]>,
    /// Of each block.
    blocks: Vec<[u8; 4]>,
    /// Rows of a block.
    stride: u64,
}

impl Default for Checks {
    fn default() -> Self {
        Self {
            columns: Vec::new(),
            blocks: vec![[0; 4]; BLOCKS],
            stride: 1,
        }
    }
}

impl Checks {
    /// Of rows as they stand in the file.
    pub fn of<'a>(rows: impl Iterator<Item = &'a str>) -> Self {
        let mut checks = Self::default();
        rows.zip(0..)
            .for_each(|(row, number)| checks.add(number, row));
        checks
    }

    /// Takes in the row of a number, from 0.
    pub fn add(&mut self, number: u64, row: &str) {
        let Some((step, _)) = row.split_once(',') else {
            return;
        };
        for (column, cell) in row.split(',').enumerate() {
            if cell.is_empty() {
                continue;
            }
            if self.columns.len() <= column {
                self.columns.resize(column + 1, [0; 4]);
            }
            add(&mut self.columns[column], hash(step, cell));
        }
        self.stride = self.stride.max(1);
        self.blocks.resize(BLOCKS, [0; 4]);
        while number / self.stride >= BLOCKS as u64 {
            self.stride = self.stride.saturating_mul(2);
            for block in 0..BLOCKS {
                let pair = self.blocks.get(2 * block..2 * block + 2);
                let sum = pair.map_or(0, |pair| value(pair[0]).wrapping_add(value(pair[1])));
                self.blocks[block] = sum.to_le_bytes();
            }
        }
        let block = (number / self.stride) as usize;
        add(
            &mut self.blocks[block],
            hash(step, row.trim_end_matches(',')),
        );
    }

    /// The columns in which other checks of as many rows differ.
    pub fn different_columns(&self, other: &Checks) -> Vec<usize> {
        let [one, other] = [&self.columns, &other.columns];
        let column = |columns: &[[u8; 4]], column| columns.get(column).copied().unwrap_or_default();
        (0..one.len().max(other.len()))
            .filter(|&number| column(one, number) != column(other, number))
            .collect()
    }

    /// The rows among which are all that differ in other checks of as many rows.
    pub fn different_rows(&self, other: &Checks) -> Option<Range<u64>> {
        let pairs = self.blocks.iter().zip(&other.blocks).zip(0..);
        let mut different = pairs.filter(|((one, other), _)| one != other);
        let (_, first): (_, u64) = different.next()?;
        let last = different.last().map_or(first, |(_, last)| last);
        Some(first.saturating_mul(self.stride)..(last + 1).saturating_mul(self.stride))
    }
}

fn hash(step: &str, text: &str) -> u32 {
    let mut hash = crc32fast::Hasher::new();
    hash.update(step.as_bytes());
    hash.update(b",");
    hash.update(text.as_bytes());
    hash.finalize()
}

fn value(sum: [u8; 4]) -> u32 {
    u32::from_le_bytes(sum)
}

fn add(sum: &mut [u8; 4], hash: u32) {
    *sum = value(*sum).wrapping_add(hash).to_le_bytes();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_found_among_any_number_of_rows() {
        for (rows, stride) in [(2, 1), (128, 1), (129, 2), (1000, 8)] {
            let row = |step: u64| format!("{step},{},,7", step as f64 / 3.0);
            let texts: Vec<String> = (0..rows).map(row).collect();
            let checks = Checks::of(texts.iter().map(String::as_str));
            assert_eq!(checks.different_rows(&checks), None);
            assert!(checks.different_columns(&checks).is_empty());
            for changed in [0, rows / 2, rows - 1] {
                let mut other = texts.clone();
                other[changed as usize] = format!("{changed},{},,8", changed as f64 / 3.0);
                let other = Checks::of(other.iter().map(String::as_str));
                assert_eq!(checks.different_columns(&other), [3]);
                let found = checks.different_rows(&other).expect("a change");
                assert_eq!(found.end - found.start, stride);
                assert!(found.contains(&changed), "{changed} in {found:?}");
            }
            // A column that comes later changes nothing of what was.
            let wider: Vec<String> = texts.iter().map(|row| format!("{row},,")).collect();
            assert_eq!(Checks::of(wider.iter().map(String::as_str)), checks);
        }
    }
}
