//! What in a run's folder is not as the run has left it.

use super::super::folder::{FIELDS, SERIES};
use super::super::provenance::changed_inputs;
use super::super::summary::Status;
use super::{RecordedSummary, read_table};
use std::fs;
use std::path::Path;

/// The tables of a run.
const TABLES: [&str; 3] = ["history.csv", "ledger.csv", "shape.csv"];

/// What is missing in the folder of a run or was changed there, by `run.json` and the list of the snapshots, a sentence each:
/// inputs with another SHA-256, tables that end too early or have gaps, fields. A file that cannot be read is passed over.
pub fn doubts(folder: &Path, summary: &RecordedSummary) -> Vec<String> {
    let changed = changed_inputs(folder, &summary.inputs).unwrap_or_default();
    let changed = changed.into_iter().map(|input| {
        format!("{input} is not the file that the run was computed from: its SHA-256 is another one than in run.json")
    });
    let tables = TABLES.into_iter();
    let tables = tables.filter_map(|table| doubt_of_table(folder, table, summary));
    let listed = snapshots_listed(folder).into_iter();
    let listed = listed.map(|file| format!("{FIELDS}/{file}"));
    let last = (summary.status == Status::Done).then(|| "final.vtu".to_owned());
    let gone = listed
        .chain(last)
        .filter(|file| !folder.join(file).exists());
    let gone = gone.map(|file| format!("{file} is missing"));
    changed.chain(tables).chain(gone).collect()
}

/// What is wrong with the rows of a table. (The steps between two rows may change where a run is resumed.)
fn doubt_of_table(folder: &Path, table: &str, summary: &RecordedSummary) -> Option<String> {
    let path = folder.join(table);
    if !path.exists() {
        return Some(format!("{table} is missing"));
    }
    let columns = read_table(&path).ok()?;
    let steps = columns.column("step").unwrap_or_default();
    let (end, every) = (summary.steps, summary.every.max(1));
    // The law is one of steps: the ledger has no row of the initial state.
    let last = steps.last().map_or(0, |step| *step as u64);
    let missing = end.saturating_sub(last);
    if missing >= every || (missing > 0 && summary.status == Status::Done) {
        return Some(format!(
            "{table} ends with step {last}, and run.json has {end} steps"
        ));
    }
    let is_gap = |pair: &&[f64]| summary.sessions.len() <= 1 && pair[1] - pair[0] > every as f64;
    let gap = steps.windows(2).find(is_gap)?;
    Some(format!(
        "{table} has no rows between the steps {} and {}, and run.json says that every {every} steps have one",
        gap[0], gap[1]
    ))
}

/// The files of `fields/fields.pvd`; none where that cannot be read.
fn snapshots_listed(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join(FIELDS).join(SERIES)).unwrap_or_default();
    let list = roxmltree::Document::parse(&text);
    let files = list.iter().flat_map(|list| list.descendants());
    let files = files.filter_map(|node| node.attribute("file"));
    files.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of a run's folder.
    type Damage = fn(&Path);

    fn truncate(path: &Path, keep: impl Fn(usize) -> bool) {
        let text = fs::read_to_string(path).expect("it is there");
        let lines = text.lines().enumerate();
        let kept: Vec<&str> = lines
            .filter(|(row, _)| keep(*row))
            .map(|(_, line)| line)
            .collect();
        fs::write(path, kept.join("\n") + "\n").expect("it is written");
    }

    #[test]
    fn each_damage_is_named() {
        let summary: RecordedSummary = serde_json::from_str(
            r#"{"scene": "a", "status": "done", "error": null, "started": "", "ended": null, "steps": 4, "every": 1,
                "inputs": [{"path": "scene.toml",
                            "sha256": "ca978112ca1bbdcafac231b39a23dc4da786eff8147c4e72b9807785afee48bb"}]}"#,
        )
        .expect("a summary");
        let cases: [(Damage, &str); 8] = [
            (|_| (), ""),
            (
                |at| fs::write(at.join("scene.toml"), "b").expect("written"),
                "scene.toml is not",
            ),
            (
                |at| truncate(&at.join("history.csv"), |row| row < 3),
                "history.csv ends with step 1",
            ),
            (
                |at| truncate(&at.join("shape.csv"), |row| row != 3),
                "between the steps 1 and 3",
            ),
            (
                |at| fs::remove_file(at.join("ledger.csv")).expect("gone"),
                "ledger.csv is missing",
            ),
            (
                |at| truncate(&at.join("ledger.csv"), |row| row < 4),
                "ledger.csv ends with step 3",
            ),
            (
                |at| fs::remove_file(at.join("fields/step-2.vtu")).expect("gone"),
                "fields/step-2.vtu is missing",
            ),
            (
                |at| fs::remove_file(at.join("final.vtu")).expect("gone"),
                "final.vtu is missing",
            ),
        ];
        for (damage, words) in cases {
            let folder = tempfile::tempdir().expect("a folder");
            let at = folder.path();
            let write = |name: &str, text: &str| fs::write(at.join(name), text).expect("written");
            fs::create_dir(at.join(FIELDS)).expect("made");
            write("scene.toml", "a");
            for table in ["history.csv", "shape.csv"] {
                write(table, "step,t\n0,0\n1,1\n2,2\n3,3\n4,4\n");
            }
            write("ledger.csv", "step,t\n1,1\n2,2\n3,3\n4,4\n");
            write(
                "fields/fields.pvd",
                "<a><DataSet file=\"step-0.vtu\"/><DataSet file=\"step-2.vtu\"/></a>",
            );
            for file in ["fields/step-0.vtu", "fields/step-2.vtu", "final.vtu"] {
                write(file, "");
            }
            damage(at);
            let found = doubts(at, &summary).join("\n");
            assert_eq!(found.is_empty(), words.is_empty(), "{found}");
            assert!(
                found.contains(words) && found.lines().count() <= 1,
                "{found}"
            );
        }
    }
}
