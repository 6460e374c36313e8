//! Ten thousand things that happen at random: what always holds, holds.

use std::path::PathBuf;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::super::keys::BINDINGS;
use super::super::super::message::{Effect, Message};
use super::super::super::state::{App, Field, Screen, Slot, Status};
use super::rig::{Rig, scene, slot};
use crate::simulation::{Message as WorkerMessage, RunId, WorkerEvent};

const MESSAGES: usize = 10_000;

fn random_key(random: &mut ChaCha8Rng) -> KeyEvent {
    const OTHERS: [KeyCode; 17] = [
        KeyCode::Left,
        KeyCode::Right,
        KeyCode::Home,
        KeyCode::End,
        KeyCode::PageUp,
        KeyCode::PageDown,
        KeyCode::Up,
        KeyCode::Down,
        KeyCode::Tab,
        KeyCode::BackTab,
        KeyCode::Enter,
        KeyCode::Esc,
        KeyCode::Backspace,
        KeyCode::F(1),
        KeyCode::F(7),
        KeyCode::Delete,
        KeyCode::Null,
    ];
    if random.random_range(0..3) == 0 {
        let code = OTHERS[random.random_range(0..OTHERS.len())];
        return KeyEvent::new(code, KeyModifiers::NONE);
    }
    let characters: Vec<char> = " ?123456789agnsSvdclroe+-=yn/xqtbPPφ".chars().collect();
    let code = KeyCode::Char(characters[random.random_range(0..characters.len())]);
    let modifiers = match random.random_range(0..50) {
        0 => KeyModifiers::CONTROL,
        1 => KeyModifiers::ALT,
        _ => KeyModifiers::NONE,
    };
    KeyEvent::new(code, modifiers)
}

/// Something happens.
fn happen(rig: &mut Rig, random: &mut ChaCha8Rng) {
    let runs: Vec<RunId> = rig.workers.keys().copied().collect();
    let any_run = runs.get(random.random_range(0..runs.len().max(1))).copied();
    match random.random_range(0..100) {
        0..25 => rig.tell(Message::Key(random_key(random))),
        25..55 => {
            for _ in 0..random.random_range(1..20) {
                any_run.into_iter().for_each(|run| rig.turn(run));
            }
        }
        55..85 => {
            for _ in 0..random.random_range(1..20) {
                rig.deliver();
            }
        }
        85..92 => rig.fetch(),
        92 => rig.tell(Message::Resized(
            random.random_range(0..300),
            random.random_range(0..100),
        )),
        93 => {
            rig.app.stale = false;
            rig.tell(Message::Tick);
            assert!(!rig.app.stale);
        }
        94 => {
            let outcome = if random.random() {
                Ok(PathBuf::from("/some/where"))
            } else {
                Err("no room".to_owned())
            };
            rig.tell(Message::Saved(outcome));
        }
        95 => {
            let end = format!("time.end={}e-4", random.random_range(1..4));
            let number = random.random_range(0..3);
            let path = PathBuf::from(format!("{number}.toml"));
            let loaded = match random.random_range(0..3) {
                0 => Err("line 1: nothing is right".to_owned()),
                1 => Ok(Box::new(slot("circle"))),
                _ => Ok(Box::new(Slot::new("own", Some(path), scene(&[&end])))),
            };
            rig.tell(Message::Loaded(loaded));
        }
        96 => {
            // Of a run that has long been ended, or never was.
            let run = RunId(random.random_range(0..1000));
            if !rig.workers.contains_key(&run) {
                let event = WorkerEvent::Done;
                rig.tell(Message::Solver(WorkerMessage { run, event }));
            }
        }
        97 => {
            if let Some(run) = any_run {
                let computing = std::time::Duration::from_millis(random.random_range(0..9999));
                rig.tell(Message::Computing(run, computing));
            }
        }
        98 if random.random_range(0..20) == 0 => {
            any_run.into_iter().for_each(|run| rig.fail(run));
        }
        99 => rig.tell(Message::Passed(std::time::Duration::from_millis(250))),
        _ => rig.tell(Message::Continued),
    }
}

/// What holds at any time.
fn check(rig: &Rig) {
    let app = &rig.app;
    let slot = &app.slots[app.active];
    assert!(slot.run.is_some() || app.screen == Screen::Gallery);
    let [least, most] = App::FRAME_RATES;
    assert!((least..=most).contains(&app.frames_per_second));
    if app.view.field == Field::DirectorLength {
        assert!(slot.scene.nematic.is_some());
    }
    if let Some(index) = app.looking_back {
        let run = app.active_run().expect("a run with a past");
        assert!(index < run.past.len());
        assert_eq!(app.screen, Screen::Run);
    }
    assert!(app.saving_now.is_some() || app.saving_next.is_none());
    assert_eq!(app.clock.is_some(), app.screen == Screen::Gallery);
    let runs = app.slots.iter().filter_map(|slot| slot.run.as_ref());
    let stored: usize = runs.map(|run| run.past.bytes()).sum();
    assert!(stored <= 64 << 20, "{stored} bytes of older fields");
    for slot in &app.slots {
        let Some(run) = &slot.run else { continue };
        let rises = run
            .notices
            .iter()
            .any(|notice| notice.text.contains("rises"));
        assert!(!rises, "{:?}", run.notices);
        if let Some(steps) = run.steps() {
            assert!(run.report.step <= steps);
        }
    }
    for binding in BINDINGS {
        let _ = (binding.brief)(app).len();
    }
}

/// What holds when everybody has heard everything: statuses are true, and only those compute that
/// are shown.
fn check_at_rest(rig: &mut Rig) {
    rig.settle();
    let app = &rig.app;
    let mut computing = 0;
    for (index, slot) in app.slots.iter().enumerate() {
        let Some(run) = &slot.run else { continue };
        let worker = &rig.workers[&run.id];
        assert_eq!(run.report, worker.report);
        assert!(slot.scene.nematic.is_some());
        assert_eq!(slot.anchoring(), Some(worker.anchoring_to_be()));
        let is_running = run.status == Status::Running;
        assert!(!worker.computes() || is_running);
        assert!(!is_running || worker.computes() || app.brake.on);
        computing += usize::from(worker.computes());
        if worker.computes() {
            assert!(app.shows(index));
        }
        if run.status == Status::Done {
            assert_eq!(Some(run.report.step), run.steps());
        }
    }
    let most = match app.screen {
        Screen::Run => 1,
        Screen::Gallery => app.cores,
    };
    assert!(computing <= most);
}

#[test]
fn what_always_holds_holds() {
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rig = Rig::new();
        let (mut quits, mut galleries, mut saves, mut longest) = (0, 0, 0, 0);
        for message in 0..MESSAGES {
            happen(&mut rig, &mut random);
            for effect in std::mem::take(&mut rig.effects) {
                match effect {
                    Effect::SaveView(..) | Effect::SaveSet(_) => saves += 1,
                    Effect::Quit => {
                        // A user who has not saved was asked before.
                        quits += 1;
                        rig.app.ending = None;
                        rig.app.overlay = None;
                    }
                    _ => {}
                }
            }
            galleries += usize::from(rig.app.screen == Screen::Gallery);
            check(&rig);
            let steps = rig.workers.values().map(|worker| worker.report.step);
            longest = steps.fold(longest, u64::max);
            if message % 100 == 0 {
                check_at_rest(&mut rig);
            }
        }
        // It has been everywhere.
        assert!(
            quits > 0 && galleries > 100 && saves > 10,
            "{quits} {galleries} {saves}"
        );
        assert!(longest > 50, "{longest}");
    }
}
