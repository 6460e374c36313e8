//! How things are shown, and scrubbing.

use crossterm::event::KeyCode;

use super::super::super::message::Effect;
use super::super::super::state::{Director, Field, Panel, Zoom};
use super::rig::{Rig, scene, slot};

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
