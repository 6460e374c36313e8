//! What the tests of the numerics share: scenes as text, schemes made from them, numbers compared.
//!
//! Each test binary compiles its own copy and uses a part of it.
#![allow(dead_code, reason = "every test binary uses another part")]

use std::sync::Arc;

use vesica::{Mesh, NamedValue, Scene, Scheme, State, StepReport, initial_fields};

/// A small vesicle with every effect, off the centre and askew, so that no symmetry hides anything.
/// The mesh is coarse for it (h ≈ ε): identities hold on any mesh, and a step takes milliseconds.
pub const SMALL: &str = r#"
    name = "Small"
    [mesh]
    cells = 16
    [vesicle]
    shape = "ellipse"
    half_axes = [0.3, 0.2]
    center = [0.48, 0.51]
    angle = 70
    [time]
    step = 1e-6
    end = 1e-5
    [membrane]
    interface_width = 0.06
    [area]
    target = 1.1
    [nematic]
    initial = [0.6, 0.8]
    [anchoring]
    kind = "parallel"
"#;

/// Solved as tightly as rounding allows.
pub const TIGHT: [&str; 2] = ["solver.tolerance=1e-10", "solver.law_tolerance=1e-12"];

/// The scene of a text with arguments `KEY=VALUE`.
#[track_caller]
pub fn scene<S: AsRef<str>>(text: &str, settings: &[S]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|s| s.as_ref().to_owned()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(text, "the test", &settings, &mut no_files).expect("a scene")
}

/// The mesh of a scene.
pub fn mesh(scene: &Scene) -> Arc<Mesh> {
    Mesh::of(scene).expect("a fair mesh")
}

/// The scheme of a scene at its initial state.
pub fn scheme(scene: &Scene) -> Scheme {
    let mesh = mesh(scene);
    let initial = initial_fields(scene, &mesh).expect("initial fields");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("a scheme")
}

/// The value of this name.
#[track_caller]
pub fn named(values: &[NamedValue], name: &str) -> f64 {
    let found = values.iter().find(|value| value.name == name);
    found
        .unwrap_or_else(|| panic!("no {name} in {values:?}"))
        .value
}

/// S: the sum of the absolute energies of the effects.
pub fn energy_scale(report: &StepReport) -> f64 {
    report
        .energies
        .iter()
        .map(|energy| energy.value.abs())
        .sum()
}

/// max |a − b|.
pub fn greatest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// max |a|.
pub fn greatest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |greatest, a| a.abs().max(greatest))
}

/// Every field of a state, with its name.
pub fn fields(state: &State) -> Vec<(&'static str, &[f64])> {
    let mut fields = vec![
        ("phi", &state.phi[..]),
        ("omega", &state.omega[..]),
        ("mu", &state.mu[..]),
    ];
    if let Some([x, y]) = &state.director {
        fields.extend([("d_x", &x[..]), ("d_y", &y[..])]);
    }
    fields
}
