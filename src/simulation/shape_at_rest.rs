//! The shape at rest that the sharp-interface theory foresees for a scene.

use crate::fem::{Mesh, Pieces, center_and_axis};
use crate::geometry::Point;
use crate::scene::{Geometry, ScalarField, Scene};
use crate::theory::{self, AreaPenalty, ElasticaError, ShapeAtRest};
use std::f64::consts::PI;

/// Why the theory foresees no shape at rest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoShapeAtRest {
    /// The theory is of one closed curve.
    #[error("the theory of the shape at rest is of one vesicle, and there are {vesicles}")]
    Vesicles {
        /// How many there are.
        vesicles: usize,
    },
    /// Its energy has another form.
    #[error(
        "the theory of the shape at rest is of a membrane without spontaneous curvature: try it with \
         --set membrane.spontaneous_curvature=0"
    )]
    SpontaneousCurvature,
    /// Of bodies of rotation it is another one.
    #[error(
        "the theory of the shape at rest is of a curve in the plane, and domain.geometry = \"axisymmetric\" has a body of rotation"
    )]
    Rotation,
    /// There is no such curve.
    #[error(transparent)]
    Elastica(#[from] ElasticaError),
}

/// The shape at rest of the membrane of a scene as if it were alone: without nematic and outer fields. `phi` is any state of
/// the run; A = ∫φ⁰ and B(φ⁰) are those of the initial state.
///
/// # Errors
/// [`NoShapeAtRest`].
pub fn shape_at_rest(
    scene: &Scene,
    (mesh, phi): (&Mesh, &[f64]),
    [phase_integral, surface_area]: [f64; 2],
) -> Result<ShapeAtRest, NoShapeAtRest> {
    if scene.geometry == Geometry::Axisymmetric {
        return Err(NoShapeAtRest::Rotation);
    }
    if scene.membrane.spontaneous_curvature != ScalarField::Constant(0.0) {
        return Err(NoShapeAtRest::SpontaneousCurvature);
    }
    let vesicles = Pieces::default().find(mesh, phi);
    if vesicles != 1 {
        return Err(NoShapeAtRest::Vesicles { vesicles });
    }
    let penalty = scene.area.map(|area| AreaPenalty {
        target: area.target * surface_area,
        penalty: area.penalty,
    });
    Ok(ShapeAtRest::new(
        enclosed_area(mesh, phase_integral),
        penalty,
    )?)
}

/// The curve of a shape at rest beside the vesicle of a state: about its centre and along it.
pub fn outline_beside(shape: &ShapeAtRest, mesh: &Mesh, phi: &[f64]) -> Vec<Point> {
    let (center, axis) = center_and_axis(mesh, phi);
    shape.outline(center, axis)
}

/// (|Ω| + ∫φ)/2: the area inside of a membrane where φ jumps from −1 to 1; by rotation that of the great circle of the sphere
/// with the volume (|Ω| + ∫φ)/2.
pub fn enclosed_area(mesh: &Mesh, phase_integral: f64) -> f64 {
    let enclosed = 0.5 * (mesh.measures().iter().sum::<f64>() + phase_integral);
    match mesh.geometry() {
        Geometry::Planar => enclosed,
        Geometry::Axisymmetric => PI * (0.75 * enclosed / PI).cbrt().powi(2),
    }
}

/// The time in which the slowest mode of a round vesicle decays that has this [enclosed area](enclosed_area).
pub fn relaxation_time(geometry: Geometry, enclosed: f64, mobility: f64) -> f64 {
    match geometry {
        Geometry::Planar => theory::relaxation_time(enclosed, mobility),
        Geometry::Axisymmetric => {
            theory::relaxation_time_of_sphere((enclosed / PI).sqrt(), mobility)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Simulation, tests::small};
    use super::*;

    fn of(settings: &[&str]) -> Result<ShapeAtRest, NoShapeAtRest> {
        let scene = small(settings);
        let simulation = Simulation::new(&scene).expect("a small scene");
        let report = simulation.report();
        let phi = &simulation.state().phi;
        let start = [report.phase_integral, report.surface_area];
        shape_at_rest(&scene, (simulation.mesh(), phi), start)
    }

    #[test]
    fn the_theory_says_what_it_is_not_for() {
        let two = "vesicle={ parts = [{ shape = 'circle', radius = 0.12, center = [0.25, 0.5] }, \
                   { shape = 'circle', radius = 0.12, center = [0.75, 0.5] }] }";
        assert_eq!(of(&[two]), Err(NoShapeAtRest::Vesicles { vesicles: 2 }));
        let curved = of(&["membrane.spontaneous_curvature=0.5"]);
        assert_eq!(curved, Err(NoShapeAtRest::SpontaneousCurvature));
        let rotated = of(&[
            "domain.geometry=axisymmetric",
            "vesicle={ shape = 'circle', radius = 0.3, center = [0, 0.5] }",
            "nematic.initial=[0, 1]",
        ]);
        assert_eq!(rotated, Err(NoShapeAtRest::Rotation));
        let long = of(&["area={ target = 3.0, penalty = 1e-5 }"]);
        assert!(
            matches!(
                long,
                Err(NoShapeAtRest::Elastica(ElasticaError::Touching { .. }))
            ),
            "{long:?}"
        );
    }

    /// The profile of a circle of radius R has the area π(R² + π²ε²/6).
    #[test]
    fn the_area_inside_is_half_of_the_domain_and_the_integral() {
        let shape = of(&[
            "vesicle={ shape = 'circle', radius = 0.3 }",
            "mesh.cells=40",
        ])
        .expect("a circle");
        let pi = std::f64::consts::PI;
        let exact = pi * (0.09 + pi * pi * 0.06 * 0.06 / 6.0);
        assert!(
            (shape.enclosed / exact - 1.0).abs() < 0.01,
            "{}",
            shape.enclosed
        );
    }
}
