//! What can go wrong with a run's files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file or a folder of a run could not be had.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A file could not be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// A file could not be read back.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// A folder could not be made.
    #[error(
        "cannot make the folder {}: {}",
        path.display(),
        if reason.kind() == io::ErrorKind::AlreadyExists {
            "there is a file of this name".to_owned()
        } else {
            reason.to_string()
        }
    )]
    MakeFolder {
        /// The folder.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// A symbolic link leads nowhere.
    #[error(
        "{} is a symbolic link to {}, which is not there: make that folder, or remove the link",
        link.display(), target.display()
    )]
    DanglingLink {
        /// The link.
        link: PathBuf,
        /// Where it leads.
        target: PathBuf,
    },
    /// A file of an earlier run could not be removed.
    #[error("cannot remove {}: {reason}", path.display())]
    Remove {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// A folder could not be renamed.
    #[error("cannot rename {} to {}: {reason}", path.display(), to.display())]
    Rename {
        /// The folder.
        path: PathBuf,
        /// Its new name.
        to: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// The folder holds a run and nobody said that it may be replaced.
    #[error(
        "{} holds a run already (it has {found}): give another folder with --out, or --force to replace that run",
        folder.display()
    )]
    Occupied {
        /// The folder.
        folder: PathBuf,
        /// The first file of a run that was found in it.
        found: &'static str,
    },
    /// The folder should be replaced, but is not a run's.
    #[error(
        "{} holds {found} but no run.json, so it is not the folder of a run, and --force does not replace it: \
         give another folder with --out, or remove {found}",
        folder.display()
    )]
    NotARun {
        /// The folder.
        folder: PathBuf,
        /// The first file in it that a run would overwrite.
        found: &'static str,
    },
    /// A folder has the name of a file that must be written.
    #[error(
        "{} is a folder, and the run is to write a file of this name: rename that folder, or move it away",
        path.display()
    )]
    FolderInTheWay {
        /// The folder.
        path: PathBuf,
    },
    /// Another process writes to the folder.
    #[error(
        "another process is recording a run in {}: wait for it, or give another folder with --out",
        folder.display()
    )]
    InUse {
        /// The folder.
        folder: PathBuf,
    },
    /// A part of the record is lost.
    #[error("a part of the record is lost: {what}")]
    Lost {
        /// Where, and why.
        what: String,
    },
    /// A table was removed, or its folder, while the run went on.
    #[error("{} has vanished while the run was writing to it", path.display())]
    Vanished {
        /// The file.
        path: PathBuf,
    },
}

impl RecordError {
    /// For `map_err`: the folder at `path` could not be made.
    pub(super) fn make_folder(path: &Path) -> impl FnOnce(io::Error) -> RecordError + '_ {
        move |reason| {
            let dangling = path.ancestors().find_map(|link| {
                let target = fs::read_link(link).ok()?;
                (!link.exists()).then(|| (link.to_owned(), target))
            });
            match dangling {
                Some((link, target)) => RecordError::DanglingLink { link, target },
                None => RecordError::MakeFolder {
                    path: path.to_owned(),
                    reason,
                },
            }
        }
    }

    /// For `map_err`: the file at `path` could not be read.
    pub(super) fn read(path: &Path) -> impl FnOnce(io::Error) -> RecordError + '_ {
        move |reason| RecordError::Read {
            path: path.to_owned(),
            reason,
        }
    }

    /// For `map_err`: the file at `path` could not be written.
    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> RecordError + '_ {
        move |reason| RecordError::Write {
            path: path.to_owned(),
            reason,
        }
    }
}
