//! Files that appear whole or not at all.

use super::RecordError;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// How the name of a file begins and ends that is not whole yet.
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
    match std::fs::remove_file(before) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    std::fs::hard_link(path, before).or_else(|_| std::fs::rename(path, before))
}

/// Removes what killed processes have left behind in a folder; what cannot be removed stays.
pub(super) fn clean(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) {
            let _ = std::fs::remove_file(entry.path());
        }
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
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // As any other new file: what the user's umask allows. A temporary file is private.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut writer = BufWriter::with_capacity(1 << 16, builder.tempfile_in(folder)?);
    content(&mut writer)?;
    let file = writer.into_inner().map_err(|error| error.into_error())?;
    file.as_file().sync_all()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
