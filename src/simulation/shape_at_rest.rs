//! The shape at rest that the sharp-interface theory foresees for a scene.

use crate::fem::{Contour, Mesh, Pieces, center_and_axis};
use crate::geometry::{BoundingBox, Point, Vector};
use crate::scene::{Geometry, ScalarField, Scene};
use crate::theory::{
    self, AreaPenalty, BodyAtRest, Branch, ClosedSurfaceError, CurveAtRest, ElasticaError,
    ShapeAtRest,
};
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
    /// Its membrane is not closed.
    #[error(
        "the theory of the shape at rest is of a closed membrane, and this vesicle is cut by the wall"
    )]
    AtWall,
    /// Its energy has another form.
    #[error(
        "the theory of the shape at rest is of a membrane without spontaneous curvature: try it with \
         --set membrane.spontaneous_curvature=0"
    )]
    SpontaneousCurvature,
    /// Of bodies of rotation the theory knows those that are one with a sphere.
    #[error(
        "the theory of the shape at rest is of a vesicle that the axis of rotation passes through, in at one pole and out at the other; here \
         it meets the membrane {crossings} times"
    )]
    OffAxis {
        /// How often the membrane meets the axis.
        crossings: usize,
    },
    /// There is no such surface.
    #[error(transparent)]
    ClosedSurface(#[from] ClosedSurfaceError),
    /// There is no such curve.
    #[error(transparent)]
    Elastica(#[from] ElasticaError),
}

/// The shape at rest of the membrane of a scene as if it were alone: without nematic and outer fields. `phi` is any state of
/// the run; A = ∫φ⁰ and B(φ⁰) are those of the initial state. By rotation it is on the branch that the state is like.
///
/// # Errors
/// [`NoShapeAtRest`].
pub fn shape_at_rest(
    scene: &Scene,
    (mesh, phi): (&Mesh, &[f64]),
    [phase_integral, surface_area]: [f64; 2],
) -> Result<ShapeAtRest, NoShapeAtRest> {
    if scene.membrane.spontaneous_curvature != ScalarField::Constant(0.0) {
        return Err(NoShapeAtRest::SpontaneousCurvature);
    }
    let vesicles = Pieces::default().find(mesh, phi);
    if vesicles != 1 {
        return Err(NoShapeAtRest::Vesicles { vesicles });
    }
    let at_wall = mesh.on_boundary().iter().zip(mesh.on_axis());
    let at_wall = at_wall.map(|(on_wall, on_axis)| *on_wall && !on_axis);
    if at_wall.zip(phi).any(|(at_wall, phi)| at_wall && *phi > 0.0) {
        return Err(NoShapeAtRest::AtWall);
    }
    let penalty = scene.area.map(|area| AreaPenalty {
        target: area.target * surface_area,
        penalty: area.penalty,
    });
    let enclosed = enclosed(mesh, phase_integral);
    Ok(match mesh.geometry() {
        Geometry::Planar => ShapeAtRest::Curve(CurveAtRest::new(enclosed, penalty)?),
        Geometry::Axisymmetric => {
            let branch = branch_of(mesh, phi)?;
            ShapeAtRest::Body(BodyAtRest::new(branch, enclosed, penalty)?)
        }
    })
}

/// The branch that a vesicle is like, and whether it is a cup that is open downwards.
fn branch_of(mesh: &Mesh, phi: &[f64]) -> Result<(Branch, bool), NoShapeAtRest> {
    let contour = Contour::new(mesh, phi);
    let poles = contour.poles();
    let [one, other] = poles[..] else {
        return Err(NoShapeAtRest::OffAxis {
            crossings: poles.len(),
        });
    };
    let extent = BoundingBox::around(contour.segments.iter().flatten());
    let heights = [extent.lower.y, extent.upper.y];
    let branch = Branch::of_extents([one, other], heights, extent.upper.x);
    Ok((branch, one + other > heights[0] + heights[1]))
}

/// The curve of a shape at rest beside the vesicle of a state: about its centre and along it, or along the axis of rotation.
pub fn outline_beside(shape: &ShapeAtRest, mesh: &Mesh, phi: &[f64]) -> Vec<Point> {
    let (center, axis) = match shape {
        ShapeAtRest::Curve(_) => center_and_axis(mesh, phi),
        ShapeAtRest::Body(_) => {
            let contour = Contour::new(mesh, phi);
            let extent = BoundingBox::around(contour.segments.iter().flatten());
            let middle = 0.5 * (extent.lower.y + extent.upper.y);
            (Point::new(0.0, middle), Vector::y())
        }
    };
    shape.outline(center, axis)
}

/// (|Ω| + ∫φ)/2: the area inside of a membrane where φ jumps from −1 to 1, or the volume.
fn enclosed(mesh: &Mesh, phase_integral: f64) -> f64 {
    0.5 * (mesh.measures().iter().sum::<f64>() + phase_integral)
}

/// The area inside of a membrane; by rotation that of the great circle of the sphere with its volume.
pub fn enclosed_area(mesh: &Mesh, phase_integral: f64) -> f64 {
    let enclosed = enclosed(mesh, phase_integral);
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
        let cut = of(&["vesicle={ shape = 'circle', radius = 0.2, center = [0, 0.5] }"]);
        assert_eq!(cut, Err(NoShapeAtRest::AtWall));
        let ring = "vesicle={ shape = 'circle', radius = 0.15, center = [0.5, 0.5] }";
        let ring = of(&[
            "domain.geometry=axisymmetric",
            "nematic.initial=[0, 1]",
            ring,
        ]);
        assert_eq!(ring, Err(NoShapeAtRest::OffAxis { crossings: 0 }));
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
        let ShapeAtRest::Curve(shape) = shape else {
            panic!("in the plane: {shape:?}");
        };
        let pi = std::f64::consts::PI;
        let exact = pi * (0.09 + pi * pi * 0.06 * 0.06 / 6.0);
        assert!(
            (shape.enclosed / exact - 1.0).abs() < 0.01,
            "{}",
            shape.enclosed
        );
    }

    /// By rotation the shape is on the branch of the vesicle, about its volume and beside it.
    #[test]
    fn a_body_of_rotation_rests_on_the_branch_that_it_is_like() {
        let cup = "{ shape = 'stomatocyte', radius = 0.29, thickness = 0.2, opening = 75, center = [0.0, 0.53], angle = ANGLE }";
        let ellipse = |r: f64, z: f64| {
            format!("{{ shape = 'ellipse', half_axes = [{r}, {z}], center = [0.0, 0.5] }}")
        };
        for (vesicle, branch, is_turned) in [
            (ellipse(0.2, 0.4), Branch::Prolate, false),
            (ellipse(0.6, 0.3), Branch::Oblate, false),
            (cup.replace("ANGLE", "0"), Branch::Stomatocyte, false),
            (cup.replace("ANGLE", "180"), Branch::Stomatocyte, true),
        ] {
            let scene = small(&[
                "domain.geometry=axisymmetric",
                "nematic.initial=[0, 1]",
                "mesh.cells=60",
                "membrane.interface_width=0.02",
                "area={ target = 1.0, penalty = 1e-4 }",
                &format!("vesicle={vesicle}"),
            ]);
            let simulation = Simulation::new(&scene).expect("a small scene");
            let report = simulation.report();
            let (mesh, phi) = (simulation.mesh(), &simulation.state().phi);
            let start = [report.phase_integral, report.surface_area];
            let shape = shape_at_rest(&scene, (mesh, phi), start).expect("a body");
            let ShapeAtRest::Body(body) = &shape else {
                panic!("in space: {shape:?}");
            };
            assert_eq!(
                (body.branch, body.is_turned),
                (branch, is_turned),
                "{vesicle}"
            );
            let contour = Contour::new(mesh, phi);
            let reduced_volume = contour.reduced_size().expect("there is a vesicle");
            let v = body.surface.reduced_volume;
            assert!(
                (v / reduced_volume - 1.0).abs() < 0.03,
                "{vesicle}: {v} {reduced_volume}"
            );
            // The outlines lie near to one another.
            let outline = outline_beside(&shape, mesh, phi);
            let extent = BoundingBox::around(&outline);
            let own = BoundingBox::around(contour.segments.iter().flatten());
            for (theory, own) in [
                (extent.lower.y, own.lower.y),
                (extent.upper.y, own.upper.y),
                (extent.upper.x, own.upper.x),
                (-extent.lower.x, own.upper.x),
            ] {
                assert!((theory - own).abs() < 0.06, "{vesicle}: {theory} {own}");
            }
        }
    }
}
