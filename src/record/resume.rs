//! Taking a run up again from its checkpoint.

use super::atomic::clean;
use super::checkpoint::{CheckpointError, Content, Keeper, Problem, RUN};
use super::folder::{FIELDS, FINAL, SERIES, a_file_of, all_numbered, remove, remove_snapshots};
use super::history::{FoundTables, Tables};
use super::scene_file::{identity, write_scene};
use super::summary::EventRecord;
use super::{RecordError, Recorder, RunFolder, RunSummary, Settings, vtu};
use crate::scene::Scene;
use crate::simulation::{Memory, Simulation};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

/// What stands in a folder for a run to go on from.
#[derive(Debug)]
pub enum Found {
    /// Nothing: no folder, or no run in it.
    Nothing,
    /// A run that was killed before it had anything to keep.
    Abandoned,
    /// A run of the scene that can be taken up again.
    Run(Box<Resumption>),
}

/// A run that is about to be taken up again. Nothing is changed yet.
#[derive(Debug)]
pub struct Resumption {
    folder: RunFolder,
    /// What can be gone on from, the newest first, with their names.
    candidates: Vec<(&'static str, Content)>,
    /// What is wrong with the others.
    problems: Vec<String>,
}

impl Resumption {
    /// Looks for a run of `scene` in the folder at `path`.
    ///
    /// # Errors
    /// [`CheckpointError`]: there is a run, and it cannot be taken up again.
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
            // That there is no older one yet is nothing to tell.
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
    /// [`CheckpointError`]: the latest run cannot be taken up again, or all are of other scenes.
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

    /// What the run goes on from, if it can be used.
    pub(super) fn content(&self) -> Option<&Content> {
        self.candidates.first().map(|(_, newest)| newest)
    }

    /// What is wrong with checkpoints that are there and cannot be used.
    pub(super) fn problems(&self) -> &[String] {
        &self.problems
    }

    fn memory(&self) -> Option<&Memory> {
        self.content().map(|content| &content.simulation)
    }

    /// The step that the run has come to.
    pub fn step(&self) -> u64 {
        self.memory().map_or(0, Memory::step)
    }

    /// The time that it has come to.
    pub fn t(&self) -> f64 {
        self.memory().map_or(0.0, Memory::t)
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
    /// With it come the checkpoints that cannot be used, and why.
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
        let Some((name, content, tables)) = self.choose(simulation) else {
            return Err(CheckpointError::Unusable {
                folder: self.folder().to_owned(),
                problems: self.problems,
            });
        };
        let schedule = settings.schedule(scene);
        let (step, t) = (content.simulation.step(), content.simulation.t());
        let mut summary =
            RunSummary::resumed(scene, schedule.steps, content.totals.clone(), simulation);
        summary.events.push(EventRecord {
            kind: "resumed".into(),
            step,
            t,
            text: match &self.problems[..] {
                [] => format!("the run was taken up again from {name}"),
                problems => format!(
                    "the run was taken up again from {name}; not used: {}",
                    problems.join("; ")
                ),
            },
        });
        let tables = self.cut_back(scene, &content, tables)?;
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
        Ok((recorder, self.problems))
    }

    /// Brings the simulation, which is new and of the same scene, to where the run was, and tells how that
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

    /// The first candidate whose state and tables are right.
    fn choose(
        &mut self,
        simulation: &mut Simulation,
    ) -> Option<(&'static str, Content, FoundTables)> {
        for (name, content) in std::mem::take(&mut self.candidates) {
            let recalled = simulation
                .recall(&content.simulation)
                .map_err(Problem::State);
            let found = recalled.and_then(|()| {
                Tables::find(self.folder(), &content.tables).map_err(Problem::Tables)
            });
            match found {
                Ok(tables) => return Some((name, content, tables)),
                Err(problem) => self.problems.push(format!("{name}: {problem}")),
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
        let tables = tables.take_up()?;
        remove(&folder.join(FINAL))?;
        remove_snapshots(folder, |snapshot| snapshot > step)?;
        match &content.written[..] {
            [] => remove(&fields.join(SERIES))?,
            written => vtu::write_series(&fields.join(SERIES), written)?,
        }
        clean(folder);
        clean(&fields);
        write_scene(folder, scene)?;
        Ok(tables)
    }
}

fn words(problems: &[(&'static str, Problem)]) -> Vec<String> {
    let words = |(name, problem): &(&str, Problem)| format!("{name}: {problem}");
    problems.iter().map(words).collect()
}

/// Whether a run has recorded more than its initial state.
fn has_rows(folder: &Path) -> bool {
    fs::read_to_string(folder.join("history.csv")).is_ok_and(|text| text.lines().count() > 2)
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
                let [one, other] = [one, other].map(|line| line.unwrap_or("nothing").trim());
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
    use super::*;

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
    }
}
