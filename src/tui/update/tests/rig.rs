//! The app with workers that are played: they keep to what the real ones promise, but take a step
//! only when they are asked to, and what they report arrives only when it is delivered.

use crate::scene::Change;
use crate::simulation::{Event, EventKind};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::super::super::message::{Effect, Message};
use super::super::super::state::{App, Run, Slot};
use super::super::update;
use crate::fem::Mesh;
use crate::physics::NamedValue;
use crate::scene::{AnchoringKind, Scene};
use crate::scheme::State;
use crate::simulation::{
    Command, Failure, Message as WorkerMessage, Report, RunId, RunSnapshot, Setting, WorkerConfig,
    WorkerEvent, step_count,
};

/// A worker that is played.
#[derive(Debug)]
pub(super) struct Played {
    orders: WorkerConfig,
    scene: Scene,
    ready: bool,
    going: bool,
    told: Option<&'static str>,
    commands: VecDeque<Command>,
    pub(super) report: Report,
    pub(super) anchoring: AnchoringKind,
    /// Of the scene, for the next step.
    changes: Vec<Change>,
    /// Added to the energy of every step from now on: a mistake of the solver.
    pub(super) mistake: f64,
    /// Whether it has failed: its thread has ended.
    failed: bool,
}

impl Played {
    fn new(orders: WorkerConfig, scene: &Scene) -> Self {
        let mut played = Self {
            going: !orders.paused,
            orders,
            scene: scene.clone(),
            ready: false,
            told: None,
            commands: VecDeque::new(),
            report: Report::default(),
            anchoring: scene
                .anchoring
                .map_or(AnchoringKind::None, |anchoring| anchoring.kind),
            changes: Vec::new(),
            mistake: 0.0,
            failed: false,
        };
        played.measure();
        played
    }

    fn steps(&self) -> u64 {
        step_count(&self.scene.time).expect("a fixed grid")
    }

    /// An energy that falls from step to step and jumps with the anchoring.
    fn measure(&mut self) {
        let anchoring = match self.anchoring {
            AnchoringKind::None => 0.0,
            AnchoringKind::Parallel => 50.0,
            AnchoringKind::Homeotropic => 90.0,
        };
        let bending = 100.0 / (1.0 + 1e-3 * self.report.step as f64) + self.mistake;
        self.report.energies = [("bending", bending), ("anchoring", anchoring)]
            .map(|(name, value)| NamedValue { name, value })
            .to_vec();
        self.report.total_energy = bending + anchoring;
    }

    fn rest(&self) -> Option<&'static str> {
        let beyond = |horizon| self.report.t >= horizon;
        if self.report.step >= self.steps() {
            Some("done")
        } else if !self.going {
            Some("paused")
        } else if self.orders.horizon.is_some_and(beyond) {
            Some("at the horizon")
        } else {
            None
        }
    }

    /// Whether it uses a core.
    pub(super) fn computes(&self) -> bool {
        let busy = !self.ready || self.rest().is_none() || self.commands.contains(&Command::Step);
        busy && !self.failed
    }

    /// The anchoring of the next step.
    pub(super) fn anchoring_to_be(&self) -> AnchoringKind {
        self.scene.anchoring_at(self.report.t)
    }

    fn take_step(&mut self, event: &mut Vec<WorkerEvent>) {
        let (step, t) = (self.report.step, self.report.t);
        let before = self.report.total_energy;
        self.measure();
        let of_the_same_state = self.report.total_energy;
        self.anchoring = self.anchoring_to_be();
        self.measure();
        let work = self.report.total_energy - of_the_same_state;
        self.report.step += 1;
        self.report.t = self.report.step as f64 * self.scene.time.step;
        self.measure();
        let change = self.report.total_energy - before;
        self.report.ledger = [("dE", change), ("change_work", -work)]
            .map(|(name, value)| NamedValue { name, value })
            .to_vec();
        event.push(WorkerEvent::Reports(vec![self.report.clone()]));
        let changes = std::mem::take(&mut self.changes);
        if !changes.is_empty() {
            let kind = EventKind::ParametersChanged { changes, work };
            event.push(WorkerEvent::Event(Event { step, t, kind }));
        }
    }

    /// One turn of the worker's loop: a command or a step. Returns what it reports.
    fn turn(&mut self) -> Vec<WorkerEvent> {
        let mut event = Vec::new();
        if self.failed {
            return event;
        }
        if !self.ready {
            self.ready = true;
            event.push(WorkerEvent::Ready(Arc::new(Setting {
                scene: self.scene.clone(),
                steps: Some(self.steps()),
                warnings: Vec::new(),
            })));
            event.push(WorkerEvent::Reports(vec![self.report.clone()]));
        }
        let rest = self.rest();
        if rest != self.told {
            self.told = rest;
            event.push(match rest {
                Some("done") => WorkerEvent::Done,
                Some("paused") => WorkerEvent::Paused,
                Some(_) => WorkerEvent::AtHorizon,
                None => WorkerEvent::Resumed,
            });
        }
        match self.commands.pop_front() {
            None if rest.is_none() => self.take_step(&mut event),
            Some(Command::Resume) => self.going = true,
            Some(Command::Horizon(horizon)) => self.orders.horizon = horizon,
            Some(Command::Until(end)) => {
                self.going &= rest != Some("done");
                self.scene.time.end = end;
            }
            Some(Command::Change { set, over }) => {
                let at = self.report.t;
                let change = Change { at, over, set };
                event.push(match self.scene.add_change(&change) {
                    Ok(()) => {
                        self.changes.push(change.clone());
                        WorkerEvent::Changed(change)
                    }
                    Err(error) => WorkerEvent::ChangeRefused(error.to_string()),
                });
            }
            Some(command @ (Command::Pause | Command::Step)) if rest != Some("done") => {
                if command == Command::Step {
                    self.take_step(&mut event);
                }
                self.going = false;
                self.told = None;
            }
            _ => {}
        }
        event
    }

    /// Whether there is anything to be done or reported but the next step.
    fn is_pending(&self) -> bool {
        !self.failed && (!self.ready || !self.commands.is_empty() || self.told != self.rest())
    }

    fn picture(&self) -> Arc<RunSnapshot> {
        let field = vec![self.report.step as f64; 9];
        Arc::new(RunSnapshot {
            run: self.orders.run,
            anchoring: Some(self.anchoring),
            report: self.report.clone(),
            mesh: Arc::new(Mesh::structured(2, 0.0, 1).unwrap()),
            state: Arc::new(State {
                phi: field.clone(),
                omega: field.clone(),
                mu: field.clone(),
                director: Some([field.clone(), field]),
            }),
        })
    }
}

/// The app, its workers, and what is on the way from these to that.
pub(super) struct Rig {
    pub(super) app: App,
    pub(super) workers: BTreeMap<RunId, Played>,
    pub(super) on_the_way: VecDeque<WorkerMessage>,
    /// Effects that concern no worker.
    pub(super) effects: Vec<Effect>,
}

/// A scene of a thousand steps.
pub(super) fn scene(settings: &[&str]) -> Scene {
    let text = "
        [time]
        step = 1e-6
        end = 1e-3
        [nematic]
        [anchoring]
    ";
    Scene::of_text(text, settings)
}

pub(super) fn slot(name: &str) -> Slot {
    Slot::new(name, None, scene(&[]))
}

impl Rig {
    /// The four cases, of which the third is shown.
    pub(super) fn new() -> Self {
        Self::with(["case1", "case2", "case3", "case4"].map(slot).into())
    }

    /// At the question whether to resume runs of an earlier session.
    pub(super) fn asked(slots: Vec<Slot>) -> Self {
        let mut rig = Self {
            app: App::new(slots, 2, (80, 24), 10),
            workers: BTreeMap::new(),
            on_the_way: VecDeque::new(),
            effects: Vec::new(),
        };
        rig.app.offer_to_go_on();
        rig.tell(Message::Tick);
        rig
    }

    pub(super) fn with(slots: Vec<Slot>) -> Self {
        let mut rig = Self {
            app: App::new(slots, 2, (80, 24), 10),
            workers: BTreeMap::new(),
            on_the_way: VecDeque::new(),
            effects: Vec::new(),
        };
        rig.app.cores = 2;
        rig.tell(Message::Tick);
        rig
    }

    /// Sends the app a message and carries out its commands to the workers.
    pub(super) fn tell(&mut self, message: Message) {
        for effect in update(&mut self.app, message) {
            match effect {
                Effect::Start(orders, scene) => {
                    let run = orders.run;
                    let before = self.workers.insert(run, Played::new(orders, &scene));
                    assert!(before.is_none(), "{run:?} twice");
                }
                Effect::Tell(run, command) => {
                    let worker = self.workers.get_mut(&run).expect("a run that was started");
                    worker.commands.push_back(command);
                }
                Effect::Drop(run) | Effect::Discard(run) => {
                    self.workers.remove(&run).expect("a run that was started");
                }
                other => self.effects.push(other),
            }
        }
    }

    pub(super) fn press(&mut self, code: KeyCode) {
        self.tell(Message::Key(KeyEvent::new(code, KeyModifiers::NONE)));
    }

    pub(super) fn press_control(&mut self, character: char) {
        let code = KeyCode::Char(character);
        self.tell(Message::Key(KeyEvent::new(code, KeyModifiers::CONTROL)));
    }

    /// Presses a key for each character.
    pub(super) fn keys(&mut self, characters: &str) {
        for character in characters.chars() {
            self.press(KeyCode::Char(character));
        }
    }

    /// One turn of a worker; what it reports is on the way then.
    pub(super) fn turn(&mut self, run: RunId) {
        if let Some(worker) = self.workers.get_mut(&run) {
            let event = worker.turn().into_iter();
            self.on_the_way
                .extend(event.map(|event| WorkerMessage { run, event }));
        }
    }

    /// A worker fails.
    pub(super) fn fail(&mut self, run: RunId) {
        if let Some(worker) = self.workers.get_mut(&run)
            && !worker.failed
            && worker.told != Some("done")
        {
            worker.failed = true;
            let event = WorkerEvent::Failed(Failure {
                words: "it did not converge".to_owned(),
                is_of_scene: false,
            });
            self.on_the_way.push_back(WorkerMessage { run, event });
        }
    }

    /// What arrives first of that which is on the way.
    pub(super) fn deliver(&mut self) {
        if let Some(message) = self.on_the_way.pop_front() {
            self.tell(Message::Solver(message));
        }
    }

    pub(super) fn deliver_all(&mut self) {
        while !self.on_the_way.is_empty() {
            self.deliver();
        }
    }

    /// This many turns of every worker, and all that they report.
    pub(super) fn work(&mut self, turns: usize) {
        for _ in 0..turns {
            for run in self.workers.keys().copied().collect::<Vec<_>>() {
                self.turn(run);
                self.deliver_all();
            }
        }
    }

    /// Lets all workers carry out their commands, without a step more than that takes.
    pub(super) fn settle(&mut self) {
        self.deliver_all();
        loop {
            let pending: Vec<RunId> = self
                .workers
                .iter()
                .filter(|(_, worker)| worker.is_pending())
                .map(|(run, _)| *run)
                .collect();
            if pending.is_empty() {
                return;
            }
            for run in pending {
                self.turn(run);
                self.deliver_all();
            }
        }
    }

    /// Fetches the latest fields of all runs.
    pub(super) fn fetch(&mut self) {
        let pictures: Vec<_> = self.workers.values().map(Played::picture).collect();
        for picture in pictures {
            self.tell(Message::Fields(picture));
        }
    }

    pub(super) fn run(&self, slot: usize) -> &Run {
        self.app.slots[slot].run.as_ref().expect("a run")
    }

    pub(super) fn worker(&mut self, slot: usize) -> &mut Played {
        let run = self.run(slot).id;
        self.workers.get_mut(&run).expect("a worker")
    }

    /// The only effect since the last call that concerns no worker; what a scene would take does not count.
    pub(super) fn effect(&mut self) -> Effect {
        self.effects
            .retain(|effect| !matches!(effect, Effect::Expect(..)));
        assert_eq!(self.effects.len(), 1, "{:?}", self.effects);
        self.effects.remove(0)
    }
}
