mod changes;

use std::collections::HashSet;
use std::sync::Arc;

use super::*;
use crate::fem::{QuadratureRule, Space};
use crate::physics::EffectContext;
use crate::scene;
use crate::scheme::StepError;

/// A small vesicle with every effect, off the centre and askew.
pub(super) fn small(settings: &[&str]) -> Scene {
    let text = "
        [mesh]
        cells = 12
        [vesicle]
        shape = 'ellipse'
        half_axes = [0.3, 0.2]
        center = [0.48, 0.51]
        angle = 70
        [time]
        step = 1e-6
        end = 4e-5
        [membrane]
        interface_width = 0.06
        [area]
        target = 1.1
        [nematic]
        initial = [0.6, 0.8]
        [anchoring]
        kind = 'parallel'
    ";
    Scene::of_text(text, settings)
}

fn simulation(steps: usize) -> Simulation {
    let mut simulation = Simulation::new(&small(&[])).unwrap();
    for _ in 0..steps {
        simulation.advance().unwrap();
    }
    simulation
}

#[test]
fn times_of_the_grid_are_the_nearest_numbers() {
    assert_eq!(grid_time(150, 1e-7), 1.5e-5);
    assert_eq!(grid_time(782, 1e-6), 7.82e-4);
    assert_eq!(grid_time(3, 0.3), 3.0 * 0.3);
    assert_eq!(grid_time(0, 1e-7), 0.0);
}

#[test]
fn without_measuring_anew_the_law_would_be_broken() {
    let error = with_broken_law(simulation(3));
    let broken = matches!(
        error,
        SimulationError::Step {
            step: 4,
            source: StepError::LawBroken { .. },
            ..
        }
    );
    assert!(broken, "{error}");
}

#[test]
fn an_error_names_the_solvers_that_the_mesh_has() {
    for (setting, named, other) in [
        ("mesh.jitter=0", "of the grid", "Laplacians"),
        ("mesh.jitter=0.1", "Laplacians", "of the grid"),
    ] {
        let simulation = Simulation::new(&small(&[setting])).unwrap();
        let error = with_broken_law(simulation).to_string();
        assert!(error.contains(named) && !error.contains(other), "{error}");
    }
}

/// The error of a step that cannot be made: its law begins with other energies.
fn with_broken_law(mut simulation: Simulation) -> SimulationError {
    let other = small(&["anchoring.kind=homeotropic"]);
    // What a change does, but for the energies.
    let space = Space::new(simulation.mesh().clone(), QuadratureRule::Consistent);
    let scheme = &mut simulation.scheme;
    let context = EffectContext {
        scene: &other,
        space: &space,
        initial_area: 1.0,
    };
    scheme.effects_mut().change(&small(&[]), &context);
    scheme.forget();
    simulation.advance().unwrap_err()
}

/// A run to its end, with what must hold at every step checked on the way.
fn whole(settings: &[&str], snapshots: u64) -> (Simulation, Vec<Report>, u32) {
    let scene = small(settings);
    let schedule = Schedule::new(&scene.time, 1, snapshots);
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.follow(&schedule);
    let mut reports = vec![simulation.report().clone()];
    let mut kept = u32::from(schedule.snapshot_due(0, 0.0));
    loop {
        let before = &reports[reports.len() - 1];
        if schedule.is_over(before.step, before.t) {
            return (simulation, reports, kept);
        }
        let report = simulation.advance().unwrap().clone();
        assert_eq!(report.step, before.step + 1);
        assert!(report.total_energy <= before.total_energy, "never a rise");
        let drift = report.phase_integral - before.phase_integral;
        assert!(drift.abs() < 1e-13, "{drift}");
        let sum: f64 = report.ledger.iter().map(|term| term.value).sum();
        assert!(report.law_residual.abs() <= scene.solver.law_tolerance);
        let scale: f64 = report
            .energies
            .iter()
            .map(|energy| energy.value.abs())
            .sum();
        assert!(
            sum.abs() <= 1.1 * scene.solver.law_tolerance * scale,
            "{sum}"
        );
        assert_eq!(report.ledger[0].name, "dE");
        let change = report.total_energy - before.total_energy;
        assert!((report.ledger[0].value - change).abs() <= 1e-12 * scale);
        kept += u32::from(schedule.snapshot_due(report.step, report.t));
        reports.push(report);
    }
}

/// The distance of two φ in L2, nearly: on a uniform mesh the factor does not matter.
fn distance(one: &Simulation, other: &Simulation) -> f64 {
    let pairs = one.state().phi.iter().zip(&other.state().phi);
    let sum: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
    (sum / one.state().phi.len() as f64).sqrt()
}

#[test]
fn chosen_steps_meet_snapshots_and_the_end_exactly() {
    let (_, reports, kept) = whole(&["time.tolerance=1e-5"], 4);
    assert_eq!(kept, 4);
    let last = &reports[reports.len() - 1];
    assert_eq!(last.t, 4e-5);
    for landing in [4e-5 / 3.0, 2.0 * 4e-5 / 3.0] {
        assert!(
            reports.iter().any(|report| report.t == landing),
            "{landing}"
        );
    }
    for pair in reports.windows(2) {
        let [before, after] = pair else { continue };
        let dt = after.t - before.t;
        assert!((after.dt - dt).abs() <= 1e-12 * last.t, "{} {dt}", after.dt);
        assert!(after.time_error.is_none_or(|error| error <= 1e-5));
    }
    let numerical = |report: &Report| {
        let mut terms = report.ledger.iter();
        terms.any(|term| term.name.starts_with("ND_") && term.value != 0.0)
    };
    assert!(!numerical(last) && numerical(&reports[1]));
    let first_order = whole(&["time.tolerance=1e-5", "time.scheme=first-order"], 4).1;
    assert!(numerical(&first_order[first_order.len() - 1]));
}

#[test]
fn what_is_too_inaccurate_is_refused_and_the_iterations_are_counted() {
    let (_, reports, _) = whole(&["time.tolerance=1e-6", "time.end=2e-7"], 2);
    assert!(reports[1].refused > 0 && reports[1].dt < 1e-7);
    assert!(reports[1].newton > reports[2].newton);
    let refused: u32 = reports.iter().map(|report| report.refused).sum();
    assert!(refused < 10, "{refused}");
}

#[test]
fn the_secant_scheme_is_of_second_order_and_the_other_of_first() {
    let tight = ["solver.tolerance=1e-10", "solver.law_tolerance=1e-12"];
    let at = |scheme: &str, step: &str| whole(&[scheme, step, tight[0], tight[1]], 1).0;
    let reference = at("time.scheme=secant", "time.step=2.5e-7");
    let errors = |scheme: &str| {
        ["time.step=4e-6", "time.step=2e-6"].map(|step| distance(&at(scheme, step), &reference))
    };
    let [coarse, fine] = errors("time.scheme=secant");
    let second = (coarse / fine).log2();
    let [plain, halved] = errors("time.scheme=first-order");
    let first = (plain / halved).log2();
    assert!(
        (1.7..2.4).contains(&second),
        "{second}: {coarse:e} {fine:e}"
    );
    assert!((0.8..1.2).contains(&first), "{first}: {plain:e} {halved:e}");
    assert!(coarse < 0.2 * plain, "{coarse:e} {plain:e}");
}

#[test]
fn the_error_at_the_end_is_in_proportion_to_the_tolerance() {
    let tight = ["solver.tolerance=1e-10", "solver.law_tolerance=1e-12"];
    let at = |tolerance: &str| whole(&[tolerance, tight[0], tight[1]], 1).0;
    let reference = at("time.tolerance=3e-8");
    let [coarse, fine] =
        ["time.tolerance=1e-4", "time.tolerance=1e-5"].map(|text| distance(&at(text), &reference));
    let ratio = coarse / fine;
    assert!((3.0..30.0).contains(&ratio), "{ratio}: {coarse:e} {fine:e}");
    assert!(coarse < 1e-3, "{coarse:e}");
}

/// Noise may raise the energy, by its work and no more.
#[test]
fn what_noise_does_is_no_unexplained_rise() {
    let mut simulation = Simulation::new(&small(&["noise.strength=1"])).unwrap();
    assert_eq!(simulation.report().unexplained_rise(), None);
    let mut before = simulation.report().total_energy;
    let mut rises = 0;
    for _ in 0..30 {
        let report = simulation.advance().unwrap();
        rises += u32::from(report.total_energy > before);
        before = report.total_energy;
        let unexplained = report.unexplained_rise().expect("a ledger");
        assert!(unexplained <= 1e-8 * report.total_energy, "{unexplained:e}");
    }
    assert!(rises > 0);
}

/// A step that is interrupted before each of its attempts, by a run that is resumed each time, is bit
/// for bit the step that was never left, with the same events; and meanwhile the last whole step is known.
#[test]
fn a_step_that_is_left_goes_on_as_if_nothing_had_happened() {
    let coarse = ["mesh.cells=8", "membrane.interface_width=0.09"];
    let hard: [&[&str]; 4] = [
        &["area.penalty=1e-8", "time.step=1e-5", "time.end=1"],
        &[
            "area.penalty=1e-8",
            "time.step=1e-5",
            "time.end=1",
            "time.scheme=secant",
        ],
        &["time={ tolerance = 1e-9, end = 1 }"],
        // With other solvers on the way.
        &[
            "mesh={ cells = 8, jitter = 0.6, seed = 7 }",
            "vesicle={ shape = 'random', amplitude = 4.0, seed = 3 }",
            "membrane.interface_width=0.04",
            "area={ target = 1.25, penalty = 1e-6 }",
            "nematic.initial={ kind = 'random', seed = 2 }",
            "anchoring={}",
            "time={ step = 1e-4, end = 1 }",
        ],
    ];
    let mut kinds = HashSet::new();
    for settings in hard {
        let scene = small(&[&coarse, settings].concat());
        let mut whole = Simulation::new(&scene).unwrap();
        let mut parted = Simulation::new(&scene).unwrap();
        // What happened at the start must not be reported again.
        assert_eq!(whole.drain_events(), parted.drain_events());
        let mut left = 0;
        for _ in 0..2 {
            let mut last = whole.report().t;
            let before = Report {
                ledger: Vec::new(),
                costs: Costs::default(),
                ..whole.report().clone()
            };
            let state_before = whole.state().clone();
            let expected = Report {
                costs: Costs::default(),
                ..whole.advance().unwrap().clone()
            };
            let told = |simulation: &mut Simulation| -> Vec<(u64, f64, String)> {
                let events = simulation.drain_events().into_iter();
                let words = |event: Event| (event.step, event.t, event.kind.to_string());
                events.map(words).collect()
            };
            let mut told_within = Vec::new();
            while !parted.advance_unless(&mut |_| true).unwrap() {
                left += 1;
                told_within.extend(told(&mut parted));
                let t = parted.report().t;
                assert!(last <= t && t < expected.t, "{settings:?}");
                last = t;
                let mut checkpoint = SimulationCheckpoint::default();
                parted.save(&mut checkpoint);
                parted = Simulation::new(&scene).unwrap();
                parted.restore(&checkpoint).unwrap();
                let (report, state) = parted.last_whole();
                assert_eq!(*report, before, "{settings:?}");
                assert_eq!(*state, state_before, "{settings:?}");
                let underway = parted.underway().unwrap();
                assert_eq!((underway.step, underway.t), (before.step + 1, t));
                assert!(checkpoint.is_begun());
            }
            let report = Report {
                costs: Costs::default(),
                ..parted.report().clone()
            };
            assert_eq!(report, expected, "{settings:?}");
            assert_eq!(parted.state(), whole.state(), "{settings:?}");
            kinds.extend(whole.events.iter().map(|event| event.kind.name()));
            told_within.extend(told(&mut parted));
            assert_eq!(told_within, told(&mut whole), "{settings:?}");
        }
        assert!(left > 0, "{settings:?}");
    }
    for kind in [
        "step-divided",
        "short-steps",
        "newton-damped",
        "fell-back-to-factor",
    ] {
        assert!(kinds.contains(kind), "{kind} is not tested: {kinds:?}");
    }
}

/// A step whose parts have become a millionth of it is interrupted to report that, once, and continues.
#[test]
fn steps_that_become_short_are_told_within_the_step() {
    let hard: [&[&str]; 2] = [
        &["area.penalty=1e-8", "time.step=1e-2", "time.end=1"],
        &["time={ tolerance = 1e-300, end = 1 }"],
    ];
    let told = |simulation: &mut Simulation| -> Vec<Event> {
        let mut events = simulation.drain_events();
        events.retain(|event| matches!(event.kind, EventKind::ShortSteps { .. }));
        events
    };
    for settings in hard {
        let mut simulation = Simulation::new(&small(settings)).unwrap();
        assert!(!simulation.advance_unless(&mut |_| false).unwrap());
        let events = told(&mut simulation);
        let [Event { step: 1, kind, .. }] = &events[..] else {
            panic!("{settings:?}: {events:?}");
        };
        let EventKind::ShortSteps { dt, first, .. } = *kind else {
            panic!("{kind:?}");
        };
        let asked = simulation.scene().time.step;
        // Soon after it fell below: the longest leap there is a factor of 2⁶.
        let share = dt / asked;
        assert!(first == asked && share < 1e-6 && share > 1e-8, "{kind:?}");
        assert_eq!(simulation.report().step, 0);
        let mut attempts = 0;
        let mut leave = |_: &StepProgress| {
            attempts += 1;
            attempts > 3
        };
        assert!(!simulation.advance_unless(&mut leave).unwrap());
        assert_eq!(told(&mut simulation), [], "{settings:?}");
    }
    let mut simulation = Simulation::new(&small(&["time.step=1e-4", "time.end=1"])).unwrap();
    assert!(simulation.advance_unless(&mut |_| false).unwrap());
    assert_eq!(told(&mut simulation), []);
}

/// Every rung is an event, the damping too: when it begins.
#[test]
fn a_damped_step_is_an_event() {
    let mut simulation = Simulation::new(&small(&[
        "area.penalty=1e-6",
        "time.step=1e-5",
        "time.end=1",
    ]))
    .unwrap();
    let mut was_damped = false;
    let mut seen = 0;
    for _ in 0..6 {
        let damping = simulation.advance().unwrap().effort.damping;
        let events = simulation.drain_events().into_iter();
        let factors: Vec<f64> = events
            .filter_map(|event| match event.kind {
                EventKind::Damped { factor } => Some(factor),
                _ => None,
            })
            .collect();
        let expected = (damping < 1.0 && !was_damped).then_some(damping);
        assert_eq!(factors, expected.into_iter().collect::<Vec<_>>());
        seen += factors.len();
        was_damped = damping < 1.0;
    }
    assert!(seen > 0);
}

/// The names of the solvers that a run has, and of no other, in its error and in what it reports.
#[test]
fn errors_name_the_solvers_that_the_mesh_has() {
    let square = include_bytes!("../../tests/meshes/square-22.msh");
    let file = scene::Mesh::File(scene::MeshFile {
        path: "square.msh".to_owned(),
        triangulation: Arc::new(scene::Triangulation::parse(square).unwrap()),
    });
    let names = [
        "GMRES with the transform of the grid",
        "GMRES with the shifted Laplacians",
        "the sparse factor",
    ];
    for (mesh, settings, used) in [
        (None, &[][..], [true, false, true]),
        (Some(&file), &[], [false, true, true]),
        (
            Some(&file),
            &["solver.linear=shifted"],
            [false, true, false],
        ),
        (Some(&file), &["solver.linear=factor"], [false, false, true]),
        (
            Some(&file),
            &["domain.boundary=clamped"],
            [false, false, true],
        ),
        (None, &["mesh.jitter=0.1"], [false, true, true]),
    ] {
        let settings = [&["solver.law_tolerance=1e-300"], settings].concat();
        let mut scene = small(&settings);
        if let Some(mesh) = mesh {
            scene.mesh = mesh.clone();
        }
        let mut simulation = Simulation::new(&scene).unwrap();
        let error = simulation.advance().unwrap_err().to_string();
        let (_, tried) = error.split_once("tried were").expect(&error);
        for (name, used) in names.into_iter().zip(used) {
            assert_eq!(tried.contains(name), used, "{settings:?}, {name}: {error}");
        }
        let events = simulation.drain_events().into_iter();
        let words: Vec<String> = events.map(|event| event.kind.to_string()).collect();
        let words = words.join("\n") + &error;
        assert_eq!(
            words.contains("of the grid"),
            used[0],
            "{settings:?}: {words}"
        );
    }
}

/// What overflows is refused when a run is set up, and never passed over.
#[test]
fn a_scene_too_large_to_compute_with_is_refused() {
    for settings in [
        &["vesicle.scale=1e100", "vesicle.projection=nodal"][..],
        &["membrane.spontaneous_curvature=1e300"],
        &[
            "membrane.spontaneous_curvature=1e300",
            "solver.quadrature=lumped",
        ],
        &["nematic.initial=[1e200, 0]"],
    ] {
        let outcome = Simulation::new(&small(settings));
        let error = outcome.expect_err("too large").to_string();
        assert!(error.contains("too large"), "{settings:?}: {error}");
    }
}

#[test]
fn a_run_begins_with_the_solver_whose_memory_is_foreseen() {
    for (setting, method) in [
        ("time.step=1e-6", "transform"),
        ("time.tolerance=1e-4", "factor"),
        ("mesh.jitter=0.1", "shifted"),
        ("domain.geometry=axisymmetric", "transform"),
        ("solver.linear=factor", "factor"),
        ("domain.boundary=clamped", "factor"),
    ] {
        let scene = small(&[setting]);
        assert_eq!(Simulation::new(&scene).unwrap().linear_method(), method);
        let foreseen = memory_held(&scene, method == "factor");
        assert_eq!(memory_needed(&scene), foreseen, "{setting}");
    }
    let told = small(&["time.tolerance=1e-4", "solver.linear=transform"]);
    assert_eq!(Simulation::new(&told).unwrap().linear_method(), "transform");
    assert_eq!(memory_needed(&told), memory_held(&told, false));
}

/// A membrane that is not closed has no reduced area.
#[test]
fn a_vesicle_at_the_wall_has_no_reduced_area() {
    let of = |center: &str| {
        let scene = small(&[center]);
        examine(&scene).expect("a scene").reduced_size
    };
    let inside = of("vesicle.center=[0.5, 0.5]").expect("one vesicle");
    assert!((0.8..1.0).contains(&inside), "{inside}");
    assert_eq!(of("vesicle.center=[0.1, 0.5]"), None);
}
