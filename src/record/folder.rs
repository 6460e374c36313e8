//! The folder of a run.

use super::RecordError;
use super::atomic::{clean, folder_beside, try_to_write, write_whole};
use super::scene_file::{INPUTS, MESH_NAME};
use crate::scene::NodalKey;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folder, within a run's, of snapshots.
pub(super) const FIELDS: &str = "fields";
/// The list of snapshots, within that folder.
pub(super) const SERIES: &str = "fields.pvd";

/// The fields at the end.
pub(super) const FINAL: &str = "final.vtu";

/// What the run was measured to miss, if that was asked for.
const MEASURED_ERROR: &str = "measured-error.csv";

/// The newest checkpoint, and the one before.
pub(super) const NEWEST: &str = "checkpoint.bin";
pub(super) const OLDER: &str = "checkpoint-older.bin";

/// The file that marks a run's folder.
pub(super) const SUMMARY: &str = "run.json";

/// The scene, complete.
pub(super) const SCENE: &str = "scene.toml";

/// The files of a run beside those in folders; where one of them stands, no run is put.
const FILES: [&str; 9] = [
    SUMMARY,
    SCENE,
    "history.csv",
    "ledger.csv",
    "shape.csv",
    MEASURED_ERROR,
    FINAL,
    NEWEST,
    OLDER,
];

/// What to do with a folder that holds a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IfOccupied {
    /// Leave it alone.
    Refuse,
    /// Remove that run's files, and no others.
    Replace,
}

/// Where what a run has written stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Whereabouts {
    path: PathBuf,
    is_there: bool,
    moved_to: Option<PathBuf>,
}

impl fmt::Display for Whereabouts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        match (self.is_there, &self.moved_to) {
            (true, _) => write!(f, "what there is stands in {path}"),
            (false, Some(moved_to)) => write!(
                f,
                "the folder {path} was moved while the run went on: what was written until then stands in {}",
                moved_to.display()
            ),
            (false, None) => write!(
                f,
                "the folder {path} is not there any more: it was removed or moved while the run went on"
            ),
        }
    }
}

/// A folder that a run may write to, and no other process as long as this one holds it.
#[derive(Debug, Clone)]
pub struct RunFolder {
    path: PathBuf,
    /// Locked until the last copy is dropped.
    lock: Option<Arc<File>>,
}

impl RunFolder {
    /// The folder `path`, made if it is not there. It may hold other files.
    ///
    /// # Errors
    /// [`RecordError::Occupied`] if it holds a run and is not to be replaced;
    /// [`RecordError::NotARun`] if it must be replaced, but what it holds may be a user's own, such
    /// as a scene with comments; otherwise what could not be made or removed.
    pub fn at(path: &Path, if_occupied: IfOccupied) -> Result<RunFolder, RecordError> {
        make(path)?;
        let lock = lock(path)?;
        for folder in [path, &path.join(FIELDS)] {
            clean(folder);
        }
        let found = a_file_of(path);
        match (found, if_occupied) {
            (None, _) => {}
            (Some(found), IfOccupied::Refuse) => {
                return Err(RecordError::Occupied {
                    folder: path.to_owned(),
                    found,
                });
            }
            (Some(found), IfOccupied::Replace) if !path.join(SUMMARY).exists() => {
                return Err(RecordError::NotARun {
                    folder: path.to_owned(),
                    found,
                });
            }
            (Some(_), IfOccupied::Replace) => clear(path)?,
        }
        Ok(RunFolder {
            path: path.to_owned(),
            lock,
        })
    }

    /// The folder of a run that is there.
    ///
    /// # Errors
    /// [`RecordError::InUse`].
    pub(super) fn of_run(path: &Path) -> Result<RunFolder, RecordError> {
        Ok(RunFolder {
            path: path.to_owned(),
            lock: lock(path)?,
        })
    }

    /// Whether a process holds it at present: it records a run there, or resumes the one that it holds.
    pub fn is_in_use(path: &Path) -> bool {
        matches!(lock(path), Err(RecordError::InUse { .. }))
    }

    /// A new folder `parent/name`, or if that is there, `parent/name-2`, `parent/name-3`, ….
    ///
    /// The first that can be made is taken, so that runs started at the same moment do not meet.
    ///
    /// # Errors
    /// [`RecordError::MakeFolder`].
    pub fn numbered(parent: &Path, name: &OsStr) -> Result<RunFolder, RecordError> {
        make(parent)?;
        let mut path = parent.join(name);
        let mut number = 1_u64;
        loop {
            match fs::create_dir(&path) {
                Ok(()) => match RunFolder::of_run(&path) {
                    // Someone was faster, and checks whether it is a run's.
                    Err(RecordError::InUse { .. }) => {}
                    folder => return folder,
                },
                Err(reason) if reason.kind() == io::ErrorKind::AlreadyExists => {}
                Err(reason) => return Err(RecordError::make_folder(&path)(reason)),
            }
            number += 1;
            path = parent.join(numbered(name, number));
        }
    }

    /// A new folder in `parent` that is not whole yet, as its name says: [`RunFolder::publish`] gives it
    /// another. Of a process that was killed it is a leftover.
    ///
    /// # Errors
    /// [`RecordError::MakeFolder`].
    pub(crate) fn unpublished(parent: &Path) -> Result<RunFolder, RecordError> {
        make(parent)?;
        let path = folder_beside(parent).map_err(|reason| RecordError::MakeFolder {
            path: parent.to_owned(),
            reason,
        })?;
        RunFolder::of_run(&path)
    }

    /// Renames it, within the folder that it is in, to `name`, or if that is there to `name-2`,
    /// `name-3`, ….
    ///
    /// # Errors
    /// [`RecordError::Rename`]; it stands where it was.
    pub(crate) fn publish(mut self, name: &OsStr) -> Result<RunFolder, RecordError> {
        let parent = self.path.parent().unwrap_or(Path::new(""));
        self.path = rename_numbered(&self.path, parent, name, 1)?;
        Ok(self)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is still where it was, in words for a user who looks for its files.
    pub fn whereabouts(&self) -> Whereabouts {
        let here = fs::canonicalize(&self.path).ok();
        let now = self.moved_to();
        let moved_to = now.filter(|now| here.as_ref() != Some(now));
        Whereabouts {
            path: self.path.clone(),
            is_there: here.is_some() && moved_to.is_none(),
            moved_to,
        }
    }

    /// Where the system says that the folder is now; known on Linux only, and not where it was removed.
    fn moved_to(&self) -> Option<PathBuf> {
        #[cfg(target_os = "linux")]
        {
            use std::os::fd::AsRawFd;
            let descriptor = self.lock.as_ref()?.as_raw_fd();
            let path = fs::read_link(format!("/proc/self/fd/{descriptor}")).ok()?;
            path.is_dir().then_some(path)
        }
        #[cfg(not(target_os = "linux"))]
        None
    }

    /// Makes the folder of snapshots.
    pub(super) fn make_fields(&self) -> Result<PathBuf, RecordError> {
        let path = self.path.join(FIELDS);
        // Not the folder that it is in: if that has been removed, someone did not want it.
        match fs::create_dir(&path) {
            Err(reason) if !path.is_dir() => Err(RecordError::make_folder(&path)(reason)),
            _ => Ok(path),
        }
    }
}

/// Writes the table of the measured errors of a run into its folder; gives the file's name.
///
/// # Errors
/// [`RecordError::Write`].
pub fn write_error_table(folder: &Path, table: &str) -> Result<&'static str, RecordError> {
    write_whole(&folder.join(MEASURED_ERROR), |file| {
        file.write_all(table.as_bytes())
    })?;
    Ok(MEASURED_ERROR)
}

/// The name of the folder of a number: that of 1 has none.
fn numbered(name: &OsStr, number: u64) -> OsString {
    let mut numbered = name.to_owned();
    if number > 1 {
        numbered.push(format!("-{number}"));
    }
    numbered
}

/// The number of the folder `name` (1) or `name-2`, `name-3`, …; none for others.
pub(super) fn number(folder: &OsStr, name: &OsStr) -> Option<u64> {
    if folder == name {
        return Some(1);
    }
    let (folder, name) = (folder.to_str()?, name.to_str()?);
    let number = folder.strip_prefix(name)?.strip_prefix('-')?;
    number.parse().ok().filter(|number| *number > 1)
}

/// The folders `parent/name`, `parent/name-2`, …, as far as they are there, in this order.
pub(super) fn all_numbered(parent: &Path, name: &OsStr) -> Vec<PathBuf> {
    let mut folders: Vec<(u64, PathBuf)> = fs::read_dir(parent)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| Some((number(&entry.file_name(), name)?, entry.path())))
        .filter(|(_, path)| path.is_dir())
        .collect();
    folders.sort();
    folders.into_iter().map(|(_, path)| path).collect()
}

/// The first of `parent/name`, `parent/name-2`, … that is free.
pub(super) fn free_numbered(parent: &Path, name: &OsStr) -> PathBuf {
    let mut number = 1;
    loop {
        let path = parent.join(numbered(name, number));
        if path.symlink_metadata().is_err() {
            return path;
        }
        number += 1;
    }
}

/// Renames a folder to the first of `parent/name`, `parent/name-2`, … that is free, from a number on.
///
/// # Errors
/// [`RecordError::Rename`].
pub(super) fn rename_numbered(
    path: &Path,
    parent: &Path,
    name: &OsStr,
    first: u64,
) -> Result<PathBuf, RecordError> {
    let mut number = first;
    loop {
        let to = parent.join(numbered(name, number));
        number += 1;
        if to.symlink_metadata().is_ok() {
            continue;
        }
        match fs::rename(path, &to) {
            Ok(()) => return Ok(to),
            // Someone was faster.
            Err(reason)
                if [
                    io::ErrorKind::DirectoryNotEmpty,
                    io::ErrorKind::AlreadyExists,
                    io::ErrorKind::NotADirectory,
                ]
                .contains(&reason.kind())
                    && to.symlink_metadata().is_ok() => {}
            Err(reason) => {
                return Err(RecordError::Rename {
                    path: path.to_owned(),
                    to,
                    reason,
                });
            }
        }
    }
}

/// A file of a run in this folder, if there is one.
pub(super) fn a_file_of(folder: &Path) -> Option<&'static str> {
    FILES.into_iter().find(|file| folder.join(file).exists())
}

/// Locks a folder, where the system can: two processes must not record into it.
fn lock(folder: &Path) -> Result<Option<Arc<File>>, RecordError> {
    // A pipe would wait for a writer.
    let Some(file) = folder.is_dir().then(|| File::open(folder).ok()).flatten() else {
        return Ok(None);
    };
    match file.try_lock() {
        Ok(()) => Ok(Some(Arc::new(file))),
        Err(TryLockError::WouldBlock) => Err(RecordError::InUse {
            folder: folder.to_owned(),
        }),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Makes a folder, and those that it is in, if they are not there.
///
/// # Errors
/// [`RecordError::MakeFolder`], [`RecordError::DanglingLink`].
pub(crate) fn make(path: &Path) -> Result<(), RecordError> {
    fs::create_dir_all(path).map_err(RecordError::make_folder(path))
}

/// Removes the files of a run, file by file: what a user put beside them stays.
pub(crate) fn clear(folder: &Path) -> Result<(), RecordError> {
    for file in FILES {
        remove(&folder.join(file))?;
    }
    let inputs = folder.join(INPUTS);
    for file in input_names() {
        remove(&inputs.join(file))?;
    }
    let fields = folder.join(FIELDS);
    remove(&fields.join(SERIES))?;
    remove_snapshots(folder, |_| true)?;
    // They stay if they hold anything else.
    let _ = fs::remove_dir(inputs);
    let _ = fs::remove_dir(fields);
    Ok(())
}

/// Removes the snapshots of the steps that `which` names, and those whose name has no step.
pub(super) fn remove_snapshots(
    folder: &Path,
    which: impl Fn(u64) -> bool,
) -> Result<(), RecordError> {
    snapshots(folder, which).try_for_each(|path| remove(&path))
}

/// Where the snapshots are of the steps that `which` names, and those whose name has no step.
fn snapshots(folder: &Path, which: impl Fn(u64) -> bool) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(folder.join(FIELDS));
    entries
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(move |entry| {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            let step = name.strip_prefix("step-")?.strip_suffix(".vtu")?;
            step.parse().map_or(true, &which).then(|| entry.path())
        })
}

/// Checks whether the files of a run can be written into its folder, where a run continues from a step;
/// changes nothing. The tables, which are read first, are not looked at.
///
/// # Errors
/// [`RecordError`]: what is in the way.
pub(super) fn check_writable(folder: &Path, step: u64) -> Result<(), RecordError> {
    let files = [SUMMARY, SCENE, FINAL, NEWEST, OLDER].map(|file| folder.join(file));
    let inputs = input_names().map(|file| folder.join(INPUTS).join(file));
    let fields = folder.join(FIELDS);
    let in_the_way = files
        .into_iter()
        .chain(inputs)
        .chain([fields.join(SERIES)])
        .chain(snapshots(folder, |snapshot| snapshot > step))
        .find(|path| path.is_dir());
    if let Some(path) = in_the_way {
        return Err(RecordError::FolderInTheWay { path });
    }
    try_to_write(&folder.join(SUMMARY))?;
    match fields.symlink_metadata() {
        Ok(_) => try_to_write(&fields.join(SERIES)),
        Err(_) => Ok(()),
    }
}

/// Where a run's scene may have files, relative to its folder: the scene, and the inputs beside it.
pub(super) fn scene_files() -> impl Iterator<Item = String> {
    let inputs = input_names().map(|name| format!("{INPUTS}/{name}"));
    std::iter::once(SCENE.to_owned()).chain(inputs)
}

/// The files of the run in a folder that others can read, relative to the folder, and of each whether it is an input.
/// Checkpoints are not among them: only the version that wrote them reads them.
pub(crate) fn files_of_run(folder: &Path) -> Vec<(String, bool)> {
    let inputs: Vec<String> = scene_files().collect();
    let records = FILES.into_iter().map(str::to_owned);
    let records = records.filter(|file| ![SCENE, NEWEST, OLDER].contains(&file.as_str()));
    let mut fields: Vec<String> = snapshots(folder, |_| true)
        .filter_map(|path| Some(format!("{FIELDS}/{}", path.file_name()?.to_str()?)))
        .collect();
    fields.sort();
    fields.push(format!("{FIELDS}/{SERIES}"));
    let inputs = inputs.into_iter().map(|file| (file, true));
    let records = records.chain(fields).map(|file| (file, false));
    let is_there = |(file, _): &(String, bool)| folder.join(file).is_file();
    inputs.chain(records).filter(is_there).collect()
}

fn input_names() -> impl Iterator<Item = &'static str> {
    let values = NodalKey::all().into_iter().map(|key| key.file_name);
    values.chain([MESH_NAME])
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), RecordError> {
    match fs::remove_file(path) {
        Err(reason) if reason.kind() != io::ErrorKind::NotFound => Err(RecordError::Remove {
            path: path.to_owned(),
            reason,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_folders_are_numbered_from_two() {
        let parent = tempfile::tempdir().unwrap();
        let runs = parent.path().join("runs");
        for expected in ["case3", "case3-2", "case3-3"] {
            let folder = RunFolder::numbered(&runs, OsStr::new("case3")).unwrap();
            assert_eq!(folder.path(), runs.join(expected));
        }
        fs::remove_dir(runs.join("case3-2")).unwrap();
        let folder = RunFolder::numbered(&runs, OsStr::new("case3")).unwrap();
        assert_eq!(folder.path(), runs.join("case3-2"));
    }

    #[test]
    fn the_numbers_of_folders() {
        let number = |folder| number(OsStr::new(folder), OsStr::new("case3"));
        assert_eq!(number("case3"), Some(1));
        assert_eq!(number("case3-2"), Some(2));
        for other in ["case3-1", "case3-x", "case32", "case3-", "case"] {
            assert_eq!(number(other), None, "{other}");
        }
    }

    #[test]
    fn a_folder_gets_its_name_when_it_is_whole() {
        let parent = tempfile::tempdir().unwrap();
        for expected in ["set", "set-2"] {
            let folder = RunFolder::unpublished(parent.path()).unwrap();
            fs::write(folder.path().join("a"), "").unwrap();
            assert!(!parent.path().join(expected).exists());
            let folder = folder.publish(OsStr::new("set")).unwrap();
            assert_eq!(folder.path(), parent.path().join(expected));
            assert!(folder.path().join("a").is_file());
        }
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 2);
    }

    #[test]
    fn any_file_of_a_run_keeps_another_out() {
        for file in FILES {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path();
            fs::write(path.join("notes.txt"), "mine").unwrap();
            RunFolder::at(path, IfOccupied::Refuse).unwrap();
            fs::write(path.join(file), "theirs").unwrap();
            let error = RunFolder::at(path, IfOccupied::Refuse).unwrap_err();
            assert!(matches!(error, RecordError::Occupied { found, .. } if found == file));
            assert!(error.to_string().contains("--force"), "{error}");
            let replaced = RunFolder::at(path, IfOccupied::Replace);
            assert_eq!(replaced.is_ok(), file == SUMMARY);
            assert_eq!(path.join(file).exists(), file != SUMMARY);
        }
    }

    #[test]
    fn replacing_removes_the_run_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let theirs = [
            "run.json",
            "fields/step-0000003.vtu",
            "fields/fields.pvd",
            "inputs/director.txt",
        ];
        let mine = ["notes.txt", "fields/notes.txt", "fields/my.vtu"];
        fs::create_dir(path.join("fields")).unwrap();
        fs::create_dir(path.join("inputs")).unwrap();
        for file in theirs.iter().chain(&mine) {
            fs::write(path.join(file), "").unwrap();
        }
        RunFolder::at(path, IfOccupied::Replace).unwrap();
        assert!(theirs.iter().all(|file| !path.join(file).exists()));
        assert!(mine.iter().all(|file| path.join(file).exists()));
        assert!(!path.join("inputs").exists());
    }

    #[test]
    fn a_folder_has_one_run_at_a_time() {
        let parent = tempfile::tempdir().unwrap();
        let first = RunFolder::at(parent.path(), IfOccupied::Refuse).unwrap();
        let copy = first.clone();
        drop(first);
        for choice in [IfOccupied::Refuse, IfOccupied::Replace] {
            let error = RunFolder::at(parent.path(), choice).unwrap_err();
            assert!(matches!(error, RecordError::InUse { .. }), "{error}");
        }
        drop(copy);
        RunFolder::at(parent.path(), IfOccupied::Refuse).unwrap();
    }

    #[test]
    fn a_file_in_the_way_is_an_error_with_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "").unwrap();
        let error = RunFolder::at(&path, IfOccupied::Replace).unwrap_err();
        assert!(matches!(error, RecordError::MakeFolder { .. }), "{error}");
        assert!(error.to_string().contains(path.to_str().unwrap()));
        assert!(path.is_file());
    }
}
