use crate::scene::Change;
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, TryRecvError};

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::tests::small;
use super::super::{Costs, Report, SetUp, Simulation, State};
use super::*;
use crate::scene::{AnchoringKind, InitialDirector, NodalValues};

/// Long enough for anything but a hang.
const PATIENCE: Duration = Duration::from_secs(60);

/// A worker and what it has reported.
struct Watched {
    worker: Worker,
    event: Receiver<Message>,
}

fn config() -> WorkerConfig {
    WorkerConfig {
        run: RunId(7),
        paused: true,
        horizon: None,
        gathering: Duration::ZERO,
        snapshots: 0,
        threads: 1,
    }
}

fn start(config: WorkerConfig, scene: Scene) -> Watched {
    start_from(config, scene, Continuity::default())
}

fn start_from(config: WorkerConfig, scene: Scene, continuity: Continuity) -> Watched {
    let (sender, event) = mpsc::channel();
    let sink = move |message| {
        // The receiver may have been dropped.
        let _ = sender.send(message);
    };
    let worker = Worker::start_from(config, Arc::new(scene), continuity, sink);
    Watched { worker, event }
}

impl Watched {
    /// The next event, without those of the set-up and the progress within a step, which depend on the clock.
    fn next(&self) -> WorkerEvent {
        loop {
            let message = self.event.recv_timeout(PATIENCE).unwrap();
            assert_eq!(message.run, RunId(7));
            if !matches!(
                message.event,
                WorkerEvent::SettingUp(_) | WorkerEvent::StepProgress(_)
            ) {
                return message.event;
            }
        }
    }

    /// All events up to the first for which this holds.
    fn until(&self, is_last: impl Fn(&WorkerEvent) -> bool) -> Vec<WorkerEvent> {
        let mut event = vec![self.next()];
        while !event.last().is_some_and(&is_last) {
            event.push(self.next());
        }
        event
    }

    /// The words of the events up to the first such word.
    fn words_until(&self, last: &str) -> Vec<String> {
        let event = self.until(|event| word(event) == last);
        event.iter().map(word).collect()
    }
}

/// WorkerEvent in a word, with the steps of reports.
fn word(event: &WorkerEvent) -> String {
    match event {
        WorkerEvent::SettingUp(part) => part.words().to_owned(),
        WorkerEvent::Ready(_) => "ready".to_owned(),
        WorkerEvent::Reports(reports) => {
            let steps: Vec<u64> = reports.iter().map(|report| report.step).collect();
            format!("{steps:?}")
        }
        WorkerEvent::StepProgress(underway) => format!("within {}", underway.step),
        WorkerEvent::Event(event) => event.kind.name().to_owned(),
        WorkerEvent::Changed(change) => format!("{change} at {:e}", change.at),
        WorkerEvent::ChangeRefused(_) => "refused".to_owned(),
        WorkerEvent::Snapshot(picture) => format!("snapshot {}", picture.report.step),
        WorkerEvent::State(checkpoint) => format!("state {}", checkpoint.step()),
        WorkerEvent::Paused => "paused".to_owned(),
        WorkerEvent::Resumed => "resumed".to_owned(),
        WorkerEvent::AtHorizon => "at the horizon".to_owned(),
        WorkerEvent::Done => "done".to_owned(),
        WorkerEvent::Failed(reason) => format!("failed: {reason}"),
    }
}

fn reports(event: &[WorkerEvent]) -> Vec<Report> {
    let reports = event.iter().filter_map(|event| match event {
        WorkerEvent::Reports(reports) => Some(reports.clone()),
        _ => None,
    });
    reports.flatten().map(without_costs).collect()
}

/// What the clock says is never the same twice.
fn without_costs(report: Report) -> Report {
    Report {
        costs: Costs::default(),
        ..report
    }
}

fn fetched(worker: &Worker) -> (u64, State) {
    let picture = worker.mailbox().fetch().unwrap();
    (picture.report.step, State::clone(&picture.state))
}

#[test]
fn a_watched_run_is_bit_for_bit_the_one_that_nobody_watches() {
    let scene = small(&[]);
    let config = WorkerConfig {
        paused: false,
        gathering: Duration::from_millis(3),
        snapshots: 5,
        ..config()
    };
    let watched = start(config, scene.clone());
    let event = watched.until(|event| matches!(event, WorkerEvent::Done));

    let mut simulation = Simulation::new(&scene).unwrap();
    let mut expected = vec![simulation.report().clone()];
    let mut states = vec![simulation.state().clone()];
    for _ in 0..40 {
        expected.push(without_costs(simulation.advance().unwrap().clone()));
        states.push(simulation.state().clone());
    }
    assert_eq!(reports(&event), expected);
    let snapshots: Vec<_> = event
        .iter()
        .filter_map(|event| match event {
            WorkerEvent::Snapshot(picture) => Some(picture),
            _ => None,
        })
        .collect();
    let steps: Vec<u64> = snapshots.iter().map(|kept| kept.report.step).collect();
    assert_eq!(steps, [0, 10, 20, 30, 40]);
    for kept in snapshots {
        let step = kept.report.step as usize;
        assert_eq!(*kept.state, states[step]);
        assert_eq!(without_costs(kept.report.clone()), expected[step]);
        assert_eq!(kept.anchoring, Some(AnchoringKind::Parallel));
    }
    assert_eq!(fetched(&watched.worker), (40, states[40].clone()));
    let WorkerEvent::Ready(setting) = &event[0] else {
        panic!("{:?}", event[0]);
    };
    assert_eq!((setting.steps, &setting.scene), (Some(40), &scene));
    let costs = event.iter().filter_map(|event| match event {
        WorkerEvent::Reports(reports) => Some(reports),
        _ => None,
    });
    let costs: Duration = costs.flatten().map(|report| report.costs.total()).sum();
    assert!(!costs.is_zero() && watched.worker.computing() >= costs);
}

#[test]
fn news_come_in_the_order_of_the_commands() {
    let watched = start(config(), small(&["time.end=6e-6"]));
    let Watched { worker, .. } = &watched;
    assert_eq!(watched.words_until("paused"), ["ready", "[0]", "paused"]);
    assert_eq!(worker.computing(), Duration::ZERO);
    worker.tell(Command::Step);
    assert_eq!(watched.words_until("paused"), ["[1]", "paused"]);
    assert_eq!(fetched(worker).0, 1);
    worker.tell(Command::Step);
    worker.tell(Command::Step);
    worker.tell(Command::Pause);
    let words: Vec<String> = (0..5).map(|_| word(&watched.next())).collect();
    assert_eq!(words, ["[2]", "paused", "[3]", "paused", "paused"]);
    worker.tell(anchor(AnchoringKind::None));
    assert_eq!(word(&watched.next()), "anchoring.kind = \"none\" at 3e-6");
    worker.tell(Command::Resume);
    let words = watched.words_until("done");
    assert_eq!(
        words,
        ["resumed", "[4]", "parameters-changed", "[5]", "[6]", "done"]
    );
    for command in [
        Command::Pause,
        Command::Step,
        Command::Resume,
        Command::Horizon(Some(0.0)),
        anchor(AnchoringKind::Homeotropic),
    ] {
        worker.tell(command);
    }
    assert_eq!(
        word(&watched.next()),
        "anchoring.kind = \"homeotropic\" at 6e-6"
    );
    let picture = worker.mailbox().fetch().unwrap();
    // It would be the next step's.
    assert_eq!(picture.anchoring, Some(AnchoringKind::None));
    assert_eq!(picture.report.step, 6);
}

#[test]
fn the_parts_of_the_set_up_are_told_in_order() {
    let Watched { event, worker } = start(config(), small(&[]));
    let words: Vec<String> = (0..4)
        .map(|_| word(&event.recv_timeout(PATIENCE).unwrap().event))
        .collect();
    let parts = [SetUp::Mesh, SetUp::InitialState, SetUp::Solver].map(SetUp::words);
    assert_eq!(words[..3], parts);
    assert_eq!(words[3], "ready");
    drop(worker);
}

/// A mesh that takes seconds to make is not waited for.
#[test]
fn a_run_ends_while_its_mesh_is_made() {
    let scene = small(&["mesh={ kind = 'delaunay', size = 0.004 }"]);
    let Watched { event, worker } = start(config(), scene);
    let first = event.recv_timeout(PATIENCE).unwrap().event;
    assert_eq!(word(&first), SetUp::Mesh.words());
    drop(worker);
    let words: Vec<String> = event.iter().map(|message| word(&message.event)).collect();
    assert_eq!(words, [""; 0]);
}

#[test]
fn a_step_of_a_running_run_pauses_it() {
    let config = WorkerConfig {
        paused: false,
        ..config()
    };
    let watched = start(config, small(&["time.end=1.0"]));
    watched.worker.tell(Command::Step);
    let words = watched.words_until("paused");
    watched.worker.tell(Command::Step);
    // Ready, the initial state, all steps up to the one that was asked for, and the pause.
    assert_eq!(watched.next_steps(), [words.len() as u64 - 2]);
    assert_eq!(word(&watched.next()), "paused");
}

impl Watched {
    fn next_steps(&self) -> Vec<u64> {
        let event = [self.next()];
        reports(&event).iter().map(|report| report.step).collect()
    }
}

#[test]
fn a_run_waits_at_its_horizon_until_that_moves() {
    let config = WorkerConfig {
        paused: false,
        horizon: Some(3e-6),
        ..config()
    };
    // Without the event that another linear solver takes over.
    let scene = small(&["time.end=9e-6", "solver.linear=transform"]);
    let watched = start(config, scene);
    let Watched { worker, .. } = &watched;
    let words = watched.words_until("at the horizon");
    assert_eq!(words[1..], ["[0]", "[1]", "[2]", "[3]", "at the horizon"]);
    assert_eq!(fetched(worker).0, 3);
    worker.tell(Command::Horizon(Some(2e-6)));
    worker.tell(Command::Resume);
    // Between two times of the grid: up to the later one.
    worker.tell(Command::Horizon(Some(3.5e-6)));
    let words = watched.words_until("at the horizon");
    assert_eq!(words, ["resumed", "[4]", "at the horizon"]);
    worker.tell(anchor(AnchoringKind::Homeotropic));
    assert_eq!(
        word(&watched.next()),
        "anchoring.kind = \"homeotropic\" at 4e-6"
    );
    assert_eq!(fetched(worker).0, 4);
    worker.tell(Command::Step);
    let words = watched.words_until("paused");
    assert_eq!(words, ["[5]", "parameters-changed", "paused"]);
    worker.tell(Command::Resume);
    assert_eq!(word(&watched.next()), "at the horizon");
    worker.tell(Command::Pause);
    assert_eq!(word(&watched.next()), "paused");
    worker.tell(Command::Horizon(None));
    worker.tell(Command::Resume);
    let words = watched.words_until("done");
    assert_eq!(words, ["resumed", "[6]", "[7]", "[8]", "[9]", "done"]);
}

#[test]
fn an_event_comes_after_the_report_of_its_step() {
    let at_wall = small(&["vesicle.center=[0.5, 0.9]", "vesicle.angle=0"]);
    let watched = start(config(), at_wall);
    let words = watched.words_until("paused");
    assert_eq!(words, ["ready", "[0]", "reached-wall", "paused"]);
    assert!(watched.event.try_recv().is_err());
}

#[test]
fn a_picture_is_painted_only_when_the_last_one_was_fetched() {
    let mailbox: Arc<OnceLock<Mailbox>> = Arc::default();
    let (sender, steps) = mpsc::channel();
    let shared = mailbox.clone();
    let sink = move |message: Message| match message.event {
        WorkerEvent::Reports(reports) if reports[0].step % 3 == 1 => {
            let picture = shared.get().and_then(Mailbox::fetch);
            let _ = sender.send(picture.map(|picture| picture.report.step));
        }
        _ => {}
    };
    let worker = Worker::start(config(), Arc::new(small(&["time.end=1e-5"])), sink);
    mailbox.set(worker.mailbox()).unwrap();
    worker.tell(Command::Resume);
    let fetched: Vec<_> = (0..4).map(|_| steps.recv_timeout(PATIENCE)).collect();
    // At 1 what was shown at rest; then the one of the next step, before whose event the place was free.
    assert_eq!(
        fetched,
        [Ok(Some(0)), Ok(Some(2)), Ok(Some(5)), Ok(Some(8))]
    );
}

#[test]
fn reports_are_gathered_and_none_is_held_back_at_rest() {
    let config = WorkerConfig {
        gathering: Duration::from_secs(3600),
        ..config()
    };
    let watched = start(config, small(&["time.end=5e-6"]));
    assert_eq!(watched.words_until("paused"), ["ready", "[0]", "paused"]);
    watched.worker.tell(Command::Step);
    assert_eq!(watched.words_until("paused"), ["[1]", "paused"]);
    watched.worker.tell(Command::Resume);
    let words = watched.words_until("done");
    assert_eq!(words, ["resumed", "[2, 3, 4, 5]", "done"]);
}

/// The command to change the anchoring.
fn anchor(kind: AnchoringKind) -> Command {
    Command::Change {
        set: Change::of_anchoring(kind),
        over: 0.0,
    }
}

/// Repeats the changes that a worker has reported in a run of the scene that has them from the start.
fn replay(scene: &Scene, event: &[WorkerEvent]) -> (Vec<Report>, State) {
    let mut scene = scene.clone();
    for event in event {
        if let WorkerEvent::Changed(change) = event {
            scene.add_change(change).unwrap();
        }
    }
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut expected = vec![simulation.report().clone()];
    for _ in 1..reports(event).len() {
        expected.push(without_costs(simulation.advance().unwrap().clone()));
    }
    (expected, simulation.state().clone())
}

#[test]
fn a_thousand_commands_lose_nothing_and_double_nothing() {
    let scene = small(&["mesh.cells=8", "time.end=6e-4"]);
    let steps = 600;
    let kinds = [
        AnchoringKind::Homeotropic,
        AnchoringKind::Parallel,
        AnchoringKind::None,
    ];
    let config = WorkerConfig {
        gathering: Duration::from_millis(1),
        snapshots: 7,
        horizon: Some(0.0),
        ..config()
    };
    let watched = start(config, scene.clone());
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (mut event, mut switches, mut answers) = (Vec::new(), Vec::new(), 1);
    for _ in 0..1000 {
        let command = match random.random_range(0..20) {
            0..4 => Command::Pause,
            4..10 => Command::Resume,
            // Too few to reach T from the farthest horizon.
            10..13 => Command::Step,
            13..15 => anchor(kinds[random.random_range(0..3)]),
            _ => Command::Horizon(Some(random.random_range(0.0..3e-4))),
        };
        match command {
            Command::Pause | Command::Step => answers += 1,
            Command::Change { ref set, .. } => switches.push(set.clone()),
            _ => {}
        }
        watched.worker.tell(command);
        for _ in 0..random.next_u32() % 4 {
            match watched.event.try_recv() {
                Ok(message) => event.push(message.event),
                Err(TryRecvError::Empty) => thread::yield_now(),
                Err(TryRecvError::Disconnected) => panic!("the thread has ended"),
            }
        }
    }
    watched.worker.tell(Command::Horizon(None));
    watched.worker.tell(Command::Resume);
    event.extend(watched.until(|event| matches!(event, WorkerEvent::Done)));

    let told: Vec<u64> = reports(&event).iter().map(|report| report.step).collect();
    assert_eq!(told, (0..=steps).collect::<Vec<_>>());
    let count = |word_of: &str| event.iter().filter(|event| word(event) == word_of).count();
    assert_eq!(count("paused"), answers);
    assert_eq!((count("ready"), count("done")), (1, 1));
    assert_eq!(count("snapshot 0") + count("snapshot 600"), 2);
    assert_eq!(
        event
            .iter()
            .filter(|event| word(event).starts_with("snap"))
            .count(),
        7
    );
    let anchored: Vec<_> = event
        .iter()
        .filter_map(|event| match event {
            WorkerEvent::Changed(change) => Some(change.set.clone()),
            _ => None,
        })
        .collect();
    assert_eq!(anchored, switches);
    let (expected, state) = replay(&scene, &event);
    assert_eq!(reports(&event), expected);
    assert_eq!(fetched(&watched.worker), (steps, state));
    check_life_cycle(&event);
}

/// A worker that is paused takes only the steps that are asked for, and resumes only from a pause.
fn check_life_cycle(event: &[WorkerEvent]) {
    let (mut stands, mut steps_while_standing) = (false, 0);
    for event in &event[2..] {
        match event {
            WorkerEvent::Paused => {
                assert!(steps_while_standing <= 1);
                (stands, steps_while_standing) = (true, 0);
            }
            WorkerEvent::AtHorizon => {
                assert_eq!(steps_while_standing, 0);
                stands = true;
            }
            WorkerEvent::Resumed => {
                assert!(stands && steps_while_standing == 0);
                stands = false;
            }
            WorkerEvent::Reports(reports) if stands => steps_while_standing += reports.len(),
            _ => {}
        }
    }
}

/// A step that takes many seconds: its progress is reported, and its state in the middle of it; a run that continues
/// from there reports the last whole step first.
#[test]
fn a_hard_step_is_told_and_kept_in_its_midst() {
    let text = "
        mesh.cells = 20
        membrane = { interface_width = 0.05, spontaneous_curvature = '1e6*sign(x-0.5)' }
        vesicle = { shape = 'circle', radius = 0.25 }
        area = { target = 1.25, penalty = 1e-3 }
        time = { step = 1e-6, end = 1.0 }
    ";
    let scene = Scene::of_text(text, &[]);
    let start = |from: Option<Box<SimulationCheckpoint>>| {
        let keep = Some(Duration::ZERO);
        let config = WorkerConfig {
            paused: false,
            ..config()
        };
        start_from(config, scene.clone(), Continuity { from, keep })
    };
    let Watched { worker, event } = start(None);
    // Until a part of the step is behind it.
    let mut kept: Option<Box<SimulationCheckpoint>> = None;
    let underway = loop {
        match event.recv_timeout(PATIENCE).unwrap().event {
            WorkerEvent::StepProgress(underway)
                if kept.as_ref().is_some_and(|kept| kept.t() > 0.0) =>
            {
                break underway;
            }
            WorkerEvent::State(checkpoint) => kept = Some(checkpoint),
            WorkerEvent::Reports(reports) => assert!(reports.iter().all(|report| report.step == 0)),
            _ => {}
        }
    };
    assert_eq!(underway.step, 1);
    assert!(
        underway.t < underway.end && underway.dt < 1e-6,
        "{underway:?}"
    );
    let kept = kept.expect("it is kept too");
    assert!(kept.is_begun() && kept.step() == 0);
    assert!(0.0 < kept.t() && kept.t() <= underway.t, "{}", kept.t());
    drop(worker);
    let Watched { event, .. } = &start(Some(kept.clone()));
    let next = || {
        loop {
            match event.recv_timeout(PATIENCE).unwrap().event {
                WorkerEvent::SettingUp(_) => {}
                event => break event,
            }
        }
    };
    let (WorkerEvent::Ready(_), WorkerEvent::Reports(reports), WorkerEvent::StepProgress(again)) =
        (next(), next(), next())
    else {
        panic!("other event");
    };
    assert_eq!((reports[0].step, reports[0].t), (0, 0.0));
    assert_eq!((again.step, again.t), (1, kept.t()));
    assert_eq!(Some(again), kept.underway());
}

#[test]
fn a_set_up_that_fails_is_told() {
    // More than any memory holds: refused before anything is allocated.
    let scene = small(&["mesh.cells=20000"]);
    let expected = Simulation::new(&scene).unwrap_err().to_string();
    let watched = start(config(), scene);
    assert_eq!(word(&watched.next()), format!("failed: {expected}"));
    assert!(
        watched.event.recv_timeout(PATIENCE).is_err(),
        "nothing more"
    );
    watched.worker.tell(Command::Resume);
}

#[test]
fn a_step_that_fails_is_told_after_all_before_it() {
    let scene = small(&["solver.law_tolerance=1e-300"]);
    let mut simulation = Simulation::new(&scene).unwrap();
    let initial = simulation.state().clone();
    let error = simulation.advance().unwrap_err().to_string();
    let config = WorkerConfig {
        paused: false,
        gathering: Duration::from_secs(3600),
        ..config()
    };
    let watched = start(config, scene);
    let words: Vec<String> = (0..4).map(|_| word(&watched.next())).collect();
    // The event comes while the step is taken.
    let failed = format!("failed: {error}");
    assert_eq!(words, ["ready", "[0]", "short-steps", &failed]);
    assert!(
        watched.event.recv_timeout(PATIENCE).is_err(),
        "nothing more"
    );
    assert_eq!(fetched(&watched.worker), (0, initial));
}

fn simulation_nodes(scene: &crate::scene::Scene) -> usize {
    Simulation::new(scene).unwrap().mesh().nodes().len()
}

#[test]
fn a_panic_is_told() {
    let mut scene = small(&[]);
    // No scene that was read has one value a node for the director.
    let nodes = simulation_nodes(&scene);
    scene.nematic.get_or_insert_default().initial = InitialDirector::File(NodalValues {
        path: String::new(),
        values: Arc::from(vec![0.0; nodes]),
        columns: 1,
    });
    let watched = start(config(), scene);
    let told = word(&watched.next());
    assert!(
        told.starts_with("failed: the solver has a mistake"),
        "{told}"
    );
    assert!(
        watched.event.recv_timeout(PATIENCE).is_err(),
        "nothing more"
    );
}

#[test]
fn a_sink_that_panics_ends_the_run_and_nothing_else() {
    let (sender, event) = mpsc::channel();
    let sink = move |message: Message| {
        if !matches!(message.event, WorkerEvent::SettingUp(_)) {
            let _ = sender.send(word(&message.event));
        }
        assert!(
            !matches!(message.event, WorkerEvent::Ready(_)),
            "a sink's mistake"
        );
    };
    let worker = Worker::start(config(), Arc::new(small(&[])), sink);
    assert_eq!(event.recv_timeout(PATIENCE).as_deref(), Ok("ready"));
    let told = event.recv_timeout(PATIENCE).unwrap();
    assert!(told.contains("a sink's mistake"), "{told}");
    drop(worker);
    assert!(event.recv().is_err());
}

#[test]
fn dropping_ends_a_run_within_a_step() {
    let endless = small(&["time.end=1.0"]);
    for (paused, horizon) in [(true, None), (false, Some(1e-6)), (false, None)] {
        let config = WorkerConfig {
            paused,
            horizon,
            ..config()
        };
        let watched = start(config, endless.clone());
        watched.next();
        drop(watched.worker);
        // All events are here, and the thread with its sender has ended.
        let told = watched.event.iter().count();
        assert!(told < 1_000_000);
    }
}

#[test]
fn an_end_holds_nothing_back() {
    let config = WorkerConfig {
        gathering: Duration::from_secs(3600),
        paused: false,
        ..config()
    };
    let watched = start(config, small(&["time.end=1.0"]));
    assert_eq!(word(&watched.next()), "ready");
    watched.worker.tell(Command::End);
    let event: Vec<WorkerEvent> = watched.event.iter().map(|message| message.event).collect();
    let steps: Vec<u64> = reports(&event).iter().map(|report| report.step).collect();
    assert_eq!(steps, (0..steps.len() as u64).collect::<Vec<_>>());
    assert!(!steps.is_empty());
}

#[test]
fn without_a_director_no_anchoring_is_told() {
    let scene = small(&["anchoring=false", "nematic=false"]);
    let watched = start(config(), scene);
    watched.words_until("paused");
    watched.worker.tell(anchor(AnchoringKind::Parallel));
    watched.worker.tell(Command::Step);
    assert_eq!(watched.words_until("paused"), ["refused", "[1]", "paused"]);
    let picture = watched.worker.mailbox().fetch().unwrap();
    assert_eq!((picture.anchoring, &picture.state.director), (None, &None));
}

#[test]
fn an_event_of_a_switch_is_told_once() {
    let watched = start(config(), small(&[]));
    watched.words_until("paused");
    watched.worker.tell(anchor(AnchoringKind::None));
    watched.worker.tell(Command::Step);
    let event = watched.until(|event| matches!(event, WorkerEvent::Paused));
    let words: Vec<String> = event.iter().map(word).collect();
    let change = "anchoring.kind = \"none\" at 0e0";
    assert_eq!(words, [change, "[1]", "parameters-changed", "paused"]);
}

#[test]
fn a_run_goes_on_from_the_state_of_another() {
    let scene = small(&[]);
    let start_from = |from: Option<Box<SimulationCheckpoint>>| {
        let keep = Some(Duration::from_secs(3600));
        start_from(config(), scene.clone(), Continuity { from, keep })
    };
    let first = start_from(None);
    first.worker.tell(Command::Step);
    first.worker.tell(Command::Step);
    first.worker.tell(Command::End);
    let event = first.until(|event| matches!(event, WorkerEvent::State(_)));
    let Some(WorkerEvent::State(checkpoint)) = event.last() else {
        panic!("{event:?}");
    };
    assert_eq!(checkpoint.step(), 2);
    assert!(first.event.recv_timeout(PATIENCE).is_err(), "nothing more");
    let second = start_from(Some(checkpoint.clone()));
    second.worker.tell(Command::Step);
    let mut told = second.words_until("paused");
    told.extend(second.words_until("paused"));
    assert_eq!(told, ["ready", "[2]", "paused", "[3]", "paused"]);
    let mut simulation = Simulation::new(&scene).unwrap();
    (0..3).for_each(|_| drop(simulation.advance().unwrap().clone()));
    assert_eq!(fetched(&second.worker), (3, simulation.state().clone()));

    // The state of another scene is reported as an error, and nothing is computed.
    let other = Simulation::new(&small(&["mesh.cells=9"])).unwrap();
    let mut checkpoint = Box::new(SimulationCheckpoint::default());
    other.save(&mut checkpoint);
    let third = start_from(Some(checkpoint));
    assert!(word(&third.next()).contains("another scene"));
}
