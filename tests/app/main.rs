//! The real binary in a pseudo-terminal: how the app begins, behaves and ends. The numbers are those
//! of the points of the terminal app's specification. On Linux, whose process table tells what a process
//! costs.

#![cfg(target_os = "linux")]

mod changing;
mod ending;
mod input;
mod keeping;
mod lasting;
mod pty;
mod screen;
mod speed;

use pty::Pty;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const VESICA: &str = env!("CARGO_BIN_EXE_vesica");

/// A small scene that steps fast and does not end within a test.
const SMALL: &str = "\
name = \"Small\"
[mesh]
cells = 20
[vesicle]
shape = \"ellipse\"
half_axes = [0.35, 0.2]
angle = 90
[time]
step = 1e-6
end = 1.0
[membrane]
interface_width = 0.04
[area]
target = 1.05
[nematic]
[anchoring]
kind = \"homeotropic\"
";

/// A folder with the small scene in `small.toml`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("small.toml"), SMALL).expect("it can be written");
    folder
}

/// The app on the small scene, running.
fn running(folder: &TempDir, size: (u16, u16)) -> Pty {
    let app = Pty::start(size, folder.path(), &[VESICA, "small.toml"], &[]);
    wait_running(&app);
    app
}

/// Waits until the run that is shown has made some steps.
#[track_caller]
fn wait_running(app: &Pty) {
    app.wait("a run that goes on", |seen| {
        seen.shows("running") && step(&seen.text()).is_some_and(|step| step > 3)
    });
}

/// The step that the header tells.
fn step(screen: &str) -> Option<u64> {
    let (_, after) = screen.split_once(" step ")?;
    after.split('/').next()?.trim().parse().ok()
}

/// The runs that are kept, with a whole state, in the order of their names.
fn kept(folder: &TempDir) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.path().join("saved/unfinished"));
    let paths = entries.into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = paths.map(|entry| entry.path()).collect();
    paths.retain(|path| path.join("checkpoint.bin").is_file());
    paths.sort();
    paths
}

/// Pauses the app.
#[track_caller]
fn pause(app: &mut Pty) {
    app.type_keys(" ");
    app.wait_text("paused");
    app.wait_quiet();
}
