//! The two generations of a run's checkpoint on the disk.

use super::{Magic, Problem, RUN, decode, encode};
use crate::record::RecordError;
use crate::record::atomic::{write_keeping, write_whole};
use crate::record::folder::{NEWEST, OLDER};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Bytes of a checkpoint at most: about a hundred million nodal values.
const LARGEST: u64 = 1 << 30;

/// Writes checkpoints, keeping the one before.
#[derive(Debug)]
pub(in crate::record) struct Keeper {
    magic: Magic,
    newest: PathBuf,
    older: PathBuf,
    /// Whether what stands under the newest name is worth keeping.
    newest_is_good: bool,
    buffer: Vec<u8>,
}

impl Keeper {
    /// For the checkpoints in a run's folder. `newest_is_good`: what stands under the newest name, if
    /// anything does, can be used.
    pub fn of_run(folder: &Path, newest_is_good: bool) -> Keeper {
        let generations = [NEWEST, OLDER].map(|name| folder.join(name));
        Keeper::new(RUN, generations, newest_is_good)
    }

    /// For the checkpoints of these names, the newest first.
    pub fn new(magic: Magic, [newest, older]: [PathBuf; 2], newest_is_good: bool) -> Keeper {
        Keeper {
            magic,
            newest,
            older,
            newest_is_good,
            buffer: Vec::new(),
        }
    }

    /// Writes a checkpoint. The newest one becomes the one before, at the last moment.
    ///
    /// # Errors
    /// [`RecordError::Write`]; at least one generation stands as it was.
    pub fn write(&mut self, content: &impl Serialize) -> Result<(), RecordError> {
        let encoded = encode(self.magic, content, &mut self.buffer);
        encoded.map_err(|error| RecordError::Write {
            path: self.newest.clone(),
            reason: io::Error::other(error),
        })?;
        let content = |file: &mut dyn Write| file.write_all(&self.buffer);
        if self.newest_is_good {
            write_keeping(&self.newest, &self.older, content)?;
        } else {
            write_whole(&self.newest, content)?;
        }
        self.newest_is_good = true;
        Ok(())
    }

    /// The names of both generations, the newest first.
    pub fn names() -> [&'static str; 2] {
        [NEWEST, OLDER]
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`Problem`]: why it cannot be used.
    pub fn read<C: DeserializeOwned>(magic: Magic, path: &Path) -> Result<C, Problem> {
        decode(magic, &Keeper::bytes(path)?)
    }

    fn bytes(path: &Path) -> Result<Vec<u8>, Problem> {
        let unreadable = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => Problem::Missing,
            _ => Problem::Unreadable(error),
        };
        // A pipe would wait for a writer, and some devices have no end.
        let metadata = fs::metadata(path).map_err(unreadable)?;
        if !metadata.is_file() {
            return Err(Problem::NotACheckpoint);
        }
        let length = metadata.len();
        let file = File::open(path).map_err(unreadable)?;
        if length > LARGEST {
            return Err(Problem::TooLarge { bytes: length });
        }
        let mut bytes = Vec::new();
        file.take(LARGEST)
            .read_to_end(&mut bytes)
            .map_err(Problem::Unreadable)?;
        Ok(bytes)
    }
}
