//! Files and folders that appear whole or not at all.

use super::RecordError;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// How the name of a file or a folder begins and ends that is not whole yet. Its writer holds a
/// lock on it.
const PREFIX: &str = ".vesica-";
const SUFFIX: &str = ".part";

/// Writes a file whole: beside its place, to the disk, and only then under its name.
///
/// A file that had the name is replaced. If anything fails, or the process is killed, what stood
/// under the name stands there still; a kill can leave a hidden file `.vesica-….part` behind.
///
/// # Errors
/// [`RecordError::Write`] with the path and the system's reason.
pub(crate) fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), RecordError> {
    write_beside(path, content)
        .and_then(|file| file.persist(path).map_err(|error| error.error))
        .map(|_| ())
        .map_err(RecordError::write(path))
}

/// As [`write_whole`], but what stood under the name is kept as `before`: at the last moment, when the new
/// file is on the disk.
///
/// # Errors
/// [`RecordError::Write`] with the path and the system's reason.
pub(super) fn write_keeping(
    path: &Path,
    before: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), RecordError> {
    write_beside(path, content)
        .and_then(|file| {
            keep(path, before)?;
            file.persist(path).map_err(|error| error.error)
        })
        .map(|_| ())
        .map_err(RecordError::write(path))
}

/// Gives what stands under a name, if anything does, a second one in place of what stood there. There is
/// no moment at which the first name is free, unless the disk knows no second names.
fn keep(path: &Path, before: &Path) -> io::Result<()> {
    if !path.exists() {
        return Ok(());
    }
    match fs::remove_file(before) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    fs::hard_link(path, before).or_else(|_| fs::rename(path, before))
}

/// Makes a folder in `parent` whose name says that it is not whole yet. The caller locks and fills it, and
/// then renames it.
///
/// # Errors
/// What the system says.
pub(super) fn folder_beside(parent: &Path) -> io::Result<PathBuf> {
    let mut builder = builder();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent).map(|folder| folder.keep())
}

/// A name for what stands for a moment only: [`clean`] removes what has it.
pub(crate) fn unfinished_name(name: &str) -> String {
    format!("{PREFIX}{name}{SUFFIX}")
}

/// What a process that was killed had left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leftover {
    /// The file or the folder.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
}

/// Removes what killed processes have left behind in a folder, and says what that was. What a process
/// that lives is writing stays, and what cannot be removed.
pub(crate) fn clean(folder: &Path) -> Vec<Leftover> {
    let mut removed = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let name = name.to_string_lossy();
        // A link leads to what is not ours.
        let Ok(metadata) = fs::symlink_metadata(&path) else {
            continue;
        };
        let is_ours = name.starts_with(PREFIX) && name.ends_with(SUFFIX) && !metadata.is_symlink();
        if !is_ours || !(metadata.is_file() || metadata.is_dir()) {
            continue;
        }
        let Ok(file) = File::open(&path) else {
            continue;
        };
        if file.try_lock().is_err() {
            continue;
        }
        let bytes = size(&path);
        let outcome = match metadata.is_dir() {
            true => fs::remove_dir_all(&path),
            false => fs::remove_file(&path),
        };
        if outcome.is_ok() {
            removed.push(Leftover { path, bytes });
        }
    }
    removed
}

/// The bytes of a file, or of all files in a folder and below.
pub(crate) fn size(path: &Path) -> u64 {
    match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_dir() => {
            let entries = fs::read_dir(path).into_iter().flatten().flatten();
            entries.map(|entry| size(&entry.path())).sum()
        }
        Ok(metadata) => metadata.len(),
        Err(_) => 0,
    }
}

/// As [`write_whole`], but never replaces a file: not even one that another program made a moment
/// ago.
///
/// # Errors
/// [`RecordError::Write`] with the path and the system's reason, such as that it exists.
pub(crate) fn write_new(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), RecordError> {
    write_beside(path, content)
        .and_then(|file| file.persist_noclobber(path).map_err(|error| error.error))
        .map(|_| ())
        .map_err(RecordError::write(path))
}

/// Tries whether a file could be written with [`write_whole`]; leaves nothing.
///
/// # Errors
/// [`RecordError::Write`] with the path and the system's reason.
pub(crate) fn try_to_write(path: &Path) -> Result<(), RecordError> {
    if path.is_dir() {
        return Err(RecordError::write(path)(io::ErrorKind::IsADirectory.into()));
    }
    let tried = write_beside(path, |_| Ok(()));
    tried.map(drop).map_err(RecordError::write(path))
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    builder
}

/// Writes a file beside its place, and to the disk.
fn write_beside(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<NamedTempFile> {
    // A name without a folder in front of it has the empty path as its parent.
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = builder();
    #[cfg(unix)]
    {
        // As any other new file: what the user's umask allows. A temporary file is private.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    // It is a leftover once this process has ended. Where the system has no locks nobody removes it.
    let _ = file.as_file().try_lock();
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    content(&mut writer)?;
    let file = writer.into_inner().map_err(|error| error.into_error())?;
    file.as_file().sync_all()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["first", "2"] {
            write_whole(&path, |file| file.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failure_half_way_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, |file| file.write_all(b"whole")).unwrap();
        let error = write_whole(&path, |file| {
            file.write_all(&[b'x'; 1 << 20])?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        })
        .unwrap_err();
        assert!(error.to_string().contains("a.txt"), "{error}");
        assert!(error.to_string().contains("no storage space"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_was_there_is_kept_only_when_the_new_one_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (path, before) = (folder.path().join("a"), folder.path().join("b"));
        for text in ["1", "2", "3"] {
            write_keeping(&path, &before, |file| file.write_all(text.as_bytes())).unwrap();
        }
        write_keeping(&path, &before, |_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "3");
        assert_eq!(fs::read_to_string(&before).unwrap(), "2");
        fs::write(folder.path().join(".vesica-x.part"), "").unwrap();
        clean(folder.path());
        assert_eq!(names(folder.path()), ["a", "b"]);
    }

    #[test]
    fn leftovers_of_the_dead_go_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let dead = folder_beside(folder.path()).unwrap();
        fs::create_dir(dead.join("fields")).unwrap();
        fs::write(dead.join("fields/a.vtu"), [0; 1000]).unwrap();
        let living = folder_beside(folder.path()).unwrap();
        let lock = File::open(&living).unwrap();
        lock.try_lock().unwrap();
        fs::write(folder.path().join("notes.part"), "mine").unwrap();
        let path = folder.path().join("a");
        write_whole(&path, |_| {
            let removed = clean(folder.path());
            let expected = Leftover {
                path: dead.clone(),
                bytes: 1000,
            };
            assert_eq!(removed, [expected]);
            Ok(())
        })
        .unwrap();
        let living = living.file_name().unwrap().to_str().unwrap();
        assert_eq!(names(folder.path()), [living, "a", "notes.part"]);
    }

    #[test]
    fn what_is_there_is_not_replaced_by_what_is_new() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_new(&path, |file| file.write_all(b"first")).unwrap();
        let error = write_new(&path, |file| file.write_all(b"second")).unwrap_err();
        assert!(error.to_string().contains("exists"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_cannot_be_written_is_found_out_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        try_to_write(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        try_to_write(&path.join("b")).unwrap_err();
        fs::create_dir(&path).unwrap();
        let error = try_to_write(&path).unwrap_err().to_string();
        assert!(error.contains("directory"), "{error}");
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error_with_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gone/a.txt");
        let error = write_whole(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(error.starts_with("cannot write "), "{error}");
        assert!(error.contains("gone/a.txt"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_it_as_far_as_the_umask_allows() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("a"), folder.path().join("b"));
        write_whole(&ours, |_| Ok(())).unwrap();
        fs::write(&plain, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(ours), mode(plain));
    }
}
