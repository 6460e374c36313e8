//! What the app keeps from one time to the next, and what it says of that.

use super::pty::{ENTER, LIMIT, Pty};
use super::{VESICA, folder, kept, pause, running, step, wait_running};
use nix::sys::signal::Signal;
use std::fs;
use std::path::Path;
use std::time::Duration;
use tempfile::TempDir;

/// How long the process may outlive its terminal.
const OUTLIVE: Duration = Duration::from_secs(2);

fn start(folder: &TempDir) -> Pty {
    Pty::start((120, 40), folder.path(), &[VESICA, "small.toml"], &[])
}

/// Leaves a paused run behind, and tells its step.
fn left_behind(folder: &TempDir) -> u64 {
    let mut app = running(folder, (120, 40));
    pause(&mut app);
    let left = step(&app.seen().text()).expect("a step");
    quit(&mut app);
    left
}

#[track_caller]
fn quit(app: &mut Pty) {
    app.type_keys("q");
    app.wait_text("Leave vesica?");
    app.type_keys("y");
    app.assert_restored(0);
}

#[test]
fn the_next_time_it_goes_on_where_it_was() {
    for hang_up in [false, true] {
        let folder = folder();
        let mut app = running(&folder, (120, 40));
        pause(&mut app);
        let left = step(&app.seen().text()).expect("a step");
        if hang_up {
            app.hang_up();
            assert_eq!(app.exit_status(OUTLIVE), 129);
        } else {
            app.type_keys("qy");
            app.assert_restored(0);
        }

        let mut app = Pty::start((120, 40), folder.path(), &[VESICA, "small.toml"], &[]);
        app.wait_text(&format!("small at step {left}"));
        // Nothing begins before the answer.
        app.wait_quiet();
        assert_eq!(step(&app.seen().text()), None);
        app.type_keys("y");
        app.wait("a run that goes on", |seen| {
            step(&seen.text()).is_some_and(|step| step > left)
        });
        app.type_keys("qy");
        app.assert_restored(0);

        // Another scene is not meant.
        let other = [VESICA, "small.toml", "--set", "mesh.cells=18"];
        let mut app = Pty::start((120, 40), folder.path(), &other, &[]);
        wait_running(&app);
        app.type_keys("qy");
        app.assert_restored(0);
        assert_eq!(kept(&folder).len(), 2);
    }
}

#[test]
fn escape_changes_nothing_and_a_new_beginning_puts_the_old_run_aside() {
    let folder = folder();
    let left = left_behind(&folder);
    let first = kept(&folder).remove(0);
    let files = |path: &Path| {
        ["checkpoint.bin", "history.csv"].map(|name| fs::read(path.join(name)).expect("a file"))
    };
    let before = files(&first);

    let mut app = start(&folder);
    app.wait_text(&format!("small at step {left}"));
    app.type_keys("\x1b");
    app.wait_text("stays as it is");
    wait_running(&app);
    quit(&mut app);
    assert_eq!(files(&first), before);
    let beside = format!("{}-2", first.display());
    assert_eq!(kept(&folder), [first.clone(), beside.clone().into()]);

    // The next time it asks again, and after that the new run is the one that is asked about.
    let mut app = start(&folder);
    app.wait_text(&format!("small at step {left}"));
    app.type_keys("n");
    let aside = format!(
        "unfinished/{}-3",
        first.file_name().unwrap().to_string_lossy()
    );
    app.wait("the name", |seen| {
        seen.text().replace('\n', "").contains(&aside)
    });
    assert_eq!(files(format!("{}-3", first.display()).as_ref()), before);
    wait_running(&app);
    pause(&mut app);
    let second = step(&app.seen().text()).expect("a step");
    quit(&mut app);
    let mut app = start(&folder);
    app.wait_text(&format!("small at step {second}"));
    app.type_keys("\x03");
    app.assert_restored(0);

    // What was put aside is opened by its name, and goes on there.
    let program = [VESICA, &format!("saved/{aside}")];
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    app.wait_text(&format!("at step {left}"));
    app.type_keys("y");
    app.wait("a run that goes on", |seen| {
        step(&seen.text()).is_some_and(|step| step > left)
    });
    quit(&mut app);
    assert_eq!(kept(&folder).len(), 3);
}

#[test]
fn a_second_app_on_the_scene_says_so_and_keeps_its_own() {
    let folder = folder();
    let left = left_behind(&folder);
    let first = kept(&folder).remove(0);
    let mut one = start(&folder);
    one.wait_text(&format!("small at step {left}"));
    one.type_keys("y");
    wait_running(&one);
    let mut other = start(&folder);
    other.wait_text("in use by another app");
    wait_running(&other);
    pause(&mut one);
    let furthest = step(&one.seen().text()).expect("a step");
    quit(&mut one);
    quit(&mut other);
    assert_eq!(
        kept(&folder),
        [first.clone(), format!("{}-2", first.display()).into()]
    );
    let mut app = start(&folder);
    app.wait_text(&format!("small at step {furthest}"));
    app.type_keys("\x03");
    app.assert_restored(0);
}

#[test]
fn the_folder_of_a_run_that_goes_on_is_refused_and_the_other_runs_are_named() {
    let folder = folder();
    left_behind(&folder);
    let first = kept(&folder).remove(0);
    let name = first.file_name().unwrap().to_string_lossy().into_owned();
    let source = format!("saved/unfinished/{name}");
    let program = [VESICA, source.as_str()];
    let mut one = Pty::start((120, 40), folder.path(), &program, &[]);
    one.wait_text("Go on where you were");
    let mut other = Pty::start((120, 40), folder.path(), &program, &[]);
    other.assert_restored(2);
    let text = other.seen().text().replace('\n', "");
    assert!(text.contains("is in use by another process"), "{text}");
    assert!(text.contains(&format!("{source}/scene.toml")), "{text}");
    assert_eq!(other.seen().times(ENTER), 0);
    // Where it is open already it is looked at.
    one.type_keys("y");
    wait_running(&one);
    one.type_keys(&format!("o{source}\r"));
    one.wait_text("is unchanged");
    one.type_keys("osmall.toml\r");
    one.wait_text("in use by another app");
    wait_running(&one);
    one.type_keys("qy");
    one.assert_restored(0);
    assert_eq!(kept(&folder).len(), 2);
    let mut app = start(&folder);
    app.wait_text("Of small another run is kept in");
    app.wait("its folder", |seen| {
        let text = seen.text();
        text.contains(&format!("{name}-2")) && text.contains("o opens a run")
    });
    app.type_keys("\x03");
    app.assert_restored(0);
}

#[test]
fn a_state_that_cannot_be_kept_is_an_error_before_the_end_and_after_it() {
    for end in ["quit", "signal"] {
        let folder = folder();
        fs::write(folder.path().join("saved"), "").expect("a file");
        let mut app = running(&folder, (120, 40));
        app.wait_text("not kept");
        if end == "quit" {
            app.type_keys("q");
            app.wait_text("cannot be kept");
            assert!(!app.seen().shows("another time"));
            app.type_keys("y");
        } else {
            app.signal(Signal::SIGTERM);
        }
        app.assert_restored(1);
        let text = app.seen().text().replace('\n', "");
        assert!(text.contains("not kept: small (step "), "{text}");
        assert!(text.contains("Not a directory"), "{text}");
        assert!(text.contains("nothing was saved"), "{text}");
    }
}

#[test]
fn what_comes_in_the_way_later_is_seen_before_the_end() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    pause(&mut app);
    app.type_keys("q");
    app.wait_text("The runs are kept");
    app.type_keys("n");
    fs::remove_dir_all(folder.path().join("saved")).expect("a folder");
    fs::write(folder.path().join("saved"), "").expect("a file");
    app.type_keys("q");
    app.wait_text("cannot be kept");
    // Whoever mends it loses nothing.
    fs::remove_file(folder.path().join("saved")).expect("a file");
    app.type_keys("nq");
    app.wait_text("The runs are kept");
    app.type_keys("y");
    app.assert_restored(0);
    assert_eq!(kept(&folder).len(), 1);
}

#[test]
fn a_damaged_state_is_told_and_put_aside() {
    let folder = folder();
    left_behind(&folder);
    let first = kept(&folder).remove(0);
    for name in ["checkpoint.bin", "checkpoint-older.bin"] {
        fs::write(first.join(name), "damaged").expect("a file");
    }
    let mut app = start(&folder);
    let aside = format!("{}-unusable", first.file_name().unwrap().to_string_lossy());
    app.wait("what is wrong", |seen| {
        let text = seen.text();
        text.contains("cannot be resumed") && text.contains("unusable")
    });
    wait_running(&app);
    quit(&mut app);
    let aside = first.with_file_name(aside);
    assert_eq!(
        fs::read(aside.join("checkpoint.bin")).expect("a file"),
        b"damaged"
    );
    assert_eq!(kept(&folder), [first, aside]);
}

#[test]
fn what_a_killed_process_saved_by_half_is_removed_and_told() {
    let folder = folder();
    let half = folder.path().join("saved/.vesica-killed.part/fields");
    fs::create_dir_all(&half).expect("a folder");
    fs::write(half.join(".vesica-a.part"), vec![0; 3_000_000]).expect("a file");
    let mut app = running(&folder, (120, 40));
    app.wait_text("(3.00 MB)");
    assert!(!folder.path().join("saved/.vesica-killed.part").exists());
    quit(&mut app);
}

#[test]
fn a_wrong_scene_in_the_dialog_is_told_once_and_rightly() {
    let folder = folder();
    fs::write(folder.path().join("wrong.toml"), "[mesh]\nsells = 8\n").expect("a file");
    let mut app = running(&folder, (120, 40));
    pause(&mut app);
    app.type_keys("owrong.toml");
    app.wait_text("sells");
    let text = app.seen().text();
    assert_eq!(text.matches("wrong.toml:2").count(), 1, "{text}");
    assert!(!text.contains("wrong.toml: "), "{text}");
    app.type_keys("\r");
    app.wait_text("wrong.toml:2");
    app.wait_quiet();
    assert!(!app.seen().shows("no such scene"), "{}", app.seen().text());
    // With what follows at once it would be another key.
    app.type_keys("\x1b");
    app.wait("the end of the dialog", |seen| !seen.shows("Open a scene"));
    quit(&mut app);
}

#[test]
fn after_a_saved_set_it_is_not_said_that_there_is_none() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    app.type_keys("S");
    app.wait("the path", |seen| seen.shows("small-set"));
    wait_running(&app);
    app.type_keys("q");
    app.wait_text("Figures of small are saved up to step ");
    assert!(!app.seen().shows("No figures"));
    app.type_keys("y");
    assert_eq!(app.exit_status(LIMIT), 0);
    // The whole history, from the rows on the disk.
    let set = folder.path().join("saved/small-set");
    let history = fs::read_to_string(set.join("history.csv")).expect("a table");
    let rows = history.lines().count() - 1;
    let last = history
        .lines()
        .last()
        .and_then(|line| line.split(',').next());
    assert_eq!(last, Some(&*(rows - 1).to_string()));
    let ledger = fs::read_to_string(set.join("ledger.csv")).expect("a table");
    assert_eq!(ledger.lines().count(), rows);
}
