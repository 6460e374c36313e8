//! Where each triangle's 3 × 3 element matrix goes in the sparse pattern of the mesh.

use std::sync::Arc;

use super::Mesh;
use crate::linalg::Pattern;

/// The pattern of the P1 matrices of a mesh and the way into it.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// An entry for every pair of nodes that share a triangle, and for every node with itself.
    pub pattern: Arc<Pattern>,
    /// Where the entries (a, b) of each triangle's element matrix are stored, row by row.
    positions: Vec<[[u32; 3]; 3]>,
    /// Where the diagonal entry of each node is stored.
    pub diagonal: Vec<u32>,
}

impl Assembly {
    /// The pattern of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let mut rows: Vec<Vec<u32>> = (0..mesh.nodes().len() as u32)
            .map(|node| vec![node])
            .collect();
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
        let positions = mesh
            .triangles()
            .iter()
            .map(|triangle| triangle.map(|a| triangle.map(|b| position(a, b))))
            .collect();
        let diagonal = (0..mesh.nodes().len() as u32)
            .map(|node| position(node, node))
            .collect();
        Self {
            pattern: Arc::new(pattern),
            positions,
            diagonal,
        }
    }

    /// values ← values + the symmetric element matrix of a triangle, given by its entries aa, ab, ac,
    /// bb, bc, cc.
    #[inline(always)]
    pub fn add_element(&self, values: &mut [f64], triangle: usize, entries: &[f64; 6]) {
        let [aa, ab, ac, bb, bc, cc] = *entries;
        let element = [[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]];
        for (positions, entries) in self.positions[triangle].iter().zip(element) {
            for (&position, entry) in positions.iter().zip(entries) {
                values[position as usize] += entry;
            }
        }
    }
}
