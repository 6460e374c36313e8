//! The rate at which a nearly round vesicle becomes round, against the sharp-interface theory (docs/guide/shapes.md).

use std::f64::consts::PI;

use vesica::scene::{Scene, preset};
use vesica::simulation::{Schedule, Simulation, enclosed_area};
use vesica::theory::RoundVesicle;

fn scene(settings: &[&str]) -> Scene {
    let text = preset("relaxation").expect("it is built in");
    let settings: Vec<String> = settings
        .iter()
        .map(|setting| (*setting).to_owned())
        .collect();
    Scene::parse(text, "relaxation", &settings, &mut |_| {
        Err(std::io::ErrorKind::NotFound.into())
    })
    .unwrap_or_else(|error| panic!("{error}"))
}

/// The measured rate of the mode n = 2 over that of theory.
fn measured_over_theory(settings: &[&str]) -> f64 {
    let scene = scene(settings);
    let schedule = Schedule::new(&scene.time, 1, 1);
    let mut simulation = Simulation::new(&scene).expect("a vesicle");
    simulation.follow(&schedule);
    let log_amplitude = |simulation: &Simulation| {
        let outline = simulation.report().outline().expect("one vesicle");
        ((outline.length - outline.waist) / (outline.length + outline.waist)).ln()
    };
    // From after the first steps, in which the profile of the membrane finds its form.
    let mut start = None;
    while !schedule.is_done(simulation.report()) {
        let t = simulation.advance().expect("a step").t;
        if t > 3e-5 {
            start.get_or_insert((t, log_amplitude(&simulation)));
        }
    }
    let (from, before) = start.expect("a step after the first");
    let rate = (before - log_amplitude(&simulation)) / (simulation.report().t - from);
    let enclosed = enclosed_area(simulation.mesh(), simulation.report().phase_integral);
    let vesicle = RoundVesicle {
        radius: (enclosed / PI).sqrt(),
        mobility: scene.membrane.mobility,
        interface_width: scene.membrane.interface_width,
        tension: 0.0,
        is_in_unit_square: true,
    };
    rate / vesicle.decay_rate(2).expect("ε is small")
}

/// At ε/R = 0.067, with 4 edges of the mesh across ε.
#[test]
fn a_nearly_round_vesicle_relaxes_at_the_rate_of_theory() {
    let ratio = measured_over_theory(&["time.end=2e-4"]);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}
