//! `[[change]]`: parameters that take other values while a run goes.
//!
//! ```toml
//! [[change]]
//! at = 2e-4
//! over = 1e-4                       # a linear ramp, of numbers; without it the change is sudden
//! set = { "area.target" = 1.1 }
//! ```
//!
//! A change begins from the values that its parameters have at its time. Changes may be given in any order; those of the same
//! time follow each other as in the text. A change of a parameter that is still in a ramp ends that ramp.

use std::fmt;
use std::io;

use serde::{Deserialize, Serialize};

use super::document;
use super::error::{Problem, SceneError};
use super::nodal_file::Context;
use super::parameter::ParameterValue;
use super::reader::{Field, NOT_NEGATIVE, Reader};
use super::suggest::nearest;
use super::tables::{AnchoringKind, Scene, tables};
use super::timetable::Timetable;
use super::write::{number, quoted};

/// A change of some parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// When it begins. A step has it if its middle is not before: on a fixed grid that is from the nearest end of a step on,
    /// and chosen steps end there.
    pub at: f64,
    /// How long it takes to get there, on a straight line; 0: no time.
    pub over: f64,
    /// The parameters, and their values at the end of it.
    pub set: Vec<Assignment>,
}

/// A parameter and a value for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// The parameter with its table, such as `area.target`.
    pub key: String,
    /// The value.
    pub value: ParameterValue,
}

impl Assignment {
    /// The table and the key in it.
    pub(super) fn path(&self) -> [&str; 2] {
        let (table, key) = self.key.split_once('.').unwrap_or_default();
        [table, key]
    }
}

impl Change {
    /// Whether it takes time.
    pub fn is_ramp(&self) -> bool {
        self.over > 0.0
    }

    /// When it is done.
    pub fn end(&self) -> f64 {
        self.at + self.over
    }

    /// In short, for marks: `parallel`, `area.target = 1.1`.
    pub fn label(&self) -> String {
        let set = self.set.iter();
        let labels = set.map(|Assignment { key, value }| match value {
            ParameterValue::Text(word) if key == "anchoring.kind" => word.clone(),
            value => format!("{key} = {value}"),
        });
        labels.collect::<Vec<_>>().join(", ")
    }

    /// A change of the anchoring's kind.
    pub fn of_anchoring(kind: AnchoringKind) -> Vec<Assignment> {
        vec![Assignment {
            key: "anchoring.kind".to_owned(),
            value: ParameterValue::Text(kind.name().to_owned()),
        }]
    }

    /// The keys of its table.
    pub(super) fn to_toml(&self) -> String {
        let mut text = format!("at = {}\n", number(self.at));
        if self.is_ramp() {
            text += &format!("over = {}\n", number(self.over));
        }
        let set = self.set.iter();
        let set = set.map(|Assignment { key, value }| format!("{} = {value}", quoted(key)));
        text + &format!("set = {{ {} }}\n", set.collect::<Vec<_>>().join(", "))
    }
}

/// What it sets, for people: `area.target = 1.1 over 1e-4`.
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, Assignment { key, value }) in self.set.iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{key} = {value}")?;
        }
        match self.is_ramp() {
            true => write!(f, " over {}", number(self.over)),
            false => Ok(()),
        }
    }
}

impl Scene {
    /// The parameters that can change while a run goes, such as `area.target`.
    pub fn tunable_parameters() -> Vec<String> {
        let keys = tables().into_iter().flat_map(|table| {
            let parameters = table.parameters.into_iter();
            let tunable = parameters.filter(|parameter| parameter.is_tunable);
            tunable.map(move |parameter| format!("{}.{}", table.name, parameter.key))
        });
        keys.collect()
    }

    /// The kind of the anchoring at a time; none where there is no anchoring.
    pub fn anchoring_at(&self, t: f64) -> AnchoringKind {
        let kind = |scene: &Self| scene.anchoring.map(|anchoring| anchoring.kind);
        let kind = match self.changes.is_empty() {
            true => kind(self),
            false => kind(&Timetable::of(self).at(t)),
        };
        kind.unwrap_or(AnchoringKind::None)
    }

    /// The value that a parameter has at a time, after the changes that begin then.
    pub fn parameter_at(&self, t: f64, key: &str) -> Option<ParameterValue> {
        match self.changes.is_empty() {
            true => self.parameter(key),
            false => Timetable::of(self).at(t).parameter(key),
        }
    }

    /// Has changes hold from the start: those that `before` does not have.
    pub fn begin_with_changes(&mut self, before: &[Change]) {
        let (kept, made) = std::mem::take(&mut self.changes)
            .into_iter()
            .partition(|change| before.contains(change));
        self.changes = kept;
        let made: Vec<Change> = made;
        for assignment in made.iter().flat_map(|change| &change.set) {
            self.set_parameter(assignment.path(), &assignment.value);
        }
    }

    /// Adds a change, after those that begin at its time or before.
    ///
    /// # Errors
    /// As if it stood in the scene's text.
    pub fn add_change(&mut self, change: &Change) -> Result<(), SceneError> {
        let text = format!("[[change]]\n{}", change.to_toml());
        let (sources, node) = document::read(&text, "the change", &[])?;
        let mut no_files = |_: &str| Err(io::ErrorKind::NotFound.into());
        let mut context = Context {
            read: &mut no_files,
            mesh: self.mesh.clone(),
        };
        read_changes(&Reader::top(&sources, &node), self, &mut context)
    }
}

/// Adds the changes of a document to a scene that is read but for them.
pub(super) fn read_changes(
    top: &Reader<'_>,
    scene: &mut Scene,
    context: &mut Context<'_>,
) -> Result<(), SceneError> {
    let Some(list) = top.get("change") else {
        return Ok(());
    };
    let mut read = Vec::new();
    for item in list.items("an array of tables, [[change]]")? {
        read.push(read_change(&item, scene, context)?);
    }
    read.sort_by(|(a, _), (b, _)| a.at.total_cmp(&b.at));
    // A ramp needs a number to begin with, which changes before it may give.
    let mut timetable = Timetable::of(scene);
    for (change, fields) in &read {
        let before = timetable.at(change.at);
        for (Assignment { key, value }, field) in change.set.iter().zip(fields) {
            let begins = before.parameter(key);
            let reason = match (&begins, value) {
                _ if !change.is_ramp() => continue,
                (Some(ParameterValue::Number(_)), ParameterValue::Number(_)) => continue,
                (Some(ParameterValue::Number(_)), _) => "would not end at one",
                (Some(_), _) => "is not one before it",
                (None, _) => "has no value before it",
            };
            return Err(field.error(Problem::RampWithoutNumbers {
                key: key.clone(),
                over: change.over,
                reason,
            }));
        }
        timetable.insert(change.clone());
        let place = scene.changes.partition_point(|other| other.at <= change.at);
        scene.changes.insert(place, change.clone());
    }
    Ok(())
}

/// A change, and where its values stand.
fn read_change<'a>(
    item: &Field<'a>,
    scene: &Scene,
    context: &mut Context<'_>,
) -> Result<(Change, Vec<Field<'a>>), SceneError> {
    let table = item.table()?;
    table.allow(&["at", "over", "set"])?;
    let at = table.require("at", "[[change]]")?.number(NOT_NEGATIVE)?;
    let over = table.number("over", 0.0, NOT_NEGATIVE)?;
    let set = table.require("set", "[[change]]")?;
    let mut change = Change {
        at,
        over,
        set: Vec::new(),
    };
    let mut fields = Vec::new();
    for (key, field) in set.table()?.fields() {
        if !key.contains('.') && matches!(field.value(), document::Value::Table(_)) {
            for (inner, field) in field.table()?.fields() {
                let key = format!("{key}.{inner}");
                change
                    .set
                    .push(read_assignment(key, &field, scene, context)?);
                fields.push(field);
            }
        } else {
            let assignment = read_assignment(key.to_owned(), &field, scene, context)?;
            change.set.push(assignment);
            fields.push(field);
        }
    }
    let mut keys = change.set.iter().map(|assignment| &assignment.key);
    while let Some(key) = keys.next() {
        if keys.clone().any(|other| other == key) {
            let key = key.clone();
            return Err(set.error(Problem::Repeated { key }));
        }
    }
    match change.set.is_empty() {
        true => Err(set.out_of_range("a table such as { \"area.target\" = 1.1 }")),
        false => Ok((change, fields)),
    }
}

fn read_assignment(
    key: String,
    field: &Field<'_>,
    scene: &Scene,
    context: &mut Context<'_>,
) -> Result<Assignment, SceneError> {
    let allowed = Scene::tunable_parameters();
    if !allowed.contains(&key) {
        let exists = tables().iter().any(|table| {
            let mut keys = table.parameters.iter();
            keys.any(|parameter| key == format!("{}.{}", table.name, parameter.key))
        });
        let problem = if exists {
            Problem::FixedParameter { key, allowed }
        } else {
            let near = nearest(&key, allowed.iter().map(String::as_str));
            let near = near.map(ToOwned::to_owned);
            Problem::UnknownParameter { key, near, allowed }
        };
        return Err(field.key_error(problem));
    }
    let (table, name) = key.split_once('.').unwrap_or_default();
    let info = tables().into_iter().find(|info| info.name == table);
    let needs_director = table == "nematic" || info.is_some_and(|info| info.needs_director);
    if needs_director && scene.nematic.is_none() {
        return Err(field.key_error(Problem::ChangeWithoutDirector { key }));
    }
    match Scene::read_tunable([table, name], field, context)? {
        Some(value) => Ok(Assignment { key, value }),
        None => Err(field.error(Problem::ChangeToFile { key })),
    }
}
