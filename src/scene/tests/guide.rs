//! The guide has the tables that are declared.

use std::fmt::Write as _;

use crate::scene::{DefaultValue, Parameter, TableInfo, tables};

/// The guide's table of the parameters of a table.
fn markdown(table: &TableInfo) -> String {
    let TableInfo { name, words, .. } = table;
    let rule = match (table.is_effect(), table.needs_director) {
        (_, true) => " An effect, which needs `[nematic]`.",
        (true, false) => " An effect.",
        (false, false) => "",
    };
    let mut text = format!(
        "**`[{name}]`** {words}{rule}\n\n| key | what it is | default | allowed |\n| --- | --- | --- | --- |\n"
    );
    for parameter in &table.parameters {
        let Parameter { key, words, .. } = parameter;
        // Not for the key that chooses the kind.
        let is_choice = parameter.kinds == [*key] || parameter.kinds.len() > 5;
        let kinds = match parameter.kinds {
            [] => String::new(),
            _ if is_choice => String::new(),
            kinds => format!("`\"{}\"`: ", kinds.join("\"`, `\"")),
        };
        let words = words.trim_end_matches('.');
        let allowed = &parameter.allowed;
        let default = match &parameter.default {
            DefaultValue::Value(text) => format!("`{text}`"),
            DefaultValue::Absent => "none".to_owned(),
            DefaultValue::Required => "must be given".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| `{key}` | {kinds}{words} | {default} | {allowed} |");
    }
    text
}

#[test]
fn the_guide_has_the_table_of_every_table() {
    let mut missing = String::new();
    for table in tables() {
        let guide = match table.name {
            "tension" => include_str!("../../../docs/guide/effects.md"),
            _ => include_str!("../../../docs/guide/scenes.md"),
        };
        let text = markdown(&table);
        if !guide.contains(&text) {
            missing += &format!("{text}\n");
        }
    }
    assert!(missing.is_empty(), "put this there:\n{missing}");
}
