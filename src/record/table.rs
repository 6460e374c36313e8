//! A CSV file that grows during a run and yet always consists of whole lines.

use super::atomic::write_whole;
use super::table_repair::{Repaired, repair};
use super::{Number, RecordError};
use crc32fast::Hasher;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};

/// A growing table of numbers.
///
/// The file appears whole with its header, and what rows there are then. Lines are collected in memory
/// until [`Table::flush`] appends them; if an append fails half-way, the file is cut back to its last
/// whole line.
#[derive(Debug)]
pub(super) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    /// None before the first flush.
    file: Option<File>,
    /// Bytes of the file that are known to be whole lines.
    length: u64,
    /// Of the columns, how many the file does not have yet.
    late: usize,
    /// Whole lines that are not in the file yet.
    pending: String,
    /// Of the file and pending.
    rows: u64,
    /// Of the last row.
    last_step: Option<u64>,
    /// Of the bytes of the file.
    checksum: Hasher,
}

/// How far a table has come.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(super) struct Extent {
    pub columns: Vec<String>,
    pub rows: u64,
    /// The step of the last row.
    pub last_step: Option<u64>,
    /// CRC-32 of the file's bytes.
    pub checksum: u32,
}

/// A table that was found to go as far as it must, and may go further.
#[derive(Debug)]
pub(super) struct Found {
    path: PathBuf,
    extent: Extent,
    content: FoundContent,
}

#[derive(Debug)]
enum FoundContent {
    /// The first so many bytes are what was written.
    Whole { length: u64 },
    /// What was written can be had from it, or as much as there is.
    Repaired(Repaired),
    /// It is not there.
    Missing,
}

impl Table {
    /// A new table with a header and no rows. A file of that name is replaced with the first flush.
    pub fn new(path: PathBuf, columns: Vec<String>) -> Table {
        Table {
            path,
            columns,
            file: None,
            length: 0,
            late: 0,
            pending: String::new(),
            rows: 0,
            last_step: None,
            checksum: Hasher::new(),
        }
    }

    /// Looks whether a table goes as far as `extent`; changes nothing. One that another program has
    /// rewritten is read as what was meant.
    ///
    /// # Errors
    /// [`RecordError::Read`], [`RecordError::NoColumn`], [`RecordError::Short`].
    pub fn find(path: PathBuf, extent: &Extent) -> Result<Found, RecordError> {
        let content = match whole_length(&path, extent) {
            Ok(Some(length)) => FoundContent::Whole { length },
            Ok(None) => FoundContent::Repaired(repair(&path, extent)?),
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => FoundContent::Missing,
            Err(reason) => return Err(RecordError::Read { path, reason }),
        };
        Ok(Found {
            path,
            extent: extent.clone(),
            content,
        })
    }

    /// How far it has come. What was appended is to be flushed before.
    pub fn extent(&self) -> Extent {
        Extent {
            columns: self.columns.clone(),
            rows: self.rows,
            last_step: self.last_step,
            checksum: self.checksum.clone().finalize(),
        }
    }

    /// The header.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Adds columns at the right; they are empty in the rows so far. Nothing is written yet.
    pub fn add_columns(&mut self, names: Vec<String>) {
        if names.is_empty() {
            return;
        }
        if self.file.is_some() {
            self.late += names.len();
        }
        self.pending = widened(self.pending.lines(), names.len());
        self.columns.extend(names);
    }

    /// Appends a row, one cell a column, the first of which is the step; `None` is an empty cell. Nothing
    /// is written yet.
    pub fn append(&mut self, cells: impl IntoIterator<Item = Option<f64>>) {
        let mut count = 0;
        for cell in cells {
            if count == 0 {
                self.last_step = cell.map(|step| step as u64);
            }
            if count > 0 {
                self.pending.push(',');
            }
            if let Some(value) = cell {
                // Writing to a String cannot fail.
                let _ = write!(self.pending, "{}", Number(value));
            }
            count += 1;
        }
        debug_assert_eq!(count, self.columns.len(), "one cell a column");
        self.pending.push('\n');
        self.rows += 1;
    }

    /// Writes the rows that were appended since the last flush.
    ///
    /// # Errors
    /// [`RecordError::Vanished`] where the file is no longer under its name (a write would succeed
    /// and be lost): the next flush begins it anew. [`RecordError::Write`] otherwise. The rows that are
    /// not written yet are kept for another try.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        if self.file.is_none() {
            let text = self.columns.join(",") + "\n" + &self.pending;
            self.replace(&text)?;
            self.pending.clear();
            return Ok(());
        }
        if self.pending.is_empty() && self.late == 0 {
            return Ok(());
        }
        if !self.path.exists() {
            self.file = None;
            self.rows = self.pending.lines().count() as u64;
            return Err(RecordError::Vanished {
                path: self.path.clone(),
            });
        }
        if self.late > 0 {
            let text = fs::read_to_string(&self.path).map_err(|reason| RecordError::Read {
                path: self.path.clone(),
                reason,
            })?;
            let rows = widened(text.lines().skip(1), self.late);
            self.replace(&(self.columns.join(",") + "\n" + &rows))?;
        }
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        if let Err(reason) = file.write_all(self.pending.as_bytes()) {
            // As much of the last line as did get written goes; if even that fails, the error
            // below still tells.
            let _ = file.set_len(self.length);
            return Err(RecordError::write(&self.path)(reason));
        }
        self.length += self.pending.len() as u64;
        self.checksum.update(self.pending.as_bytes());
        self.pending.clear();
        Ok(())
    }

    /// Flushes, and waits until the disk has it all.
    ///
    /// # Errors
    /// Those of [`Table::flush`].
    pub fn finish(&mut self) -> Result<(), RecordError> {
        self.flush()?;
        match &self.file {
            Some(file) => file.sync_all().map_err(RecordError::write(&self.path)),
            None => Ok(()),
        }
    }

    /// Replaces the file by a text and opens it for appending.
    fn replace(&mut self, text: &str) -> Result<(), RecordError> {
        write_whole(&self.path, |file| file.write_all(text.as_bytes()))?;
        self.checksum = Hasher::new();
        self.checksum.update(text.as_bytes());
        self.open(text.len() as u64)
    }

    /// Opens the file, which has so many bytes, for appending.
    fn open(&mut self, length: u64) -> Result<(), RecordError> {
        let file = OpenOptions::new()
            .append(true)
            .open(&self.path)
            .map_err(RecordError::write(&self.path))?;
        self.file = Some(file);
        (self.length, self.late) = (length, 0);
        Ok(())
    }
}

impl Found {
    /// What is to be reported of it, in words.
    pub fn remarks(&self) -> Vec<String> {
        match &self.content {
            FoundContent::Whole { .. } => Vec::new(),
            FoundContent::Repaired(repaired) => repaired.remarks.clone(),
            FoundContent::Missing => vec![format!(
                "{} is gone, with {} rows: it begins anew",
                self.path.display(),
                self.extent.rows
            )],
        }
    }

    /// Cuts the table back to what is to stay, and goes on with it.
    ///
    /// # Errors
    /// [`RecordError`] where the file cannot be read or written.
    pub fn take_up(self) -> Result<Table, RecordError> {
        let Extent {
            columns,
            rows,
            last_step,
            checksum,
        } = self.extent;
        let mut table = Table::new(self.path, columns);
        table.last_step = last_step;
        match self.content {
            FoundContent::Whole { length } => {
                table.rows = rows;
                table.checksum = Hasher::new_with_initial_len(checksum, length);
                table.open(length)?;
                if let Some(file) = &table.file {
                    file.set_len(length)
                        .map_err(RecordError::write(&table.path))?;
                }
            }
            FoundContent::Repaired(repaired) => {
                table.rows = repaired.rows;
                table.replace(&repaired.text)?;
            }
            FoundContent::Missing => {}
        }
        Ok(table)
    }
}

/// The length of what was written, if the file begins with that, bit for bit.
fn whole_length(path: &Path, extent: &Extent) -> io::Result<Option<u64>> {
    // A pipe would wait for a writer.
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is no file"));
    }
    let mut file = BufReader::new(File::open(path)?);
    let (mut line, mut checksum, mut length) = (Vec::new(), Hasher::new(), 0);
    for _ in 0..=extent.rows {
        line.clear();
        length += file.read_until(b'\n', &mut line)? as u64;
        checksum.update(&line);
        if !line.ends_with(b"\n") {
            return Ok(None);
        }
    }
    Ok((checksum.finalize() == extent.checksum).then_some(length))
}

/// Lines with so many empty cells more.
fn widened<'a>(lines: impl Iterator<Item = &'a str>, cells: usize) -> String {
    let empty = ",".repeat(cells);
    lines.map(|line| format!("{line}{empty}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(folder: &Path) -> Table {
        let columns = ["step", "t"].map(str::to_owned).to_vec();
        let mut table = Table::new(folder.join("table.csv"), columns);
        table.flush().unwrap();
        table
    }

    #[test]
    fn grows_by_whole_lines_and_only_when_flushed() {
        let folder = tempfile::tempdir().unwrap();
        let mut table = table(folder.path());
        let text = |table: &Table| fs::read_to_string(&table.path).unwrap();
        assert_eq!(text(&table), "step,t\n");
        table.append([Some(0.0), Some(1e-7)]);
        table.append([Some(1.0), None]);
        assert_eq!(text(&table), "step,t\n");
        table.flush().unwrap();
        assert_eq!(text(&table), "step,t\n0,1e-7\n1,\n");
        table.append([None, Some(-2.5)]);
        table.finish().unwrap();
        assert_eq!(text(&table), "step,t\n0,1e-7\n1,\n,-2.5\n");
    }

    #[test]
    fn a_late_column_is_empty_before() {
        let folder = tempfile::tempdir().unwrap();
        let mut table = table(folder.path());
        table.append([Some(0.0), Some(0.0)]);
        table.flush().unwrap();
        table.append([Some(0.5), Some(0.25)]);
        table.add_columns(vec!["E_field".into(), "E_pull".into()]);
        table.append([Some(1.0), Some(0.5), Some(3.0), None]);
        table.flush().unwrap();
        assert_eq!(
            fs::read_to_string(&table.path).unwrap(),
            "step,t,E_field,E_pull\n0,0,,\n0.5,0.25,,\n1,0.5,3,\n"
        );
    }

    #[test]
    fn a_vanished_folder_is_an_error_with_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let mut table = table(folder.path());
        table.append([Some(0.0), Some(0.0)]);
        drop(folder);
        let error = table.flush().unwrap_err();
        assert!(matches!(&error, RecordError::Vanished { path } if *path == table.path));
        let error = table.flush().unwrap_err();
        assert!(matches!(&error, RecordError::Write { path, .. } if *path == table.path));
        // Whoever makes the folder again gets the rows that were not lost.
        fs::create_dir(table.path.parent().unwrap()).unwrap();
        table.append([Some(1.0), Some(0.5)]);
        table.flush().unwrap();
        let text = fs::read_to_string(&table.path).unwrap();
        assert_eq!(text, "step,t\n0,0\n1,0.5\n");
        fs::remove_dir_all(table.path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_table_is_taken_up_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = table(folder.path());
        first.append([Some(0.0), Some(0.0)]);
        first.append([Some(1.0), Some(0.5)]);
        let extent = first.extent();
        first.append([Some(2.0), Some(1.0)]);
        first.flush().unwrap();
        let path = first.path.clone();
        for late in [false, true] {
            if late {
                first.add_columns(vec!["late".into()]);
                first.append([Some(3.0), Some(1.5), Some(7.0)]);
                first.flush().unwrap();
            }
            let whole = fs::read_to_string(&path).unwrap();
            let found = Table::find(path.clone(), &extent).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), whole);
            let mut again = found.take_up().unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "step,t\n0,0\n1,0.5\n");
            again.append([Some(2.0), Some(1.0)]);
            again.flush().unwrap();
            let text = fs::read_to_string(&path).unwrap();
            assert_eq!(text, "step,t\n0,0\n1,0.5\n2,1\n");
            assert_eq!(again.extent().rows, 3);
            first = again;
        }
        let more = Extent {
            rows: 4,
            last_step: Some(3),
            ..extent
        };
        let error = Table::find(path.clone(), &more).unwrap_err();
        assert!(matches!(
            error,
            RecordError::Short {
                rows: 3,
                wanted: 4,
                ..
            }
        ));
        fs::write(&path, "step,t\n0,0\n1,0.").unwrap();
        let two = Extent {
            rows: 2,
            last_step: Some(1),
            ..more
        };
        assert!(Table::find(path.clone(), &two).is_err());
        let other = Extent {
            columns: vec!["step".into(), "x".into()],
            rows: 1,
            last_step: Some(0),
            checksum: 0,
        };
        assert!(Table::find(path, &other).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_and_the_rows_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut table = table(folder.path());
        let full = OpenOptions::new().append(true).open("/dev/full").unwrap();
        let good = table.file.replace(full);
        table.append([Some(0.0), Some(0.0)]);
        let error = table.flush().unwrap_err().to_string();
        assert!(error.contains("table.csv: No space left"), "{error}");
        table.file = good;
        table.flush().unwrap();
        assert_eq!(fs::read_to_string(&table.path).unwrap(), "step,t\n0,0\n");
    }
}
