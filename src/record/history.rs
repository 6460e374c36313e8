//! The tables of a run: the content of their columns.

use super::folder::remove;
use super::scalar_columns::{energy_column, scalar, value_of};
use super::table::{Extent, Found, Rows, Table};
use super::{Columns, ReadError, RecordError};
use crate::simulation::{NamedValue, Report};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The columns of `history.csv` that every run has. Effects beyond these append theirs,
/// `E_<effect>`, at the right.
pub const HISTORY_COLUMNS: [&str; 14] = [
    "step",
    "t",
    "dt",
    "E_total",
    "E_bending",
    "E_area",
    "E_nematic",
    "E_anchoring",
    "A",
    "B",
    "law_residual",
    "newton",
    "krylov",
    "wall",
];

const HISTORY: &str = "history.csv";
pub(super) const LEDGER: &str = "ledger.csv";
const SHAPE: &str = "shape.csv";

const LEDGER_COLUMNS: [&str; 2] = ["step", "t"];
pub(super) const SHAPE_COLUMNS: [&str; 5] = ["step", "t", "length", "waist", "width"];

/// Something of each table.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct PerTable<T> {
    history: T,
    shape: T,
    /// Made with the first report that has terms: the law is about steps, and the initial state
    /// is not one.
    ledger: Option<T>,
}

impl<T> PerTable<T> {
    fn as_ref(&self) -> PerTable<&T> {
        PerTable {
            history: &self.history,
            shape: &self.shape,
            ledger: self.ledger.as_ref(),
        }
    }

    fn as_mut(&mut self) -> PerTable<&mut T> {
        PerTable {
            history: &mut self.history,
            shape: &mut self.shape,
            ledger: self.ledger.as_mut(),
        }
    }

    fn try_map<U, E>(self, change: impl Fn(T) -> Result<U, E>) -> Result<PerTable<U>, E> {
        Ok(PerTable {
            history: change(self.history)?,
            shape: change(self.shape)?,
            ledger: self.ledger.map(change).transpose()?,
        })
    }

    fn all(self) -> impl Iterator<Item = T> {
        [Some(self.history), Some(self.shape), self.ledger]
            .into_iter()
            .flatten()
    }
}

/// `history.csv`, `ledger.csv` and `shape.csv`, which get their rows at the same steps.
#[derive(Debug)]
pub(super) struct Tables {
    tables: PerTable<Table>,
    ledger_path: PathBuf,
    next_row: NextRow,
}

/// What the next row is made from, beyond its report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct NextRow {
    /// The step of the last row.
    last_row: Option<u64>,
    /// The law's residual of largest magnitude since the last row.
    law_residual: f64,
    terms: StepTerms,
}

/// The terms of the law of the last step that was observed. A run that is resumed after it does not know them
/// any more, and the step may yet get a row.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct StepTerms {
    step: u64,
    values: Vec<(Cow<'static, str>, f64)>,
}

/// How far the tables have come, and what the next row is made from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct TablesCheckpoint {
    extents: PerTable<Extent>,
    next_row: NextRow,
}

/// Tables that were looked for.
#[derive(Debug)]
pub(super) struct FoundTables {
    tables: PerTable<Found>,
    ledger_path: PathBuf,
    next_row: NextRow,
}

/// The rows that the tables have at some moment.
#[derive(Debug)]
pub(super) struct TablesRows(PerTable<Rows>);

impl TablesRows {
    /// Writes them as tables of their own into a folder.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn write(self, folder: &Path) -> Result<(), RecordError> {
        let mut tables = self.0.all().zip([HISTORY, SHAPE, LEDGER]);
        tables.try_for_each(|(rows, name)| rows.write(&folder.join(name)))
    }
}

impl FoundTables {
    /// What is reported of the tables, in words.
    pub fn remarks(&self) -> Vec<String> {
        self.tables
            .as_ref()
            .all()
            .flat_map(Found::remarks)
            .collect()
    }

    /// As [`FoundTables::remarks`], where the run continues with them.
    pub fn remarks_of_take_up(&self) -> Vec<String> {
        let tables = self.tables.as_ref().all();
        tables.flat_map(Found::remarks_of_take_up).collect()
    }

    /// The rows that the tables had then; changes nothing.
    ///
    /// # Errors
    /// [`RecordError::Read`].
    pub fn rows(&self) -> Result<TablesRows, RecordError> {
        self.tables.as_ref().try_map(Found::rows).map(TablesRows)
    }

    /// The scalars that the tables had then; changes nothing.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn columns(&self) -> Result<Columns, ReadError> {
        let mut columns = self.tables.history.columns()?;
        columns.join(self.tables.shape.columns()?);
        Ok(columns)
    }

    /// Checks whether the tables can be written; changes nothing.
    ///
    /// # Errors
    /// [`RecordError::Write`], [`RecordError::FolderInTheWay`].
    pub fn check(&self) -> Result<(), RecordError> {
        self.tables.as_ref().all().try_for_each(Found::check)?;
        match &self.tables.ledger {
            None if self.ledger_path.is_dir() => Err(RecordError::FolderInTheWay {
                path: self.ledger_path.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Cuts the tables back to where they were.
    ///
    /// # Errors
    /// [`RecordError`] where a file cannot be read or written.
    pub fn reopen(self) -> Result<Tables, RecordError> {
        if self.tables.ledger.is_none() {
            remove(&self.ledger_path)?;
        }
        Ok(Tables {
            tables: self.tables.try_map(Found::reopen)?,
            ledger_path: self.ledger_path,
            next_row: self.next_row,
        })
    }
}

impl Tables {
    /// How far they have come. What was appended must be flushed before.
    pub fn save(&self) -> TablesCheckpoint {
        let PerTable {
            history,
            shape,
            ledger,
        } = self.tables.as_ref();
        TablesCheckpoint {
            extents: PerTable {
                history: history.extent(),
                shape: shape.extent(),
                ledger: ledger.map(Table::extent),
            },
            next_row: self.next_row.clone(),
        }
    }

    /// Checks whether the tables in `folder` go as far as they did; changes nothing.
    pub fn find(folder: &Path, checkpoint: &TablesCheckpoint) -> FoundTables {
        let ledger_path = folder.join(LEDGER);
        let extents = checkpoint.extents.as_ref();
        let ledger = extents.ledger;
        FoundTables {
            tables: PerTable {
                history: Table::find(folder.join(HISTORY), extents.history),
                shape: Table::find(folder.join(SHAPE), extents.shape),
                ledger: ledger.map(|extent| Table::find(ledger_path.clone(), extent)),
            },
            ledger_path,
            next_row: checkpoint.next_row.clone(),
        }
    }

    /// The tables of a run in `folder`, still without rows.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn create(folder: &Path, initial: &Report) -> Result<Tables, RecordError> {
        let mut tables = Tables::new(folder, initial);
        tables.flush()?;
        Ok(tables)
    }

    /// The tables of a run in `folder`, still without rows and without files.
    pub fn new(folder: &Path, initial: &Report) -> Tables {
        let mut columns = owned(&HISTORY_COLUMNS);
        columns.extend(missing(&columns, &initial.energies, energy_column));
        Tables {
            tables: PerTable {
                history: Table::new(folder.join(HISTORY), columns),
                shape: Table::new(folder.join(SHAPE), owned(&SHAPE_COLUMNS)),
                ledger: None,
            },
            ledger_path: folder.join(LEDGER),
            next_row: NextRow::default(),
        }
    }

    /// Continues them in another folder; the rows that are in a file stay where they are.
    pub fn move_to(&mut self, folder: &Path) {
        self.ledger_path = folder.join(LEDGER);
        let tables = self.tables.as_mut().all();
        tables.for_each(|table| table.move_to(folder));
    }

    /// The rows up to now, those too that are in no file yet.
    ///
    /// # Errors
    /// [`RecordError`].
    pub fn rows_now(&mut self) -> Result<TablesRows, RecordError> {
        self.tables
            .as_mut()
            .try_map(Table::rows_now)
            .map(TablesRows)
    }

    /// Takes note of a step, whether or not it gets a row.
    pub fn observe(&mut self, report: &Report) {
        // Written so that a residual that is not a number is not passed over.
        let NextRow {
            law_residual,
            terms,
            ..
        } = &mut self.next_row;
        if law_residual.abs() < report.law_residual.abs() || report.law_residual.is_nan() {
            *law_residual = report.law_residual;
        }
        if !report.ledger.is_empty() {
            terms.step = report.step;
            terms.values.clear();
            let ledger = report.ledger.iter();
            let ledger = ledger.map(|term| (Cow::Borrowed(term.name), term.value));
            terms.values.extend(ledger);
        }
    }

    /// Appends the row of a step to each table, if it is not there yet. `wall` is the time of
    /// computing since the run began, in seconds. Nothing is written yet.
    pub fn append(&mut self, report: &Report, wall: f64) {
        if self.next_row.last_row == Some(report.step) {
            return;
        }
        self.append_scalars(report, wall);
        self.append_ledger(report);
    }

    /// Appends a row but for the ledger.
    fn append_scalars(&mut self, report: &Report, wall: f64) {
        self.next_row.last_row = Some(report.step);

        let law_residual = std::mem::take(&mut self.next_row.law_residual);
        let history = &mut self.tables.history;
        history.add_columns(missing(history.columns(), &report.energies, energy_column));
        let cell = |column: &String| match column.as_str() {
            "law_residual" => Some(law_residual),
            "wall" => Some(wall),
            column => scalar(report, column),
        };
        let cells: Vec<_> = history.columns().iter().map(cell).collect();
        history.append(cells);

        let cells = SHAPE_COLUMNS.map(|column| scalar(report, column));
        self.tables.shape.append(cells);
    }

    fn append_ledger(&mut self, report: &Report) {
        let StepTerms { step, values } = &self.next_row.terms;
        let is_taken_up = report.ledger.is_empty() && *step == report.step;
        let terms = match is_taken_up {
            true => &values[..],
            false => &[],
        };
        let tables = &mut self.tables;
        if tables.ledger.is_none() && report.ledger.is_empty() && terms.is_empty() {
            return;
        }
        let ledger = tables
            .ledger
            .get_or_insert_with(|| Table::new(self.ledger_path.clone(), owned(&LEDGER_COLUMNS)));
        let is_known = |name: &str| ledger.columns().iter().any(|column| column == name);
        let all = ledger_cells(report, is_known);
        let names = terms.iter().map(|(name, _)| name.clone().into_owned());
        let mut late: Vec<String> = names.filter(|name| !is_known(name)).collect();
        late.extend(missing(ledger.columns(), &all, str::to_owned));
        ledger.add_columns(late);
        let value = |name: &String| {
            let term = terms.iter().find(|(known, _)| known == name);
            term.map(|(_, value)| *value)
                .or_else(|| value_of(&all, name))
        };
        let names = &ledger.columns()[LEDGER_COLUMNS.len()..];
        let cells: Vec<_> = [Some(report.step as f64), Some(report.t)]
            .into_iter()
            .chain(names.iter().map(value))
            .collect();
        ledger.append(cells);
    }

    /// Brings every row to the files.
    ///
    /// # Errors
    /// [`RecordError::Write`], [`RecordError::Vanished`].
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.each(Table::flush)
    }

    /// Brings every row to the disk.
    ///
    /// # Errors
    /// Those of [`Tables::flush`].
    pub fn finish(&mut self) -> Result<(), RecordError> {
        self.each(Table::finish)
    }

    /// Every table is tried, also after one that fails; returns the first error.
    fn each(
        &mut self,
        action: fn(&mut Table) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let tables = self.tables.as_mut().all();
        tables.map(action).fold(Ok(()), Result::and)
    }
}

/// The cells of a row of the ledger, but for step and time. `is_known`: whether it has a column.
pub(super) fn ledger_cells(report: &Report, is_known: impl Fn(&str) -> bool) -> Vec<NamedValue> {
    let effort = report.effort.columns();
    // The ledger of a run that never had to climb has the terms of the law and nothing else.
    let is_told = report.effort.needed_more() || is_known(effort[0].0);
    let effort = effort.map(|(name, value)| NamedValue { name, value });
    let effort = effort.into_iter().filter(|_| is_told);
    report.ledger.iter().copied().chain(effort).collect()
}

pub(super) fn owned(columns: &[&str]) -> Vec<String> {
    columns.iter().map(|&column| column.to_owned()).collect()
}

/// The columns of `values` that a table does not have.
fn missing(
    columns: &[String],
    values: &[NamedValue],
    column_of: impl Fn(&str) -> String,
) -> Vec<String> {
    values
        .iter()
        .map(|named| column_of(named.name))
        .filter(|column| !columns.contains(column))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{OutlineMeasure, Vesicle};
    use std::fs;

    fn named(name: &'static str, value: f64) -> NamedValue {
        NamedValue { name, value }
    }

    fn report(step: u64) -> Report {
        Report {
            step,
            t: step as f64 * 1e-7,
            dt: 1e-7,
            energies: vec![named("bending", 36.5), named("field", -0.25)],
            total_energy: 36.25,
            phase_integral: -0.75,
            surface_area: 1.5,
            law_residual: 0.0,
            newton: 2,
            krylov: 20,
            ..Report::default()
        }
    }

    fn read(folder: &Path, name: &str) -> String {
        fs::read_to_string(folder.join(name)).unwrap()
    }

    #[test]
    fn the_columns_are_those_of_the_interface() {
        let folder = tempfile::tempdir().unwrap();
        let mut tables = Tables::create(folder.path(), &report(0)).unwrap();
        tables.append(&report(0), 0.0);
        tables.finish().unwrap();
        assert_eq!(
            read(folder.path(), "history.csv"),
            "step,t,dt,E_total,E_bending,E_area,E_nematic,E_anchoring,A,B,law_residual,newton,\
             krylov,wall,E_field\n\
             0,0,1e-7,36.25,36.5,,,,-0.75,1.5,0,2,20,0,-0.25\n"
        );
        assert_eq!(
            read(folder.path(), "shape.csv"),
            "step,t,length,waist,width\n0,0,,,\n"
        );
        assert!(!folder.path().join("ledger.csv").exists());
    }

    #[test]
    fn the_residual_is_the_one_of_largest_magnitude_since_the_row_before() {
        let folder = tempfile::tempdir().unwrap();
        let mut tables = Tables::create(folder.path(), &report(0)).unwrap();
        for (step, law_residual) in [(1, 1e-9), (2, -3e-9), (3, 2e-9), (4, 5e-10), (5, 1e-10)] {
            let report = Report {
                law_residual,
                ..report(step)
            };
            tables.observe(&report);
            if [3, 5].contains(&step) {
                tables.append(&report, 0.5);
            }
        }
        tables.finish().unwrap();
        let text = read(folder.path(), "history.csv");
        let residuals: Vec<_> = text
            .lines()
            .map(|line| line.split(',').nth(10).unwrap())
            .collect();
        assert_eq!(residuals, ["law_residual", "-3e-9", "5e-10"]);
    }

    #[test]
    fn a_step_has_one_row_however_often_it_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let mut tables = Tables::create(folder.path(), &report(0)).unwrap();
        for step in [0, 0, 1, 1] {
            tables.append(&report(step), 0.0);
        }
        tables.finish().unwrap();
        assert_eq!(read(folder.path(), "history.csv").lines().count(), 3);
        assert_eq!(read(folder.path(), "shape.csv").lines().count(), 3);
    }

    #[test]
    fn the_ladder_is_told_from_the_first_step_that_climbs_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut tables = Tables::create(folder.path(), &report(0)).unwrap();
        let climbed = crate::simulation::StepEffort {
            damping: 0.5,
            parts: 2,
            refused: 3,
            ..Default::default()
        };
        for (step, effort) in [
            (1, Default::default()),
            (2, climbed),
            (3, Default::default()),
        ] {
            let mut report = report(step);
            report.ledger = vec![named("rate", 0.5)];
            report.effort = effort;
            tables.append(&report, 0.0);
        }
        tables.finish().unwrap();
        assert_eq!(
            read(folder.path(), "ledger.csv"),
            "step,t,rate,rung,damping,parts,refused\n\
             1,1e-7,0.5,,,,\n2,2e-7,0.5,4,0.5,2,3\n3,3e-7,0.5,0,1,0,0\n"
        );
    }

    #[test]
    fn an_effect_that_comes_late_gets_its_columns() {
        let folder = tempfile::tempdir().unwrap();
        let mut tables = Tables::create(folder.path(), &report(0)).unwrap();
        let step = |n, terms: &[&'static str]| {
            let mut report = report(n);
            report.ledger = terms.iter().map(|term| named(term, 0.5)).collect();
            let outline = OutlineMeasure {
                length: 0.64,
                waist: 0.125,
                width: 0.25,
            };
            report.vesicles = vec![Vesicle {
                outline: Some(outline),
                ..Vesicle::default()
            }];
            report
        };
        tables.append(&report(0), 0.0);
        tables.append(&step(1, &["rate"]), 0.0);
        let mut late = step(2, &["rate", "anchoring"]);
        late.energies.push(named("pull", 7.0));
        late.energies.push(named("anchoring", 9.0));
        tables.append(&late, 0.0);
        tables.finish().unwrap();
        assert_eq!(
            read(folder.path(), "ledger.csv"),
            "step,t,rate,anchoring\n1,1e-7,0.5,\n2,2e-7,0.5,0.5\n"
        );
        let history = read(folder.path(), "history.csv");
        let lines: Vec<_> = history.lines().collect();
        assert!(lines[0].ends_with(",wall,E_field,E_pull"));
        assert!(lines[2].ends_with(",0,-0.25,"));
        assert_eq!(
            lines[3],
            "2,2e-7,1e-7,36.25,36.5,,,9,-0.75,1.5,0,2,20,0,-0.25,7"
        );
        assert!(read(folder.path(), "shape.csv").ends_with("\n2,2e-7,0.64,0.125,0.25\n"));
    }
}
