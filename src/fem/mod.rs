//! Meshes (a stand-in for the real room).

/// A triangulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    nodes: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The structured mesh of the unit square.
    pub fn structured(cells: usize) -> Mesh {
        let side = cells + 1;
        let at = |i: usize| i as f64 / cells as f64;
        let nodes = (0..side * side)
            .map(|n| [at(n % side), at(n / side)])
            .collect();
        let mut triangles = Vec::new();
        for row in 0..cells {
            for column in 0..cells {
                let corner = (row * side + column) as u32;
                let above = corner + side as u32;
                triangles.push([corner, corner + 1, above + 1]);
                triangles.push([corner, above + 1, above]);
            }
        }
        Mesh { nodes, triangles }
    }

    /// The nodes.
    pub fn nodes(&self) -> &[[f64; 2]] {
        &self.nodes
    }

    /// The triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
