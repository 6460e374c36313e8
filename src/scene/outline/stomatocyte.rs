//! The section of a cup: a wall of constant thickness about an arc of a circle, with a round rim.

use std::f64::consts::{PI, TAU};

use super::SignedDistance;
use crate::geometry::{Point, Vector, length};

/// The points within half a thickness of an arc of a circle about the origin. The arc leaves an opening about the positive y
/// axis. The distance is that to the arc, less half the thickness: exact on either side of the curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stomatocyte {
    radius: f64,
    half_thickness: f64,
    /// Half of the angle of the arc, from the negative y axis to its ends, in (0, π).
    half_angle: f64,
}

impl Stomatocyte {
    /// The opening is in degrees.
    pub(super) fn new(radius: f64, thickness: f64, opening: f64) -> Self {
        Self {
            radius,
            half_thickness: 0.5 * thickness,
            half_angle: PI - 0.5 * opening.to_radians(),
        }
    }

    /// The least opening, in degrees, at which the ends of the rim stay apart; `None` for a wall that is too thick for any.
    pub(super) fn least_opening(radius: f64, thickness: f64) -> Option<f64> {
        let sine = 0.5 * thickness / radius;
        (sine < 1.0).then(|| 2.0 * sine.asin().to_degrees())
    }

    /// The end of the arc at x > 0.
    fn end(&self) -> Point {
        let (sine, cosine) = self.half_angle.sin_cos();
        self.radius * Point::new(sine, -cosine)
    }

    pub(super) fn signed_distance(&self, point: Point) -> SignedDistance {
        let from_center = length(point.coords);
        // From the middle of the arc.
        let angle = point.x.abs().atan2(-point.y);
        let (distance, gradient) = if angle <= self.half_angle {
            let outwards = match from_center > 0.0 {
                true => point.coords / from_center,
                false => -Vector::y(),
            };
            match from_center < self.radius {
                true => (self.radius - from_center, outwards),
                false => (from_center - self.radius, -outwards),
            }
        } else {
            let end = self.end();
            let end = Point::new(end.x.copysign(point.x), end.y);
            let distance = length(end - point);
            match distance > 0.0 {
                true => (distance, (end - point) / distance),
                false => (0.0, Vector::y()),
            }
        };
        SignedDistance {
            value: self.half_thickness - distance,
            gradient,
        }
    }

    /// How far the curve reaches in the direction of a unit vector.
    pub(super) fn support(&self, direction: Vector) -> f64 {
        let angle = direction.x.abs().atan2(-direction.y);
        let along_arc = if angle <= self.half_angle {
            self.radius
        } else {
            let end = self.end();
            Vector::new(end.x.copysign(direction.x), end.y).dot(&direction)
        };
        along_arc + self.half_thickness
    }

    /// The outer side, the inner one and the two ends.
    pub(super) fn length(&self) -> f64 {
        4.0 * self.half_angle * self.radius + TAU * self.half_thickness
    }

    pub(super) fn area(&self) -> f64 {
        self.half_thickness * (4.0 * self.half_angle * self.radius + PI * self.half_thickness)
    }
}
