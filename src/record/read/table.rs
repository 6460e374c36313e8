//! Tables of numbers, read back.

use super::super::Columns;
use super::super::bounded_read::read_file_text;
use super::super::lenient::LenientTable;
use super::super::shortened::shortened;
use super::{LARGEST, ReadError};
use std::path::Path;

/// Reads a table, also one that a spreadsheet has rewritten. An empty cell is NaN. What follows the last
/// whole line is left out: a run that is not finished, or was killed, may have left a part of a line.
///
/// # Errors
/// [`ReadError`] with line and column.
pub(in super::super) fn read_table(path: &Path) -> Result<Columns, ReadError> {
    let text = read_file_text(path, LARGEST).map_err(|reason| ReadError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    parse_table(path, &text)
}

/// As [`read_table`], of the text of the file.
///
/// # Errors
/// [`ReadError`] with line and column.
pub(in super::super) fn parse_table(path: &Path, text: &str) -> Result<Columns, ReadError> {
    let whole = text.rfind(['\n', '\r']).map_or("", |end| &text[..=end]);
    let mut table = LenientTable::new(whole).ok_or_else(|| ReadError::EmptyTable {
        path: path.to_owned(),
    })?;
    let names = table.columns.clone();
    let mut values = vec![Vec::new(); names.len()];
    while let Some(line) = table.next() {
        if line.cells.len() != names.len() {
            return Err(ReadError::Row {
                path: path.to_owned(),
                line: line.number,
                found: line.cells.len(),
                expected: names.len(),
            });
        }
        for ((cell, column), name) in line.cells.iter().zip(&mut values).zip(&names) {
            column.push(table.value(cell).ok_or_else(|| ReadError::Cell {
                path: path.to_owned(),
                line: line.number,
                column: shortened(name).into_owned(),
                text: shortened(cell).into_owned(),
            })?);
        }
    }
    Ok(Columns::from_parts(names, values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(text: &str) -> Result<Columns, ReadError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("history.csv");
        fs::write(&path, text).expect("it is written");
        read_table(&path)
    }

    #[test]
    fn an_empty_cell_is_no_number_and_a_part_of_a_line_is_left_out() {
        let table = read("step,t,E_area\n0,0,\n1,1e-7,36.5\n2,2e-").expect("a table");
        assert_eq!(table.rows(), 2);
        assert_eq!(table.column("t"), Some(&[0.0, 1e-7][..]));
        let area = table.column("E_area").expect("a column");
        assert!(area[0].is_nan() && area[1] == 36.5);
    }

    #[test]
    fn damage_is_told_with_its_place() {
        let error = |text| read(text).expect_err("damaged").to_string();
        assert!(error("").contains("is empty"));
        assert!(error("\n").contains("is empty"));
        let text = error("step,t\n0,0\n1\n");
        assert!(
            text.contains("line 3 has 1 cells, the header has 2"),
            "{text}"
        );
        let text = error("step,t\n0,0\n1,one\n");
        assert!(text.contains("line 3, column t has \"one\""), "{text}");
        let long = "one".repeat(1 << 20);
        let text = read(&format!("step,t\n0,{long}\n"))
            .expect_err("damaged")
            .to_string();
        assert!(text.len() < 400, "{} bytes", text.len());
    }

    #[test]
    fn bytes_that_are_no_text_are_an_error_with_the_path() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("history.csv");
        fs::write(&path, [b's', 0xff]).expect("it is written");
        let text = read_table(&path).expect_err("no text").to_string();
        assert!(
            text.contains("history.csv") && text.contains("UTF-8"),
            "{text}"
        );
    }
}
