//! The shape that a membrane without nematic takes at rest.

use super::body_at_rest::BodyAtRest;
use super::curve_at_rest::CurveAtRest;
use crate::geometry::{Point, Vector};

/// The shape at which bending energy and penalty of the area are least in all, about what the membrane encloses.
#[derive(Debug, Clone, PartialEq)]
pub enum ShapeAtRest {
    /// In the plane.
    Curve(CurveAtRest),
    /// In space, a body of rotation.
    Body(BodyAtRest),
}

/// The penalty (B − β)²/(2η) of the membrane's area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaPenalty {
    /// β.
    pub target: f64,
    /// η.
    pub penalty: f64,
}

/// (B − β)/η; zero without a penalty.
pub(super) fn strain(surface_area: f64, penalty: Option<AreaPenalty>) -> f64 {
    penalty.map_or(0.0, |it| (surface_area - it.target) / it.penalty)
}

impl ShapeAtRest {
    /// The closed curve about a centre, in the plane with its long axis along a unit vector; the cross-section of a body, whose axis is
    /// that of y.
    pub fn outline(&self, center: Point, axis: Vector) -> Vec<Point> {
        match self {
            Self::Curve(curve) => curve.outline(center, axis),
            Self::Body(body) => body.outline(center),
        }
    }
}
