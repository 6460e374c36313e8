//! The app with real workers: what the played ones promise is what the real ones do.

use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::Duration;

use crossterm::event::KeyCode;

use super::super::super::message::{Effect, Message};
use super::super::super::state::{App, Slot, Status};
use super::super::update;
use crate::scene::{AnchoringKind, Scene};
use crate::simulation::{Costs, Message as WorkerMessage, Report, RunId, Simulation, Worker};

/// Long enough for anything but a hang.
const PATIENCE: Duration = Duration::from_secs(60);

struct Watched {
    app: App,
    workers: BTreeMap<RunId, Worker>,
    sender: Sender<WorkerMessage>,
    event: Receiver<WorkerMessage>,
}

fn scene(kind: &str) -> Scene {
    let text = "
        [mesh]
        cells = 8
        [time]
        step = 1e-6
        end = 6e-5
        [membrane]
        interface_width = 0.06
        [area]
        [nematic]
        initial = [0.6, 0.8]
        [anchoring]
    ";
    let setting = format!("anchoring.kind={kind}");
    Scene::of_text(text, &[&setting])
}

impl Watched {
    fn new(slots: Vec<Slot>) -> Self {
        let mut app = App::new(slots, 0, (80, 24), 10);
        app.cores = 2;
        let (sender, event) = mpsc::channel();
        let workers = BTreeMap::new();
        let mut watched = Self {
            app,
            workers,
            sender,
            event,
        };
        watched.tell(Message::Tick);
        watched
    }

    fn tell(&mut self, message: Message) {
        for effect in update(&mut self.app, message) {
            match effect {
                Effect::Start(orders, scene) => {
                    let sender = self.sender.clone();
                    let sink = move |message| {
                        // At the end of a test nobody listens.
                        let _ = sender.send(message);
                    };
                    let run = orders.run;
                    self.workers.insert(run, Worker::start(orders, scene, sink));
                }
                Effect::Tell(run, command) => self.workers[&run].tell(command),
                Effect::Drop(run) | Effect::Discard(run) => drop(self.workers.remove(&run)),
                other => panic!("{other:?}"),
            }
        }
    }

    fn press(&mut self, character: char) {
        self.tell(Message::Key(KeyCode::Char(character).into()));
    }

    /// Listens until something holds.
    fn until(&mut self, holds: impl Fn(&App) -> bool) {
        while !holds(&self.app) {
            let message = self.event.recv_timeout(PATIENCE).unwrap();
            self.tell(Message::Solver(message));
        }
    }
}

fn is(app: &App, slot: usize, status: &Status) -> bool {
    let run = app.slots[slot].run.as_ref();
    run.is_some_and(|run| run.status == *status)
}

fn report(app: &App, slot: usize) -> Report {
    let run = app.slots[slot].run.as_ref().unwrap();
    without_costs(run.report.clone())
}

fn without_costs(report: Report) -> Report {
    let costs = Costs::default();
    Report { costs, ..report }
}

#[test]
fn the_gallery_comes_to_its_end_with_the_results_of_runs_that_nobody_watches() {
    let slot = |kind| Slot::new(kind, None, scene(kind));
    let slots = ["homeotropic", "parallel", "none", "parallel"].map(slot);
    let mut watched = Watched::new(slots.into());
    watched.press('g');
    watched.until(|app| (0..4).all(|slot| is(app, slot, &Status::Done)));
    for (slot, kind) in ["homeotropic", "parallel", "none"].into_iter().enumerate() {
        let mut simulation = Simulation::new(&scene(kind)).unwrap();
        for _ in 0..60 {
            simulation.advance().unwrap();
        }
        let expected = without_costs(simulation.report().clone());
        assert_eq!(report(&watched.app, slot), expected, "{kind}");
    }
    assert_eq!(report(&watched.app, 3), report(&watched.app, 1));
    let run = watched.app.slots[0].run.as_ref().unwrap();
    assert_eq!(run.snapshots.len(), 5);
    let picture = watched.workers[&run.id].mailbox().fetch().unwrap();
    assert_eq!(picture.report.step, 60);
}

#[test]
fn pausing_stepping_switching_and_coming_back() {
    let mut endless = scene("homeotropic");
    endless.time.end = 1.0;
    let slots = vec![
        Slot::new("endless", None, endless),
        Slot::new("short", None, scene("parallel")),
    ];
    let mut watched = Watched::new(slots);
    watched.until(|app| is(app, 0, &Status::Running));
    watched.press(' ');
    assert!(is(&watched.app, 0, &Status::Pausing));
    watched.until(|app| is(app, 0, &Status::Paused));
    let step = report(&watched.app, 0).step;
    watched.press('n');
    assert!(is(&watched.app, 0, &Status::Pausing));
    watched.until(|app| is(app, 0, &Status::Paused));
    assert_eq!(report(&watched.app, 0).step, step + 1);
    watched.press('2');
    watched.until(|app| is(app, 1, &Status::Done));
    assert_eq!(report(&watched.app, 0).step, step + 1);
    watched.press('1');
    watched.press('a');
    watched.until(|app| app.slots[0].anchoring() == Some(AnchoringKind::Parallel));
    watched.press(' ');
    watched.until(|app| report(app, 0).step > step + 5);
    let run = watched.app.slots[0].run.as_ref().unwrap();
    let marks = run.history.marks.iter();
    let marks: Vec<_> = marks.map(|mark| (mark.step, mark.name())).collect();
    assert_eq!(marks, [(step + 1, Some("parallel"))]);
    let rises = |text: &str| text.contains("rises");
    assert!(!run.notices.iter().any(|notice| rises(&notice.text)));
}
