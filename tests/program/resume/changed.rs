//! Tables and fields of a run that somebody has changed before it goes on.

use super::{folder_with_scene, record, summary, vesica};
use std::fs;
use std::path::{Path, PathBuf};

/// Where the run stands whose tables and fields are changed in the tests that follow.
struct Changed {
    folder: tempfile::TempDir,
}

impl Changed {
    const RUN: [&str; 6] = ["run", "small.toml", "--snapshots", "5", "--steps", "40"];

    fn new() -> Self {
        let folder = folder_with_scene();
        let whole = [&Self::RUN[..], &["--out", "whole"]].concat();
        vesica(folder.path(), &whole, 0);
        Self { folder }
    }

    /// Begins the run and ends it at half its time, changes something of it, goes on with it, and gives what
    /// was told.
    fn go_on_after(&self, change: impl FnOnce(&Path)) -> String {
        let path = self.folder.path();
        let run = path.join("a");
        let _ = fs::remove_dir_all(&run);
        // The snapshots of a run of 40 steps, up to step 20.
        let half = [
            "run",
            "small.toml",
            "--snapshots",
            "3",
            "--steps",
            "20",
            "--out",
            "a",
        ];
        vesica(path, &half, 0);
        change(&run);
        let more = ["--out", "a", "--resume", "--quiet"];
        let told = vesica(path, &[&Self::RUN[..], &more].concat(), 0);
        let event = summary(&run)["events"][0]["text"].to_string();
        for line in told.lines() {
            let words = line.trim_start_matches("warning: ");
            let words = words.replace('\\', "\\\\").replace('"', "\\\"");
            assert!(event.contains(&words), "{words}: {event}");
        }
        // Whatever was changed, no step is lost, and nobody is told to replace the run.
        assert_eq!(summary(&run)["events"][0]["step"], 20, "{told}");
        assert!(!told.contains("--force"), "{told}");
        told
    }

    /// That the tables are those of the run that nobody has changed.
    #[track_caller]
    fn assert_tables(&self, but_for: &[&str]) {
        let [found, wanted] = ["a", "whole"].map(|name| record(&self.folder.path().join(name)));
        for table in ["history.csv", "ledger.csv", "shape.csv", "final.vtu"] {
            let is_same = found[Path::new(table)] == wanted[Path::new(table)];
            assert_eq!(is_same, !but_for.contains(&table), "{table}");
        }
    }
}

fn rewrite(path: &Path, change: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(path).expect("it is there");
    fs::write(path, change(text)).expect("it can be written");
}

/// What a spreadsheet or an editor makes of a table is read, and brought back bit for bit.
#[test]
fn tables_that_another_program_has_rewritten_are_brought_back() {
    let changed = Changed::new();
    let windows: fn(String) -> String = |text| format!("\u{feff}{}", text.replace('\n', "\r\n"));
    let quoted: fn(String) -> String = |text| {
        let quote = |line: &str| format!("\"{}\"\n", line.replace(',', "\",\""));
        text.lines().map(quote).collect()
    };
    let german: fn(String) -> String = |text| text.replace(',', ";").replace('.', ",");
    let of_excel: fn(String) -> String = |text| format!("sep=,\r\n{text}");
    let blank: fn(String) -> String = |text| text.replace('\n', ",,\n") + ",,,\n\n\n";
    let cut: fn(String) -> String = |text| text.trim_end().to_owned();
    let backward: fn(String) -> String = |text| {
        let (header, rows) = text.split_once('\n').expect("a header");
        let mut rows: Vec<&str> = rows.lines().collect();
        rows.reverse();
        format!("{header}\n{}\n", rows.join("\n"))
    };
    let others: fn(String) -> String = |text| {
        let add = |line: &str| format!("note,{line}\n");
        text.lines().map(add).collect()
    };
    let a_blank: fn(String) -> String = |text| text.replacen("\n5,", "\n5, ", 1);
    let commas: fn(String) -> String = |text| text.replacen("\n6,", ",,,\n,,,,\n6,", 1);
    let digits: fn(String) -> String = |text| {
        let zeros = format!("\n{}5,", "0".repeat(5_000_000));
        text.replacen("\n5,", &zeros, 1)
    };
    let note: fn(String) -> String = |text| text.replacen("\n5,", "\nhere it moves\n5,", 1);
    for (change, words) in [
        (a_blank, "blanks around cells (line "),
        (commas, "empty cells at the ends of lines (line "),
        (digits, "numbers written in another way (line "),
        (
            note,
            "is left out: it has no step, and begins with \"here it moves\"",
        ),
        (windows, "byte-order mark, CR LF"),
        (quoted, "quoted cells"),
        (german, "other separators"),
        (of_excel, "other separators"),
        (blank, "blank lines"),
        (cut, "no end of the last line"),
        (backward, "rows in another order"),
        (others, "further ones"),
    ] {
        let told = changed.go_on_after(|run| {
            for table in ["history.csv", "ledger.csv", "shape.csv"] {
                rewrite(&run.join(table), change);
            }
        });
        for table in ["history.csv", "ledger.csv", "shape.csv"] {
            let line = told
                .lines()
                .find(|line| line.contains(table))
                .expect("it is told");
            assert!(
                line.contains(words) && line.contains("all its numbers"),
                "{line}"
            );
        }
        changed.assert_tables(&[]);
    }
    // Whoever looks at such a run sees it too.
    let history = changed.folder.path().join("a/history.csv");
    rewrite(&history, windows);
    let figures = ["figures", "a", "--out", "b", "--quiet"];
    vesica(changed.folder.path(), &figures[..4], 0);
}

/// What cannot be brought back is told with its place, and the run goes on.
#[test]
fn tables_that_are_damaged_are_told_and_the_run_goes_on() {
    let changed = Changed::new();
    let line = |number: usize, change: fn(&str) -> String| {
        move |text: String| -> String {
            let lines = text.lines().enumerate();
            lines
                .map(|(index, line)| match index + 1 == number {
                    true => change(line),
                    false => format!("{line}\n"),
                })
                .collect()
        }
    };
    let no_number = line(4, |line| line.replacen(",1e-6,", ",soon,", 1) + "\n");
    let missing = line(5, |_| String::new());
    let twice = line(6, |line| format!("{line}\n{line}\n"));
    let other = line(7, |line| line.replacen(",1e-6,", ",2e-6,", 1) + "\n");
    let nonsense = line(8, |_| "\u{1}nonsense\n".to_owned());
    let earlier = line(9, |line| {
        let (step, rest) = line.split_once(',').expect("cells");
        let (_, rest) = rest.split_once(',').expect("cells");
        format!("{step},1e-9,{rest}\n")
    });
    type Change<'a> = &'a dyn Fn(String) -> String;
    let changes: [(Change<'_>, &str, bool); 6] = [
        (
            &no_number,
            "line 4, column dt had \"soon\", which is no number",
            false,
        ),
        (
            &missing,
            "1 of 21 rows are missing, the first of them between the steps 2 and 4",
            false,
        ),
        (
            &twice,
            "line 7 is left out: step 4 stands in line 6 too",
            true,
        ),
        (
            &other,
            "line 7, column dt: the number is not the one that the run wrote",
            false,
        ),
        (&nonsense, "line 8 is left out: it has no step", false),
        (
            &earlier,
            "line 9 has t = 1e-9, after t = 6e-6 in line 8",
            false,
        ),
    ];
    for (change, words, is_whole) in changes {
        let told = changed.go_on_after(|run| rewrite(&run.join("history.csv"), change));
        assert!(told.contains(words), "{words}: {told}");
        let but_for: &[&str] = if is_whole { &[] } else { &["history.csv"] };
        changed.assert_tables(but_for);
        vesica(
            changed.folder.path(),
            &["figures", "a", "--out", "b", "--force"],
            0,
        );
    }
    let told = changed.go_on_after(|run| {
        fs::remove_file(run.join("ledger.csv")).expect("it is there");
    });
    assert!(told.contains("ledger.csv is gone, with 20 rows"), "{told}");
    changed.assert_tables(&["ledger.csv"]);
}

/// Whatever has become of the tables: the run goes on from where it was, and what is missing is told.
#[test]
fn tables_that_are_cut_or_rubbish_cost_no_step() {
    let changed = Changed::new();
    let cut = |path: &Path| {
        rewrite(path, |text| {
            let rows = text.lines().count() - 12;
            text.split_inclusive('\n').take(rows).collect()
        });
    };
    let half_a_row = |path: &Path| {
        rewrite(path, |text| text[..text.len() - 9].to_owned());
    };
    let empty = |path: &Path| rewrite(path, |_| String::new());
    let header = |path: &Path| {
        rewrite(path, |text| {
            let (header, _) = text.split_once('\n').expect("a header");
            header.to_owned() + "\n"
        });
    };
    let old_mac = |path: &Path| rewrite(path, |text| text.replace('\n', "\r"));
    let header_last = |path: &Path| {
        rewrite(path, |text| {
            let (header, rows) = text.split_once('\n').expect("a header");
            format!("{rows}{header}\n")
        });
    };
    let rubbish = |path: &Path| {
        fs::write(path, [0, 0x93, 0xff, b'\n', 7].repeat(999)).expect("it can be written");
    };
    let folder = |path: &Path| {
        fs::remove_file(path).expect("it is there");
        fs::create_dir(path).expect("it can be made");
    };
    type Change<'a> = &'a dyn Fn(&Path);
    let changes: [(Change<'_>, &str, bool); 8] = [
        (&cut, "rows are missing, the last ones", false),
        (&half_a_row, "is cut short, and left out", false),
        (&empty, "is empty", false),
        (&header, "rows are missing", false),
        (&old_mac, "CR at the ends of lines", true),
        (&header_last, "its header among the rows (line 22)", true),
        (&rubbish, "cannot be read", false),
        (&folder, "cannot be read (it is a folder)", false),
    ];
    let tables = ["history.csv", "ledger.csv", "shape.csv"];
    for (change, words, is_whole) in changes {
        let told = changed.go_on_after(|run| {
            tables.iter().for_each(|table| change(&run.join(table)));
        });
        for table in tables {
            let line = told.lines().find(|line| line.contains(table));
            let line = line.unwrap_or_else(|| panic!("{words}: {table} is not told: {told}"));
            // The ledger begins with step 1.
            let words = match table {
                "ledger.csv" => words.replace("22", "21"),
                _ => words.to_owned(),
            };
            assert!(line.contains(&words), "{words}: {line}");
        }
        let but_for: &[&str] = if is_whole { &[] } else { &tables };
        changed.assert_tables(but_for);
        let kept = changed.folder.path().join("a/history.csv.as-found");
        assert_eq!(kept.exists(), words.contains("cannot be read"), "{words}");
        // What comes is recorded.
        for table in tables {
            let text = fs::read_to_string(changed.folder.path().join("a").join(table));
            let text = text.expect("a table");
            let last = text.lines().last().expect("rows");
            assert!(last.starts_with("40,"), "{words}: {table}: {last}");
        }
    }
}

/// Fields that were removed to have room are told, and the list has those that are there.
#[test]
fn snapshots_that_are_gone_are_told_and_no_longer_listed() {
    let changed = Changed::new();
    let all = "step-0000000.vtu, step-0000010.vtu, step-0000020.vtu";
    let cut = |path: PathBuf| rewrite(&path, |text| text[..text.len() / 2].to_owned());
    type Change<'a> = &'a dyn Fn(&Path);
    let changes: [(Change<'_>, &str, &[u64]); 3] = [
        (
            &|fields| fs::remove_dir_all(fields).expect("it is there"),
            all,
            &[30, 40],
        ),
        (
            &|fields| fs::remove_file(fields.join("step-0000010.vtu")).expect("it is there"),
            "1 of 3 snapshots in a/fields are gone or damaged, and no longer listed in fields.pvd: \
             step-0000010.vtu",
            &[0, 20, 30, 40],
        ),
        (
            &|fields| cut(fields.join("step-0000000.vtu")),
            "step-0000000.vtu",
            &[10, 20, 30, 40],
        ),
    ];
    for (change, words, listed) in changes {
        let told = changed.go_on_after(|run| change(&run.join("fields")));
        assert!(told.contains(words), "{told}");
        changed.assert_tables(&[]);
        let run = changed.folder.path().join("a/fields");
        let list = fs::read_to_string(run.join("fields.pvd")).expect("the list");
        for step in [0, 10, 20, 30, 40] {
            let name = format!("step-{step:07}.vtu");
            assert_eq!(
                list.contains(&name),
                listed.contains(&step),
                "{name}: {list}"
            );
        }
    }
}
