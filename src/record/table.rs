//! A CSV file that grows during a run and yet always consists of whole lines.

use super::atomic::{write_keeping, write_whole};
use super::bounded_read::{open_file, read_file_lossy, read_file_text};
use super::folder::free_numbered;
use super::number::push_cells;
use super::read::{LARGEST, parse_table};
use super::table_checks::Checks;
use super::table_repair::{Repaired, repair};
use super::{Columns, ReadError, RecordError};
use crc32fast::Hasher;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Write as _};
use std::path::{Path, PathBuf};

/// What a file is called, after its own name, that is kept as it was found.
const AS_FOUND: &str = ".as-found";
/// No line of a table has as many bytes.
const LONGEST_LINE: u64 = 1 << 20;

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
    /// Of the rows.
    checks: Checks,
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
    pub checks: Checks,
}

/// A table that was looked for: it goes as far as it must, or may go further, or is damaged.
#[derive(Debug)]
pub(super) struct Found {
    path: PathBuf,
    extent: Extent,
    content: FoundContent,
}

#[derive(Debug)]
enum FoundContent {
    /// The first `length` bytes are what was written.
    Whole { length: u64 },
    /// What was written can be recovered, or a part of it.
    Repaired(Repaired),
    /// Nothing can be recovered.
    Lost(Loss),
}

/// Why nothing can be recovered from a table.
#[derive(Debug)]
enum Loss {
    /// It is not there.
    Gone,
    /// It is empty.
    Empty,
    /// It cannot be read.
    Unreadable(io::Error),
    /// No line of it has the names of the columns.
    Headless,
}

/// The rows that a table has at some moment: they can be copied while it grows.
#[derive(Debug)]
pub(super) struct Rows {
    /// The file as it is open at that moment, and how much of it.
    file: Option<(File, u64)>,
    /// What follows.
    text: String,
}

impl Rows {
    /// Writes them as a table of their own.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn write(self, path: &Path) -> Result<(), RecordError> {
        write_whole(path, |to| {
            if let Some((file, length)) = self.file
                && io::copy(&mut file.take(length), to)? < length
            {
                let message = "the table that it is copied from was cut short";
                return Err(io::Error::new(io::ErrorKind::UnexpectedEof, message));
            }
            to.write_all(self.text.as_bytes())
        })
    }
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
            checks: Checks::default(),
        }
    }

    /// Checks whether a table goes as far as `extent`; changes nothing. One that another program has
    /// rewritten is read as what was meant, and of one that is damaged as much as there is.
    pub fn find(path: PathBuf, extent: &Extent) -> Found {
        let content = match whole_length(&path, extent) {
            Ok(Some(length)) => FoundContent::Whole { length },
            Ok(None) => match read_file_lossy(&path, LARGEST) {
                Ok(text) if text.trim().is_empty() => FoundContent::Lost(Loss::Empty),
                Ok(text) => repair(&path, &text, extent)
                    .map_or(FoundContent::Lost(Loss::Headless), FoundContent::Repaired),
                Err(reason) => FoundContent::Lost(Loss::Unreadable(reason)),
            },
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => {
                FoundContent::Lost(Loss::Gone)
            }
            Err(reason) => FoundContent::Lost(Loss::Unreadable(reason)),
        };
        Found {
            path,
            extent: extent.clone(),
            content,
        }
    }

    /// How far it has come. What was appended must be flushed before.
    pub fn extent(&self) -> Extent {
        Extent {
            columns: self.columns.clone(),
            rows: self.rows,
            last_step: self.last_step,
            checksum: self.checksum.clone().finalize(),
            checks: self.checks.clone(),
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
        let begin = self.pending.len();
        let mut cells = cells.into_iter().peekable();
        self.last_step = cells.peek().copied().flatten().map(|step| step as u64);
        push_cells(&mut self.pending, cells);
        let row = &self.pending[begin..];
        let count = row.split(',').count();
        debug_assert_eq!(count, self.columns.len(), "one cell a column");
        self.checks.add(self.rows, row);
        self.pending.push('\n');
        self.rows += 1;
    }

    /// Writes the rows that were appended since the last flush.
    ///
    /// # Errors
    /// [`RecordError::Vanished`] where the file is no longer under its name (a write would succeed
    /// and be lost): the next flush creates it again. [`RecordError::Write`] otherwise. The rows that are
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
            self.begin_anew();
            return Err(RecordError::Vanished {
                path: self.path.clone(),
            });
        }
        if self.late > 0 {
            let text =
                read_file_text(&self.path, LARGEST).map_err(RecordError::read(&self.path))?;
            let rows = widened(text.lines().skip(1), self.late);
            self.replace(&(self.columns.join(",") + "\n" + &rows))?;
        }
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        if let Err(reason) = file.write_all(self.pending.as_bytes()) {
            // As much of the last line as did get written goes; if even that fails, the error
            // below still reports it.
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

    /// Continues as a table in another folder, with the rows that are not in a file yet.
    pub fn move_to(&mut self, folder: &Path) {
        self.begin_anew();
        if let Some(name) = self.path.file_name() {
            self.path = folder.join(name);
        }
    }

    /// Leaves the file, if there is one: the rows that it has are not those of this table any more.
    fn begin_anew(&mut self) {
        self.file = None;
        (self.length, self.late) = (0, 0);
        self.rows = self.pending.lines().count() as u64;
        self.checks = Checks::of(self.pending.lines());
    }

    /// The rows up to now, those too that are in no file yet.
    ///
    /// # Errors
    /// [`RecordError`] where the file cannot be read, or must be rewritten for late columns and
    /// cannot.
    pub fn rows_now(&mut self) -> Result<Rows, RecordError> {
        if self.late > 0 {
            self.flush()?;
        }
        if self.file.is_none() {
            return Ok(Rows {
                file: None,
                text: self.columns.join(",") + "\n" + &self.pending,
            });
        }
        Ok(Rows {
            file: Some((self.open_for_reading()?, self.length)),
            text: self.pending.clone(),
        })
    }

    fn open_for_reading(&self) -> Result<File, RecordError> {
        open_file(&self.path).map_err(RecordError::read(&self.path))
    }

    /// Replaces the file by a text and opens it for appending.
    fn replace(&mut self, text: &str) -> Result<(), RecordError> {
        write_whole(&self.path, |file| file.write_all(text.as_bytes()))?;
        self.open_replaced(text)
    }

    /// Opens the file, which has just got this text, for appending.
    fn open_replaced(&mut self, text: &str) -> Result<(), RecordError> {
        self.checksum = Hasher::new();
        self.checksum.update(text.as_bytes());
        self.open(text.len() as u64)
    }

    /// Opens the file, which has `length` bytes, for appending.
    fn open(&mut self, length: u64) -> Result<(), RecordError> {
        self.file = Some(open_for_appending(&self.path)?);
        (self.length, self.late) = (length, 0);
        Ok(())
    }
}

impl Found {
    /// What is reported of it, in words.
    pub fn remarks(&self) -> Vec<String> {
        let (path, rows) = (self.path.display(), self.extent.rows);
        match &self.content {
            FoundContent::Whole { .. } => Vec::new(),
            FoundContent::Repaired(repaired) => repaired.remarks.clone(),
            FoundContent::Lost(loss) => vec![match loss {
                Loss::Gone => format!("{path} is gone, with {rows} rows: a new one begins"),
                Loss::Empty => format!("{path} is empty, and had {rows} rows: a new one begins"),
                Loss::Unreadable(reason) => {
                    format!(
                        "{path} cannot be read ({reason}), and had {rows} rows: a new one begins"
                    )
                }
                Loss::Headless => format!(
                    "{path} cannot be read (no line has the names of its columns), and had {rows} \
                     rows: a new one begins"
                ),
            }],
        }
    }

    /// Checks whether it can be written; changes nothing. Of a file that must be replaced the folder tells
    /// that.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn check(&self) -> Result<(), RecordError> {
        match &self.content {
            FoundContent::Whole { .. } => open_for_appending(&self.path).map(drop),
            FoundContent::Repaired(_) | FoundContent::Lost(_) => Ok(()),
        }
    }

    /// The name that the file gets when the run is resumed, if not all of its content goes into the table.
    fn kept_as(&self) -> Option<PathBuf> {
        let is_kept = match &self.content {
            FoundContent::Whole { .. } | FoundContent::Lost(Loss::Gone | Loss::Empty) => false,
            FoundContent::Repaired(repaired) => repaired.leaves_out,
            FoundContent::Lost(Loss::Unreadable(_) | Loss::Headless) => true,
        };
        let mut name = OsString::from(self.path.file_name()?);
        name.push(AS_FOUND);
        let parent = self.path.parent().unwrap_or(Path::new(""));
        is_kept.then(|| free_numbered(parent, &name))
    }

    /// What is reported where the run continues with it: as [`Found::remarks`], and where the file
    /// is kept that was found.
    pub fn remarks_of_take_up(&self) -> Vec<String> {
        let mut remarks = self.remarks();
        if let (Some(kept), Some(remark)) = (self.kept_as(), remarks.first_mut()) {
            *remark += &format!("; what was found is kept as {}", kept.display());
        }
        remarks
    }

    /// Cuts the table back to what must stay, and reopens it. What was found and is left out stays
    /// under another name.
    ///
    /// # Errors
    /// [`RecordError`] where the file cannot be read or written.
    pub fn reopen(self) -> Result<Table, RecordError> {
        let kept = self.kept_as();
        let Extent {
            columns,
            rows,
            last_step,
            checksum,
            checks,
        } = self.extent;
        let mut table = Table::new(self.path, columns);
        table.last_step = last_step;
        match self.content {
            FoundContent::Whole { length } => {
                (table.rows, table.checks) = (rows, checks);
                table.checksum = Hasher::new_with_initial_len(checksum, length);
                table.open(length)?;
                if let Some(file) = &table.file {
                    file.set_len(length)
                        .map_err(RecordError::write(&table.path))?;
                }
            }
            FoundContent::Repaired(repaired) => {
                table.rows = repaired.rows;
                table.checks = Checks::of(repaired.text.lines().skip(1));
                match kept {
                    Some(kept) => {
                        write_keeping(&table.path, &kept, |file| {
                            file.write_all(repaired.text.as_bytes())
                        })?;
                        table.open_replaced(&repaired.text)?;
                    }
                    None => table.replace(&repaired.text)?,
                }
            }
            FoundContent::Lost(_) => {
                if let Some(to) = kept {
                    fs::rename(&table.path, &to).map_err(|reason| RecordError::Rename {
                        path: table.path.clone(),
                        to,
                        reason,
                    })?;
                }
            }
        }
        Ok(table)
    }

    /// The rows that stay; changes nothing.
    ///
    /// # Errors
    /// [`RecordError::Read`].
    pub fn rows(&self) -> Result<Rows, RecordError> {
        let table = |text: String| Rows { file: None, text };
        Ok(match &self.content {
            FoundContent::Whole { length } => {
                let file = open_file(&self.path).map_err(RecordError::read(&self.path))?;
                Rows {
                    file: Some((file, *length)),
                    text: String::new(),
                }
            }
            FoundContent::Repaired(repaired) => table(repaired.text.clone()),
            FoundContent::Lost(_) => table(self.extent.columns.join(",") + "\n"),
        })
    }

    /// The scalars that stay; changes nothing.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn columns(&self) -> Result<Columns, ReadError> {
        let unreadable = |reason| ReadError::Unreadable {
            path: self.path.clone(),
            reason,
        };
        let text = match &self.content {
            FoundContent::Whole { length } => {
                let file = open_file(&self.path).map_err(unreadable)?;
                let mut text = String::new();
                let read = file.take(*length).read_to_string(&mut text);
                read.map_err(unreadable)?;
                text
            }
            FoundContent::Repaired(repaired) => repaired.text.clone(),
            FoundContent::Lost(_) => self.extent.columns.join(",") + "\n",
        };
        parse_table(&self.path, &text)
    }
}

fn open_for_appending(path: &Path) -> Result<File, RecordError> {
    OpenOptions::new()
        .append(true)
        .open(path)
        .map_err(RecordError::write(path))
}

/// The length of what was written, if the file begins with that, bit for bit, and has only later rows after
/// it.
fn whole_length(path: &Path, extent: &Extent) -> io::Result<Option<u64>> {
    let mut file = BufReader::new(open_file(path)?);
    let (mut line, mut checksum, mut length) = (Vec::new(), Hasher::new(), 0);
    let mut next = |line: &mut Vec<u8>| {
        line.clear();
        let bytes = (&mut file).take(LONGEST_LINE).read_until(b'\n', line)?;
        io::Result::Ok((bytes as u64, line.ends_with(b"\n")))
    };
    for _ in 0..=extent.rows {
        let (bytes, is_ended) = next(&mut line)?;
        if !is_ended {
            return Ok(None);
        }
        length += bytes;
        checksum.update(&line);
    }
    if checksum.finalize() != extent.checksum {
        return Ok(None);
    }
    // The last line may be cut.
    while next(&mut line)?.1 {
        if !is_later_row(&line, extent.last_step) {
            return Ok(None);
        }
    }
    Ok(Some(length))
}

/// Whether a line looks like one of a step that is not before another.
fn is_later_row(line: &[u8], step: Option<u64>) -> bool {
    let cell = line.split(|byte| *byte == b',').next();
    let cell = cell.and_then(|cell| str::from_utf8(cell).ok()?.parse().ok());
    cell.is_some_and(|later: u64| step.is_none_or(|step| later >= step))
}

/// Lines with more empty cells at their ends.
fn widened<'a>(lines: impl Iterator<Item = &'a str>, cells: usize) -> String {
    let empty = ",".repeat(cells);
    lines.map(|line| format!("{line}{empty}\n")).collect()
}

#[cfg(test)]
mod tests;
