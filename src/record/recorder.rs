//! Recording a run while it goes.

use super::folder::{SERIES, SUMMARY};
use super::history::Tables;
use super::scene_file::write_scene;
use super::summary::{EventRecord, seconds};
use super::{Ending, RecordError, RunFolder, RunSummary, Schedule, vtu};
use crate::scene::Scene;
use crate::simulation::Simulation;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long rows of the tables stay in memory only.
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);
/// How long `run.json` may be behind.
const SUMMARY_INTERVAL: Duration = Duration::from_secs(10);
/// Digits of a step in a file name, at least: enough for names to sort and to look alike.
const STEP_DIGITS: usize = 7;

/// What of a run is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// A row every so many steps.
    pub every: u64,
    /// Snapshots of the fields, evenly from t = 0 to T.
    pub snapshots: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            every: 1,
            snapshots: 5,
        }
    }
}

/// The record of a run that is being set up: `scene.toml` and `run.json` are there.
#[derive(Debug)]
pub struct Preparation {
    folder: RunFolder,
    schedule: Schedule,
    summary: RunSummary,
}

impl Preparation {
    /// Begins the record of a run of `scene` in `folder`.
    ///
    /// # Errors
    /// [`RecordError`] with the file that could not be written.
    pub fn begin(
        folder: RunFolder,
        scene: &Scene,
        settings: Settings,
    ) -> Result<Preparation, RecordError> {
        let schedule = Schedule::new(&scene.time, settings.every, settings.snapshots);
        write_scene(folder.path(), scene)?;
        let preparation = Preparation {
            summary: RunSummary::new(scene, schedule.steps),
            folder,
            schedule,
        };
        preparation.summary.write(&preparation.summary_path())?;
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
        let now = Instant::now();
        let mut recorder = Recorder {
            tables: Tables::create(self.folder.path(), simulation.report())?,
            summary_path: self.summary_path(),
            folder: self.folder,
            schedule: self.schedule,
            summary: self.summary,
            snapshots: Vec::new(),
            flushed: now,
            summarised: now,
        };
        recorder.tables.append(simulation.report(), 0.0)?;
        recorder.tables.flush()?;
        if recorder.schedule.snapshot_due(0, 0.0) {
            recorder.snapshot(simulation)?;
        }
        recorder.summarise()?;
        Ok(recorder)
    }

    /// The set-up failed: says so in `run.json`.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn fail(mut self, error: String) -> Result<(), RecordError> {
        self.summary.end(Ending::Failed(error));
        self.summary.write(&self.summary_path())
    }

    fn summary_path(&self) -> PathBuf {
        self.folder.path().join(SUMMARY)
    }
}

/// The record of a run that goes on.
///
/// Call [`Recorder::step`] after every time step and [`Recorder::finish`] at the end, also of a
/// run that failed: what was not written by then is lost otherwise.
#[derive(Debug)]
pub struct Recorder {
    folder: RunFolder,
    schedule: Schedule,
    tables: Tables,
    summary: RunSummary,
    summary_path: PathBuf,
    /// The time and the name of each snapshot so far.
    snapshots: Vec<(f64, String)>,
    flushed: Instant,
    summarised: Instant,
}

impl Recorder {
    /// The run's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// What is recorded when.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// What happened so far.
    pub fn events(&self) -> &[EventRecord] {
        &self.summary.events
    }

    /// Records the step that the simulation has just made. `computing` is the time of computing
    /// since the run began: of steps, not of set-up, files or pauses.
    ///
    /// # Errors
    /// [`RecordError`] with the file that could not be written. The simulation is not harmed.
    pub fn step(
        &mut self,
        simulation: &mut Simulation,
        computing: Duration,
    ) -> Result<(), RecordError> {
        let events = simulation.drain_events();
        self.summary.events.extend(events.iter().map(Into::into));
        self.summary.linear_method = Some(simulation.linear_method());
        self.summary.seconds = seconds(computing);

        let report = simulation.report();
        self.summary.step(report);
        self.tables.observe(report);
        if self.schedule.row_due(report.step, report.t) {
            self.tables.append(report, self.summary.seconds)?;
        }
        if self.schedule.snapshot_due(report.step, report.t) {
            self.snapshot(simulation)?;
        }
        let now = Instant::now();
        if now.duration_since(self.flushed) >= FLUSH_INTERVAL {
            self.flushed = now;
            self.tables.flush()?;
        }
        if now.duration_since(self.summarised) >= SUMMARY_INTERVAL {
            self.summarise()?;
        }
        Ok(())
    }

    /// Ends the record: the last row, `final.vtu`, and the ending in `run.json`. Each is tried
    /// even if another fails.
    ///
    /// # Errors
    /// The first [`RecordError`]; `run.json` then tells of it, where it can be written.
    pub fn finish(
        mut self,
        simulation: &mut Simulation,
        ending: Ending,
    ) -> Result<RunSummary, RecordError> {
        let events = simulation.drain_events();
        self.summary.events.extend(events.iter().map(Into::into));
        let report = simulation.report();
        let tables = self
            .tables
            .append(report, self.summary.seconds)
            .and(self.tables.finish());
        let fields = vtu::write_fields(
            &self.folder().join("final.vtu"),
            simulation.mesh(),
            simulation.state(),
            report.t,
        );
        let written = tables.and(fields);
        self.summary.end(match (ending, &written) {
            (Ending::Done | Ending::Interrupted, Err(error)) => Ending::Failed(error.to_string()),
            (ending, _) => ending,
        });
        let summarised = self.summarise();
        written.and(summarised)?;
        Ok(self.summary)
    }

    /// Writes the fields as they are, and the list of all snapshots anew.
    fn snapshot(&mut self, simulation: &Simulation) -> Result<(), RecordError> {
        let fields = self.folder.make_fields()?;
        let report = simulation.report();
        let digits = STEP_DIGITS.max(self.schedule.steps.unwrap_or(0).to_string().len());
        let name = format!("step-{:0digits$}.vtu", report.step);
        vtu::write_fields(
            &fields.join(&name),
            simulation.mesh(),
            simulation.state(),
            report.t,
        )?;
        self.snapshots.push((report.t, name));
        vtu::write_series(&fields.join(SERIES), &self.snapshots)
    }

    fn summarise(&mut self) -> Result<(), RecordError> {
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
        let preparation = Preparation::begin(folder.clone(), &scene, settings).unwrap();
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
        };
        let run = record(folder.path(), settings, 2, Ending::Interrupted);
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
        let preparation = Preparation::begin(claimed, &scene(""), Settings::default()).unwrap();
        preparation.fail("no memory".into()).unwrap();
        assert_eq!(names(folder.path()), ["run.json", "scene.toml"]);
        let text = fs::read_to_string(folder.path().join("run.json")).unwrap();
        assert!(text.contains(r#""status": "failed""#), "{text}");
        assert!(text.contains(r#""error": "no memory""#), "{text}");
    }

    #[test]
    fn a_folder_that_vanishes_is_an_error_and_no_panic() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene("");
        let claimed = RunFolder::at(folder.path(), IfOccupied::Refuse).unwrap();
        let preparation = Preparation::begin(claimed, &scene, Settings::default()).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
        drop(folder);
        simulation.advance().unwrap();
        let step = recorder.step(&mut simulation, Duration::ZERO);
        let error = recorder
            .finish(&mut simulation, Ending::Failed("vanished".into()))
            .unwrap_err();
        assert!(
            step.is_err() || matches!(error, RecordError::Vanished { .. }),
            "{error}"
        );
        assert!(error.to_string().contains(".csv"), "{error}");
    }
}
