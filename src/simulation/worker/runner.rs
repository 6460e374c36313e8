//! What a worker's thread does.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

use super::super::claim::KeptFree;
use super::super::{
    Report, Schedule, Simulation, SimulationCheckpoint, SimulationError, threads_that_pay,
};
use super::mailbox::{Mailbox, SnapshotOf, SnapshotPool};
use super::{Command, Continuity, Failure, Message, RunId, Setting, WorkerConfig, WorkerEvent};
use crate::scene::{AnchoringKind, Assignment, Scene, Time};

/// Bytes that reporting a state takes: a copy of it, and its bytes when it is written, in a block that grows by
/// doubling. What is kept of case 3 has 370 bytes a node (`ls -l` of its file).
const KEEPING: u64 = 4 << 20;
const KEEPING_A_NODE: u64 = 1200;

/// The thread's own: everything but the simulation.
pub(super) struct Runner<Sink> {
    config: WorkerConfig,
    commands: Receiver<Command>,
    /// What came while the run was set up or a hard step was taken.
    waiting: VecDeque<Command>,
    events: EventSender<Sink>,
    mailbox: Mailbox,
    canvases: SnapshotPool,
    computing: Arc<AtomicU64>,
    kept: Kept,
    step_in_hand: StepInHand,
}

/// When the state was reported last, and how often it is reported.
struct Kept {
    interval: Option<Duration>,
    /// Whether nothing was computed since.
    is_current: bool,
    at: Instant,
}

impl Kept {
    fn is_due(&self) -> bool {
        let is_due = |interval| self.at.elapsed() >= interval;
        !self.is_current && self.interval.is_some_and(is_due)
    }
}

/// When the current step was begun, and when its progress is reported next.
struct StepInHand {
    step: u64,
    told_at: Instant,
}

impl StepInHand {
    /// The progress of a step that takes longer than this is reported.
    const PATIENCE: Duration = Duration::from_secs(1);
    /// And again after this.
    const INTERVAL: Duration = Duration::from_millis(500);

    /// Whether it is time to report the progress of this step.
    fn is_due(&mut self, step: u64) -> bool {
        if self.step != step {
            *self = Self {
                step,
                told_at: Instant::now() + Self::PATIENCE,
            };
        }
        Instant::now() >= self.told_at
    }

    fn told(&mut self) {
        self.told_at = Instant::now() + Self::INTERVAL;
    }
}

/// Why a worker is idle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum IdleReason {
    Paused,
    AtHorizon,
    Done,
}

impl IdleReason {
    fn event(self) -> WorkerEvent {
        match self {
            Self::Paused => WorkerEvent::Paused,
            Self::AtHorizon => WorkerEvent::AtHorizon,
            Self::Done => WorkerEvent::Done,
        }
    }
}

impl<Sink: Fn(Message)> Runner<Sink> {
    pub(super) fn new(
        config: WorkerConfig,
        commands: Receiver<Command>,
        sink: Sink,
        mailbox: Mailbox,
        computing: Arc<AtomicU64>,
    ) -> Self {
        Self {
            events: EventSender {
                run: config.run,
                gathering: config.gathering,
                sink,
                gathered: Vec::new(),
                sent: Instant::now(),
            },
            config,
            commands,
            waiting: VecDeque::new(),
            mailbox,
            canvases: SnapshotPool::default(),
            computing,
            kept: Kept {
                interval: None,
                is_current: true,
                at: Instant::now(),
            },
            step_in_hand: StepInHand {
                step: 0,
                told_at: Instant::now(),
            },
        }
    }

    /// Runs the scene until it is asked to end or fails, which it reports.
    pub(super) fn run(mut self, scene: &Scene, continuity: Continuity) {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.simulate(scene, continuity)));
        let failure = match outcome {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(Failure::from(error)),
            Err(panic) => Some(Failure::other(format!(
                "the solver has a mistake and stopped: {}",
                panic_words(&*panic)
            ))),
        };
        // The sink itself may have panicked; then nobody is left to report to.
        let _ = catch_unwind(AssertUnwindSafe(|| match failure {
            Some(failure) => self.events.tell(WorkerEvent::Failed(failure)),
            None => self.events.flush(),
        }));
    }

    /// Sets the run up and computes until `End`.
    fn simulate(&mut self, scene: &Scene, continuity: Continuity) -> Result<(), SimulationError> {
        let mut simulation = match self.set_up(scene) {
            Err(SimulationError::Ended) => return Ok(()),
            result => result?,
        };
        // At once: others may wait for the claim that the set-up has just dropped.
        let nodes = simulation.mesh().nodes().len() as u64;
        let _kept_free = continuity
            .keep
            .map(|_| KeptFree::of(KEEPING + KEEPING_A_NODE * nodes));
        if let Some(checkpoint) = continuity.from {
            simulation.restore(&checkpoint)?;
        }
        simulation.set_threads(threads_that_pay(nodes as usize, self.config.threads));
        self.kept = Kept {
            interval: continuity.keep,
            is_current: true,
            at: Instant::now(),
        };
        let mut schedule = Schedule::new(&scene.time, 1, self.config.snapshots);
        simulation.follow(&schedule);
        // Before the event, so that its receiver finds it; the same everywhere.
        self.show(&simulation);
        self.events.tell(WorkerEvent::Ready(Arc::new(Setting {
            scene: scene.clone(),
            steps: schedule.steps,
            warnings: simulation.warnings().to_vec(),
        })));
        self.tell_step(&mut simulation, &schedule);
        if let Some(underway) = simulation.underway() {
            self.events.tell(WorkerEvent::StepProgress(underway));
        }

        let mut going = !self.config.paused;
        let mut told = None;
        loop {
            let rest = self.rest(&simulation, &schedule, going);
            if rest != told {
                match rest {
                    Some(rest) => {
                        self.show(&simulation);
                        self.events.tell(rest.event());
                    }
                    None => self.events.tell(WorkerEvent::Resumed),
                }
                told = rest;
            }
            let command = match (self.waiting.pop_front(), rest) {
                (Some(command), _) => Ok(command),
                (None, Some(_)) => self.commands.recv().map_err(|_| TryRecvError::Disconnected),
                (None, None) => self.commands.try_recv(),
            };
            match command {
                Err(TryRecvError::Empty) => {
                    self.attempt(&mut simulation, &schedule)?;
                    if self.kept.is_due() {
                        self.keep(&simulation);
                    }
                }
                Ok(Command::Resume) => going = true,
                Ok(Command::Horizon(horizon)) => self.config.horizon = horizon,
                Ok(Command::Until(end)) => {
                    let time = Time { end, ..scene.time };
                    schedule = Schedule::new(&time, 1, self.config.snapshots);
                    simulation.follow(&schedule);
                    simulation.go_beyond_rest();
                    going &= rest != Some(IdleReason::Done);
                }
                Ok(Command::Change { set, over }) => self.change(&mut simulation, set, over),
                Ok(Command::Keep) => self.tell_state(&simulation),
                Ok(command @ (Command::Pause | Command::Step))
                    if rest != Some(IdleReason::Done) =>
                {
                    if command == Command::Step {
                        self.step(&mut simulation, &schedule)?;
                    }
                    going = false;
                    // To be answered, even if it stood still before.
                    told = None;
                }
                Ok(Command::Pause | Command::Step) => {}
                Ok(Command::End) | Err(TryRecvError::Disconnected) => {
                    self.keep(&simulation);
                    return Ok(());
                }
            }
        }
    }

    /// Sets the run up, telling what is done; `Ended` where it is to end before any step.
    fn set_up(&mut self, scene: &Scene) -> Result<Simulation, SimulationError> {
        let mut told = None;
        Simulation::new_unless(scene, &mut |part| {
            if told.replace(part) != Some(part) {
                self.events.tell(WorkerEvent::SettingUp(part));
            }
            while let Some(command) = next_command(&self.commands) {
                let is_end = command == Command::End;
                self.waiting.push_back(command);
                // Where nobody is left to ask, there is one end after another.
                if is_end {
                    break;
                }
            }
            let before_steps = self.waiting.iter().take_while(|it| **it != Command::Step);
            before_steps.into_iter().any(|it| *it == Command::End)
        })
    }

    /// Reports the state, if that was ordered and anything was computed since.
    fn keep(&mut self, simulation: &Simulation) {
        if !self.kept.is_current {
            self.tell_state(simulation);
        }
    }

    /// Reports the state, if that was ordered.
    fn tell_state(&mut self, simulation: &Simulation) {
        if self.kept.interval.is_none() {
            return;
        }
        let mut checkpoint = Box::new(SimulationCheckpoint::default());
        simulation.save(&mut checkpoint);
        self.events.tell(WorkerEvent::State(checkpoint));
        self.kept.is_current = true;
        self.kept.at = Instant::now();
    }

    /// Why the run is idle at present; `None`: it computes.
    fn rest(
        &self,
        simulation: &Simulation,
        schedule: &Schedule,
        going: bool,
    ) -> Option<IdleReason> {
        let report = simulation.report();
        if schedule.is_done(report) {
            Some(IdleReason::Done)
        } else if !going {
            Some(IdleReason::Paused)
        } else if self
            .config
            .horizon
            .is_some_and(|horizon| report.t >= horizon)
        {
            Some(IdleReason::AtHorizon)
        } else {
            None
        }
    }

    /// One step, unless a command comes while it is taken.
    fn step(
        &mut self,
        simulation: &mut Simulation,
        schedule: &Schedule,
    ) -> Result<(), SimulationError> {
        while !self.attempt(simulation, schedule)? && self.waiting.is_empty() {
            if self.kept.is_due() {
                self.keep(simulation);
            }
        }
        Ok(())
    }

    /// Takes one step and reports it; returns whether it was completed. One that takes long is interrupted when a
    /// command arrives, and when it is time to report its progress or its state.
    fn attempt(
        &mut self,
        simulation: &mut Simulation,
        schedule: &Schedule,
    ) -> Result<bool, SimulationError> {
        let begun = Instant::now();
        let (commands, waiting) = (&self.commands, &mut self.waiting);
        let (kept, in_hand) = (&mut self.kept, &mut self.step_in_hand);
        kept.is_current = false;
        let advanced = simulation.advance_unless(&mut |underway| {
            if waiting.is_empty() {
                waiting.extend(next_command(commands));
            }
            !waiting.is_empty() || in_hand.is_due(underway.step) || kept.is_due()
        });
        let nanoseconds = u64::try_from(begun.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.computing.fetch_add(nanoseconds, Ordering::Relaxed);
        let is_whole = match advanced {
            Ok(is_whole) => is_whole,
            Err(error) => {
                self.show(simulation);
                // The last good one.
                self.keep(simulation);
                return Err(error);
            }
        };
        if !is_whole {
            self.tell_events(simulation);
            if let Some(underway) = simulation.underway()
                && self.step_in_hand.is_due(underway.step)
            {
                self.step_in_hand.told();
                self.events.tell(WorkerEvent::StepProgress(underway));
            }
            return Ok(false);
        }
        if self.mailbox.is_empty() {
            self.show(simulation);
        }
        self.tell_step(simulation, schedule);
        Ok(true)
    }

    /// The report, the events and, where one is due, the snapshot of the state that was reached.
    fn tell_step(&mut self, simulation: &mut Simulation, schedule: &Schedule) {
        self.events.gather(simulation.last_whole().0);
        self.tell_events(simulation);
        let (report, _) = simulation.last_whole();
        if schedule.is_snapshot_due(report) {
            let picture = Arc::new(self.picture(simulation).to_picture());
            self.events.tell(WorkerEvent::Snapshot(picture));
        }
    }

    fn tell_events(&mut self, simulation: &mut Simulation) {
        for event in simulation.drain_events() {
            self.events.tell(WorkerEvent::Event(event));
        }
    }

    /// Changes parameters from the next step on, and answers.
    fn change(&mut self, simulation: &mut Simulation, set: Vec<Assignment>, over: f64) {
        let answer = match simulation.change(set, over) {
            Ok(change) => WorkerEvent::Changed(change.clone()),
            Err(error) => WorkerEvent::ChangeRefused(error.to_string()),
        };
        self.events.tell(answer);
    }

    /// Puts the present state into the mailbox: that of the last whole step, with which everything else that is
    /// reported and saved agrees.
    fn show(&mut self, simulation: &Simulation) {
        let picture = self.canvases.paint(self.picture(simulation));
        self.mailbox.put(picture);
    }

    fn picture<'a>(&self, simulation: &'a Simulation) -> SnapshotOf<'a> {
        let scene = simulation.parameters();
        let kind = scene
            .anchoring
            .map_or(AnchoringKind::None, |anchoring| anchoring.kind);
        let (report, state) = simulation.last_whole();
        SnapshotOf {
            run: self.config.run,
            anchoring: scene.nematic.as_ref().map(|_| kind),
            report,
            mesh: simulation.mesh(),
            state,
        }
    }
}

/// The next command, if there is one; an end where nobody is left to send one.
fn next_command(commands: &Receiver<Command>) -> Option<Command> {
    match commands.try_recv() {
        Ok(command) => Some(command),
        Err(TryRecvError::Disconnected) => Some(Command::End),
        Err(TryRecvError::Empty) => None,
    }
}

/// Sends the events of a run in order, and gathers reports so that they are not sent one by one.
struct EventSender<Sink> {
    run: RunId,
    gathering: Duration,
    sink: Sink,
    gathered: Vec<Report>,
    /// When reports were sent last.
    sent: Instant,
}

impl<Sink: Fn(Message)> EventSender<Sink> {
    /// Takes the report of a step, and sends what was gathered if it is time.
    fn gather(&mut self, report: &Report) {
        self.gathered.push(report.clone());
        if self.sent.elapsed() >= self.gathering {
            self.flush();
        }
    }

    /// Sends an event, after all that came before it.
    fn tell(&mut self, event: WorkerEvent) {
        self.flush();
        (self.sink)(Message {
            run: self.run,
            event,
        });
    }

    fn flush(&mut self) {
        self.sent = Instant::now();
        if !self.gathered.is_empty() {
            let event = WorkerEvent::Reports(std::mem::take(&mut self.gathered));
            (self.sink)(Message {
                run: self.run,
                event,
            });
        }
    }
}

/// The words of a panic.
pub(crate) fn panic_words(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("it panicked without a word")
}
