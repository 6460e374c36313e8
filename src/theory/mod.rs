//! What the sharp-interface theory of membranes says of vesicles, as a measure for runs: the shape at rest, and how fast
//! a nearly round vesicle becomes round.
//!
//! A membrane of interface width ε tends to a curve as ε → 0: its area B to c times the length of the curve, and its
//! bending energy to c/2 ∫κ² ds, with the factor c = [`MEMBRANE_FACTOR`].

mod body_at_rest;
mod closed_surface;
mod curve_at_rest;
mod elastica;
mod relaxation;
mod root;
mod shape_at_rest;

pub use body_at_rest::BodyAtRest;
pub use closed_surface::{Branch, CROSSINGS, ClosedSurface, ClosedSurfaceError};
pub use curve_at_rest::CurveAtRest;
pub use elastica::ElasticaError;
pub use relaxation::{RoundBody, RoundVesicle, relaxation_time, relaxation_time_of_sphere};
pub use shape_at_rest::{AreaPenalty, ShapeAtRest};

/// c = 2√2/3: B of a flat profile tanh(s/(√2 ε)), per unit of length.
pub const MEMBRANE_FACTOR: f64 = 2.0 * std::f64::consts::SQRT_2 / 3.0;
