//! The scalars of a run in memory: columns over the rows of its tables.

use super::history::{HISTORY_COLUMNS, SHAPE_COLUMNS, owned};
use super::push_cells;
use super::read::{ReadError, read_table};
use crate::simulation::{NamedValue, Report};
use std::collections::HashSet;
use std::path::Path;

/// The columns before the energies of the effects, which differ from run to run, and after them.
const BEFORE_ENERGIES: &[&str] = HISTORY_COLUMNS.split_at(4).0;
const AFTER_ENERGIES: &[&str] = HISTORY_COLUMNS.split_at(8).1;
const SIZES: &[&str] = SHAPE_COLUMNS.split_at(2).1;

/// The column of an effect's energy.
pub(super) fn energy_column(effect: &str) -> String {
    format!("E_{effect}")
}

/// What a report has for a column; `None`: nothing.
pub(super) fn scalar(report: &Report, column: &str) -> Option<f64> {
    match column {
        "step" => Some(report.step as f64),
        "t" => Some(report.t),
        "dt" => Some(report.dt),
        "E_total" => Some(report.total_energy),
        "A" => Some(report.phase_integral),
        "B" => Some(report.surface_area),
        "law_residual" => Some(report.law_residual),
        "newton" => Some(f64::from(report.newton)),
        "krylov" => Some(f64::from(report.krylov)),
        "length" => report.outline().map(|outline| outline.length),
        "waist" => report.outline().map(|outline| outline.waist),
        "width" => report.outline().map(|outline| outline.width),
        energy => value_of(&report.energies, energy.strip_prefix("E_")?),
    }
}

/// The value of a name.
pub(super) fn value_of(values: &[NamedValue], name: &str) -> Option<f64> {
    let named = values.iter().find(|named| named.name == name)?;
    Some(named.value)
}

/// Columns of scalars, each with a value a row; NaN where there is none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    columns: Vec<(String, Vec<f64>)>,
    rows: usize,
}

impl Columns {
    /// Appends a step. `wall` is left out: a report knows no clock.
    pub fn push(&mut self, report: &Report) {
        let energies = report.energies.iter();
        let energies = energies.map(|energy| energy_column(energy.name));
        let names = [
            owned(BEFORE_ENERGIES),
            energies.collect(),
            owned(AFTER_ENERGIES),
            owned(SIZES),
        ];
        for name in names.concat() {
            let Some(value) = scalar(report, &name) else {
                continue;
            };
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

    /// Columns with their values, all of the same length.
    pub(super) fn from_parts(names: Vec<String>, values: Vec<Vec<f64>>) -> Columns {
        Columns {
            rows: values.first().map_or(0, Vec::len),
            columns: names.into_iter().zip(values).collect(),
        }
    }

    /// Takes over the columns of another table that are not here, for the steps that are.
    pub(super) fn join(&mut self, other: Columns) {
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
        let known: HashSet<String> = self.names().map(str::to_owned).collect();
        for (name, values) in other.columns {
            if !known.contains(&name) {
                let value = |row: &Option<usize>| row.map_or(f64::NAN, |row| values[row]);
                self.columns.push((name, rows.iter().map(value).collect()));
            }
        }
    }

    /// Keeps the first rows only.
    pub fn truncate(&mut self, rows: usize) {
        self.rows = self.rows.min(rows);
        for (_, values) in &mut self.columns {
            values.truncate(rows);
        }
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The names of the columns, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
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

    /// As CSV. Numbers read back exactly; what is not a number is an empty cell.
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.names().collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows {
            let values = self.columns.iter().map(|(_, values)| values[row]);
            push_cells(
                &mut text,
                values.map(|value| Some(value).filter(|value| !value.is_nan())),
            );
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
