//! Directions from angles in degrees.

use nalgebra::UnitComplex;

use super::Vector;

/// The unit vector at an angle to the x axis, in degrees; exact at the multiples of 90°.
pub fn direction(degrees: f64) -> Vector {
    // The remainder is exact for any size, as a quotient of large numbers is not.
    let degrees = degrees % 360.0;
    let quarter_turns = (degrees / 90.0).round();
    let (sine, cosine) = (degrees - 90.0 * quarter_turns).to_radians().sin_cos();
    match quarter_turns.rem_euclid(4.0) {
        1.0 => Vector::new(-sine, cosine),
        2.0 => Vector::new(-cosine, -sine),
        3.0 => Vector::new(sine, -cosine),
        _ => Vector::new(cosine, sine),
    }
}

/// The rotation that takes the x axis to a unit vector.
pub fn frame(axis: Vector) -> UnitComplex<f64> {
    UnitComplex::from_cos_sin_unchecked(axis.x, axis.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact_and_the_rest_is_right() {
        assert_eq!(direction(0.0), Vector::new(1.0, 0.0));
        assert_eq!(direction(90.0), Vector::new(0.0, 1.0));
        assert_eq!(direction(180.0), Vector::new(-1.0, 0.0));
        assert_eq!(direction(-90.0), Vector::new(0.0, -1.0));
        assert_eq!(direction(270.0), Vector::new(0.0, -1.0));
        assert_eq!(direction(450.0), Vector::new(0.0, 1.0));
        assert_eq!(direction(360_000_090.0), Vector::new(0.0, 1.0));
        assert_eq!(direction(-360_000_090.0), Vector::new(0.0, -1.0));
        assert_eq!(
            direction(90.0 * 99_999_999_999_999.0),
            Vector::new(0.0, -1.0)
        );
        assert_eq!(direction(90.0 * 2_f64.powi(900)), Vector::new(1.0, 0.0));
        // 10²⁰ = 280 + 360 n.
        assert_eq!(direction(1e20), direction(280.0));
        for degrees in -800..800 {
            let degrees = f64::from(degrees) + 0.25;
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let [x, y] = direction(degrees).into();
            assert!(
                (x - cosine).abs() < 4e-15 && (y - sine).abs() < 4e-15,
                "{degrees}"
            );
        }
    }
}
