//! The table of a sweep: one row a point, the varied keys first.

use super::folder::{PointState, SweepFolder};
use super::plan::Plan;
use super::points::Point;
use crate::physics::EFFECTS;
use crate::record::{Columns, EventRecord, Number, read_file_text};
use serde::Deserialize;
use std::path::Path;

/// The columns before and after the energies of the effects.
const BEFORE: [&str; 4] = ["step", "t", "dt", "E_total"];
const AFTER: [&str; 6] = ["A", "B", "law_residual", "length", "waist", "width"];
/// The first column that is no value of the scene.
const STATE: &str = "state";
const REPETITION: &str = "repetition";
const POINT: &str = "point";
/// Between a round vesicle, 1, and one that is pinched, 0.
const RATIO: &str = "waist/length";

/// Bytes of a run.json, at most.
const LARGEST: u64 = 1 << 28;

/// Whether a name is that of a column that the table has of itself, or may have: an effect's energy is `E_` and its name.
pub(super) fn is_own_column(name: &str) -> bool {
    let of_points = [POINT, STATE, REPETITION, RATIO, "E_bending"];
    let mut own = of_points.into_iter().chain(BEFORE).chain(AFTER);
    own.any(|own| own == name) || EFFECTS.iter().any(|it| name.strip_prefix("E_") == Some(it))
}

/// One point of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its folder's name.
    pub name: String,
    /// The values of the varied keys, as TOML.
    pub values: Vec<String>,
    /// Which repetition it is; 0 where there are none.
    pub repetition: u64,
    /// How it stands.
    pub state: PointState,
    /// The numbers, of the columns; `None`: there is none.
    pub numbers: Vec<Option<f64>>,
}

/// The table of a sweep, as far as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The varied keys.
    pub keys: Vec<String>,
    /// Whether there are repetitions.
    pub has_repetitions: bool,
    /// The names of the numbers.
    pub columns: Vec<String>,
    /// The points in their order.
    pub rows: Vec<Row>,
}

impl Table {
    /// Reads the table from the folders of a sweep's runs. A run that cannot be read has no numbers.
    pub fn read(sweep: &SweepFolder) -> Table {
        let points = sweep.points().iter();
        let read: Vec<_> = points
            .map(|point| {
                let folder = sweep.run(point);
                let history = Columns::read(&folder).ok().filter(|it| it.rows() > 0);
                let history = history.map(|it| (it, events(&folder)));
                (point, sweep.state(point), history)
            })
            .collect();
        // The effects that some point has, in the order of the first that has them.
        let mut energies: Vec<&str> = Vec::new();
        for (_, _, history) in &read {
            let names = history.iter().flat_map(|(history, _)| history.names());
            for name in names.filter(|name| name.starts_with("E_") && *name != "E_total") {
                if !energies.contains(&name) {
                    energies.push(name);
                }
            }
        }
        let plain: Vec<&str> = BEFORE.into_iter().chain(energies).chain(AFTER).collect();
        let results = &sweep.plan.results;
        let asked = results.iter().map(|it| match it.measure.is_clock() {
            true => format!("{} [s]", it.name),
            false => it.name.clone(),
        });
        let columns = plain.iter().map(|it| (*it).to_owned());
        let columns = columns.chain([RATIO.to_owned()]).chain(asked).collect();
        let row = |(point, state, history): &(&Point, PointState, Option<_>)| {
            let history: Option<&(Columns, Vec<EventRecord>)> = history.as_ref();
            let last = |name: &str| {
                let value = history?.0.column(name)?.last()?;
                Some(*value).filter(|value| !value.is_nan())
            };
            let ratio = last("waist").zip(last("length")).map(|(w, l)| w / l);
            let asked = results.iter().map(|column| {
                let (history, events) = history?;
                column.measure.of(history, events)
            });
            let plain = plain.iter().map(|name| last(name));
            Row {
                name: point.name.clone(),
                values: point.values.clone(),
                repetition: point.repetition,
                state: state.clone(),
                numbers: plain.chain([ratio]).chain(asked).collect(),
            }
        };
        Table {
            keys: sweep.keys().to_vec(),
            has_repetitions: sweep.plan.repeat.is_some(),
            columns,
            rows: read.iter().map(row).collect(),
        }
    }

    /// The place of a column among the numbers.
    pub fn column(&self, name: &str) -> Option<usize> {
        let bare = |column: &str| column.strip_suffix(" [s]").unwrap_or(column) == name;
        self.columns.iter().position(|column| bare(column))
    }

    /// The columns of numbers that the table of a plan has, whatever effects there are.
    pub fn columns_of(plan: &Plan) -> Vec<String> {
        let own = BEFORE.into_iter().chain(AFTER).chain([RATIO]);
        let asked = plan.results.iter().map(|result| result.name.clone());
        own.map(str::to_owned).chain(asked).collect()
    }

    /// As CSV: the varied keys with their units, the repetition, the point, how it stands, the numbers. All numbers
    /// are dimensionless where no unit is given; they read back exactly, and what there is not is an empty cell.
    pub fn to_csv(&self) -> String {
        let mut head: Vec<String> = self.keys.iter().map(|key| with_unit(key)).collect();
        head.extend(self.has_repetitions.then(|| REPETITION.to_owned()));
        head.extend([POINT.to_owned(), STATE.to_owned()]);
        head.extend(self.columns.iter().cloned());
        let mut text = line(head);
        for row in &self.rows {
            let mut cells: Vec<String> = row.values.iter().map(|value| plain(value)).collect();
            cells.extend(self.has_repetitions.then(|| row.repetition.to_string()));
            cells.extend([row.name.clone(), row.state.word().to_owned()]);
            let number =
                |number: &Option<f64>| number.map_or(String::new(), |it| Number(it).to_string());
            cells.extend(row.numbers.iter().map(number));
            text += &line(cells);
        }
        text
    }
}

/// A value of TOML without the quotes of a string.
pub fn plain(value: &str) -> String {
    let string = value.strip_prefix(['"', '\'']);
    let string = string.and_then(|value| value.strip_suffix(['"', '\'']));
    string.unwrap_or(value).to_owned()
}

/// A key with the unit of its values, if they have one.
fn with_unit(key: &str) -> String {
    match key.ends_with(".angle") {
        true => format!("{key} [degrees]"),
        false => key.to_owned(),
    }
}

/// Cells as a line of CSV (RFC 4180).
fn line(cells: Vec<String>) -> String {
    let quoted = |cell: String| match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell,
    };
    cells.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// What happened in a run, by its run.json.
fn events(run: &Path) -> Vec<EventRecord> {
    #[derive(Deserialize)]
    struct Summary {
        events: Vec<EventRecord>,
    }
    let text = read_file_text(&run.join("run.json"), LARGEST).unwrap_or_default();
    serde_json::from_str::<Summary>(&text).map_or_else(|_| Vec::new(), |it| it.events)
}
