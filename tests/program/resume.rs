//! Runs that were ended go on as if nothing had happened: the real binary, killed and damaged.

#![cfg(unix)]

mod changed;
mod killed;
mod whole_or_not;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A vesicle with every effect on a small mesh.
const SCENE: &str = r#"
name = "Small"
[mesh]
cells = 12
[vesicle]
shape = "ellipse"
half_axes = [0.3, 0.2]
angle = 70
[time]
step = 1e-6
end = 1.5e-3
[membrane]
interface_width = 0.08
[area]
target = 1.1
[nematic]
initial = [0.6, 0.8]
[anchoring]
kind = "parallel"
"#;

/// Random phases that want an area, strictly: the first step is solved in hundreds of parts, and takes
/// many seconds.
const HARD: &str = r#"
mesh.cells = 24
vesicle = { shape = "random", amplitude = 9.0, seed = 1 }
time = { step = 1e-6, end = 1.0 }
membrane.interface_width = 0.03
area = { target = 1.25, penalty = 1e-8 }
nematic.initial = { kind = "random", seed = 2, length = 1.0 }
[anchoring]
"#;

fn folder_with_scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("small.toml"), SCENE).expect("it can be written");
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesica"));
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

#[track_caller]
fn vesica(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = command(folder, arguments).output().expect("vesica starts");
    check(output, status)
}

#[track_caller]
fn check(output: Output, status: i32) -> String {
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(status), "{told}");
    assert!(!told.contains("panicked"), "{told}");
    told
}

fn send(child: &Child, signal: &str) {
    let status = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// What stands in a run's folder, but for the clock: the column `wall`, and `run.json` and the
/// checkpoints, which have it too.
fn record(run: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut record = BTreeMap::new();
    // Without snapshots there are no fields.
    let fields = Some(run.join("fields")).filter(|fields| fields.is_dir());
    for folder in std::iter::once(run.to_owned()).chain(fields) {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            let name = path
                .file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            if path.is_dir() || name == "run.json" || name.starts_with("checkpoint") {
                continue;
            }
            let mut bytes = fs::read(&path).expect("a file");
            if name == "history.csv" {
                bytes = without_wall(&String::from_utf8(bytes).expect("text")).into_bytes();
            }
            let path = path.strip_prefix(run).expect("it is in the run's folder");
            record.insert(path.to_owned(), bytes);
        }
    }
    record
}

fn without_wall(history: &str) -> String {
    let mut lines = history.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let wall = header
        .iter()
        .position(|name| *name == "wall")
        .expect("it is there");
    let row = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells.remove(wall);
        cells.join(",")
    };
    lines.map(row).collect::<Vec<String>>().join("\n")
}

#[track_caller]
fn assert_same(run: &Path, wanted: &Path) {
    let (found, wanted) = (record(run), record(wanted));
    let names = |record: &BTreeMap<PathBuf, Vec<u8>>| record.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&found), names(&wanted));
    for (name, bytes) in &wanted {
        assert!(found[name] == *bytes, "{} differs", name.display());
    }
}

fn summary(run: &Path) -> serde_json::Value {
    let text = fs::read_to_string(run.join("run.json")).expect("run.json");
    serde_json::from_str(&text).expect("JSON")
}

/// The exit status of a run that a signal has ended and that is saved.
const SAVED: i32 = 75;

fn resumed(summary: &serde_json::Value) -> usize {
    let events = summary["events"].as_array().expect("a list");
    events
        .iter()
        .filter(|event| event["kind"] == "resumed")
        .count()
}

#[test]
fn a_run_that_a_signal_ends_goes_on_in_its_folder() {
    let folder = folder_with_scene();
    let path = folder.path();
    vesica(path, &["run", "small.toml", "--out", "whole"], 0);
    for (signal, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1), ("-XCPU", 24)] {
        if crate::ignored::is_ignored(number) {
            continue;
        }
        let run = path.join("runs/small");
        let _ = fs::remove_dir_all(&run);
        let child = command(path, &["run", "small.toml"])
            .spawn()
            .expect("vesica starts");
        while !fs::read_to_string(run.join("run.json")).is_ok_and(|text| text.contains("nodes"))
            || !run.join("checkpoint.bin").is_file()
        {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(50));
        send(&child, signal);
        let told = check(child.wait_with_output().expect("it ends"), SAVED);
        assert!(told.contains("vesica run runs/small --resume"), "{told}");
        assert_eq!(summary(&run)["status"], "interrupted");
        let wall = summary(&run)["seconds"].as_f64().expect("a number");

        let told = vesica(path, &["run", "runs/small", "--resume"], 0);
        assert!(told.contains("goes on from step"), "{told}");
        assert_same(&run, &path.join("whole"));
        let seconds = summary(&run)["seconds"].as_f64().expect("a number");
        assert!(seconds > wall, "{seconds} after {wall}");
    }
}

#[test]
fn a_run_whose_process_is_gone_is_known_and_ended() {
    let folder = folder_with_scene();
    let path = folder.path();
    vesica(
        path,
        &["run", "small.toml", "--out", "a", "--steps", "20"],
        0,
    );
    let run = path.join("a");
    // As if it had been killed before its last word.
    let file = run.join("run.json");
    let text = fs::read_to_string(&file).expect("run.json");
    let killed = text.replace("\"status\": \"done\"", "\"status\": \"running\"");
    assert_ne!(killed, text);
    fs::write(&file, killed).expect("it can be written");
    fs::remove_file(run.join("final.vtu")).expect("it was there");
    let told = vesica(path, &["run", "a", "--resume", "--steps", "20"], 0);
    assert!(told.contains("the run in a was killed"), "{told}");
    assert_eq!(summary(&run)["status"], "done");
    assert!(run.join("final.vtu").is_file());
    let told = vesica(path, &["run", "a", "--resume", "--steps", "20"], 0);
    assert!(
        !told.contains("killed") && told.contains("nothing to do"),
        "{told}"
    );
}

#[test]
fn a_run_that_is_done_goes_on_to_a_later_end() {
    let folder = folder_with_scene();
    let path = folder.path();
    let every = ["--every", "8", "--snapshots", "0"];
    let run = |more: &[&str]| vesica(path, &[&["run", "small.toml"], more].concat(), 0);
    run(&[&every[..], &["--out", "whole", "--steps", "60"]].concat());
    run(&[&every[..], &["--out", "a", "--steps", "20"]].concat());
    let told = run(&["--out", "a", "--resume", "--steps", "20"]);
    assert!(told.contains("at step 20 already"), "{told}");
    assert_eq!(resumed(&summary(&path.join("a"))), 0);
    run(&["--out", "a", "--resume", "--steps", "60"]);
    assert_same(&path.join("a"), &path.join("whole"));
    // Its settings were kept: every eighth step, no snapshots.
    let history = fs::read_to_string(path.join("a/history.csv")).expect("history.csv");
    assert_eq!(history.lines().count(), 1 + 8 + 1);
}

#[test]
fn the_latest_run_of_the_scene_is_found_and_none_is_begun() {
    let folder = folder_with_scene();
    let path = folder.path();
    let run = |more: &[&str]| vesica(path, &[&["run", "small.toml"], more].concat(), 0);
    let told = run(&["--resume", "--steps", "5"]);
    assert!(told.contains("no run to go on with"), "{told}");
    run(&["--steps", "5", "--set", "anchoring.kind=homeotropic"]);
    run(&["--steps", "6", "--set", "mesh.cells=10"]);
    let told = run(&[
        "--resume",
        "--steps",
        "8",
        "--set",
        "anchoring.kind=homeotropic",
    ]);
    assert!(told.contains("runs/small-2"), "{told}");
    assert_eq!(summary(&path.join("runs/small-2"))["steps"], 8);
    assert_eq!(summary(&path.join("runs/small"))["steps"], 5);
    let foreign = ["run", "small.toml", "--resume", "--set", "mesh.cells=11"];
    let told = vesica(path, &foreign, 2);
    assert!(told.contains("in [mesh] it has cells = 10"), "{told}");
}

#[test]
fn damage_is_recognised_and_the_older_checkpoint_taken() {
    let folder = folder_with_scene();
    let path = folder.path();
    // The times of snapshots depend on the end, which comes later on resuming.
    let none = ["--snapshots", "0"];
    let whole = ["run", "small.toml", "--out", "whole", "--steps", "40"];
    vesica(path, &[&whole[..], &none].concat(), 0);
    let [newest, older] =
        ["a/checkpoint.bin", "a/checkpoint-older.bin"].map(|name| path.join(name));
    let begin = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--force",
        "--checkpoint",
        "0",
    ];
    let go_on = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--resume",
        "--steps",
        "40",
    ];
    let flip: fn(&Path) = |path| {
        let mut bytes = fs::read(path).expect("a checkpoint");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(path, bytes).expect("it can be written");
    };
    let cut: fn(&Path) = |path| {
        let bytes = fs::read(path).expect("a checkpoint");
        fs::write(path, &bytes[..bytes.len() / 3]).expect("it can be written");
    };
    let remove: fn(&Path) = |path| fs::remove_file(path).expect("it can be removed");
    for (damage, word) in [
        (flip, "checksum"),
        (cut, "cut short"),
        (remove, "not there"),
    ] {
        vesica(path, &[&begin[..], &none, &["--steps", "20"]].concat(), 0);
        damage(&newest);
        let told = vesica(path, &go_on, 0);
        assert!(
            told.contains(word) && told.contains("checkpoint.bin"),
            "{told}"
        );
        assert_same(&path.join("a"), &path.join("whole"));
        let event = summary(&path.join("a"))["events"][0]["text"].to_string();
        assert!(
            event.contains(word) && event.contains("checkpoint-older.bin"),
            "{event}"
        );
    }

    vesica(path, &[&begin[..], &none, &["--steps", "20"]].concat(), 0);
    flip(&newest);
    cut(&older);
    let before = record(&path.join("a"));
    let told = vesica(path, &go_on, 1);
    assert!(
        told.contains("checksum") && told.contains("cut short"),
        "{told}"
    );
    assert!(record(&path.join("a")) == before);

    // Rows that are not there any more are no matter of the checkpoint.
    vesica(path, &[&begin[..], &none, &["--steps", "20"]].concat(), 0);
    fs::write(path.join("a/history.csv"), "step,t\n0,0\n").expect("it can be written");
    let told = vesica(path, &go_on, 0);
    assert!(
        told.contains("20 of 21 rows are missing, the last ones"),
        "{told}"
    );
    assert!(told.contains("goes on from step 20"), "{told}");

    remove(&newest);
    remove(&older);
    fs::write(path.join("a/history.csv"), "step,t\n0,0\n1,1\n").expect("it can be written");
    let told = vesica(path, &go_on, 2);
    assert!(told.contains("no checkpoint"), "{told}");
}

#[test]
fn two_processes_do_not_share_a_folder() {
    let folder = folder_with_scene();
    let path = folder.path();
    let arguments = ["run", "small.toml", "--out", "a", "--steps", "100000000"];
    let mut child = command(path, &arguments).spawn().expect("vesica starts");
    while !path.join("a/checkpoint.bin").is_file() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let outputs = ["--resume", "--force"].map(|option| {
        let arguments = [&arguments[..], &[option]].concat();
        command(path, &arguments).output().expect("vesica runs")
    });
    // It would go on for ever where a check fails.
    child.kill().expect("it is there to be killed");
    child.wait().expect("it ends");
    for output in outputs {
        let told = check(output, 2);
        assert!(told.contains("another process"), "{told}");
    }
}

/// A limit on the size of files stands for a disk that is full: the system refuses what goes beyond.
#[test]
fn a_run_that_cannot_be_written_goes_on_and_tells_it() {
    let folder = folder_with_scene();
    let path = folder.path();
    // In blocks of 512 or 1024 bytes: history.csv gets larger.
    let shell = format!(
        "ulimit -f 200; exec {} run small.toml --out a --steps 1500 --snapshots 0",
        env!("CARGO_BIN_EXE_vesica")
    );
    let output = Command::new("sh")
        .args(["-c", &shell])
        .current_dir(path)
        .stdin(Stdio::null())
        .output()
        .expect("a shell");
    let told = check(output, 1);
    assert!(
        told.contains("not all of the run could be recorded"),
        "{told}"
    );
    assert!(told.contains("a/") && told.contains("too large"), "{told}");
    let history = fs::read_to_string(path.join("a/history.csv")).expect("history.csv");
    assert!(history.ends_with('\n'), "whole lines only");
}

/// A disk that is really full while a run goes on, and one that cannot be written: a small disk in memory,
/// which only root may mount.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_does_not_end_a_run() {
    let folder = folder_with_scene();
    let path = folder.path();
    let run = |after_mounting: &str, steps: u32| {
        let shell = format!(
            "mkdir -p disk && mount -t tmpfs -o size=400k none disk || exit 77; {after_mounting} \
             {} run small.toml --out disk/run --steps {steps} --snapshots 0; status=$?; \
             mount -o remount,rw,size=100m disk && cp -r disk/run kept; exit $status",
            env!("CARGO_BIN_EXE_vesica")
        );
        let mut command = Command::new("unshare");
        command.args(["-m", "sh", "-c", &shell]);
        command.current_dir(path).stdin(Stdio::null()).output()
    };
    let refused = match run("", 1) {
        Ok(output) if output.status.code() == Some(0) => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).into_owned()),
        Err(error) => Some(error.to_string()),
    };
    if let Some(reason) = refused {
        eprintln!("not tested: no disk can be mounted here: {reason}");
        return;
    }
    fs::remove_dir_all(path.join("kept")).expect("the run was kept");
    let told = check(run("", 1500).expect("a shell"), 1);
    assert!(told.contains("No space left"), "{told}");
    assert!(told.contains("disk/run/"), "{told}");
    let history = fs::read_to_string(path.join("kept/history.csv")).expect("history.csv");
    assert!(history.ends_with('\n'), "whole lines only");
    // What stands there can be gone on with.
    vesica(path, &["run", "kept", "--resume", "--steps", "1500"], 0);
    vesica(
        path,
        &[
            "run",
            "small.toml",
            "--out",
            "whole",
            "--steps",
            "1500",
            "--snapshots",
            "0",
        ],
        0,
    );
    assert_same(&path.join("kept"), &path.join("whole"));

    // On one that cannot be written at all nothing begins.
    let told = check(run("mount -o remount,ro disk;", 5).expect("a shell"), 2);
    assert!(
        told.contains("disk/run") && told.contains("Read-only"),
        "{told}"
    );
}

/// A step that would take for ever: a signal ends the run within it, and it goes on from there.
#[test]
fn a_signal_ends_a_run_in_the_midst_of_a_hard_step() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    fs::write(path.join("hard.toml"), HARD).expect("it can be written");
    let mut reached = 0.0;
    for arguments in [&["run", "hard.toml"][..], &["run", "hard.toml", "--resume"]] {
        let mut child = command(path, arguments).spawn().expect("vesica starts");
        let checkpoint = path.join("runs/hard/checkpoint.bin");
        while !checkpoint.is_file() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_secs(1));
        send(&child, "-TERM");
        let begun = Instant::now();
        while child.try_wait().expect("a child").is_none() {
            assert!(begun.elapsed() < Duration::from_secs(60), "it does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        let told = check(child.wait_with_output().expect("it has ended"), SAVED);
        assert!(told.contains("--resume"), "{told}");
        let run = summary(&path.join("runs/hard"));
        assert_eq!(run["steps"], 0);
        let t = run["t"].as_f64().expect("a number");
        assert!(reached <= t && t < 1e-6, "{t} after {reached}");
        reached = t;
    }
}

/// A name below which no file stands that can be read, but a pipe nobody writes into, a folder, a device:
/// an error each, and no waiting.
#[test]
fn what_is_no_file_is_told() {
    let folder = folder_with_scene();
    let path = folder.path();
    vesica(
        path,
        &["run", "small.toml", "--out", "a", "--steps", "3"],
        0,
    );
    let made = Command::new("mkfifo").arg(path.join("pipe")).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
    fs::create_dir(path.join("folder")).expect("it can be made");
    let others = [
        path.join("pipe"),
        path.join("folder"),
        PathBuf::from("/dev/zero"),
    ];
    let mut steps = 3;
    for other in &others {
        let place = |name: &str| {
            let place = path.join("a").join(name);
            let kept = path.join("kept");
            fs::rename(&place, &kept).expect("it is there");
            std::os::unix::fs::symlink(other, &place).expect("a link");
            (place, kept)
        };
        for name in ["history.csv", "shape.csv"] {
            let (_, kept) = place(name);
            steps += 1;
            let end = steps.to_string();
            let resume = [
                "run",
                "small.toml",
                "--out",
                "a",
                "--resume",
                "--steps",
                &end,
            ];
            let told = vesica(path, &resume, 0);
            let words = format!("{name} cannot be read");
            assert!(told.contains(&words), "{other:?}: {told}");
            fs::remove_file(kept).expect("it is there");
        }
        for name in [
            "history.csv",
            "shape.csv",
            "scene.toml",
            "fields/step-0000000.vtu",
        ] {
            let (place, kept) = place(name);
            let told = vesica(path, &["figures", "a", "--out", "b", "--force"], 2);
            assert!(told.contains(name), "{other:?}: {told}");
            fs::rename(kept, place).expect("it is there");
        }
        let other = other.to_str().expect("text");
        let told = vesica(path, &["check", other], 2);
        assert!(told.contains(other), "{told}");
        for values in [
            "vesicle={ shape = 'file', values = 'F' }",
            "nematic.initial={ kind = 'file', values = 'F' }",
            "membrane.spontaneous_curvature={ file = 'F' }",
            "pull.potential={ file = 'F' }",
        ] {
            let values = values.replace('F', other);
            let told = vesica(path, &["run", "small.toml", "--set", &values], 2);
            assert!(told.contains(other), "{told}");
        }
    }
    assert!(!path.join("runs").exists());
}

/// The last step that was solved stands in a run that fails, and why it failed.
#[test]
fn a_run_that_fails_leaves_its_last_good_state() {
    let folder = folder_with_scene();
    let path = folder.path();
    let run = |arguments: &[&str], status| {
        let scene = ["run", "small.toml", "--out", "a"];
        vesica(path, &[&scene[..], arguments].concat(), status)
    };
    run(&["--steps", "7"], 0);
    let good = fs::read(path.join("a/final.vtu")).expect("final.vtu");
    // The energy law closes no better than to rounding.
    let impossible = ["--set", "solver.law_tolerance=1e-300"];
    fs::rename(path.join("a"), path.join("good")).expect("it is there");
    let told = run(&[&impossible[..], &["--steps", "9"]].concat(), 1);
    for words in ["step 1", "tried were", "attempts", "stands in a"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let summary_of = |name: &str| summary(&path.join(name));
    let failed = summary_of("a");
    assert_eq!(
        (&failed["status"], &failed["steps"]),
        (&"failed".into(), &0.into())
    );
    let error = failed["error"].as_str().expect("a reason");
    assert!(error.contains("tried were"), "{error}");
    assert_eq!(
        fs::read(path.join("a/final.vtu")).expect("final.vtu"),
        fs::read(path.join("a/fields/step-0000000.vtu")).expect("the start"),
    );
    assert_ne!(fs::read(path.join("a/final.vtu")).expect("final.vtu"), good);
    let table = fs::read_to_string(path.join("a/history.csv")).expect("history.csv");
    assert_eq!(table.lines().count(), 2, "{table}");
}

/// A folder that was moved while the run went on: where it is now is told. And a link that leads nowhere is
/// called one.
#[test]
fn a_folder_that_moves_away_and_a_link_that_leads_nowhere_are_told() {
    let folder = folder_with_scene();
    let path = folder.path();
    let endless = ["run", "small.toml", "--out", "r", "--steps", "100000000"];
    let child = command(path, &endless).spawn().expect("vesica starts");
    while !path.join("r/checkpoint.bin").is_file() {
        std::thread::sleep(Duration::from_millis(5));
    }
    fs::rename(path.join("r"), path.join("elsewhere")).expect("it can be moved");
    send(&child, "-TERM");
    let told = check(child.wait_with_output().expect("it ends"), 1);
    assert!(!told.contains("stands in r\n"), "{told}");
    if cfg!(target_os = "linux") {
        let now = path.join("elsewhere");
        let words = format!(
            "r was moved while the run went on: what was written until then stands in {}",
            now.display()
        );
        assert!(told.contains(&words), "{told}");
    }

    std::os::unix::fs::symlink("nowhere", path.join("runs")).expect("a link");
    let below = ["run", "small.toml", "--out", "runs/below/it"];
    for arguments in [&["run", "small.toml"][..], &below] {
        let told = vesica(path, arguments, 2);
        assert!(
            told.contains("runs is a symbolic link to nowhere, which is not there"),
            "{told}"
        );
    }
}

#[test]
fn odd_paths_are_no_hindrance() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder_with_scene();
    let path = folder.path();
    for name in [
        &b"two words"[..],
        b"not \xff UTF-8",
        b"-dash",
        "\u{e9}\u{1f9ea}".as_bytes(),
    ] {
        let out = path.join("runs").join(std::ffi::OsStr::from_bytes(name));
        let mut first = command(path, &["run", "small.toml", "--steps", "3", "--out"]);
        check(first.arg(&out).output().expect("vesica starts"), 0);
        let mut second = command(path, &["run", "--resume", "--steps", "6"]);
        let told = check(second.arg(&out).output().expect("vesica starts"), 0);
        assert!(told.contains("goes on from step 3"), "{told}");
        assert_eq!(summary(&out)["steps"], 6);
        // A folder that cannot be: the path and the reason are told.
        let below = out.join("run.json/below");
        let mut third = command(path, &["run", "small.toml", "--out"]);
        let told = check(third.arg(&below).output().expect("vesica starts"), 2);
        assert!(told.contains("run.json/below"), "{told}");
    }
}

#[test]
fn a_scene_that_needs_more_memory_than_there_is_is_refused() {
    let folder = folder_with_scene();
    let path = folder.path();
    for (command, status) in [("run", 2), ("check", 2)] {
        let told = vesica(
            path,
            &[command, "case3", "--set", "mesh.cells=20000"],
            status,
        );
        assert!(
            told.contains("1360 GB") && told.contains("mesh.cells"),
            "{told}"
        );
    }
    assert!(!path.join("runs").exists());
}
