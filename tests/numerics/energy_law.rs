//! The discrete energy law (3.26), an identity: solved tightly it closes to rounding for every
//! combination of effects, quadrature, boundary, mesh and Δt. (That wrong constants and wrong
//! secants break it is shown in tests/wrong_effects.)

use crate::common::{SMALL, TIGHT, energy_scale, named, scene, scheme};
use vesica::{Scene, Scheme, StepReport};

const BOUNDARIES: [&str; 2] = ["natural", "clamped"];
const CURVATURES: [&str; 3] = ["0.0", "1.5", "'2*sin(3*x) - y'"];
const JITTERS: [f64; 2] = [0.0, 0.2];
const TIME_STEPS: [f64; 4] = [1e-9, 1e-7, 1e-5, 1e-3];
const STEPS: usize = 4;

/// What is asked of law_residual.
const LAW: f64 = 1e-12;
/// Of each Δt·ND/S: at least minus this.
const DISSIPATION: f64 = 1e-14;
/// Of ∫φ.
const CONSERVED: f64 = 1e-13;

/// The terms of the ledger that every scene has, then those of each effect.
const COMMON_TERMS: [&str; 3] = ["dE", "membrane_mobility", "ND_omega"];
const NEMATIC_TERMS: [&str; 4] = ["director_mobility", "ND_elast", "ND_penal", "ND_interp"];
const ANCHORING_TERMS: [&str; 1] = ["ND_anch"];

/// What there is besides the membrane.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Inside {
    Nothing,
    Nematic,
    Anchored(&'static str),
}

impl Inside {
    const ALL: [Self; 4] = [
        Self::Nothing,
        Self::Nematic,
        Self::Anchored("parallel"),
        Self::Anchored("homeotropic"),
    ];

    /// |d⁰| = 1.5 and no two neighbours alike, so that every term of the ledger is at work.
    fn settings(self) -> Vec<String> {
        let director = "nematic.initial={ kind = 'random', seed = 3, length = 1.5 }".to_owned();
        match self {
            Self::Nothing => vec!["anchoring=false".to_owned(), "nematic=false".to_owned()],
            Self::Nematic => vec![director, "anchoring.kind=none".to_owned()],
            Self::Anchored(kind) => vec![director, format!("anchoring.kind={kind}")],
        }
    }

    fn terms(self) -> Vec<&'static str> {
        match self {
            Self::Nothing => COMMON_TERMS.to_vec(),
            Self::Nematic => [&COMMON_TERMS[..], &NEMATIC_TERMS].concat(),
            Self::Anchored(_) => [&COMMON_TERMS[..], &NEMATIC_TERMS, &ANCHORING_TERMS].concat(),
        }
    }
}

/// Takes the steps of a scene and checks all that (3.26) says of them.
#[track_caller]
fn check(inside: Inside, settings: &[String]) {
    let scene = scene(SMALL, &[&inside.settings(), settings].concat());
    let mut scheme = scheme(&scene);
    let start = scheme.report().phase_integral;
    for step in 1..=STEPS {
        let before = scheme.report().total_energy;
        let place = format!("step {step} with {inside:?}, {settings:?}");
        let report = match scheme.step(scene.time.step) {
            Ok(report) => report.clone(),
            Err(error) => panic!("{place}: {error}"),
        };
        assert_eq!(report.fallback, None, "{place}");
        check_report(&report, before, &place);
        let drift = report.phase_integral - start;
        assert!(drift.abs() <= CONSERVED, "{place}: A by {drift:e}");
        check_mobility(&scheme, &scene, &place);
        let mut names: Vec<&str> = report.ledger.iter().map(|term| term.name).collect();
        let mut expected = inside.terms();
        names.sort_unstable();
        expected.sort_unstable();
        assert_eq!(names, expected, "{place}");
    }
}

#[track_caller]
fn check_report(report: &StepReport, energy_before: f64, place: &str) {
    let scale = energy_scale(report);
    let residual = report.law_residual;
    assert!(residual.abs() <= LAW, "{place}: law_residual {residual:e}");

    let total: f64 = report.energies.iter().map(|energy| energy.value).sum();
    assert_eq!(total, report.total_energy, "{place}");
    let rise = report.total_energy - energy_before;
    assert_eq!(rise, named(&report.ledger, "dE"), "{place}");
    let allowed = (residual.abs() + DISSIPATION) * scale;
    assert!(rise <= allowed, "{place}: E rises by {rise:e}");

    for term in report.ledger.iter().filter(|term| term.name != "dE") {
        assert!(
            term.value >= -DISSIPATION * scale,
            "{place}: {} is {:e}",
            term.name,
            term.value
        );
    }
}

/// Δt γ_ben ‖∇μ‖² is taken from the state, and without it the law would not close.
#[track_caller]
fn check_mobility(scheme: &Scheme, scene: &Scene, place: &str) {
    let report = scheme.report();
    let booked = named(&report.ledger, "membrane_mobility");
    let square = scheme
        .space()
        .stiffness()
        .quadratic_form(&scheme.state().mu);
    let value = scene.time.step * scene.membrane.mobility * square;
    assert!((booked - value).abs() <= 1e-14 * value, "{place}: {booked}");
    assert!(booked > LAW * energy_scale(report), "{place}: {booked:e}");
}

fn check_all(quadrature: &str, inside: Inside) {
    for boundary in BOUNDARIES {
        for curvature in CURVATURES {
            for jitter in JITTERS {
                for step in TIME_STEPS {
                    let settings = [
                        TIGHT[0].to_owned(),
                        TIGHT[1].to_owned(),
                        format!("solver.quadrature={quadrature}"),
                        format!("domain.boundary={boundary}"),
                        format!("membrane.spontaneous_curvature={curvature}"),
                        format!("mesh.jitter={jitter}"),
                        format!("time.step={step:e}"),
                    ];
                    check(inside, &settings);
                }
            }
        }
    }
}

#[test]
fn the_law_closes_with_the_consistent_quadrature() {
    for inside in Inside::ALL {
        check_all("consistent", inside);
    }
}

#[test]
fn the_law_closes_with_the_lumped_quadrature() {
    for inside in Inside::ALL {
        check_all("lumped", inside);
    }
}

/// Each term of the ledger is of a size that the law would miss: no check above is empty.
#[test]
fn every_term_is_at_work() {
    for quadrature in ["consistent", "lumped"] {
        let inside = Inside::Anchored("homeotropic");
        let mut settings = inside.settings();
        settings.extend(TIGHT.map(str::to_owned));
        settings.push(format!("solver.quadrature={quadrature}"));
        let mut scheme = scheme(&scene(SMALL, &settings));
        let report = scheme.step(1e-5).expect("a solved step");
        for name in inside.terms() {
            let share = named(&report.ledger, name).abs() / energy_scale(report);
            assert!(share > 1e6 * LAW, "{quadrature} {name}: {share:e}");
        }
    }
}

/// The residual measures the algebraic error: where the equations are solved loosely it says so, in
/// the same scene that closes to rounding above. It is the sum of the ledger over S, the larger one
/// of the step's two ends.
#[test]
fn a_loosely_solved_step_misses_the_law() {
    for quadrature in ["consistent", "lumped"] {
        let settings = [
            format!("solver.quadrature={quadrature}"),
            "solver.tolerance=1.0".to_owned(),
            "solver.law_tolerance=1.0".to_owned(),
            "time.step=1e-5".to_owned(),
        ];
        let mut scheme = scheme(&scene(SMALL, &settings));
        let before = energy_scale(scheme.report());
        let report = scheme.step(1e-5).expect("a step solved loosely");
        let residual = report.law_residual;
        assert!(residual.abs() > 1e3 * LAW, "{quadrature}: {residual:e}");
        let sum: f64 = report.ledger.iter().map(|term| term.value).sum();
        let expected = sum / energy_scale(report).max(before);
        assert!(
            (residual - expected).abs() < 1e-15,
            "{quadrature}: {residual:e}, {expected:e}"
        );
    }
}

/// ∫φ is kept to rounding by each linear solve, not by solving tightly: with the tolerances that a
/// scene has by itself, and with none.
#[test]
fn a_loosely_solved_step_keeps_the_volume() {
    for quadrature in ["consistent", "lumped"] {
        for path in [
            "solver.linear=transform",
            "solver.linear=factor",
            "solver.iteration=lagged",
            "domain.boundary=clamped",
            "mesh.jitter=0.2",
        ] {
            for tolerances in [
                &[][..],
                &["solver.tolerance=1.0", "solver.law_tolerance=1.0"],
            ] {
                let quadrature = format!("solver.quadrature={quadrature}");
                let settings = [&[&quadrature, path][..], tolerances].concat();
                let mut scheme = scheme(&scene(SMALL, &settings));
                let start = scheme.report().phase_integral;
                for step in 1..=20 {
                    let drift = match scheme.step(1e-6) {
                        Ok(report) => report.phase_integral - start,
                        Err(error) => panic!("step {step} with {settings:?}: {error}"),
                    };
                    assert!(
                        drift.abs() <= CONSERVED,
                        "step {step} with {settings:?}: A by {drift:e}"
                    );
                }
            }
        }
    }
}
