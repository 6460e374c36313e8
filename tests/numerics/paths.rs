//! The two ways to solve the linear systems of substep 2, and the two iterations, are ways to the
//! same solution; which way is taken is chosen by itself, and told.

use crate::common::{SMALL, TIGHT, fields, greatest, greatest_difference, scene, scheme};
use vesica::internal::simulation::EventKind;
use vesica::{Scene, Scheme, Simulation, StepError};

/// Steps of the comparisons.
const STEPS: usize = 8;

/// Anchoring so strong that the preconditioner of the fast path, which knows nothing of it, is of
/// no use, while the factor contains it.
const TOO_MUCH_FOR_THE_TRANSFORM: [&str; 2] = ["anchoring.weight=1e8", "time.step=1e-5"];

/// By rotation, on the axis.
const ROTATED: [&str; 3] = [
    "domain.geometry=axisymmetric",
    "vesicle.center=[0.0, 0.51]",
    "vesicle.angle=90",
];

/// In the plane and by rotation.
const GEOMETRIES: [&[&str]; 2] = [&[], &ROTATED];

fn small(groups: &[&[&str]]) -> Scene {
    scene(SMALL, &groups.concat())
}

#[track_caller]
fn advance(scheme: &mut Scheme, dt: f64) {
    for step in 1..=STEPS {
        if let Err(error) = scheme.step(dt) {
            panic!("step {step}: {error}");
        }
    }
}

/// The greatest difference of any field after a few steps, relative to the field.
#[track_caller]
fn difference(first: &Scene, second: &Scene) -> f64 {
    let mut schemes = [first, second].map(scheme);
    for scheme in &mut schemes {
        advance(scheme, first.time.step);
        assert!(scheme.report().fallback.is_none());
    }
    let [first, second] = schemes.each_ref().map(|scheme| fields(scheme.state()));
    let differences: Vec<f64> = first
        .iter()
        .zip(&second)
        .map(|((_, a), (_, b))| greatest_difference(a, b) / greatest(a))
        .collect();
    println!("{differences:?}");
    greatest(&differences)
}

#[test]
fn transform_and_factor_give_the_same_trajectory() {
    for geometry in GEOMETRIES {
        for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
            for step in ["time.step=1e-8", "time.step=1e-6", "time.step=1e-4"] {
                for (tolerances, bound) in [(&TIGHT[..], 1e-9), (&[][..], 1e-5)] {
                    let solved_by =
                        |method| small(&[tolerances, geometry, &[quadrature, step, method]]);
                    let transform = solved_by("solver.linear=transform");
                    let factor = solved_by("solver.linear=factor");
                    let difference = difference(&transform, &factor);
                    assert!(
                        difference < bound,
                        "{geometry:?} {quadrature} {step} {tolerances:?}: {difference:e}"
                    );
                }
            }
        }
    }
}

/// Eigenvectors of the operator with the weight r do by rotation what cosines do in the plane: a step takes at most 1.3 times
/// the iterations.
#[test]
fn the_transform_takes_as_many_iterations_by_rotation() {
    let finer = ["mesh.cells=32", "membrane.interface_width=0.03"];
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        for step in ["time.step=1e-7", "time.step=1e-6"] {
            let [planar, rotated] = GEOMETRIES.map(|geometry| {
                let scene = small(&[geometry, &finer, &[quadrature, step]]);
                let mut scheme = scheme(&scene);
                let mut iterations = 0;
                for number in 0..2 * STEPS {
                    assert!(scheme.uses_transform());
                    let report = scheme.step(scene.time.step).expect("solved");
                    if number >= STEPS {
                        iterations += report.krylov;
                    }
                }
                iterations
            });
            println!("{quadrature} {step}: {planar}, {rotated}");
            assert!(
                10 * rotated <= 13 * planar,
                "{quadrature} {step}: {planar}, {rotated}"
            );
        }
    }
}

/// On a grid, on one that is distorted, and on triangles; at Δt where two of the three shifts are
/// complex, too.
#[test]
fn shifted_laplacians_and_factor_give_the_same_trajectory() {
    let triangles = &["mesh.kind=delaunay", "mesh.size=0.07"][..];
    for mesh in [&[][..], &["mesh.jitter=0.3"], triangles] {
        for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
            for step in ["time.step=1e-8", "time.step=1e-6", "time.step=1e-4"] {
                for (tolerances, bound) in [(&TIGHT[..], 1e-9), (&[][..], 1e-5)] {
                    let solved_by =
                        |method| small(&[tolerances, mesh, &[quadrature, step, method]]);
                    let shifted = solved_by("solver.linear=shifted");
                    let factor = solved_by("solver.linear=factor");
                    let difference = difference(&shifted, &factor);
                    assert!(
                        difference < bound,
                        "{mesh:?} {quadrature} {step} {tolerances:?}: {difference:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn newton_and_the_lagged_iteration_have_the_same_fixed_point() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        for method in ["solver.linear=transform", "solver.linear=factor"] {
            let solved_by = |iteration| small(&[&TIGHT, &[quadrature, method, iteration]]);
            let newton = solved_by("solver.iteration=newton");
            let lagged = solved_by("solver.iteration=lagged");
            let difference = difference(&newton, &lagged);
            assert!(difference < 1e-9, "{quadrature} {method}: {difference:e}");
        }
    }
}

/// (4.35) leaves out parts of the derivative: it must need more iterations, or it is not what is run.
#[test]
fn the_lagged_iteration_is_another_iteration() {
    let [newton, lagged] =
        ["solver.iteration=newton", "solver.iteration=lagged"].map(|iteration| {
            let mut scheme = scheme(&small(&[&TIGHT, &[iteration]]));
            advance(&mut scheme, 1e-6);
            scheme.report().newton
        });
    assert!(lagged > newton, "{lagged} and {newton} iterations");
}

#[test]
fn the_transform_is_taken_where_it_applies() {
    for (settings, method) in [
        (&[][..], "transform"),
        (&["solver.linear=transform"], "transform"),
        (&["solver.linear=shifted"], "shifted"),
        (&["solver.linear=factor"], "factor"),
        (&["domain.boundary=clamped"], "factor"),
        (&["mesh.jitter=0.2"], "shifted"),
        (&["mesh.jitter=0.2", "domain.boundary=clamped"], "factor"),
        (&["mesh.kind=delaunay", "mesh.size=0.08"], "shifted"),
        (&ROTATED, "transform"),
        (&[&ROTATED[..], &["mesh.jitter=0.2"]].concat(), "shifted"),
    ] {
        let mut scheme = scheme(&small(&[settings]));
        assert_eq!(scheme.linear_method(), method, "{settings:?}");
        assert_eq!(scheme.uses_transform(), method == "transform");
        advance(&mut scheme, 1e-6);
        assert_eq!(scheme.linear_method(), method, "{settings:?}");
    }
}

/// The automatic choice goes on with the factor where the transform fails, says so once, and leaves
/// no trace of the failed attempt in the solution.
#[test]
fn the_factor_takes_over_and_this_is_an_event() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        let hard = |more: &[&str]| small(&[&TOO_MUCH_FOR_THE_TRANSFORM, &[quadrature], more]);
        let mut simulation = Simulation::new(&hard(&[])).expect("a simulation");
        assert_eq!(simulation.linear_method(), "transform");
        let mut falls = Vec::new();
        for _ in 0..3 {
            if let Err(error) = simulation.advance() {
                panic!("{quadrature}: {error}");
            }
            for event in simulation.drain_events() {
                if let EventKind::FellBackToFactor { reason } = &event.kind {
                    assert!(matches!(
                        reason,
                        StepError::NotConverged { .. } | StepError::Membrane { .. }
                    ));
                    falls.push((event.step, event.kind.name()));
                }
            }
        }
        assert_eq!(falls, [(1, "fell-back-to-factor")]);
        assert_eq!(simulation.linear_method(), "factor");

        let factor = hard(&["solver.linear=factor"]);
        let mut from_the_start = scheme(&factor);
        for _ in 0..3 {
            from_the_start.step(factor.time.step).expect("solved");
        }
        let pairs = fields(simulation.state());
        for ((name, a), (_, b)) in pairs.into_iter().zip(fields(from_the_start.state())) {
            let difference = greatest_difference(a, b) / greatest(a);
            assert!(difference < 1e-7, "{name}: {difference:e}");
        }
    }
}

/// What the user has asked for is not replaced: without the automatic choice the failure is the
/// step's error, and the state stays what it was.
#[test]
fn the_transform_alone_fails_with_a_reason() {
    let scene = small(&[&TOO_MUCH_FOR_THE_TRANSFORM, &["solver.linear=transform"]]);
    let mut scheme = scheme(&scene);
    let (state, report) = (scheme.state().clone(), scheme.report().clone());
    let error = scheme.step(scene.time.step).expect_err("too hard");
    assert!(
        matches!(
            error,
            StepError::NotConverged { .. } | StepError::Membrane { .. }
        ),
        "{error}"
    );
    assert!(scheme.uses_transform());
    assert_eq!((scheme.state(), scheme.report()), (&state, &report));
}
