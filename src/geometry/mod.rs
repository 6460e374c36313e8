//! Points, vectors and symmetric tensors of the plane, segments and distances from them.
//!
//! Points and vectors are those of nalgebra, with its algebra: the difference of two points is a vector,
//! `u.dot(&v)` and `u.perp(&v)` are the products of two vectors, `tensor * vector` is a vector.

mod angle;
mod bounding_box;
mod crop;
mod nearest_segments;
mod segment;
mod segment_grid;
mod tensor;

pub use angle::{direction, frame};
pub use bounding_box::BoundingBox;
pub use crop::{crop, widened};
pub use nearest_segments::NearestSegments;
pub use segment::{Segment, first_crossing, segment_distance, segment_offset};
pub use segment_grid::SegmentGrid;
pub use tensor::SymmetricTensor;

/// A point of the plane.
pub type Point = nalgebra::Point2<f64>;

/// A vector of the plane: a difference of points, a gradient, a flux.
pub type Vector = nalgebra::Vector2<f64>;

/// The length of a vector. Unlike nalgebra's `norm` it does not overflow or underflow, whatever the unit
/// of length.
pub fn length(vector: Vector) -> f64 {
    vector.x.hypot(vector.y)
}

/// Twice the area of a triangle: positive where its corners are counter-clockwise.
pub fn doubled_area([a, b, c]: [Point; 3]) -> f64 {
    (b - a).perp(&(c - a))
}
