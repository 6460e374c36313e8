//! The scalars of a run in memory: columns over the rows of its tables.

use super::history::{LEDGER, ledger_cells};
use super::read::{ReadError, read_table};
use super::{HISTORY_COLUMNS, Number};
use crate::simulation::Report;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;

/// The columns of `shape.csv` beyond step and t.
const SHAPE: [&str; 3] = ["length", "waist", "width"];
/// How the names of the ledger's columns begin here.
const OF_LEDGER: &str = "ledger:";

/// Columns of scalars, each with a value a row; NaN where there is none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Columns {
    columns: Vec<(String, Vec<f64>)>,
    rows: usize,
    /// Of the row that was taken back, the step and the cells of the ledger.
    #[serde(skip)]
    taken_back: Option<(f64, Vec<(String, f64)>)>,
}

impl Columns {
    /// Appends a step. `wall` is left out: a report knows no clock.
    pub fn push(&mut self, report: &Report) {
        let outline = report.outline;
        let mut cells: Vec<(String, f64)> = vec![
            ("step".to_owned(), report.step as f64),
            ("t".to_owned(), report.t),
            ("dt".to_owned(), report.dt),
            ("E_total".to_owned(), report.total_energy),
        ];
        let energies = report.energies.iter();
        cells.extend(energies.map(|energy| (format!("E_{}", energy.name), energy.value)));
        cells.extend([
            ("A".to_owned(), report.phase_integral),
            ("B".to_owned(), report.surface_area),
            ("law_residual".to_owned(), report.law_residual),
            ("newton".to_owned(), f64::from(report.newton)),
            ("krylov".to_owned(), f64::from(report.krylov)),
        ]);
        if let Some(outline) = outline {
            let sizes = [outline.length, outline.waist, outline.width];
            cells.extend(SHAPE.map(str::to_owned).into_iter().zip(sizes));
        }
        let taken_back = self.taken_back.take();
        if !report.ledger.is_empty() {
            let is_known = |name: &str| self.column(&format!("{OF_LEDGER}{name}")).is_some();
            let ledger = ledger_cells(report, is_known).into_iter();
            cells.extend(ledger.map(|cell| (format!("{OF_LEDGER}{}", cell.name), cell.value)));
        } else if let Some((step, ledger)) = taken_back
            && step == report.step as f64
        {
            cells.extend(ledger);
        }
        self.append(cells);
    }

    /// Takes the last row back: it is the first that a run tells that goes on from there. Its ledger is
    /// kept for it, for such a run does not know that any more.
    pub fn take_back(&mut self) {
        let Some(last) = self.rows.checked_sub(1) else {
            return;
        };
        let step = self.column("step").map_or(f64::NAN, |steps| steps[last]);
        let of_ledger = |(name, _): &&(String, Vec<f64>)| name.starts_with(OF_LEDGER);
        let ledger = self.columns.iter().filter(of_ledger);
        let ledger = ledger.map(|(name, values)| (name.clone(), values[last]));
        self.taken_back = Some((step, ledger.collect()));
        self.truncate(last);
    }

    fn append(&mut self, cells: Vec<(String, f64)>) {
        for (name, value) in cells {
            let column = match self.columns.iter().position(|(known, _)| *known == name) {
                Some(number) => number,
                None => {
                    self.columns.push((name, vec![f64::NAN; self.rows]));
                    self.columns.len() - 1
                }
            };
            self.columns[column].1.push(value);
        }
        self.rows += 1;
        for (_, values) in &mut self.columns {
            values.resize(self.rows, f64::NAN);
        }
    }

    /// Reads `history.csv`, and `shape.csv` where it is there, of a run's folder.
    ///
    /// # Errors
    /// [`ReadError`]: what cannot be read, or is damaged, with file, line and column.
    pub fn read(folder: &Path) -> Result<Columns, ReadError> {
        let path = folder.join("history.csv");
        let mut columns = read_table(&path)?;
        for name in HISTORY_COLUMNS {
            if columns.column(name).is_none() {
                return Err(ReadError::NoColumn { path, name });
            }
        }
        let shape = folder.join("shape.csv");
        if shape.exists() {
            columns.join(read_table(&shape)?);
        }
        Ok(columns)
    }

    /// As [`read`](Self::read), and `ledger.csv` too where it is there and can be read.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub(super) fn read_with_ledger(folder: &Path) -> Result<Columns, ReadError> {
        let mut columns = Self::read(folder)?;
        if let Ok(mut ledger) = read_table(&folder.join(LEDGER)) {
            for (name, _) in &mut ledger.columns {
                if !["step", "t"].contains(&name.as_str()) {
                    name.insert_str(0, OF_LEDGER);
                }
            }
            columns.join(ledger);
        }
        Ok(columns)
    }

    /// Columns with their values, all of the same length.
    pub(super) fn from_parts(names: Vec<String>, values: Vec<Vec<f64>>) -> Columns {
        Columns {
            rows: values.first().map_or(0, Vec::len),
            columns: names.into_iter().zip(values).collect(),
            taken_back: None,
        }
    }

    /// Takes over the columns of another table that are not here, for the steps that are.
    fn join(&mut self, other: Columns) {
        let (Some(steps), Some(other_steps)) = (self.column("step"), other.column("step")) else {
            return;
        };
        // Both are in order; a table that was written a moment later has some rows more.
        let mut row_of = other_steps.iter().enumerate().peekable();
        let rows: Vec<Option<usize>> = steps
            .iter()
            .map(|step| {
                while row_of.next_if(|(_, other)| *other < step).is_some() {}
                row_of
                    .next_if(|(_, other)| *other == step)
                    .map(|(row, _)| row)
            })
            .collect();
        let names = self.columns.iter().map(|(name, _)| name.clone());
        let known: HashSet<String> = names.collect();
        for (name, values) in other.columns {
            if !known.contains(&name) {
                let value = |row: &Option<usize>| row.map_or(f64::NAN, |row| values[row]);
                self.columns.push((name, rows.iter().map(value).collect()));
            }
        }
    }

    /// Whether every column has a value a row: what comes from a file may not.
    pub(super) fn is_whole(&self) -> bool {
        let whole = |(_, values): &(String, Vec<f64>)| values.len() == self.rows;
        self.columns.iter().all(whole)
    }

    /// Keeps the first rows only.
    pub fn truncate(&mut self, rows: usize) {
        self.rows = self.rows.min(rows);
        for (_, values) in &mut self.columns {
            values.truncate(rows);
        }
    }

    /// Keeps the rows up to a step. Where there is none of the step itself there is one with nothing
    /// else in it.
    pub(super) fn end_at(&mut self, step: u64) {
        let steps = self.column("step").unwrap_or_default();
        let rows = steps.partition_point(|other| *other <= step as f64);
        let is_there = rows > 0 && steps[rows - 1] == step as f64;
        self.truncate(rows);
        if !is_there {
            self.append(vec![("step".to_owned(), step as f64)]);
        }
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The names of the columns, in order; the ledger has its own.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let names = self.columns.iter().map(|(name, _)| name.as_str());
        names.filter(|name| !name.starts_with(OF_LEDGER))
    }

    /// The values of a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let (_, values) = self.columns.iter().find(|(known, _)| known == name)?;
        Some(values)
    }

    /// The values of a column that has any number: not of an effect that is absent.
    pub fn known(&self, name: &str) -> Option<&[f64]> {
        let values = self.column(name)?;
        values
            .iter()
            .any(|value| value.is_finite())
            .then_some(values)
    }

    /// As CSV. Numbers read back exactly; what is no number is an empty cell.
    pub fn to_csv(&self) -> String {
        self.csv(&self.names().collect::<Vec<_>>(), |_| true)
    }

    /// The text of `history.csv`: the columns that every run has, then those of further effects.
    pub(super) fn to_history(&self) -> String {
        let mut names = HISTORY_COLUMNS.to_vec();
        let further = |name: &&str| name.starts_with("E_") && !HISTORY_COLUMNS.contains(name);
        names.extend(self.names().filter(further));
        self.csv(&names, |_| true)
    }

    /// The text of `shape.csv`.
    pub(super) fn to_shape(&self) -> String {
        self.csv(&["step", "t", SHAPE[0], SHAPE[1], SHAPE[2]], |_| true)
    }

    /// The text of `ledger.csv`: the rows that have one, which are those of steps; `None`, if there is no
    /// such row.
    pub(super) fn to_ledger(&self) -> Option<String> {
        let of_ledger = |(name, _): &&(String, Vec<f64>)| name.starts_with(OF_LEDGER);
        let ledger: Vec<_> = self.columns.iter().filter(of_ledger).collect();
        let mut names = vec!["step", "t"];
        names.extend(ledger.iter().map(|(name, _)| name.as_str()));
        let is_of_step = |row: usize| ledger.iter().any(|(_, values)| !values[row].is_nan());
        let text = self.csv(&names, is_of_step);
        (!ledger.is_empty()).then(|| text.replace(OF_LEDGER, ""))
    }

    /// Some columns of some rows as CSV; one that is not there has empty cells.
    fn csv(&self, names: &[&str], has_row: impl Fn(usize) -> bool) -> String {
        let columns: Vec<_> = names.iter().map(|name| self.column(name)).collect();
        let mut text = names.join(",") + "\n";
        for row in (0..self.rows).filter(|row| has_row(*row)) {
            for (number, values) in columns.iter().enumerate() {
                if number > 0 {
                    text.push(',');
                }
                let value = values.map_or(f64::NAN, |values| values[row]);
                if !value.is_nan() {
                    // Writing to a String cannot fail.
                    let _ = write!(text, "{}", Number(value));
                }
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::NamedValue;

    fn report(step: u64, energies: &[(&'static str, f64)]) -> Report {
        let named = |&(name, value): &(&'static str, f64)| NamedValue { name, value };
        Report {
            step,
            t: step as f64 * 1e-7,
            energies: energies.iter().map(named).collect(),
            ..Report::default()
        }
    }

    #[test]
    fn an_effect_that_comes_late_has_no_number_before() {
        let mut columns = Columns::default();
        columns.push(&report(0, &[("bending", 2.0)]));
        columns.push(&report(1, &[("bending", 1.0), ("anchoring", 0.5)]));
        columns.push(&report(2, &[("bending", 0.5)]));
        let anchoring = columns.column("E_anchoring").expect("it came");
        assert!(anchoring[0].is_nan() && anchoring[2].is_nan());
        assert_eq!(anchoring[1], 0.5);
        assert_eq!(columns.column("step"), Some(&[0.0, 1.0, 2.0][..]));
        assert_eq!(columns.column("E_area"), None);
        assert_eq!(columns.rows(), 3);
        let text = columns.to_csv();
        assert!(text.starts_with("step,t,dt,E_total,E_bending,A,"), "{text}");
        assert!(text.ends_with(",0,0,\n"), "{text}");
    }
}
