//! A CSV file that grows during a run and yet always consists of whole lines.

use super::atomic::write_whole;
use super::{Number, RecordError};
use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A growing table of numbers.
///
/// The file appears whole with its header. Lines are collected in memory until [`Table::flush`]
/// appends them; if an append fails half-way, the file is cut back to its last whole line.
#[derive(Debug)]
pub(super) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    file: File,
    /// Bytes of the file that are known to be whole lines.
    length: u64,
    /// Whole lines that are not in the file yet.
    pending: String,
}

impl Table {
    /// A new table with a header and no rows; a file of that name is replaced.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn create(path: PathBuf, columns: Vec<String>) -> Result<Table, RecordError> {
        let header = columns.join(",") + "\n";
        let (file, length) = replace(&path, &header)?;
        Ok(Table {
            path,
            columns,
            file,
            length,
            pending: String::new(),
        })
    }

    /// The header.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Adds columns at the right; they are empty in the rows so far.
    ///
    /// # Errors
    /// [`RecordError`] where the file cannot be read back or replaced.
    pub fn add_columns(&mut self, names: Vec<String>) -> Result<(), RecordError> {
        if names.is_empty() {
            return Ok(());
        }
        self.flush()?;
        let text = fs::read_to_string(&self.path).map_err(|reason| RecordError::Read {
            path: self.path.clone(),
            reason,
        })?;
        let empty = ",".repeat(names.len());
        self.columns.extend(names);
        let mut wider = self.columns.join(",") + "\n";
        for line in text.lines().skip(1) {
            wider.push_str(line);
            wider.push_str(&empty);
            wider.push('\n');
        }
        (self.file, self.length) = replace(&self.path, &wider)?;
        Ok(())
    }

    /// Appends a row, one cell a column; `None` is an empty cell. Nothing is written yet.
    pub fn append(&mut self, cells: impl IntoIterator<Item = Option<f64>>) {
        let mut count = 0;
        for cell in cells {
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
    }

    /// Writes the rows that were appended since the last flush.
    ///
    /// # Errors
    /// [`RecordError::Vanished`] where the file is no longer under its name (a write would succeed
    /// and be lost), [`RecordError::Write`] otherwise. The rows are kept for another try.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        if !self.path.exists() {
            return Err(RecordError::Vanished {
                path: self.path.clone(),
            });
        }
        if let Err(reason) = self.file.write_all(self.pending.as_bytes()) {
            // As much of the last line as did get written goes; if even that fails, the error
            // below still tells.
            let _ = self.file.set_len(self.length);
            return Err(RecordError::write(&self.path)(reason));
        }
        self.length += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }

    /// Flushes, and waits until the disk has it all.
    ///
    /// # Errors
    /// Those of [`Table::flush`].
    pub fn finish(&mut self) -> Result<(), RecordError> {
        self.flush()?;
        self.file.sync_all().map_err(RecordError::write(&self.path))
    }
}

/// Replaces the file at `path` and opens it for appending.
fn replace(path: &Path, text: &str) -> Result<(File, u64), RecordError> {
    write_whole(path, |file| file.write_all(text.as_bytes()))?;
    let file = OpenOptions::new()
        .append(true)
        .open(path)
        .map_err(RecordError::write(path))?;
    Ok((file, text.len() as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(folder: &Path) -> Table {
        let columns = ["step", "t"].map(str::to_owned).to_vec();
        Table::create(folder.join("table.csv"), columns).unwrap()
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
        table
            .add_columns(vec!["E_field".into(), "E_pull".into()])
            .unwrap();
        table.append([Some(1.0), Some(0.5), Some(3.0), None]);
        table.flush().unwrap();
        assert_eq!(
            fs::read_to_string(&table.path).unwrap(),
            "step,t,E_field,E_pull\n0,0,,\n1,0.5,3,\n"
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
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_and_the_rows_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut table = table(folder.path());
        let good = std::mem::replace(
            &mut table.file,
            OpenOptions::new().append(true).open("/dev/full").unwrap(),
        );
        table.append([Some(0.0), Some(0.0)]);
        let error = table.flush().unwrap_err().to_string();
        assert!(error.contains("table.csv: No space left"), "{error}");
        table.file = good;
        table.flush().unwrap();
        assert_eq!(fs::read_to_string(&table.path).unwrap(), "step,t\n0,0\n");
    }
}
