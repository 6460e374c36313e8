//! Where the numbers of a run come from: what `run.json` says of it, `vesica verify` and `vesica export`; and what
//! packagers install.

use super::cli::{command, done, folder_with_scene, stderr, stdout, vesica};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

#[track_caller]
fn ok(output: &Output) -> &str {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    stdout(output)
}

/// The SHA-256 of a file by another program; none where there is no such program.
fn sha256sum(path: &Path) -> Option<String> {
    let output = Command::new("sha256sum").arg(path).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.split_whitespace().next().map(str::to_owned)
}

#[test]
fn a_run_says_by_which_programs_it_was_computed_and_from_what() {
    let folder = folder_with_scene();
    let path = folder.path();
    let values: String = (0..81).map(|_| "0.5\n").collect();
    fs::write(path.join("phi0.txt"), values).expect("it is written");
    let file = "vesicle={ shape = 'file', values = 'phi0.txt' }";
    let arguments = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--set",
        file,
        "--steps",
        "2",
    ];
    let run = done(path, &vesica(path, &arguments), "a");
    let [session] = &run["sessions"].as_array().expect("a list")[..] else {
        panic!("one process: {}", run["sessions"]);
    };
    assert_eq!(session["reason"], "done");
    assert_eq!([&session["from_step"], &session["to_step"]], [0, 2]);
    assert_eq!(session["threads"], run["threads"]);
    assert!(session["host"].is_string() && session["ended"].is_string());
    let command = session["command"].as_array().expect("a list");
    assert_eq!(
        command[1..]
            .iter()
            .map(|it| it.as_str().unwrap_or(""))
            .collect::<Vec<_>>(),
        arguments
    );
    let program = &session["program"];
    assert_eq!(program["version"], env!("CARGO_PKG_VERSION"));
    let compiler = program["compiler"].as_str().expect("a compiler");
    assert!(compiler.starts_with("rustc "), "{compiler}");

    let inputs = run["inputs"].as_array().expect("a list");
    let names: Vec<&str> = inputs.iter().filter_map(|it| it["path"].as_str()).collect();
    assert_eq!(names, ["scene.toml", "inputs/vesicle.txt"]);
    for input in inputs {
        let file = path.join("a").join(input["path"].as_str().expect("a path"));
        if let Some(wanted) = sha256sum(&file) {
            assert_eq!(input["sha256"], wanted.as_str());
        }
    }

    // A resumption is a session of its own; what was there before stays. Nobody need know the computer.
    let mut again = super::cli::command(path, &["run", "a", "--resume", "--steps", "3"]);
    let output = again
        .env("VESICA_NO_HOST", "1")
        .output()
        .expect("it starts");
    let run = done(path, &output, "a");
    let [first, second] = &run["sessions"].as_array().expect("a list")[..] else {
        panic!("two processes: {}", run["sessions"]);
    };
    assert_eq!(first, session);
    assert_eq!([&second["from_step"], &second["to_step"]], [2, 3]);
    assert!(second["host"].is_null());
    let hash = |run: &serde_json::Value| run["inputs"][0]["sha256"].clone();
    assert_ne!(hash(&run), inputs[0]["sha256"], "the end has moved");

    // That a process was killed is known from the next one.
    let file = path.join("a/run.json");
    let mut killed = run.clone();
    killed["status"] = "running".into();
    killed["sessions"][1]["reason"] = serde_json::Value::Null;
    fs::write(&file, killed.to_string()).expect("it is written");
    let arguments = ["run", "a", "--resume", "--steps", "4", "--no-host"];
    let run = done(path, &vesica(path, &arguments), "a");
    assert_eq!(run["sessions"][1]["reason"], "killed");
    assert!(run["sessions"][2]["host"].is_null());
}

#[test]
fn a_run_is_verified_and_a_digit_that_was_changed_is_found() {
    let folder = folder_with_scene();
    let path = folder.path();
    for (name, more) in [
        ("a", &[][..]),
        (
            "chosen",
            &[
                "--set",
                "time={ tolerance = 1e-3, end = 1e-6 }",
                "--every",
                "2",
            ],
        ),
    ] {
        let arguments = [&["run", "small.toml", "--out", name], more].concat();
        ok(&vesica(path, &arguments));
        let output = vesica(path, &["verify", name]);
        let told = ok(&output);
        assert!(told.contains("the same, bit for bit"), "{told}");
        assert!(told.contains("by the program that computed it"), "{told}");
    }
    let table = path.join("a/history.csv");
    let text = fs::read_to_string(&table).expect("a table");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<String> = lines[3].split(',').map(str::to_owned).collect();
    let energy: f64 = cells[3].parse().expect("E_total");
    cells[3] = format!("{:?}", energy.next_up());
    lines[3] = cells.join(",");
    fs::write(&table, lines.join("\n") + "\n").expect("it is written");
    let output = vesica(path, &["verify", "a"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told = stdout(&output);
    assert!(
        told.contains("E_total") && told.contains("from step 2 on"),
        "{told}"
    );
    // The first steps are the same, and so are all within a tolerance; which that is stands in the JSON.
    ok(&vesica(path, &["verify", "a", "--steps", "1"]));
    let output = vesica(path, &["verify", "a", "--tolerance", "1e-12", "--json"]);
    let verdict: serde_json::Value = serde_json::from_str(ok(&output)).expect("JSON");
    assert_eq!([&verdict["identical"], &verdict["same"]], [false, true]);
    assert_eq!(verdict["differences"][0]["column"], "E_total");
    assert_eq!(verdict["rows"], 4);

    // A scene that somebody has changed is not the run's.
    let scene = path.join("a/scene.toml");
    let text = fs::read_to_string(&scene).expect("a scene");
    fs::write(&scene, text.replace("step = 1e-7", "step = 2e-7")).expect("it is written");
    let output = vesica(path, &["verify", "a"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("scene.toml is not the file"),
        "{}",
        stderr(&output)
    );

    for (arguments, part) in [
        (&["verify", "nowhere"][..], "run.json"),
        (&["verify", "."], "run.json"),
    ] {
        let output = vesica(path, arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
}

/// What was changed in a run's folder is found, and the folder as it was is the same.
#[test]
fn a_changed_run_is_not_verified() {
    let folder = folder_with_scene();
    let path = folder.path();
    let run = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--steps",
        "5",
        "--every",
        "2",
    ];
    ok(&vesica(path, &run));
    let read = |name: &str| fs::read_to_string(path.join("a").join(name)).expect("it is there");
    let without = |text: &str, number: usize| -> String {
        let lines = text.lines().enumerate();
        let lines = lines.filter(|(line, _)| *line != number);
        lines.map(|(_, line)| format!("{line}\n")).collect()
    };
    let (history, shape, scene) = (read("history.csv"), read("shape.csv"), read("scene.toml"));
    // Rows of steps 0, 2, 4 and 5.
    assert_eq!(history.lines().count(), 5);
    // Of the last digit of B in the row of step 4.
    let mut digit: Vec<Vec<String>> = history
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    let cell = &mut digit[3][9];
    let last = cell.pop().expect("a number");
    cell.push(if last == '7' { '8' } else { '7' });
    let digit: Vec<String> = digit.into_iter().map(|cells| cells.join(",")).collect();
    let digit = digit.join("\n") + "\n";
    let no_area: String = shape
        .lines()
        .map(|line| line.rsplit_once(',').expect("columns").0.to_owned() + "\n")
        .collect();
    for (name, text, part) in [
        (
            "history.csv",
            digit,
            "B              differs in 1 rows, from step 4 on",
        ),
        (
            "history.csv",
            without(&history, 2),
            "1 rows of the repetition are not there in the run",
        ),
        (
            "history.csv",
            without(&history, 1),
            "1 rows of the repetition are not there in the run",
        ),
        (
            "history.csv",
            without(&history, 4),
            "1 rows of the repetition are not there in the run",
        ),
        (
            "shape.csv",
            without(&shape, 3),
            "width          differs in 1 rows, from step 4 on",
        ),
        (
            "shape.csv",
            no_area,
            "width          differs in 4 rows, from step 0 on",
        ),
        (
            "scene.toml",
            scene.replace("step = 1e-7", "step = 2e-7"),
            "not the same",
        ),
        (
            "scene.toml",
            scene.replace("interface_width = 0.05", "interface_width = 0.0500001"),
            "E_bending",
        ),
    ] {
        let file = path.join("a").join(name);
        let before = fs::read_to_string(&file).expect("it is there");
        assert_ne!(text, before, "{name}");
        fs::write(&file, text).expect("it is written");
        let output = vesica(path, &["verify", "a"]);
        assert_eq!(output.status.code(), Some(1), "{part}: {}", stdout(&output));
        let told = stdout(&output);
        assert!(told.contains(part), "{part}: {told}");
        assert!(
            told.contains("not the same") && !told.contains("bit for bit"),
            "{told}"
        );
        // A changed input is named; the tables are no inputs.
        let is_named = stderr(&output).contains("scene.toml is not the file");
        assert_eq!(is_named, name == "scene.toml", "{}", stderr(&output));
        fs::write(&file, before).expect("it is written");
        let output = vesica(path, &["verify", "a"]);
        assert!(ok(&output).contains("the same, bit for bit: 4 rows up to step 5"));
    }
    // A part of it has the rows that are due in it, and no others.
    for steps in ["1", "3", "4"] {
        let output = vesica(path, &["verify", "a", "--steps", steps]);
        assert!(ok(&output).contains("the same, bit for bit"), "{steps}");
    }
    fs::write(path.join("a/history.csv"), without(&history, 2)).expect("it is written");
    let output = vesica(path, &["verify", "a", "--steps", "2", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let verdict: serde_json::Value = serde_json::from_str(stdout(&output)).expect("JSON");
    assert_eq!([&verdict["lost_rows"], &verdict["missing_rows"]], [1, 0]);
    assert_eq!([&verdict["identical"], &verdict["same"]], [false, false]);
}

/// Unpacks an archive with its own reader.
fn unpack(archive: &Path, folder: &Path) {
    let file = fs::File::open(archive).expect("it is there");
    let mut archive = zip::ZipArchive::new(file).expect("an archive");
    archive.extract(folder).expect("it can be unpacked");
}

#[test]
fn a_run_is_exported_unpacked_verified_and_run_again() {
    let folder = folder_with_scene();
    let path = folder.path();
    ok(&vesica(path, &["run", "small.toml", "--quiet"]));
    let export = [
        "export",
        "runs/small",
        "--author",
        "A. Author",
        "--no-figures",
    ];
    ok(&vesica(path, &export));
    let output = vesica(path, &export);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("small.zip is there already"));
    ok(&vesica(path, &[&export[..], &["--force"]].concat()));
    unpack(&path.join("small.zip"), &path.join("small"));
    let text = fs::read_to_string(path.join("small/ro-crate-metadata.json")).expect("it is there");
    let crate_: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for entity in crate_["@graph"].as_array().expect("a list") {
        if entity["@type"] != "File" {
            continue;
        }
        let file = path
            .join("small")
            .join(entity["@id"].as_str().expect("a path"));
        let size = fs::metadata(&file).expect("it is there").len();
        assert_eq!(entity["contentSize"], size.to_string());
        if let Some(wanted) = sha256sum(&file) {
            assert_eq!(entity["sha256"], wanted.as_str(), "{}", file.display());
        }
    }
    assert!(!path.join("small/checkpoint.bin").exists());
    let output = vesica(path, &["verify", "small"]);
    assert!(ok(&output).contains("the same, bit for bit"));
    let readme = fs::read_to_string(path.join("small/README.md")).expect("it is there");
    assert!(readme.contains("vesica verify small"), "{readme}");
    ok(&vesica(
        path,
        &["run", "small/scene.toml", "--out", "again"],
    ));

    let output = vesica(path, &["export", "."]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let output = vesica(path, &["export", "runs/small", "--license", "mine"]);
    assert!(stderr(&output).contains("it must be a URL"));
}

/// Whether it can be written is found out first, and what a signal ends leaves nothing.
#[test]
fn an_export_leaves_nothing_half_done() {
    let folder = folder_with_scene();
    let path = folder.path();
    ok(&vesica(path, &["run", "small.toml", "--quiet"]));
    fs::create_dir(path.join("taken.zip")).expect("a folder");
    // A figure that cannot be drawn is not even tried.
    let export = ["export", "runs/small", "--out"];
    for (arguments, words) in [
        (&["taken.zip", "--force"][..], "directory"),
        (&["gone/a.zip"], "gone/a.zip"),
    ] {
        let arguments = [&export, arguments].concat();
        let begun = Instant::now();
        let output = vesica(path, &arguments);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
        assert!(begun.elapsed() < Duration::from_secs(20));
    }

    // Some seconds of work, and a file that a killed export has left.
    let large = fs::File::create(path.join("runs/small/final.vtu")).expect("a file");
    large.set_len(1 << 29).expect("room");
    let is_part = |name: &str| name.starts_with(".vesica-") && name.ends_with(".part");
    let parts = || {
        let entries = fs::read_dir(path).expect("a folder");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        names
            .filter(|name| is_part(&name.to_string_lossy()))
            .count()
    };
    fs::write(path.join(".vesica-old.part"), "half").expect("written");
    let arguments = ["export", "runs/small", "--no-figures", "--out", "a.zip"];
    let mut child = command(path, &arguments)
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    let deadline = Instant::now() + Duration::from_secs(60);
    let is_written = || !path.join(".vesica-old.part").exists() && parts() > 0;
    while !is_written() && child.try_wait().expect("a status").is_none() {
        assert!(Instant::now() < deadline, "nothing is written");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill").arg(child.id().to_string()).status();
    assert!(kill.is_ok_and(|status| status.success()));
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(143), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("ended by SIGTERM"),
        "{}",
        stderr(&output)
    );
    assert_eq!(parts(), 0);
    assert!(!path.join("a.zip").exists());
}

#[test]
fn a_run_without_its_scene_is_not_verified_and_says_what_is_missing() {
    let folder = folder_with_scene();
    let path = folder.path();
    ok(&vesica(path, &["run", "small.toml", "--quiet"]));
    fs::remove_file(path.join("runs/small/scene.toml")).expect("it was there");
    let output = vesica(path, &["verify", "runs/small"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let error = stderr(&output);
    assert!(error.contains("no scene.toml"), "{error}");
    assert!(error.contains("as runs/small/scene.toml"), "{error}");
    assert!(!error.contains("resume"), "{error}");
}

/// Needs Python with rocrate-validator and runcrate:
/// `python3 -m venv venv && venv/bin/pip install roc-validator runcrate`, and PYTHON=venv/bin/python.
#[test]
#[ignore = "needs Python with rocrate-validator and runcrate"]
fn an_exported_run_is_a_valid_crate() {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let folder = folder_with_scene();
    let path = folder.path();
    ok(&vesica(path, &["run", "small.toml", "--steps", "2"]));
    ok(&vesica(path, &["run", "small.toml", "--resume"]));
    ok(&vesica(
        path,
        &["export", "runs/small", "--author", "A. Author"],
    ));
    unpack(&path.join("small.zip"), &path.join("small"));
    let check = fs::canonicalize("tests/program/crate.py").expect("the script");
    let output = Command::new(&python)
        .arg(check)
        .arg(path.join("small"))
        .stdin(Stdio::null())
        .output()
        .expect("Python starts");
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}{}",
        stdout(&output),
        stderr(&output)
    );
}

#[test]
fn shells_complete_scenes_and_keys_and_there_is_a_manual() {
    let folder = folder_with_scene();
    let path = folder.path();
    for shell in ["bash", "zsh", "fish"] {
        let output = vesica(path, &["completions", shell]);
        let script = ok(&output);
        assert!(script.contains("VESICA_COMPLETE"), "{script}");
    }
    // As the script for bash asks.
    let asked = |words: &[&str]| {
        let last = words.len() - 1;
        let mut asking = command(path, &[&["--"], words].concat());
        asking
            .env("VESICA_COMPLETE", "bash")
            .env("_CLAP_COMPLETE_INDEX", last.to_string())
            .env("_CLAP_COMPLETE_COMP_TYPE", "9")
            .env("_CLAP_COMPLETE_SPACE", "false")
            .env("_CLAP_IFS", "\n");
        ok(&asking.output().expect("it starts")).to_owned()
    };
    let told = asked(&["vesica", "run", "case3-"]);
    assert!(told.lines().any(|line| line == "case3-quick"), "{told}");
    let told = asked(&["vesica", "run", "sma"]);
    assert!(told.contains("small.toml"), "{told}");
    let told = asked(&["vesica", "run", "case3", "--set", "anchoring.k"]);
    assert_eq!(told.trim(), "anchoring.kind=");
    let told = asked(&["vesica", "ver"]);
    assert_eq!(told.trim(), "verify");

    assert!(ok(&vesica(path, &["man"])).contains(".TH vesica 1"));
    ok(&vesica(path, &["man", "--out", "man"]));
    for page in ["vesica.1", "vesica-run.1", "vesica-sweep-status.1"] {
        assert!(path.join("man").join(page).is_file(), "{page}");
    }
}

#[test]
fn what_was_found_out_is_told_to_programs_too() {
    let folder = folder_with_scene();
    let path = folder.path();
    fs::write(path.join("wrong.toml"), "mesh.cells = -1\n").expect("it is written");
    let output = vesica(
        path,
        &["check", "small.toml", "wrong.toml", "--json", "--quick"],
    );
    assert_eq!(output.status.code(), Some(2));
    let found: serde_json::Value = serde_json::from_str(stdout(&output)).expect("JSON");
    assert_eq!(found[0]["verdict"], "well formed");
    assert_eq!([&found[0]["nodes"], &found[0]["steps"]], [81, 3]);
    assert_eq!(found[1]["verdict"], "wrong");
    assert!(
        found[1]["reason"]
            .as_str()
            .expect("words")
            .contains("mesh.cells")
    );

    let output = vesica(
        path,
        &[
            "effects",
            "small.toml",
            "--after",
            "1",
            "--steps",
            "1",
            "--json",
        ],
    );
    let found: serde_json::Value = serde_json::from_str(ok(&output)).expect("JSON");
    assert_eq!(found["effects"][0]["effect"], "nematic");
    assert!(found["whole"]["step_seconds"].as_f64().expect("a number") > 0.0);

    let plan = "scene = 'small.toml'\n[vary]\n'nematic.weight' = [1.0, 2.0]\n";
    fs::write(path.join("plan.toml"), plan).expect("it is written");
    ok(&vesica(
        path,
        &["sweep", "plan.toml", "--out", "s", "--quiet"],
    ));
    let output = vesica(path, &["sweep", "status", "s", "--json"]);
    let found: serde_json::Value = serde_json::from_str(ok(&output)).expect("JSON");
    assert_eq!(found["counts"]["done"], 2);
    assert_eq!(found["points"][1]["state"], "done");
}
