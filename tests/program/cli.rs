//! The real binary: its exit statuses, its messages and the files it leaves.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Three steps on a small mesh.
const SCENE: &str = "\
name = \"Small\"
[mesh]
cells = 8
[time]
step = 1e-7
end = 3e-7
[membrane]
interface_width = 0.05
[nematic]
";

const COLUMNS: &str = "step,t,dt,E_total,E_bending,E_area,E_nematic,E_anchoring,A,B,law_residual,\
                       newton,krylov,wall";

pub fn vesica(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("vesica starts")
}

pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesica"));
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null());
    command
}

pub fn folder_with_scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("small.toml"), SCENE).expect("it can be written");
    folder
}

pub fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("text")
}

pub fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("text")
}

/// A mesh that takes seconds to make.
const FINE_MESH: &str = "mesh={ kind = 'delaunay', size = 0.004 }";

/// The run did what it should; gives what stands in `run.json`.
#[track_caller]
pub fn done(folder: &Path, output: &Output, run: &str) -> serde_json::Value {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    summary(folder, run)
}

#[track_caller]
fn summary(folder: &Path, run: &str) -> serde_json::Value {
    let text = fs::read_to_string(folder.join(run).join("run.json")).expect("run.json is there");
    serde_json::from_str(&text).expect("run.json is JSON")
}

/// The arguments or the scene are wrong: status 2, nothing on stdout, and stderr has `parts`.
#[track_caller]
fn refused(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let output = vesica(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    for part in parts {
        assert!(
            stderr(&output).contains(part),
            "no '{part}' in:\n{}",
            stderr(&output)
        );
    }
}

#[test]
fn a_run_leaves_its_folder_and_one_line() {
    let folder = folder_with_scene();
    let output = vesica(folder.path(), &["run", "small.toml"]);
    let run = done(folder.path(), &output, "runs/small");
    assert_eq!(run["status"], "done");
    assert_eq!(run["steps"], 3);
    assert_eq!(run["nodes"], 81);

    assert_eq!(stdout(&output).lines().count(), 1, "{}", stdout(&output));
    for part in ["Small", "3 steps", "t = 3e-7", "E_total = ", "runs/small"] {
        assert!(stdout(&output).contains(part), "{}", stdout(&output));
    }
    // No bar where there is no terminal.
    assert!(!stderr(&output).contains('\u{1b}'), "{}", stderr(&output));

    let runs = folder.path().join("runs/small");
    let history = fs::read_to_string(runs.join("history.csv")).expect("history.csv");
    assert_eq!(history.lines().next(), Some(COLUMNS));
    assert_eq!(history.lines().count(), 5);
    for line in history.lines().skip(1) {
        let cells: Vec<_> = line.split(',').collect();
        assert_eq!(cells.len(), 14, "{line}");
        // No area, no anchoring; a director there is.
        assert!(cells[5].is_empty() && cells[7].is_empty(), "{line}");
        assert!(cells[6].parse::<f64>().is_ok(), "{line}");
    }
    for file in [
        "scene.toml",
        "ledger.csv",
        "shape.csv",
        "final.vtu",
        "fields/fields.pvd",
    ] {
        assert!(runs.join(file).is_file(), "{file}");
    }
}

#[test]
fn the_recorded_scene_gives_the_same_run() {
    let folder = folder_with_scene();
    let path = folder.path();
    let first = vesica(
        path,
        &["run", "small.toml", "--out", "a", "--set", "time.step=5e-8"],
    );
    done(path, &first, "a");
    let second = vesica(path, &["run", "a/scene.toml", "--out", "b"]);
    done(path, &second, "b");
    for file in ["scene.toml", "ledger.csv", "shape.csv", "final.vtu"] {
        let read = |run: &str| fs::read(path.join(run).join(file)).expect("it is there");
        assert!(read("a") == read("b"), "{file} differs");
    }
    let history = |run: &str| -> Vec<String> {
        let text = fs::read_to_string(path.join(run).join("history.csv")).expect("it is there");
        let without_wall = |line: &str| line.rsplit_once(',').map(|(row, _)| row.to_owned());
        text.lines().filter_map(without_wall).collect()
    };
    assert_eq!(history("a"), history("b"));
    assert_eq!(history("a").len(), 8);
}

#[test]
fn the_end_and_the_rows_can_be_overridden() {
    let folder = folder_with_scene();
    let path = folder.path();
    let output = vesica(
        path,
        &[
            "run",
            "small.toml",
            "--out",
            "a",
            "--steps",
            "7",
            "--every",
            "3",
        ],
    );
    assert_eq!(done(path, &output, "a")["steps"], 7);
    let history = fs::read_to_string(path.join("a/history.csv")).expect("it is there");
    let steps: Vec<_> = history
        .lines()
        .filter_map(|line| line.split(',').next())
        .collect();
    assert_eq!(steps, ["step", "0", "3", "6", "7"]);

    let output = vesica(
        path,
        &[
            "run",
            "small.toml",
            "--out",
            "b",
            "--until",
            "5e-7",
            "--snapshots",
            "2",
        ],
    );
    assert_eq!(done(path, &output, "b")["steps"], 5);
    let mut fields: Vec<_> = fs::read_dir(path.join("b/fields"))
        .expect("it is there")
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    fields.sort();
    assert_eq!(
        fields,
        ["fields.pvd", "step-0000000.vtu", "step-0000005.vtu"]
    );
}

#[test]
fn a_folder_that_holds_a_run_is_kept() {
    let folder = folder_with_scene();
    let path = folder.path();
    done(
        path,
        &vesica(path, &["run", "small.toml", "--out", "a"]),
        "a",
    );
    let before = fs::read(path.join("a/run.json")).expect("it is there");
    refused(
        path,
        &["run", "small.toml", "--out", "a"],
        &["a holds a run already", "--force"],
    );
    refused(
        path,
        &[
            "run",
            "small.toml",
            "--out",
            "a",
            "--resume",
            "--set",
            "mesh.cells=9",
        ],
        &["another scene", "cells = 8", "cells = 9"],
    );
    assert!(fs::read(path.join("a/run.json")).expect("it is there") == before);

    let output = vesica(
        path,
        &["run", "small.toml", "--out", "a", "--force", "--steps", "1"],
    );
    assert_eq!(done(path, &output, "a")["steps"], 1);
    assert!(!path.join("a/fields/step-0000003.vtu").exists());

    for expected in ["runs/small", "runs/small-2", "runs/small-3"] {
        done(path, &vesica(path, &["run", "small.toml"]), expected);
    }
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = folder_with_scene();
    let path = folder.path();
    refused(path, &["run"], &["SCENE"]);
    refused(
        path,
        &["run", "small.toml", "--stpes", "3"],
        &["--stpes", "--steps"],
    );
    for option in ["--steps", "--every"] {
        for number in ["0", "-1", "1.5", "many"] {
            let arguments = ["run", "small.toml", option, number];
            refused(path, &arguments, &[option, number, "a whole number from 1"]);
        }
    }
    for time in ["0", "-1", "nan", "inf", "soon"] {
        let arguments = ["run", "small.toml", "--until", time];
        refused(path, &arguments, &["--until", time, "a finite number > 0"]);
    }
    let nothing = |raise| ["first step of length 1e-7", raise];
    let until = ["run", "small.toml", "--until", "4e-8"];
    refused(path, &until, &nothing("Raise --until, or"));
    let end = ["run", "small.toml", "--set", "time.end=4e-8"];
    refused(path, &end, &nothing("Raise time.end, or"));
    refused(
        path,
        &["run", "small.toml", "--until", "1", "--steps", "1"],
        &["cannot be used with"],
    );
    refused(
        path,
        &["run", "small.toml", "--set", "nonsense"],
        &["nonsense"],
    );
    refused(
        path,
        &["run", "case33"],
        &["did you mean 'case3'?", "case1, case2, case3, case4"],
    );
    refused(path, &["run", "gone.toml"], &["gone.toml"]);
    refused(path, &["run", "."], &["is a folder"]);
    refused(path, &["preset", "case9"], &["case9", "did you mean"]);
    refused(path, &["check"], &["FILE"]);
    for budget in ["-1", "0", "1.5"] {
        let arguments = ["accuracy", "small.toml", "--budget", budget];
        refused(path, &arguments, &["from 1 to 1000000"]);
    }
    // None of them began anything.
    assert!(!path.join("runs").exists());
}

#[test]
fn a_wrong_scene_is_refused_with_its_place() {
    let folder = folder_with_scene();
    let path = folder.path();
    fs::write(path.join("wrong.toml"), "[msh]\ncells = 8\n").expect("it can be written");
    refused(path, &["run", "wrong.toml"], &["wrong.toml", "msh"]);
    assert!(!path.join("runs").exists());

    let output = vesica(path, &["check", "wrong.toml", "small.toml", "case1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stdout(&output).contains("small.toml: ok"),
        "{}",
        stdout(&output)
    );
    assert!(stdout(&output).contains("case1: ok"), "{}", stdout(&output));
    assert!(
        stderr(&output).contains("1 of 3 scenes"),
        "{}",
        stderr(&output)
    );
    let output = vesica(path, &["check", "small.toml"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        stdout(&output).contains("81 nodes, 3 steps"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn a_domain_without_a_vesicle_is_refused() {
    let folder = folder_with_scene();
    let path = folder.path();
    let circle = "vesicle={ shape = 'circle', radius = 0.9 }";
    let words =
        "no vesicle in the domain: the outline is around all of it, from (0, 0) to (1.00, 1.00)";
    // On a mesh that the check does not make, too.
    for cells in ["mesh.cells=12", "mesh.cells=400"] {
        let scene = ["small.toml", "--set", circle, "--set", cells];
        refused(path, &[&["check"][..], &scene].concat(), &[words]);
    }
    let scene = ["small.toml", "--set", circle];
    refused(path, &[&["run"][..], &scene].concat(), &[words]);
}

#[test]
fn a_check_tells_what_a_run_would_tell() {
    let folder = folder_with_scene();
    let path = folder.path();
    let warnings = |output: &Output| {
        let text = stderr(output).replace("warning: case1: ", "warning: ");
        assert_eq!(output.status.code(), Some(0), "{text}");
        text
    };
    let small = [
        "--set",
        "mesh.cells=20",
        "--set",
        "membrane.interface_width=0.1",
    ];
    let checked = vesica(path, &[&["check", "case1"][..], &small].concat());
    let run = vesica(
        path,
        &[&["run", "case1", "--steps", "1"][..], &small].concat(),
    );
    assert_eq!(warnings(&checked), warnings(&run));
    for part in ["fewer than 3", "of the wall", "never reach its target"] {
        assert!(
            stderr(&run).contains(part),
            "no '{part}' in {}",
            stderr(&run)
        );
    }

    let huge = ["small.toml", "--set", "mesh.cells=20000"];
    let says = ["would need about", "lower mesh.cells"];
    refused(path, &[&["check"][..], &huge].concat(), &says);
    refused(path, &[&["run"][..], &huge].concat(), &says);
    refused(
        path,
        &["check", "small.toml", "--set", "time.step=1"],
        &["first step"],
    );
}

/// "ok" is said of what was solved once.
#[test]
fn a_scene_that_fails_at_its_first_step_is_not_ok() {
    let folder = folder_with_scene();
    let path = folder.path();
    let fails = [
        "check",
        "small.toml",
        "--set",
        "solver.law_tolerance=1e-300",
    ];
    refused(
        path,
        &fails,
        &["a run would fail: step 1 to t = 1e-7", "1 of 1 scenes"],
    );
    let output = vesica(path, &[&fails[..], &["--quick"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = stdout(&output);
    assert!(
        told.contains("no step was tried") && !told.contains("ok"),
        "{told}"
    );
    assert!(
        told.contains("small.toml: about ") && told.contains(" MB of memory"),
        "{told}"
    );
}

#[test]
fn presets_are_listed_and_printed() {
    let folder = folder_with_scene();
    let path = folder.path();
    let output = vesica(path, &["presets"]);
    assert_eq!(output.status.code(), Some(0));
    let names: Vec<_> = stdout(&output)
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for name in ["case1", "case2", "case3", "case4"] {
        assert!(names.contains(&name), "{name}");
    }
    let output = vesica(path, &["preset", "case3"]);
    assert_eq!(output.status.code(), Some(0));
    fs::write(path.join("mine.toml"), &output.stdout).expect("it can be written");
    let output = vesica(path, &["check", "mine.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("14641 nodes, 10000 steps"));
}

#[test]
fn nodal_values_go_into_the_folder() {
    let folder = folder_with_scene();
    let path = folder.path();
    fs::create_dir(path.join("scenes")).expect("it can be made");
    let values: String = (0..81)
        .map(|node| format!("{}\n", 0.9 * (f64::from(node) / 27.0).sin()))
        .collect();
    fs::write(path.join("scenes/phi0.txt"), values).expect("it can be written");
    let scene = format!("{SCENE}[vesicle]\nshape = \"file\"\nvalues = \"phi0.txt\"\n");
    fs::write(path.join("scenes/file.toml"), scene).expect("it can be written");
    let arguments = ["run", "scenes/file.toml", "--out", "a", "--steps", "1"];
    done(path, &vesica(path, &arguments), "a");
    fs::remove_dir_all(path.join("scenes")).expect("it can be removed");
    fs::rename(path.join("a"), path.join("moved")).expect("it can be moved");
    done(
        path,
        &vesica(path, &["run", "moved/scene.toml", "--out", "b"]),
        "b",
    );
}

#[test]
fn quiet_is_quiet() {
    let folder = folder_with_scene();
    let output = vesica(folder.path(), &["run", "small.toml", "-q"]);
    done(folder.path(), &output, "runs/small");
    assert_eq!(stdout(&output), "");
    assert_eq!(stderr(&output), "");
}

#[test]
fn the_app_says_where_to_go() {
    let folder = folder_with_scene();
    refused(folder.path(), &[], &["vesica run case3"]);
    refused(folder.path(), &["case1"], &["vesica run case1"]);
    refused(folder.path(), &["small.toml"], &["vesica run small.toml"]);
}

#[test]
fn a_misspelt_command_is_told() {
    let folder = folder_with_scene();
    for arguments in [&["rnu"][..], &["rnu", "case3"], &["rnu", "--steps", "3"]] {
        refused(
            folder.path(),
            arguments,
            &["no command 'rnu'", "run, figures, effects, presets"],
        );
    }
}

#[test]
fn help_and_version_succeed() {
    let folder = folder_with_scene();
    for arguments in [&["--help"][..], &["--version"], &["run", "--help"]] {
        let output = vesica(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(!stdout(&output).is_empty());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_pipe_is_no_panic_and_a_full_disk_is_told() {
    let folder = folder_with_scene();
    let mut child = command(folder.path(), &["preset", "case3"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));

    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .expect("Linux has it");
    let output = command(folder.path(), &["preset", "case3"])
        .stdout(full)
        .output()
        .expect("vesica starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("No space left"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    let folder = folder_with_scene();
    let arguments = ["run", "small.toml", "--out", "small.toml/run"];
    refused(folder.path(), &arguments, &["small.toml/run"]);
    refused(
        folder.path(),
        &["run", "small.toml", "--out", "small.toml"],
        &["small.toml"],
    );
}

#[cfg(unix)]
mod signals;
mod values;

#[test]
fn the_effects_are_priced() {
    let folder = folder_with_scene();
    let output = vesica(
        folder.path(),
        &[
            "effects",
            "small.toml",
            "--steps",
            "2",
            "--set",
            "area.target=1.1",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
    let lines: Vec<&str> = stdout(&output).lines().collect();
    assert_eq!(lines[0], "Small: 8 × 8 cells, steps 11 to 12");
    let labels = ["all effects", "bending alone", "no area", "no nematic"];
    for (line, label) in lines[3..].iter().zip(labels) {
        assert!(line.starts_with(label), "{line}");
        // The program's allocator counts.
        assert!(!line.ends_with('-'), "{line}");
    }
    let names: Vec<String> = fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().display().to_string())
        .collect();
    assert_eq!(names, ["small.toml"], "nothing is saved");
    refused(
        folder.path(),
        &["effects", "nowhere.toml"],
        &["nowhere.toml"],
    );
}

/// Nothing was computed yet: the run ends without waiting for its mesh, and goes on from the beginning.
#[test]
fn a_signal_ends_a_run_while_it_is_set_up() {
    let folder = folder_with_scene();
    let path = folder.path();
    let arguments = ["run", "small.toml", "--out", "r", "--set", FINE_MESH];
    let mut command = command(path, &arguments);
    let child = command
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    let begun = Instant::now();
    while !path.join("r/scene.toml").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no folder");
        std::thread::sleep(Duration::from_millis(5));
    }
    let status = Command::new("kill").arg(child.id().to_string()).status();
    assert!(status.expect("kill starts").success());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(75), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("ended by SIGTERM while the run was set up"),
        "{}",
        stderr(&output)
    );
    assert!(!path.join("r/history.csv").exists());
    assert_eq!(summary(path, "r")["status"], "interrupted");
    let again = ["run", "small.toml", "--out", "r", "--resume"];
    done(path, &vesica(path, &again), "r");
}

/// The address space that the shell allows is memory too, less what the process has of it already.
#[cfg(target_os = "linux")]
#[test]
fn more_memory_than_ulimit_allows_is_refused_before_anything_begins() {
    let folder = folder_with_scene();
    let limited = |arguments: &str| {
        let vesica = env!("CARGO_BIN_EXE_vesica");
        let line = format!("ulimit -v 600000; exec '{vesica}' {arguments} --set mesh.cells=600");
        let mut shell = Command::new("sh");
        let shell = shell.current_dir(folder.path()).args(["-c", &line]);
        shell.stdin(Stdio::null()).output().expect("sh starts")
    };
    for arguments in [
        "run small.toml",
        "check small.toml",
        "effects small.toml",
        "figures small.toml",
    ] {
        let output = limited(arguments);
        let words = stderr(&output);
        for part in [
            "a mesh of 600 × 600 cells would need about",
            "MB are left of the address space that ulimit -v allows: lower mesh.cells",
        ] {
            assert!(words.contains(part), "{arguments}: {words}");
        }
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments}");
    }
    assert!(!folder.path().join("runs").exists());
}
