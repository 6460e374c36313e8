//! Parameters that are changed while the run goes: what is saved repeats the run.

use super::{VESICA, folder, pause, running, step};
use std::fs;
use std::path::Path;
use std::process::Command;

const DOWN: &str = "\x1b[B";
const ENTER: &str = "\r";

/// The rows of a table, but for the column `wall`.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).expect("a table");
    let rows = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect());
    let mut rows: Vec<Vec<String>> = rows.collect();
    if let Some(wall) = rows[0].iter().position(|column| column == "wall") {
        rows.iter_mut().for_each(|row| drop(row.remove(wall)));
    }
    rows
}

#[test]
fn a_saved_run_repeats_itself_with_what_was_changed_by_hand() {
    let folder = folder();
    let mut app = running(&folder, (120, 40));
    app.type_keys("a");
    app.wait_text("parallel");
    pause(&mut app);
    app.type_keys("k");
    app.wait_text("Change parameters from the next step on");
    // The third is area.target: a number, over a time.
    app.type_keys(&format!("{DOWN}{DOWN}"));
    app.wait_text("β as a fraction");
    app.type_keys(&format!("1.1{ENTER}r2e-5{ENTER}"));
    app.wait_text("over a time of 2e-5");
    app.type_keys(ENTER);
    app.wait_text("area.target = 1.1 over 2e-5 from the next step on");
    let before = step(&app.seen().text()).expect("a step");
    app.type_keys(" ");
    app.wait("further steps", |seen| {
        step(&seen.text()).is_some_and(|step| step > before + 30)
    });
    app.type_keys("u");
    app.wait_text("area.target = 1.05 from the next step on");
    let before = step(&app.seen().text()).expect("a step");
    app.wait("further steps", |seen| {
        step(&seen.text()).is_some_and(|step| step > before + 5)
    });
    pause(&mut app);
    app.type_keys("S");
    app.wait("the path", |seen| seen.shows("small-set"));
    app.type_keys("q");
    app.assert_restored(0);

    let set = folder.path().join("saved/small-set");
    let scene = fs::read_to_string(set.join("scene.toml")).expect("the scene");
    assert_eq!(scene.matches("[[change]]").count(), 3, "{scene}");
    let history = rows(&set.join("history.csv"));
    let steps = history.last().expect("a row")[0].clone();
    let again = folder.path().join("again");
    let run = Command::new(VESICA)
        .args([
            "run",
            "saved/small-set/scene.toml",
            "--steps",
            &steps,
            "--out",
            "again",
        ])
        .current_dir(folder.path())
        .output()
        .expect("a run");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    assert_eq!(rows(&again.join("history.csv")), history);
    assert_eq!(
        rows(&again.join("ledger.csv")),
        rows(&set.join("ledger.csv"))
    );
}
