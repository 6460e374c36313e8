//! A plan: which scenes a sweep is made of, as TOML.
//!
//! ```toml
//! scene = "case3-quick"                  # a preset, or a file relative to the plan's
//! repeat = 3                             # with seeds 1, 2, 3 of the noise
//!
//! [set]                                  # of every point
//! "time.end" = 5e-4
//! "noise.strength" = 0.5
//!
//! [vary]                                 # every combination of these
//! "anchoring.weight" = { from = 1, to = 100, count = 7, scale = "log" }
//! "nematic.initial" = [[1.0, 0.0], [0.0, 1.0]]
//! zip = [{ "mesh.interface" = [0.014, 0.01], "time.tolerance" = [2e-2, 1e-2] }]    # these together
//!
//! [[point]]                              # and single ones
//! "area.target" = 1.05
//!
//! [result]                               # columns of the table beside the usual ones
//! thinnest = "min(waist)"
//! ```

use super::error::SweepError;
use super::measure::Measure;
use super::table::is_own_column;
use crate::record::{LoadError, Number};
use crate::scene::{
    FINITE, Problem, SceneError, TomlField, TomlReader, TomlValue, nearest, read_document, tables,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Values of a range, and repetitions, at most.
const LARGEST_COUNT: u64 = 100_000;

/// A key of a scene with its value, as TOML.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Assignment {
    /// Dotted, such as `anchoring.weight`.
    pub key: String,
    /// As `--set` takes it.
    pub value: String,
}

impl Assignment {
    /// As an argument of `--set`.
    pub fn argument(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// How the values of an axis lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    /// A list.
    Listed,
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Logarithmic,
}

/// Keys that vary together: one, or those of a zipped group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// Dotted.
    pub keys: Vec<String>,
    /// How the first key's values lie.
    pub spacing: Spacing,
    /// For each place on the axis the value of each key, as TOML.
    pub values: Vec<Vec<String>>,
}

/// The same points again with other seeds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repeat {
    /// How often.
    pub count: u64,
    /// The keys of the seeds; none: all that the scene has.
    pub seeds: Vec<String>,
    /// The first seed; the others follow it.
    pub first: u64,
}

/// A column of the table that the plan asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultColumn {
    /// Its name.
    pub name: String,
    /// What stands in it.
    pub measure: Measure,
}

/// What a sweep is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// A title.
    pub name: Option<String>,
    /// A preset's name, or a file's path.
    pub scene: String,
    /// Of every point.
    pub set: Vec<Assignment>,
    /// Every combination of their places is a point; the last axis varies fastest.
    pub axes: Vec<Axis>,
    /// Single points.
    pub singles: Vec<Vec<Assignment>>,
    /// The same points again.
    pub repeat: Option<Repeat>,
    /// Further columns of the table.
    pub results: Vec<ResultColumn>,
    /// As it was read.
    pub text: String,
    /// What it is called in messages.
    pub origin: String,
}

impl Plan {
    /// Reads a plan; `origin` names it in messages.
    ///
    /// # Errors
    /// What is not TOML, not known, or without sense, with its place.
    pub fn parse(text: &str, origin: &str) -> Result<Plan, SceneError> {
        let (sources, node) = read_document(text, origin, &[])?;
        let top = TomlReader::top(&sources, &node);
        top.allow(&["name", "scene", "set", "vary", "point", "repeat", "result"])?;
        let mut axes = Vec::new();
        if let Some(vary) = top.get("vary") {
            for (name, field) in vary.table()?.fields() {
                match name {
                    "zip" => axes.extend(zipped_axes(&field)?),
                    _ => leaves(&field, "vary.", true, &mut |key, field| {
                        let (spacing, values) = values(field)?;
                        let values = values.into_iter().map(|value| vec![value]).collect();
                        let keys = vec![key];
                        axes.push(Axis {
                            keys,
                            spacing,
                            values,
                        });
                        Ok(())
                    })?,
                }
            }
            once_each(&vary, axes.iter().flat_map(|axis| &axis.keys))?;
        }
        let assignments = |field: &TomlField<'_>, prefix: &str| {
            let mut found = Vec::new();
            for (_, field) in field.table()?.fields() {
                leaves(&field, prefix, false, &mut |key, field| {
                    let value = field.toml().to_owned();
                    found.push(Assignment { key, value });
                    Ok(())
                })?;
            }
            once_each(field, found.iter().map(|assignment| &assignment.key))?;
            Ok::<_, SceneError>(found)
        };
        let set = match top.get("set") {
            Some(field) => assignments(&field, "set.")?,
            None => Vec::new(),
        };
        let mut singles: Vec<Vec<Assignment>> = Vec::new();
        if let Some(field) = top.get("point") {
            for point in field.items("an array of tables, each [[point]]")? {
                singles.push(assignments(&point, &format!("{}.", point.path))?);
            }
        }
        let mut results = Vec::new();
        if let Some(field) = top.get("result") {
            for (name, field) in field.table()?.fields() {
                let of_axes = axes.iter().flat_map(|axis| &axis.keys);
                let of_singles = singles.iter().flatten().map(|single| &single.key);
                if is_own_column(name) || of_axes.chain(of_singles).any(|key| key == name) {
                    let name = name.to_owned();
                    return Err(field.key_error(Problem::TakenColumn { name }));
                }
                results.push(result(name, &field)?);
            }
        }
        let name = match top.get("name") {
            Some(field) => Some(field.text()?.to_owned()),
            None => None,
        };
        let repeat = top.get("repeat").map(|field| repeat(&field)).transpose()?;
        Ok(Plan {
            name,
            scene: top.require("scene", "a plan")?.text()?.to_owned(),
            set,
            axes,
            singles,
            repeat,
            results,
            text: text.to_owned(),
            origin: origin.to_owned(),
        })
    }

    /// An error about a key of the top level, with its place in the text.
    pub(super) fn error_at(&self, key: &str, problem: Problem) -> SceneError {
        let error = |top: &TomlReader<'_>| {
            let field = top.get(key);
            field.map_or_else(
                || top.error(problem.clone()),
                |it| it.error(problem.clone()),
            )
        };
        match read_document(&self.text, &self.origin, &[]) {
            Ok((sources, node)) => error(&TomlReader::top(&sources, &node)),
            Err(error) => error,
        }
    }

    /// An error about the value that `[set]` gives a key.
    fn error_in_set(&self, key: &str, problem: &Problem) -> SceneError {
        let in_set = || {
            let (sources, node) = read_document(&self.text, &self.origin, &[])?;
            let Some(set) = TomlReader::top(&sources, &node).get("set") else {
                return Ok(());
            };
            set.table()?.fields().try_for_each(|(_, field)| {
                leaves(&field, "set.", false, &mut |own, field| match own == key {
                    true => Err(field.error(problem.clone())),
                    false => Ok(()),
                })
            })
        };
        match in_set() {
            Ok(()) => self.error_at("set", problem.clone()),
            Err(error) => error,
        }
    }

    /// That its scene cannot be had, with the place in the plan where that is to blame.
    pub(super) fn scene_error(&self, error: LoadError) -> SweepError {
        match error {
            LoadError::Scene(error) => {
                let mut set = self.set.iter();
                match set.find(|set| error.is_of_override(&set.argument())) {
                    Some(set) => self.error_in_set(&set.key, &error.problem).into(),
                    None => SweepError::Scene(error.into()),
                }
            }
            error => {
                let reason = error.to_string();
                self.error_at("scene", Problem::PlanScene { reason }).into()
            }
        }
    }

    /// What its runs are called by: its title, or the file's name.
    pub fn title(&self, path: &Path) -> String {
        let stem = path.file_stem().unwrap_or(path.as_os_str());
        self.name
            .clone()
            .unwrap_or_else(|| stem.to_string_lossy().into_owned())
    }

    /// The keys whose values differ between points, in the order of the plan.
    pub fn varied_keys(&self) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        let of_axes = self.axes.iter().flat_map(|axis| axis.keys.iter());
        let of_singles = self.singles.iter().flatten().map(|single| &single.key);
        for key in of_axes.chain(of_singles) {
            if !keys.contains(key) {
                keys.push(key.clone());
            }
        }
        keys
    }

    /// How many points it has; saturates.
    pub fn count(&self) -> usize {
        let grid = match (self.axes.is_empty(), self.singles.is_empty()) {
            // A plan without either is its scene.
            (true, false) => 0,
            _ => self.axes.iter().fold(1_usize, |count, axis| {
                count.saturating_mul(axis.values.len())
            }),
        };
        let repeats = self
            .repeat
            .as_ref()
            .map_or(1, |repeat| repeat.count as usize);
        grid.saturating_add(self.singles.len())
            .saturating_mul(repeats)
    }

    /// The assignments of each point, without repetitions: the grid, its last axis fastest, and then the single
    /// points.
    pub fn combinations(&self) -> Vec<Vec<Assignment>> {
        let mut grid: Vec<Vec<Assignment>> = vec![Vec::new()];
        for axis in &self.axes {
            grid = grid
                .iter()
                .flat_map(|before| {
                    axis.values.iter().map(|values| {
                        let keys = axis.keys.iter().cloned();
                        let own = keys
                            .zip(values.iter().cloned())
                            .map(|(key, value)| Assignment { key, value });
                        before.iter().cloned().chain(own).collect()
                    })
                })
                .collect();
        }
        if self.axes.is_empty() && !self.singles.is_empty() {
            grid.clear();
        }
        grid.extend(self.singles.iter().cloned());
        grid
    }
}

/// The words that a range is known by.
const RANGE: [&str; 4] = ["from", "to", "count", "scale"];

/// Gives every key of a scene in a value, dotted, whether it is written `"a.b" = …` or as tables, with its field.
fn leaves<'a>(
    field: &TomlField<'a>,
    prefix: &str,
    varies: bool,
    take: &mut dyn FnMut(String, &TomlField<'a>) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    let key = field.path.strip_prefix(prefix).unwrap_or(&field.path);
    let key: String = key.split('.').map(str::trim).collect::<Vec<_>>().join(".");
    if let TomlValue::Table(entries) = field.value() {
        let is_range = entries
            .iter()
            .any(|entry| RANGE.contains(&entry.key.as_str()));
        // A table of a scene may have a key `from`, as [field] has: a range stands at a key of a table. What is written
        // within braces at such a key is its value, where it is not varied.
        let is_value = is_range || (!varies && field.toml().starts_with('{'));
        if (!key.contains('.') || !is_value) && !entries.is_empty() {
            known_key(field, &key)?;
            return field
                .table()?
                .fields()
                .try_for_each(|(_, field)| leaves(&field, prefix, varies, take));
        }
    }
    known_key(field, &key)?;
    take(key, field)
}

/// Refuses a key that no scene has. What stands below a parameter, as in `mesh.refine.band`, is the scene's to
/// check.
fn known_key(field: &TomlField<'_>, key: &str) -> Result<(), SceneError> {
    let tables = tables();
    let mut parts = key.split('.');
    let first = parts.next().unwrap_or_default();
    let Some(table) = tables.iter().find(|table| table.name == first) else {
        let names: Vec<&'static str> = tables.iter().map(|table| table.name).collect();
        return Err(field.unknown_key(first, "", &names));
    };
    let Some(word) = parts.next() else {
        return Ok(());
    };
    let keys: Vec<&'static str> = table.parameters.iter().map(|it| it.key).collect();
    match keys.contains(&word) {
        true => Ok(()),
        false => Err(field.unknown_key(word, table.name, &keys)),
    }
}

/// Refuses keys that come twice.
fn once_each<'k>(
    field: &TomlField<'_>,
    keys: impl Iterator<Item = &'k String>,
) -> Result<(), SceneError> {
    let mut seen: Vec<&String> = Vec::new();
    for key in keys {
        if seen.contains(&key) {
            let key = key.clone();
            return Err(field.key_error(Problem::Repeated { key }));
        }
        seen.push(key);
    }
    Ok(())
}

/// The values of a list or a range, as TOML.
fn values(field: &TomlField<'_>) -> Result<(Spacing, Vec<String>), SceneError> {
    const WORDS: &str = "a list of values, or a range { from, to, count, scale }";
    match field.value() {
        TomlValue::Table(_) => range(field),
        TomlValue::List(_) => {
            let items = field.items(WORDS)?;
            if items.is_empty() {
                return Err(field.out_of_range("a list of at least one value"));
            }
            let values = items.iter().map(|item| item.toml().to_owned());
            Ok((Spacing::Listed, values.collect()))
        }
        _ => Err(field.wrong_type(WORDS)),
    }
}

fn range(field: &TomlField<'_>) -> Result<(Spacing, Vec<String>), SceneError> {
    let table = field.table()?;
    table.allow(&RANGE)?;
    let end = |key| {
        let field = table.require(key, "a range")?;
        Ok::<_, SceneError>((field.number(FINITE)?, field))
    };
    let ((from, from_field), (to, to_field)) = (end("from")?, end("to")?);
    let count = table
        .require("count", "a range")?
        .integer(&(1..=LARGEST_COUNT))?;
    let scales = [("linear", Spacing::Linear), ("log", Spacing::Logarithmic)];
    let spacing = match table.get("scale") {
        Some(field) => field.choice(&scales)?,
        None => Spacing::Linear,
    };
    if spacing == Spacing::Logarithmic {
        for (value, field) in [(from, &from_field), (to, &to_field)] {
            if value <= 0.0 {
                return Err(field.out_of_range("a number > 0, for the scale is logarithmic"));
            }
        }
    }
    if count == 1 && from != to {
        return Err(field.out_of_range("a range of at least 2 values, or with from = to"));
    }
    let steps = (count - 1).max(1) as f64;
    let values = (0..count).map(|number| {
        let share = number as f64 / steps;
        let value = match (spacing, number) {
            (_, 0) => from,
            (_, number) if number + 1 == count => to,
            (Spacing::Logarithmic, _) => from * (to / from).powf(share),
            _ => from + (to - from) * share,
        };
        written(value)
    });
    Ok((spacing, values.collect()))
}

/// A number to fourteen digits: 0.3, not 0.30000000000000004. A whole one without a point, for keys that count.
fn written(value: f64) -> String {
    let rounded = format!("{value:.13e}").parse().unwrap_or(value);
    Number(rounded).to_string()
}

/// The axes of `zip`: one group, or a list of groups.
fn zipped_axes(field: &TomlField<'_>) -> Result<Vec<Axis>, SceneError> {
    match field.value() {
        TomlValue::Table(_) => Ok(vec![zipped(field)?]),
        _ => field
            .items("a group of keys with lists of the same length, or a list of such groups")?
            .iter()
            .map(zipped)
            .collect(),
    }
}

fn zipped(group: &TomlField<'_>) -> Result<Axis, SceneError> {
    let mut keys: Vec<String> = Vec::new();
    let mut columns: Vec<Vec<String>> = Vec::new();
    let mut first = Spacing::Listed;
    let prefix = format!("{}.", group.path);
    for (_, field) in group.table()?.fields() {
        leaves(&field, &prefix, true, &mut |key, field| {
            let (spacing, values) = values(field)?;
            match columns.first() {
                None => first = spacing,
                Some(before) if before.len() != values.len() => {
                    return Err(field.out_of_range(format!(
                        "of {} values, as many as {} has in the same group",
                        before.len(),
                        keys[0]
                    )));
                }
                Some(_) => {}
            }
            keys.push(key);
            columns.push(values);
            Ok(())
        })?;
    }
    let Some(length) = columns.first().map(Vec::len) else {
        return Err(group.out_of_range("a group of at least one key"));
    };
    let place = |number: usize| {
        columns
            .iter()
            .map(|column| column[number].clone())
            .collect()
    };
    Ok(Axis {
        keys,
        spacing: first,
        values: (0..length).map(place).collect(),
    })
}

fn repeat(field: &TomlField<'_>) -> Result<Repeat, SceneError> {
    let counts = 1..=LARGEST_COUNT;
    let TomlValue::Table(_) = field.value() else {
        return Ok(Repeat {
            count: field.integer(&counts)?,
            seeds: Vec::new(),
            first: 1,
        });
    };
    let table = field.table()?;
    table.allow(&["count", "seeds", "first"])?;
    let mut seeds = Vec::new();
    if let Some(field) = table.get("seeds") {
        for item in field.items("a list of keys, such as [\"noise.seed\"]")? {
            let key = item.text()?;
            known_key(&item, key)?;
            if !key.ends_with(".seed") {
                return Err(item.out_of_range("the key of a seed, such as \"noise.seed\""));
            }
            seeds.push(key.to_owned());
        }
        once_each(&field, seeds.iter())?;
    }
    Ok(Repeat {
        count: table.require("count", "repeat")?.integer(&counts)?,
        seeds,
        first: match table.get("first") {
            Some(field) => field.integer(&(0..=u64::from(u32::MAX)))?,
            None => 1,
        },
    })
}

fn result(name: &str, field: &TomlField<'_>) -> Result<ResultColumn, SceneError> {
    let text = field.text()?;
    let measure = Measure::parse(text).map_err(|error| match error.column {
        Some(column) => field.error(Problem::UnknownChoice {
            key: field.path.clone(),
            near: nearest(&column, Measure::columns()),
            found: column,
            allowed: Measure::columns().collect(),
        }),
        None => field.out_of_range(Measure::WORDS),
    })?;
    Ok(ResultColumn {
        name: name.to_owned(),
        measure,
    })
}
