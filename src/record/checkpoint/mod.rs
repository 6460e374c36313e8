//! Checkpoints: the state of a run in a file, from which it continues bit for bit.
//!
//! A checkpoint is a binary file:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `VESICACP`; of a run in the app `VESICAAP` |
//! | 4 | the version of the format, [`VERSION`] |
//! | 8 | n, the length of the content |
//! | n | the content: [`Content`] in postcard's format |
//! | 4 | CRC-32 of all before |
//!
//! (integers little-endian). There are two generations of it: the newest and the one before, which is
//! taken where the newest is damaged. Both are written whole, beside their place.

mod error;
mod store;

pub use error::{CheckpointError, Problem};
pub(super) use store::Keeper;

use super::history::TablesCheckpoint;
use super::mark::RunMark;
use super::summary::Totals;
use crate::simulation::SimulationCheckpoint;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// How a kind of file begins: eight bytes.
pub(super) type Magic = [u8; 8];

/// Of a run that is recorded.
pub(super) const RUN: Magic = *b"VESICACP";
/// Of a run in the app.
pub(super) const APP: Magic = *b"VESICAAP";

/// Raised whenever the content becomes another.
const VERSION: u32 = 7;

/// Magic, version, length.
const HEADER: usize = 8 + 4 + 8;
const CHECKSUM: usize = 4;

/// The content of a checkpoint.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Content {
    /// By which the scene is known: its complete text, but for the end.
    pub scene: String,
    /// The state of the simulation.
    pub simulation: SimulationCheckpoint,
    /// How far the tables have come.
    pub tables: TablesCheckpoint,
    /// What `run.json` sums up.
    pub totals: Totals,
    /// Steps from one row to the next.
    pub every: u64,
    /// How many snapshots were ordered.
    pub snapshots: u64,
    /// The time and the name of each snapshot so far.
    pub written: Vec<(f64, String)>,
}

impl Content {
    /// What curves of the run are marked with.
    pub fn marks(&self) -> Vec<RunMark> {
        let events = self.totals.events.iter();
        events.filter_map(RunMark::of_record).collect()
    }
}

/// Puts the bytes of a checkpoint in the place of what `bytes` holds.
///
/// # Errors
/// An error of the encoder; no cause of one is known.
pub(super) fn encode(
    magic: Magic,
    content: &impl Serialize,
    bytes: &mut Vec<u8>,
) -> Result<(), postcard::Error> {
    bytes.clear();
    bytes.extend_from_slice(&magic);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&[0; 8]);
    *bytes = postcard::to_extend(content, std::mem::take(bytes))?;
    let length = (bytes.len() - HEADER) as u64;
    bytes[HEADER - 8..HEADER].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32fast::hash(bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    Ok(())
}

/// The content of a checkpoint's bytes, whatever they are.
///
/// # Errors
/// [`Problem`]: what is wrong with them.
pub(super) fn decode<C: DeserializeOwned>(magic: Magic, bytes: &[u8]) -> Result<C, Problem> {
    let Some(rest) = bytes.strip_prefix(&magic) else {
        return Err(Problem::NotACheckpoint);
    };
    let cut_short = || Problem::CutShort { bytes: bytes.len() };
    let (version, rest) = rest.split_first_chunk::<4>().ok_or_else(cut_short)?;
    let version = u32::from_le_bytes(*version);
    let (length, rest) = rest.split_first_chunk::<8>().ok_or_else(cut_short)?;
    if (rest.len() as u64) < u64::from_le_bytes(*length).saturating_add(CHECKSUM as u64) {
        return Err(cut_short());
    }
    let Some((body, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else {
        return Err(cut_short());
    };
    if crc32fast::hash(body) != u32::from_le_bytes(*checksum) {
        return Err(Problem::Checksum);
    }
    // Only now: a damaged version is damage.
    if version != VERSION {
        return Err(Problem::Version { version });
    }
    postcard::from_bytes(&body[HEADER..]).map_err(Problem::Content)
}

#[cfg(test)]
mod tests;
