//! Runs of the app, kept from one time to the next: a folder each.
//!
//! In the folder stand `scene.toml`, the tables of a run, which grow, and the state in two generations,
//! `checkpoint.bin` and `checkpoint-older.bin`. It is locked while a process computes the run.

mod keeper;
mod note;
#[cfg(test)]
mod tests;

pub use keeper::{KeptAt, KeptRows, RunKeeper};
pub use note::KeptNote;

use super::atomic::clean;
use super::checkpoint::{APP, CheckpointError, Keeper, Problem};
use super::folder::{SCENE, all_numbered, clear, rename_numbered};
use super::history::{Tables, TablesCheckpoint};
use super::scene_file::identity;
use super::{Columns, Found, ReadError, RecordError, Resumption, RunFolder};
use crate::record::RunMark;
use crate::scene::Scene;
use crate::simulation::SimulationCheckpoint;
use serde::{Deserialize, Serialize};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The name of a state that cannot be used.
const DAMAGED: &str = "checkpoint-damaged.bin";

/// What is kept of a run beside its rows.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Content {
    /// By which the scene is known.
    scene: String,
    checkpoint: SimulationCheckpoint,
    tables: TablesCheckpoint,
    marks: Vec<RunMark>,
    /// Seconds of computing.
    computed: f64,
}

/// A run of an earlier session. While this is held no other process resumes it.
#[derive(Debug, Default)]
pub struct KeptRun {
    content: Content,
    folder: PathBuf,
    /// `None`: of a run that `vesica run` has recorded, whose folder is left as it is.
    lock: Option<RunFolder>,
}

impl KeptRun {
    /// The state.
    pub fn checkpoint(&self) -> &SimulationCheckpoint {
        &self.content.checkpoint
    }

    /// The step that it has reached.
    pub fn step(&self) -> u64 {
        self.content.checkpoint.step()
    }

    /// What curves of it are marked with.
    pub fn marks(&self) -> &[RunMark] {
        &self.content.marks
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its scalars up to the state.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn rows(&self) -> Result<Columns, ReadError> {
        Tables::find(&self.folder, &self.content.tables).columns()
    }
}

/// What was found.
#[derive(Debug, Default)]
pub struct Search {
    /// The run to resume, if there is one.
    pub run: Option<KeptRun>,
    /// The folders of others that are kept behind it, in their order.
    pub others: Vec<PathBuf>,
    /// What is reported.
    pub notes: Vec<KeptNote>,
}

impl Search {
    /// Reports what is wrong with tables.
    fn note_tables(&mut self, remarks: Vec<String>) {
        if !remarks.is_empty() {
            self.notes.push(KeptNote::Tables { remarks });
        }
    }
}

/// The kept runs of a scene: folders `NAME-CHECKSUM`, `NAME-CHECKSUM-2`, … among those of others. The first
/// of them is the one that is resumed the next time.
#[derive(Debug, Clone)]
pub struct KeptRuns {
    parent: PathBuf,
    name: OsString,
    scene: Arc<Scene>,
    identity: String,
}

impl KeptRuns {
    /// Those of a scene of this name in the folder `parent`, which need not be there.
    pub fn new(parent: &Path, name: &str, scene: &Arc<Scene>) -> KeptRuns {
        let identity = identity(scene);
        // Runs of another scene of the same name have another folder.
        let number = crc32fast::hash(identity.as_bytes());
        KeptRuns {
            parent: parent.to_owned(),
            name: format!("{name}-{number:08x}").into(),
            scene: Arc::clone(scene),
            identity,
        }
    }

    /// Looks for the first that can be resumed. What is damaged is renamed; those behind it are only
    /// named.
    pub fn find(&self) -> Search {
        let mut search = Search::default();
        for path in all_numbered(&self.parent, &self.name) {
            if search.run.is_none() {
                self.look_at(&path, &mut search);
            } else if Keeper::names().iter().any(|name| path.join(name).is_file()) {
                search.others.push(path);
            }
        }
        search
    }

    /// Looks at the run in a folder: one that the app has kept, or one that was recorded.
    pub fn find_in(&self, folder: &Path) -> Search {
        let mut search = Search::default();
        let of_the_app = |name: &&str| {
            let read = Keeper::read::<Content>(APP, &folder.join(name));
            !matches!(read, Err(Problem::NotACheckpoint | Problem::Missing))
        };
        if Keeper::names().iter().any(of_the_app) {
            self.look_at(folder, &mut search);
        } else {
            self.look_at_recorded(folder, &mut search);
        }
        search
    }

    fn look_at(&self, path: &Path, search: &mut Search) {
        let folder = path.to_owned();
        let lock = match RunFolder::of_run(path) {
            Ok(lock) => lock,
            Err(_) => return search.notes.push(KeptNote::InUse { folder }),
        };
        clean(path);
        let mut problems = Vec::new();
        for name in Keeper::names() {
            let file = path.join(name);
            match self.read(&file) {
                Ok(content) => {
                    let note = |(path, problem): (PathBuf, Problem)| KeptNote::Older {
                        aside: aside(&problem, || {
                            let damaged = folder.join(DAMAGED);
                            fs::rename(&path, &damaged).ok().map(|()| damaged)
                        }),
                        path,
                        problem,
                    };
                    search.notes.extend(problems.into_iter().map(note));
                    let tables = Tables::find(path, &content.tables);
                    search.note_tables(tables.remarks_of_take_up());
                    search.run = Some(KeptRun {
                        content,
                        folder,
                        lock: Some(lock),
                    });
                    return;
                }
                Err(Problem::Missing) => {}
                Err(problem) => problems.push((file, problem)),
            }
        }
        let Some((_, problem)) = problems.first() else {
            // It was ended before it had a state. An empty one may be about to be locked.
            if path.join(SCENE).exists() && clear(path).is_ok() {
                let _ = fs::remove_dir(path);
            }
            return;
        };
        let aside = aside(problem, || {
            let name = joined(&self.name, "-unusable");
            rename_numbered(path, &self.parent, &name, 1).ok()
        });
        let words = |(path, problem): &(PathBuf, Problem)| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            format!("{name}: {problem}")
        };
        search.notes.push(KeptNote::Unusable {
            problems: problems.iter().map(words).collect(),
            folder,
            aside,
        });
    }

    fn read(&self, file: &Path) -> Result<Content, Problem> {
        let content = Keeper::read::<Content>(APP, file)?;
        if content.scene != self.identity {
            let words = "its values are other ones".to_owned();
            return Err(Problem::Scene(words));
        }
        Ok(content)
    }

    fn look_at_recorded(&self, path: &Path, search: &mut Search) {
        let folder = path.to_owned();
        let found = match Resumption::find(path, &self.scene) {
            Ok(Found::Run(found)) => found,
            Ok(Found::Nothing | Found::Abandoned) | Err(CheckpointError::None { .. }) => {
                return search.notes.push(KeptNote::NoCheckpoint { folder });
            }
            Err(error) => {
                let problem = error.to_string();
                return search.notes.push(KeptNote::Recorded { folder, problem });
            }
        };
        let Some(content) = found.content() else {
            return;
        };
        // Its files stay as they are.
        search.note_tables(Tables::find(path, &content.tables).remarks());
        if !found.problems().is_empty() {
            search.notes.push(KeptNote::RecordedOlder {
                folder: folder.clone(),
                problems: found.problems().to_vec(),
            });
        }
        search.run = Some(KeptRun {
            content: Content {
                scene: self.identity.clone(),
                checkpoint: content.simulation.clone(),
                tables: content.tables.clone(),
                marks: content.marks(),
                computed: 0.0,
            },
            folder,
            lock: None,
        });
    }

    /// Renames a kept run, so that the next one of the scene is the first: to a numbered name, if it is the
    /// first now. Returns where it is.
    ///
    /// # Errors
    /// [`RecordError::Rename`]; it stands where it was.
    pub fn put_aside(&self, kept: &KeptRun) -> Result<PathBuf, RecordError> {
        let path = &kept.folder;
        if *path != self.parent.join(&self.name) {
            return Ok(path.clone());
        }
        rename_numbered(path, &self.parent, &self.name, 2)
    }
}

/// Renames something that is damaged. What cannot be read at present may be good another time, and what is of
/// another scene is good for that.
fn aside(problem: &Problem, rename: impl FnOnce() -> Option<PathBuf>) -> Option<PathBuf> {
    match problem {
        Problem::Unreadable(_) | Problem::Scene(_) => None,
        _ => rename(),
    }
}

fn joined(name: &OsStr, end: &str) -> OsString {
    let mut joined = name.to_owned();
    joined.push(end);
    joined
}
