//! The nearest point of a closed curve that is symmetric about both coordinate axes.
//!
//! For a point in the closed first quadrant some nearest point of the curve lies there too:
//! mirroring a point of the curve into the quadrant never takes it farther away. So a curve is
//! given by its quarter γ(u) from the waist, on the y axis, to the tip, on the x axis, and the
//! nearest point is a root of the slope of half the squared distance, g(u) = (γ(u) − p)·γ′(u).
//!
//! How many roots there are can change only where p crosses the evolute of the quarter (its centres
//! of curvature; there g = g′ = 0) or the normal at one of its ends, that is a coordinate axis. If
//! the evolute stays out of the open first quadrant, as it does for ellipses and Cassini ovals, the
//! number is the same for every p in it: one, the global minimum, and no search can miss it.
//! Where an evolute does enter, the curve says so and every sign change of g is followed.

use std::f64::consts::FRAC_PI_2;

use super::quadrature::integrate;
use crate::geometry::{Point, Vector, length};

/// A Newton step in u this short is the last: convergence is quadratic, what is left is rounding.
const LAST_STEP: f64 = 1e-10;

/// Iterations before the best bracket is taken as it is; bisection alone needs fewer.
const MOST_ITERATIONS: usize = 100;

/// A point of a quarter arc, with the derivatives by its parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArcPoint {
    /// γ.
    pub position: Point,
    /// γ′.
    pub first: Vector,
    /// γ″.
    pub second: Vector,
}

impl ArcPoint {
    /// The point at a parameter larger by a `step` of at most [`LAST_STEP`], by Taylor's formula.
    fn moved_by(self, step: f64) -> Self {
        Self {
            position: self.position + step * (self.first + 0.5 * step * self.second),
            first: self.first + step * self.second,
            ..self
        }
    }

    /// The unit normal that points into the curve: the direction of travel turned clockwise.
    pub(super) fn inward_normal(&self) -> Vector {
        Vector::new(self.first.y, -self.first.x) / length(self.first)
    }
}

/// A quarter of a curve in the first quadrant, from the waist γ(0) = (0, y) to the tip
/// γ(`end`) = (x, 0).
pub(super) trait QuarterArc {
    /// The parameter of the tip.
    fn end(&self) -> f64 {
        FRAC_PI_2
    }

    /// γ, γ′ and γ″ at a parameter.
    fn at(&self, parameter: f64) -> ArcPoint;

    /// Whether a point of the closed first quadrant is inside the curve, by its implicit form.
    fn encloses(&self, point: Point) -> bool;

    /// Parameters from 0 to `end`, increasing, between which the slope g is searched for roots.
    fn breakpoints(&self) -> Vec<f64> {
        evenly_spaced(0.0, self.end(), 64)
            .chain([self.end()])
            .collect()
    }

    /// Whether the evolute of the quarter is near this point of the first quadrant, so that the
    /// distance to the quarter may have several local minima.
    fn near_evolute(&self, _point: Point) -> bool {
        false
    }
}

/// `count` parameters from `start` (included) to `end` (not included).
pub(super) fn evenly_spaced(start: f64, end: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| start + (end - start) * k as f64 / count as f64)
}

/// What is approached, in homogeneous coordinates: the point `towards` (`weight` 1) or the point
/// at infinity in the direction `towards` (`weight` 0).
#[derive(Debug, Clone, Copy)]
struct Target {
    towards: Vector,
    weight: f64,
}

impl Target {
    /// g = (γ − p)·γ′, or −n·γ′ at infinity.
    fn slope(&self, position: Point, first: Vector) -> f64 {
        self.away(position).dot(&first)
    }

    /// g′ = γ′·γ′ + (γ − p)·γ″, or −n·γ″ at infinity.
    fn slope_derivative(&self, at: &ArcPoint) -> f64 {
        self.weight * at.first.norm_squared() + self.away(at.position).dot(&at.second)
    }

    fn away(&self, position: Point) -> Vector {
        self.weight * position.coords - self.towards
    }
}

/// One entry of the table in which roots are bracketed.
#[derive(Debug, Clone, Copy)]
struct Sample {
    parameter: f64,
    position: Point,
    first: Vector,
}

/// A quarter arc with the table that brackets its nearest points.
#[derive(Debug, Clone)]
pub(super) struct PreparedArc<Arc> {
    arc: Arc,
    table: Vec<Sample>,
}

impl<Arc: QuarterArc> PreparedArc<Arc> {
    pub(super) fn new(arc: Arc) -> Self {
        let table = arc
            .breakpoints()
            .into_iter()
            .map(|parameter| {
                let ArcPoint {
                    position, first, ..
                } = arc.at(parameter);
                Sample {
                    parameter,
                    position,
                    first,
                }
            })
            .collect();
        Self { arc, table }
    }

    pub(super) fn encloses(&self, point: Point) -> bool {
        self.arc.encloses(point)
    }

    /// The distance from a point of the closed first quadrant to the curve, and its nearest point.
    pub(super) fn nearest(&self, point: Point) -> (f64, ArcPoint) {
        let target = Target {
            towards: point.coords,
            weight: 1.0,
        };
        let measured = |cell| {
            let foot = self.root(cell, &target);
            (length(target.away(foot.position)), foot)
        };
        let mut best = measured(self.only_cell(&target));
        if self.arc.near_evolute(point) {
            for cell in self.cells_with_minimum(&target) {
                let candidate = measured(cell);
                if candidate.0 < best.0 {
                    best = candidate;
                }
            }
        }
        best
    }

    /// max γ·n over the curve, for a direction n in the closed first quadrant.
    pub(super) fn support(&self, direction: Vector) -> f64 {
        let target = Target {
            towards: direction,
            weight: 0.0,
        };
        let reached = self.root(self.only_cell(&target), &target).position;
        reached.coords.dot(&direction)
    }

    /// The length of the whole curve, 4∫|γ′|du.
    pub(super) fn length(&self) -> f64 {
        4.0 * integrate(self.arc.end(), |parameter| {
            length(self.arc.at(parameter).first)
        })
    }

    /// The area inside the whole curve, 4∫y dx.
    pub(super) fn area(&self) -> f64 {
        4.0 * integrate(self.arc.end(), |parameter| {
            let point = self.arc.at(parameter);
            point.position.y * point.first.x
        })
    }

    /// The cell of the table in which the slope turns positive, if it does so only once.
    ///
    /// The slope is known to be ≤ 0 at the waist and ≥ 0 at the tip; neither is evaluated, so that
    /// a target on an axis does not depend on the sign of a rounded zero.
    fn only_cell(&self, target: &Target) -> usize {
        let inner = &self.table[1..self.table.len() - 1];
        inner.partition_point(|sample| target.slope(sample.position, sample.first) <= 0.0)
    }

    /// Every cell of the table in which the slope turns positive.
    fn cells_with_minimum(&self, target: &Target) -> impl Iterator<Item = usize> {
        let last = self.table.len() - 1;
        let positive = move |k: usize| {
            let sample = &self.table[k];
            k == last || (k > 0 && target.slope(sample.position, sample.first) > 0.0)
        };
        (0..last).filter(move |&k| !positive(k) && positive(k + 1))
    }

    /// The minimum in a cell in which the slope turns positive: Newton's method for g, kept in the
    /// bracket.
    fn root(&self, cell: usize, target: &Target) -> ArcPoint {
        let (low, high) = (&self.table[cell], &self.table[cell + 1]);
        let low_slope = target.slope(low.position, low.first);
        let high_slope = target.slope(high.position, high.first);
        let (mut low, mut high) = (low.parameter, high.parameter);
        let inside = |parameter: f64, low: f64, high: f64| low < parameter && parameter < high;

        // A root at an end of the arc is approached from one side only: Newton's step will
        // overshoot it, and the end itself is then tried, once.
        let mut untried_end = if cell == 0 {
            Some(low)
        } else if cell + 2 == self.table.len() {
            Some(high)
        } else {
            None
        };

        let middle = |low: f64, high: f64| low + 0.5 * (high - low);
        let secant = low + (high - low) * low_slope / (low_slope - high_slope);
        let mut parameter = if inside(secant, low, high) {
            secant
        } else {
            middle(low, high)
        };
        let mut point = self.arc.at(parameter);
        for _ in 0..MOST_ITERATIONS {
            let slope = target.slope(point.position, point.first);
            let derivative = target.slope_derivative(&point);
            if slope < 0.0 {
                low = parameter;
            } else if slope > 0.0 {
                high = parameter;
            }
            let step = -slope / derivative;
            let rising = derivative > 0.0;
            if rising && step.abs() <= LAST_STEP {
                let reached = (parameter + step).clamp(0.0, self.arc.end());
                return point.moved_by(reached - parameter);
            }
            let newton = parameter + step;
            let bisected = middle(low, high);
            parameter = if rising && inside(newton, low, high) {
                newton
            } else if let Some(end) = untried_end.take_if(|end| {
                rising
                    && if cell == 0 {
                        newton <= *end
                    } else {
                        newton >= *end
                    }
            }) {
                end
            } else if inside(bisected, low, high) {
                bisected
            } else {
                break;
            };
            point = self.arc.at(parameter);
        }
        point
    }
}

/// The centre of curvature at a parameter, for the tests of the curves.
#[cfg(test)]
pub(super) fn center_of_curvature(arc: &impl QuarterArc, parameter: f64) -> Point {
    let point = arc.at(parameter);
    let speed = length(point.first);
    // Positive where the curve bends towards its inward normal.
    let curvature = point.second.perp(&point.first) / speed.powi(3);
    point.position + point.inward_normal() / curvature
}

/// Checks γ′ and γ″ against differences of γ, for the tests of the curves.
#[cfg(test)]
pub(super) fn assert_derivatives(arc: &impl QuarterArc, tolerance: f64) {
    let step = 1e-5;
    for parameter in evenly_spaced(0.0, arc.end(), 101) {
        let (before, at, after) = (
            arc.at(parameter - step),
            arc.at(parameter),
            arc.at(parameter + step),
        );
        for k in 0..2 {
            let first = (after.position[k] - before.position[k]) / (2.0 * step);
            let second = (after.first[k] - before.first[k]) / (2.0 * step);
            assert!((first - at.first[k]).abs() < tolerance, "γ′ at {parameter}");
            assert!(
                (second - at.second[k]).abs() < tolerance,
                "γ″ at {parameter}"
            );
        }
    }
}
