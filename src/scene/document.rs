//! A TOML document whose values know where they come from, with overrides applied.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::error::{Origin, Problem, SceneError};
use super::overrides;

/// The text of the scene and of each override.
#[derive(Debug)]
pub(crate) struct Sources(Vec<Source>);

#[derive(Debug)]
struct Source {
    origin: Origin,
    text: String,
}

/// A range of bytes in one of the sources.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Location {
    source: usize,
    start: usize,
    end: usize,
}

/// A value and where it stands.
#[derive(Debug)]
pub(crate) struct Node {
    pub value: Value,
    pub location: Location,
}

#[derive(Debug)]
pub(crate) enum Value {
    Text(String),
    Number {
        value: f64,
        /// The value where it is written as an integer.
        whole: Option<i128>,
    },
    Boolean(bool),
    Date,
    List(Vec<Node>),
    Table(Table),
}

/// The entries of a table, in the order of the text.
pub(crate) type Table = Vec<Entry>;

#[derive(Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub key_location: Location,
    pub node: Node,
}

impl Sources {
    pub(super) fn error(&self, location: Location, problem: Problem) -> SceneError {
        let Source { origin, text } = &self.0[location.source];
        SceneError::new(origin, text, location.start..location.end, problem)
    }

    /// The text at a location.
    pub(super) fn snippet(&self, location: Location) -> &str {
        self.0[location.source]
            .text
            .get(location.start..location.end)
            .unwrap_or_default()
    }
}

impl Location {
    /// Whether an override put it there.
    pub(super) fn is_override(self) -> bool {
        self.source > 0
    }

    /// A part of this one, in bytes from its start.
    pub(super) fn part(self, range: Range<usize>) -> Self {
        Self {
            start: self.start + range.start,
            end: self.start + range.end,
            ..self
        }
    }
}

impl Value {
    /// What kind of value it is, with its article.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Number { .. } => "a number",
            Self::Boolean(_) => "true or false",
            Self::Date => "a date or a time",
            Self::List(_) => "an array",
            Self::Table(_) => "a table",
        }
    }
}

/// Reads `text` and applies the overrides, each an argument `KEY=VALUE`, in their order.
pub(crate) fn read(
    text: &str,
    origin: &str,
    overrides: &[String],
) -> Result<(Sources, Node), SceneError> {
    let mut sources = vec![Source {
        origin: Origin::Text(origin.to_owned()),
        text: text.to_owned(),
    }];
    sources.extend(overrides.iter().map(|text| Source {
        origin: Origin::Override,
        text: text.clone(),
    }));
    let sources = Sources(sources);

    let location = Location::default();
    let table = DeTable::parse(text).map_err(|error| syntax_error(&sources, &error, location))?;
    let mut table = convert_table(table.get_ref(), location);
    for (index, text) in overrides.iter().enumerate() {
        let start = Location {
            source: index + 1,
            start: 0,
            end: text.len(),
        };
        overrides::apply(&sources, &mut table, text, start)?;
    }
    let value = Value::Table(table);
    Ok((sources, Node { value, location }))
}

/// Reads one value, which stands at `location`.
pub(super) fn read_value(
    sources: &Sources,
    text: &str,
    location: Location,
) -> Result<Node, SceneError> {
    let value = DeValue::parse(text).map_err(|error| syntax_error(sources, &error, location))?;
    let value = convert(value.get_ref(), location);
    Ok(Node { value, location })
}

/// `base` is where the text begins that `error` counts from.
fn syntax_error(sources: &Sources, error: &toml::de::Error, base: Location) -> SceneError {
    let location = error.span().map_or(base, |span| base.part(span));
    // The parser's message may hold the line break of a list of words.
    let message = error.message().trim().replace('\n', "; ");
    sources.error(location, Problem::Syntax { message })
}

/// The depth of a document is bounded by the parser, so the recursion is too.
fn convert(value: &DeValue<'_>, base: Location) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(integer) => {
            let whole = i128::from_str_radix(integer.as_str(), integer.radix()).ok();
            // More digits than 128 bits hold are still a number, of any table of decimal digits.
            let value = whole.map_or_else(|| float(integer.as_str()), |whole| whole as f64);
            Value::Number { value, whole }
        }
        DeValue::Float(number) => Value::Number {
            value: float(number.as_str()),
            whole: None,
        },
        DeValue::Boolean(value) => Value::Boolean(*value),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(items) => Value::List(
            items
                .iter()
                .map(|item| Node {
                    value: convert(item.get_ref(), base),
                    location: base.part(item.span()),
                })
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(convert_table(table, base)),
    }
}

fn convert_table(table: &DeTable<'_>, base: Location) -> Table {
    let mut entries: Table = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().clone().into_owned(),
            key_location: base.part(key.span()),
            node: Node {
                value: convert(value.get_ref(), base),
                location: base.part(value.span()),
            },
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_location.start);
    entries
}

/// NaN, which every check of a value refuses, where it is none.
fn float(text: &str) -> f64 {
    text.parse().unwrap_or(f64::NAN)
}
