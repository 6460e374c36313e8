//! Help, questions, opening and reloading scenes.

use std::path::PathBuf;
use std::sync::Arc;

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::super::super::autosave::Kept;
use super::super::super::keys;
use super::super::super::message::{Effect, Message};
use super::super::super::panel::{kept_words, quit_words};
use super::super::super::state::{Ending, Keeping, Overlay, Question, Slot, Status};
use super::super::offered;
use super::rig::{Rig, scene, slot};
use crate::record::KeptAt;
use crate::simulation::{Message as WorkerMessage, Report, StepProgress, WorkerEvent};

fn typed(rig: &Rig) -> (&str, Option<usize>, Option<&str>) {
    let Some(Overlay::Open {
        text,
        chosen,
        error,
    }) = &rig.app.overlay
    else {
        panic!("{:?}", rig.app.overlay);
    };
    (text, *chosen, error.as_deref())
}

fn file(settings: &[&str]) -> Box<Slot> {
    let path = PathBuf::from("my/own.toml");
    Box::new(Slot::new("own", Some(path), scene(settings)))
}

#[test]
fn the_help_scrolls_within_its_lines_and_closes() {
    let mut rig = Rig::new();
    rig.keys("?");
    rig.press(KeyCode::Up);
    assert_eq!(rig.app.overlay, Some(Overlay::Help { scroll: 0 }));
    rig.press(KeyCode::End);
    let Some(Overlay::Help { scroll }) = rig.app.overlay else {
        panic!("{:?}", rig.app.overlay);
    };
    assert!((10..100).contains(&scroll), "{scroll}");
    rig.press(KeyCode::Home);
    rig.press(KeyCode::Down);
    assert_eq!(rig.app.overlay, Some(Overlay::Help { scroll: 1 }));
    for code in [KeyCode::Esc, KeyCode::Char('q'), KeyCode::Char('?')] {
        rig.app.overlay = Some(Overlay::Help { scroll: 0 });
        rig.press(code);
        assert_eq!(rig.app.overlay, None);
    }
    assert_eq!(rig.app.ending, None);
}

#[test]
fn quitting_asks_when_something_would_be_lost() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("q");
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Quit)));
    rig.press(KeyCode::Esc);
    assert_eq!((&rig.app.overlay, &rig.app.ending), (&None, &None));
    rig.keys("qy");
    assert_eq!(rig.app.ending, Some(Ending::Quit));
    assert!(matches!(rig.effect(), Effect::Quit));

    let mut rig = Rig::new();
    rig.keys("q");
    assert_eq!(rig.app.ending, Some(Ending::Quit));
}

#[test]
fn control_c_asks_once_and_quits_from_anywhere() {
    for opening in ["", "?", "o", "r"] {
        let mut rig = Rig::new();
        rig.work(3);
        rig.keys(opening);
        rig.press_control('c');
        assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Quit)));
        rig.press_control('c');
        assert_eq!(rig.app.ending, Some(Ending::Quit), "{opening}");
    }
}

#[test]
fn releases_are_no_presses() {
    let mut rig = Rig::new();
    let mut event = KeyEvent::new(KeyCode::Char('?'), KeyModifiers::NONE);
    event.kind = KeyEventKind::Release;
    rig.tell(Message::Key(event));
    assert_eq!(rig.app.overlay, None);
}

#[test]
fn suspending_and_editing_are_effects() {
    let mut rig = Rig::new();
    for opening in ["", "?", "o"] {
        rig.keys(opening);
        rig.press_control('z');
        assert!(matches!(rig.effect(), Effect::Suspend));
        rig.press(KeyCode::Esc);
    }
    rig.app.stale = false;
    rig.tell(Message::Continued);
    assert!(rig.app.stale);
    rig.keys("e");
    assert!(matches!(rig.effect(), Effect::Edit(2)));
}

#[test]
fn a_name_is_typed_and_keys_mean_nothing_else_meanwhile() {
    let mut rig = Rig::new();
    rig.keys("oq?a");
    assert_eq!(typed(&rig), ("q?a", None, None));
    rig.press(KeyCode::Backspace);
    assert_eq!(typed(&rig).0, "q?");
    rig.press_control('u');
    rig.press(KeyCode::Enter);
    assert!(typed(&rig).2.is_some_and(|error| error.contains("type")));
    assert!(rig.effects.is_empty());
    rig.keys("my scene.toml");
    assert_eq!(typed(&rig), ("my scene.toml", None, None));
    rig.press(KeyCode::Enter);
    let Effect::Load(name) = rig.effect() else {
        panic!("a scene is loaded");
    };
    assert_eq!(name, "my scene.toml");
    rig.tell(Message::Loaded(Err("cannot read it".to_owned())));
    assert_eq!(typed(&rig), ("my scene.toml", None, Some("cannot read it")));
    rig.press(KeyCode::Esc);
    assert_eq!(rig.app.overlay, None);
}

#[test]
fn a_preset_is_chosen_or_completed() {
    assert_eq!(
        offered("cas"),
        [
            "case1",
            "case2",
            "case3",
            "case4",
            "case1-quick",
            "case2-quick",
            "case3-quick",
            "case4-quick",
            "case1-fine",
            "case2-fine",
            "case3-fine",
            "case4-fine"
        ]
    );
    let mut rig = Rig::new();
    rig.keys("ocas");
    rig.press(KeyCode::Down);
    rig.press(KeyCode::Down);
    assert_eq!(typed(&rig).1, Some(1));
    rig.press(KeyCode::Enter);
    assert!(matches!(rig.effect(), Effect::Load(name) if name == "case2"));
    rig.press(KeyCode::Up);
    rig.press(KeyCode::Up);
    assert_eq!(typed(&rig).1, None);
    rig.press(KeyCode::Up);
    assert_eq!(typed(&rig).1, Some(11));
    rig.press(KeyCode::Tab);
    assert_eq!(typed(&rig), ("case4-fine", None, None));
    rig.press_control('u');
    rig.keys("nothing like it");
    rig.press(KeyCode::Down);
    rig.press(KeyCode::Tab);
    assert_eq!(typed(&rig), ("nothing like it", None, None));
}

#[test]
fn an_opened_scene_gets_a_slot_and_a_run() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("o");
    rig.tell(Message::Loaded(Ok(file(&[]))));
    assert_eq!((rig.app.active, rig.app.slots.len()), (4, 5));
    assert_eq!(rig.app.overlay, None);
    rig.work(3);
    assert_eq!(rig.run(4).status, Status::Running);
    assert_eq!(rig.run(2).status, Status::Paused);
    rig.keys("35");
    assert_eq!(rig.app.active, 4);
    // A preset that is there already is shown.
    rig.tell(Message::Loaded(Ok(Box::new(slot("case1")))));
    assert_eq!((rig.app.active, rig.app.slots.len()), (0, 5));
    assert_eq!(rig.app.overlay, None);
}

#[test]
fn an_edited_scene_replaces_its_run_when_that_is_wanted() {
    let mut rig = Rig::new();
    rig.tell(Message::Loaded(Ok(file(&[]))));
    rig.work(5);
    let before = rig.run(4).id;
    rig.keys("a");
    rig.tell(Message::Loaded(Ok(file(&[]))));
    assert!(rig.app.remark.clone().unwrap().contains("unchanged"));
    assert_eq!(rig.run(4).id, before);

    rig.tell(Message::Loaded(Ok(file(&["time.end=2e-3"]))));
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Reload)));
    rig.keys("n");
    assert_eq!(rig.run(4).id, before);
    assert!(rig.app.reloaded.is_none());

    rig.tell(Message::Loaded(Ok(file(&["time.end=2e-3"]))));
    rig.keys("y");
    assert_ne!(rig.run(4).id, before);
    assert_eq!(rig.app.slots[4].scene.time.end, 2e-3);
    rig.work(2);
    assert_eq!(rig.run(4).steps(), Some(2000));
    assert_eq!(rig.app.slots.len(), 5);
}

#[test]
fn a_preset_that_was_not_changed_in_the_editor_gets_no_slot() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("ae");
    rig.effects.clear();
    rig.tell(Message::Loaded(Ok(file(&[]))));
    assert_eq!((rig.app.slots.len(), rig.app.active), (4, 2));
    assert!(rig.app.remark.clone().unwrap().contains("unchanged"));
    rig.keys("e");
    rig.tell(Message::Loaded(Ok(file(&["time.end=2e-3"]))));
    assert_eq!((rig.app.slots.len(), rig.app.active), (5, 4));
    assert!(rig.app.editing.is_none());
}

#[test]
fn what_was_not_changed_in_the_editor_is_not_waited_for() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("e");
    rig.tell(Message::NotEdited);
    assert!(rig.app.editing.is_none() && rig.app.overlay.is_none());
    assert!(
        rig.app
            .remark
            .clone()
            .unwrap()
            .contains("nothing was changed")
    );
}

/// More than the screen has room for is scrolled, and the footer names the keys.
#[test]
fn long_notes_are_scrolled() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.app.size = (80, 24);
    let long: Vec<String> = (0..50).map(|line| format!("line {line}")).collect();
    rig.tell(Message::Loaded(Err(long.join("\n"))));
    let scroll = |rig: &Rig| match &rig.app.overlay {
        Some(Overlay::Message { scroll, .. }) => *scroll,
        other => panic!("{other:?}"),
    };
    let named = |rig: &Rig| {
        let footer = keys::Footer::of(&rig.app);
        footer
            .first
            .iter()
            .any(|binding| (binding.brief)(&rig.app) == "scroll")
    };
    assert!(named(&rig));
    rig.press(KeyCode::Down);
    assert_eq!(scroll(&rig), 1);
    rig.press(KeyCode::End);
    assert_eq!(scroll(&rig), 30);
    rig.press(KeyCode::Down);
    rig.press(KeyCode::Up);
    assert_eq!(scroll(&rig), 29);
    rig.press(KeyCode::Home);
    assert_eq!(scroll(&rig), 0);
    rig.press(KeyCode::Esc);
    rig.tell(Message::Loaded(Err("short".to_owned())));
    assert!(!named(&rig));
}

#[test]
fn an_error_of_an_edited_scene_is_shown_whole() {
    let mut rig = Rig::new();
    rig.work(3);
    let reason = "line 3: no such key\nline 4: nor that one".to_owned();
    rig.tell(Message::Loaded(Err(reason.clone())));
    let Some(Overlay::Message { text, .. }) = &rig.app.overlay else {
        panic!("{:?}", rig.app.overlay);
    };
    assert_eq!(*text, reason);
    rig.press(KeyCode::Enter);
    assert_eq!(rig.app.overlay, None);
    assert_eq!(rig.run(2).status, Status::Running);
}

#[test]
fn runs_of_an_earlier_time_are_offered_before_anything_begins() {
    for (answer, offered_again) in [("y", true), ("n", false)] {
        let mut slots: Vec<Slot> = ["case1", "case2", "case3"].map(slot).into();
        slots[2].kept = Some(Default::default());
        let mut rig = Rig::asked(slots);
        assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::GoOn)));
        assert!(rig.app.active_run().is_none());
        rig.keys(answer);
        assert_eq!(rig.app.overlay, None);
        let run = rig.app.active_run().expect("it has begun");
        assert_eq!(run.before.is_some(), offered_again);
        let aside = rig.effects.drain(..).find_map(|effect| match effect {
            Effect::PutAside(kept) => Some(kept),
            _ => None,
        });
        // Where it was restarted what was kept is not lost.
        assert_eq!(aside.is_some_and(|kept| kept[0].0 == 2), !offered_again);
        // A restarted run begins at step 0.
        rig.keys("ry");
        assert!(rig.app.slots[2].kept.is_none());
        let run = rig.app.active_run().expect("it has begun");
        assert!(run.before.is_none());
    }
    let mut slots: Vec<Slot> = ["case1", "case2", "case3"].map(slot).into();
    slots[2].kept = Some(Default::default());
    let mut rig = Rig::asked(slots);
    rig.press_control('c');
    assert_eq!(rig.app.ending, Some(Ending::Quit));
}

#[test]
fn escape_leaves_the_runs_of_an_earlier_time_as_they_are() {
    let mut slots: Vec<Slot> = ["case1", "case2", "case3"].map(slot).into();
    slots[2].kept = Some(Default::default());
    let mut rig = Rig::asked(slots);
    rig.press(KeyCode::Esc);
    assert_eq!(rig.app.overlay, None);
    let run = rig.app.active_run().expect("it has begun");
    assert!(run.before.is_none());
    assert!(rig.effects.is_empty(), "{:?}", rig.effects);
    let told = rig.app.remark.as_deref().expect("it is told");
    assert!(told.contains("stays as it is"), "{told}");
}

#[test]
fn states_are_kept_before_it_is_said_that_they_are() {
    let mut rig = Rig::new();
    rig.work(3);
    rig.keys("q");
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::Quit)));
    let words = |rig: &Rig| quit_words(&rig.app);
    assert!(words(&rig).contains("are being kept"), "{}", words(&rig));
    let run = rig.run(2).id;
    let kept = KeptAt {
        folder: "there".into(),
        step: 3,
        bytes: 1,
    };
    rig.tell(Message::Kept(run, Keeping::Kept(kept)));
    assert!(words(&rig).contains("The runs are kept"), "{}", words(&rig));
    // Asked again, it is kept again.
    rig.keys("nq");
    assert!(words(&rig).contains("are being kept"), "{}", words(&rig));
    rig.tell(Message::Kept(
        run,
        Keeping::Failed("the disk is full".into()),
    ));
    assert!(
        words(&rig).contains("is lost: the disk is full"),
        "{}",
        words(&rig)
    );
    assert!(!words(&rig).contains("another time"), "{}", words(&rig));
    // Of figures that were saved it is not said that there are none.
    rig.fetch();
    rig.keys("n S");
    let step = rig.run(2).report.step;
    rig.tell(Message::Saved(Ok("set".into())));
    rig.keys(" ");
    rig.work(9);
    rig.keys("q");
    let words = words(&rig);
    assert!(!words.contains("No figures"), "{words}");
    assert!(
        words.contains(&format!("case3 are saved up to step {step} of ")),
        "{words}"
    );
}

#[test]
fn figures_that_are_being_saved_are_not_said_to_be_missing() {
    let mut rig = Rig::new();
    rig.work(5);
    rig.fetch();
    rig.keys(" ");
    rig.settle();
    let step = rig.run(2).report.step;
    rig.keys("Sq");
    let words = quit_words(&rig.app);
    assert!(!words.contains("No figures"), "{words}");
    let expected = format!("Figures of case3 up to step {step} are being saved");
    assert!(words.contains(&expected), "{words}");
    // There are none of the steps after those.
    rig.keys("nn");
    rig.settle();
    rig.keys("q");
    let words = quit_words(&rig.app);
    let missing = format!("No figures are saved of case3 (step {}).", step + 1);
    assert!(
        words.contains(&missing) && words.contains(&expected),
        "{words}"
    );
    rig.tell(Message::Saved(Ok("set".into())));
    let words = quit_words(&rig.app);
    let saved = format!("case3 are saved up to step {step} of {}", step + 1);
    assert!(
        words.contains(&saved) && !words.contains("being saved"),
        "{words}"
    );
}

#[test]
fn a_run_within_a_hard_step_is_said_to_be_there() {
    let mut rig = Rig::new();
    rig.settle();
    let run = rig.run(2).id;
    let event = WorkerEvent::StepProgress(StepProgress {
        step: 1,
        t: 3e-7,
        end: 1e-6,
        dt: 1e-9,
        parts: 3,
        refused: 2,
    });
    rig.tell(Message::Solver(WorkerMessage { run, event }));
    rig.keys("q");
    let words = quit_words(&rig.app);
    assert!(words.contains("case3 (within step 1, t = 3e-7)"), "{words}");
}

#[test]
fn the_question_whether_to_go_on_names_the_other_runs_of_the_scene() {
    let words = |others: &[&str]| {
        let mut slots: Vec<Slot> = ["case1", "case2", "case3"].map(slot).into();
        slots[2].kept = Some(Arc::new(Kept {
            others: others.iter().map(PathBuf::from).collect(),
            ..Kept::default()
        }));
        kept_words(&Rig::asked(slots).app)
    };
    let none = words(&[]);
    assert!(
        none.starts_with("Go on where you were: case3 at step 0 (t = 0)? "),
        "{none}"
    );
    assert!(none.ends_with("the next time."), "{none}");
    let one = words(&["saved/unfinished/case3-1a2b-2"]);
    assert!(
        one.ends_with(
            "Of case3 another run is kept in saved/unfinished/case3-1a2b-2: o opens a run by its folder."
        ),
        "{one}"
    );
    let names: Vec<String> = (2..9)
        .map(|number| format!("kept/case3-1a2b-{number}"))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let three = words(&names[..3]);
    assert!(
        three.contains("3 more runs are kept in kept/case3-1a2b-2, -3, -4: o opens"),
        "{three}"
    );
    let many = words(&names);
    assert!(
        many.contains("7 more runs are kept in kept/case3-1a2b-2, -3, -4, -5, -6 and 2 more: o"),
        "{many}"
    );
}

#[test]
fn the_prices_are_shown_while_they_are_looked_at() {
    let mut rig = Rig::new();
    rig.keys("p");
    assert!(matches!(&rig.app.overlay, Some(Overlay::Prices { .. })));
    rig.tell(Message::Prices("a table".to_owned()));
    let text = "a table".to_owned();
    assert_eq!(rig.app.overlay, Some(Overlay::Prices { text }));
    rig.press(KeyCode::Esc);
    assert_eq!(rig.app.overlay, None);
    rig.tell(Message::Prices("too late".to_owned()));
    assert_eq!(rig.app.overlay, None);
}

/// The names of scenes whose price the app wants measured.
fn asked_prices(rig: &mut Rig) -> Vec<String> {
    let asked = rig.effects.drain(..).filter_map(|effect| match effect {
        Effect::Expect(name, _) => Some(name),
        _ => None,
    });
    asked.collect()
}

#[test]
fn the_dialog_tells_what_the_chosen_scene_would_take() {
    let mut rig = Rig::new();
    rig.keys("ocircl");
    assert!(asked_prices(&mut rig).is_empty(), "that is no scene's name");
    rig.keys("e");
    assert_eq!(asked_prices(&mut rig), ["circle"]);
    // Something else is shown before that is known: one at a time.
    rig.press_control('u');
    rig.keys("case1");
    assert!(asked_prices(&mut rig).is_empty());
    rig.tell(Message::Expected(
        "circle".into(),
        Some(Ok("about 3 s".into())),
    ));
    assert_eq!(asked_prices(&mut rig), ["case1"]);
    // What is not shown any more may be left unknown.
    rig.tell(Message::Expected("case1".into(), None));
    assert_eq!(asked_prices(&mut rig), ["case1"]);
    assert_eq!(rig.app.expectation.words("circle"), Some(Ok("about 3 s")));
    rig.tell(Message::Expected(
        "case1".into(),
        Some(Ok("about 9 min".into())),
    ));
    assert!(asked_prices(&mut rig).is_empty());
    assert_eq!(rig.app.expectation.words("case1"), Some(Ok("about 9 min")));
    rig.press(KeyCode::Esc);
    assert!(asked_prices(&mut rig).is_empty());
}

/// The list is measured line by line, and Enter runs the line that is chosen in a place of its own.
#[test]
fn the_price_list_is_measured_and_a_line_of_it_is_run() {
    let mut rig = Rig::new();
    rig.keys("i");
    let name = rig.app.slots[2].scene.name.clone();
    for error in ["1e-1", "3e-2", "1e-2", "3e-3", "1e-3"] {
        let asked = format!("{name}, error {error}");
        assert_eq!(asked_prices(&mut rig), std::slice::from_ref(&asked));
        rig.tell(Message::Expected(asked, Some(Ok("about 3 s".into()))));
    }
    assert!(asked_prices(&mut rig).is_empty(), "all are known");
    let Some(Overlay::Accuracy(list)) = &rig.app.overlay else {
        panic!("{:?}", rig.app.overlay);
    };
    let known = list
        .rows
        .iter()
        .all(|(_, price)| *price == Some(Ok("about 3 s".into())));
    assert!(known, "{list:?}");
    rig.press(KeyCode::Esc);
    assert_eq!((rig.app.slots.len(), rig.app.active), (4, 2));
    rig.keys("i");
    for _ in 0..2 {
        rig.press(KeyCode::Down);
    }
    rig.press(KeyCode::Enter);
    assert_eq!((rig.app.slots.len(), rig.app.active), (5, 4));
    let slot = &rig.app.slots[4];
    assert_eq!(slot.name, "case3-1e-2");
    assert_eq!(slot.scene.time.tolerance, Some(5e-3));
    assert!(slot.run.is_some(), "it has begun");
    assert!(rig.app.slots[2].run.is_some(), "the other waits");
}

#[test]
fn a_file_that_is_called_as_a_preset_has_another_name() {
    let mut rig = Rig::new();
    let mut slot = slot("case3");
    slot.file = Some("case3.toml".into());
    rig.tell(Message::Loaded(Ok(Box::new(slot))));
    assert_eq!(rig.app.slots[4].name, "case3.toml");
}

#[test]
fn a_run_that_is_over_is_shown_when_its_folder_is_opened() {
    for (is_over, end) in [(true, 0.0), (false, 1.0)] {
        let mut rig = Rig::new();
        let mut slot = slot("mine");
        slot.folder = Some("runs/mine".into());
        slot.kept = Some(Default::default());
        Arc::make_mut(&mut slot.scene).time.end = end;
        rig.tell(Message::Loaded(Ok(Box::new(slot))));
        assert_eq!(rig.app.overlay.is_none(), is_over);
        let run = rig.app.slots[4].run.as_ref();
        assert_eq!(run.is_some_and(|run| run.before.is_some()), is_over);
        let Some(run) = run.map(|run| run.id) else {
            continue;
        };
        // What it stands at was computed before, the step after it was not.
        for (step, is_computed) in [(5, false), (6, true)] {
            let report = Report {
                step,
                ..Report::default()
            };
            let event = WorkerEvent::Reports(vec![report]);
            rig.tell(Message::Solver(WorkerMessage { run, event }));
            assert_eq!(rig.run(4).unsaved, is_computed);
        }
    }
}

#[test]
fn a_kept_run_of_an_opened_scene_is_offered_too() {
    let mut rig = Rig::new();
    let mut slot = slot("mine");
    slot.kept = Some(Default::default());
    rig.tell(Message::Loaded(Ok(Box::new(slot))));
    assert_eq!(rig.app.overlay, Some(Overlay::Confirm(Question::GoOn)));
    assert!(rig.app.slots[4].run.is_none());
    rig.keys("y");
    assert!(
        rig.app.slots[4]
            .run
            .as_ref()
            .is_some_and(|run| run.before.is_some())
    );
}
