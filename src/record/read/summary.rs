//! `run.json`, read back: what of it a repetition of the run and its description need.

use super::super::bounded_read::read_file_text;
use super::super::folder::SUMMARY;
use super::super::provenance::{InputRecord, Session};
use super::super::summary::Status;
use super::super::{LARGEST_SUMMARY, Settings};
use super::ReadError;
use serde::Deserialize;
use std::path::Path;

/// What `run.json` says of a run. Runs of versions that did not record a part of it have defaults there.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct RecordedSummary {
    /// The scene's title.
    pub scene: String,
    /// How the run stands.
    pub status: Status,
    /// Why it failed.
    pub error: Option<String>,
    /// When it began.
    pub started: String,
    /// When it ended.
    pub ended: Option<String>,
    /// Steps done.
    pub steps: u64,
    /// Steps from one row to the next.
    #[serde(default = "default_every")]
    pub every: u64,
    /// Snapshots of the fields.
    #[serde(default = "default_snapshots")]
    pub snapshots: u64,
    /// The files that it is computed from.
    #[serde(default)]
    pub inputs: Vec<InputRecord>,
    /// The processes that computed it.
    #[serde(default)]
    pub sessions: Vec<Session>,
}

fn default_every() -> u64 {
    Settings::default().every
}

fn default_snapshots() -> u64 {
    Settings::default().snapshots
}

/// Reads the `run.json` of a run's folder.
///
/// # Errors
/// [`ReadError::NotARun`], [`ReadError::Unreadable`], [`ReadError::Json`].
pub fn read_summary(folder: &Path) -> Result<RecordedSummary, ReadError> {
    let path = folder.join(SUMMARY);
    if !path.exists() {
        return Err(ReadError::NotARun {
            folder: folder.to_owned(),
            missing: SUMMARY,
        });
    }
    let text = read_file_text(&path, LARGEST_SUMMARY).map_err(|reason| ReadError::Unreadable {
        path: path.clone(),
        reason,
    })?;
    serde_json::from_str(&text).map_err(|reason| ReadError::Json { path, reason })
}
