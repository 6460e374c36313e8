//! Starting, pausing, switching, anchoring, failing.

use crate::tui::state::Notice;
use crossterm::event::KeyCode;

use super::super::super::message::{Effect, Message};
use super::super::super::state::{Beyond, Overlay, Question, Run, Severity, Status};
use super::rig::{Rig, scene, slot};
use crate::physics::NamedValue;
use crate::scene::{AnchoringKind, Assignment, Change, Geometry, ParameterValue, Warning};
use crate::simulation::{
    Event, EventKind, Message as WorkerMessage, Report, RunId, StepProgress, VesicleChange,
    WorkerEvent,
};

/// A worker of the active run says this.
fn say(rig: &mut Rig, event: WorkerEvent) {
    let run = rig.app.active_run().map(|run| run.id).unwrap();
    rig.tell(Message::Solver(WorkerMessage { run, event }));
}

/// After which steps something was marked, and what.
fn marked(run: &Run) -> Vec<(u64, &str)> {
    let marks = run.history.marks.iter();
    let named = marks.filter_map(|mark| Some((mark.step, mark.name()?)));
    named.collect()
}

fn status(rig: &Rig, slot: usize) -> Status {
    rig.run(slot).status.clone()
}

#[test]
fn the_first_message_starts_the_run_that_is_looked_at() {
    let mut rig = Rig::new();
    assert_eq!(rig.workers.len(), 1);
    assert_eq!(status(&rig, 2), Status::Starting);
    assert!(rig.app.slots[0].run.is_none());
    rig.work(1);
    assert_eq!(status(&rig, 2), Status::Running);
    rig.work(10);
    let run = rig.run(2);
    assert_eq!(run.report.step, 11);
    assert_eq!(run.history.total_energy.at_start(), Some(190.0));
    assert_eq!(run.steps(), Some(1000));
    assert!(run.unsaved);
}

#[test]
fn the_status_is_what_the_worker_has_told() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys(" ");
    assert_eq!(status(&rig, 2), Status::Pausing);
    let run = rig.run(2).id;
    rig.turn(run);
    rig.turn(run);
    assert_eq!(status(&rig, 2), Status::Pausing);
    rig.deliver_all();
    assert_eq!(status(&rig, 2), Status::Paused);
    let step = rig.run(2).report.step;
    rig.work(5);
    assert_eq!(rig.run(2).report.step, step);
    rig.keys(" ");
    assert_eq!(status(&rig, 2), Status::Paused);
    rig.work(2);
    assert_eq!(status(&rig, 2), Status::Running);
    rig.work(2000);
    assert_eq!(status(&rig, 2), Status::Done);
    assert_eq!(rig.run(2).report.step, 1000);
}

/// A step that takes long: how far it is shows, and leaving it asks.
#[test]
fn a_hard_first_step_is_shown_and_asked_about() {
    let mut rig = Rig::new();
    let run = rig.run(2).id;
    rig.turn(run);
    while let Some(message) = rig.on_the_way.pop_front() {
        // Set up, and at no step.
        if matches!(message.event, WorkerEvent::Ready(_)) {
            rig.tell(Message::Solver(message));
        }
    }
    assert!(!rig.run(2).unsaved);
    let underway = StepProgress {
        step: 1,
        t: 2.6e-8,
        end: 1e-6,
        dt: 1.5e-11,
        parts: 84,
        refused: 14,
    };
    say(&mut rig, WorkerEvent::StepProgress(underway));
    assert_eq!(rig.run(2).underway, Some(underway));
    let told = underway.to_string();
    for words in [
        "step 1 takes long",
        "t = 2.600e-8 of 1.000e-6",
        "84 parts",
        "= 1.5e-11",
    ] {
        assert!(told.contains(words), "{told}");
    }
    rig.keys("q");
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Quit)));
    rig.press(KeyCode::Esc);
    let report = Report {
        step: 1,
        ..Report::default()
    };
    say(&mut rig, WorkerEvent::Reports(vec![report]));
    assert_eq!(rig.run(2).underway, None);
}

/// A run that has reached its end continues to a later one if that is wanted, and otherwise stays as it was.
#[test]
fn keys_that_a_run_at_its_end_cannot_follow_ask_whether_it_goes_on() {
    for (key, beyond) in [
        (" ", Beyond::Run),
        ("n", Beyond::Step),
        ("a", Beyond::Anchor(AnchoringKind::Parallel)),
    ] {
        let mut rig = Rig::new();
        rig.work(2000);
        rig.keys(key);
        let question = Overlay::Confirm(Question::GoBeyond(beyond));
        assert_eq!(rig.app.overlay, Some(question.clone()), "{key:?}");
        rig.press(KeyCode::Esc);
        rig.settle();
        assert_eq!(
            (rig.run(2).report.step, status(&rig, 2)),
            (1000, Status::Done)
        );
        assert_eq!(
            rig.app.slots[2].anchoring(),
            Some(AnchoringKind::Homeotropic)
        );
        assert_eq!(
            rig.app.slots[2].anchoring(),
            Some(AnchoringKind::Homeotropic)
        );
        assert!(rig.run(2).history.marks.is_empty() && rig.app.remark.is_none());

        rig.keys(key);
        assert_eq!(rig.app.overlay, Some(question), "{key:?}");
        rig.keys("y");
        rig.settle();
        assert_eq!(rig.run(2).steps(), Some(2000));
        if key == "n" {
            assert_eq!(
                (rig.run(2).report.step, status(&rig, 2)),
                (1001, Status::Paused)
            );
            rig.keys(" ");
        } else {
            assert_eq!(status(&rig, 2), Status::Running);
        }
        let marks = match key {
            "a" => vec![(1000, "parallel")],
            _ => Vec::new(),
        };
        if key == "a" {
            rig.work(1);
        }
        assert_eq!(marked(rig.run(2)), marks);
        rig.work(2000);
        assert_eq!(
            (rig.run(2).report.step, status(&rig, 2)),
            (2000, Status::Done)
        );
        // Once more, and again to the end that the scene has.
        rig.keys(" y");
        rig.settle();
        assert_eq!(rig.run(2).steps(), Some(4000));
        rig.keys("ry");
        rig.work(2);
        assert_eq!(rig.run(2).steps(), Some(1000));
    }
}

#[test]
fn pausing_while_the_run_is_set_up() {
    let mut rig = Rig::new();
    rig.keys(" ");
    assert_eq!(status(&rig, 2), Status::Pausing);
    rig.work(3);
    assert_eq!(status(&rig, 2), Status::Paused);
    assert_eq!(rig.run(2).report.step, 0);
    assert!(!rig.run(2).unsaved);
}

#[test]
fn one_step_of_a_paused_run_and_of_a_running_one() {
    let mut rig = Rig::new();
    rig.keys(" ");
    rig.work(3);
    rig.keys("n");
    assert_eq!(status(&rig, 2), Status::Pausing);
    rig.work(3);
    assert_eq!(
        (rig.run(2).report.step, status(&rig, 2)),
        (1, Status::Paused)
    );
    rig.keys("nn");
    rig.work(5);
    assert_eq!(
        (rig.run(2).report.step, status(&rig, 2)),
        (3, Status::Paused)
    );
    rig.keys(" ");
    rig.work(5);
    let step = rig.run(2).report.step;
    rig.keys("n");
    rig.work(5);
    assert_eq!(rig.run(2).report.step, step + 1);
    assert_eq!(status(&rig, 2), Status::Paused);
}

#[test]
fn a_case_that_is_left_waits_where_it_is_and_then_goes_on() {
    let mut rig = Rig::new();
    rig.work(10);
    rig.keys("a1");
    rig.work(3);
    assert_eq!(status(&rig, 2), Status::Paused);
    assert_eq!(status(&rig, 0), Status::Running);
    let (id, step) = (rig.run(2).id, rig.run(2).report.step);
    rig.work(20);
    assert_eq!(rig.run(2).report.step, step);
    assert!(rig.run(0).report.step > 15);
    rig.keys("3");
    rig.work(5);
    assert_eq!(rig.run(2).id, id);
    assert!(rig.run(2).report.step > step);
    assert_eq!(status(&rig, 0), Status::Paused);
    assert_eq!(rig.app.slots[2].anchoring(), Some(AnchoringKind::Parallel));
    assert_eq!(
        rig.app.slots[0].anchoring(),
        Some(AnchoringKind::Homeotropic)
    );
    let told = rig.worker(2).report.total_energy;
    assert!((100.0..150.0).contains(&told), "{told}");
}

#[test]
fn a_case_that_was_paused_stays_paused() {
    let mut rig = Rig::new();
    rig.work(4);
    rig.keys(" ");
    rig.work(2);
    rig.keys("1");
    rig.work(4);
    rig.keys("3");
    rig.work(4);
    assert_eq!(status(&rig, 2), Status::Paused);
    // And without waiting for anything.
    rig.keys("131313");
    rig.settle();
    assert_eq!(status(&rig, 2), Status::Paused);
    assert_eq!(status(&rig, 0), Status::Paused);
    rig.keys("1");
    rig.work(4);
    assert_eq!(status(&rig, 0), Status::Running);
}

#[test]
fn a_slot_that_is_not_there_is_said() {
    let mut rig = Rig::with(vec![slot("case1"), slot("case2")]);
    assert_eq!(rig.app.active, 1);
    rig.keys("4");
    assert_eq!(rig.app.active, 1);
    assert!(rig.app.remark.clone().unwrap().contains("2 scenes"));
}

#[test]
fn restart_asks_only_when_something_would_be_lost() {
    let mut rig = Rig::new();
    let first = rig.run(2).id;
    rig.keys("r");
    assert_eq!(rig.app.overlay, None);
    assert_ne!(rig.run(2).id, first);
    rig.work(5);
    let second = rig.run(2).id;
    rig.keys("r");
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Restart)));
    rig.keys("xrn");
    assert_eq!(rig.app.overlay, None);
    assert_eq!(rig.run(2).id, second);
    rig.keys("ary");
    assert_ne!(rig.run(2).id, second);
    assert_eq!(rig.run(2).report.step, 0);
    assert_eq!(rig.app.slots[2].anchoring(), Some(AnchoringKind::Parallel));
    assert_eq!(rig.workers.len(), 1);
    rig.work(3);
    assert_eq!(status(&rig, 2), Status::Running);
}

#[test]
fn news_of_an_ended_run_are_dropped() {
    let mut rig = Rig::new();
    rig.work(5);
    let old = rig.run(2).id;
    for _ in 0..5 {
        rig.turn(old);
    }
    let late: Vec<_> = rig.on_the_way.drain(..).collect();
    assert!(!late.is_empty());
    let picture = {
        rig.fetch();
        rig.run(2).picture.clone().unwrap()
    };
    rig.keys("ry");
    rig.app.stale = false;
    for message in late {
        rig.tell(Message::Solver(message));
    }
    rig.tell(Message::Fields(picture));
    let computing = std::time::Duration::from_secs(1);
    rig.tell(Message::Computing(old, computing));
    assert!(!rig.app.stale);
    let run = rig.run(2);
    assert_eq!((run.report.step, run.picture.is_none()), (0, true));
    assert_eq!(run.history.total_energy.last(), None);
    assert_eq!(run.past.len(), 0);
    assert_eq!(run.status, Status::Starting);
}

#[test]
fn the_anchoring_goes_round_and_is_marked_and_nothing_rises() {
    let mut rig = Rig::new();
    rig.work(4);
    let kinds = [
        AnchoringKind::Parallel,
        AnchoringKind::None,
        AnchoringKind::Homeotropic,
    ];
    for kind in kinds {
        let before = rig.run(2).report.clone();
        rig.keys("a");
        assert!(rig.app.remark.clone().unwrap().contains(kind.name()));
        // At the first turn of the worker it is confirmed, and the next step has it.
        rig.work(1);
        let run = rig.run(2);
        assert_eq!(rig.app.slots[2].anchoring(), Some(kind));
        assert_eq!(run.report.step, before.step);
        rig.work(1);
        let run = rig.run(2);
        assert_eq!(run.report.step, before.step + 1);
        assert!((run.report.total_energy - before.total_energy).abs() > 1.0);
        rig.work(2);
    }
    let run = rig.run(2);
    let marks: Vec<_> = marked(run).into_iter().map(|(_, name)| name).collect();
    assert_eq!(marks, kinds.map(AnchoringKind::name));
    let is_log = |notice: &Notice| notice.severity == Severity::Log;
    assert!(run.notices.iter().all(is_log), "{:?}", run.notices);
    assert_eq!(run.history.energies.len(), 2);
}

/// Until the worker confirms it, a switch is a wish: the scene keeps the anchoring that is in force.
#[test]
fn only_the_worker_s_confirmation_changes_the_scene() {
    let mut rig = Rig::new();
    rig.work(4);
    let homeotropic = Some(AnchoringKind::Homeotropic);
    rig.keys("a");
    assert_eq!(rig.app.slots[2].anchoring(), homeotropic);
    rig.settle();
    let parallel = Some(AnchoringKind::Parallel);
    assert_eq!(rig.app.slots[2].anchoring(), parallel);
    // A run that fails before it has switched was computed with the old anchoring; the next one has the new.
    rig.keys("a");
    let id = rig.run(2).id;
    rig.fail(id);
    rig.deliver_all();
    assert_eq!(rig.app.slots[2].anchoring(), parallel);
    rig.keys("ry");
    let none = Some(AnchoringKind::None);
    assert_eq!(rig.app.slots[2].anchoring(), none);
}

#[test]
fn three_quick_switches_are_three() {
    let mut rig = Rig::new();
    rig.work(4);
    rig.keys("aaa");
    rig.settle();
    assert_eq!(rig.app.slots[2].scene.changes.len(), 3);
    assert_eq!(
        rig.app.slots[2].anchoring(),
        Some(AnchoringKind::Homeotropic)
    );
}

#[test]
fn without_a_director_there_is_no_anchoring_and_no_length() {
    let mut bare = slot("case3");
    bare.scene = scene(&["anchoring=false", "nematic=false"]).into();
    let mut rig = Rig::with(vec![slot("case1"), slot("case2"), bare, slot("case4")]);
    rig.work(3);
    rig.effects.clear();
    rig.keys("a");
    assert!(rig.app.remark.clone().unwrap().contains("no director"));
    assert!(rig.run(2).history.marks.is_empty());
    assert_eq!(rig.app.slots[2].anchoring(), None);
}

#[test]
fn an_energy_that_rises_is_said_once_with_its_step() {
    let mut rig = Rig::new();
    rig.work(4);
    let step = rig.run(2).report.step;
    rig.worker(2).mistake = 1.0;
    rig.work(3);
    let notices: Vec<_> = rig.run(2).notices.iter().cloned().collect();
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert_eq!(
        (notices[0].step, notices[0].severity),
        (step + 1, Severity::Warning)
    );
    assert!(
        notices[0].text.contains("energy rises"),
        "{}",
        notices[0].text
    );
    rig.worker(2).mistake = 2.0;
    rig.work(1);
    assert_eq!(rig.run(2).notices.len(), 2);
}

#[test]
fn what_rounding_does_to_the_energy_is_no_rise() {
    let mut rig = Rig::new();
    rig.work(1);
    for (step, energy) in [(2, 100.0), (3, 100.0 + 0.9e-6), (4, 100.0 + 2.0e-6)] {
        let energies = vec![NamedValue {
            name: "bending",
            value: energy,
        }];
        say(
            &mut rig,
            WorkerEvent::Reports(vec![Report {
                step,
                total_energy: energy,
                energies,
                ..Report::default()
            }]),
        );
        // The tolerance of the law is 1e-8 of the energy.
        assert_eq!(rig.run(2).notices.len(), usize::from(step == 4));
    }
}

#[test]
fn a_number_that_is_none_pauses_the_run() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.worker(2).mistake = f64::NAN;
    rig.work(1);
    let step = rig.run(2).report.step;
    rig.work(5);
    let run = rig.run(2);
    assert_eq!((run.report.step, &run.status), (step, &Status::Paused));
    assert_eq!(run.notices.len(), 1, "{:?}", run.notices);
    assert_eq!(
        (run.notices[0].severity, run.notices[0].step),
        (Severity::Error, step)
    );
}

#[test]
fn a_run_that_fails_says_so_and_the_app_lives() {
    let mut rig = Rig::new();
    rig.work(5);
    let step = rig.run(2).report.step;
    let id = rig.run(2).id;
    rig.fail(id);
    rig.deliver_all();
    let run = rig.run(2);
    assert_eq!(run.status, Status::Failed("it did not converge".to_owned()));
    let notice = run.notices.back().unwrap();
    assert_eq!((notice.severity, notice.step), (Severity::Error, step));
    rig.keys(" ");
    assert!(rig.app.remark.clone().unwrap().contains("has failed"));
    rig.keys("a");
    assert!(
        rig.app
            .remark
            .clone()
            .unwrap()
            .contains("when the run is restarted")
    );
    assert!(rig.app.ending.is_none());
    rig.keys("1");
    rig.settle();
    assert!(matches!(status(&rig, 2), Status::Failed(_)));
    rig.keys("3ry");
    rig.work(3);
    assert_eq!(status(&rig, 2), Status::Running);
    assert_eq!(rig.app.slots[2].anchoring(), Some(AnchoringKind::Parallel));
}

#[test]
fn warnings_and_events_become_notices() {
    let mut rig = Rig::new();
    rig.work(2);
    let kind = EventKind::ReachedWall;
    say(
        &mut rig,
        WorkerEvent::Event(Event {
            step: 2,
            t: 2e-6,
            kind,
        }),
    );
    let notice = rig.run(2).notices.back().unwrap().clone();
    assert_eq!((notice.step, notice.severity), (2, Severity::Warning));
    assert!(notice.text.contains("wall"));
}

/// What the solver did, and what was asked for, is in the list of all, after what the user must know.
#[test]
fn what_the_solver_did_is_logged_and_what_happened_is_marked() {
    let mut rig = Rig::new();
    rig.work(2);
    let change = VesicleChange::Merged;
    let counts = [2, 1];
    let set = vec![Assignment {
        key: "field.strength".to_owned(),
        value: ParameterValue::Number(2.0),
    }];
    let (at, over) = (2e-6, 0.0);
    let stronger = Change { at, over, set };
    let kinds = [
        (EventKind::ReachedWall, Severity::Warning),
        (EventKind::Damped { factor: 0.1 }, Severity::Log),
        (EventKind::FactorIsFaster, Severity::Log),
        (
            EventKind::ParametersChanged {
                changes: vec![stronger],
                work: 1.0,
            },
            Severity::Log,
        ),
        (
            EventKind::VesiclesChanged { change, counts },
            Severity::Note,
        ),
    ];
    for (kind, severity) in kinds {
        let (step, t) = (2, 2e-6);
        say(&mut rig, WorkerEvent::Event(Event { step, t, kind }));
        assert_eq!(rig.run(2).notices.back().unwrap().severity, severity);
    }
    let marks = [(2, "wall"), (2, "field.strength = 2.0"), (2, "merged")];
    assert_eq!(marked(rig.run(2)), marks);
    rig.keys("w");
    let Some(Overlay::Message { text, .. }) = &rig.app.overlay else {
        unreachable!("no list: {:?}", rig.app.overlay);
    };
    let place = |words: &str| {
        text.find(words)
            .unwrap_or_else(|| panic!("{words}: {text}"))
    };
    let order = ["wall", "have merged", "on the way", "damped"].map(place);
    assert!(order.is_sorted(), "{text}");
}

#[test]
fn a_target_out_of_reach_is_said_at_the_start() {
    let mut rig = Rig::new();
    rig.work(1);
    let mut setting = (**rig.run(2).setting.as_ref().unwrap()).clone();
    setting.warnings = vec![Warning::TargetOutOfReach {
        target: 0.75,
        quotient: 0.69,
        geometry: Geometry::Planar,
    }];
    rig.keys("ry");
    say(&mut rig, WorkerEvent::Ready(setting.into()));
    let notice = &rig.run(2).notices[0];
    assert_eq!((notice.step, notice.severity), (0, Severity::Warning));
    assert!(notice.text.contains("0.5625"), "{}", notice.text);
}

#[test]
fn only_what_shows_makes_the_screen_stale() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("1");
    rig.settle();
    rig.work(3);
    rig.app.stale = false;
    rig.tell(Message::Tick);
    rig.tell(Message::Resized(80, 24));
    rig.tell(Message::Computing(
        RunId(999),
        std::time::Duration::from_secs(1),
    ));
    rig.press(KeyCode::F(9));
    assert!(!rig.app.stale);
    // A picture of a run that is not shown.
    let hidden = rig.run(2).id;
    rig.turn(hidden);
    rig.deliver_all();
    assert!(!rig.app.stale);
    rig.tell(Message::Resized(81, 24));
    assert!(rig.app.stale);
    rig.app.stale = false;
    let shown = rig.run(0).id;
    rig.tell(Message::Computing(shown, std::time::Duration::from_secs(1)));
    assert!(rig.app.stale);
    rig.app.stale = false;
    rig.tell(Message::Computing(shown, std::time::Duration::from_secs(1)));
    assert!(!rig.app.stale);
    rig.work(1);
    assert!(rig.app.stale);
}

#[test]
fn signals_and_a_lost_terminal_end_the_app_without_asking() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("1");
    rig.work(3);
    rig.keys("3");
    rig.tell(Message::HungUp);
    // The states are kept by the workers' end; figures can be made from them later.
    assert!(matches!(rig.effect(), Effect::Quit));
    rig.keys("1q");
    rig.tell(Message::Signal(15));
    assert!(rig.effects.is_empty());

    let mut rig = Rig::new();
    rig.tell(Message::Signal(15));
    assert!(matches!(rig.effect(), Effect::Quit));
}
