//! Rectangles about points.

use std::borrow::Borrow;

use super::{Point, Vector};

/// A rectangle with its sides along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// The least x and y.
    pub lower: Point,
    /// The greatest x and y.
    pub upper: Point,
}

impl BoundingBox {
    /// The smallest one that holds these points.
    pub fn around(points: impl IntoIterator<Item = impl Borrow<Point>>) -> Self {
        let nothing = Self {
            lower: Point::new(f64::INFINITY, f64::INFINITY),
            upper: Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
        };
        points.into_iter().fold(nothing, |hull, point| Self {
            lower: hull.lower.inf(point.borrow()),
            upper: hull.upper.sup(point.borrow()),
        })
    }

    /// Its width and its height; 0 where it holds no point.
    pub fn extent(&self) -> Vector {
        (self.upper - self.lower).sup(&Vector::zeros())
    }

    /// The smallest one that holds this one and another.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lower: self.lower.inf(&other.lower),
            upper: self.upper.sup(&other.upper),
        }
    }

    /// The point in its middle.
    pub fn center(&self) -> Point {
        nalgebra::center(&self.lower, &self.upper)
    }

    /// Its width by its height.
    pub fn aspect(&self) -> f64 {
        self.extent().x / self.extent().y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_its_points_and_nothing_has_no_extent() {
        let points = [[1.0, 5.0], [-2.0, 6.0], [0.0, 5.5]].map(Point::from);
        let hull = BoundingBox::around(points);
        assert_eq!(hull.lower, Point::new(-2.0, 5.0));
        assert_eq!(hull.upper, Point::new(1.0, 6.0));
        assert_eq!(hull.extent(), Vector::new(3.0, 1.0));
        let other = BoundingBox::around([[0.0, 0.0], [2.0, 5.5]].map(Point::from));
        let both = BoundingBox {
            lower: Point::new(-2.0, 0.0),
            upper: Point::new(2.0, 6.0),
        };
        assert_eq!(hull.union(&other), both);
        assert_eq!(both.center(), Point::new(0.0, 3.0));
        let nothing = BoundingBox::around(std::iter::empty::<Point>());
        assert_eq!(nothing.extent(), Vector::zeros());
    }
}
