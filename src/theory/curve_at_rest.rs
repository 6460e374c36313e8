//! The curve that a membrane without nematic takes at rest in the plane.

use std::f64::consts::PI;

use super::MEMBRANE_FACTOR;
use super::elastica::{Elastica, ElasticaError, LEAST_REDUCED_AREA};
use super::root::root;
use super::shape_at_rest::{AreaPenalty, strain};
use crate::geometry::{Point, Vector};

/// The curve of length L about the area A at which c/2 ∫κ² ds + (cL − β)²/(2η) is least.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveAtRest {
    /// The curve.
    pub elastica: Elastica,
    /// L.
    pub perimeter: f64,
    /// A.
    pub enclosed: f64,
    /// σ = c(cL − β)/η: negative where the membrane is compressed.
    pub tension: f64,
    /// c/2 ∫κ² ds: the limit of E_ben.
    pub bending: f64,
    /// (cL − β)²/(2η).
    pub stretching: f64,
}

impl CurveAtRest {
    /// About this area; without a penalty the membrane may have any length, and the curve is a circle.
    ///
    /// # Errors
    /// [`ElasticaError::Touching`]: at rest opposite sides would meet; `TooRound` for an area that is no positive number.
    pub fn new(enclosed: f64, penalty: Option<AreaPenalty>) -> Result<Self, ElasticaError> {
        if !(enclosed > 0.0 && enclosed.is_finite()) {
            return Err(ElasticaError::NoArea { enclosed });
        }
        // dE/dL at constant A, over c: positive where the membrane would rather be shorter.
        let force = |elastica: &Elastica| {
            let perimeter = perimeter(enclosed, elastica.reduced_area);
            strain(MEMBRANE_FACTOR * perimeter, penalty)
                - elastica.tension / (perimeter * perimeter)
        };
        let circle = Elastica::circle();
        let on_circle = force(&circle);
        if on_circle >= 0.0 {
            return Ok(Self::of(circle, enclosed, penalty));
        }
        let mut found = Elastica::new(LEAST_REDUCED_AREA)?;
        let on_longest = force(&found);
        if on_longest < 0.0 {
            let aimed = penalty.map_or(f64::NAN, |penalty| penalty.target / MEMBRANE_FACTOR);
            let reduced_area = 4.0 * PI * enclosed / (aimed * aimed);
            return Err(ElasticaError::Touching { reduced_area });
        }
        let ends = [
            (circle.reduced_area, on_circle),
            (found.reduced_area, on_longest),
        ];
        root(ends, |reduced_area| {
            found = Elastica::new(reduced_area)?;
            Ok::<_, ElasticaError>(force(&found))
        })?;
        Ok(Self::of(found, enclosed, penalty))
    }

    fn of(elastica: Elastica, enclosed: f64, penalty: Option<AreaPenalty>) -> Self {
        let perimeter = perimeter(enclosed, elastica.reduced_area);
        let strain = strain(MEMBRANE_FACTOR * perimeter, penalty);
        Self {
            bending: MEMBRANE_FACTOR * 2.0 * PI * PI / perimeter * elastica.energy,
            tension: MEMBRANE_FACTOR * strain,
            stretching: penalty.map_or(0.0, |it| 0.5 * it.penalty * strain * strain),
            elastica,
            perimeter,
            enclosed,
        }
    }

    /// Its extents: length, waist, greatest width.
    pub fn extents(&self) -> [f64; 3] {
        let Elastica {
            length,
            waist,
            width,
            ..
        } = self.elastica;
        [length, waist, width].map(|extent| extent * self.perimeter)
    }

    /// The closed curve about a centre, with its long axis along a unit vector.
    pub fn outline(&self, center: Point, axis: Vector) -> Vec<Point> {
        self.elastica.outline(self.perimeter, center, axis)
    }
}

/// L of α and A.
fn perimeter(enclosed: f64, reduced_area: f64) -> f64 {
    (4.0 * PI * enclosed / reduced_area).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_rest(enclosed: f64, target: f64, penalty: f64) -> Result<CurveAtRest, ElasticaError> {
        CurveAtRest::new(enclosed, Some(AreaPenalty { target, penalty }))
    }

    /// The total energy of the elastica of the same area at another length.
    fn energy(shape: &CurveAtRest, target: f64, penalty: f64, perimeter: f64) -> f64 {
        let alpha = 4.0 * PI * shape.enclosed / (perimeter * perimeter);
        let elastica = Elastica::new(alpha).expect("it is near one that there is");
        let excess = MEMBRANE_FACTOR * perimeter - target;
        MEMBRANE_FACTOR * 2.0 * PI * PI / perimeter * elastica.energy
            + excess * excess / (2.0 * penalty)
    }

    #[test]
    fn the_length_at_rest_has_the_least_energy() {
        for (target, penalty) in [(1.6, 1e-3), (1.6, 3e-3), (1.9, 3e-4)] {
            let enclosed = 0.13;
            let shape = at_rest(enclosed, target, penalty).expect("there is one");
            let own = shape.bending + shape.stretching;
            assert!((own - energy(&shape, target, penalty, shape.perimeter)).abs() < 1e-9 * own);
            for step in [-1e-3, 1e-3] {
                let other = energy(&shape, target, penalty, shape.perimeter * (1.0 + step));
                assert!(other > own, "{target} {penalty} {step}: {other} {own}");
            }
            // The membrane's tension is that of the elastica.
            let lambda = shape.elastica.tension / shape.perimeter.powi(2);
            assert!((shape.tension / (MEMBRANE_FACTOR * lambda) - 1.0).abs() < 1e-6);
            assert!(shape.tension < 0.0 && MEMBRANE_FACTOR * shape.perimeter < target);
        }
    }

    #[test]
    fn a_membrane_that_is_too_short_or_free_is_a_circle() {
        let enclosed = 0.05;
        let radius = (enclosed / PI).sqrt();
        for penalty in [
            None,
            Some(AreaPenalty {
                target: 0.2,
                penalty: 1e-3,
            }),
        ] {
            let shape = CurveAtRest::new(enclosed, penalty).expect("a circle");
            assert_eq!(shape.elastica.reduced_area, 1.0);
            for extent in shape.extents() {
                assert!((extent - 2.0 * radius).abs() < 1e-12);
            }
            // 2√2π/(3R)
            let energy = MEMBRANE_FACTOR * PI / radius;
            assert!((shape.bending / energy - 1.0).abs() < 1e-12);
            assert_eq!(shape.tension > 0.0, penalty.is_some());
        }
    }

    #[test]
    fn sides_that_would_meet_and_no_area_are_errors() {
        let error = at_rest(0.05, 3.0, 1e-4).expect_err("too long");
        assert!(
            matches!(error, ElasticaError::Touching { reduced_area } if reduced_area < 0.27),
            "{error}"
        );
        for enclosed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = CurveAtRest::new(enclosed, None).expect_err("no area");
            assert!(error.to_string().contains("encloses no area"), "{error}");
        }
    }
}
