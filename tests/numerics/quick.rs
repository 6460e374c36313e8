//! The quick presets of the paper's cases: sizes and order of the four fates are those
//! of the cases on their own mesh with their own 10,000 steps.

use std::thread;

use vesica::internal::fem::long_axis;
use vesica::internal::simulation::OutlineMeasure;
use vesica::{Scene, Simulation, Vector, find_preset};

/// Length and waist of the cases at t = 1e-3 with homeotropic anchoring, from docs/guide/cases.md. Parallel
/// anchoring gives the same with cases 1 and 2 exchanged, and 3 and 4 (`cargo test --test numerics symmetry`).
const CASES: [(&str, f64, f64); 4] = [
    ("case1-quick", 0.5751, 0.2525),
    ("case2-quick", 0.5768, 0.2895),
    ("case3-quick", 0.6486, 0.1082),
    ("case4-quick", 0.7072, 0.1827),
];

/// The vesicle at the end of a preset, and the direction in which it is long.
fn end_of(name: &str) -> (OutlineMeasure, Vector) {
    let text = find_preset(name).expect("a preset");
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, name, &[], &mut no_files).expect("a scene");
    let mut simulation = Simulation::new(&scene).expect("it can be set up");
    let warnings: Vec<_> = simulation
        .warnings()
        .iter()
        .map(|w| w.to_string())
        .collect();
    assert!(
        !warnings.iter().any(|warning| warning.contains("trusted")),
        "{name}: {warnings:?}"
    );
    while simulation.report().t < scene.time.end {
        simulation.advance().expect("a step");
    }
    let axis = long_axis(simulation.mesh(), &simulation.state().phi);
    (simulation.report().outline().expect("one vesicle"), axis)
}

#[test]
fn the_quick_presets_have_the_fates_of_their_cases() {
    let ends = thread::scope(|scope| {
        let runs = CASES.map(|(name, ..)| scope.spawn(move || end_of(name)));
        runs.map(|run| run.join().expect("a run"))
    });
    for ((name, length, waist), (outline, axis)) in CASES.iter().zip(&ends) {
        let errors = [outline.length / length - 1.0, outline.waist / waist - 1.0];
        assert!(
            errors.iter().all(|error| error.abs() < 0.05),
            "{name}: {outline:?}, off by {errors:?}"
        );
        // Upright, not along the mesh.
        assert!(axis[0].abs() < 0.05, "{name}: {axis:?}");
    }
    let [one, two, three, four] = ends.map(|(outline, _)| outline);
    assert!(three.waist < four.waist && four.waist < one.waist && one.waist < two.waist);
    assert!(one.length.max(two.length) < three.length && three.length < four.length);
    // Case 3 stays biconcave, case 4 loses its waist.
    assert!(three.waist / three.width < 0.45 && four.waist / four.width > 0.7);
}
