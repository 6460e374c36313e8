//! What goes to the standard output and what to the standard error, of every command; and what `--quiet` leaves.

use super::cli::{folder_with_scene, stderr, stdout, vesica};
use std::fs;
use std::path::Path;

/// A command of which the standard output has a part that says what came out.
struct Case {
    arguments: &'static [&'static str],
    result: &'static str,
    /// Whether that is printed with `--quiet` too: where it is what the command is asked for. It is not where the result is
    /// in files and this says where.
    is_asked_for: bool,
    /// A part of the text on the standard error; `None`: there is no text.
    told: Option<&'static str>,
}

const fn asked(
    arguments: &'static [&'static str],
    result: &'static str,
    told: Option<&'static str>,
) -> Case {
    Case {
        arguments,
        result,
        is_asked_for: true,
        told,
    }
}

const fn in_files(
    arguments: &'static [&'static str],
    result: &'static str,
    told: Option<&'static str>,
) -> Case {
    Case {
        arguments,
        result,
        is_asked_for: false,
        told,
    }
}

/// Takes a minute, and has tests of its own.
const TRIED_ELSEWHERE: &str = "accuracy";

/// In this order: the later ones read what the earlier ones leave.
const CASES: &[Case] = &[
    asked(&["presets"], "case3-quick", None),
    asked(&["preset", "case3"], "interface_width", None),
    asked(&["completions", "bash"], "VESICA_COMPLETE", None),
    asked(&["man"], ".TH vesica 1", None),
    asked(&["check", "warned.toml"], "ok, 81 nodes", Some("warning: ")),
    asked(
        &["check", "warned.toml", "--json"],
        "\"verdict\": \"ok\"",
        None,
    ),
    asked(
        &["effects", "small.toml", "--after", "0", "--steps", "1"],
        "all effects",
        None,
    ),
    asked(&["shape", "circle.toml"], "reduced area", Some("warning: ")),
    in_files(
        &["run", "warned.toml", "--out", "a", "--force"],
        "3 steps",
        Some("warning: "),
    ),
    in_files(
        &["run", "a", "--resume", "--steps", "4"],
        "4 steps",
        Some("goes on from step 3"),
    ),
    asked(&["verify", "a"], "the same, bit for bit", None),
    in_files(
        &["export", "a", "--no-figures", "--force"],
        "in a.zip",
        None,
    ),
    in_files(
        &["figures", "a", "--out", "f", "--force", "--width", "400"],
        "figures, each as PNG",
        None,
    ),
    asked(
        &["sweep", "plan.toml", "--list", "--quick"],
        "2 points",
        None,
    ),
    asked(
        &["sweep", "slurm", "plan.toml", "--out", "s", "--dry-run"],
        "sbatch",
        None,
    ),
    asked(&["sweep", "rerun", "s"], "sweep point", None),
    asked(&["sweep", "status", "s"], "2 points: ", None),
    asked(&["sweep", "status", "s", "--json"], "\"counts\"", None),
    in_files(&["sweep", "point", "s", "1"], "", Some(": done")),
    in_files(
        &["sweep", "s", "--resume"],
        "the table: ",
        Some("1 point done before"),
    ),
    asked(&["sweep", "table", "s"], "E_total", None),
    in_files(
        &["sweep", "figure", "s", "--column", "E_total", "--force"],
        "each as PNG",
        None,
    ),
];

fn folder() -> tempfile::TempDir {
    let folder = folder_with_scene();
    let path = folder.path();
    let small = fs::read_to_string(path.join("small.toml")).expect("a scene");
    fs::write(
        path.join("warned.toml"),
        format!("{small}[area]\ntarget = 2.5\n"),
    )
    .expect("it is written");
    fs::write(
        path.join("circle.toml"),
        "mesh.cells = 24\nmembrane.interface_width = 0.05\n[area]\ntarget = 1.1\n",
    )
    .expect("it is written");
    let plan = "scene = 'small.toml'\n[vary]\n'nematic.weight' = [1.0, 2.0]\n";
    fs::write(path.join("plan.toml"), plan).expect("it is written");
    folder
}

/// The commands that the help lists, but for `help` itself.
fn commands(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let help = vesica(folder, &[arguments, &["--help"]].concat());
    let lines = stdout(&help)
        .lines()
        .skip_while(|line| *line != "Commands:");
    let names = lines.skip(1).take_while(|line| line.starts_with("  "));
    let names = names.filter(|line| !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    names
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_command_has_results_and_words_in_their_places() {
    let (loud, quiet) = (folder(), folder());
    for case in CASES {
        let arguments = case.arguments;
        let output = vesica(loud.path(), arguments);
        let (result, told) = (stdout(&output), stderr(&output));
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
        assert!(result.contains(case.result), "{arguments:?}: {result}");
        assert_eq!(result.is_empty(), case.result.is_empty(), "{result}");
        for word in ["warning: ", "error: ", "note: "] {
            let mut lines = result.lines();
            assert!(
                !lines.any(|line| line.starts_with(word)),
                "{arguments:?}: {result}"
            );
        }
        assert!(!result.contains('\u{1b}'), "{arguments:?}: {result}");
        match case.told {
            Some(part) => assert!(told.contains(part), "{arguments:?}: {told}"),
            None => assert_eq!(told, "", "{arguments:?}"),
        }

        let arguments = [arguments, &["--quiet"]].concat();
        let output = vesica(quiet.path(), &arguments);
        let (result, told) = (stdout(&output), stderr(&output));
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
        assert_eq!(told, "", "{arguments:?}");
        match case.is_asked_for {
            true => assert!(result.contains(case.result), "{arguments:?}: {result}"),
            false => assert_eq!(result, "", "{arguments:?}"),
        }
    }
    // Every command was tried.
    let path = loud.path();
    let all = commands(path, &[]);
    assert!(all.len() > 10, "{all:?}");
    for command in all {
        let is_tried = CASES.iter().any(|case| case.arguments[0] == command);
        assert!(
            is_tried || command == TRIED_ELSEWHERE,
            "{command} is not tried"
        );
    }
    for command in commands(path, &["sweep"]) {
        let is_tried = |case: &Case| case.arguments[0] == "sweep" && case.arguments[1] == command;
        assert!(CASES.iter().any(is_tried), "sweep {command} is not tried");
    }
}

#[test]
fn errors_are_told_by_quiet_commands_too() {
    let folder = folder();
    let path = folder.path();
    for (arguments, status) in [
        (&["run", "nowhere.toml"][..], 2),
        (
            &["run", "small.toml", "--set", "solver.law_tolerance=1e-300"],
            1,
        ),
        (&["check", "nowhere.toml"], 2),
        (&["effects", "nowhere.toml"], 2),
        (&["accuracy", "nowhere.toml"], 2),
        (&["shape", "nowhere.toml"], 2),
        (&["figures", "nowhere.toml"], 2),
        (&["verify", "nowhere"], 2),
        (&["export", "nowhere"], 2),
        (&["preset", "nowhere"], 2),
        (&["sweep", "nowhere.toml"], 2),
        (&["sweep", "status", "nowhere"], 2),
        (&["man", "--out", "small.toml/man"], 1),
    ] {
        let output = vesica(path, &[arguments, &["--quiet"]].concat());
        assert_eq!(
            output.status.code(),
            Some(status),
            "{arguments:?}: {}",
            stderr(&output)
        );
        assert_eq!(stdout(&output), "", "{arguments:?}");
        let told = stderr(&output);
        assert!(told.starts_with("error: "), "{arguments:?}: {told}");
    }
}
