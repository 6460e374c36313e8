//! A triangulation whose nodes move a little: edges are flipped until it is Delaunay again (Lawson), in a tenth of the time
//! that it takes to make it anew.

use crate::geometry::{Point, doubled_area};

/// No triangle beyond an edge.
const NONE: u32 = u32::MAX;

/// An edge is flipped if the sine of the sum of the two angles opposite to it is less than minus this: circles through four
/// nodes, to rounding, are left as they are.
const TIE: f64 = 1e-12;

/// Flips a triangle, at most: more means that rounding turns in circles.
const MOST_FLIPS: usize = 64;

/// Triangles, counter-clockwise, and their neighbours.
#[derive(Debug)]
pub(super) struct MovingTriangulation {
    triangles: Vec<[u32; 3]>,
    /// The triangle beyond the edge opposite to each corner.
    neighbours: Vec<[u32; 3]>,
    /// Triangles whose edges are to be looked at: all of them, or only those to triangles of larger numbers.
    pending: Vec<(u32, bool)>,
}

impl MovingTriangulation {
    /// Of these triangles.
    pub(super) fn new(triangles: Vec<[u32; 3]>) -> Self {
        let mut neighbours = vec![[NONE; 3]; triangles.len()];
        let mut edges: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
        for (triangle, corners) in triangles.iter().enumerate() {
            for corner in 0..3 {
                let [a, b] = [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
                edges.push(([a.min(b), a.max(b)], triangle as u32, corner));
            }
        }
        edges.sort_unstable();
        for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let [(_, one, at_one), (_, other, at_other)] = [pair[0], pair[1]];
            neighbours[one as usize][at_one] = other;
            neighbours[other as usize][at_other] = one;
        }
        Self {
            triangles,
            neighbours,
            pending: Vec::new(),
        }
    }

    /// The triangles.
    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Makes it Delaunay for the nodes as they are. `false` where a triangle has turned round: it must be made anew.
    pub(super) fn restore(&mut self, nodes: &[Point]) -> bool {
        let place = |node: u32| nodes[node as usize];
        if !(self.triangles.iter()).all(|corners| doubled_area(corners.map(place)) > 0.0) {
            return false;
        }
        self.pending.clear();
        let all = (0..self.triangles.len() as u32).rev();
        self.pending.extend(all.map(|triangle| (triangle, false)));
        let mut flips = MOST_FLIPS * self.triangles.len();
        while let Some((triangle, is_whole)) = self.pending.pop() {
            for corner in 0..3 {
                let is_due = is_whole || self.neighbours[triangle as usize][corner] > triangle;
                if is_due && self.flips(nodes, triangle as usize, corner) {
                    let beyond = self.flip(triangle as usize, corner);
                    self.pending
                        .extend([(beyond as u32, true), (triangle, true)]);
                    flips -= 1;
                    break;
                }
            }
            if flips == 0 {
                return false;
            }
        }
        true
    }

    /// The number of a corner's triangle among the neighbours of the one beyond the opposite edge.
    fn corner_beyond(&self, triangle: usize, beyond: usize) -> usize {
        let own = triangle as u32;
        (0..3)
            .find(|it| self.neighbours[beyond][*it] == own)
            .unwrap_or(0)
    }

    /// Whether the edge opposite to a corner is to be flipped.
    fn flips(&self, nodes: &[Point], triangle: usize, corner: usize) -> bool {
        let beyond = self.neighbours[triangle][corner];
        if beyond == NONE {
            return false;
        }
        let across = self.corner_beyond(triangle, beyond as usize);
        let turned = |triangle: usize, corner: usize| {
            [0, 1, 2].map(|turn| nodes[self.triangles[triangle][(corner + turn) % 3] as usize])
        };
        let [p, q, r] = turned(triangle, corner);
        let [s, _, _] = turned(beyond as usize, across);
        // Cosines and sines of the angles at p and s, times the lengths of their sides.
        let at_p = [(q - p).dot(&(r - p)), (q - p).perp(&(r - p))];
        let at_s = [(r - s).dot(&(q - s)), (r - s).perp(&(q - s))];
        let sine = at_p[0] * at_s[1] + at_p[1] * at_s[0];
        let size = (at_p[0].abs() + at_p[1]) * (at_s[0].abs() + at_s[1]);
        sine < -TIE * size && doubled_area([p, q, s]) > 0.0 && doubled_area([p, s, r]) > 0.0
    }

    /// Flips the edge opposite to a corner; returns the other triangle.
    fn flip(&mut self, triangle: usize, corner: usize) -> usize {
        let beyond = self.neighbours[triangle][corner] as usize;
        let across = self.corner_beyond(triangle, beyond);
        let turned = |of: [u32; 3], corner: usize| [0, 1, 2].map(|turn| of[(corner + turn) % 3]);
        // (p, q, r) and (s, r, q) become (p, q, s) and (s, r, p).
        let [p, q, r] = turned(self.triangles[triangle], corner);
        let [s, _, _] = turned(self.triangles[beyond], across);
        let [_, beside_q, beside_r] = turned(self.neighbours[triangle], corner);
        let [_, over_r, over_q] = turned(self.neighbours[beyond], across);
        let [one, other] = [triangle as u32, beyond as u32];
        self.triangles[triangle] = [p, q, s];
        self.triangles[beyond] = [s, r, p];
        self.neighbours[triangle] = [over_r, other, beside_r];
        self.neighbours[beyond] = [beside_q, one, over_q];
        for (neighbour, from, to) in [(over_r, other, one), (beside_q, one, other)] {
            if neighbour != NONE {
                let known = &mut self.neighbours[neighbour as usize];
                known
                    .iter_mut()
                    .filter(|it| **it == from)
                    .for_each(|it| *it = to);
            }
        }
        beyond
    }
}

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// Against the definition: no node within the circle through a triangle's corners.
    #[test]
    fn flipped_edges_make_it_delaunay() {
        for seed in 0..8 {
            let mesh = Mesh::structured(12, 0.0, 0).expect("a regular mesh");
            let mut triangulation = MovingTriangulation::new(mesh.triangles().to_vec());
            let mut nodes = mesh.nodes().to_vec();
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            for _ in 0..3 {
                for (node, on_wall) in nodes.iter_mut().zip(mesh.on_boundary()) {
                    if !on_wall {
                        node.iter_mut()
                            .for_each(|x| *x += generator.random_range(-0.012..0.012));
                    }
                }
                assert!(triangulation.restore(&nodes));
            }
            let areas = triangulation.triangles.iter();
            let areas = areas.map(|corners| doubled_area(corners.map(|it| nodes[it as usize])));
            let sum: f64 = areas.inspect(|area| assert!(*area > 0.0)).sum();
            assert!((sum - 2.0).abs() < 1e-12);
            for corners in triangulation.triangles() {
                let [a, b, c] = corners.map(|it| nodes[it as usize]);
                for node in &nodes {
                    let row = |of: Point| {
                        let offset = of - node;
                        [offset.x, offset.y, offset.norm_squared()]
                    };
                    let [a, b, c] = [a, b, c].map(row);
                    let inside = nalgebra::Matrix3::from([a, b, c]).determinant();
                    assert!(inside < 1e-9, "{seed}: {inside:.1e}");
                }
            }
        }
    }

    #[test]
    fn a_triangle_turned_round_is_noticed() {
        let mesh = Mesh::structured(4, 0.0, 0).expect("a regular mesh");
        let mut triangulation = MovingTriangulation::new(mesh.triangles().to_vec());
        let mut nodes = mesh.nodes().to_vec();
        assert!(triangulation.restore(&nodes));
        nodes[12].x += 0.4;
        assert!(!triangulation.restore(&nodes));
    }
}
