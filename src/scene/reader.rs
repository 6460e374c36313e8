//! Typed access to the tables of a document: each value is checked where it is read, and an error
//! knows its key and its place.

use std::ops::RangeInclusive;

use super::document::{Entry, Location, Node, Sources, Value};
use super::error::{Problem, SceneError};
use super::parameter::{Choice, Parameter, SEED, SEEDS, Value as _, one_of};
use super::suggest::nearest;
use super::tables::table_with;

/// What a number must be; it must be finite in any case.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    /// In words.
    pub words: &'static str,
    holds: fn(f64) -> bool,
}

pub(crate) const FINITE: Bound = Bound {
    words: "a finite number",
    holds: |_| true,
};
pub(super) const POSITIVE: Bound = Bound {
    words: "a finite number > 0",
    holds: |v| v > 0.0,
};
pub(super) const NOT_NEGATIVE: Bound = Bound {
    words: "a finite number ≥ 0",
    holds: |v| v >= 0.0,
};

impl Bound {
    /// A bound of a parameter's own; `words` say what `holds` tests.
    pub(super) const fn new(words: &'static str, holds: fn(f64) -> bool) -> Self {
        Self { words, holds }
    }
}

/// A table of the document. One that is absent reads like one without keys.
#[derive(Clone)]
pub(crate) struct Reader<'a> {
    sources: &'a Sources,
    /// Its dotted key.
    pub path: String,
    entries: Vec<&'a Entry>,
    location: Location,
}

/// A value of the document.
#[derive(Clone)]
pub(crate) struct Field<'a> {
    sources: &'a Sources,
    /// The dotted key.
    pub path: String,
    key_location: Location,
    node: &'a Node,
}

impl<'a> Reader<'a> {
    /// The top level of a document.
    pub(crate) fn top(sources: &'a Sources, node: &'a Node) -> Self {
        let entries: &[Entry] = if let Value::Table(entries) = &node.value {
            entries
        } else {
            &[]
        };
        Self {
            sources,
            path: String::new(),
            entries: entries.iter().collect(),
            location: node.location,
        }
    }

    pub(crate) fn get(&self, key: &str) -> Option<Field<'a>> {
        let entry = self.entries.iter().find(|entry| entry.key == key)?;
        Some(self.field(entry))
    }

    fn field(&self, entry: &'a Entry) -> Field<'a> {
        Field {
            sources: self.sources,
            path: join(&self.path, &entry.key),
            key_location: entry.key_location,
            node: &entry.node,
        }
    }

    /// A key that `owner` cannot do without.
    pub(crate) fn require(&self, key: &'static str, owner: &str) -> Result<Field<'a>, SceneError> {
        let field = self.get(key);
        field.ok_or_else(|| self.missing(key, owner.to_owned()))
    }

    /// The error that `owner` lacks a key.
    pub(super) fn missing(&self, key: &'static str, owner: String) -> SceneError {
        self.error(Problem::MissingKey { key, owner })
    }

    /// An error about the whole table.
    pub(crate) fn error(&self, problem: Problem) -> SceneError {
        self.sources.error(self.location, problem)
    }

    /// Reads on as if a key were not there.
    pub(super) fn pass_over(&mut self, key: &str) {
        self.entries.retain(|entry| entry.key != key);
    }

    /// Of two keys that exclude each other, the one that an override gave takes the place of the other. Whether
    /// both were there.
    pub(super) fn choose(&mut self, keys: [&str; 2], problem: Problem) -> Result<bool, SceneError> {
        let [Some(first), Some(second)] = keys.map(|key| self.get(key)) else {
            return Ok(false);
        };
        match (first.is_override(), second.is_override()) {
            (true, false) => self.pass_over(keys[1]),
            (false, true) => self.pass_over(keys[0]),
            _ => return Err(first.key_error(problem)),
        }
        Ok(true)
    }

    /// Refuses keys that do not go with the kind of the table; `owner` says how the user chose it. Where an
    /// override did, keys that went with the former kind are passed over.
    pub(super) fn allow_kind(
        &self,
        parameters: &[Parameter],
        [kind, owner]: [&str; 2],
        is_overridden: bool,
    ) -> Result<(), SceneError> {
        let is_allowed = |it: &&Parameter| it.kinds.is_empty() || it.kinds.contains(&kind);
        let allowed = parameters.iter().filter(is_allowed).map(|it| it.key);
        let allowed: Vec<&'static str> = allowed.collect();
        for (key, field) in self.fields() {
            let mut of_kinds = parameters.iter().filter(|it| !it.kinds.is_empty());
            if allowed.contains(&key) {
                continue;
            } else if !of_kinds.any(|it| it.key == key) {
                self.allow(&allowed)?;
            } else if !is_overridden || field.is_override() {
                return Err(field.key_error(Problem::MisplacedKey {
                    key: key.to_owned(),
                    owner: owner.to_owned(),
                    allowed,
                }));
            }
        }
        Ok(())
    }

    /// The table of this name, where it is there.
    pub(super) fn present(&self, key: &str) -> Result<Option<Reader<'a>>, SceneError> {
        self.get(key).map(|field| field.table()).transpose()
    }

    /// The table of this name, as if it were there.
    pub(super) fn table(&self, key: &str) -> Result<Reader<'a>, SceneError> {
        Ok(self.present(key)?.unwrap_or_else(|| Reader {
            sources: self.sources,
            path: join(&self.path, key),
            entries: Vec::new(),
            location: self.location,
        }))
    }

    /// Its keys and values, in the order of the text.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a str, Field<'a>)> {
        self.entries
            .iter()
            .map(|&entry| (entry.key.as_str(), self.field(entry)))
    }

    /// Refuses every key that is not among `allowed`.
    pub(crate) fn allow(&self, allowed: &[&'static str]) -> Result<(), SceneError> {
        match self.fields().find(|(key, _)| !allowed.contains(key)) {
            Some((key, field)) => Err(field.unknown_key(key, &self.path, allowed)),
            None => Ok(()),
        }
    }

    pub(super) fn number(&self, key: &str, default: f64, bound: Bound) -> Result<f64, SceneError> {
        self.get(key)
            .map_or(Ok(default), |field| field.number(bound))
    }

    pub(super) fn vector(&self, key: &str, default: [f64; 2]) -> Result<[f64; 2], SceneError> {
        self.get(key)
            .map_or(Ok(default), |field| field.vector(FINITE))
    }

    pub(super) fn choice<T: Choice>(&self, key: &str, default: T) -> Result<T, SceneError> {
        self.get(key)
            .map_or(Ok(default), |field| field.choice(T::NAMES))
    }

    pub(super) fn seed(&self) -> Result<u64, SceneError> {
        self.get("seed")
            .map_or(Ok(SEED), |field| field.integer(&SEEDS))
    }
}

impl<'a> Field<'a> {
    pub(crate) fn value(&self) -> &'a Value {
        &self.node.value
    }

    /// The value as it is written.
    pub(crate) fn toml(&self) -> &'a str {
        self.sources.snippet(self.node.location)
    }

    /// Whether an override gave it.
    pub(super) fn is_override(&self) -> bool {
        self.key_location.is_override()
    }

    /// An error about the value.
    pub(crate) fn error(&self, problem: Problem) -> SceneError {
        self.sources.error(self.node.location, problem)
    }

    /// An error about the key.
    pub(crate) fn key_error(&self, problem: Problem) -> SceneError {
        self.sources.error(self.key_location, problem)
    }

    /// An error about a part of a string, in bytes of the string.
    pub(super) fn error_within(
        &self,
        text: &str,
        range: std::ops::Range<usize>,
        problem: Problem,
    ) -> SceneError {
        // Where the string is written with escapes, its parts are elsewhere: point to all of it.
        let location = match self.sources.snippet(self.node.location).find(text) {
            Some(start) => self
                .node
                .location
                .part(start + range.start..start + range.end),
            None => self.node.location,
        };
        self.sources.error(location, problem)
    }

    pub(crate) fn unknown_key(
        &self,
        key: &str,
        table: &str,
        allowed: &[&'static str],
    ) -> SceneError {
        let near = nearest(key, allowed.iter().copied());
        let elsewhere = if near.is_some() {
            None
        } else {
            table_with(key)
        };
        self.key_error(Problem::UnknownKey {
            key: key.to_owned(),
            table: table.to_owned(),
            near,
            elsewhere: elsewhere.filter(|elsewhere| *elsewhere != table),
            allowed: allowed.to_vec(),
        })
    }

    /// An error about the value's type.
    pub(crate) fn wrong_type(&self, expected: impl Into<String>) -> SceneError {
        self.error(Problem::WrongType {
            key: self.path.clone(),
            expected: expected.into(),
            found: self.node.value.kind(),
        })
    }

    /// An error about a value of the right type.
    pub(crate) fn out_of_range(&self, allowed: impl Into<String>) -> SceneError {
        self.error(Problem::OutOfRange {
            key: self.path.clone(),
            allowed: allowed.into(),
            found: self.sources.snippet(self.node.location).to_owned(),
        })
    }

    pub(crate) fn number(&self, bound: Bound) -> Result<f64, SceneError> {
        match self.node.value {
            Value::Number { value, .. } if value.is_finite() && (bound.holds)(value) => Ok(value),
            Value::Number { .. } => Err(self.out_of_range(bound.words)),
            _ => Err(self.wrong_type(bound.words)),
        }
    }

    pub(crate) fn integer(&self, range: &RangeInclusive<u64>) -> Result<u64, SceneError> {
        let words = u64::words(range);
        let Value::Number { whole, .. } = self.node.value else {
            return Err(self.wrong_type(words));
        };
        whole
            .and_then(|whole| u64::try_from(whole).ok())
            .filter(|whole| range.contains(whole))
            .ok_or_else(|| self.out_of_range(words))
    }

    pub(super) fn vector(&self, bound: Bound) -> Result<[f64; 2], SceneError> {
        let words = <[f64; 2]>::words(&bound);
        let items = self.items(&words)?;
        let [first, second] = &items[..] else {
            return Err(self.out_of_range(words));
        };
        Ok([first.number(bound)?, second.number(bound)?])
    }

    pub(super) fn switch(&self) -> Result<bool, SceneError> {
        match self.node.value {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    pub(crate) fn text(&self) -> Result<&'a str, SceneError> {
        match &self.node.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.wrong_type("a string")),
        }
    }

    pub(crate) fn choice<T: Copy>(&self, names: &[(&'static str, T)]) -> Result<T, SceneError> {
        let allowed = || names.iter().map(|(name, _)| *name);
        let Value::Text(word) = &self.node.value else {
            return Err(self.wrong_type(one_of(names)));
        };
        names
            .iter()
            .find(|(name, _)| name == word)
            .map(|(_, meant)| *meant)
            .ok_or_else(|| {
                self.error(Problem::UnknownChoice {
                    key: self.path.clone(),
                    found: word.clone(),
                    near: nearest(word, allowed()),
                    allowed: allowed().collect(),
                })
            })
    }

    pub(crate) fn table(&self) -> Result<Reader<'a>, SceneError> {
        match &self.node.value {
            Value::Table(entries) => Ok(Reader {
                sources: self.sources,
                path: self.path.clone(),
                entries: entries.iter().collect(),
                location: self.key_location,
            }),
            _ => Err(self.wrong_type("a table")),
        }
    }

    pub(crate) fn items(&self, words: &str) -> Result<Vec<Field<'a>>, SceneError> {
        let Value::List(items) = &self.node.value else {
            return Err(self.wrong_type(words));
        };
        let field = |(index, node): (usize, &'a Node)| Field {
            sources: self.sources,
            path: format!("{}[{index}]", self.path),
            key_location: node.location,
            node,
        };
        Ok(items.iter().enumerate().map(field).collect())
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}
