//! How far two solutions are apart, on whatever meshes of whatever domain they are.
//!
//! Errors are integrals over the common domain, which is where both meshes are: meshes of the same
//! domain with a curved wall differ a little there. Both solutions are sampled at the midpoints of the
//! same fine grid over the rectangle around the common domain, where P1 functions are exact; the sum
//! over the samples that lie in both meshes, times the area of a cell of the grid, stands for the
//! integral (the midpoint rule: an error of second order in the grid's width, 1/512 of the rectangle,
//! and of first order in it for the area at a wall across the grid, in a number that is wanted to two
//! digits).

use super::error_size::ErrorSize;
use crate::fem::{Contour, Mesh, Raster};
use crate::geometry::{BoundingBox, Point, Segment, length, segment_offset};
use crate::physics::potentials;
use crate::scheme::State;
use crate::simulation::Simulation;
use serde::Serialize;
use std::sync::Arc;

/// Samples along each side.
const SAMPLES: usize = 512;

/// They are laid over the two meshes in so many bands, one after the other: where one of them lies takes 48 bytes,
/// and all at once would take more than most runs.
const BANDS: usize = 32;

/// The state of a run at T.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    mesh: Arc<Mesh>,
    phase: Vec<f64>,
    director: Option<[Vec<f64>; 2]>,
    membrane: Vec<Segment>,
    energy: f64,
    surface_area: f64,
}

/// How far a solution is from another one. What cannot be measured, and what does not differ at all, is
/// left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// ‖φ − φ*‖ in L2.
    pub phase: Option<ErrorSize>,
    /// The mean distance of the membrane φ = 0 from the other one, along the one or the other,
    /// whichever is larger; none without a membrane.
    pub membrane: Option<ErrorSize>,
    /// (∫ I(φ*)|d − d*|²)^½; none without a director.
    pub director: Option<ErrorSize>,
    /// |E_tot − E_tot*|/|E_tot*|.
    pub energy: Option<ErrorSize>,
    /// |B − B*|/B*.
    pub surface_area: Option<ErrorSize>,
}

impl Solution {
    pub(super) fn of(simulation: &Simulation) -> Self {
        let report = simulation.report();
        Self::new(
            Arc::clone(simulation.mesh()),
            simulation.state(),
            report.total_energy,
            report.surface_area,
        )
    }

    pub(super) fn new(mesh: Arc<Mesh>, state: &State, energy: f64, surface_area: f64) -> Self {
        Self {
            phase: state.phi.clone(),
            director: state.director.clone(),
            membrane: Contour::new(&mesh, &state.phi).segments,
            mesh,
            energy,
            surface_area,
        }
    }

    /// Whether every value of φ is a number.
    pub(super) fn is_finite(&self) -> bool {
        self.phase.iter().all(|value| value.is_finite())
    }

    /// How far it is from the reference.
    pub(super) fn errors(&self, reference: &Self) -> Errors {
        let relative = |value: f64, reference: f64| {
            ErrorSize::new((value - reference).abs() / reference.abs())
        };
        let [phase, director] = self.square_differences(reference);
        let root = |square: Option<f64>| ErrorSize::new(square?.sqrt());
        Errors {
            phase: root(phase),
            membrane: membrane_distance(&self.membrane, &reference.membrane),
            director: root(director),
            energy: relative(self.energy, reference.energy),
            surface_area: relative(self.surface_area, reference.surface_area),
        }
    }

    /// ‖φ − φ*‖ in L2.
    pub(super) fn phase_error(&self, reference: &Self) -> Option<ErrorSize> {
        let [phase, _] = self.square_differences(reference);
        ErrorSize::new(phase?.sqrt())
    }

    /// ∫|φ − φ*|² and ∫ I(φ*)|d − d*|² over the common domain: `None` where there is none, and of a director
    /// that one of the two has not.
    fn square_differences(&self, reference: &Self) -> [Option<f64>; 2] {
        let meshes = [&*self.mesh, &*reference.mesh];
        let [a, b] = meshes.map(Mesh::bounding_box);
        let region = BoundingBox {
            lower: a.lower.sup(&b.lower),
            upper: a.upper.inf(&b.upper),
        };
        let size = region.extent();
        if size.min() <= 0.0 {
            return [None; 2];
        }
        let directors = self.director.as_ref().zip(reference.director.as_ref());
        let (mut phase, mut director, mut is_empty) = (0.0, 0.0, true);
        for band in 0..BANDS {
            let y = [band, band + 1].map(|n| region.lower.y + size.y * n as f64 / BANDS as f64);
            let band = BoundingBox {
                lower: Point::new(region.lower.x, y[0]),
                upper: Point::new(region.upper.x, y[1]),
            };
            let rasters = meshes.map(|mesh| Raster::new(mesh, band, SAMPLES, SAMPLES / BANDS));
            for row in 0..SAMPLES / BANDS {
                for column in 0..SAMPLES {
                    let at = |[one, other]: [&[f64]; 2]| {
                        let one = rasters[0].at(one, column, row)?;
                        Some([one, rasters[1].at(other, column, row)?])
                    };
                    let Some([one, other]) = at([&self.phase, &reference.phase]) else {
                        continue;
                    };
                    is_empty = false;
                    phase += (one - other) * (one - other);
                    let Some((own, others)) = directors else {
                        continue;
                    };
                    for (own, others) in own.iter().zip(others) {
                        if let Some([a, b]) = at([own, others]) {
                            director += potentials::phase_indicator(other) * (a - b) * (a - b);
                        }
                    }
                }
            }
        }
        let cell = size.x * size.y / (SAMPLES * SAMPLES) as f64;
        [
            (!is_empty).then_some(cell * phase),
            directors.filter(|_| !is_empty).map(|_| cell * director),
        ]
    }
}

/// The larger of the two mean distances; none if either is empty.
fn membrane_distance(one: &[Segment], other: &[Segment]) -> Option<ErrorSize> {
    if one.is_empty() || other.is_empty() {
        return None;
    }
    ErrorSize::new(mean_distance(one, other).max(mean_distance(other, one)))
}

/// The mean distance of the points of a curve to another curve, by the middles of its segments.
fn mean_distance(from: &[Segment], to: &[Segment]) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for [a, b] in from {
        let middle = nalgebra::center(a, b);
        let weight = length(b - a);
        let nearest = to
            .iter()
            .map(|segment| segment_offset(middle, *segment).norm_squared())
            .fold(f64::INFINITY, f64::min);
        sum += weight * nearest.sqrt();
        total += weight;
    }
    sum / total.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    /// φ = tanh((r − |x − c|)/0.1) on a mesh.
    fn circle(cells: usize, radius: f64) -> Solution {
        let mesh = Mesh::structured(cells, 0.0, 1).expect("a mesh");
        let center = Point::new(0.5, 0.5);
        let distance = |at: Point| radius - length(at - center);
        solution(mesh, |place| (distance(place) / 0.1).tanh())
    }

    fn solution(mesh: Mesh, phase: impl Fn(Point) -> f64) -> Solution {
        let nodes = mesh.nodes().iter();
        let state = State {
            phi: nodes.map(|node| phase(*node)).collect(),
            omega: Vec::new(),
            mu: Vec::new(),
            director: None,
        };
        Solution::new(Arc::new(mesh), &state, 2.0, 4.0)
    }

    #[test]
    fn a_moved_membrane_is_as_far_as_it_was_moved() {
        let (one, other) = (circle(64, 0.25), circle(64, 0.26));
        let errors = one.errors(&other);
        let membrane = errors.membrane.expect("a membrane").get();
        assert!((membrane - 0.01).abs() < 2e-4, "{membrane}");
        // ‖φ − φ*‖² ≈ 0.01² ∫ sech⁴(s/0.1)/0.1² over the ring of length 2π·0.255: 4/3·0.1/0.1².
        let expected = 0.01 * (std::f64::consts::TAU * 0.255 * 4.0 / 3.0 / 0.1).sqrt();
        let phase = errors.phase.expect("an error").get();
        assert!((phase / expected - 1.0).abs() < 0.02, "{phase} {expected}");
        assert_eq!(
            (errors.energy, errors.surface_area, errors.director),
            (None, None, None)
        );
    }

    #[test]
    fn the_error_of_interpolation_falls_as_the_square_of_the_width() {
        let fine = circle(128, 0.25);
        let [coarse, halved] = [16, 32].map(|cells| {
            let phase = circle(cells, 0.25).errors(&fine).phase;
            phase.expect("an error").get()
        });
        let order = (coarse / halved).log2();
        assert!((1.7..2.3).contains(&order), "{order}");
    }

    /// Squares of width `h`, each of two triangles, wherever `is_there` has it at the square's middle.
    fn squares(h: f64, across: usize, up: usize, is_there: impl Fn(Point) -> bool) -> Mesh {
        let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
        let mut numbers = std::collections::HashMap::new();
        for (column, row) in (0..up).flat_map(|row| (0..across).map(move |column| (column, row))) {
            if !is_there([column, row].map(|cell| h * (cell as f64 + 0.5)).into()) {
                continue;
            }
            let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[right, above]| {
                let corner = [column + right, row + above];
                *numbers.entry(corner).or_insert_with(|| {
                    nodes.push(corner.map(|cells| h * cells as f64).into());
                    nodes.len() as u32 - 1
                })
            });
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        Mesh::new(nodes, triangles).expect("counter-clockwise")
    }

    /// The polygon of `sides` corners between two radii about the origin; without an inner one a disc.
    fn ring(inner: f64, outer: f64, sides: usize, layers: usize) -> Mesh {
        let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
        for layer in 0..=layers {
            let radius = inner + (outer - inner) * layer as f64 / layers as f64;
            nodes.extend((0..sides).map(|side| {
                let angle = std::f64::consts::TAU * side as f64 / sides as f64;
                Point::new(radius * angle.cos(), radius * angle.sin())
            }));
        }
        let number = |layer: usize, side: usize| (layer * sides + side % sides) as u32;
        for (layer, side) in (0..layers).flat_map(|layer| (0..sides).map(move |side| (layer, side)))
        {
            let [a, b] = [number(layer, side), number(layer + 1, side)];
            let [c, d] = [number(layer + 1, side + 1), number(layer, side + 1)];
            triangles.push([a, b, c]);
            // The innermost points of a disc are one.
            if inner > 0.0 || layer > 0 {
                triangles.push([a, c, d]);
            }
        }
        Mesh::new(nodes, triangles).expect("counter-clockwise")
    }

    /// Functions that differ by a constant: their distance is that times the root of the area.
    #[test]
    fn errors_are_integrals_over_the_domain_whatever_its_shape() {
        let domains: [(&str, &dyn Fn(usize) -> Mesh); 5] = [
            ("an L", &|n| {
                let h = 1.0 / n as f64;
                squares(h, 2 * n, 2 * n, |at| at.x < 1.0 || at.y < 1.0)
            }),
            ("a channel", &|n| {
                squares(0.1 / n as f64, 100 * n, n, |_| true)
            }),
            ("a ring", &|n| ring(0.4, 1.0, 64, n)),
            ("a disc", &|n| ring(0.0, 2.0, 64, n)),
            ("a tiny square", &|n| {
                squares(1e-5 / n as f64, n, n, |_| true)
            }),
        ];
        for (name, mesh) in domains {
            let area: f64 = mesh(4).areas().iter().sum();
            let line = |at: Point| 2.0 * at.x - at.y;
            let shifted = |place| line(place) + 0.1;
            let errors = solution(mesh(4), shifted).errors(&solution(mesh(6), line));
            let (error, expected) = (errors.phase.expect(name).get(), 0.1 * area.sqrt());
            let ratio = error / expected;
            assert!((ratio - 1.0).abs() < 5e-3, "{name}: {error} {expected}");
        }
    }

    /// A disc is a polygon, and a finer mesh has another one: what one of them leaves out counts not.
    #[test]
    fn errors_are_measured_where_both_meshes_are() {
        let [coarse, fine] = [8, 64].map(|sides| ring(0.0, 1.0, sides, 3));
        let area: f64 = coarse.areas().iter().sum();
        let errors = solution(coarse, |_| 0.3).errors(&solution(fine, |_| 0.1));
        let error = errors.phase.expect("an error").get();
        assert!((error / (0.2 * area.sqrt()) - 1.0).abs() < 5e-3, "{error}");
        let elsewhere = squares(1.0, 2, 1, |at| at.x > 1.0);
        let apart = squares(1.0, 1, 1, |_| true);
        let errors = solution(elsewhere, |_| 0.3).errors(&solution(apart, |_| 0.1));
        assert_eq!(errors.phase, None);
    }
}
