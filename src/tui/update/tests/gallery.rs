//! Four cases side by side.

use crossterm::event::KeyCode;

use super::super::super::message::Message;
use super::super::super::state::{Screen, Status};
use super::super::common_time;
use super::rig::{Rig, scene, slot};

const STEP: f64 = 1e-6;
const END: f64 = 1e-3;

fn times(rig: &Rig) -> Vec<f64> {
    let time = |worker: &super::rig::Played| worker.report.t;
    rig.workers.values().map(time).collect()
}

fn lead(rig: &Rig) -> f64 {
    let times = times(rig);
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    times.iter().copied().fold(0.0, f64::max) - least
}

fn computing(rig: &Rig) -> usize {
    let computes = |worker: &&super::rig::Played| worker.computes();
    rig.workers.values().filter(computes).count()
}

#[test]
fn all_four_come_up_and_stay_together_on_as_many_cores_as_there_are() {
    for cores in [1, 2, 3, 4, 16] {
        let mut rig = Rig::new();
        rig.app.cores = cores;
        rig.keys("g");
        let mut busiest = 0;
        for turn in 0..10_000 {
            rig.work(1);
            let computing = computing(&rig);
            assert!(computing <= cores, "{computing} of {cores}");
            busiest = busiest.max(computing);
            if rig.workers.len() == 4 {
                // The first that is set up does not wait for the others; then they catch up.
                let most = if turn < 200 { END / 10.0 } else { END / 200.0 };
                assert!(lead(&rig) <= most + STEP, "{:?}", times(&rig));
            }
        }
        assert_eq!(busiest, cores.min(4));
        for index in 0..4 {
            assert_eq!(rig.run(index).status, Status::Done, "{cores} cores");
            assert_eq!(rig.run(index).report.step, 1000);
        }
    }
}

#[test]
fn a_case_that_is_ahead_waits_for_the_others() {
    let mut rig = Rig::new();
    rig.work(100);
    let ahead = rig.run(2).report.step;
    rig.keys("g");
    rig.work(20);
    assert!(rig.run(2).report.step <= ahead + 1);
    assert_eq!(rig.run(2).status, Status::Waiting);
    rig.work(400);
    assert!(rig.run(2).report.step > ahead + 1);
    assert!(lead(&rig) <= END / 200.0 + STEP);
}

/// The clock moves while the others are set up: what the first run has stored is shown, and they catch up.
#[test]
fn the_clock_does_not_wait_for_runs_that_are_set_up() {
    let mut rig = Rig::new();
    rig.app.cores = 2;
    rig.work(100);
    rig.keys("g");
    // None of them has reported anything yet.
    for _ in 0..20 {
        rig.tell(Message::Tick);
    }
    let clock = common_time(&rig.app).unwrap();
    assert!(clock > 0.0 && clock <= rig.run(2).report.t, "{clock}");
    rig.work(4000);
    assert_eq!(times(&rig).len(), 4);
    assert!(lead(&rig) <= END / 200.0 + STEP, "{:?}", times(&rig));
}

/// Not when a run comes up to the others, and not without the brake.
#[test]
fn the_clock_never_goes_back() {
    for cores in [1, 2, 3, 4] {
        let mut rig = Rig::new();
        rig.app.cores = cores;
        rig.work(100);
        rig.keys("g");
        let mut last = 0.0;
        for turn in 0..8000 {
            rig.work(1);
            let now = common_time(&rig.app).unwrap_or(0.0);
            assert!(
                now >= last,
                "{cores} cores, turn {turn}: from {last} to {now}"
            );
            last = now;
        }
        assert_eq!(last, END);
    }
}

/// From a fresh app: the first run that is set up goes on, also while the others take long for that; it does not go
/// far without them.
#[test]
fn the_first_run_that_is_set_up_goes_on_at_once() {
    for cores in [2, 4] {
        let mut rig = Rig::new();
        rig.app.cores = cores;
        rig.keys("g");
        let first = rig.run(2).id;
        for _ in 0..40 {
            rig.turn(first);
            rig.deliver_all();
            let computing = computing(&rig);
            assert!(computing <= cores, "{computing} of {cores}");
        }
        assert!(rig.run(2).report.step > 10, "{cores} cores");
        assert!(common_time(&rig.app).unwrap() > 0.0);
        for _ in 0..2000 {
            rig.turn(first);
            rig.deliver_all();
        }
        let t = rig.run(2).report.t;
        assert!((0.09..0.11).contains(&(t / END)), "{cores} cores: {t}");
        rig.work(4000);
        assert!((0..4).all(|index| rig.run(index).status == Status::Done));
    }
}

#[test]
fn leaving_the_gallery_leaves_one_run() {
    let mut rig = Rig::new();
    rig.keys("g");
    rig.work(50);
    rig.keys("2");
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Run, 1));
    assert_eq!(rig.app.clock, None);
    rig.settle();
    let before = times(&rig);
    rig.work(50);
    let status = |index| rig.run(index).status.clone();
    assert_eq!(
        [status(0), status(2), status(3)],
        [(); 3].map(|()| Status::Paused)
    );
    assert_eq!(status(1), Status::Running);
    let moved = before
        .iter()
        .zip(times(&rig))
        .filter(|(before, now)| **before != *now);
    assert_eq!(moved.count(), 1);
    assert!(rig.run(1).report.step > 50);
}

#[test]
fn space_pauses_and_resumes_all() {
    let mut rig = Rig::new();
    rig.keys("g");
    rig.work(50);
    rig.keys(" ");
    rig.settle();
    let before = times(&rig);
    rig.work(20);
    assert_eq!(times(&rig), before);
    for index in 0..4 {
        assert_eq!(rig.run(index).status, Status::Paused);
    }
    rig.keys(" ");
    rig.work(50);
    assert!(
        times(&rig)
            .iter()
            .zip(&before)
            .all(|(now, before)| now > before)
    );
}

#[test]
fn a_case_that_was_paused_before_does_not_hold_the_others_up() {
    let mut rig = Rig::new();
    rig.work(5);
    rig.keys(" ");
    rig.settle();
    let step = rig.run(2).report.step;
    rig.keys("g");
    rig.work(300);
    assert_eq!(
        (rig.run(2).report.step, rig.run(2).status.clone()),
        (step, Status::Paused)
    );
    assert!(rig.run(0).report.step > 50);
}

#[test]
fn a_case_that_fails_frees_its_core() {
    let mut rig = Rig::new();
    rig.app.cores = 1;
    rig.keys("g");
    rig.work(50);
    let run = rig.run(0).id;
    rig.fail(run);
    rig.work(200);
    assert!(rig.run(1).report.step > 20);
    assert!(matches!(rig.run(0).status, Status::Failed(_)));
}

#[test]
fn tab_goes_through_the_cases_and_enter_opens_one() {
    let mut rig = Rig::new();
    rig.keys("g");
    rig.press(KeyCode::Tab);
    rig.press(KeyCode::Tab);
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Gallery, 0));
    rig.press(KeyCode::BackTab);
    rig.press(KeyCode::Enter);
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Run, 3));
    // Enter and Esc mean nothing there.
    rig.press(KeyCode::Esc);
    assert_eq!(rig.app.screen, Screen::Run);
}

#[test]
fn the_gallery_shows_the_cases_only() {
    let slots = ["case1", "case2", "case3", "case4", "other"].map(slot);
    let mut rig = Rig::with(slots.into());
    rig.keys("5");
    rig.work(5);
    let step = rig.run(4).report.step;
    rig.keys("g");
    assert_eq!(rig.app.active, 0);
    rig.work(100);
    assert!(rig.run(4).report.step <= step + 1);
    assert_eq!(rig.run(4).status, Status::Paused);
}

#[test]
fn opened_scenes_have_a_gallery_of_their_own() {
    let slots = ["case1", "case2", "case3", "case4", "one", "other"].map(slot);
    let mut rig = Rig::with(slots.into());
    rig.keys("G");
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Gallery, 4));
    rig.work(100);
    assert!([4, 5].iter().all(|index| rig.run(*index).report.step > 20));
    assert!(rig.app.slots[0].run.is_none());
    // From one gallery into the other, and out of it.
    rig.keys("g");
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Gallery, 0));
    rig.keys("g");
    assert_eq!((rig.app.screen, rig.app.active), (Screen::Run, 0));
    let mut rig = Rig::new();
    rig.keys("G");
    assert_eq!(rig.app.screen, Screen::Run);
    assert!(rig.app.remark.clone().unwrap().contains("o opens one"));
}

#[test]
fn steps_longer_than_a_tick_of_the_clock_are_taken_one_by_one() {
    let coarse = |name: &str| {
        let mut slot = slot(name);
        slot.scene = scene(&["time.step=1e-4"]).into();
        slot
    };
    let mut rig = Rig::with(["1", "2", "3", "4"].map(coarse).into());
    rig.keys("g");
    for _ in 0..500 {
        rig.work(1);
        assert!(rig.workers.len() < 4 || lead(&rig) <= 1e-4 * 1.000_001);
    }
    assert!((0..4).all(|index| rig.run(index).status == Status::Done));
}
