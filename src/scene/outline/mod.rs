//! Vesicles as closed curves: signed distance, tanh profile, bounding box, length and area.
//!
//! The distance is the true Euclidean one, to rounding, everywhere. A level-set value divided by
//! its gradient has the same zero and the same slope there, but not the same curvature: it puts
//! the bending energy off by a factor.

mod arc;
mod cassini;
mod discocyte;
mod ellipse;
mod quadrature;
mod stomatocyte;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, SQRT_2, TAU};

use self::arc::{PreparedArc, QuarterArc};
use self::cassini::Cassini;
use self::discocyte::Discocyte;
use self::ellipse::Ellipse;
use self::stomatocyte::Stomatocyte;
use super::{Curve, Geometry, Outline};
use crate::geometry::{BoundingBox, Point, Vector, direction, frame, length};

/// The least opening of a stomatocyte, in degrees, at which its rim stays open; `None` for a wall that is too thick for any.
pub(super) fn least_opening(radius: f64, thickness: f64) -> Option<f64> {
    Stomatocyte::least_opening(radius, thickness)
}

/// A signed distance to a curve, and its slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignedDistance {
    /// s: the distance to the nearest point of the curve, positive inside.
    pub value: f64,
    /// ∇s, a unit vector: the inward normal at the nearest point, and at one of them where there
    /// are several.
    pub gradient: Vector,
}

/// An outline prepared for many evaluations of its signed distance.
#[derive(Debug, Clone)]
pub struct OutlineDistance {
    center: Point,
    /// The direction of the axis that is along x in `shape`.
    axis: Vector,
    shape: PreparedCurve,
}

/// A curve with what its evaluation needs, as [`Curve`] has it.
#[derive(Debug, Clone)]
enum PreparedCurve {
    Circle { radius: f64 },
    Ellipse(PreparedArc<Ellipse>),
    Cassini(PreparedArc<Cassini>),
    Discocyte(PreparedArc<Discocyte>),
    Stomatocyte(Stomatocyte),
}

impl OutlineDistance {
    /// Prepares an outline whose sizes are positive, whose ratio, if any, is in [0, 1), and whose rim, if any, is open.
    pub fn new(outline: &Outline) -> Self {
        let shape = match outline.curve {
            Curve::Circle { radius } => PreparedCurve::Circle { radius },
            Curve::Ellipse { half_axes } => {
                PreparedCurve::Ellipse(PreparedArc::new(Ellipse::new(half_axes)))
            }
            Curve::Cassini { ratio, half_length } => {
                PreparedCurve::Cassini(PreparedArc::new(Cassini::new(ratio, half_length)))
            }
            Curve::Discocyte { radius } => {
                PreparedCurve::Discocyte(PreparedArc::new(Discocyte::new(radius)))
            }
            Curve::Stomatocyte {
                radius,
                thickness,
                opening,
            } => PreparedCurve::Stomatocyte(Stomatocyte::new(radius, thickness, opening)),
        };
        Self {
            center: outline.center.into(),
            axis: direction(outline.angle),
            shape,
        }
    }

    /// The Euclidean signed distance of a point to the outline, to rounding.
    ///
    /// Inside and outside are told apart by the implicit form of the curve, evaluated at the point.
    pub fn signed_distance(&self, point: Point) -> SignedDistance {
        let frame = frame(self.axis);
        let local = frame.inverse_transform_vector(&(point - self.center));
        let SignedDistance { value, gradient } = self.shape.signed_distance(local.into());
        SignedDistance {
            value,
            gradient: frame * gradient,
        }
    }

    /// The smallest box around the outline, to rounding.
    pub fn bounding_box(&self) -> BoundingBox {
        // How far the curve reaches along a direction of the plane.
        let frame = frame(self.axis);
        let reach = |direction: Vector| {
            let local = frame.inverse_transform_vector(&direction);
            self.shape.support(local)
        };
        let upper = Vector::new(reach(Vector::x()), reach(Vector::y()));
        let lower = Vector::new(reach(-Vector::x()), reach(-Vector::y()));
        BoundingBox {
            lower: self.center - lower,
            upper: self.center + upper,
        }
    }

    /// The length of the outline, to rounding.
    pub fn length(&self) -> f64 {
        match &self.shape {
            PreparedCurve::Circle { radius } => TAU * radius,
            PreparedCurve::Ellipse(arc) => arc.length(),
            PreparedCurve::Cassini(arc) => arc.length(),
            PreparedCurve::Discocyte(arc) => arc.length(),
            PreparedCurve::Stomatocyte(cup) => cup.length(),
        }
    }

    /// The area that the outline encloses, to rounding.
    pub fn area(&self) -> f64 {
        match &self.shape {
            PreparedCurve::Circle { radius } => PI * radius * radius,
            PreparedCurve::Ellipse(arc) => arc.area(),
            PreparedCurve::Cassini(arc) => arc.area(),
            PreparedCurve::Discocyte(arc) => arc.area(),
            PreparedCurve::Stomatocyte(cup) => cup.area(),
        }
    }

    /// 4π·area/length², at most 1: the square of the factor by which the membrane can shrink at
    /// constant area until the vesicle is a circle (isoperimetric inequality).
    pub fn isoperimetric_quotient(&self) -> f64 {
        4.0 * PI * self.area() / self.length().powi(2)
    }
}

impl PreparedCurve {
    fn signed_distance(&self, point: Point) -> SignedDistance {
        match self {
            Self::Circle { radius } => {
                let distance = length(point.coords);
                let gradient = if distance > 0.0 {
                    -point.coords / distance
                } else {
                    Vector::x()
                };
                SignedDistance {
                    value: radius - distance,
                    gradient,
                }
            }
            Self::Ellipse(arc) => quartered_distance(arc, point),
            Self::Cassini(arc) => quartered_distance(arc, point),
            Self::Discocyte(arc) => quartered_distance(arc, point),
            Self::Stomatocyte(cup) => cup.signed_distance(point),
        }
    }

    /// max γ·n over the curve, for a unit vector n.
    fn support(&self, direction: Vector) -> f64 {
        // By the symmetry of a quartered curve a direction reaches as far as its image in the first quadrant.
        let folded = direction.abs();
        match self {
            Self::Circle { radius } => *radius,
            Self::Ellipse(arc) => arc.support(folded),
            Self::Cassini(arc) => arc.support(folded),
            Self::Discocyte(arc) => arc.support(folded),
            Self::Stomatocyte(cup) => cup.support(direction),
        }
    }
}

/// The signed distance to a curve that is symmetric about both axes.
fn quartered_distance<Arc: QuarterArc>(arc: &PreparedArc<Arc>, point: Point) -> SignedDistance {
    let folded = point.map(f64::abs);
    let (distance, nearest) = arc.nearest(folded);
    let normal = nearest.inward_normal();
    let unfolded = |component: f64, at: f64| if at < 0.0 { -component } else { component };
    SignedDistance {
        value: if arc.encloses(folded) {
            distance
        } else {
            -distance
        },
        gradient: normal.zip_map(&point.coords, unfolded),
    }
}

/// The signed distance to the union of what the outlines enclose: the largest of theirs.
///
/// Outside it is the distance; inside, where outlines overlap, it is a lower bound of it. Of no
/// outline at all it is −∞, with a slope of zero.
pub fn union_distance(outlines: &[OutlineDistance], point: Point) -> SignedDistance {
    let nothing = SignedDistance {
        value: f64::NEG_INFINITY,
        gradient: Vector::zeros(),
    };
    outlines.iter().fold(nothing, |largest, outline| {
        let distance = outline.signed_distance(point);
        if distance.value > largest.value {
            distance
        } else {
            largest
        }
    })
}

/// The least distance of the outlines to the wall of the unit square Ω: negative if one lies
/// across it. By rotation the side x = 0 is the axis, and no wall.
pub fn wall_distance(outlines: &[OutlineDistance], geometry: Geometry) -> f64 {
    outlines
        .iter()
        .map(|outline| {
            let BoundingBox { lower, upper } = outline.bounding_box();
            let others = lower.y.min(1.0 - upper.x).min(1.0 - upper.y);
            match geometry {
                Geometry::Planar => lower.x.min(others),
                Geometry::Axisymmetric => others,
            }
        })
        .fold(f64::INFINITY, f64::min)
}

/// φ⁰ = tanh(s/(√2 ε)) and ∇φ⁰ = sech²(s/(√2 ε)) ∇s/(√2 ε), ε being `interface_width`.
///
/// This is the profile of a flat membrane at rest: it solves −Δφ + F′(φ)/ε² = 0.
pub fn phase_profile(distance: SignedDistance, interface_width: f64) -> (f64, Vector) {
    let scale = 1.0 / (SQRT_2 * interface_width);
    let argument = scale * distance.value;
    // sech² without the overflow of cosh and the cancellation of 1 − tanh².
    let decay = (-2.0 * argument.abs()).exp();
    let slope = scale * 4.0 * decay / ((1.0 + decay) * (1.0 + decay));
    (argument.tanh(), slope * distance.gradient)
}
