//! How element loads and element matrices add up to vectors and matrices: for every node and every entry of the sparse
//! pattern, the entries of the elements that belong to it.
//!
//! Elements write what they have to contribute, each to a place of its own; then every value collects its contributions,
//! in the order of the elements. So both can be divided among threads, and the sums are the same however they are.

use std::sync::Arc;

use super::Mesh;
use super::space::{LANES, Lane};
use crate::linalg::{Pattern, parallel};

/// The load of each corner, of a group of triangles.
pub type LoadEntries = [Lane; 3];

/// The six different entries aa, ab, ac, bb, bc, cc of the element matrices of a group of triangles.
pub type MatrixEntries = [Lane; 6];

/// Which of the six entries belongs to two corners.
const ENTRY: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// The pattern of the P1 matrices of a mesh and the way into it.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// An entry for every pair of nodes that share a triangle, and for every node with itself.
    pub pattern: Arc<Pattern>,
    /// Where the diagonal entry of each node is stored.
    pub diagonal: Vec<u32>,
    /// For each node, which entries of loads belong to it.
    loads: Contributions,
    /// For each stored value of a matrix, which entries of element matrices belong to it.
    matrices: Contributions,
}

/// Lists of numbers, one after the other.
#[derive(Debug, Clone)]
struct Contributions {
    /// Where each list begins; one more at the end.
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Contributions {
    /// Lists of the pairs (list, number), each in the order of the pairs.
    fn new(lists: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0; lists + 1];
        for (list, _) in pairs.clone() {
            starts[list as usize + 1] += 1;
        }
        for list in 0..lists {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; starts[lists] as usize];
        for (list, number) in pairs {
            let place = &mut next[list as usize];
            numbers[*place as usize] = number;
            *place += 1;
        }
        Self { starts, numbers }
    }

    /// values_i ← values_i + Σ entries_j over the numbers j of the list i, for N vectors with the same lists.
    fn collect<const N: usize>(&self, entries: [&[f64]; N], values: [&mut [f64]; N]) {
        parallel::over_pieces(values, |first, mut values| {
            let length = values.first().map_or(0, |values| values.len());
            let mut start = self.starts[first] as usize;
            for (index, end) in self.starts[first + 1..][..length].iter().enumerate() {
                let end = *end as usize;
                for number in &self.numbers[start..end] {
                    for (values, entries) in values.iter_mut().zip(&entries) {
                        values[index] += entries[*number as usize];
                    }
                }
                start = end;
            }
        });
    }
}

impl Assembly {
    /// The pattern of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let nodes = mesh.nodes().len();
        let mut rows: Vec<Vec<u32>> = (0..nodes as u32).map(|node| vec![node]).collect();
        for triangle in mesh.triangles() {
            for &a in triangle {
                rows[a as usize].extend(triangle);
            }
        }
        let pattern = Pattern::from_rows(rows);
        let position = |row: u32, column: u32| {
            pattern
                .position(row as usize, column as usize)
                .map(|position| position as u32)
                .expect("the pattern was made from these triangles")
        };
        let place = |triangle: usize, entry: usize, entries: usize| {
            (triangle / LANES * entries * LANES + entry * LANES + triangle % LANES) as u32
        };
        let triangles = || mesh.triangles().iter().enumerate();
        let loads = triangles().flat_map(|(number, corners)| {
            (0..3).map(move |corner| (corners[corner], place(number, corner, 3)))
        });
        let loads = Contributions::new(nodes, loads);
        let matrices: Vec<(u32, u32)> = triangles()
            .flat_map(|(number, corners)| {
                (0..9).map(move |pair| {
                    let (a, b) = (pair / 3, pair % 3);
                    let place = place(number, ENTRY[a][b], 6);
                    (position(corners[a], corners[b]), place)
                })
            })
            .collect();
        let matrices = Contributions::new(pattern.stored(), matrices.iter().copied());
        let diagonal = (0..nodes as u32).map(|node| position(node, node)).collect();
        Self {
            diagonal,
            loads,
            matrices,
            pattern: Arc::new(pattern),
        }
    }

    /// diagonal ← diagonal + the first three of each triangle's entries, those of its corners.
    pub fn collect_corners(&self, entries: &[MatrixEntries], diagonal: &mut [f64]) {
        let entries = entries.as_flattened().as_flattened();
        let lists = self.loads.starts.windows(2);
        for (value, list) in diagonal.iter_mut().zip(lists) {
            for number in &self.loads.numbers[list[0] as usize..list[1] as usize] {
                let (group, place) = (
                    *number as usize / (3 * LANES),
                    *number as usize % (3 * LANES),
                );
                *value += entries[group * 6 * LANES + place];
            }
        }
    }

    /// load ← load + the entries of all triangles.
    pub fn collect_load(&self, entries: &[LoadEntries], load: &mut [f64]) {
        self.loads
            .collect([entries.as_flattened().as_flattened()], [load]);
    }

    /// values ← values + the element matrices of all triangles, for N matrices.
    pub fn collect_matrices<const N: usize>(
        &self,
        entries: [&[MatrixEntries]; N],
        values: [&mut [f64]; N],
    ) {
        let entries = entries.map(|entries| entries.as_flattened().as_flattened());
        self.matrices.collect(entries, values);
    }
}
