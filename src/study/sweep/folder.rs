//! The folder of a sweep.
//!
//! | file | what |
//! | --- | --- |
//! | `sweep.json` | the points: values, folder, predicted time and memory; it marks the folder, and is written last |
//! | `plan.toml` | the plan as it was read |
//! | `base/` | the plan's scene, complete, with its files |
//! | `points/0007-3fa2b1/` | the run of a point |
//! | `points/0007-3fa2b1.lock` | who works on it |
//! | `jobs.txt` | a command for each point, to be run by anything |
//! | `table.csv` | the table, when a sweep ends |
//!
//! How far the sweep is follows from the points' folders alone.

use super::error::SweepError;
use super::lock::{Holder, PointLock};
use super::plan::Plan;
use super::points::{Needs, Origin, Point, folder_of, identity, name, points};
use crate::record::{
    LARGEST_SCENE, LoadedScene, RunFolder, Status, clean, load_scene, make_folder, read_file_text,
    read_text, write_scene, write_whole,
};
use crate::scene::{Scene, preset};
use serde::{Deserialize, Serialize};
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What marks the folder of a sweep.
const SWEEP: &str = "sweep.json";
const PLAN: &str = "plan.toml";
const BASE: &str = "base";
const POINTS: &str = "points";

/// Bytes of sweep.json and of a run.json, at most.
const LARGEST: u64 = 1 << 30;

/// A sweep whose points were checked, before it has a folder.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// The plan.
    pub plan: Plan,
    /// What it is called.
    pub title: String,
    /// Its scene with what the plan sets.
    pub base: Scene,
    /// Where that is from.
    pub origin: Origin,
    /// All points.
    pub points: Vec<Point>,
    /// What each needs, as far as it follows from its size.
    pub needs: Vec<Needs>,
}

impl Sweep {
    /// Reads a plan and checks every point of it.
    ///
    /// # Errors
    /// [`SweepError`].
    pub fn read(path: &Path) -> Result<Sweep, SweepError> {
        let unreadable = |reason| SweepError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        let text = read_text(path, LARGEST_SCENE).map_err(unreadable)?;
        let plan = Plan::parse(&text, &path.display().to_string())?;
        let here = folder_of(path);
        // A preset's name is the preset, as everywhere.
        let (source, folder) = match preset(&plan.scene) {
            Some(_) => (PathBuf::from(&plan.scene), here),
            None => {
                let source = here.join(&plan.scene);
                let folder = folder_of(&source);
                // That a word was meant as a preset's name is told by the one who knows their names.
                let is_word = !plan.scene.contains(['/', '.']) && !source.exists();
                let source = if is_word {
                    PathBuf::from(&plan.scene)
                } else {
                    source
                };
                (source, folder)
            }
        };
        let overrides: Vec<String> = plan.set.iter().map(|set| set.argument()).collect();
        let loaded = load_scene(source.as_os_str(), &overrides);
        let LoadedScene { scene: base, .. } = loaded.map_err(|error| plan.scene_error(error))?;
        let origin = Origin {
            text: base.to_toml(),
            folders: vec![folder],
        };
        let (points, needs) = points(&plan, &origin)?;
        Ok(Sweep {
            title: plan.title(path),
            plan,
            base,
            origin,
            points,
            needs,
        })
    }

    /// The scene of a point.
    ///
    /// # Errors
    /// [`SweepError::Plan`]: a file that it needs has changed.
    pub fn scene(&self, point: &Point) -> Result<Scene, SweepError> {
        Ok(self.origin.scene(&point.assignments)?)
    }

    fn stored(&self, needs: Vec<Needs>) -> Stored {
        Stored {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            title: self.title.clone(),
            folders: self.origin.folders.clone(),
            keys: self.plan.varied_keys(),
            points: self.points.clone(),
            needs,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Stored {
    version: String,
    title: String,
    folders: Vec<PathBuf>,
    keys: Vec<String>,
    points: Vec<Point>,
    needs: Vec<Needs>,
}

/// Removes what killed processes have left half written. The folders of the points are cleaned by their runs.
fn clean_all(path: &Path) {
    for folder in [path, &path.join(BASE), &path.join(POINTS)] {
        clean(folder);
    }
}

/// How a point stands.
#[derive(Debug, Clone, PartialEq)]
pub enum PointState {
    /// Nothing of it is there.
    Waiting,
    /// Somebody works on it.
    Running(Holder),
    /// It was stopped, or killed, and can be resumed.
    Saved,
    /// It failed, and why.
    Failed(String),
    /// It reached its end, but what it left is not whole any more.
    Damaged(Damage),
    /// It reached its end.
    Done,
}

/// What is wrong with what a point has left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// Of a run that is done a table is not there.
    Missing(&'static str),
    /// Of a run that is done a table has no row of the last step.
    Short(&'static str),
    /// A file is in the place of the run's folder.
    NotAFolder,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Damage::Missing(table) => write!(f, "its {table} is missing"),
            Damage::Short(table) => write!(f, "its {table} has no row of its last step"),
            Damage::NotAFolder => f.write_str("a file is in the place of its folder"),
        }
    }
}

impl PointState {
    /// The words for all states.
    pub const WORDS: [&str; 6] = ["done", "running", "saved", "failed", "damaged", "waiting"];

    /// In a word.
    pub fn word(&self) -> &'static str {
        match self {
            PointState::Waiting => "waiting",
            PointState::Running(_) => "running",
            PointState::Saved => "saved",
            PointState::Failed(_) => "failed",
            PointState::Damaged(_) => "damaged",
            PointState::Done => "done",
        }
    }
}

/// A sweep that has its folder.
#[derive(Debug, Clone)]
pub struct SweepFolder {
    path: PathBuf,
    /// The plan.
    pub plan: Plan,
    stored: Stored,
    origin: Origin,
}

impl SweepFolder {
    /// Whether a folder holds a sweep.
    pub fn is_one(path: &Path) -> bool {
        path.join(SWEEP).is_file()
    }

    /// Begins a sweep in a folder. `needs` are those of each point.
    ///
    /// # Errors
    /// [`SweepError::Occupied`], or what cannot be written.
    pub fn create(path: &Path, sweep: &Sweep, needs: Vec<Needs>) -> Result<Self, SweepError> {
        let path = &std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        if Self::is_one(path) {
            let folder = path.clone();
            return Err(SweepError::Occupied { folder });
        }
        make_folder(&path.join(POINTS))?;
        make_folder(&path.join(BASE))?;
        clean_all(path);
        write_scene(&path.join(BASE), &sweep.base)?;
        let plan = path.join(PLAN);
        write_whole(&plan, |file| file.write_all(sweep.plan.text.as_bytes()))?;
        let stored = sweep.stored(needs);
        write_whole(&path.join(SWEEP), |file| {
            serde_json::to_writer_pretty(&mut *file, &stored)?;
            writeln!(file)
        })?;
        Self::open(path)
    }

    /// A new folder `parent/name`, or `parent/name-2`, …, for a sweep.
    ///
    /// # Errors
    /// [`SweepError::Record`].
    pub fn numbered(parent: &Path, name: &str) -> Result<PathBuf, SweepError> {
        Ok(RunFolder::numbered(parent, OsStr::new(name))?
            .path()
            .to_owned())
    }

    /// Opens the folder of a sweep.
    ///
    /// # Errors
    /// [`SweepError::NoSweep`], `Damaged`, or what cannot be read.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        if !Self::is_one(&path) {
            return Err(SweepError::NoSweep { folder: path });
        }
        let read = |file: &Path, largest| {
            read_file_text(file, largest).map_err(|reason| SweepError::Unreadable {
                path: file.to_owned(),
                reason,
            })
        };
        let file = path.join(SWEEP);
        let stored: Stored = serde_json::from_str(&read(&file, LARGEST)?)
            .map_err(|reason| SweepError::Damaged { path: file, reason })?;
        let file = path.join(PLAN);
        let plan = Plan::parse(&read(&file, LARGEST_SCENE)?, &file.display().to_string())?;
        let base = path.join(BASE);
        let text = read(&base.join("scene.toml"), LARGEST_SCENE)?;
        let folders = std::iter::once(base).chain(stored.folders.iter().cloned());
        let origin = Origin {
            text,
            folders: folders.collect(),
        };
        Ok(SweepFolder {
            path,
            plan,
            stored,
            origin,
        })
    }

    /// Opens the folder to continue a sweep.
    ///
    /// # Errors
    /// [`SweepError::Changed`] where its points are others, and those of [`SweepFolder::open`].
    pub fn resume(path: &Path, sweep: &Sweep) -> Result<Self, SweepError> {
        let folder = Self::open(path)?;
        let changed = |difference: String| SweepError::Changed {
            folder: folder.path.clone(),
            difference,
        };
        let (old, new) = (folder.points(), &sweep.points);
        for (old, new) in old.iter().zip(new) {
            if old.name != new.name {
                return Err(changed(format!("{} there, {} here", old.name, new.name)));
            }
        }
        if old.len() != new.len() {
            return Err(changed(format!("{} there, {} here", old.len(), new.len())));
        }
        clean_all(&folder.path);
        // A point that is done is not taken again: nobody else would find the lock that its killed owner has left.
        for point in folder.runs() {
            PointLock::clear_stale(&folder.lock(point));
        }
        Ok(folder)
    }

    /// Where it is, absolute.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The scene that is varied, complete, as TOML.
    pub fn scene_text(&self) -> &str {
        &self.origin.text
    }

    /// What the sweep is called.
    pub fn title(&self) -> &str {
        &self.stored.title
    }

    /// The keys that vary.
    pub fn keys(&self) -> &[String] {
        &self.stored.keys
    }

    /// All points.
    pub fn points(&self) -> &[Point] {
        &self.stored.points
    }

    /// The points that are run: those that are not the same as an earlier one.
    pub fn runs(&self) -> impl Iterator<Item = &Point> {
        let points = self.stored.points.iter();
        points.filter(|point| point.same_as.is_none())
    }

    /// What a point was predicted to take.
    pub fn needs(&self, point: &Point) -> Option<Needs> {
        self.stored.needs.get(point.number - 1).copied()
    }

    /// The point of a name, or of a number.
    ///
    /// # Errors
    /// [`SweepError::NoPoint`].
    pub fn point(&self, name: &str) -> Result<&Point, SweepError> {
        let number = name.parse::<usize>().ok();
        let mut points = self.points().iter();
        let found = points.find(|point| point.name == name || Some(point.number) == number);
        let name_of = |point: Option<&Point>| point.map_or_else(String::new, |it| it.name.clone());
        found.ok_or_else(|| SweepError::NoPoint {
            folder: self.path.clone(),
            name: name.to_owned(),
            points: self.points().len(),
            first: name_of(self.points().first()),
            last: name_of(self.points().last()),
        })
    }

    /// The scene of a point.
    ///
    /// # Errors
    /// [`SweepError::Changed`]: it is not the one that the point's name was made of.
    pub fn scene(&self, point: &Point) -> Result<Scene, SweepError> {
        let scene = self.origin.scene(&point.assignments)?;
        let name = name(point.number, &identity(&scene));
        if name != point.name {
            return Err(SweepError::Changed {
                folder: self.path.clone(),
                difference: format!("{} there, {name} here", point.name),
            });
        }
        Ok(scene)
    }

    /// The folder of a point's run; of one that is the same as an earlier point, that one's.
    pub fn run(&self, point: &Point) -> PathBuf {
        let number = point.same_as.unwrap_or(point.number);
        let name = self
            .points()
            .get(number - 1)
            .map_or(&point.name, |it| &it.name);
        self.path.join(POINTS).join(name)
    }

    /// The file of a point's lock.
    pub fn lock(&self, point: &Point) -> PathBuf {
        self.run(point).with_extension("lock")
    }

    /// Makes the folder of the points' runs, if it is not there any more.
    ///
    /// # Errors
    /// [`SweepError::NotAFolder`], or it cannot be made.
    pub fn make_points(&self) -> Result<(), SweepError> {
        let path = self.path.join(POINTS);
        self.check_folder(&path)?;
        Ok(make_folder(&path)?)
    }

    /// Refuses a file in the place of a folder.
    ///
    /// # Errors
    /// [`SweepError::NotAFolder`].
    pub fn check_folder(&self, path: &Path) -> Result<(), SweepError> {
        match path.exists() && !path.is_dir() {
            true => Err(SweepError::NotAFolder {
                path: path.to_owned(),
                folder: self.path.clone(),
            }),
            false => Ok(()),
        }
    }

    /// How a point stands by its folder alone, whether somebody works on it or not.
    pub fn recorded(&self, point: &Point) -> PointState {
        recorded_state(&self.run(point))
    }

    /// How a point stands.
    pub fn state(&self, point: &Point) -> PointState {
        let recorded = self.recorded(point);
        match recorded {
            PointState::Done => recorded,
            _ => match PointLock::holder(&self.lock(point)) {
                Some(holder) => PointState::Running(holder),
                None => recorded,
            },
        }
    }
}

/// How a run stands by its run.json, and of one that is done by its tables.
fn recorded_state(run: &Path) -> PointState {
    if !run.is_dir() {
        return match run.exists() {
            true => PointState::Damaged(Damage::NotAFolder),
            false => PointState::Waiting,
        };
    }
    #[derive(Deserialize)]
    struct Summary {
        status: Status,
        error: Option<String>,
        steps: Option<u64>,
    }
    let text = read_file_text(&run.join("run.json"), LARGEST).unwrap_or_default();
    match serde_json::from_str::<Summary>(&text) {
        Ok(Summary {
            status,
            error,
            steps,
        }) => match status {
            Status::Done => damage(run, steps).map_or(PointState::Done, PointState::Damaged),
            Status::Failed => PointState::Failed(error.unwrap_or_default()),
            Status::Running | Status::Interrupted => PointState::Saved,
        },
        // Killed before it had anything, or damaged: its checkpoint decides when it is run again.
        Err(_) if fs::read_dir(run).is_ok_and(|mut it| it.next().is_some()) => PointState::Saved,
        Err(_) => PointState::Waiting,
    }
}

/// The tables that the table of a sweep is made of.
const TABLES: [&str; 2] = ["history.csv", "shape.csv"];

/// Bytes at the end of a table that its last row is in.
const LONGEST_ROW: u64 = 1 << 13;

/// What is wrong with the tables of a run that ended after this number of steps. Only the end of a table is read, because every
/// point is looked at again and again.
fn damage(run: &Path, steps: Option<u64>) -> Option<Damage> {
    TABLES.into_iter().find_map(|table| {
        let path = run.join(table);
        if !path.is_file() {
            return Some(Damage::Missing(table));
        }
        // One that cannot be read now need not be damaged: the table of the sweep lacks its numbers.
        let last = last_step(&path).ok()?;
        let is_whole = last.is_some() && steps.is_none_or(|steps| last == Some(steps));
        (!is_whole).then_some(Damage::Short(table))
    })
}

/// The step of the last row of a table; `None`: it has no row.
fn last_step(table: &Path) -> io::Result<Option<u64>> {
    let mut file = fs::File::open(table)?;
    let size = file.metadata()?.len();
    file.seek(SeekFrom::Start(size.saturating_sub(LONGEST_ROW)))?;
    let mut end = Vec::new();
    file.take(LONGEST_ROW).read_to_end(&mut end)?;
    let end = String::from_utf8_lossy(&end);
    let row = end.trim_end().lines().next_back().unwrap_or_default();
    Ok(row.split(',').next().and_then(|step| step.parse().ok()))
}
