//! The brake on quick runs, the past that is played again, and the two forms of the cases.

use std::time::Duration;

use crossterm::event::KeyCode;

use super::super::super::brake::Brake;
use super::super::super::message::Message;
use super::super::super::state::{Screen, Status};
use super::super::time_counts;
use super::rig::{Rig, slot};

/// The four cases, the third of which is shown, with a brake of 10 s for their thousand steps.
fn braked() -> Rig {
    let mut rig = Rig::new();
    rig.app.brake = Brake::new(10.0);
    rig.tell(Message::Tick);
    rig
}

/// Time passes, while the workers would compute much more than they may.
fn watch(rig: &mut Rig, seconds: f64) {
    for _ in 0..(seconds / 0.05).round() as usize {
        rig.tell(Message::Passed(Duration::from_millis(50)));
        rig.work(40);
        rig.fetch();
    }
}

fn step(rig: &Rig) -> u64 {
    rig.run(2).report.step
}

#[test]
fn a_quick_run_is_watched_and_never_ahead_of_what_is_shown() {
    let mut rig = braked();
    rig.work(500);
    assert!(step(&rig) <= 51, "{}", step(&rig));
    watch(&mut rig, 3.0);
    assert!((270..=330).contains(&step(&rig)), "{}", step(&rig));
    assert_eq!(rig.run(2).status, Status::Running);
    assert!(time_counts(&rig.app));
    rig.keys(" ");
    rig.settle();
    assert_eq!(rig.run(2).status, Status::Paused);
    assert!(!time_counts(&rig.app));
    let shown = rig.app.picture().expect("a picture").report.step;
    assert_eq!(shown, step(&rig));
    watch(&mut rig, 1.0);
    rig.keys("a ");
    watch(&mut rig, 0.2);
    // The state that was shown has got the other anchoring.
    assert_eq!(rig.run(2).history.marks.len(), 1);
    assert_eq!(rig.run(2).history.marks[0].step, shown);
    watch(&mut rig, 8.0);
    assert_eq!(rig.run(2).status, Status::Done);
    assert!(!time_counts(&rig.app));
}

#[test]
fn a_run_that_is_slower_is_not_held_up() {
    let mut rig = braked();
    let (turns, mut horizons) = (100, 0);
    for _ in 0..turns {
        let before = rig.run(2).control.horizon;
        rig.tell(Message::Passed(Duration::from_millis(50)));
        horizons += u64::from(rig.run(2).control.horizon != before);
        rig.work(1);
    }
    // A turn is a step or a command; the first ones are the start.
    assert!(horizons < 15, "{horizons}");
    assert!(step(&rig) + horizons + 6 >= turns, "{}", step(&rig));
}

#[test]
fn the_brake_can_be_taken_off_and_put_on() {
    let mut rig = braked();
    watch(&mut rig, 1.0);
    rig.keys("b");
    rig.work(300);
    assert!(step(&rig) > 350, "{}", step(&rig));
    assert_eq!(rig.run(2).control.horizon, None);
    rig.keys("b");
    rig.settle();
    let before = step(&rig);
    rig.work(500);
    assert!(step(&rig) <= before + 51, "{}", step(&rig));
    // Without one from the start it has the usual length.
    let mut rig = Rig::new();
    rig.keys("b");
    assert_eq!(rig.app.brake.seconds, 8.0);
}

#[test]
fn the_gallery_is_braked_as_a_whole() {
    let mut rig = braked();
    rig.keys("g");
    watch(&mut rig, 0.5);
    rig.work(3000);
    for slot in 0..4 {
        let step = rig.run(slot).report.step;
        assert!((40..150).contains(&step), "{slot}: {step}");
    }
    rig.keys("b");
    rig.work(6000);
    assert!((0..4).all(|slot| rig.run(slot).status == Status::Done));
}

#[test]
fn the_past_is_played_again_at_the_same_pace() {
    let mut rig = braked();
    watch(&mut rig, 12.0);
    assert_eq!(rig.run(2).status, Status::Done);
    rig.keys("P");
    let shown = |rig: &Rig| rig.app.report().expect("a report").step;
    assert!(shown(&rig) < 60);
    rig.tell(Message::Passed(Duration::from_secs(4)));
    assert!((390..=450).contains(&shown(&rig)), "{}", shown(&rig));
    // Stopped by either key, it stays there; and it is played from there.
    rig.keys(" ");
    let stopped = shown(&rig);
    assert!(rig.app.overlay.is_none() && !time_counts(&rig.app));
    rig.tell(Message::Passed(Duration::from_secs(4)));
    assert_eq!(shown(&rig), stopped);
    rig.keys("PP");
    assert_eq!(shown(&rig), stopped);
    rig.keys("P");
    assert!(time_counts(&rig.app));
    rig.tell(Message::Passed(Duration::from_secs(7)));
    // The run is over: it is played again from its start, and faster if that is asked for.
    assert!(shown(&rig) < 60 && time_counts(&rig.app));
    rig.keys("+");
    rig.tell(Message::Passed(Duration::from_secs(2)));
    assert!((390..=450).contains(&shown(&rig)), "{}", shown(&rig));
    rig.keys("P");
    rig.press(KeyCode::End);
    assert_eq!((rig.app.looking_back, rig.app.replay), (None, None));
    assert!(!time_counts(&rig.app));
    // Whoever scrubs does not want it to go on.
    rig.keys("P");
    rig.press(KeyCode::Right);
    assert_eq!(rig.app.replay, None);
    assert!(rig.app.looking_back.is_some());
}

#[test]
fn no_anchoring_is_changed_in_the_past() {
    let mut rig = braked();
    watch(&mut rig, 2.0);
    rig.press(KeyCode::Home);
    rig.keys("a");
    rig.work(2);
    assert!(rig.app.slots[2].scene.changes.is_empty());
    let remark = rig.app.remark.as_deref().expect("a reason");
    assert!(remark.contains("End shows the present"), "{remark}");
    rig.press(KeyCode::End);
    rig.keys("a");
    rig.work(2);
    assert_eq!(rig.app.slots[2].scene.changes.len(), 1);
}

#[test]
fn each_case_is_there_quick_and_as_printed() {
    let names = ["1q", "2q", "3q", "4q", "1p", "2p", "3p", "4p", "own"];
    let mut rig = Rig::with(names.map(slot).into());
    rig.app = std::mem::replace(
        &mut rig.app,
        crate::tui::state::App::new(vec![], 0, (0, 0), 1),
    )
    .with_forms(2);
    let name = |rig: &Rig| rig.app.active_slot().expect("a slot").name.clone();
    rig.keys("t");
    assert_eq!(name(&rig), "3p");
    rig.keys("1");
    assert_eq!(name(&rig), "1p");
    rig.keys("5");
    assert_eq!(name(&rig), "own");
    rig.keys("t");
    assert_eq!(name(&rig), "own");
    rig.keys("6");
    assert_eq!(name(&rig), "own");
    // What was looked at last.
    rig.keys("g");
    assert_eq!((rig.app.cases(), name(&rig)), (4..8, "1p".to_owned()));
    rig.keys("t");
    assert_eq!((rig.app.cases(), name(&rig)), (0..4, "1q".to_owned()));
    assert_eq!(rig.app.screen, Screen::Gallery);
    rig.press(KeyCode::BackTab);
    assert_eq!(name(&rig), "4q");
    rig.work(400);
    assert!((0..4).all(|slot| rig.run(slot).report.step > 20));
    assert!(rig.app.slots[7].run.is_none());
}
