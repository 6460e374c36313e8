//! Parameters that change while a run goes.

use proptest::prelude::*;

use super::super::*;
use super::small;
use crate::scene::{AnchoringKind, ParameterValue, Scene};

/// With every effect, and a law that closes to rounding.
const ALL: [&str; 6] = [
    "field={ weight = 300, angle = 35 }",
    "pull.potential='100*x - 300*y^2'",
    "noise={ strength = 1e-3, seed = 5 }",
    "membrane.spontaneous_curvature=0.5",
    "solver.tolerance=1e-10",
    "solver.law_tolerance=1e-12",
];

fn with(settings: &[&str], changes: &str) -> Simulation {
    let changes = format!("change=[{changes}]");
    Simulation::new(&small(&[settings, &[&changes]].concat())).unwrap()
}

/// Takes steps; the reports, with that of the state before.
fn run(simulation: &mut Simulation, steps: usize) -> Vec<Report> {
    let mut reports = vec![simulation.report().clone()];
    for _ in 0..steps {
        reports.push(without_costs(simulation.advance().unwrap()));
    }
    reports
}

fn without_costs(report: &Report) -> Report {
    Report {
        costs: Costs::default(),
        ..report.clone()
    }
}

/// The law of a step, over S: the sum of its ledger, which begins with the change of the energy since the step before.
#[track_caller]
fn law(before: &Report, report: &Report) -> f64 {
    let scale = report.law_scale().max(before.law_scale());
    let change = report.total_energy - before.total_energy;
    assert!((report.ledger[0].value - change).abs() <= 1e-12 * scale);
    report.ledger.iter().map(|term| term.value).sum::<f64>() / scale
}

/// Another value for every parameter.
fn other_value(key: &str) -> &'static str {
    match key {
        "membrane.mobility" => "0.03",
        "membrane.spontaneous_curvature" => "1.5",
        "area.target" => "1.05",
        "area.penalty" => "2e-3",
        "nematic.weight" => "8.0",
        "nematic.mobility" => "0.7",
        "nematic.penalty" => "0.1",
        "anchoring.kind" => "'homeotropic'",
        "anchoring.weight" => "14.0",
        "field.weight" => "-200.0",
        "field.strength" => "1.3",
        "field.angle" => "80.0",
        "field.on" => "false",
        "pull.potential" => "'200*x'",
        "noise.strength" => "2e-3",
        "tension.weight" => "0.7",
        key => panic!("{key} needs a value here"),
    }
}

fn is_number(key: &str) -> bool {
    !["anchoring.kind", "field.on", "pull.potential"].contains(&key)
}

#[test]
fn the_law_closes_through_a_change_of_every_parameter() {
    for key in Scene::tunable_parameters() {
        // It is brought in.
        let is_new = key.starts_with("tension");
        for over in [0.0, 3e-6] {
            if over > 0.0 && (!is_number(&key) || is_new) {
                continue;
            }
            let value = other_value(&key);
            let change = format!("{{ at = 2e-6, over = {over}, set = {{ {key} = {value} }} }}");
            let reports = run(&mut with(&ALL, &change), 6);
            let mut works = Vec::new();
            for pair in reports.windows(2) {
                let name = format!("{key} over {over}, step {}", pair[1].step);
                assert!(law(&pair[0], &pair[1]).abs() <= 1e-12, "{name}");
                works.push(pair[1].change_work());
                let scale = pair[1].law_scale();
                // Without the work it would not close.
                let missed = law(&pair[0], &pair[1]) + pair[1].change_work() / scale;
                assert_eq!(
                    missed.abs() > 1e-9,
                    pair[1].change_work() != 0.0,
                    "{name}: {missed:e}"
                );
            }
            let worked = works.iter().map(|work| *work != 0.0);
            let is_dissipative = key.ends_with("mobility") || key.starts_with("noise");
            let wanted = (1..=6).map(|step| match over > 0.0 {
                false => !is_dissipative && step == 3,
                true => !is_dissipative && (3..=6).contains(&step),
            });
            assert!(worked.eq(wanted), "{key} over {over}: {works:?}");
        }
    }
}

#[test]
fn a_change_back_and_forth_in_no_time_is_no_change() {
    let plain = run(&mut with(&ALL, ""), 6);
    let there =
        "{ at = 2e-6, set = { area.target = 1.2, anchoring.kind = 'none', field.on = false } }";
    let back =
        "{ at = 2e-6, set = { area.target = 1.1, anchoring.kind = 'parallel', field.on = true } }";
    let mut changed = with(&ALL, &format!("{there}, {back}"));
    for (plain, changed) in plain.iter().zip(run(&mut changed, 6)) {
        assert_eq!(plain.energies, changed.energies);
        assert_eq!(plain.law_residual, changed.law_residual);
    }
    let [event] = &changed.drain_events()[..] else {
        panic!("one event");
    };
    let EventKind::ParametersChanged { changes, work } = &event.kind else {
        panic!("{event:?}");
    };
    assert_eq!((changes.len(), *work, event.step), (2, 0.0, 2));
}

/// The distance of two runs' φ in the largest norm.
fn distance(one: &Simulation, other: &Simulation) -> f64 {
    let pairs = one.state().phi.iter().zip(&other.state().phi);
    pairs
        .map(|(one, other)| (one - other).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_ramp_in_pieces_tends_to_the_ramp() {
    const STEPS: usize = 32;
    let over = STEPS as f64 * 1e-6;
    let quiet = ["time.end=1", "solver.tolerance=1e-9"];
    let ramp = format!("{{ at = 0, over = {over}, set = {{ area.target = 1.3 }} }}");
    let mut whole = with(&quiet, &ramp);
    run(&mut whole, STEPS);
    let distances = [2, 4, 8].map(|pieces| {
        let piece = |number: usize| {
            let at = over * number as f64 / f64::from(pieces);
            let share = (number as f64 + 0.5) / f64::from(pieces);
            format!(
                "{{ at = {at}, set = {{ area.target = {} }} }}",
                1.1 + 0.2 * share
            )
        };
        let pieces: Vec<String> = (0..pieces as usize).map(piece).collect();
        let mut stairs = with(&quiet, &pieces.join(", "));
        run(&mut stairs, STEPS);
        distance(&whole, &stairs)
    });
    let mut plain = with(&quiet, "");
    run(&mut plain, STEPS);
    assert!(
        distances[0] < 0.2 * distance(&whole, &plain),
        "{distances:?}"
    );
    for pair in distances.windows(2) {
        assert!(pair[1] < 0.6 * pair[0], "{distances:?}");
    }
}

/// Both ways to write the same.
#[test]
fn from_and_until_are_changes() {
    let field = "field={ weight = 300, from = 2e-6, until = 4e-6 }";
    for other in ["time.scheme=secant", "time.tolerance=1e-5"] {
        let settings = [other, "time.end=8e-6"];
        let mut one = with(&[&settings[..], &[field]].concat(), "");
        let off = "field={ weight = 300, on = false }";
        let changes =
            "{ at = 4e-6, set = { field.on = false } }, { at = 2e-6, set = { field.on = true } }";
        let mut two = with(&[&settings[..], &[off]].concat(), changes);
        let both = [&mut one, &mut two].map(|simulation| {
            let mut reports = Vec::new();
            while simulation.report().t < 8e-6 {
                reports.push(without_costs(simulation.advance().unwrap()));
            }
            reports
        });
        assert_eq!(both[0], both[1], "{other}");
        assert!(one.state() == two.state());
        let events = one.drain_events();
        assert_eq!(events, two.drain_events());
        let changed = |event: &&Event| matches!(event.kind, EventKind::ParametersChanged { .. });
        let times: Vec<f64> = events.iter().filter(changed).map(|event| event.t).collect();
        assert!(times.starts_with(&[2e-6]), "{times:?}");
        // What is off is no effect.
        let has_field = |report: &Report| report.energies.iter().any(|it| it.name == "field");
        for report in &both[0] {
            assert_eq!(
                has_field(report),
                report.t > 2e-6 && report.t <= 4e-6,
                "{}",
                report.t
            );
        }
    }
}

#[test]
fn a_change_by_hand_is_one_of_the_scene_bit_for_bit() {
    for settings in [&ALL[..], &["time.scheme=secant"]] {
        let mut played = with(settings, "");
        run(&mut played, 3);
        let set = Change::of_anchoring(AnchoringKind::Homeotropic);
        played.change(set, 0.0).unwrap();
        run(&mut played, 2);
        let target = vec![Assignment {
            key: "area.target".to_owned(),
            value: ParameterValue::Number(1.2),
        }];
        played.change(target, 3e-6).unwrap();
        run(&mut played, 4);
        let mut again = Simulation::new(played.scene()).unwrap();
        let reports = run(&mut again, 9);
        assert_eq!(reports.last(), Some(&without_costs(played.report())));
        assert!(again.state() == played.state());
        assert_eq!(again.drain_events(), played.drain_events());
        // And so it is when the scene was written down and read.
        let text = played.scene().to_toml();
        assert_eq!(Scene::of_text(&text, &[]), *played.scene());
    }
}

#[test]
fn a_change_that_the_scene_cannot_have_is_refused() {
    let mut bare = Simulation::new(&small(&["anchoring=false", "nematic=false"])).unwrap();
    let before = bare.scene().clone();
    let set = Change::of_anchoring(AnchoringKind::Parallel);
    let error = bare.change(set, 0.0).unwrap_err().to_string();
    assert!(error.contains("needs a director"), "{error}");
    assert_eq!(*bare.scene(), before);
}

#[test]
fn a_run_goes_on_in_the_middle_of_a_ramp() {
    let ramp = "{ at = 0, over = 2e-5, set = { area.target = 1.3, membrane.spontaneous_curvature = 1.5 } }";
    for settings in [
        &[][..],
        &["time.scheme=secant"],
        &["time.tolerance=1e-4"],
        &["time.tolerance=1e-4", "time.scheme=first-order"],
    ] {
        let mut first = with(settings, ramp);
        run(&mut first, 4);
        first.drain_events();
        let mut checkpoint = SimulationCheckpoint::default();
        first.save(&mut checkpoint);
        let bytes = postcard::to_stdvec(&checkpoint).unwrap();
        let checkpoint: SimulationCheckpoint = postcard::from_bytes(&bytes).unwrap();
        let mut second = with(settings, ramp);
        second.restore(&checkpoint).unwrap();
        assert!(second.report().t < 1e-5);
        let both = [&mut first, &mut second].map(|simulation| run(simulation, 5)[1..].to_vec());
        assert_eq!(both[0], both[1]);
        assert!(both[0][0].change_work() != 0.0);
        assert!(first.state() == second.state());
    }
}

/// Steps of the second order keep it through a ramp, for each has the parameters of its middle.
#[test]
fn the_secant_scheme_keeps_its_order_through_a_ramp() {
    let ramp = "{ at = 0, over = 64e-6, set = { area.target = 1.3, anchoring.weight = 20 } }";
    let end = |steps: usize| {
        let step = format!("time.step={}", 64e-6 / steps as f64);
        let settings = [
            "time.scheme=secant",
            "time.end=1",
            &step,
            "solver.tolerance=1e-10",
        ];
        let mut simulation = with(&settings, ramp);
        run(&mut simulation, steps);
        simulation
    };
    let exact = end(512);
    let errors = [16, 32, 64].map(|steps| distance(&end(steps), &exact));
    for pair in errors.windows(2) {
        assert!(pair[0] / pair[1] > 2.8, "{errors:?}");
    }
}

#[test]
fn chosen_steps_meet_the_ends_of_a_ramp() {
    let ramp = "{ at = 3e-6, over = 4e-6, set = { area.target = 1.2 } }";
    let mut simulation = with(&["time.tolerance=1e-4", "time.end=2e-5"], ramp);
    let mut times = Vec::new();
    let mut before = simulation.report().clone();
    while simulation.report().t < 2e-5 {
        let report = simulation.advance().unwrap().clone();
        assert!(law(&before, &report).abs() < 1e-8);
        times.push(report.t);
        before = report;
    }
    assert!(times.contains(&3e-6) && times.contains(&7e-6), "{times:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// Of any changes: the law closes, the energy changes by their work and falls otherwise.
    #[test]
    fn the_law_closes_through_any_sequence(
        changes in proptest::collection::vec((0_usize..16, 0.0..8e-6, 0.0..4e-6, 0.7..1.4), 1..8),
        scheme in prop_oneof![Just("time.scheme=first-order"), Just("time.scheme=secant")],
    ) {
        let keys = Scene::tunable_parameters();
        let change = |(number, at, over, factor): &(usize, f64, f64, f64)| {
            let key = &keys[*number % keys.len()];
            let value = other_value(key);
            match (is_number(key), value.parse::<f64>()) {
                (true, Ok(value)) if !key.starts_with("tension") => format!(
                    "{{ at = {at}, over = {over}, set = {{ {key} = {} }} }}", factor * value
                ),
                _ => format!("{{ at = {at}, set = {{ {key} = {value} }} }}"),
            }
        };
        let changes: Vec<String> = changes.iter().map(change).collect();
        let mut simulation = with(&[&ALL[..], &[scheme]].concat(), &changes.join(", "));
        for pair in run(&mut simulation, 10).windows(2) {
            let missed = law(&pair[0], &pair[1]);
            prop_assert!(missed.abs() <= 1e-12, "{changes:?}: {missed:e}");
            let rise = pair[1].unexplained_rise().unwrap() / pair[1].law_scale();
            prop_assert!(rise <= 1e-12, "{changes:?}: {rise:e}");
        }
    }
}
