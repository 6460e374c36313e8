//! The secant midpoint scheme: its energy law is an identity without numerical dissipation, for every effect; what it
//! does not damp is damped by the steps of first order before it.

use crate::common::{SMALL, TIGHT, energy_scale, scene, scheme};
use vesica::StepError;

const SECANT: &str = "time.scheme=secant";
const QUADRATURES: [&str; 2] = ["solver.quadrature=consistent", "solver.quadrature=lumped"];

/// Each effect, and scenes without the others.
const EFFECTS: [&[&str]; 10] = [
    &[],
    &["anchoring=false", "nematic=false"],
    &["area=false", "anchoring=false", "nematic=false"],
    &["anchoring=false"],
    &["anchoring.kind=homeotropic"],
    &["membrane.spontaneous_curvature='2*sin(3*x) - y'"],
    &["field={ weight = 300, strength = 1.2, angle = 20 }"],
    &["field={ weight = -300, strength = 1.2, angle = 20 }"],
    &["pull.potential='40*x'"],
    &["noise.strength=1e-3"],
];

/// Of the first steps, which are of first order, and of those that follow.
const STARTING: usize = 2;

#[test]
fn the_law_is_an_identity_without_numerical_dissipation() {
    for quadrature in QUADRATURES {
        for boundary in ["domain.boundary=natural", "domain.boundary=clamped"] {
            for effects in EFFECTS {
                for dt in [1e-7, 1e-5] {
                    // |d| on both sides of 1, and no two neighbours alike.
                    let director = "nematic.initial={ kind = 'random', seed = 3, length = 1.2 }";
                    let with_director = !effects.contains(&"nematic=false");
                    let director = with_director.then_some(director);
                    let settings: Vec<&str> = [SECANT, quadrature, boundary]
                        .into_iter()
                        .chain(director)
                        .chain(TIGHT)
                        .chain(effects.iter().copied())
                        .collect();
                    let mut scheme = scheme(&scene(SMALL, &settings));
                    for step in 1..=STARTING + 3 {
                        let place = format!("{settings:?}, dt = {dt:e}, step {step}");
                        let before = scheme.report().total_energy;
                        let report = match scheme.step(dt) {
                            Ok(report) => report,
                            Err(error) => panic!("{place}: {error}"),
                        };
                        assert!(report.law_residual.abs() <= 1e-12, "{place}");
                        let terms = report.ledger.iter();
                        let numerical = terms.filter(|term| term.name.starts_with("ND_"));
                        let lost: f64 = numerical.map(|term| term.value).sum();
                        assert_eq!(lost != 0.0, step <= STARTING, "{place}: {lost:e}");
                        let works = report.ledger.iter().filter(|term| term.is_work());
                        let works: f64 = works.map(|term| term.value).sum();
                        let rise = report.total_energy - before + works;
                        assert!(rise <= 1e-12 * energy_scale(report), "{place}: {rise:e}");
                    }
                }
            }
        }
    }
}

/// Runs until a step is refused because its law is broken; after how many that is.
fn broken_after(mut scheme: vesica::Scheme) -> Option<usize> {
    for step in 0..STARTING + 3 {
        match scheme.step(1e-6) {
            Ok(_) => {}
            Err(StepError::LawBroken { .. }) => return Some(step),
            Err(error) => panic!("{error}"),
        }
    }
    None
}

/// An effect with the forces of first order (i_Δt and p_Δt) in place of secants. Its numerical dissipation is not in the
/// ledger of a secant step, so the law is broken.
#[test]
fn an_effect_that_knows_no_secant_breaks_the_law() {
    for quadrature in QUADRATURES {
        let with = |how: &str| crate::wrong_effects::with_own_nematic(&[quadrature, how]);
        assert_eq!(broken_after(with("time.scheme=first-order")), None);
        assert_eq!(broken_after(with(SECANT)), Some(STARTING));
    }
}

/// A derivative in place of a secant, F'(φ) for F_sec, breaks the law of both schemes.
#[test]
fn a_derivative_is_no_secant() {
    for quadrature in QUADRATURES {
        for how in ["time.scheme=first-order", SECANT] {
            let right = crate::wrong_effects::with_right_well(&[quadrature, how]);
            assert_eq!(broken_after(right), None, "{quadrature} {how}");
        }
        let wrong = crate::wrong_effects::with_well_that_goes_wrong(&[quadrature, SECANT]);
        assert_eq!(broken_after(wrong), Some(STARTING), "{quadrature}");
    }
}
