//! `--resume` does what it is to do or leaves all as it was, and says what is true.

use super::{check, command, folder_with_scene, summary, vesica};
use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Everything in a folder and below.
fn everything(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            all.extend(everything(&path));
        } else {
            let bytes = fs::read(&path).expect("a file");
            all.insert(path, bytes);
        }
    }
    all
}

/// A run of 20 steps in the folder `a`.
fn run_of_20() -> tempfile::TempDir {
    let folder = folder_with_scene();
    let arguments = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--steps",
        "20",
        "--checkpoint",
        "0",
    ];
    vesica(folder.path(), &arguments, 0);
    folder
}

/// Says in `run.json` that the run goes on, as one does that was killed.
fn kill(run: &Path) {
    let file = run.join("run.json");
    let text = fs::read_to_string(&file).expect("run.json");
    let killed = text.replace("\"status\": \"done\"", "\"status\": \"running\"");
    assert_ne!(killed, text);
    fs::write(&file, killed).expect("it can be written");
}

#[test]
fn what_cannot_be_written_is_seen_before_anything_is_touched() {
    let folder = run_of_20();
    let run = folder.path().join("a");
    for name in [
        "run.json",
        "scene.toml",
        "final.vtu",
        "checkpoint.bin",
        "checkpoint-older.bin",
        "fields/fields.pvd",
        "fields/step-0000030.vtu",
        "inputs/vesicle.txt",
    ] {
        let place = run.join(name);
        let kept = folder.path().join("kept");
        let was_there = fs::rename(&place, &kept).is_ok();
        fs::create_dir_all(&place).expect("it can be made");
        let before = everything(&run);
        let resume = [
            "run",
            "small.toml",
            "--out",
            "a",
            "--resume",
            "--steps",
            "40",
        ];
        let told = vesica(folder.path(), &resume, 1);
        let words = format!("a/{name} is a folder, and the run is to write a file of this name");
        assert!(told.contains(&words), "{words}: {told}");
        assert!(everything(&run) == before, "{name}");
        fs::remove_dir(&place).expect("it is empty");
        if was_there {
            fs::rename(&kept, &place).expect("it is there");
        }
    }
    // When nothing is in the way any more the run goes on.
    vesica(folder.path(), &["run", "a", "--resume", "--steps", "40"], 0);
}

#[test]
fn a_folder_without_its_scene_is_told_with_what_to_do() {
    let folder = run_of_20();
    let scene = folder.path().join("a/scene.toml");
    fs::remove_file(&scene).expect("it is there");
    let told = vesica(folder.path(), &["run", "a", "--resume", "--steps", "30"], 2);
    let words = "a holds a run, but no scene.toml";
    assert!(told.contains(words), "{told}");
    assert!(told.contains("vesica run SCENE --out a --resume"), "{told}");
    let resume = [
        "run",
        "small.toml",
        "--out",
        "a",
        "--resume",
        "--steps",
        "30",
    ];
    vesica(folder.path(), &resume, 0);
    assert!(scene.is_file());
    // A folder without a run is none.
    fs::create_dir(folder.path().join("b")).expect("it can be made");
    let told = vesica(folder.path(), &["run", "b", "--resume"], 2);
    assert!(told.contains("b is a folder, not a scene"), "{told}");
}

/// Nobody waits for a pipe, not even for one that has a writer who never writes.
#[test]
fn a_pipe_in_the_folder_of_a_run_is_not_waited_for() {
    let folder = run_of_20();
    let path = folder.path();
    let mut steps = 20;
    for (name, status) in [
        ("run.json", 0),
        ("history.csv", 0),
        ("ledger.csv", 0),
        ("checkpoint.bin", 0),
        ("fields/step-0000000.vtu", 0),
        ("final.vtu", 0),
        ("scene.toml", 2),
    ] {
        let place = path.join("a").join(name);
        fs::remove_file(&place).expect("it is there");
        let made = Command::new("mkfifo").arg(&place).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
        let writer = OpenOptions::new().read(true).write(true).open(&place);
        let writer = writer.expect("a pipe");
        steps += 1;
        let end = steps.to_string();
        let resume = ["run", "a", "--resume", "--steps", &end];
        let mut child = command(path, &resume).spawn().expect("vesica starts");
        let begun = Instant::now();
        while child.try_wait().expect("a child").is_none() {
            if begun.elapsed() > Duration::from_secs(60) {
                child.kill().expect("it is there");
                panic!("{name} is waited for");
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let told = check(child.wait_with_output().expect("it has ended"), status);
        if !name.starts_with("final") {
            let file = name.strip_prefix("fields/").unwrap_or(name);
            assert!(told.contains(file), "{name}: {told}");
        }
        if status == 0 {
            assert_eq!(summary(&path.join("a"))["status"], "done", "{name}");
        }
        drop(writer);
    }
    vesica(path, &["figures", "a", "--out", "b"], 2);
}

/// A run that was killed and is beyond the end that is asked for keeps its own end, and is recorded as what
/// it is.
#[test]
fn a_killed_run_that_is_beyond_the_end_is_told_as_interrupted() {
    let folder = run_of_20();
    let run = folder.path().join("a");
    kill(&run);
    fs::remove_file(run.join("final.vtu")).expect("it is there");
    let scene = fs::read(run.join("scene.toml")).expect("a scene");
    let resume = ["run", "a", "--resume", "--steps", "10"];
    let told = vesica(folder.path(), &resume, 0);
    assert!(told.contains("was killed"), "{told}");
    assert!(told.contains("at step 20 already"), "{told}");
    let of_run = summary(&run);
    assert_eq!(of_run["status"], "interrupted");
    assert_eq!(
        (&of_run["steps"], &of_run["planned_steps"]),
        (&20.into(), &20.into())
    );
    assert!(of_run["ended"].is_string(), "{of_run}");
    assert!(run.join("final.vtu").is_file());
    assert!(fs::read(run.join("scene.toml")).expect("a scene") == scene);
    let told = vesica(folder.path(), &resume, 0);
    assert!(told.contains("nothing to do"), "{told}");
    assert_eq!(summary(&run), of_run);
}

#[test]
fn a_run_whose_own_words_are_lost_gets_new_ones() {
    let folder = run_of_20();
    let run = folder.path().join("a");
    for text in ["", "{", "[]", "{\"status\": \"flying\"}"] {
        fs::write(run.join("run.json"), text).expect("it can be written");
        let told = vesica(folder.path(), &["run", "a", "--resume"], 0);
        assert!(told.contains("run.json cannot be read"), "{text}: {told}");
        assert_eq!(summary(&run)["status"], "done");
        assert_eq!(summary(&run)["steps"], 20);
    }
}

/// Also where it cannot be gone on with; and when it can be, its record is ended.
#[test]
fn a_killed_run_that_cannot_go_on_is_told_as_interrupted() {
    let folder = run_of_20();
    let run = folder.path().join("a");
    kill(&run);
    let last = run.join("final.vtu");
    fs::remove_file(&last).expect("it is there");
    fs::create_dir(&last).expect("it can be made");
    vesica(folder.path(), &["run", "a", "--resume"], 1);
    assert_eq!(summary(&run)["status"], "interrupted");
    fs::remove_dir(&last).expect("it is empty");
    vesica(folder.path(), &["run", "a", "--resume"], 0);
    assert_eq!(summary(&run)["status"], "done");
    assert!(last.is_file());
}
