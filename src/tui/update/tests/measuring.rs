//! The measured error of a run: asked for, coming in, shown, and of no use any more.

use std::sync::Arc;

use super::super::super::measuring::MeasuringJob;
use super::super::super::message::{Effect, Message};
use super::super::super::state::{MeasuringNews, Overlay};
use super::rig::Rig;
use crate::simulation::{Message as WorkerMessage, RunId, WorkerEvent};
use crate::study::{ErrorRow, Measured};

fn row(t: f64) -> ErrorRow {
    let phase = Measured {
        error: 1e-2,
        uncertainty: 2e-3,
    };
    ErrorRow {
        t,
        order: Some(1.9),
        phase,
        membrane: None,
        scalars: vec![("waist".to_owned(), 0.2, phase)],
    }
}

/// The active run at its first snapshot, and its job once `m` is pressed.
fn asked(rig: &mut Rig) -> (RunId, MeasuringJob) {
    rig.work(3);
    let run = rig.run(2).id;
    let mut picture = (*snapshot(rig)).clone();
    picture.report.step = 0;
    picture.report.t = 0.0;
    let event = WorkerEvent::Snapshot(Arc::new(picture));
    rig.tell(Message::Solver(WorkerMessage { run, event }));
    rig.keys("m");
    match rig.effect() {
        Effect::Measure(of, job) => (of, *job),
        other => panic!("{other:?}"),
    }
}

fn snapshot(rig: &mut Rig) -> Arc<crate::simulation::RunSnapshot> {
    rig.fetch();
    rig.app.picture().expect("a picture").clone()
}

#[test]
fn what_is_measured_comes_in_and_is_shown() {
    let mut rig = Rig::new();
    let (run, job) = asked(&mut rig);
    assert_eq!(job.times, [0.0, 2.5e-4, 5e-4, 7.5e-4, 1e-3]);
    assert!(job.states.iter().any(|state| state.report.step == 0));
    rig.tell(Message::Measured(run, MeasuringNews::Share(0.3)));
    rig.tell(Message::Measured(run, MeasuringNews::Row(row(2.5e-4))));
    rig.tell(Message::Measured(run, MeasuringNews::Row(row(0.0))));
    let measurement = rig.run(2).measurement.as_ref().expect("one");
    assert!(measurement.is_going && measurement.share == 0.3);
    assert_eq!(measurement.at(2e-4).map(|row| row.t), Some(0.0));
    assert_eq!(measurement.at(2.5e-4).map(|row| row.t), Some(2.5e-4));
    rig.tell(Message::Measured(run, MeasuringNews::Done));
    assert!(!rig.run(2).is_measured());
    rig.keys("m");
    assert_eq!(rig.app.overlay, Some(Overlay::Measured));
    // One that nobody knows any more.
    rig.tell(Message::Measured(RunId(99), MeasuringNews::Done));
}

#[test]
fn one_at_a_time_and_the_key_ends_it() {
    let mut rig = Rig::new();
    asked(&mut rig);
    rig.keys("1");
    rig.work(3);
    rig.keys("m");
    let remark = rig.app.remark.clone().expect("a reason");
    assert!(remark.contains("case3 is being measured"), "{remark}");
    rig.keys("3m");
    assert!(!rig.run(2).is_measured());
    rig.keys("m");
    assert!(rig.run(2).is_measured());
}

#[test]
fn a_switch_ends_it_and_is_switched_again_in_the_next() {
    let mut rig = Rig::new();
    let (run, _) = asked(&mut rig);
    rig.tell(Message::Measured(run, MeasuringNews::Row(row(0.0))));
    rig.keys("a");
    rig.settle();
    assert!(!rig.run(2).is_measured());
    let t = rig.run(2).report.t;
    rig.keys("m");
    let Effect::Measure(_, job) = rig.effect() else {
        panic!("it is measured again");
    };
    let change = job.scene.changes.first().expect("the change");
    assert_eq!((change.at, change.label()), (t, "parallel".to_owned()));
}

#[test]
fn what_cannot_be_measured_is_said() {
    let mut rig = Rig::new();
    let (run, _) = asked(&mut rig);
    let words = "there is no memory".to_owned();
    rig.tell(Message::Measured(run, MeasuringNews::Failed(words)));
    let notice = rig.run(2).notices.back().expect("a notice");
    assert!(notice.text.contains("there is no memory"));
    assert_eq!(rig.run(2).measurement, None);
}
