//! `[[change]]`.

use proptest::prelude::*;

use super::{read, read_with};
use crate::scene::{ParameterValue, Scene, Timetable, warnings};

/// The header of the error of a scene with these changes.
fn message(changes: &str) -> String {
    let text =
        format!("[area]\n[nematic]\n[field]\n[membrane]\nspontaneous_curvature = 'x'\n{changes}");
    let files = [("k.txt", "1\n")];
    let error = read_with(&text, &[], &files)
        .expect_err(changes)
        .to_string();
    error.split('\n').next().unwrap_or_default().to_owned()
}

fn change(set: &str) -> String {
    message(&format!("[[change]]\nat = 1e-4\nset = {{ {set} }}"))
}

#[test]
fn a_change_says_what_is_wrong_and_where() {
    let near = change("'area.tagret' = 1.1");
    assert!(
        near.starts_with("a.toml:8:9: unknown parameter 'area.tagret'; did you mean 'area.target'? A change can set: membrane.mobility, "),
        "{near}"
    );
    for fixed in [
        "mesh.cells = 30",
        "membrane.interface_width = 0.02",
        "solver.quadrature = 'lumped'",
    ] {
        let fixed = change(fixed);
        assert!(fixed.contains("cannot change while a run goes"), "{fixed}");
    }
    for (set, part) in [
        (
            "area.target = -1",
            "change[0].set.area.target must be a finite number > 0, not -1",
        ),
        ("area.target = nan", "must be a finite number > 0"),
        ("area.penalty = 0", "must be a finite number > 0"),
        (
            "area.target = 'x'",
            "must be a finite number > 0, not a string",
        ),
        ("anchoring.kind = 'paralel'", "did you mean 'parallel'?"),
        ("field.on = 1", "must be true or false, not a number"),
        ("pull.potential = 'x +'", "pull.potential"),
        (
            "area.target = 1, 'area.target' = 2",
            "area.target is given more than once",
        ),
        (
            "",
            "must be a table such as { \"area.target\" = 1.1 }, not {",
        ),
        ("targt = 1", "unknown parameter 'targt'"),
    ] {
        let text = change(set);
        assert!(text.contains(part), "{set}: {text}");
    }
    for (changes, part) in [
        (
            "[[change]]\nset = { area.target = 1 }",
            "[[change]] needs the key 'at'",
        ),
        ("[[change]]\nat = 1", "[[change]] needs the key 'set'"),
        (
            "[[change]]\nat = -1\nset = { area.target = 1 }",
            "a.toml:7:6: change[0].at must be a finite number ≥ 0",
        ),
        (
            "[[change]]\nat = 1\nove = 1\nset = { area.target = 1 }",
            "did you mean 'over'?",
        ),
        ("[change]\nat = 1", "must be an array of tables"),
    ] {
        let text = message(changes);
        assert!(text.contains(part), "{changes}: {text}");
    }
}

#[test]
fn a_ramp_is_from_number_to_number() {
    let ramp = |set: &str| message(&format!("[[change]]\nat = 1\nover = 1\nset = {{ {set} }}"));
    for (set, part) in [
        (
            "anchoring.kind = 'none'",
            "anchoring.kind has no value before it",
        ),
        ("field.on = false", "field.on is not one before it"),
        ("membrane.spontaneous_curvature = 1", "is not one before it"),
        (
            "nematic.weight = 1, field.strength = 'x'",
            "must be a finite number",
        ),
        (
            "pull.potential = 1",
            "pull.potential has no value before it",
        ),
    ] {
        let text = ramp(set);
        assert!(text.contains(part), "{set}: {text}");
    }
    // An earlier change gives it one, wherever it stands.
    read(
        "[[change]]\nat = 2\nover = 1\nset = { area.target = 2 }\n[[change]]\nat = 1\nset = { area.penalty = 1 }",
    );
}

#[test]
fn a_change_brings_no_director_in() {
    for set in [
        "nematic.weight = 1",
        "anchoring.kind = 'parallel'",
        "field.strength = 1",
        "noise.strength = 1",
    ] {
        let text = format!("[[change]]\nat = 1\nset = {{ {set} }}");
        let error = read_with(&text, &[], &[]).expect_err(set).to_string();
        assert!(error.contains("needs a director"), "{error}");
    }
    // Of a file there is none after the start.
    let file = change("pull.potential = { file = 'k.txt' }");
    assert!(file.contains("file"), "{file}");
}

#[test]
fn both_ways_to_write_a_parameter_are_the_same() {
    let nested = read("[area]\n[[change]]\nat = 1\nset = { area.target = 1.1, area.penalty = 2 }");
    let quoted =
        read("[area]\n[[change]]\nat = 1\nset = { 'area.target' = 1.1, 'area.penalty' = 2 }");
    assert_eq!(nested, quoted);
    assert_eq!(read(&nested.to_toml()), nested);
}

fn number(scene: &Scene, t: f64, key: &str) -> f64 {
    let value = scene.parameter_at(t, key);
    value.as_ref().and_then(ParameterValue::number).expect(key)
}

#[test]
fn changes_come_in_the_order_of_time_and_a_later_one_ends_a_ramp() {
    let scene = read(
        "area.target = 1
         [[change]]
         at = 4
         over = 4
         set = { area.target = 3 }
         [[change]]
         at = 1
         over = 2
         set = { area.target = 2 }
         [[change]]
         at = 6
         set = { area.target = 5 }
         [[change]]
         at = 6
         over = 2
         set = { area.target = 1 }",
    );
    let times: Vec<f64> = scene.changes.iter().map(|change| change.at).collect();
    assert_eq!(times, [1.0, 4.0, 6.0, 6.0]);
    for (t, target) in [
        (0.0, 1.0),
        (1.0, 1.0),
        (2.0, 1.5),
        (3.0, 2.0),
        (3.5, 2.0),
        (5.0, 2.25),
        (5.999, 2.499_75),
        // The jump ends the ramp, and the last ramp begins from it.
        (6.0, 5.0),
        (7.0, 3.0),
        (8.0, 1.0),
        (9.0, 1.0),
    ] {
        let found = number(&scene, t, "area.target");
        assert!((found - target).abs() < 1e-12, "{t}: {found}");
    }
    let timetable = Timetable::of(&scene);
    let mut events = vec![0.0];
    while let Some(event) = timetable.next_event(events[events.len() - 1]) {
        events.push(event);
    }
    assert_eq!(events, [0.0, 1.0, 3.0, 4.0, 6.0, 8.0]);
    assert_eq!([0.5, 1.0, 6.0].map(|t| timetable.begun(t)), [0, 1, 4]);
    assert!(timetable.has_jump(|at| at == 6.0) && !timetable.has_jump(|at| at == 4.0));
}

#[test]
fn from_and_until_are_short_for_changes() {
    let scene = read("[nematic]\n[field]\nfrom = 2\nuntil = 3");
    let is_on = |t: f64| scene.parameter_at(t, "field.on");
    assert!(scene.changes.is_empty());
    let timetable = Timetable::of(&scene);
    let on = |t: f64| timetable.at(t).field.map(|field| field.on);
    assert_eq!(
        [1.0, 2.0, 3.0].map(on),
        [Some(false), Some(true), Some(false)]
    );
    assert_eq!(is_on(2.5), Some(ParameterValue::Switch(true)));
}

#[test]
fn what_is_changed_by_hand_holds_from_the_start_of_the_next_run() {
    let loaded = read("[area]\n[[change]]\nat = 1\nset = { area.target = 2 }");
    let mut scene = loaded.clone();
    let by_hand =
        read("[area]\n[[change]]\nat = 0.5\nover = 1\nset = { area.penalty = 7 }").changes;
    scene.add_change(&by_hand[0]).expect("a change");
    assert_eq!(scene.changes.len(), 2);
    scene.begin_with_changes(&loaded.changes);
    assert_eq!(scene.changes, loaded.changes);
    assert_eq!(scene.area.expect("it").penalty, 7.0);
}

#[test]
fn a_change_after_the_end_is_told() {
    let scene = read("time.end = 1\n[area]\n[[change]]\nat = 1\nset = { area.target = 2 }");
    let warned = warnings(&scene, None);
    assert!(
        warned
            .iter()
            .any(|it| it.to_string().contains("never begins")),
        "{warned:?}"
    );
}

#[test]
fn the_guide_has_all_parameters_that_can_change() {
    let guide = include_str!("../../../docs/guide/changes.md");
    for key in Scene::tunable_parameters() {
        let is_of_the_guide = key.starts_with("tension.");
        assert!(
            is_of_the_guide || guide.contains(&format!("`{key}`")),
            "{key}"
        );
    }
}

proptest! {
    /// Numbers between the ends of a ramp lie between its values.
    #[test]
    fn a_ramp_stays_between_its_ends(from in 0.1..9.0, to in 0.1..9.0, share in 0.0..1.0, at in 0.0..1.0, over in 1e-6..1.0) {
        let scene = read(&format!(
            "area.target = {from:?}\n[[change]]\nat = {at:?}\nover = {over:?}\nset = {{ area.target = {to:?} }}"
        ));
        let found = number(&scene, at + share * over, "area.target");
        let slack = 1e-12;
        prop_assert!(found >= f64::min(from, to) - slack && found <= f64::max(from, to) + slack);
        prop_assert_eq!(number(&scene, at + over * 1.001, "area.target"), to);
    }
}
