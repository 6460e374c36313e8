//! Taking a run up again from its checkpoint.

use super::atomic::{clean, write_whole};
use super::bounded_read::read_file_text;
use super::checkpoint::{CheckpointError, Content, Keeper, Problem, RUN};
use super::folder::{
    FIELDS, FINAL, SERIES, SUMMARY, a_file_of, all_numbered, check_writable, remove,
    remove_snapshots,
};
use super::history::{FoundTables, Tables};
use super::provenance::{Session, inputs};
use super::read::LARGEST;
use super::scene_file::{identity, write_scene};
use super::shortened::shortened;
use super::summary::{EventRecord, Status};
use super::{LARGEST_SUMMARY, RecordError, Recorder, RunFolder, RunSummary, Settings, vtu};
use crate::scene::Scene;
use crate::simulation::{Simulation, SimulationCheckpoint};
use std::ffi::OsStr;
use std::path::Path;

/// Snapshots that are named one by one.
const NAMED_SNAPSHOTS: usize = 4;

/// What a folder holds from which a run can be resumed.
#[derive(Debug)]
pub enum Found {
    /// Nothing: no folder, or no run in it.
    Nothing,
    /// A run that was killed before it had anything to keep.
    Abandoned,
    /// A run of the scene that can be resumed.
    Run(Box<Resumption>),
}

/// A run that is about to be resumed. Nothing is changed yet.
#[derive(Debug)]
pub struct Resumption {
    folder: RunFolder,
    /// The states to resume from, the newest first, with their names.
    candidates: Vec<(&'static str, Content)>,
    /// What is wrong with the others.
    problems: Vec<String>,
}

impl Resumption {
    /// Looks for a run of `scene` in the folder at `path`.
    ///
    /// # Errors
    /// [`CheckpointError`]: there is a run, and it cannot be resumed.
    pub fn find(path: &Path, scene: &Scene) -> Result<Found, CheckpointError> {
        if a_file_of(path).is_none() {
            return Ok(Found::Nothing);
        }
        let folder = RunFolder::of_run(path)?;
        let wanted = identity(scene);
        let mut candidates = Vec::new();
        let mut problems = Vec::new();
        for name in Keeper::names() {
            match Keeper::read::<Content>(RUN, &path.join(name)) {
                Ok(content) if content.scene == wanted => candidates.push((name, content)),
                Ok(content) => {
                    let difference = difference(&content.scene, &wanted);
                    problems.push((name, Problem::Scene(difference)));
                }
                Err(problem) => problems.push((name, problem)),
            }
        }
        let folder_path = || path.to_owned();
        if !candidates.is_empty() {
            // That there is no older one yet is not reported.
            let told = |(name, problem): &(&str, Problem)| {
                let untold = *name != Keeper::names()[0] && matches!(problem, Problem::Missing);
                (!untold).then(|| format!("{name}: {problem}"))
            };
            return Ok(Found::Run(Box::new(Resumption {
                folder,
                candidates,
                problems: problems.iter().filter_map(told).collect(),
            })));
        }
        let is_missing = |(_, problem): &(&str, Problem)| matches!(problem, Problem::Missing);
        if problems.iter().all(is_missing) {
            return if has_rows(path) {
                Err(CheckpointError::None {
                    folder: folder_path(),
                })
            } else {
                Ok(Found::Abandoned)
            };
        }
        problems.retain(|problem| !is_missing(problem));
        let is_foreign = |(_, problem): &(&str, Problem)| matches!(problem, Problem::Scene(_));
        if problems.iter().all(is_foreign)
            && let Some((_, Problem::Scene(difference))) = problems.pop()
        {
            return Err(CheckpointError::Foreign {
                folder: folder_path(),
                difference,
            });
        }
        Err(CheckpointError::Unusable {
            folder: folder_path(),
            problems: words(&problems),
        })
    }

    /// Looks for the latest run of `scene` among `parent/name`, `parent/name-2`, ….
    ///
    /// # Errors
    /// [`CheckpointError`]: the latest run cannot be resumed, or all are of other scenes.
    pub fn find_latest(
        parent: &Path,
        name: &OsStr,
        scene: &Scene,
    ) -> Result<Found, CheckpointError> {
        let mut foreign = None;
        for path in all_numbered(parent, name).into_iter().rev() {
            match Resumption::find(&path, scene) {
                Ok(Found::Nothing | Found::Abandoned) => {}
                Err(error @ CheckpointError::Foreign { .. }) => {
                    foreign.get_or_insert(error);
                }
                found => return found,
            }
        }
        match foreign {
            Some(error) => Err(error),
            None => Ok(Found::Nothing),
        }
    }

    /// Where the run is.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// How the run stands by its `run.json`, if that can be read. That it is running is not true, for nobody
    /// holds the folder's lock: the process has gone without a word.
    pub fn status(&self) -> Option<Status> {
        let status = self.recorded_summary()?.get("status")?.clone();
        serde_json::from_value(status).ok()
    }

    fn recorded_summary(&self) -> Option<serde_json::Value> {
        let text = read_file_text(&self.folder().join(SUMMARY), LARGEST_SUMMARY).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// The processes that computed the run so far, if its `run.json` can be read.
    fn sessions(&self) -> Vec<Session> {
        let recorded = self
            .recorded_summary()
            .and_then(|mut summary| Some(summary.get_mut("sessions")?.take()));
        let sessions = recorded.and_then(|value| serde_json::from_value(value).ok());
        let mut sessions: Vec<Session> = sessions.unwrap_or_default();
        sessions.iter_mut().for_each(Session::end_if_killed);
        sessions
    }

    /// Says in the `run.json` of a run whose process has gone without a word that it was interrupted.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn end_killed(&self) -> Result<(), RecordError> {
        let path = self.folder().join(SUMMARY);
        let Some(mut summary) = self.recorded_summary() else {
            return Ok(());
        };
        write_whole(&path, |file| {
            summary["status"] = serde_json::to_value(Status::Interrupted)?;
            serde_json::to_writer_pretty(&mut *file, &summary)?;
            writeln!(file)
        })
    }

    /// What the run resumes from, if it can be used.
    pub(super) fn content(&self) -> Option<&Content> {
        self.candidates.first().map(|(_, newest)| newest)
    }

    /// What is wrong with checkpoints that are there and cannot be used.
    pub(super) fn problems(&self) -> &[String] {
        &self.problems
    }

    fn checkpoint(&self) -> Option<&SimulationCheckpoint> {
        self.content().map(|content| &content.simulation)
    }

    /// The step that the run has reached.
    pub fn step(&self) -> u64 {
        self.checkpoint().map_or(0, SimulationCheckpoint::step)
    }

    /// The time that it has reached.
    pub fn t(&self) -> f64 {
        self.checkpoint().map_or(0.0, SimulationCheckpoint::t)
    }

    /// Whether nothing moved any more there, so that the run was over.
    pub fn is_at_rest(&self) -> bool {
        self.checkpoint()
            .is_some_and(SimulationCheckpoint::is_at_rest)
    }

    /// What the run had recorded, but for how often it is saved.
    pub fn settings(&self) -> Settings {
        let newest = self.candidates.first();
        newest.map_or_else(Settings::default, |(_, content)| Settings {
            every: content.every,
            snapshots: content.snapshots,
            ..Settings::default()
        })
    }

    /// Brings the simulation, which is new and of the same scene, to where the run was, and its files.
    /// With it come the checkpoints that cannot be used, and why, and what is not as the run has left it.
    ///
    /// # Errors
    /// [`CheckpointError::Unusable`]: nothing was changed. [`CheckpointError::Record`]: a file could not
    /// be written; the checkpoint stands as it was.
    pub fn start(
        mut self,
        scene: &Scene,
        settings: Settings,
        simulation: &mut Simulation,
    ) -> Result<(Recorder, Vec<String>), CheckpointError> {
        let Some((name, mut content, tables)) = self.choose(simulation) else {
            return Err(CheckpointError::Unusable {
                folder: self.folder().to_owned(),
                problems: self.problems,
            });
        };
        let (step, t) = (content.simulation.step(), content.simulation.t());
        check_writable(self.folder(), step)?;
        tables.check()?;
        let lost = lose_snapshots(&self.folder().join(FIELDS), &mut content.written);
        let mut remarks = tables.remarks_of_take_up();
        remarks.extend(lost);
        let sessions = self.sessions();
        let tables = self.cut_back(scene, &content, tables)?;
        let schedule = settings.schedule(scene);
        let mut summary =
            RunSummary::resumed(scene, schedule.steps, content.totals.clone(), simulation);
        summary.inputs = inputs(self.folder())?;
        summary.sessions = sessions;
        summary.sessions.push(Session::begin(step, settings.host));
        summary.take_threads(simulation.threads());
        summary.take_settings(settings);
        summary.events.push(EventRecord {
            kind: "resumed".into(),
            step,
            t,
            values: Default::default(),
            text: {
                let mut text = format!("the run was resumed from {name}");
                if !self.problems.is_empty() {
                    text += &format!("; not used: {}", self.problems.join("; "));
                }
                remarks
                    .iter()
                    .for_each(|remark| text += &format!("; {remark}"));
                text
            },
        });
        let newest_is_good = name == Keeper::names()[0];
        let keeper = Keeper::of_run(self.folder(), newest_is_good);
        let content = Content {
            every: settings.every,
            snapshots: settings.snapshots,
            ..content
        };
        let mut recorder = Recorder::new(
            self.folder,
            (settings, schedule),
            tables,
            summary,
            (keeper, content),
        );
        recorder.summarise()?;
        self.problems.extend(remarks);
        Ok((recorder, self.problems))
    }

    /// Brings the simulation, which is new and of the same scene, to where the run was, and returns how that
    /// went. Changes no file.
    ///
    /// # Errors
    /// [`CheckpointError::Unusable`].
    pub fn look(
        mut self,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<RunSummary, CheckpointError> {
        let schedule = self.settings().schedule(scene);
        match self.choose(simulation) {
            Some((_, content, _)) => Ok(RunSummary::resumed(
                scene,
                schedule.steps,
                content.totals,
                simulation,
            )),
            None => Err(CheckpointError::Unusable {
                folder: self.folder().to_owned(),
                problems: self.problems,
            }),
        }
    }

    /// The first candidate whose state is right, and the tables as they are.
    fn choose(
        &mut self,
        simulation: &mut Simulation,
    ) -> Option<(&'static str, Content, FoundTables)> {
        for (name, content) in std::mem::take(&mut self.candidates) {
            match simulation.restore(&content.simulation) {
                Ok(()) => {
                    let tables = Tables::find(self.folder(), &content.tables);
                    return Some((name, content, tables));
                }
                Err(error) => {
                    let problem = Problem::State(error);
                    self.problems.push(format!("{name}: {problem}"));
                }
            }
        }
        None
    }

    /// Takes back what was recorded after the checkpoint.
    fn cut_back(
        &self,
        scene: &Scene,
        content: &Content,
        tables: FoundTables,
    ) -> Result<Tables, RecordError> {
        let folder = self.folder();
        let fields = folder.join(FIELDS);
        let step = content.simulation.step();
        write_scene(folder, scene)?;
        let tables = tables.reopen()?;
        remove(&folder.join(FINAL))?;
        remove_snapshots(folder, |snapshot| snapshot > step)?;
        match &content.written[..] {
            [] => remove(&fields.join(SERIES))?,
            written => vtu::write_series(&fields.join(SERIES), written)?,
        }
        clean(folder);
        clean(&fields);
        Ok(tables)
    }
}

/// Takes those snapshots off the list that are not in the folder, or not whole; returns what is reported of
/// them, in words.
fn lose_snapshots(fields: &Path, written: &mut Vec<(f64, String)>) -> Option<String> {
    let all = written.len();
    let mut lost = Vec::new();
    written.retain(|(_, name)| {
        let is_whole = vtu::is_whole(&fields.join(name));
        if !is_whole {
            lost.push(name.clone());
        }
        is_whole
    });
    let named = lost.iter().take(NAMED_SNAPSHOTS).cloned();
    let named = named.collect::<Vec<String>>().join(", ");
    let more = if lost.len() > NAMED_SNAPSHOTS {
        ", …"
    } else {
        ""
    };
    (!lost.is_empty()).then(|| {
        format!(
            "{} of {all} snapshots in {} are gone or damaged, and no longer listed in {SERIES}: {named}{more}",
            lost.len(),
            fields.display()
        )
    })
}

fn words(problems: &[(&'static str, Problem)]) -> Vec<String> {
    let words = |(name, problem): &(&str, Problem)| format!("{name}: {problem}");
    problems.iter().map(words).collect()
}

/// Whether a run has recorded more than its initial state.
fn has_rows(folder: &Path) -> bool {
    let text = read_file_text(&folder.join("history.csv"), LARGEST);
    text.is_ok_and(|text| text.lines().count() > 2)
}

/// The first line in which two scenes differ, with its table.
fn difference(there: &str, wanted: &str) -> String {
    let mut table = "";
    let mut lines = (there.lines(), wanted.lines());
    loop {
        match (lines.0.next(), lines.1.next()) {
            (Some(one), Some(other)) if one == other => {
                if one.starts_with('[') {
                    table = one;
                }
            }
            (None, None) => return "it is written otherwise".to_owned(),
            (one, other) => {
                let [one, other] =
                    [one, other].map(|line| shortened(line.unwrap_or("nothing").trim()));
                let table = if table.is_empty() {
                    String::new()
                } else {
                    format!("in {table} ")
                };
                return format!("{table}it has {one}, and {other} is asked for");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::read_fields;
    use super::super::{Columns, Ending, IfOccupied, RecorderBuilder};
    use super::*;
    use std::fs;
    use std::time::Duration;

    /// Every step has many parts, and other solvers take over on the way.
    const HARD: &str = "
        mesh = { cells = 8, jitter = 0.6, seed = 7 }
        vesicle = { shape = 'random', amplitude = 4.0, seed = 3 }
        membrane = { interface_width = 0.04 }
        area = { target = 1.25, penalty = 1e-6 }
        nematic = { initial = { kind = 'random', seed = 2 } }
        anchoring = {}
        time = { step = 1e-4, end = 2e-4 }
    ";

    fn summary(folder: &Path) -> serde_json::Value {
        let text = fs::read_to_string(folder.join("run.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// What happened before the first checkpoint is known to a run that resumes from there.
    #[test]
    fn a_run_that_is_killed_in_its_first_step_knows_what_happened_at_the_start() {
        let scene = Scene::of_text(HARD, &[]);
        let parent = tempfile::tempdir().unwrap();
        let folder = RunFolder::at(parent.path(), IfOccupied::Refuse).unwrap();
        let settings = Settings::default();
        let preparation = RecorderBuilder::begin(folder, &scene, settings).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        drop(preparation.start(&simulation, Duration::ZERO).unwrap());
        let mut simulation = Simulation::new(&scene).unwrap();
        let Ok(Found::Run(found)) = Resumption::find(parent.path(), &scene) else {
            panic!("it can be taken up again");
        };
        let (mut recorder, _) = found.start(&scene, settings, &mut simulation).unwrap();
        recorder.step(&mut simulation, Duration::ZERO).unwrap();
        let kinds = recorder.events().iter().map(|event| &*event.kind);
        assert_eq!(kinds.collect::<Vec<_>>(), ["reached-wall", "resumed"]);
    }

    /// A run that is ended again and again within its steps records the same as an undisturbed one; and whenever
    /// it is ended its files are about the same time.
    #[test]
    fn a_run_that_is_ended_within_its_steps_is_the_same_run() {
        let scene = Scene::of_text(HARD, &[]);
        let parent = tempfile::tempdir().unwrap();
        let [whole, parted] = ["whole", "parted"].map(|name| parent.path().join(name));
        for (path, attempts) in [(&whole, u32::MAX), (&parted, 30)] {
            let folder = RunFolder::at(path, IfOccupied::Refuse).unwrap();
            let settings = Settings::default();
            let preparation = RecorderBuilder::begin(folder, &scene, settings).unwrap();
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
            let mut ended = 0;
            while simulation.last_whole().0.step < 2 {
                let mut left = attempts;
                let leave = &mut |_: &_| {
                    left -= 1;
                    left == 0
                };
                if simulation.advance_unless(leave).unwrap() {
                    recorder.step(&mut simulation, Duration::ZERO).unwrap();
                    continue;
                }
                ended += 1;
                recorder
                    .within_step(&mut simulation, Duration::ZERO)
                    .unwrap();
                recorder
                    .finish(&mut simulation, Ending::Interrupted("SIGTERM"))
                    .unwrap();
                let run = summary(path);
                let rows = Columns::read(path).unwrap();
                let last = |name: &str| *rows.column(name).unwrap().last().unwrap();
                assert_eq!(run["t"].as_f64(), Some(last("t")));
                assert_eq!(run["steps"].as_f64(), Some(last("step")));
                assert_eq!(run["total_energy"].as_f64(), Some(last("E_total")));
                let fields = read_fields(&path.join(FINAL)).unwrap();
                assert_eq!(fields.t, last("t"));
                assert_eq!(fields.state, *simulation.last_whole().1);
                assert!(run["underway"]["t"].as_f64() >= Some(last("t")), "{run}");
                simulation = Simulation::new(&scene).unwrap();
                let Ok(Found::Run(found)) = Resumption::find(path, &scene) else {
                    panic!("it can be taken up again");
                };
                let (again, problems) = found.start(&scene, settings, &mut simulation).unwrap();
                assert!(problems.is_empty(), "{problems:?}");
                recorder = again;
            }
            assert_eq!(ended > 3, attempts == 30, "{ended}");
            recorder.finish(&mut simulation, Ending::Done).unwrap();
        }
        let [mut wanted, mut found] = [&whole, &parted].map(|path| summary(path));
        for run in [&mut wanted, &mut found] {
            let events = run["events"].as_array_mut().unwrap();
            events.retain(|event| event["kind"] != "resumed");
            for clock in [
                "started",
                "ended",
                "setup_seconds",
                "milliseconds",
                "sessions",
            ] {
                run.as_object_mut().unwrap().remove(clock);
            }
        }
        assert!(wanted["events"].as_array().unwrap().len() > 3);
        assert_eq!(found, wanted);
        for file in ["history.csv", "ledger.csv", "shape.csv", FINAL] {
            let [wanted, found] = [&whole, &parted].map(|path| fs::read(path.join(file)).unwrap());
            assert!(found == wanted, "{file}");
        }
    }

    #[test]
    fn the_first_difference_is_told_with_its_table() {
        let text = "name = \"A\"\n[mesh]\ncells = 8\n";
        let told = difference(text, &text.replace('8', "9"));
        assert_eq!(
            told,
            "in [mesh] it has cells = 8, and cells = 9 is asked for"
        );
        let told = difference(text, "name = \"A\"\n[mesh]\n");
        assert_eq!(told, "in [mesh] it has cells = 8, and nothing is asked for");
        let long = format!("name = \"{}\"\n", "A".repeat(1 << 20));
        let told = difference(&long, text);
        assert!(told.len() < 200, "{} bytes", told.len());
    }
}
