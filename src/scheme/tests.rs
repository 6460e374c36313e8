//! Faults on purpose: a value spoiled in every place of a step, in every way. Whatever it is, the step
//! either fails with an error and leaves the state as it was, or is repaired and leads to where it
//! would have led without the fault.

mod effects;
mod secant;

use super::fault_injection::Place;
use super::fault_injection::armed::{Fault, Spoiling, with_fault};
use super::{Scheme, SchemeCheckpoint, State, StepError, initial_fields};
use crate::fem::Mesh;
use crate::scene::Scene;

/// A vesicle with every effect, off the centre.
const SCENE: &str = r#"
    mesh.cells = 10
    vesicle = { shape = "ellipse", half_axes = [0.3, 0.2], center = [0.48, 0.51], angle = 70 }
    membrane.interface_width = 0.09
    area.target = 1.1
    nematic.initial = [0.6, 0.8]
    anchoring.kind = "parallel"
"#;

const DT: f64 = 1e-6;

/// Of φ's values, and of d's, against the step without a fault; solver.tolerance is 1e-5.
const NEAR: f64 = 1e-4;

const PLACES: [Place; 20] = [
    Place::DirectorLoad,
    Place::DirectorProduct,
    Place::Director(0),
    Place::Director(1),
    Place::Phi,
    Place::Omega,
    Place::Mu,
    Place::Residual,
    Place::Tangent,
    Place::Secant,
    Place::Local,
    Place::Preconditioner,
    Place::Product,
    Place::Increment,
    Place::Solved(0),
    Place::Solved(1),
    Place::Solved(2),
    Place::Solved(3),
    Place::Solved(4),
    Place::Energy,
];

const SPOILINGS: [Spoiling; 6] = [
    Spoiling::Becomes(f64::NAN),
    Spoiling::Becomes(f64::INFINITY),
    Spoiling::Becomes(f64::NEG_INFINITY),
    Spoiling::Becomes(1e300),
    Spoiling::Becomes(-1e9),
    Spoiling::Negated,
];

/// A scheme that has made a few steps.
fn scheme(settings: &[&str]) -> Scheme {
    let scene = Scene::of_text(SCENE, settings);
    let mesh = Mesh::of(&scene).expect("a mesh");
    let initial = initial_fields(&scene, &mesh).expect("fields");
    let mut scheme = Scheme::new(&scene, mesh, initial.phi, initial.director).expect("a scheme");
    for _ in 0..3 {
        scheme.step(DT).expect("a step without a fault");
    }
    scheme
}

/// The largest difference of φ and of d, over the largest value.
fn difference(a: &State, b: &State) -> f64 {
    let fields = |state: &State| -> Vec<f64> {
        let director = state.director.iter().flatten().flatten();
        state.phi.iter().chain(director).copied().collect()
    };
    let (a, b) = (fields(a), fields(b));
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let off = most(&mut a.iter().zip(&b).map(|(a, b)| (a - b).abs()));
    off / most(&mut b.iter().map(|b| b.abs()))
}

/// What is wrong with what a fault led to, in words.
fn take_step(scheme: &mut Scheme, fault: Fault, aim: &State) -> Result<bool, String> {
    let before = scheme.state().clone();
    let mut outcome = Ok(());
    let fired = with_fault(fault, || outcome = scheme.step(DT).map(|_| ()));
    if let Err(error) = outcome {
        if *scheme.state() != before {
            return Err(format!("the state has changed, in spite of: {error}"));
        }
        // Nothing of it stays behind.
        scheme
            .step(DT)
            .map_err(|error| format!("afterwards: {error}"))?;
    }
    let report = scheme.report();
    if let Some(field) = scheme.state().first_not_finite() {
        return Err(format!("{field} is not finite"));
    }
    if !report.total_energy.is_finite() || report.law_residual.abs() > 1e-8 {
        return Err(format!("the law misses by {:.1e}", report.law_residual));
    }
    let off = difference(scheme.state(), aim);
    if off > NEAR {
        return Err(format!("the step leads {off:.1e} off"));
    }
    Ok(fired > 0)
}

fn hunt(settings: &[&str]) {
    let mut scheme = scheme(settings);
    let mut start = SchemeCheckpoint::default();
    scheme.save(&mut start);
    scheme.step(DT).expect("a step without a fault");
    let aim = scheme.state().clone();
    let mut complaints = String::new();
    for place in PLACES {
        let mut fired = false;
        for spoiling in SPOILINGS {
            for (passes, lasting) in [(0, false), (1, false), (3, false), (0, true)] {
                let fault = Fault {
                    place,
                    passes,
                    lasting,
                    spoiling,
                };
                scheme.restore(&start).expect("its own");
                match take_step(&mut scheme, fault, &aim) {
                    Ok(happened) => fired |= happened,
                    Err(words) => complaints += &format!("{fault:?}: {words}\n"),
                }
            }
        }
        if !fired {
            complaints += &format!("{place:?} is not come by\n");
        }
    }
    assert!(complaints.is_empty(), "{settings:?}\n{complaints}");
}

#[test]
fn a_fault_is_caught_on_the_fast_path() {
    hunt(&["solver.quadrature=lumped"]);
    hunt(&["solver.quadrature=consistent", "solver.linear=transform"]);
    hunt(&["solver.quadrature=lumped", "time.scheme=secant"]);
}

#[test]
fn a_fault_is_caught_with_the_factor() {
    hunt(&["mesh.jitter=0.3"]);
    hunt(&["domain.boundary=clamped", "solver.quadrature=lumped"]);
}

/// What catches a solved field that is wrong but finite is the energy law.
#[test]
fn the_law_sees_a_wrong_sign() {
    for field in [0, 1, 3, 4] {
        let mut scheme = scheme(&[]);
        let fault = Fault {
            place: Place::Solved(field),
            passes: 0,
            lasting: true,
            spoiling: Spoiling::Negated,
        };
        let mut outcome = Ok(());
        with_fault(fault, || outcome = scheme.step(DT).map(|_| ()));
        let broken = matches!(outcome, Err(StepError::LawBroken { .. }));
        assert!(broken, "field {field}: {outcome:?}");
    }
}
