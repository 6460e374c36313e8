//! Negative controls on the whole scheme: effects with a wrong secant or a wrong constant, written as
//! anyone outside could write them, and what the energy law makes of them.
//!
//! A scheme compares energies from its construction on, so an effect that is put in afterwards is
//! given the energy of what it replaces (or zero) at the start: a constant, which no force sees.

mod nematic;
mod noise;
mod well;

use self::nematic::Nematic;
use self::noise::Booked;
use self::well::{Secant, Well};
use crate::common::{SMALL, TIGHT, energy_scale, named, scene, scheme};
use vesica::internal::physics::potentials::{
    double_well_derivative, double_well_secant, double_well_secant_derivative, unit_length_penalty,
    unit_length_penalty_derivative,
};
use vesica::internal::physics::{Anchoring, Area, Bending, Effects, surface_area};
use vesica::{Effect, PatchFields, Room, Scene, Scheme, StepError, Vector};

/// η_d² P(d) = ¼(|d|² − 1)² for all d.
fn untruncated(d: Vector) -> f64 {
    0.25 * (d.norm_squared() - 1.0).powi(2)
}

fn untruncated_slope(d: Vector) -> Vector {
    (d.norm_squared() - 1.0) * d
}

/// F_sec with its derivative, and what is none: F'.
const RIGHT: Secant = [double_well_secant, double_well_secant_derivative];
const DERIVATIVE: Secant = [
    |phi, _| double_well_derivative(phi),
    |phi, _| 3.0 * phi * phi - 1.0,
];

/// A scheme of the small vesicle with a well, whose secant is right.
pub fn with_right_well(settings: &[&str]) -> Scheme {
    with_well(settings, [RIGHT; 2])
}

/// The same with a secant that is wrong in the secant scheme alone.
pub fn with_well_that_goes_wrong(settings: &[&str]) -> Scheme {
    with_well(settings, [RIGHT, DERIVATIVE])
}

/// The effect of this file in the place of the library's, with the forces of first order in both schemes.
pub fn with_own_nematic(settings: &[&str]) -> Scheme {
    with_nematic(settings, |scene| {
        Nematic::new(
            scene,
            1.0,
            unit_length_penalty,
            unit_length_penalty_derivative,
        )
    })
}

fn with_well(settings: &[&str], secants: [Secant; 2]) -> Scheme {
    let mut scheme = scheme(&scene(SMALL, &[&TIGHT[..], settings].concat()));
    let well = Well::new(secants, scheme.space(), &scheme.state().phi);
    scheme.effects_mut().add(well);
    scheme.forget();
    scheme
}

const QUADRATURES: [&str; 2] = ["solver.quadrature=consistent", "solver.quadrature=lumped"];

#[test]
fn an_effect_from_outside_with_a_right_secant_keeps_the_law() {
    for quadrature in QUADRATURES {
        let mut scheme = with_right_well(&[quadrature]);
        for step in 1..=3 {
            let report = match scheme.step(1e-6) {
                Ok(report) => report,
                Err(error) => panic!("{quadrature} step {step}: {error}"),
            };
            assert!(report.law_residual.abs() <= 1e-12);
            assert!(named(&report.energies, "well").abs() > 1e-3);
        }
    }
}

/// F'(φ) in place of F_sec: the step is solved, what it solves is not the scheme, and it is refused.
#[test]
fn a_wrong_secant_breaks_the_law() {
    for quadrature in QUADRATURES {
        let mut scheme = with_well(&[quadrature], [DERIVATIVE, RIGHT]);
        let state = scheme.state().clone();
        let error = scheme.step(1e-6).expect_err("the law is broken");
        let StepError::LawBroken {
            residual,
            tolerance,
        } = error
        else {
            panic!("{quadrature}: {error}");
        };
        assert_eq!(tolerance, 1e-12);
        assert!(residual.abs() > 1e-9, "{quadrature}: {residual:e}");
        assert_eq!(scheme.state(), &state, "a refused step leaves no trace");
    }
}

/// A scheme with |d⁰| = 3 where `nematic` takes the place of the library's effect.
fn with_nematic(settings: &[&str], nematic: impl FnOnce(&Scene) -> Nematic) -> Scheme {
    let long = ["nematic.initial=[1.8, 2.4]"];
    let scene = scene(SMALL, &[&TIGHT[..], settings, &long].concat());
    let mut scheme = scheme(&scene);
    let (space, state) = (scheme.space(), scheme.state());
    let mut start = PatchFields::new(true);
    start.set_phi(&space.whole(), &state.phi);
    start.set_director(&space.whole(), state.director.as_ref().expect("a director"));
    let mut nematic = nematic(&scene);
    let energy = nematic.integral(&space.whole(), &start, &mut Room::default());
    nematic.offset = energy - named(&scheme.report().energies, "nematic");
    let mut effects = Effects::new(Bending::new(&scene.membrane, space));
    let width = scene.membrane.interface_width;
    effects.add(Area::new(
        &scene.area.expect("an area"),
        width,
        surface_area(space, &state.phi, width),
    ));
    effects.add(nematic);
    effects.add(Anchoring::new(&scene.anchoring.expect("anchoring")));
    *scheme.effects_mut() = effects;
    scheme.forget();
    scheme
}

/// The greatest Δt·ND_penal/S and the least over a few steps, in which the law closes.
#[track_caller]
fn penalty_dissipation(mut scheme: Scheme) -> [f64; 2] {
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for step in 1..=3 {
        let report = match scheme.step(1e-6) {
            Ok(report) => report,
            Err(error) => panic!("step {step}: {error}"),
        };
        // The identity holds for any p_Δt: it is the sign that tells.
        assert!(report.law_residual.abs() <= 1e-12);
        let share = named(&report.ledger, "ND_penal") / energy_scale(report);
        range = [range[0].max(share), range[1].min(share)];
    }
    range
}

/// The effect written here is the library's where its constants are right.
#[test]
fn the_control_is_the_librarys_effect_when_it_is_right() {
    for quadrature in QUADRATURES {
        let settings = [quadrature, "nematic.initial=[1.8, 2.4]"];
        let mut library = scheme(&scene(SMALL, &[&TIGHT[..], &settings].concat()));
        let mut control = with_own_nematic(&[quadrature]);
        for _ in 0..3 {
            let [first, second] = [&mut library, &mut control]
                .map(|scheme| scheme.step(1e-6).expect("a solved step").clone());
            let scale = energy_scale(&first);
            for (a, b) in first.ledger.iter().zip(&second.ledger) {
                assert_eq!(a.name, b.name);
                let difference = (a.value - b.value).abs() / scale;
                assert!(
                    difference < 1e-12,
                    "{quadrature} {}: {difference:e}",
                    a.name
                );
            }
        }
    }
}

/// The constant of p_Δt is sharp: with 1/η_d² ND_penal ≥ 0 (and > 0 only where |d| < 1 or d turns),
/// with less it is negative where |d| > 1.
#[test]
fn a_smaller_constant_makes_the_penalty_feed_energy() {
    for quadrature in QUADRATURES {
        let penalty = |convexity| {
            penalty_dissipation(with_nematic(&[quadrature], |scene| {
                Nematic::new(
                    scene,
                    convexity,
                    unit_length_penalty,
                    unit_length_penalty_derivative,
                )
            }))
        };
        let [_, least] = penalty(1.0);
        assert!(least >= -1e-14, "{quadrature}: {least:e}");
        for convexity in [0.5, 0.9] {
            let [greatest, _] = penalty(convexity);
            assert!(greatest < -1e-9, "{quadrature} {convexity}: {greatest:e}");
        }
    }
}

/// With P and its gradient both untruncated the law closes as well, and the same constant is too
/// small.
#[test]
fn the_untruncated_potential_feeds_energy() {
    for quadrature in QUADRATURES {
        let [greatest, _] = penalty_dissipation(with_nematic(&[quadrature], |scene| {
            Nematic::new(scene, 1.0, untruncated, untruncated_slope)
        }));
        assert!(greatest < -1e-9, "{quadrature}: {greatest:e}");
    }
}

/// Noise of which the books have a part of the work, as it is or with this factor.
#[test]
fn noise_whose_work_is_not_in_the_books_breaks_the_law() {
    for quadrature in QUADRATURES {
        for share in [1.0, 0.99, 1.01, 0.0] {
            let settings = [&TIGHT[..], &[quadrature]].concat();
            let mut scheme = scheme(&scene(SMALL, &settings));
            scheme.effects_mut().add(Booked::new(share));
            let outcome = scheme
                .step(1e-6)
                .map(|report| report.law_residual.abs() <= 1e-12);
            match outcome {
                Ok(closes) => assert!(closes && share == 1.0, "{quadrature} {share}"),
                Err(StepError::LawBroken { residual, .. }) => {
                    assert!(
                        share != 1.0 && residual.abs() > 1e-6,
                        "{share} {residual:e}"
                    );
                }
                Err(error) => panic!("{quadrature} {share}: {error}"),
            }
        }
    }
}
