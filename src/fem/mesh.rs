//! Triangulations of Ω: connectivity, areas, gradients of the basis functions, boundary nodes.

use std::borrow::Cow;
use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::FemError;
use super::hilbert::along_curve;
use crate::geometry::{BoundingBox, Point, Vector, doubled_area};
use crate::scene::{Geometry, Triangulation};

/// A triangulation. Nothing in it says how it was made, [`Mesh::grid`] apart.
#[derive(Debug, Clone)]
pub struct Mesh {
    nodes: Vec<Point>,
    triangles: Vec<[u32; 3]>,
    areas: Vec<f64>,
    gradients: Vec<[Vector; 3]>,
    on_boundary: Vec<bool>,
    geometry: Geometry,
    /// 2πr̄ times the area of each triangle, with r̄ the mean of r, by rotation; empty in the plane.
    volumes: Vec<f64>,
    grid: Option<Grid>,
    /// The number that each node has outside; `None`: its own.
    outer: Option<Vec<u32>>,
}

/// That a mesh is the regular one of right triangles on the unit square, row after row from below:
/// node j of row i is number i·(cells + 1) + j.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Squares along a side, 1/h.
    pub cells: usize,
}

impl Mesh {
    /// A mesh of given nodes and triangles (counter-clockwise).
    ///
    /// # Errors
    /// `DegenerateTriangle` where a triangle has no positive area.
    pub fn new(nodes: Vec<Point>, triangles: Vec<[u32; 3]>) -> Result<Self, FemError> {
        let mut areas = Vec::with_capacity(triangles.len());
        let mut gradients = Vec::with_capacity(triangles.len());
        for (triangle, &corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|node| nodes[node as usize]);
            let doubled = doubled_area([a, b, c]);
            if doubled.is_nan() || doubled <= 0.0 {
                return Err(FemError::DegenerateTriangle {
                    triangle,
                    nodes: corners,
                    area: 0.5 * doubled,
                });
            }
            // ∇ψ_a is normal to the opposite edge b → c and has the length 1/height.
            let normal =
                |from: Point, to: Point| Vector::new(from.y - to.y, to.x - from.x) / doubled;
            areas.push(0.5 * doubled);
            gradients.push([normal(b, c), normal(c, a), normal(a, b)]);
        }
        let on_boundary = ends(nodes.len(), boundary_edges(&triangles));
        Ok(Self {
            nodes,
            triangles,
            areas,
            gradients,
            on_boundary,
            geometry: Geometry::Planar,
            volumes: Vec::new(),
            grid: None,
            outer: None,
        })
    }

    /// The same mesh of another geometry. By rotation x is the radius r ≥ 0, and the axis no part of ∂Ω: ∂Ω is where the
    /// body has its surface.
    #[must_use]
    pub fn in_geometry(mut self, geometry: Geometry) -> Self {
        if geometry == self.geometry {
            return self;
        }
        self.geometry = geometry;
        self.volumes.clear();
        if geometry == Geometry::Axisymmetric {
            let triangles = self.triangles.iter().zip(&self.areas);
            self.volumes.extend(triangles.map(|(corners, area)| {
                let radii = corners.map(|node| self.nodes[node as usize].x);
                TAU / 3.0 * (radii[0] + radii[1] + radii[2]) * area
            }));
        }
        self.on_boundary = ends(self.nodes.len(), self.boundary_edges());
        self
    }

    /// The mesh of a file. Inside, nodes and triangles are numbered such that neighbours are close;
    /// values that come from outside or go there are in the file's order, by
    /// [`inward`](Self::inward) and [`outward`](Self::outward).
    ///
    /// # Errors
    /// `DegenerateTriangle`, which the check of the file should prevent.
    pub fn from_triangulation(given: &Triangulation) -> Result<Self, FemError> {
        let order = along_curve(&given.nodes);
        let mut places = vec![0; order.len()];
        for (place, node) in order.iter().enumerate() {
            places[*node as usize] = place as u32;
        }
        let nodes = order.iter().map(|node| given.nodes[*node as usize]);
        let mut triangles: Vec<[u32; 3]> = given
            .triangles
            .iter()
            .map(|corners| corners.map(|node| places[node as usize]))
            .collect();
        // Whatever the order in the file, sums come out the same.
        for corners in &mut triangles {
            let least = (0..3).min_by_key(|corner| corners[*corner]).unwrap_or(0);
            corners.rotate_left(least);
        }
        sort_by_nodes(&mut triangles);
        let mut mesh = Self::new(nodes.collect(), triangles)?;
        mesh.outer = Some(order);
        Ok(mesh)
    }

    /// The structured mesh of the unit square: `cells` squares a side, each cut by the diagonal from
    /// lower left to upper right; interior nodes moved by up to `jitter`·h in x and in y. From a jitter
    /// of a quarter on, triangles may turn round: moves at such a triangle, or one that would be thinner
    /// than a fiftieth of what it was, are halved until it is not. What is left are obtuse triangles and
    /// slivers.
    ///
    /// # Errors
    /// `DegenerateTriangle`, which the limit on the moves should prevent.
    pub fn structured(cells: usize, jitter: f64, seed: u64) -> Result<Self, FemError> {
        let side = cells + 1;
        let h = 1.0 / cells as f64;
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut places = Vec::with_capacity(side * side);
        let mut moves = vec![Vector::zeros(); side * side];
        for i in 0..side {
            for j in 0..side {
                let inside = i > 0 && i < cells && j > 0 && j < cells;
                if inside && jitter > 0.0 {
                    for by in moves[places.len()].iter_mut() {
                        *by = jitter * h * generator.random_range(-1.0..=1.0);
                    }
                }
                places.push(Point::new(j as f64 / cells as f64, i as f64 / cells as f64));
            }
        }
        let mut triangles = Vec::with_capacity(2 * cells * cells);
        for i in 0..cells {
            for j in 0..cells {
                let lower_left = (i * side + j) as u32;
                let lower_right = lower_left + 1;
                let upper_left = lower_left + side as u32;
                let upper_right = upper_left + 1;
                triangles.push([lower_left, lower_right, upper_right]);
                triangles.push([lower_left, upper_right, upper_left]);
            }
        }
        limit_moves(&places, &triangles, &mut moves, THINNEST * 0.5 * h * h);
        let nodes = places.iter().zip(&moves).map(|(place, by)| place + by);
        let mut mesh = Self::new(nodes.collect(), triangles)?;
        mesh.grid = (jitter == 0.0).then_some(Grid { cells });
        Ok(mesh)
    }

    /// A part of the mesh: the given triangles, in the order of their numbers, and their nodes; with
    /// the number of each of its nodes in the whole.
    ///
    /// # Errors
    /// None where the mesh itself could be made.
    pub fn part(&self, triangles: &[u32]) -> Result<(Self, Vec<u32>), FemError> {
        let mut used = vec![false; self.nodes.len()];
        for &triangle in triangles {
            for node in self.triangles[triangle as usize] {
                used[node as usize] = true;
            }
        }
        let mut local = vec![0; self.nodes.len()];
        let mut nodes = Vec::new();
        for (node, _) in used.iter().enumerate().filter(|(_, used)| **used) {
            local[node] = nodes.len() as u32;
            nodes.push(node as u32);
        }
        let corners = triangles
            .iter()
            .map(|&triangle| self.triangles[triangle as usize].map(|node| local[node as usize]));
        let places = nodes.iter().map(|&node| self.nodes[node as usize]);
        let part = Self::new(places.collect(), corners.collect())?;
        Ok((part.in_geometry(self.geometry), nodes))
    }

    /// The number of a node outside: in the file that the mesh is from.
    pub fn outer_number(&self, node: u32) -> u32 {
        self.outer
            .as_ref()
            .map_or(node, |outer| outer[node as usize])
    }

    /// Nodal values in the mesh's own order, from those in the order of the file that it is from.
    pub fn inward(&self, values: Vec<f64>) -> Vec<f64> {
        match &self.outer {
            None => values,
            Some(outer) => outer.iter().map(|node| values[*node as usize]).collect(),
        }
    }

    /// The nodes in the order of the file that the mesh is from.
    pub fn outer_order(&self) -> Vec<usize> {
        let nodes: Vec<usize> = (0..self.nodes.len()).collect();
        self.outward(&nodes).into_owned()
    }

    /// Nodal values in the order of the file that the mesh is from.
    pub fn outward<'a, T: Copy>(&self, values: &'a [T]) -> Cow<'a, [T]> {
        let Some(outer) = &self.outer else {
            return Cow::Borrowed(values);
        };
        let mut moved = values.to_vec();
        for (node, value) in outer.iter().zip(values) {
            moved[*node as usize] = *value;
        }
        Cow::Owned(moved)
    }

    /// The edges of ∂Ω, with the domain on their left: those that belong to one triangle only, by rotation without those on
    /// the axis.
    pub fn boundary_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = boundary_edges(&self.triangles);
        if self.geometry == Geometry::Axisymmetric {
            let least = self.least_radius();
            let is_on_axis = |node: &u32| self.nodes[*node as usize].x <= least;
            edges.retain(|ends| !ends.iter().all(is_on_axis));
        }
        edges
    }

    /// What Ω stands for.
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Whether each node lies on the axis of rotation; in the plane none does.
    pub fn on_axis(&self) -> impl Iterator<Item = bool> {
        let is_rotated = self.geometry == Geometry::Axisymmetric;
        let least = self.least_radius();
        self.nodes
            .iter()
            .map(move |node| is_rotated && node.x <= least)
    }

    /// Up to which r a place lies on the axis: rounding.
    pub(super) fn least_radius(&self) -> f64 {
        let largest = self.nodes.iter().map(|node| node.x).fold(0.0, f64::max);
        1e-12 * largest
    }

    /// ∫ 1 over each triangle: its area in the plane, and by rotation the volume 2πr̄|T| of its body.
    pub fn measures(&self) -> &[f64] {
        match self.geometry {
            Geometry::Planar => &self.areas,
            Geometry::Axisymmetric => &self.volumes,
        }
    }

    /// Where the nodes are.
    pub fn nodes(&self) -> &[Point] {
        &self.nodes
    }

    /// The smallest box that holds the nodes; from 0 to 1 where it would have no extent.
    pub fn bounding_box(&self) -> BoundingBox {
        let mut hull = BoundingBox::around(&self.nodes);
        for axis in 0..2 {
            if hull.lower[axis] >= hull.upper[axis] {
                (hull.lower[axis], hull.upper[axis]) = (0.0, 1.0);
            }
        }
        hull
    }

    /// The smallest box that holds the cross-section of what the mesh stands for: by rotation both sides of the axis.
    pub fn section_box(&self) -> BoundingBox {
        let mut hull = self.bounding_box();
        if self.geometry == Geometry::Axisymmetric {
            hull.lower.x = -hull.upper.x;
        }
        hull
    }

    /// The full cross-section of what the mesh stands for, as a mesh of the plane: by rotation with the other side of the axis,
    /// whose nodes follow those of the mesh; and for each of them, of which node it is the mirror image.
    pub fn section(&self) -> (Self, Vec<u32>) {
        let mut section = Self {
            geometry: Geometry::Planar,
            volumes: Vec::new(),
            grid: None,
            outer: None,
            ..self.clone()
        };
        let mut images = Vec::new();
        if self.geometry == Geometry::Planar {
            return (section, images);
        }
        let mut numbers: Vec<u32> = (0..self.nodes.len() as u32).collect();
        for (node, on_axis) in self.on_axis().enumerate() {
            if !on_axis {
                numbers[node] = section.nodes.len() as u32;
                images.push(node as u32);
                let place = self.nodes[node];
                section.nodes.push(Point::new(-place.x, place.y));
                section.on_boundary.push(self.on_boundary[node]);
            }
        }
        // Turned round, so that the corners are counter-clockwise again.
        let triangles = self.triangles.iter();
        let triangles = triangles.map(|[a, b, c]| [a, c, b].map(|it| numbers[*it as usize]));
        section.triangles.extend(triangles);
        section.areas.extend(&self.areas);
        let gradients = self.gradients.iter();
        let mirrored = |slope: &Vector| Vector::new(-slope.x, slope.y);
        let gradients = gradients.map(|[a, b, c]| [a, c, b].map(mirrored));
        section.gradients.extend(gradients);
        (section, images)
    }

    /// The three nodes of each triangle, counter-clockwise.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The area of each triangle.
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The gradients of the three basis functions on each triangle.
    pub fn gradients(&self) -> &[[Vector; 3]] {
        &self.gradients
    }

    /// Whether each node lies on ∂Ω.
    pub fn on_boundary(&self) -> &[bool] {
        &self.on_boundary
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let outer = self.outer.as_ref().map_or(0, Vec::len);
        size_of_val(&*self.nodes)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.areas)
            + size_of_val(&*self.gradients)
            + size_of_val(&*self.on_boundary)
            + size_of_val(&*self.volumes)
            + outer * size_of::<u32>()
    }

    /// The grid that the mesh is, if it is one.
    pub fn grid(&self) -> Option<Grid> {
        self.grid
    }
}

/// The least area of a triangle whose nodes were moved, over the area that it had.
const THINNEST: f64 = 0.02;

/// Halves the moves at triangles with less than this area, until there are none.
fn limit_moves(places: &[Point], triangles: &[[u32; 3]], moves: &mut [Vector], least_area: f64) {
    let mut too_far = vec![false; moves.len()];
    // Each round halves a move that is too far; after some ten of them hardly anything is left of it.
    for _ in 0..64 {
        let moved = |node: u32| places[node as usize] + moves[node as usize];
        let thin = |corners: &&[u32; 3]| 0.5 * doubled_area(corners.map(moved)) < least_area;
        for corners in triangles.iter().filter(thin) {
            for node in corners {
                too_far[*node as usize] = true;
            }
        }
        if !too_far.contains(&true) {
            return;
        }
        for (by, far) in moves.iter_mut().zip(&mut too_far) {
            if std::mem::take(far) {
                *by *= 0.5;
            }
        }
    }
}

/// Sorts triangles by their nodes, the least first, so that those that follow each other share some.
pub(super) fn sort_by_nodes(triangles: &mut [[u32; 3]]) {
    triangles.sort_unstable_by_key(|corners| {
        let mut sorted = *corners;
        sorted.sort_unstable();
        sorted
    });
}

/// The edges that belong to one triangle only.
fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<(u32, u32, bool)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(from, to)| (from.min(to), from.max(to), from > to))
        .collect();
    edges.sort_unstable();
    let alone = edges
        .chunk_by(|one, other| (one.0, one.1) == (other.0, other.1))
        .filter(|same| same.len() == 1);
    alone
        .map(|edge| match edge[0] {
            (a, b, false) => [a, b],
            (a, b, true) => [b, a],
        })
        .collect()
}

/// Marks the ends of edges.
fn ends(count: usize, edges: Vec<[u32; 2]>) -> Vec<bool> {
    let mut is_end = vec![false; count];
    for node in edges.into_iter().flatten() {
        is_end[node as usize] = true;
    }
    is_end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_structured_mesh_covers_the_square_once() {
        for jitter in [0.0, 0.2] {
            let mesh = Mesh::structured(6, jitter, 3).expect("a fair mesh");
            assert_eq!((mesh.nodes().len(), mesh.triangles().len()), (49, 72));
            assert!((mesh.areas().iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert_eq!(mesh.on_boundary().iter().filter(|on| **on).count(), 24);
            assert_eq!(mesh.grid().is_some(), jitter == 0.0);
        }
        let mesh = Mesh::structured(4, 0.0, 0).expect("a regular mesh");
        assert_eq!(mesh.triangles()[..2], [[0, 1, 6], [0, 6, 5]]);
    }

    /// Obtuse triangles and slivers, but none that is turned round.
    #[test]
    fn any_jitter_gives_a_mesh() {
        for seed in 0..20 {
            let mesh = Mesh::structured(12, 0.89, seed).expect("moves are limited");
            let whole = 0.5 / 144.0;
            let areas = mesh.areas();
            assert!(areas.iter().all(|area| *area >= 0.99 * THINNEST * whole));
            assert!(areas.iter().any(|area| *area < 0.2 * whole));
            assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn gradients_reproduce_a_linear_function() {
        let mesh = Mesh::structured(5, 0.3, 1).expect("a fair mesh");
        for (triangle, gradients) in mesh.triangles().iter().zip(mesh.gradients()) {
            let mut gradient = Vector::zeros();
            for (&node, g) in triangle.iter().zip(gradients) {
                let at = mesh.nodes()[node as usize];
                gradient += (2.0 * at.x - 3.0 * at.y + 1.0) * g;
            }
            assert!((gradient - Vector::new(2.0, -3.0)).abs().max() < 1e-12);
        }
    }

    #[test]
    fn a_triangle_turned_round_is_refused() {
        let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Point::from);
        let error = Mesh::new(nodes.to_vec(), vec![[0, 2, 1]]).expect_err("clockwise");
        assert!(
            matches!(error, FemError::DegenerateTriangle { triangle: 0, area, .. } if area < 0.0)
        );
    }
}
