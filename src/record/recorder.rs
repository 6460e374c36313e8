//! Recording a run while it goes.

use super::checkpoint::{Content, Keeper};
use super::folder::{FINAL, SERIES, SUMMARY};
use super::history::Tables;
use super::provenance::{Session, host_is_allowed, inputs};
use super::scene_file::{identity, write_scene};
use super::summary::{EventRecord, seconds};
use super::{Ending, RecordError, RunFolder, RunSummary, Schedule, Whereabouts, vtu};
use crate::fem::Mesh;
use crate::scene::Scene;
use crate::simulation::{Simulation, State};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long rows of the tables stay in memory only.
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);
/// How long `run.json` may be behind.
const SUMMARY_INTERVAL: Duration = Duration::from_secs(10);
/// Digits of a step in a file name, at least: enough for names to sort and to look alike.
const STEP_DIGITS: usize = 7;
/// Snapshots that are kept in memory while they cannot be written, at most.
const MOST_UNWRITTEN: usize = 16;

/// What of a run is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Steps from one row to the next.
    pub every: u64,
    /// Snapshots of the fields, evenly from t = 0 to T.
    pub snapshots: u64,
    /// Time from one checkpoint to the next; zero: one after every step.
    pub checkpoint: Duration,
    /// Whether the computer is named in `run.json`.
    pub host: bool,
}

impl Settings {
    /// How often there is a checkpoint if nobody says otherwise.
    pub const CHECKPOINT: Duration = Duration::from_secs(30);

    pub(super) fn schedule(&self, scene: &Scene) -> Schedule {
        Schedule::new(&scene.time, self.every, self.snapshots)
    }
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            every: 1,
            snapshots: 5,
            checkpoint: Settings::CHECKPOINT,
            host: host_is_allowed(),
        }
    }
}

/// The record of a run that is being set up: `scene.toml` and `run.json` are there.
#[derive(Debug)]
pub struct RecorderBuilder {
    folder: RunFolder,
    settings: Settings,
    schedule: Schedule,
    summary: RunSummary,
    scene: String,
}

impl RecorderBuilder {
    /// Begins the record of a run of `scene` in `folder`.
    ///
    /// # Errors
    /// [`RecordError`] with the file that could not be written.
    pub fn begin(
        folder: RunFolder,
        scene: &Scene,
        settings: Settings,
    ) -> Result<RecorderBuilder, RecordError> {
        let schedule = settings.schedule(scene);
        let mut preparation = RecorderBuilder {
            summary: RunSummary::new(scene, schedule.steps),
            folder,
            settings,
            schedule,
            scene: identity(scene),
        };
        let session = Session::begin(0, settings.host);
        preparation.summary.sessions.push(session);
        preparation.summary.take_settings(settings);
        // First the file that marks the folder as a run's, however early the process is killed.
        preparation.summary.write(&preparation.summary_path())?;
        let path = preparation.folder.path();
        write_scene(path, scene)?;
        preparation.summary.inputs = inputs(path)?;
        Ok(preparation)
    }

    /// What is recorded when.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// The set-up is done, in `setup` of computing: records the initial state.
    ///
    /// # Errors
    /// [`RecordError`] with the file that could not be written.
    pub fn start(
        mut self,
        simulation: &Simulation,
        setup: Duration,
    ) -> Result<Recorder, RecordError> {
        self.summary.set_up(simulation, setup);
        let mut tables = Tables::create(self.folder.path(), simulation.report())?;
        tables.append(simulation.report(), 0.0);
        tables.flush()?;
        let content = Content {
            scene: self.scene,
            every: self.settings.every,
            snapshots: self.settings.snapshots,
            ..Content::default()
        };
        let keeper = Keeper::of_run(self.folder.path(), true);
        let mut recorder = Recorder::new(
            self.folder,
            (self.settings, self.schedule),
            tables,
            self.summary,
            (keeper, content),
        );
        if recorder.schedule.snapshot_due(0, 0.0) {
            recorder.snapshot(simulation)?;
        }
        recorder.summarise()?;
        recorder.checkpoint(simulation)?;
        Ok(recorder)
    }

    /// The run's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The set-up failed or was ended: says so in `run.json`.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn end(mut self, ending: Ending) -> Result<(), RecordError> {
        self.summary.end(ending);
        self.summary.write(&self.summary_path())
    }

    fn summary_path(&self) -> PathBuf {
        self.folder.path().join(SUMMARY)
    }
}

/// The record of a run that is computed.
///
/// Call [`Recorder::step`] after every time step and [`Recorder::finish`] at the end, also of a
/// run that failed: what was not written by then is lost otherwise.
///
/// What cannot be written does not stop a run: it is kept in memory and tried again, every second,
/// and at the end. Only what was written and has vanished since is lost.
#[derive(Debug)]
pub struct Recorder {
    folder: RunFolder,
    schedule: Schedule,
    tables: Tables,
    summary: RunSummary,
    summary_path: PathBuf,
    /// The time and the name of each snapshot so far.
    snapshots: Vec<(f64, String)>,
    /// Snapshots that could not be written.
    unwritten: Vec<(f64, String, Arc<Mesh>, State)>,
    keeper: Keeper,
    content: Content,
    checkpoint_interval: Duration,
    flushed: Instant,
    summarised: Instant,
    saved: Instant,
    /// What was written and is lost, for good.
    lost: Option<String>,
    is_behind: bool,
}

impl Recorder {
    /// The record in `folder`, of which nothing waits to be written.
    pub(super) fn new(
        folder: RunFolder,
        (settings, schedule): (Settings, Schedule),
        tables: Tables,
        summary: RunSummary,
        (keeper, content): (Keeper, Content),
    ) -> Recorder {
        let now = Instant::now();
        Recorder {
            summary_path: folder.path().join(SUMMARY),
            folder,
            schedule,
            tables,
            summary,
            snapshots: content.written.clone(),
            unwritten: Vec::new(),
            keeper,
            content,
            checkpoint_interval: settings.checkpoint,
            flushed: now,
            summarised: now,
            saved: now,
            lost: None,
            is_behind: false,
        }
    }

    /// The run's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Whether the folder is still there, or where it is now.
    pub fn whereabouts(&self) -> Whereabouts {
        self.folder.whereabouts()
    }

    /// What is recorded when.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// What happened so far.
    pub fn events(&self) -> &[EventRecord] {
        &self.summary.events
    }

    /// The time of computing up to the state at which the record began or was resumed.
    pub fn computed(&self) -> Duration {
        Duration::try_from_secs_f64(self.summary.seconds).unwrap_or_default()
    }

    /// Records the step that the simulation has just made. `computing` is the time of computing
    /// since the run began: of steps, not of set-up, files or pauses.
    ///
    /// # Errors
    /// [`RecordError`] with the file that could not be written. Neither the simulation nor the record
    /// is harmed: continue, and it will be tried again.
    pub fn step(
        &mut self,
        simulation: &mut Simulation,
        computing: Duration,
    ) -> Result<(), RecordError> {
        self.take_events(simulation);
        self.summary.linear_method = Some(simulation.linear_method());
        self.summary.take_mesh(simulation.mesh());
        self.summary.take_threads(simulation.threads());
        self.summary.seconds = seconds(computing);
        self.summary.underway = None;

        let report = simulation.report();
        self.summary.step(report);
        self.tables.observe(report);
        // The last row, where it is out of turn, is for the end: a run that is resumed may have a
        // later one.
        if self.schedule.row_in_turn(report.step) {
            self.tables.append(report, self.summary.seconds);
        }
        let mut outcome = Ok(());
        let mut tried = false;
        if self.schedule.is_snapshot_due(report) {
            tried = true;
            outcome = self.snapshot(simulation);
        }
        let now = Instant::now();
        if now.duration_since(self.flushed) >= FLUSH_INTERVAL {
            self.flushed = now;
            tried = true;
            let written = self.flush().and(self.write_unwritten());
            outcome = outcome.and(written);
        }
        if now.duration_since(self.summarised) >= SUMMARY_INTERVAL {
            let written = self.summarise();
            outcome = outcome.and(written);
        }
        if now.duration_since(self.saved) >= self.checkpoint_interval {
            tried = true;
            let written = self.checkpoint(simulation);
            outcome = outcome.and(written);
        }
        if tried || outcome.is_err() {
            self.is_behind = outcome.is_err();
        }
        outcome
    }

    /// Whether it is time for a checkpoint: for a step that takes long.
    pub fn checkpoint_is_due(&self) -> bool {
        self.saved.elapsed() >= self.checkpoint_interval
    }

    /// Records a step that was interrupted: its state so far, if it is time for that, and what is
    /// in memory only.
    ///
    /// # Errors
    /// As [`Recorder::step`].
    pub fn within_step(
        &mut self,
        simulation: &mut Simulation,
        computing: Duration,
    ) -> Result<(), RecordError> {
        let known = self.summary.events.len();
        self.take_events(simulation);
        self.summary.seconds = seconds(computing);
        self.summary.underway = simulation.underway();
        self.flushed = Instant::now();
        let written = self.flush().and(self.write_unwritten());
        let saved = match self.checkpoint_is_due() {
            true => self.checkpoint(simulation).and(self.summarise()),
            // Reported at once, because the step may take hours.
            false if self.summary.events.len() > known => self.summarise(),
            false => Ok(()),
        };
        let outcome = written.and(saved);
        self.is_behind = outcome.is_err();
        outcome
    }

    /// Whether something could not be written when it was tried last.
    pub fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// Ends the record: a checkpoint, the last row, `final.vtu`, and the ending in `run.json`. Each is
    /// tried even if another fails. All of them are about the last whole step; what was done of the next
    /// one is in the checkpoint.
    ///
    /// # Errors
    /// The first [`RecordError`]; `run.json` then mentions it, if it can be written.
    /// [`RecordError::Lost`] where rows were written and have vanished since.
    pub fn finish(
        mut self,
        simulation: &mut Simulation,
        ending: Ending,
    ) -> Result<RunSummary, RecordError> {
        self.take_events(simulation);
        let snapshots = self.write_unwritten();
        let saved = self.checkpoint(simulation);
        self.summary.underway = simulation.underway();
        let (report, state) = simulation.last_whole();
        self.tables.append(report, self.summary.seconds);
        let flushed = self.flush();
        let tables = flushed.and(self.tables.finish());
        let fields = vtu::write_fields(
            &self.folder().join(FINAL),
            simulation.mesh(),
            state,
            report.t,
        );
        let lost = match self.lost.take() {
            Some(what) => Err(RecordError::Lost { what }),
            None => Ok(()),
        };
        let written = tables.and(fields).and(snapshots).and(saved).and(lost);
        self.summary.end(match (ending, &written) {
            (Ending::Done | Ending::Interrupted(_), Err(error)) => {
                Ending::Failed(error.to_string())
            }
            (ending, _) => ending,
        });
        let summarised = self.summarise();
        written.and(summarised)?;
        Ok(self.summary)
    }

    /// Moves to the summary what has happened since it was last asked.
    fn take_events(&mut self, simulation: &mut Simulation) {
        let events = simulation.drain_events();
        events
            .iter()
            .for_each(|event| self.summary.take_event(event));
    }

    /// Saves the state from which the run can be resumed.
    fn checkpoint(&mut self, simulation: &Simulation) -> Result<(), RecordError> {
        self.saved = Instant::now();
        // What it says of the files must be there.
        self.flush()?;
        simulation.save(&mut self.content.simulation);
        self.content.tables = self.tables.save();
        self.content.totals = self.summary.totals(simulation.events());
        self.content.written.clone_from(&self.snapshots);
        self.keeper.write(&self.content)
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        let outcome = self.tables.flush();
        if let Err(error @ RecordError::Vanished { .. }) = &outcome {
            self.lost.get_or_insert_with(|| error.to_string());
        }
        outcome
    }

    /// Writes the present fields, and the list of all snapshots again.
    fn snapshot(&mut self, simulation: &Simulation) -> Result<(), RecordError> {
        let (mesh, state, t) = (simulation.mesh(), simulation.state(), simulation.report().t);
        let digits = STEP_DIGITS.max(self.schedule.steps.unwrap_or(0).to_string().len());
        let name = format!("step-{:0digits$}.vtu", simulation.report().step);
        let outcome = self.write_snapshot(mesh, state, t, &name);
        if let Err(error) = &outcome {
            if self.unwritten.len() < MOST_UNWRITTEN {
                self.unwritten.push((t, name, mesh.clone(), state.clone()));
            } else {
                self.lost.get_or_insert_with(|| error.to_string());
            }
        }
        outcome
    }

    fn write_snapshot(
        &mut self,
        mesh: &Mesh,
        state: &State,
        t: f64,
        name: &str,
    ) -> Result<(), RecordError> {
        let fields = self.folder.make_fields()?;
        vtu::write_fields(&fields.join(name), mesh, state, t)?;
        if !self.snapshots.iter().any(|(_, known)| known == name) {
            let place = self.snapshots.partition_point(|(earlier, _)| *earlier < t);
            self.snapshots.insert(place, (t, name.to_owned()));
        }
        vtu::write_series(&fields.join(SERIES), &self.snapshots)
    }

    /// Writes the snapshots that could not be written before.
    fn write_unwritten(&mut self) -> Result<(), RecordError> {
        while let Some((t, name, mesh, state)) = self.unwritten.pop() {
            let outcome = self.write_snapshot(&mesh, &state, t, &name);
            if outcome.is_err() {
                self.unwritten.push((t, name, mesh, state));
                return outcome;
            }
        }
        Ok(())
    }

    pub(super) fn summarise(&mut self) -> Result<(), RecordError> {
        self.summarised = Instant::now();
        self.summary.write(&self.summary_path)
    }
}

#[cfg(test)]
mod tests {
    use super::super::IfOccupied;
    use super::super::folder::FIELDS;
    use super::super::scene_file::tests::scene;
    use super::*;
    use std::fs;

    /// Runs `steps` of the small scene's three.
    fn record(folder: &Path, settings: Settings, steps: u64, ending: Ending) -> serde_json::Value {
        let scene = scene("");
        let folder = RunFolder::at(folder, IfOccupied::Refuse).unwrap();
        let preparation = RecorderBuilder::begin(folder.clone(), &scene, settings).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
        for _ in 0..steps {
            simulation.advance().unwrap();
            recorder
                .step(&mut simulation, Duration::from_millis(5))
                .unwrap();
        }
        recorder.finish(&mut simulation, ending).unwrap();
        serde_json::from_str(&fs::read_to_string(folder.path().join("run.json")).unwrap()).unwrap()
    }

    #[test]
    fn what_is_told_within_a_step_is_in_the_summary_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let mut scene = scene("[area]\npenalty = 1e-8");
        (scene.time.step, scene.time.end) = (1e-2, 1.0);
        let claimed = RunFolder::at(&path, IfOccupied::Refuse).unwrap();
        let preparation = RecorderBuilder::begin(claimed, &scene, Settings::default()).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
        assert!(!simulation.advance_unless(&mut |_| false).unwrap());
        recorder
            .within_step(&mut simulation, Duration::ZERO)
            .unwrap();
        let run = fs::read_to_string(path.join("run.json")).unwrap();
        let run: serde_json::Value = serde_json::from_str(&run).unwrap();
        let [event] = run["events"].as_array().unwrap().as_slice() else {
            panic!("{run}");
        };
        assert_eq!(
            (&event["kind"], &event["step"]),
            (&"short-steps".into(), &1.into())
        );
        let text = event["text"].as_str().unwrap();
        assert!(
            text.contains("less than a millionth of the 1.0e-2"),
            "{run}"
        );
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn steps(folder: &Path, table: &str) -> Vec<String> {
        let text = fs::read_to_string(folder.join(table)).unwrap();
        let cell = |line: &str| line.split(',').next().unwrap().to_owned();
        text.lines().skip(1).map(cell).collect()
    }

    #[test]
    fn a_whole_run_leaves_the_files_of_the_interface() {
        let folder = tempfile::tempdir().unwrap();
        let run = record(folder.path(), Settings::default(), 3, Ending::Done);
        let files = [
            "checkpoint-older.bin",
            "checkpoint.bin",
            FIELDS,
            "final.vtu",
            "history.csv",
            "ledger.csv",
            "run.json",
            "scene.toml",
            "shape.csv",
        ];
        assert_eq!(names(folder.path()), files);
        assert_eq!(
            names(&folder.path().join(FIELDS)),
            [
                "fields.pvd",
                "step-0000000.vtu",
                "step-0000001.vtu",
                "step-0000002.vtu",
                "step-0000003.vtu",
            ]
        );
        assert_eq!(
            fs::read(folder.path().join("final.vtu")).unwrap(),
            fs::read(folder.path().join("fields/step-0000003.vtu")).unwrap()
        );
        let series = fs::read_to_string(folder.path().join("fields/fields.pvd")).unwrap();
        assert_eq!(series.matches("<DataSet ").count(), 4);
        for table in ["history.csv", "shape.csv"] {
            assert_eq!(steps(folder.path(), table), ["0", "1", "2", "3"]);
        }
        assert_eq!(run["status"], "done");
        assert_eq!(run["steps"], 3);
        assert_eq!(run["planned_steps"], 3);
        assert_eq!(run["nodes"], 81);
        assert_eq!(run["seconds"], 0.005);
    }

    #[test]
    fn a_run_that_is_interrupted_has_its_last_row() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings {
            every: 10,
            snapshots: 0,
            ..Settings::default()
        };
        let run = record(folder.path(), settings, 2, Ending::Interrupted("SIGTERM"));
        assert_eq!(steps(folder.path(), "history.csv"), ["0", "2"]);
        assert!(!folder.path().join(FIELDS).exists());
        assert!(folder.path().join("final.vtu").exists());
        assert_eq!(run["status"], "interrupted");
        assert_eq!(run["steps"], 2);
    }

    #[test]
    fn a_failed_set_up_is_told_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let claimed = RunFolder::at(folder.path(), IfOccupied::Refuse).unwrap();
        let preparation = RecorderBuilder::begin(claimed, &scene(""), Settings::default()).unwrap();
        let failed = Ending::Failed("no memory".into());
        preparation.end(failed).unwrap();
        assert_eq!(names(folder.path()), ["run.json", "scene.toml"]);
        let text = fs::read_to_string(folder.path().join("run.json")).unwrap();
        assert!(text.contains(r#""status": "failed""#), "{text}");
        assert!(text.contains(r#""error": "no memory""#), "{text}");
    }

    #[test]
    fn a_folder_that_vanishes_is_an_error_and_the_run_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_owned();
        let scene = scene("");
        let claimed = RunFolder::at(&path, IfOccupied::Refuse).unwrap();
        let settings = Settings {
            checkpoint: Duration::ZERO,
            ..Settings::default()
        };
        let preparation = RecorderBuilder::begin(claimed, &scene, settings).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
        drop(folder);
        for _ in 0..2 {
            simulation.advance().unwrap();
            let error = recorder
                .step(&mut simulation, Duration::ZERO)
                .unwrap_err()
                .to_string();
            assert!(error.contains(path.to_str().unwrap()), "{error}");
        }
        // Someone creates the folder again: what was in memory is written, and what is lost is reported.
        fs::create_dir(&path).unwrap();
        simulation.advance().unwrap();
        recorder.step(&mut simulation, Duration::ZERO).unwrap();
        let error = recorder.finish(&mut simulation, Ending::Done).unwrap_err();
        assert!(matches!(error, RecordError::Lost { .. }), "{error}");
        assert_eq!(steps(&path, "history.csv"), ["1", "2", "3"]);
        assert!(path.join(FINAL).is_file() && path.join("fields/step-0000001.vtu").is_file());
        let run = fs::read_to_string(path.join("run.json")).unwrap();
        assert!(run.contains(r#""status": "failed""#), "{run}");
        fs::remove_dir_all(path).unwrap();
    }
}
