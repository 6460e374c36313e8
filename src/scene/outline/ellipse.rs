//! The ellipse.

use super::arc::{ArcPoint, QuarterArc};
use crate::geometry::{Point, Vector};

/// A quarter of an ellipse, γ(u) = (a sin u, b cos u).
///
/// Its evolute, ((a² − b²)/a sin³u, −(a² − b²)/b cos³u), lies in the fourth quadrant where a > b
/// and in the second where a < b, so the nearest point of a quarter is its only critical one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipse {
    half_axes: [f64; 2],
}

impl Ellipse {
    pub(super) fn new(half_axes: [f64; 2]) -> Self {
        Self { half_axes }
    }
}

impl QuarterArc for Ellipse {
    fn at(&self, parameter: f64) -> ArcPoint {
        let (sine, cosine) = parameter.sin_cos();
        let [a, b] = self.half_axes;
        let position = Point::new(a * sine, b * cosine);
        ArcPoint {
            position,
            first: Vector::new(a * cosine, -b * sine),
            second: -position.coords,
        }
    }

    fn encloses(&self, point: Point) -> bool {
        let [a, b] = self.half_axes;
        (point.x / a).powi(2) + (point.y / b).powi(2) < 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::arc::{assert_derivatives, center_of_curvature, evenly_spaced};
    use super::*;

    #[test]
    fn derivatives_match_differences() {
        assert_derivatives(&Ellipse::new([0.4, 0.1]), 1e-9);
    }

    #[test]
    fn the_evolute_stays_out_of_the_open_first_quadrant() {
        for half_axes in [[0.4, 0.1], [0.1, 0.4], [0.4, 0.39], [0.45, 0.009]] {
            let arc = Ellipse::new(half_axes);
            for parameter in evenly_spaced(0.0, arc.end(), 500).skip(1) {
                let [x, y] = center_of_curvature(&arc, parameter).into();
                assert!(x.min(y) < 1e-15, "{half_axes:?} at {parameter}: ({x}, {y})");
            }
        }
    }
}
