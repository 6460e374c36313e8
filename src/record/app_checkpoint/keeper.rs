//! Keeping a run while it goes.

use super::{Content, KeptRun, KeptRuns};
use crate::record::RunMark;
use crate::record::atomic::size;
use crate::record::checkpoint::{APP, Keeper};
use crate::record::folder::clear;
use crate::record::history::{Tables, TablesRows};
use crate::record::scene_file::write_scene;
use crate::record::{RecordError, RunFolder};
use crate::scene::Change;
use crate::simulation::{Event, Report, SimulationCheckpoint, StepProgress};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long rows stay in memory only.
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);
/// This many steps have a row each; of as many that follow every second one has, of twice as many after
/// these every fourth, and so on: the rows of a day of 40,000 steps a second are a million.
pub(super) const STEPS_WITH_ROWS: u64 = 1 << 17;
/// Whether a step has a row in the tables of a kept run.
pub(super) fn has_row(step: u64) -> bool {
    step.is_multiple_of((step / STEPS_WITH_ROWS + 1).next_power_of_two())
}

impl KeptRuns {
    /// Keeps a new run. Nothing is written yet.
    pub fn begin(&self) -> RunKeeper {
        RunKeeper {
            content: Content {
                scene: self.identity.clone(),
                ..Content::default()
            },
            runs: self.clone(),
            folder: None,
            tables: None,
            keeper: None,
            reached: None,
            latest: None,
            flushed: Instant::now(),
            kept: None,
            lost: None,
            is_discarded: false,
        }
    }

    /// Resumes a kept run. Its rows after the state are removed; those of a recorded one are copied.
    /// What is wrong with its tables was reported when it was found.
    ///
    /// # Errors
    /// [`RecordError`] where its files cannot be read or written any more.
    pub fn go_on(&self, kept: &KeptRun) -> Result<RunKeeper, RecordError> {
        let content = &kept.content;
        let mut runs = self.clone();
        Arc::make_mut(&mut runs.scene).changes = content.checkpoint.changes().to_vec();
        let mut keeper = RunKeeper {
            content: content.clone(),
            runs,
            reached: Some(content.checkpoint.step()),
            ..self.begin()
        };
        let found = Tables::find(&kept.folder, &content.tables);
        match &kept.lock {
            Some(lock) => {
                keeper.kept = Some(KeptAt {
                    folder: kept.folder.clone(),
                    step: kept.step(),
                    bytes: size(&kept.folder),
                });
                keeper.take_folder(lock.clone());
                keeper.tables = Some(found.reopen()?);
            }
            None => {
                let rows = found.rows()?;
                let path = keeper.make_folder()?.to_owned();
                rows.write(&path)?;
                keeper.tables = Some(Tables::find(&path, &content.tables).reopen()?);
            }
        }
        Ok(keeper)
    }
}

/// Where and how far a run is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeptAt {
    /// The folder.
    pub folder: PathBuf,
    /// The step of the state.
    pub step: u64,
    /// The size of all that the folder holds.
    pub bytes: u64,
}

/// The rows of a kept run at some moment.
#[derive(Debug)]
pub struct KeptRows(pub(in crate::record) TablesRows);

/// Keeps a run while it goes. Its folder is made with the first rows that are written.
#[derive(Debug)]
pub struct RunKeeper {
    runs: KeptRuns,
    content: Content,
    folder: Option<RunFolder>,
    tables: Option<Tables>,
    keeper: Option<Keeper>,
    /// The last step that was taken in.
    reached: Option<u64>,
    /// Its scalars, where they are known.
    latest: Option<Report>,
    flushed: Instant,
    kept: Option<KeptAt>,
    /// What has vanished.
    lost: Option<RecordError>,
    is_discarded: bool,
}

impl RunKeeper {
    /// Takes in the scalars of a step. Those of the state that a run continues from come again.
    pub fn step(&mut self, report: &Report) {
        if self.reached.is_none_or(|reached| reached < report.step) {
            self.reached = Some(report.step);
            self.content.computed += report.costs.total().as_secs_f64();
            let tables = self
                .tables
                .get_or_insert_with(|| Tables::new(Path::new(""), report));
            tables.observe(report);
            if has_row(report.step) {
                tables.append(report, self.content.computed);
            }
        }
        self.latest = Some(report.clone());
    }

    /// Takes in a change of the scene that was made while the run goes.
    ///
    /// # Errors
    /// [`RecordError`]: the scene that stands beside the state cannot be written again.
    pub fn changed(&mut self, change: &Change) -> Result<(), RecordError> {
        let scene = Arc::make_mut(&mut self.runs.scene);
        // The run has it, so it is one that the scene can have.
        let _ = scene.add_change(change);
        match &self.folder {
            Some(folder) => write_scene(folder.path(), &self.runs.scene),
            None => Ok(()),
        }
    }

    /// Takes in an event that curves are marked with.
    pub fn mark(&mut self, event: &Event) {
        self.content.marks.extend(RunMark::of(event));
    }

    /// Writes the rows if it is time: whether that went well.
    pub fn flush_in_time(&mut self) -> Option<Result<(), RecordError>> {
        let is_due = self.flushed.elapsed() >= FLUSH_INTERVAL;
        is_due.then(|| self.flush())
    }

    /// Keeps the state, and all rows up to it.
    ///
    /// # Errors
    /// [`RecordError`]: what could not be written. What was kept before stands.
    pub fn keep(&mut self, checkpoint: SimulationCheckpoint) -> Result<(), RecordError> {
        self.content.checkpoint = checkpoint;
        self.flush()?;
        if let Some(tables) = &self.tables {
            self.content.tables = tables.save();
        }
        let (Some(folder), Some(keeper)) = (&self.folder, &mut self.keeper) else {
            return Ok(());
        };
        keeper.write(&self.content)?;
        self.kept = Some(KeptAt {
            folder: folder.path().to_owned(),
            step: self.content.checkpoint.step(),
            bytes: size(folder.path()),
        });
        Ok(())
    }

    /// Where and how far the run is kept, if it is.
    pub fn kept(&self) -> Option<&KeptAt> {
        self.kept.as_ref()
    }

    /// How far the run was in the step after the last one that was taken in, when it was kept.
    pub fn underway(&self) -> Option<StepProgress> {
        let checkpoint = &self.content.checkpoint;
        let is_kept = self.kept.is_some() && self.reached == Some(checkpoint.step());
        checkpoint.underway().filter(|_| is_kept)
    }

    /// The scalars of the last step that was taken in, where they are known.
    pub fn latest(&self) -> Option<&Report> {
        self.latest.as_ref()
    }

    /// The last step that was taken in.
    pub fn reached(&self) -> Option<u64> {
        self.reached
    }

    /// The rows up to now, those too that could not be written.
    ///
    /// # Errors
    /// [`RecordError`] where they cannot be read.
    pub fn rows(&mut self) -> Result<Option<KeptRows>, RecordError> {
        let tables = self.tables.as_mut();
        tables
            .map(|tables| tables.rows_now().map(KeptRows))
            .transpose()
    }

    /// What was written and has vanished since, once.
    pub fn take_lost(&mut self) -> Option<RecordError> {
        self.lost.take()
    }

    /// Removes all that was kept of the run; nothing more is kept of it.
    ///
    /// # Errors
    /// [`RecordError::Remove`].
    pub fn discard(&mut self) -> Result<(), RecordError> {
        self.is_discarded = true;
        self.kept = None;
        let Some(folder) = self.folder.take() else {
            return Ok(());
        };
        clear(folder.path())?;
        // It stays if it holds anything else.
        let _ = fs::remove_dir(folder.path());
        Ok(())
    }

    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        self.flushed = Instant::now();
        if self.is_discarded {
            return Ok(());
        }
        if let Some(folder) = self.folder.take_if(|folder| !folder.path().is_dir()) {
            let path = folder.path().to_owned();
            self.kept = None;
            self.lost = Some(RecordError::Vanished { path });
        }
        if self.folder.is_none() {
            let path = self.make_folder()?.to_owned();
            if let Some(tables) = &mut self.tables {
                tables.move_to(&path);
            }
        }
        let outcome = self.tables.as_mut().map_or(Ok(()), Tables::flush);
        if let Err(lost @ RecordError::Vanished { .. }) = outcome {
            // The next flush starts a new table.
            self.lost = Some(lost);
            return self.tables.as_mut().map_or(Ok(()), Tables::flush);
        }
        outcome
    }

    /// A folder of its own.
    fn make_folder(&mut self) -> Result<&Path, RecordError> {
        let runs = &self.runs;
        let folder = RunFolder::numbered(&runs.parent, &runs.name)?;
        if let Err(error) = write_scene(folder.path(), &runs.scene) {
            // Nothing stands there yet.
            let _ = clear(folder.path()).map(|()| fs::remove_dir(folder.path()));
            return Err(error);
        }
        Ok(self.take_folder(folder))
    }

    fn take_folder(&mut self, folder: RunFolder) -> &Path {
        let generations = Keeper::names().map(|name| folder.path().join(name));
        self.keeper = Some(Keeper::new(APP, generations, true));
        self.folder.insert(folder).path()
    }
}
