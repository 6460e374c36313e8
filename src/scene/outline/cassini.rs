//! The Cassini oval.

use std::f64::consts::PI;

use super::arc::{ArcPoint, QuarterArc};
use crate::geometry::{Point, Vector};

/// A quarter of a Cassini oval: the points whose distances to (±c, 0) have the product a², c < a.
///
/// As complex numbers they solve |z² − c²| = a². The parameter is the angle χ of z² − c² measured
/// back from the negative real axis, z² = −w² + 2a² sin²(χ/2) + i a² sin χ with the half-waist
/// w = sqrt(a² − c²): smooth, and free of cancellation at the waist (χ = 0) for every ratio.
/// In polar form this is r² = c² cos 2θ + sqrt(a⁴ − c⁴ sin² 2θ).
///
/// The curvature (3r⁴ + c⁴ − a⁴)/(2a²r³) grows with r, so 1/κ grows on the way from the tip to
/// the waist, and the centre of curvature moves along the inward normal: from the x axis into the
/// fourth quadrant and, past the inflection if there is one, from infinity through the second
/// quadrant to the y axis. The evolute never meets the open first quadrant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cassini {
    /// a².
    product: f64,
    /// c².
    focus_squared: f64,
    /// w² = a² − c².
    waist_squared: f64,
    /// a² + c².
    length_squared: f64,
}

impl Cassini {
    /// The oval with the given c/a in [0, 1) and sqrt(a² + c²).
    pub(super) fn new(ratio: f64, half_length: f64) -> Self {
        let length_squared = half_length * half_length;
        let product = length_squared / (1.0 + ratio * ratio);
        Self {
            product,
            focus_squared: ratio * ratio * product,
            waist_squared: (1.0 - ratio) * (1.0 + ratio) * product,
            length_squared,
        }
    }
}

impl QuarterArc for Cassini {
    fn end(&self) -> f64 {
        PI
    }

    fn at(&self, parameter: f64) -> ArcPoint {
        let (half_sine, half_cosine) = (0.5 * parameter).sin_cos();
        let sine = 2.0 * half_sine * half_cosine;
        let cosine = 1.0 - 2.0 * half_sine * half_sine;

        // v = z², and z = sqrt(v) without cancellation.
        let real = 2.0 * self.product * half_sine * half_sine - self.waist_squared;
        let imaginary = self.product * sine;
        let modulus = (real * real + imaginary * imaginary).sqrt();
        let larger = (0.5 * (modulus + real.abs())).sqrt();
        let smaller = 0.5 * imaginary / larger;
        let [x, y] = if real >= 0.0 {
            [larger, smaller]
        } else {
            [smaller, larger]
        };

        // 2zz′ = v′ = a²(sin χ + i cos χ) and 2z′² + 2zz″ = v″ = a²(cos χ − i sin χ); 1/z = z̄/|v|.
        let over_z = |re: f64, im: f64| Vector::new(re * x + im * y, im * x - re * y) / modulus;
        let half = 0.5 * self.product;
        let first = over_z(half * sine, half * cosine);
        let (real, imaginary) = (
            first.x * first.x - first.y * first.y,
            2.0 * first.x * first.y,
        );
        let second = over_z(half * cosine - real, -half * sine - imaginary);
        ArcPoint {
            position: Point::new(x, y),
            first,
            second,
        }
    }

    fn encloses(&self, point: Point) -> bool {
        // |z² − c²|² < a⁴, with (a² − c²)(a² + c²) for a⁴ − c⁴, which would cancel.
        let (x_squared, y_squared) = (point.x * point.x, point.y * point.y);
        let radius_squared = x_squared + y_squared;
        radius_squared * radius_squared
            < 2.0 * self.focus_squared * (x_squared - y_squared)
                + self.waist_squared * self.length_squared
    }
}

#[cfg(test)]
mod tests {
    use super::super::arc::{assert_derivatives, center_of_curvature, evenly_spaced};
    use super::*;

    #[test]
    fn every_point_has_the_product_of_distances() {
        let (ratio, half_length) = (0.92, 0.32);
        let arc = Cassini::new(ratio, half_length);
        let a_squared = half_length * half_length / (1.0 + ratio * ratio);
        let c = ratio * a_squared.sqrt();
        for parameter in evenly_spaced(0.0, PI, 300) {
            let [x, y] = arc.at(parameter).position.into();
            let product = (x - c).hypot(y) * (x + c).hypot(y);
            assert!(
                (product / a_squared - 1.0).abs() < 4e-15,
                "{product} against {a_squared}"
            );
        }
    }

    #[test]
    fn derivatives_match_differences() {
        for ratio in [0.0, 0.5, 0.92] {
            assert_derivatives(&Cassini::new(ratio, 0.32), 1e-8);
        }
    }

    #[test]
    fn the_evolute_stays_out_of_the_open_first_quadrant() {
        for ratio in [0.2, 0.7, 0.72, 0.92, 0.999] {
            let arc = Cassini::new(ratio, 0.32);
            for parameter in evenly_spaced(0.0, arc.end(), 1000).skip(1) {
                let [x, y] = center_of_curvature(&arc, parameter).into();
                assert!(x.min(y) < 1e-15, "ratio {ratio} at {parameter}: ({x}, {y})");
            }
        }
    }
}
