//! Signals: what ends a run, and what is left then.

use super::*;
use signal_hook::consts::{SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};
use std::process::Child;

/// A run that would take days, once it has made a step.
fn long_run(folder: &Path, mut command: Command) -> Child {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    let deadline = Instant::now() + Duration::from_secs(60);
    let history = folder.join("a/history.csv");
    while !fs::read_to_string(&history).is_ok_and(|text| text.lines().count() > 3) {
        assert!(Instant::now() < deadline, "no step was made");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

fn send(child: &Child, signal: i32) {
    let status = Command::new("kill")
        .args([format!("-{signal}"), child.id().to_string()])
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// Also within a step that never comes to its end.
#[test]
fn a_study_of_accuracy_is_ended_by_a_signal() {
    let folder = folder_with_scene();
    let path = folder.path();
    let hard = "mesh.cells = 20\nvesicle = { shape = 'circle', radius = 0.25 }\n[area]\n\
        [membrane]\ninterface_width = 0.05\nspontaneous_curvature = '1e6*sign(x - 0.5)'\n\
        [time]\nstep = 1e-6\nend = 1.0\n";
    fs::write(path.join("hard.toml"), hard).expect("it can be written");
    let child = Command::new(env!("CARGO_BIN_EXE_vesica"))
        .args(["accuracy", "hard.toml", "--budget", "600"])
        .current_dir(path)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    std::thread::sleep(Duration::from_millis(1000));
    // Not SIGINT: what runs the tests in the background may have it ignored.
    send(&child, SIGTERM);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(143), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("ended by SIGTERM"),
        "{}",
        stderr(&output)
    );
}

/// The exit status of a run that a signal has ended and that is saved.
const SAVED: i32 = 75;

const ARGUMENTS: [&str; 8] = [
    "run",
    "small.toml",
    "--out",
    "a",
    "--steps",
    "1000000000",
    "--every",
    "100",
];

#[test]
fn end_a_run_cleanly() {
    for (signal, name, times) in [
        (SIGINT, "Ctrl-C", 1),
        (SIGTERM, "SIGTERM", 1),
        (SIGHUP, "SIGHUP", 1),
        (SIGQUIT, "SIGQUIT", 1),
        // Batch systems warn with these; the last comes again every second.
        (SIGUSR1, "SIGUSR1", 2),
        (SIGUSR2, "SIGUSR2", 2),
        (SIGALRM, "SIGALRM", 1),
        (SIGXCPU, "SIGXCPU", 3),
    ] {
        if crate::ignored::is_ignored(signal) {
            continue;
        }
        let folder = folder_with_scene();
        let path = folder.path();
        let child = long_run(path, command(path, &ARGUMENTS));
        for _ in 0..times {
            send(&child, signal);
        }
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(SAVED), "{}", stderr(&output));
        assert!(stderr(&output).contains(name), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("saved in a"),
            "{}",
            stderr(&output)
        );

        let run = summary(path, "a");
        assert_eq!(run["status"], "interrupted");
        assert!(path.join("a/final.vtu").is_file());
        let history = fs::read_to_string(path.join("a/history.csv")).expect("it is there");
        let last = history
            .lines()
            .last()
            .and_then(|line| line.split(',').next());
        assert_eq!(last, Some(run["steps"].to_string().as_str()));
    }
}

#[test]
fn what_the_parent_ignores_stays_ignored() {
    let folder = folder_with_scene();
    let path = folder.path();
    let mut shell = Command::new("sh");
    shell
        .current_dir(path)
        .args(["-c", "trap '' INT USR1; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_vesica"))
        .args(ARGUMENTS)
        .stdin(Stdio::null());
    let child = long_run(path, shell);
    send(&child, SIGINT);
    send(&child, SIGUSR1);
    let rows = || fs::read_to_string(path.join("a/history.csv")).map(|text| text.lines().count());
    let before = rows().expect("it is there");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !rows().is_ok_and(|rows| rows > before + 3) {
        assert!(Instant::now() < deadline, "it does not go on");
        std::thread::sleep(Duration::from_millis(20));
    }
    send(&child, SIGTERM);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(SAVED));
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_under_nohup_outlives_its_terminal() {
    let folder = folder_with_scene();
    let path = folder.path();
    let mut nohup = Command::new("nohup");
    nohup
        .current_dir(path)
        .arg(env!("CARGO_BIN_EXE_vesica"))
        .args(ARGUMENTS)
        .stdin(Stdio::null());
    let mut child = long_run(path, nohup);
    send(&child, SIGHUP);
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().is_ok_and(|status| status.is_none()));
    send(&child, SIGTERM);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(SAVED));
}

#[test]
fn a_killed_run_leaves_whole_lines() {
    let folder = folder_with_scene();
    let path = folder.path();
    let mut child = long_run(path, command(path, &ARGUMENTS));
    child.kill().expect("it is there to be killed");
    child.wait().expect("it ends");
    let history = fs::read_to_string(path.join("a/history.csv")).expect("it is there");
    assert!(history.ends_with('\n'));
    assert!(history.lines().all(|line| line.split(',').count() == 14));
    assert_eq!(summary(path, "a")["status"], "running");
}

#[test]
fn a_run_whose_folder_vanishes_tells_it_and_goes_on() {
    let folder = folder_with_scene();
    let path = folder.path();
    let mut child = long_run(path, command(path, &ARGUMENTS));
    fs::rename(path.join("a"), path.join("b")).expect("it can be moved");
    std::thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().is_ok_and(|status| status.is_none()));
    send(&child, SIGTERM);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told = stderr(&output);
    // Which of the tables notices depends on where between two writes the folder goes.
    assert!(
        told.contains("cannot write a/") || told.contains(".csv has vanished"),
        "{told}"
    );
    assert!(told.contains("goes on in memory"), "{told}");
    assert!(!told.contains("panicked"), "{told}");
    assert!(!path.join("a").exists());
}
