//! The Evans–Fung discocyte, the mean profile of a resting red blood cell.

use super::arc::{ArcPoint, QuarterArc, evenly_spaced};
use crate::geometry::{Point, Vector};

/// The coefficients of 1, t² and t⁴ in the thickness of the cell (Evans and Fung, 1972).
const THICKNESS: [f64; 3] = [0.207, 2.003, -1.123];

/// Parameters around that of the greatest curvature, 0.887: the cusp of the evolute.
const CUSP: [f64; 2] = [0.80, 0.98];

/// The part of the first quadrant, over R, that contains what the evolute encloses there.
const EVOLUTE_BOX: [[f64; 2]; 2] = [[0.64, 0.71], [0.0, 0.08]];

/// A quarter of the discocyte, γ(u) = (R sin u, ½R cos u (0.207 + 2.003 sin²u − 1.123 sin⁴u)).
///
/// With t = sin u the tips, where sqrt(1 − t²) is not smooth in t, are smooth in u. The curvature
/// is greatest not at the tip but on the rim, at u = 0.887, so that the evolute has a cusp at
/// (0.704, 0.077)R, in the first quadrant: in the small region under it two points of the quarter
/// may compete. They part at the cusp, where the table is so fine (1.8e-4) that two minima in one
/// cell differ by rounding alone; away from it they are far apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Discocyte {
    radius: f64,
}

impl Discocyte {
    pub(super) fn new(radius: f64) -> Self {
        Self { radius }
    }
}

impl QuarterArc for Discocyte {
    fn at(&self, parameter: f64) -> ArcPoint {
        let (sine, cosine) = parameter.sin_cos();
        let [c0, c2, c4] = THICKNESS;
        let square = sine * sine;
        // With q = sin²u: the polynomial P(q), and its first two derivatives by u.
        let value = c0 + square * (c2 + square * c4);
        let by_square = c2 + 2.0 * c4 * square;
        let square_first = 2.0 * sine * cosine;
        let square_second = 2.0 * (cosine * cosine - square);
        let first = by_square * square_first;
        let second = 2.0 * c4 * square_first * square_first + by_square * square_second;

        let (radius, half) = (self.radius, 0.5 * self.radius);
        ArcPoint {
            position: Point::new(radius * sine, half * cosine * value),
            first: Vector::new(radius * cosine, half * (cosine * first - sine * value)),
            second: Vector::new(
                -radius * sine,
                half * (cosine * (second - value) - 2.0 * sine * first),
            ),
        }
    }

    fn encloses(&self, point: Point) -> bool {
        let t = point.x / self.radius;
        let [c0, c2, c4] = THICKNESS;
        let square = t * t;
        let thickness = ((1.0 - t) * (1.0 + t)).sqrt() * (c0 + square * (c2 + square * c4));
        // Beyond the tip the root is NaN, and nothing is less than NaN.
        point.y < 0.5 * self.radius * thickness
    }

    fn breakpoints(&self) -> Vec<f64> {
        evenly_spaced(0.0, CUSP[0], 32)
            .chain(evenly_spaced(CUSP[0], CUSP[1], 1024))
            .chain(evenly_spaced(CUSP[1], self.end(), 32))
            .chain([self.end()])
            .collect()
    }

    fn near_evolute(&self, point: Point) -> bool {
        (0..2).all(|k| {
            let [low, high] = EVOLUTE_BOX[k];
            (low * self.radius..=high * self.radius).contains(&point[k])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::arc::{assert_derivatives, center_of_curvature};
    use super::*;

    #[test]
    fn derivatives_match_differences() {
        assert_derivatives(&Discocyte::new(0.4), 1e-8);
    }

    #[test]
    fn the_evolute_enters_the_first_quadrant_inside_its_box_only() {
        let arc = Discocyte::new(1.0);
        let mut entered = 0;
        for parameter in evenly_spaced(0.0, arc.end(), 20_000).skip(1) {
            let center = center_of_curvature(&arc, parameter);
            if center[0] > 0.0 && center[1] > 0.0 {
                entered += 1;
                assert!(arc.near_evolute(center), "{center:?} at {parameter}");
            }
        }
        assert!(entered > 1000);
    }

    #[test]
    fn nothing_beyond_the_tip_is_inside() {
        let arc = Discocyte::new(0.4);
        let encloses = |x: f64, y: f64| arc.encloses(Point::new(x, y));
        assert!(encloses(0.0, 0.0) && encloses(0.399, 0.0));
        assert!(!encloses(0.4, 0.0) && !encloses(0.5, 0.0));
        // The half-thickness at the waist is 0.1035 R.
        assert!(encloses(0.0, 0.0413) && !encloses(0.0, 0.0415));
    }
}
