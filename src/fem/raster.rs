//! P1 functions sampled on a grid of columns and rows: what a picture on a screen needs.
//!
//! Where each sample lies in the triangulation is found once, for a mesh and a grid; to sample a
//! function is then to gather three nodal values for each sample. The triangles are laid over the
//! grid one after the other, so that the grid is its own search structure and the work is
//! proportional to triangles plus samples, whatever the triangulation.

use super::Mesh;
use crate::geometry::{BoundingBox, Point, Vector};
use crate::scene::Geometry;

/// How far outside a triangle (in barycentric coordinates) a sample may lie and still be taken as
/// inside: far more than rounding, far less than what shows.
const SLACK: f64 = 1e-10;

/// Where a place lies: the nodes of its triangle and its barycentric coordinates there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub(super) nodes: [u32; 3],
    pub(super) weights: [f64; 3],
}

/// A grid of samples laid over a mesh: sample (column, row) is the centre of its part of the
/// rectangle, row 0 at the *top* (greatest y), as screens count.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    columns: usize,
    rows: usize,
    nodes: usize,
    places: Vec<Option<Place>>,
    /// For each column: −1 on the other side of an axis of rotation, where fields are mirrored, and 1 elsewhere.
    sides: Vec<f64>,
}

impl Raster {
    /// Finds the triangle of each sample. A sample on an edge or a vertex belongs to the first of
    /// the triangles that meet there, a sample outside of all triangles to none. By rotation there is a mirror image of the
    /// mesh on the other side of the axis.
    pub fn new(mesh: &Mesh, region: BoundingBox, columns: usize, rows: usize) -> Self {
        let mut raster = Self {
            columns,
            rows,
            nodes: mesh.nodes().len(),
            places: vec![None; columns * rows],
            sides: vec![1.0; columns],
        };
        raster.lay(mesh, region, 1.0);
        if mesh.geometry() == Geometry::Axisymmetric {
            let across = region.extent().x / columns.max(1) as f64;
            for (column, side) in raster.sides.iter_mut().enumerate() {
                if region.lower.x + (column as f64 + 0.5) * across < 0.0 {
                    *side = -1.0;
                }
            }
            raster.lay(mesh, region, -1.0);
        }
        raster
    }

    /// Lays the triangles over the samples, with x times `side`.
    fn lay(&mut self, mesh: &Mesh, region: BoundingBox, side: f64) {
        let Self {
            columns,
            rows,
            places,
            ..
        } = self;
        let (columns, rows) = (*columns, *rows);
        let BoundingBox { lower, upper } = region;
        let across = (upper.x - lower.x) / columns.max(1) as f64;
        let down = (upper.y - lower.y) / rows.max(1) as f64;
        for (triangle, gradients) in mesh.triangles().iter().zip(mesh.gradients()) {
            let corners = triangle.map(|node| mesh.nodes()[node as usize]);
            // The samples whose centres lie between the corners, as (first, one past the last).
            let span = |axis: usize, start: f64, step: f64, count: usize| {
                let sign = if axis == 0 { side } else { 1.0 };
                let offsets = corners.map(|corner| (sign * corner[axis] - start) / step - 0.5);
                let least = offsets.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = offsets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                // One sample's breadth of 1e-6 more: the slack is for rounding at the sides.
                let first = (least - 1e-6).ceil().max(0.0) as usize;
                let end = (greatest + 1e-6).floor() + 1.0;
                (first, (end.max(0.0) as usize).min(count))
            };
            let (left, right) = span(0, lower.x, across, columns);
            let (top, bottom) = span(1, upper.y, -down, rows);
            for row in top..bottom {
                let y = upper.y - (row as f64 + 0.5) * down;
                for column in left..right {
                    let place = &mut places[row * columns + column];
                    if place.is_some() {
                        continue;
                    }
                    let x = lower.x + (column as f64 + 0.5) * across;
                    let at = Point::new(side * x, y);
                    let weights = [0, 1, 2].map(|corner| {
                        let (gradient, offset) = (gradients[corner], at - corners[corner]);
                        1.0 + gradient.x * offset.x + gradient.y * offset.y
                    });
                    if weights.iter().all(|weight| *weight >= -SLACK) {
                        *place = Some(Place {
                            nodes: *triangle,
                            weights,
                        });
                    }
                }
            }
        }
    }

    /// Samples side by side.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Samples one below the other.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The value of a P1 function at a sample; `None` outside the mesh, outside the grid, and where
    /// the values are not those of this mesh's nodes.
    pub fn at(&self, nodal: &[f64], column: usize, row: usize) -> Option<f64> {
        if nodal.len() != self.nodes || column >= self.columns {
            return None;
        }
        self.places
            .get(row * self.columns + column)?
            .map(|place| place.value(nodal))
    }

    /// The same for the component along x of a vector field, whose sign the other side of an axis of rotation turns round.
    pub fn at_across(&self, nodal: &[f64], column: usize, row: usize) -> Option<f64> {
        Some(self.at(nodal, column, row)? * self.sides.get(column)?)
    }

    /// The values of a P1 function at all samples, row after row from the top. Without values for
    /// every node of the mesh there is none at any sample.
    pub fn gather(&self, nodal: &[f64], samples: &mut Vec<Option<f64>>) {
        samples.clear();
        if nodal.len() == self.nodes {
            let places = self.places.iter();
            samples.extend(places.map(|place| place.map(|place| place.value(nodal))));
        } else {
            samples.resize(self.places.len(), None);
        }
    }
}

impl Place {
    /// The value there of a P1 function.
    pub fn value(&self, nodal: &[f64]) -> f64 {
        let corners = self.nodes.iter().zip(&self.weights);
        corners
            .map(|(&node, weight)| weight * nodal[node as usize])
            .sum()
    }

    /// The value there of the quadratic that goes through a P1 function's values and, in the middle of each edge, through that
    /// of the cubic with these gradients at its ends.
    pub fn quadratic_value(&self, mesh: &Mesh, nodal: &[f64], gradients: &[Vector]) -> f64 {
        let bubble = |[a, b]: [usize; 2]| {
            let [from, to] = [a, b].map(|corner| self.nodes[corner] as usize);
            let along = mesh.nodes()[to] - mesh.nodes()[from];
            0.5 * self.weights[a] * self.weights[b] * (gradients[from] - gradients[to]).dot(&along)
        };
        let bubbles = [[0, 1], [1, 2], [2, 0]].map(bubble);
        self.value(nodal) + bubbles.iter().sum::<f64>()
    }

    /// The largest value at the corners of its triangle.
    pub fn greatest(&self, nodal: &[f64]) -> f64 {
        let values = self.nodes.iter().map(|node| nodal[*node as usize]);
        values.fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: BoundingBox = BoundingBox {
        lower: Point::new(0.0, 0.0),
        upper: Point::new(1.0, 1.0),
    };

    fn nodal(mesh: &Mesh, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        mesh.nodes().iter().map(|at| f(at.x, at.y)).collect()
    }

    #[test]
    fn a_linear_function_is_reproduced_to_rounding() {
        for (cells, jitter) in [(7, 0.0), (40, 0.0), (7, 0.3), (40, 0.3)] {
            let mesh = Mesh::structured(cells, jitter, 5).expect("a fair mesh");
            let function = |x: f64, y: f64| 2.0 * x - 3.0 * y + 0.5;
            let values = nodal(&mesh, function);
            for (columns, rows) in [(1, 1), (13, 9), (64, 64), (101, 50)] {
                let raster = Raster::new(&mesh, UNIT, columns, rows);
                let mut samples = Vec::new();
                raster.gather(&values, &mut samples);
                assert_eq!(samples.len(), columns * rows);
                for (index, sample) in samples.iter().enumerate() {
                    let (column, row) = (index % columns, index / columns);
                    let x = (column as f64 + 0.5) / columns as f64;
                    let y = 1.0 - (row as f64 + 0.5) / rows as f64;
                    let value = sample.expect("every sample of the square is inside");
                    assert!((value - function(x, y)).abs() < 1e-13, "{x} {y}: {value}");
                    assert_eq!(raster.at(&values, column, row), Some(value));
                }
            }
        }
    }

    #[test]
    fn a_sample_on_a_vertex_has_its_value_and_one_on_an_edge_the_mean() {
        // 4 × 4 cells; 2 × 2 samples at the vertices (¼, ¼), …; then 4 × 2 with some on edges.
        let mesh = Mesh::structured(4, 0.0, 0).expect("a regular mesh");
        let values: Vec<f64> = (0..25).map(|node| f64::from(node * node)).collect();
        let raster = Raster::new(&mesh, UNIT, 2, 2);
        // Node j of row i is 5 i + j, rows from below; sample rows from the top.
        assert_eq!(raster.at(&values, 0, 1), Some(36.0));
        assert_eq!(raster.at(&values, 1, 0), Some(18.0 * 18.0));
        let raster = Raster::new(&mesh, UNIT, 4, 2);
        // (1/8, 3/4) lies midway between the nodes 15 and 16.
        assert_eq!(raster.at(&values, 0, 0), Some(0.5 * (225.0 + 256.0)));
        // The diagonal: the centre of the lowest left cell, midway between the nodes 0 and 6.
        let raster = Raster::new(&mesh, UNIT, 4, 4);
        assert_eq!(raster.at(&values, 0, 3), Some(18.0));
    }

    #[test]
    fn what_lies_outside_has_no_value() {
        let mesh = Mesh::structured(6, 0.2, 1).expect("a fair mesh");
        let wide = BoundingBox {
            lower: Point::new(-1.0, 0.0),
            upper: Point::new(2.0, 1.0),
        };
        let raster = Raster::new(&mesh, wide, 30, 10);
        let values = nodal(&mesh, |x, _| x);
        for row in 0..10 {
            for column in 0..30 {
                let inside = (10..20).contains(&column);
                assert_eq!(raster.at(&values, column, row).is_some(), inside);
            }
        }
        assert_eq!(raster.at(&values, 30, 0), None);
        assert_eq!(raster.at(&values, 15, 10), None);
    }

    #[test]
    fn a_domain_that_is_no_rectangle_leaves_its_complement_out() {
        // One triangle: the lower right half of the unit square.
        let nodes = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].map(Point::from);
        let mesh = Mesh::new(nodes.to_vec(), vec![[0, 1, 2]]).expect("counter-clockwise");
        assert_eq!(mesh.bounding_box(), UNIT);
        let raster = Raster::new(&mesh, UNIT, 4, 4);
        for row in 0..4 {
            for column in 0..4 {
                // On the diagonal (column + row = 3) the sample lies on the edge, which belongs to it.
                let inside = column + row >= 3;
                let sample = raster.at(&[1.0, 1.0, 1.0], column, row);
                assert_eq!(sample.is_some(), inside, "{column} {row}");
            }
        }
    }

    #[test]
    fn values_of_another_mesh_are_not_read() {
        let mesh = Mesh::structured(3, 0.0, 0).expect("a regular mesh");
        let raster = Raster::new(&mesh, UNIT, 2, 3);
        let mut samples = vec![Some(1.0)];
        raster.gather(&[1.0; 15], &mut samples);
        assert_eq!(samples, vec![None; 6]);
        assert_eq!(raster.at(&[1.0; 17], 0, 0), None);
    }

    #[test]
    fn a_grid_without_samples_is_no_error() {
        let mesh = Mesh::structured(3, 0.0, 0).expect("a regular mesh");
        for (columns, rows) in [(0, 0), (0, 4), (4, 0)] {
            let raster = Raster::new(&mesh, UNIT, columns, rows);
            assert_eq!((raster.columns(), raster.rows()), (columns, rows));
            assert_eq!(raster.at(&[0.0; 16], 0, 0), None);
        }
    }

    /// The section as a mesh of the plane is what the raster of the half shows.
    #[test]
    fn by_rotation_the_other_side_is_the_mirror_image() {
        let mesh = Mesh::structured(7, 0.3, 5).expect("a fair mesh");
        let mesh = mesh.in_geometry(Geometry::Axisymmetric);
        let values = nodal(&mesh, |x, y| 1.0 + x * x + (5.0 * y).sin());
        let (section, images) = mesh.section();
        assert_eq!((section.nodes().len(), images.len()), (64 + 56, 56));
        assert_eq!(section.bounding_box(), mesh.section_box());
        assert!((section.areas().iter().sum::<f64>() - 2.0).abs() < 1e-13);
        let remade = Mesh::new(section.nodes().to_vec(), section.triangles().to_vec());
        let remade = remade.expect("counter-clockwise");
        for (one, other) in remade.gradients().iter().zip(section.gradients()) {
            let pairs = one.iter().zip(other);
            assert!(
                pairs
                    .map(|(a, b)| (a - b).abs().max())
                    .all(|off| off < 1e-11)
            );
        }
        let mirrored = images.iter().map(|node| values[*node as usize]);
        let all: Vec<f64> = values.iter().copied().chain(mirrored).collect();
        let region = mesh.section_box();
        let [half, whole] = [&mesh, &section].map(|mesh| Raster::new(mesh, region, 26, 11));
        for row in 0..11 {
            for column in 0..26 {
                let value = half.at(&values, column, row).expect("inside");
                let wanted = whole.at(&all, column, row).expect("inside");
                assert!((value - wanted).abs() < 1e-13, "{column} {row}");
                let across = half.at_across(&values, column, row).expect("inside");
                assert_eq!(across, if column < 13 { -value } else { value });
            }
        }
    }
}
