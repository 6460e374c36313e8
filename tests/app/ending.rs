//! How the app ends, and that the terminal is then as it was (points 9, 10, 11, 15, 16).

use super::pty::{ENTER, FRAME, LEAVE, LIMIT, Pty, child_named, send};
use super::{VESICA, folder, kept, pause, running, wait_running};
use nix::sys::signal::Signal;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Its first step takes minutes, in many parts.
const HARD: &str = "
mesh.cells = 20
membrane = { interface_width = 0.05, spontaneous_curvature = '1e7*sign(x-0.5)' }
vesicle = { shape = 'circle', radius = 0.25 }
area = { target = 1.25, penalty = 1e-3 }
time = { step = 1e-6, end = 1.0 }
";

/// How long the process may outlive its terminal.
const OUTLIVE: Duration = Duration::from_secs(2);

#[test]
fn quitting_asks_restores_the_terminal_and_leaves_a_line() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    app.type_keys("q");
    app.wait_text("Leave vesica?");
    app.wait_text("The runs are kept");
    app.type_keys("y");
    app.assert_restored(0);
    let seen = app.seen();
    assert_eq!((seen.times(ENTER), seen.times(LEAVE)), (1, 1));
    let text = seen.text();
    // After the app's screen, and nothing else; it may be longer than a row.
    let line = text.trim().replace('\n', "");
    assert!(line.starts_with("small: step "), "{text}");
    assert!(
        line.contains(" of 1000000, t = ") && line.contains("E_total = "),
        "{line}"
    );
    let kept = kept(&folder);
    assert_eq!(kept.len(), 1, "{kept:?}");
    let path = kept[0].canonicalize().expect("a path");
    assert!(
        line.contains(&format!("; kept in {} (", path.display())),
        "{line}"
    );
    assert!(line.ends_with("kB)"), "{line}");
}

/// The step that the last line tells.
fn step_of_line(line: &str) -> u64 {
    let after = line.strip_prefix("small: step ").expect(line);
    let step = after.split(' ').next().expect("a word");
    step.parse().expect(line)
}

#[test]
fn the_line_tells_the_step_that_is_kept_and_asked_about_the_next_time() {
    let folder = folder();
    // Also where it was not asked to leave, and runs on until the last moment.
    for end in ["quit", "signal"] {
        let mut app = running(&folder, (120, 40));
        if end == "quit" {
            app.type_keys("q");
            app.wait_text("The runs are kept");
            app.type_keys("y");
            app.assert_restored(0);
        } else {
            app.signal(Signal::SIGTERM);
            app.assert_restored(143);
        }
        let line = app.seen().text().trim().replace('\n', "");
        let step = step_of_line(&line);
        let mut app = Pty::start((120, 40), folder.path(), &[VESICA, "small.toml"], &[]);
        app.wait_text(&format!("small at step {step} (t = "));
        app.type_keys("\x03");
        app.assert_restored(0);
        std::fs::remove_dir_all(folder.path().join("saved")).expect("a folder");
    }
}

#[test]
fn a_run_that_failed_is_told_by_the_line_and_by_the_exit_status() {
    for (setting, status, why) in [
        ("solver.law_tolerance=1e-300", 1, "failed: step 1 to t = "),
        ("mesh.cells=20000", 2, "failed: a mesh "),
    ] {
        let folder = folder();
        let program = [VESICA, "small.toml", "--set", setting];
        let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
        app.wait("the failure", |seen| seen.shows(" failed "));
        // It asks where a part of the step was taken.
        app.type_keys("qy");
        app.assert_restored(status);
        let line = app.seen().text().trim().replace('\n', "");
        assert!(line.starts_with("small: ") && line.contains(why), "{line}");
    }
}

#[test]
fn a_run_that_is_left_within_its_first_step_is_told_and_saved_as_far_as_it_is_known() {
    let folder = folder();
    std::fs::write(folder.path().join("hard.toml"), HARD).expect("a file");
    let program = [VESICA, "hard.toml"];
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    app.wait("a part of the step", |seen| {
        seen.shows("within step 1") && !seen.shows("t 0.000e0")
    });
    app.type_keys("q");
    app.wait_text("step 1, t = ");
    app.type_keys("nS");
    app.wait("the path", |seen| seen.shows("hard-set"));
    let set = folder.path().join("saved/hard-set");
    for file in [
        "history.csv",
        "ledger.csv",
        "fields/fields.pvd",
        "fields/step-0000000.vtu",
    ] {
        assert!(set.join(file).is_file(), "{file}");
    }
    app.signal(Signal::SIGTERM);
    app.assert_restored(143);
    let line = app.seen().text().trim().replace('\n', "");
    assert!(
        line.starts_with("hard: step 0 of 1000000, t = 0, E_total = "),
        "{line}"
    );
    let (_, after) = line.split_once(", and within step 1 at t = ").expect(&line);
    let t = after.split(';').next().expect("a time").to_owned();
    assert!(
        t.parse::<f64>().is_ok_and(|t| t > 0.0 && t < 1e-6),
        "{line}"
    );
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    app.wait_text("hard within step 1");
    app.wait_text(&format!("{t})?"));
    app.type_keys("\x03");
    app.assert_restored(0);
}

#[test]
fn what_was_saved_stands_in_the_line_and_in_its_place() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    pause(&mut app);
    app.type_keys("S");
    app.wait("the path", |seen| seen.shows("small-set"));
    // OSC 52 with the same path.
    let path = folder
        .path()
        .canonicalize()
        .expect("a path")
        .join("saved/small-set");
    let encoded = base64::Engine::encode(
        &base64::engine::general_purpose::STANDARD,
        path.display().to_string(),
    );
    let copy = format!("\x1b]52;c;{encoded}\x07");
    app.wait("the copy", |seen| seen.times(copy.as_bytes()) == 1);
    for file in ["scene.toml", "history.csv"] {
        assert!(path.join(file).is_file(), "{file}");
    }
    app.type_keys("q");
    app.assert_restored(0);
    let text = app.seen().text().replace('\n', "");
    assert!(
        text.contains(&format!("saved in {}", path.display())),
        "{text}"
    );
}

#[test]
fn signals_restore_the_terminal_and_save_what_there_is() {
    for (signal, number) in [
        (Signal::SIGTERM, 15),
        (Signal::SIGINT, 2),
        (Signal::SIGHUP, 1),
        (Signal::SIGUSR1, 10),
        (Signal::SIGUSR2, 12),
        (Signal::SIGXCPU, 24),
        (Signal::SIGALRM, 14),
    ] {
        let folder = folder();
        let mut app = running(&folder, (80, 24));
        app.signal(signal);
        app.assert_restored(128 + number);
        let seen = app.seen();
        assert_eq!((seen.times(ENTER), seen.times(LEAVE)), (1, 1), "{signal:?}");
        let text = seen.text().replace('\n', "");
        assert!(
            text.contains("small: step ") && text.contains("kept in /"),
            "{text}"
        );
        only_kept(&folder);
    }
}

/// One kept state is all that an end without a question leaves.
#[track_caller]
fn only_kept(folder: &TempDir) {
    assert_eq!(kept(folder).len(), 1);
    let saved = std::fs::read_dir(folder.path().join("saved")).expect("a folder");
    let names: Vec<_> = saved.flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(names, ["unfinished"]);
}

#[test]
fn a_terminal_that_goes_away_ends_the_process() {
    let shells = [
        ("delivered", format!("exec {VESICA} small.toml")),
        ("ignored", format!("trap '' HUP; exec {VESICA} small.toml")),
        // Never delivered at all: only the poll of the terminal can tell.
        (
            "blocked",
            format!("exec env --block-signal=HUP {VESICA} small.toml"),
        ),
    ];
    for (how, command) in shells {
        for state in ["running", "paused", "stopped"] {
            let folder = folder();
            let program = ["sh", "-c", command.as_str()];
            let mut app = Pty::start((100, 30), folder.path(), &program, &[]);
            wait_running(&app);
            if state == "paused" {
                pause(&mut app);
            }
            // Continued by the system, the app wants to take back a terminal that has gone.
            if state == "stopped" {
                app.hang_up_stopped();
            } else {
                app.hang_up();
            }
            let status = app.exit_status(OUTLIVE);
            assert_eq!(status, 129, "SIGHUP {how}, {state}");
            only_kept(&folder);
        }
    }
}

/// The app in a terminal that takes no more bytes, for it is full of frames.
fn stalled(folder: &TempDir) -> Pty {
    let app = running(folder, (300, 100));
    app.hold(true);
    for n in 0..12 {
        app.resize(299 + n % 2, 100);
        std::thread::sleep(Duration::from_millis(150));
    }
    app
}

#[test]
fn a_link_that_takes_nothing_more_does_not_hold_up_the_end() {
    let folder = folder();
    let mut app = stalled(&folder);
    app.signal(Signal::SIGTERM);
    assert_eq!(app.exit_status(OUTLIVE), 143);
    only_kept(&folder);
    // What the terminal reads when the app has ended puts it back.
    app.hold(false);
    app.assert_restored(143);
}

#[test]
fn a_link_that_stalls_for_a_second_at_the_end_restores_the_terminal() {
    for (keys, status) in [(None, 143), (Some("qy"), 0)] {
        let folder = folder();
        let mut app = stalled(&folder);
        match keys {
            None => app.signal(Signal::SIGTERM),
            Some(keys) => app.type_keys(keys),
        }
        std::thread::sleep(Duration::from_millis(1250));
        app.hold(false);
        app.assert_restored(status);
        let seen = app.seen();
        assert_eq!((seen.times(ENTER), seen.times(LEAVE)), (1, 1), "{keys:?}");
    }
}

#[test]
fn a_terminal_that_claims_to_be_immense_is_drawn_on_in_part() {
    let folder = folder();
    let mut app = running(&folder, (100, 30));
    let frames = app.seen().times(FRAME);
    app.claim_size(u16::MAX, u16::MAX);
    app.wait("frames", |seen| seen.times(FRAME) > frames + 1);
    app.claim_size(u16::MAX, 1);
    app.claim_size(100, 30);
    app.wait("the usual frame", |seen| {
        seen.shows("running") && seen.shows("quit")
    });
    app.type_keys("qy");
    app.assert_restored(0);
}

#[test]
fn a_terminal_that_can_place_no_text_is_refused_as_a_pipe_is() {
    let folder = folder();
    let unset = format!("unset TERM; exec {VESICA} small.toml");
    for (term, program) in [
        ("dumb", &[VESICA, "small.toml"][..]),
        ("DUMB", &[VESICA, "small.toml"]),
        ("vt52", &[VESICA, "small.toml"]),
        ("", &[VESICA, "small.toml"]),
        ("dumb", &[VESICA, "small.toml", "--color", "none"]),
        ("xterm", &["sh", "-c", &unset]),
    ] {
        let mut app = Pty::start((80, 24), folder.path(), program, &[("TERM", term)]);
        assert_eq!(app.exit_status(LIMIT), 2, "{term}");
        app.wait_text("vesica run small.toml");
        assert!(app.seen().shows("TERM is"), "{}", app.seen().text());
        assert_eq!(app.seen().times(b"\x1b"), 0, "{term}");
    }
    // Whoever wants no colours is no such terminal.
    let program = [VESICA, "small.toml"];
    let mut app = Pty::start((100, 30), folder.path(), &program, &[("NO_COLOR", "1")]);
    wait_running(&app);
    app.type_keys("qy");
    app.assert_restored(0);
}

#[test]
fn a_stop_gives_the_terminal_back_and_a_return_draws_at_the_new_size() {
    let folder = folder();
    let shell = ["bash", "--norc", "--noprofile", "-i"];
    let mut app = Pty::start((80, 24), folder.path(), &shell, &[("PS1", "shell> ")]);
    app.wait_text("shell>");
    app.type_keys(&format!("{VESICA} small.toml\r"));
    app.wait_text("running");
    app.type_keys("\x1a");
    app.wait("the shell", |seen| {
        !seen.terminal.screen().alternate_screen() && seen.shows("Stopped")
    });
    assert!(!app.seen().terminal.screen().hide_cursor());
    assert!(!app.seen().terminal.screen().bracketed_paste() || app.seen().shows("shell>"));
    app.type_keys("stty -a | tr ' ' '\\n' | grep -x -e icanon -e echo\r");
    app.wait("the modes", |seen| seen.text().contains("\nicanon\necho\n"));

    app.resize(110, 36);
    app.type_keys("clear; fg\r");
    app.wait("the app", |seen| {
        seen.terminal.screen().alternate_screen() && seen.shows("running") && seen.shows("quit")
    });
    let last = app.seen().terminal.screen().rows(0, 110).nth(35);
    assert!(
        last.is_some_and(|row| row.contains("quit")),
        "the footer is in the last row"
    );

    // Another process may ask for the stop.
    let vesica = child_named(app.pid(), "vesica").expect("the app");
    let prompts = app.seen().times(b"shell> ");
    send(vesica, Signal::SIGTSTP);
    // What is typed before the shell has the terminal again may be lost.
    app.wait("the shell", |seen| {
        !seen.terminal.screen().alternate_screen() && seen.times(b"shell> ") > prompts
    });
    app.type_keys("fg\r");
    app.wait("the app", |seen| {
        seen.terminal.screen().alternate_screen() && seen.shows("running")
    });
    app.type_keys("qy");
    app.wait("the line", |seen| seen.shows("small: step "));
    assert_eq!(app.seen().times(ENTER), 3);
    assert_eq!(app.seen().times(LEAVE), 3);
    app.type_keys("exit\r");
    app.assert_restored(0);
}

#[test]
fn without_a_shell_a_stop_is_refused() {
    let folder = folder();
    let mut app = running(&folder, (100, 30));
    app.type_keys("\x1a");
    app.wait_text("no shell that would continue");
    app.type_keys("qy");
    app.assert_restored(0);
}

#[test]
fn without_a_terminal_the_app_points_to_the_command_that_needs_none() {
    let folder = folder();
    for arguments in [&["small.toml"][..], &[]] {
        let output = Command::new(VESICA)
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .output()
            .expect("it starts");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        let scene = arguments.first().unwrap_or(&"case3-quick");
        assert!(told.contains(&format!("vesica run {scene}")), "{told}");
        assert!(told.contains("output is not a terminal"), "{told}");
        assert!(output.stdout.is_empty() && !told.contains('\x1b'), "{told}");
    }
    // Only the input is none.
    let command = format!("{VESICA} small.toml < /dev/null");
    let mut app = Pty::start((80, 24), folder.path(), &["sh", "-c", &command], &[]);
    assert_eq!(app.exit_status(LIMIT), 2);
    app.wait_text("input is not a terminal");
    assert_eq!(app.seen().times(b"\x1b"), 0);
}

#[test]
fn a_wrong_scene_is_told_before_the_terminal_is_touched() {
    let folder = folder();
    std::fs::write(folder.path().join("wrong.toml"), "[mesh]\nsells = 8\n").expect("a file");
    for arguments in [
        &["wrong.toml"][..],
        &["nowhere.toml"],
        &["case33"],
        &["case3", "--set", "mesh.cells=-1"],
        &["case3", "--fps", "0"],
        &["case3", "--color", "blue"],
    ] {
        let program = [&[VESICA], arguments].concat();
        let mut app = Pty::start((80, 24), folder.path(), &program, &[]);
        assert_eq!(app.exit_status(LIMIT), 2, "{arguments:?}");
        app.wait_text("error");
        assert_eq!(app.seen().times(ENTER), 0, "{arguments:?}");
    }
}
