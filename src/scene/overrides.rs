//! Arguments `--set KEY=VALUE`.
//!
//! KEY is dotted (`time.step`), VALUE is TOML; a bare word that is not TOML is a string
//! (`anchoring.kind=parallel`). The value takes the place of the one in the scene: a table that is
//! not there is made, a whole table can be given (`vesicle={shape="circle",radius=0.25}`), and
//! `area=false`, `field=false` and the like take the table of that effect away.

use super::document::{Entry, Location, Node, Sources, Table, Value, read_value};
use super::error::{Problem, SceneError};
use super::tables::is_optional;

/// Deeper than any key of a scene.
const DEEPEST_KEY: usize = 8;

/// Applies the override `text`, which stands at `location`.
pub(super) fn apply(
    sources: &Sources,
    table: &mut Table,
    text: &str,
    location: Location,
) -> Result<(), SceneError> {
    let malformed =
        |range, reason| Err(sources.error(location.part(range), Problem::Override { reason }));
    let Some(equals) = text.find('=') else {
        return malformed(0..text.len(), "there is no '='");
    };
    let (key, value) = (&text[..equals], &text[equals + 1..]);
    if value.trim().is_empty() {
        return malformed(0..text.len(), "the value is missing");
    }
    let mut path = Vec::new();
    let mut start = 0;
    for word in key.split('.') {
        let trimmed = word.trim();
        let first = start + (word.len() - word.trim_start().len());
        let range = first..first + trimmed.len();
        if trimmed.is_empty() {
            return malformed(0..key.len(), "the key is missing, or a part of it");
        }
        path.push((trimmed, location.part(range)));
        start += word.len() + 1;
    }
    if path.len() > DEEPEST_KEY {
        return malformed(
            0..key.len(),
            "the key has more parts than any key of a scene",
        );
    }

    let first = equals + 1 + (value.len() - value.trim_start().len());
    let value = value.trim();
    if let [(name, _)] = path[..]
        && is_optional(name)
        && value == "false"
    {
        table.retain(|entry| entry.key != name);
        return Ok(());
    }
    let value = parse_value(sources, value, location.part(first..first + value.len()))?;
    set(sources, table, &path, value)
}

/// TOML, or else a string, unless it begins as only TOML does.
fn parse_value(sources: &Sources, text: &str, location: Location) -> Result<Node, SceneError> {
    match read_value(sources, text, location) {
        Err(_) if !text.starts_with(['"', '\'', '[', '{', '#']) => Ok(Node {
            value: Value::Text(text.to_owned()),
            location,
        }),
        result => result,
    }
}

/// Puts `node` where `path` leads, making the tables on the way.
fn set(
    sources: &Sources,
    mut table: &mut Table,
    path: &[(&str, Location)],
    node: Node,
) -> Result<(), SceneError> {
    let Some(((last, last_location), way)) = path.split_last() else {
        return Ok(());
    };
    for (depth, (word, location)) in way.iter().enumerate() {
        let found = table.iter().position(|entry| entry.key == *word);
        let index = found.unwrap_or(table.len());
        if found.is_none() {
            let (value, location) = (Value::Table(Table::new()), *location);
            table.push(Entry {
                key: (*word).to_owned(),
                key_location: location,
                node: Node { value, location },
            });
        }
        match &mut table[index].node.value {
            Value::Table(inner) => table = inner,
            other => {
                let words: Vec<&str> = path[..=depth].iter().map(|(word, _)| *word).collect();
                let problem = Problem::WrongType {
                    key: words.join("."),
                    expected: "a table, to hold this key".to_owned(),
                    found: other.kind(),
                };
                return Err(sources.error(*location, problem));
            }
        }
    }
    table.retain(|entry| entry.key != *last);
    table.push(Entry {
        key: (*last).to_owned(),
        key_location: *last_location,
        node,
    });
    Ok(())
}
