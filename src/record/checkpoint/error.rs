//! Why a run cannot be resumed.

use super::VERSION;
use crate::record::RecordError;
use crate::simulation::RestoreError;
use std::io;
use std::path::PathBuf;

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// It is not there.
    #[error("it is not there")]
    Missing,
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(io::Error),
    /// It is longer than any checkpoint can be.
    #[error("it has {bytes} bytes, more than any checkpoint")]
    TooLarge {
        /// Its length.
        bytes: u64,
    },
    /// It does not begin as a checkpoint does.
    #[error("it is not a checkpoint of vesica")]
    NotACheckpoint,
    /// It is of another version.
    #[error(
        "its format is version {version}, and this vesica reads version {VERSION}: resume with the \
         vesica that wrote it"
    )]
    Version {
        /// Which.
        version: u32,
    },
    /// It ends too early.
    #[error("it is cut short, after {bytes} bytes")]
    CutShort {
        /// Its length.
        bytes: usize,
    },
    /// Its checksum does not fit.
    #[error("it is damaged: its checksum does not fit")]
    Checksum,
    /// Its checksum fits, but it cannot be read.
    #[error("it is damaged: {0}")]
    Content(postcard::Error),
    /// It is of another scene.
    #[error("it is of another scene: {0}")]
    Scene(String),
    /// The state does not fit the scene.
    #[error(transparent)]
    State(RestoreError),
}

/// Why a run cannot be resumed. Nothing was changed.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// There is a run but no checkpoint.
    #[error(
        "{} holds a run but no checkpoint, so it cannot be resumed: run the scene again, into \
         another folder or with --force",
        folder.display()
    )]
    None {
        /// The folder.
        folder: PathBuf,
    },
    /// The run is another scene's.
    #[error(
        "the run in {} is of another scene ({difference}): give the scene and the overrides that it \
         was begun with, or the folder itself in place of the scene",
        folder.display()
    )]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// A difference between the scenes.
        difference: String,
    },
    /// No checkpoint can be used.
    #[error(
        "the run in {} cannot be resumed:{}\nnothing was changed. To start again give another \
         folder with --out; --force in place of --resume would replace this run",
        folder.display(),
        problems.iter().map(|problem| format!("\n  {problem}")).collect::<String>()
    )]
    Unusable {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with each.
        problems: Vec<String>,
    },
    /// A file could not be had.
    #[error(transparent)]
    Record(#[from] RecordError),
}
