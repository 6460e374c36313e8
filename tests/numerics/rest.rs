//! A state at rest to rounding is left as it is, in every way of solving a step: its fields are zero but for
//! rounding, and no iteration makes anything of that.

use std::f64::consts::PI;

use crate::common::{greatest, mesh, scene};
use vesica::{Scene, Scheme};

const TEXT: &str = "
    vesicle = { shape = 'circle', radius = 0.25 }
    membrane = { interface_width = 0.05 }
";

const MESHES: [&str; 3] = [
    "mesh.cells=6",
    "mesh={ cells = 6, jitter = 0.6, seed = 3 }",
    "mesh={ kind = 'delaunay', size = 0.2 }",
];

const EFFECTS: [&[&str]; 3] = [
    &[],
    &[
        "membrane.spontaneous_curvature=50",
        "area={ target = 1.25 }",
    ],
    &["nematic={ initial = [0.6, 0.8] }", "anchoring={}"],
];

/// A scheme whose φ is given, with a director where the scene has one.
fn scheme(scene: &Scene, phi: impl Fn(usize) -> f64) -> Scheme {
    let mesh = mesh(scene);
    let nodes = mesh.nodes().len();
    let director = scene.nematic.is_some();
    let director = director.then(|| [vec![0.6; nodes], vec![0.8; nodes]]);
    Scheme::new(scene, mesh, (0..nodes).map(phi).collect(), director).expect("a scheme")
}

fn check(settings: &[&str]) {
    let scene = scene(TEXT, settings);
    // Every other node off by rounding.
    let rounded = |phi: f64| move |node: usize| phi * (1.0 - f64::EPSILON * (node % 3) as f64);
    for phi in [-1.0, 1.0] {
        for is_exact in [true, false] {
            let mut scheme = if is_exact {
                scheme(&scene, |_| phi)
            } else {
                scheme(&scene, rounded(phi))
            };
            let start = scheme.state().clone();
            let energy = scheme.report().total_energy;
            assert!(energy.abs() < 1e-15, "{settings:?} {phi}: {energy:e}");
            for dt in [1e-7, 1e-3, 1.0, 1e-3, 1.0] {
                let place = format!("{settings:?}, phi = {phi}, exact: {is_exact}, {dt:e}");
                if let Err(error) = scheme.step(dt) {
                    panic!("{place}: {error}");
                }
                let report = scheme.report();
                assert!(report.newton == 0 && report.damping == 1.0, "{place}");
                assert!(report.law_residual.abs() <= 1e-8, "{place}");
                assert!(
                    report.total_energy <= energy,
                    "{place}: {:e}",
                    report.total_energy
                );
                assert_eq!(scheme.state().phi, start.phi, "{place}");
                assert_eq!(scheme.state().director, start.director, "{place}");
                assert!(greatest(&scheme.state().mu) < 1e-6, "{place}");
            }
        }
    }
}

fn check_all(boundary: &str) {
    for quadrature in ["solver.quadrature=lumped", "solver.quadrature=consistent"] {
        for iteration in ["solver.iteration=newton", "solver.iteration=lagged"] {
            for mesh in MESHES {
                for effects in EFFECTS {
                    for scheme in ["time.scheme=first-order", "time.scheme=secant"] {
                        let settings = [boundary, quadrature, iteration, mesh, scheme];
                        check(&[&settings, effects].concat());
                    }
                }
            }
        }
    }
}

#[test]
fn no_membrane_stays_at_rest_with_a_natural_boundary() {
    check_all("domain.boundary=natural");
}

#[test]
fn no_membrane_stays_at_rest_with_a_clamped_boundary() {
    check_all("domain.boundary=clamped");
}

/// What is not at rest though it has no energy moves: a pull on φ = −1.
#[test]
fn a_force_without_an_energy_is_no_rest() {
    for boundary in ["natural", "clamped"] {
        let boundary = format!("domain.boundary={boundary}");
        let scene = scene(TEXT, &[MESHES[0], &boundary, "pull.potential='x*y'"]);
        let mut scheme = scheme(&scene, |_| -1.0);
        let energy = scheme.report().total_energy;
        scheme.step(1e-3).expect("a step");
        assert!(scheme.report().total_energy < energy, "{boundary}");
        let moved = scheme.state().phi.iter().map(|phi| phi + 1.0);
        assert!(
            moved.fold(0.0_f64, |most, it: f64| most.max(it.abs())) > 1e-9,
            "{boundary}"
        );
    }
}

/// What dies away comes to rest: its energy falls to nothing, in each of its steps.
#[test]
fn a_ripple_that_dies_away_comes_to_rest() {
    for boundary in ["natural", "clamped"] {
        for quadrature in ["lumped", "consistent"] {
            let settings = [
                format!("domain.boundary={boundary}"),
                format!("solver.quadrature={quadrature}"),
                MESHES[0].to_owned(),
            ];
            let scene = scene(TEXT, &settings);
            // Zero at the wall, and of the mean 0.
            let wave = |index: usize, waves: f64| (PI * waves * index as f64 / 6.0).sin();
            let mut scheme = scheme(&scene, |node| {
                1e-3 * wave(node % 7, 2.0) * wave(node / 7, 1.0) - 1.0
            });
            let mut energy = scheme.report().total_energy;
            for number in 0..80 {
                let place = format!("{boundary}, {quadrature}, step {number}");
                if let Err(error) = scheme.step(1e-4) {
                    panic!("{place}: {error}");
                }
                let report = scheme.report();
                assert!(report.total_energy <= energy, "{place}: {energy:e}");
                assert!(report.newton < 10, "{place}: {}", report.newton);
                energy = report.total_energy;
            }
            assert!(energy < 1e-18, "{boundary}, {quadrature}: {energy:e}");
        }
    }
}
