//! How far two solutions are apart, on whatever meshes they are.
//!
//! Both are sampled at the midpoints of the same fine grid, where P1 functions are exact, and sums
//! over the samples stand for integrals (the midpoint rule: an error of second order in the grid's
//! width, 1/512 of the domain, in a number that is wanted to two digits).

use crate::fem::{Contour, Mesh, Raster, Rectangle};
use crate::physics::potentials;
use crate::scheme::State;
use crate::simulation::Simulation;
use serde::Serialize;

/// Samples along each side.
const SAMPLES: usize = 512;

/// The state of a run at T, sampled.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    phase: Vec<f64>,
    director: Option<[Vec<f64>; 2]>,
    membrane: Vec<[[f64; 2]; 2]>,
    energy: f64,
    surface_area: f64,
}

/// How far a solution is from another one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// ‖φ − φ*‖ in L2.
    pub phase: f64,
    /// The mean distance of the membrane φ = 0 from the other one, along the one or the other,
    /// whichever is larger; none without a membrane.
    pub membrane: Option<f64>,
    /// (∫ I(φ*)|d − d*|²)^½; none without a director.
    pub director: Option<f64>,
    /// |E_tot − E_tot*|/|E_tot*|.
    pub energy: f64,
    /// |B − B*|/B*.
    pub surface_area: f64,
}

impl Solution {
    pub(super) fn of(simulation: &Simulation) -> Self {
        let report = simulation.report();
        Self::new(
            simulation.mesh(),
            simulation.state(),
            report.total_energy,
            report.surface_area,
        )
    }

    pub(super) fn new(mesh: &Mesh, state: &State, energy: f64, surface_area: f64) -> Self {
        let raster = Raster::new(mesh, Rectangle::around(mesh), SAMPLES, SAMPLES);
        let sampled = |nodal: &[f64]| {
            let places = (0..SAMPLES).flat_map(|row| (0..SAMPLES).map(move |column| (column, row)));
            places
                .map(|(column, row)| raster.at(nodal, column, row).unwrap_or(f64::NAN))
                .collect::<Vec<f64>>()
        };
        Self {
            phase: sampled(&state.phi),
            director: state
                .director
                .as_ref()
                .map(|director| [sampled(&director[0]), sampled(&director[1])]),
            membrane: Contour::new(mesh, &state.phi).segments,
            energy,
            surface_area,
        }
    }

    /// How far it is from the reference.
    pub(super) fn errors(&self, reference: &Self) -> Errors {
        let relative = |value: f64, reference: f64| {
            (value - reference).abs() / reference.abs().max(f64::MIN_POSITIVE)
        };
        let one = |_: usize| 1.0;
        let inside = |sample: usize| potentials::inside(reference.phase[sample]);
        let director = self.director.as_ref().zip(reference.director.as_ref());
        Errors {
            phase: mean_square(&self.phase, &reference.phase, one).sqrt(),
            membrane: membrane_distance(&self.membrane, &reference.membrane),
            director: director.map(|([x, y], [other_x, other_y])| {
                (mean_square(x, other_x, inside) + mean_square(y, other_y, inside)).sqrt()
            }),
            energy: relative(self.energy, reference.energy),
            surface_area: relative(self.surface_area, reference.surface_area),
        }
    }
}

fn mean_square(one: &[f64], other: &[f64], weight: impl Fn(usize) -> f64) -> f64 {
    let squares = one.iter().zip(other).enumerate();
    let sum: f64 = squares
        .map(|(sample, (a, b))| weight(sample) * (a - b) * (a - b))
        .sum();
    sum / one.len().max(1) as f64
}

/// The larger of the two mean distances; none if either is empty.
fn membrane_distance(one: &[[[f64; 2]; 2]], other: &[[[f64; 2]; 2]]) -> Option<f64> {
    if one.is_empty() || other.is_empty() {
        return None;
    }
    Some(mean_distance(one, other).max(mean_distance(other, one)))
}

/// The mean distance of the points of a curve to another curve, by the middles of its segments.
fn mean_distance(from: &[[[f64; 2]; 2]], to: &[[[f64; 2]; 2]]) -> f64 {
    let (mut sum, mut length) = (0.0, 0.0);
    for [a, b] in from {
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let weight = (b[0] - a[0]).hypot(b[1] - a[1]);
        let nearest = to
            .iter()
            .map(|segment| square_distance(middle, segment))
            .fold(f64::INFINITY, f64::min);
        sum += weight * nearest.sqrt();
        length += weight;
    }
    sum / length.max(f64::MIN_POSITIVE)
}

fn square_distance(point: [f64; 2], [a, b]: &[[f64; 2]; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let offset = [point[0] - a[0], point[1] - a[1]];
    let share = (offset[0] * along[0] + offset[1] * along[1]) / square.max(f64::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    let miss = [0, 1].map(|axis| offset[axis] - share * along[axis]);
    miss[0] * miss[0] + miss[1] * miss[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// φ = tanh((r − |x − c|)/0.1) on a mesh.
    fn circle(cells: usize, radius: f64) -> Solution {
        let mesh = Mesh::structured(cells, 0.0, 1).expect("a mesh");
        let distance = |[x, y]: [f64; 2]| radius - (x - 0.5).hypot(y - 0.5);
        let nodes = mesh.nodes().iter();
        let state = State {
            phi: nodes.map(|node| (distance(*node) / 0.1).tanh()).collect(),
            omega: Vec::new(),
            mu: Vec::new(),
            director: None,
        };
        Solution::new(&mesh, &state, 2.0, 4.0)
    }

    #[test]
    fn a_moved_membrane_is_as_far_as_it_was_moved() {
        let (one, other) = (circle(64, 0.25), circle(64, 0.26));
        let errors = one.errors(&other);
        let membrane = errors.membrane.expect("a membrane");
        assert!((membrane - 0.01).abs() < 2e-4, "{membrane}");
        // ‖φ − φ*‖² ≈ 0.01² ∫ sech⁴(s/0.1)/0.1² over the ring of length 2π·0.255: 4/3·0.1/0.1².
        let expected = 0.01 * (std::f64::consts::TAU * 0.255 * 4.0 / 3.0 / 0.1).sqrt();
        assert!(
            (errors.phase / expected - 1.0).abs() < 0.02,
            "{} {expected}",
            errors.phase
        );
        assert_eq!(
            (errors.energy, errors.surface_area, errors.director),
            (0.0, 0.0, None)
        );
    }

    #[test]
    fn the_error_of_interpolation_falls_as_the_square_of_the_width() {
        let fine = circle(128, 0.25);
        let [coarse, halved] = [16, 32].map(|cells| circle(cells, 0.25).errors(&fine).phase);
        let order = (coarse / halved).log2();
        assert!((1.7..2.3).contains(&order), "{order}");
    }
}
