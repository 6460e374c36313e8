//! A mesh that follows the membrane, over whole runs: many transfers, and a long way.

use std::sync::Arc;

use vesica::internal::fem::Locator;
use vesica::internal::simulation::{Event, EventKind, OutlineMeasure, Schedule};
use vesica::{Mesh, Point, Simulation};

use crate::common::scene;

/// Case 4 with an interface of three times the width, which needs a ninth of the nodes.
const CASE_4: &str = include_str!("../../presets/case4-quick.toml");
const WIDE: [&str; 2] = ["membrane.interface_width=0.03", "time.tolerance=5e-3"];

/// A vesicle that is drawn across half of the domain.
const PULLED: &str = r#"
    mesh = { kind = "adaptive", size = 0.08, interface = 0.028, band = 0.09 }
    vesicle = { shape = "circle", radius = 0.15, center = [0.25, 0.5] }
    membrane.interface_width = 0.03
    area.target = 1.0
    pull.potential = "-60000*((x - 0.75)^2 + (y - 0.5)^2)"
    time = { tolerance = 5e-3, end = 2e-3 }
"#;

/// The end of a run.
struct End {
    mesh: Arc<Mesh>,
    phi: Vec<f64>,
    outline: OutlineMeasure,
    transfers: usize,
}

/// Runs a scene to its end; the mesh is also made again at `forced` times, evenly spaced.
fn end_of(text: &str, settings: &[&str], forced: u64) -> End {
    let scene = scene(text, settings);
    let schedule = Schedule::new(&scene.time, 1, forced + 2);
    let mut simulation = Simulation::new(&scene).expect("a run");
    simulation.follow(&schedule);
    while simulation.report().t < scene.time.end {
        let report = simulation.advance().expect("a step");
        let is_due = schedule.snapshot_due(report.step, report.t) && report.t < scene.time.end;
        if forced > 0 && is_due {
            simulation.renew_mesh().expect("a new mesh");
        }
    }
    let events = simulation.drain_events();
    let is_transfer = |event: &&Event| matches!(event.kind, EventKind::MeshChanged(_));
    End {
        mesh: Arc::clone(simulation.mesh()),
        phi: simulation.state().phi.clone(),
        outline: simulation.report().outline().expect("one vesicle"),
        transfers: events.iter().filter(is_transfer).count(),
    }
}

/// ‖φ − φ'‖ in L2, by the midpoints of 200 × 200 cells.
fn distance(one: &End, other: &End) -> f64 {
    const CELLS: usize = 200;
    let locators = [one, other].map(|end| Locator::new(&end.mesh));
    let at = |index: usize| (index as f64 + 0.5) / CELLS as f64;
    let cells = (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| [column, row].map(at)));
    let squares = cells.map(|place| {
        let [a, b] =
            [(&locators[0], &one.phi), (&locators[1], &other.phi)].map(|(locator, phi)| {
                locator
                    .find(Point::from(place))
                    .expect("in the square")
                    .value(phi)
            });
        (a - b).powi(2)
    });
    (squares.sum::<f64>() / (CELLS * CELLS) as f64).sqrt()
}

/// An edge of this length everywhere.
fn uniform(edge: f64) -> String {
    format!("mesh={{ kind = 'delaunay', size = {edge} }}")
}

/// With four seeds the error was 0.8 to 1.2 times that of meshes of the same size that stay, which differ among
/// themselves by less than a tenth; with the two transfers that the run needs it is 0.7 times that.
#[test]
fn fifty_transfers_leave_the_error_of_the_size_of_the_meshs() {
    let adaptive = "mesh={ kind = 'adaptive', size = 0.055, interface = 0.028, band = 0.09 }";
    let run = |mesh: &str, forced| end_of(CASE_4, &[&WIDE[..], &[mesh]].concat(), forced);
    let fine = run(&uniform(0.0125), 0);
    let of_mesh = distance(&run(&uniform(0.028), 0), &fine);
    let few = run(adaptive, 0);
    let error = distance(&few, &fine);
    assert!(
        few.transfers < 5 && error <= of_mesh,
        "{error:.2e} {of_mesh:.2e}"
    );
    let fifty = run(adaptive, 50);
    let error = distance(&fifty, &fine);
    assert!(fifty.transfers >= 50);
    assert!(error <= 1.5 * of_mesh, "{error:.2e} {of_mesh:.2e}");
    let stretched = fifty.outline.length / fine.outline.length - 1.0;
    assert!(stretched.abs() < 0.015, "{:?}", fifty.outline);
}

#[test]
fn a_vesicle_is_followed_across_half_of_the_domain() {
    let followed = end_of(PULLED, &[], 0);
    let stayed = end_of(PULLED, &[&uniform(0.028)], 0);
    let fine = end_of(PULLED, &[&uniform(0.0125)], 0);
    assert!(followed.transfers >= 10, "{}", followed.transfers);
    let of_mesh = distance(&stayed, &fine);
    let error = distance(&followed, &fine);
    assert!(error <= of_mesh, "{error:.2e} {of_mesh:.2e}");
}
