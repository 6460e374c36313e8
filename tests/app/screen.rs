//! What the app writes while it lives (points 2, 3, 4, 5, 6, 12), and what comes from outside of it.

use super::pty::{FRAME, Pty, computed};
use super::{SMALL, VESICA, folder, pause, running, wait_running};
use std::fs;
use std::thread;
use std::time::{Duration, Instant};

/// Bytes of a moving frame of 120 × 40, at most, on the average.
const FRAME_BYTES: usize = 6 << 10;

#[test]
fn paused_and_untouched_nothing_is_written_and_nothing_computed() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    pause(&mut app);
    let before = (app.seen().count, computed(app.pid(), ""), Instant::now());
    // The measurement is over this time; nothing is waited for.
    thread::sleep(Duration::from_secs(2));
    let (count, cost, elapsed) = (
        app.seen().count,
        computed(app.pid(), ""),
        before.2.elapsed(),
    );
    assert_eq!(count, before.0, "bytes");
    assert!(before.1 > Duration::ZERO, "the system counts");
    let cost = cost.saturating_sub(before.1);
    assert!(
        1000 * cost < elapsed,
        "{cost:?} of computing in {elapsed:?}"
    );
    // It is not asleep: a key is answered.
    app.type_keys("?");
    app.wait("an answer", |seen| seen.count > count);
}

#[test]
fn a_moving_frame_has_few_bytes_and_comes_ten_times_a_second() {
    const FRAMES: usize = 30;
    let folder = folder();
    let app = running(&folder, (120, 40));
    app.wait("some frames", |seen| seen.times(FRAME) > 10);
    app.forget_bytes();
    let begun = Instant::now();
    app.wait("more frames", |seen| seen.times(FRAME) > FRAMES);
    let elapsed = begun.elapsed();
    let seen = app.seen();
    let frames = seen.times(FRAME);
    let bytes = seen.bytes.len() / frames;
    println!("{bytes} bytes a frame of 120×40, {frames} frames in {elapsed:?}");
    assert!(bytes <= FRAME_BYTES, "{bytes} bytes a frame");
    assert!(
        frames as f64 <= 10.0 * elapsed.as_secs_f64() + 2.0,
        "{frames} in {elapsed:?}"
    );
}

#[test]
fn every_frame_is_closed_before_the_next_begins() {
    let folder = folder();
    let mut app = running(&folder, (100, 30));
    app.wait("some frames", |seen| seen.times(FRAME) > 10);
    pause(&mut app);
    let seen = app.seen();
    let marks: Vec<u8> = seen
        .bytes
        .windows(FRAME.len())
        .filter(|window| window.starts_with(&FRAME[..FRAME.len() - 1]))
        .map(|window| window[FRAME.len() - 1])
        .collect();
    assert!(marks.len() > 20 && marks.len().is_multiple_of(2));
    assert!(marks.chunks(2).all(|pair| pair == b"hl"), "{marks:?}");
}

#[test]
fn a_slow_link_skips_frames_and_still_hears_keys() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    app.hold(true);
    // Long enough for twenty frames, of which the terminal holds a few.
    thread::sleep(Duration::from_secs(2));
    app.forget_bytes();
    app.type_keys(" ");
    thread::sleep(Duration::from_millis(300));
    app.hold(false);
    app.wait_text("paused");
    app.wait_quiet();
    // At most what was under way, what the terminal held, and the present.
    let frames = app.seen().times(FRAME);
    assert!(frames <= 14, "{frames} frames were queued");
    assert!(app.seen().shows("resume"));
}

#[test]
fn a_storm_of_sizes_is_few_frames_and_any_size_is_survived() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    pause(&mut app);
    app.forget_bytes();
    for n in 0..100 {
        app.resize(60 + n % 50, 20 + n % 20);
    }
    app.resize(90, 28);
    app.wait("the footer in the last row", |seen| {
        let last = seen.terminal.screen().rows(0, 90).nth(27);
        last.is_some_and(|row| row.contains("quit"))
    });
    app.wait_quiet();
    let frames = app.seen().times(FRAME);
    assert!((1..=5).contains(&frames), "{frames} frames for 101 sizes");

    for (columns, rows) in [(1, 1), (2, 200), (400, 1), (1, 30), (300, 100)] {
        app.resize(columns, rows);
        app.wait_quiet();
    }
    app.type_keys(" ");
    app.resize(1, 1);
    app.wait_quiet();
    app.resize(80, 24);
    app.wait_text("running");
    app.type_keys("qy");
    app.assert_restored(0);
}

#[test]
fn the_first_frame_comes_before_the_run_is_set_up() {
    let folder = folder();
    let arguments = [VESICA, "case3", "--set", "mesh.cells=200"];
    let app = Pty::start((120, 40), folder.path(), &arguments, &[]);
    app.wait("a frame", |seen| seen.times(FRAME) > 0);
    app.wait_text("starting");
    app.wait_text("running");
}

#[test]
fn the_editor_gets_the_terminal_and_the_scene_is_loaded_anew() {
    let folder = folder();
    let script = "sed -i 's/end = 1.0/end = 2.0/; s/target = 0.75/target = 0.8/' \"$1\"; tty <&1 > seen; \
                  stty -a > modes\n";
    fs::write(folder.path().join("edit.sh"), script).expect("a file");
    let variables = [("VISUAL", "sh edit.sh"), ("EDITOR", "false")];
    let app_with = |program: &[&str]| Pty::start((110, 34), folder.path(), program, &variables);
    let mut app = app_with(&[VESICA, "small.toml"]);
    wait_running(&app);
    app.type_keys("e");
    // The run is not saved: it is asked before it starts again.
    app.wait_text("Restart small");
    app.type_keys("y");
    app.wait_text("/2000000");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("the editor ran");
    assert!(read("seen").starts_with("/dev/"), "on the terminal");
    assert!(read("modes").contains(" icanon") && read("modes").contains(" echo "));
    app.type_keys("qy");
    app.assert_restored(0);

    // A preset is written to a file of its own.
    let arguments = [
        "--set",
        "mesh.cells=16",
        "--set",
        "membrane.interface_width=0.05",
    ];
    let mut app = app_with(&[&[VESICA, "case2"][..], &arguments].concat());
    app.wait_text("running");
    app.type_keys("e");
    app.wait("another slot", |seen| {
        seen.shows("case2") && folder.path().join("case2.toml").is_file()
    });
    app.type_keys("qy");
    app.assert_restored(0);
    assert!(read("case2.toml").contains("cells = 16"));
    assert_eq!(read("small.toml"), SMALL.replace("end = 1.0", "end = 2.0"));
}

#[test]
fn a_pasted_text_is_no_command_and_a_name_where_one_is_typed() {
    let folder = folder();
    let mut app = running(&folder, (100, 30));
    app.type_keys("\x1b[200~ q\ry\r\x1b[201~");
    app.type_keys("o");
    app.wait_text("circle");
    app.type_keys("\x1b[200~nowhere.toml\x1b[201~\r");
    app.wait_text("cannot read nowhere.toml");
    app.type_keys("\x1b");
    app.wait("the dialog is gone", |seen| !seen.shows("cannot read"));
    app.type_keys("qy");
    app.assert_restored(0);
}

#[test]
fn the_run_of_a_folder_is_shown_as_it_stands() {
    let folder = folder();
    let run = std::process::Command::new(VESICA)
        .args([
            "run",
            "small.toml",
            "--steps",
            "2",
            "--out",
            "first",
            "--quiet",
        ])
        .current_dir(folder.path())
        .status()
        .expect("it starts");
    assert!(run.success());
    let mut app = Pty::start((100, 30), folder.path(), &[VESICA, "first"], &[]);
    app.wait_text("done");
    app.wait_text("2/2");
    // Nothing was computed, so there is nothing to ask.
    app.type_keys("q");
    app.assert_restored(0);
}
