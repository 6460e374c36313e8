//! How things are shown, and scrubbing.

use crossterm::event::KeyCode;

use super::super::super::message::{Effect, Message};
use super::super::super::state::{Director, Field, Panel, Zoom};
use super::rig::{Rig, scene, slot};
use crate::scene::{Assignment, Change, ParameterValue};
use crate::simulation::{Message as WorkerMessage, RunId, WorkerEvent};
use crate::theory::{CurveAtRest, ShapeAtRest};
use std::sync::Arc;

/// A run with pictures of the steps 3, 6, …, 3n.
fn with_past(pictures: usize) -> Rig {
    let mut rig = Rig::new();
    for _ in 0..pictures {
        rig.work(3);
        rig.fetch();
    }
    rig
}

fn looked_at(rig: &Rig) -> u64 {
    rig.app.picture().expect("a picture").report.step
}

#[test]
fn scrubbing_goes_back_and_on_to_the_present() {
    let mut rig = with_past(30);
    assert_eq!(looked_at(&rig), 90);
    rig.press(KeyCode::Left);
    assert_eq!(looked_at(&rig), 87);
    rig.press(KeyCode::PageUp);
    assert_eq!(looked_at(&rig), 57);
    assert_eq!(rig.app.report().map(|report| report.step), Some(57));
    rig.press(KeyCode::Home);
    rig.press(KeyCode::Left);
    assert_eq!(looked_at(&rig), 3);
    rig.press(KeyCode::PageDown);
    rig.press(KeyCode::Right);
    assert_eq!(looked_at(&rig), 36);
    rig.press(KeyCode::End);
    assert_eq!((looked_at(&rig), rig.app.looking_back), (90, None));
    rig.press(KeyCode::Left);
    rig.press(KeyCode::Right);
    rig.press(KeyCode::Right);
    assert_eq!(rig.app.looking_back, None);
}

#[test]
fn the_picture_that_is_looked_at_stays_while_new_ones_come() {
    let mut rig = with_past(10);
    let run = rig.app.active_run().unwrap();
    // Room for about sixteen pictures, so that the past is thinned again and again.
    let bytes = run.past.bytes() / run.past.len();
    rig.app.memory = 16 * bytes;
    for _ in 0..10 {
        rig.work(3);
        rig.fetch();
    }
    rig.press(KeyCode::PageUp);
    rig.press(KeyCode::Right);
    let step = looked_at(&rig);
    for _ in 0..200 {
        rig.work(3);
        rig.fetch();
        assert_eq!(looked_at(&rig), step);
    }
    assert!(rig.run(2).report.step > 600);
    rig.keys("s");
    let Effect::SaveView(picture, 2) = rig.effect() else {
        panic!("a view is saved");
    };
    assert_eq!(picture.report.step, step);
    rig.keys("13");
    assert_eq!(rig.app.looking_back, None);
}

#[test]
fn without_a_past_there_is_nothing_to_look_back_at() {
    let mut rig = Rig::new();
    rig.press(KeyCode::Left);
    assert_eq!(rig.app.looking_back, None);
    assert!(rig.app.remark.is_some());
}

#[test]
fn the_field_goes_through_those_that_there_are() {
    let mut bare = slot("case1");
    bare.scene = scene(&["anchoring=false", "nematic=false"]).into();
    let mut rig = Rig::with(vec![bare, slot("case2"), slot("case3"), slot("case4")]);
    let mut seen = vec![rig.app.view.field];
    for _ in 0..5 {
        rig.keys("v");
        seen.push(rig.app.view.field);
    }
    let all = [
        Field::Phase,
        Field::DirectorLength,
        Field::Omega,
        Field::Mu,
        Field::EnergyDensity,
        Field::Phase,
    ];
    assert_eq!(seen, all);
    rig.keys("v1");
    assert_eq!(rig.app.view.field, Field::Phase);
    rig.keys("v");
    assert_eq!(rig.app.view.field, Field::Omega);
}

#[test]
fn styles_colours_scales_and_panels() {
    let mut rig = Rig::new();
    rig.keys("dd");
    assert_eq!(rig.app.view.director, Director::Off);
    assert_eq!(rig.app.view.zoom, Zoom::Fit);
    rig.keys("z");
    assert_eq!(rig.app.view.zoom, Zoom::Domain);
    rig.keys("zz");
    assert_eq!(rig.app.view.zoom, Zoom::Fit);
    rig.keys("dccl");
    assert_eq!(rig.app.view.director, Director::Strokes);
    assert_eq!(rig.app.view.colour_map, 2);
    assert!(rig.app.view.logarithmic);
    rig.press(KeyCode::BackTab);
    assert_eq!(rig.app.focus, Panel::Cost);
    rig.press(KeyCode::Tab);
    rig.press(KeyCode::Tab);
    assert_eq!(rig.app.focus, Panel::Energy);
}

#[test]
fn the_frame_rate_stays_within_its_bounds() {
    let mut rig = Rig::new();
    rig.keys("+");
    assert_eq!(rig.app.frames_per_second, 15);
    rig.keys("=====");
    assert_eq!(rig.app.frames_per_second, 30);
    rig.keys("---------");
    assert_eq!(rig.app.frames_per_second, 1);
    assert!(rig.app.remark.clone().unwrap().contains("1 frame a second"));
}

#[test]
fn a_remark_is_gone_with_the_next_key() {
    let mut rig = Rig::new();
    rig.keys("+");
    assert!(rig.app.remark.is_some());
    rig.keys("c");
    assert!(rig.app.remark.is_none());
}

/// The run whose shape at rest the app asks for, and the target β of its area.
fn asked_for(rig: &mut Rig) -> Vec<(RunId, f64)> {
    let asked = rig.effects.drain(..).filter_map(|effect| match effect {
        Effect::Foresee(picture, job) => {
            let target = job.scene.area.map_or(f64::NAN, |area| area.target);
            Some((picture.run, target))
        }
        _ => None,
    });
    asked.collect()
}

#[test]
fn the_shape_at_rest_is_solved_for_once_and_again_where_the_parameters_change() {
    let mut with_area = slot("case1");
    with_area.scene = scene(&["area.target=1.25"]).into();
    let mut rig = Rig::with(vec![with_area]);
    rig.work(3);
    rig.fetch();
    assert_eq!(asked_for(&mut rig), []);
    rig.keys("T");
    let runs: Vec<RunId> = rig.workers.keys().copied().collect();
    let own = rig.run(0).id;
    let with_target = |target| runs.iter().map(|run| (*run, target)).collect::<Vec<_>>();
    assert_eq!(asked_for(&mut rig), with_target(1.25));
    rig.work(3);
    rig.fetch();
    assert_eq!(asked_for(&mut rig), [], "it is being solved for");
    let circle = CurveAtRest::new(0.2, None).map(ShapeAtRest::Curve).unwrap();
    for run in &runs {
        rig.tell(Message::Foreseen(*run, Ok(Arc::new(circle.clone()))));
    }
    rig.work(3);
    assert_eq!(asked_for(&mut rig), [], "it is known");
    assert!(rig.run(0).theory.shape().is_some());
    let at = rig.run(0).report.t;
    let set = vec![Assignment {
        key: "area.target".to_owned(),
        value: ParameterValue::Number(1.3),
    }];
    let change = Change { at, over: 0.0, set };
    let event = WorkerEvent::Changed(change);
    rig.tell(Message::Solver(WorkerMessage { run: own, event }));
    assert_eq!(asked_for(&mut rig), [(own, 1.3)]);
    assert!(
        rig.run(0).theory.shape().is_some(),
        "the last one, until then"
    );
    // Hidden, nothing is asked for.
    rig.keys("Ta");
    rig.work(3);
    assert_eq!(asked_for(&mut rig), []);
}

#[test]
fn where_there_is_no_shape_at_rest_its_reason_is_told_and_it_is_hidden() {
    let mut rig = with_past(2);
    rig.keys("T");
    let own = rig.run(2).id;
    let reason = Err("there are two vesicles".to_owned());
    rig.tell(Message::Foreseen(own, reason));
    assert!(!rig.app.view.theory);
    assert_eq!(rig.app.remark.as_deref(), Some("there are two vesicles"));
    rig.keys("T");
    assert!(!rig.app.view.theory, "the reason is known");
    assert_eq!(rig.app.remark.as_deref(), Some("there are two vesicles"));
}
