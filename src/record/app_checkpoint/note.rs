//! What is reported of kept runs.

use crate::record::checkpoint::Problem;
use std::path::PathBuf;

/// What is reported of kept runs that were looked for.
#[derive(Debug, thiserror::Error)]
pub enum KeptNote {
    /// Another process computes it.
    #[error(
        "the run that is kept in {} is in use by another app: the run here is kept beside it",
        folder.display()
    )]
    InUse {
        /// Where it is kept.
        folder: PathBuf,
    },
    /// The newest state is damaged, and the one before is taken.
    #[error("{} cannot be used: {problem}; the state before it is taken{}", path.display(), put_aside(aside))]
    Older {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: Problem,
        /// Its new name, if it has one.
        aside: Option<PathBuf>,
    },
    /// Tables are not as the run left them.
    #[error("{}", remarks.join("\n"))]
    Tables {
        /// What is wrong with them.
        remarks: Vec<String>,
    },
    /// No state can be used.
    #[error(
        "the run that was kept in {} cannot be resumed ({}){}",
        folder.display(),
        problems.join("; "),
        put_aside(aside)
    )]
    Unusable {
        /// Where it was kept.
        folder: PathBuf,
        /// What is wrong with each state.
        problems: Vec<String>,
        /// The new name of the folder, if it has one.
        aside: Option<PathBuf>,
    },
    /// A recorded run has no state to resume from.
    #[error("{} has no checkpoint to resume from: the run starts from the beginning", folder.display())]
    NoCheckpoint {
        /// The run's folder.
        folder: PathBuf,
    },
    /// Of a run that was recorded the newest state is damaged, and the one before is taken.
    #[error("in {} the state before the newest is taken: {}", folder.display(), problems.join("; "))]
    RecordedOlder {
        /// The run's folder.
        folder: PathBuf,
        /// What is wrong with the newest.
        problems: Vec<String>,
    },
    /// A recorded run cannot be resumed.
    #[error("{} cannot be resumed, and the run starts from the beginning: {problem}", folder.display())]
    Recorded {
        /// The run's folder.
        folder: PathBuf,
        /// Why not, or what is wrong with a part of it.
        problem: String,
    },
}

fn put_aside(aside: &Option<PathBuf>) -> String {
    let words = |aside: &PathBuf| format!("; it is put aside as {}", aside.display());
    aside.as_ref().map_or_else(String::new, words)
}
