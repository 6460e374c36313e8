//! Symmetries that the scheme has on the structured mesh: exact but for the order of the sums.

use crate::common::{SMALL, TIGHT, greatest_difference, named, scene, scheme};
use vesica::{Scene, Scheme, State};

const STEPS: usize = 50;
const QUADRATURES: [&str; 2] = ["solver.quadrature=consistent", "solver.quadrature=lumped"];
const ENERGIES: [&str; 4] = ["bending", "area", "nematic", "anchoring"];

/// Allowed in φ and d (of size 1), and in each energy relative to E_total.
const EQUAL: f64 = 1e-12;

fn small(settings: &[&str]) -> Scene {
    scene(SMALL, &[&TIGHT[..], settings].concat())
}

#[track_caller]
fn after_steps(scene: &Scene) -> Scheme {
    let mut scheme = scheme(scene);
    for step in 1..=STEPS {
        if let Err(error) = scheme.step(scene.time.step) {
            panic!("step {step}: {error}");
        }
    }
    scheme
}

/// Nodal values where node i of the new field is node `from(i)` of the old one.
fn permuted(field: &[f64], from: impl Fn(usize) -> usize) -> Vec<f64> {
    (0..field.len()).map(|node| field[from(node)]).collect()
}

fn director(state: &State) -> &[Vec<f64>; 2] {
    state.director.as_ref().expect("a director")
}

/// In the plane d turned by a right angle is along the membrane where d is across it: parallel
/// anchoring with d⁰ = (0, 1) and homeotropic anchoring with d⁰ = (1, 0) are the same membrane, with
/// the directors turned: d = (d_x, d_y) becomes (−d_y, d_x).
#[test]
fn parallel_is_homeotropic_with_the_director_turned() {
    for quadrature in QUADRATURES {
        let parallel = small(&[
            "anchoring.kind=parallel",
            "nematic.initial=[0.0, 1.0]",
            quadrature,
        ]);
        let homeotropic = small(&[
            "anchoring.kind=homeotropic",
            "nematic.initial=[1.0, 0.0]",
            quadrature,
        ]);
        let (mut parallel, mut homeotropic) = (scheme(&parallel), scheme(&homeotropic));
        let start = parallel.state().clone();
        for step in 1..=STEPS {
            for scheme in [&mut parallel, &mut homeotropic] {
                if let Err(error) = scheme.step(1e-6) {
                    panic!("step {step}: {error}");
                }
            }
            let difference = greatest_difference(&parallel.state().phi, &homeotropic.state().phi);
            assert!(difference < EQUAL, "{quadrature} {step}: {difference:e}");
            let [first, second] = [&parallel, &homeotropic].map(Scheme::report);
            for name in ENERGIES {
                let [a, b] = [first, second].map(|report| named(&report.energies, name));
                let difference = (a - b).abs() / first.total_energy;
                assert!(
                    difference < EQUAL,
                    "{quadrature} {step}, {name}: {difference:e}"
                );
            }
        }
        let [x, y] = director(homeotropic.state());
        let turned = [y.iter().map(|y| -y).collect(), x.clone()];
        for (axis, turned) in turned.iter().enumerate() {
            let difference = greatest_difference(&director(parallel.state())[axis], turned);
            assert!(difference < EQUAL, "{quadrature} d: {difference:e}");
        }
        // All of it moves, so that the equality says something.
        assert!(greatest_difference(&parallel.state().phi, &start.phi) > 1e-2);
        for (now, start) in director(parallel.state()).iter().zip(director(&start)) {
            assert!(greatest_difference(now, start) > 1e-4);
        }
    }
}

/// The comparison above sees the anchoring: with the same d⁰ the two kinds go different ways.
#[test]
fn parallel_and_homeotropic_differ_with_the_same_director() {
    let [parallel, homeotropic] = ["parallel", "homeotropic"].map(|kind| {
        after_steps(&small(&[
            &format!("anchoring.kind={kind}"),
            "nematic.initial=[0.0, 1.0]",
        ]))
    });
    assert!(greatest_difference(&parallel.state().phi, &homeotropic.state().phi) > 1e-3);
}

/// Turning by 180° about the centre takes the mesh to itself, node i to the i-th from the end. A
/// uniform d⁰ changes its sign, which no energy sees.
#[test]
fn what_is_symmetric_under_a_half_turn_stays_so() {
    for quadrature in QUADRATURES {
        let centred = small(&["vesicle.center=[0.5, 0.5]", quadrature]);
        let scheme = after_steps(&centred);
        let state = scheme.state();
        let last = state.phi.len() - 1;
        let [x, y] = director(state);
        for field in [&state.phi, x, y] {
            let difference = greatest_difference(field, &permuted(field, |node| last - node));
            assert!(difference < EQUAL, "{quadrature}: {difference:e}");
        }
        // No symmetry is there by itself: off the centre it is gone.
        let beside = after_steps(&small(&[quadrature]));
        let phi = &beside.state().phi;
        assert!(greatest_difference(phi, &permuted(phi, |node| last - node)) > 0.1);
    }
}

/// The mesh's diagonals go from lower left to upper right: exchanging x and y takes it to itself, and
/// a scene to the one with everything in it exchanged.
#[test]
fn exchanging_x_and_y_exchanges_the_solution() {
    for quadrature in QUADRATURES {
        for boundary in ["domain.boundary=natural", "domain.boundary=clamped"] {
            let scene = |center, angle, director, curvature| {
                small(&[center, angle, director, curvature, quadrature, boundary])
            };
            let [first, second] = [
                scene(
                    "vesicle.center=[0.48, 0.51]",
                    "vesicle.angle=70",
                    "nematic.initial=[0.6, 0.8]",
                    "membrane.spontaneous_curvature='2*sin(3*x) - y'",
                ),
                scene(
                    "vesicle.center=[0.51, 0.48]",
                    "vesicle.angle=20",
                    "nematic.initial=[0.8, 0.6]",
                    "membrane.spontaneous_curvature='2*sin(3*y) - x'",
                ),
            ]
            .map(|scene| after_steps(&scene));
            let side = first.space().mesh().grid().expect("a grid").cells + 1;
            let exchanged = |node: usize| node % side * side + node / side;
            let ([x, y], [other_x, other_y]) = (director(first.state()), director(second.state()));
            for (field, other) in [
                (&first.state().phi, &second.state().phi),
                (x, other_y),
                (y, other_x),
            ] {
                let difference = greatest_difference(field, &permuted(other, exchanged));
                assert!(
                    difference < EQUAL,
                    "{quadrature} {boundary}: {difference:e}"
                );
            }
        }
    }
}

/// The same scene gives the same numbers, bit for bit.
#[test]
fn a_run_is_the_same_every_time() {
    for settings in [
        &["solver.linear=transform"][..],
        &["solver.linear=transform", "solver.quadrature=lumped"],
        &["solver.linear=factor"],
        &["domain.boundary=clamped", "mesh.jitter=0.2"],
        &["vesicle={shape='random', amplitude=0.9, seed=7}"],
    ] {
        let scene = small(settings);
        let [first, second] = [(); 2].map(|()| after_steps(&scene));
        assert_eq!(first.report(), second.report(), "{settings:?}");
        let bits = |state: &State| -> Vec<u64> {
            let fields = crate::common::fields(state).into_iter();
            fields
                .flat_map(|(_, field)| field.iter().map(|value| value.to_bits()))
                .collect()
        };
        assert_eq!(bits(first.state()), bits(second.state()), "{settings:?}");
    }
}
