//! What being watched costs a run.

use super::pty::{LIMIT, Pty};
use super::{VESICA, folder, step, wait_running};
use std::process::Command;
use std::time::{Duration, Instant};

const STEPS: u64 = 400;
/// Steps before the measurement: the set-up is not part of it.
const FIRST: u64 = 50;
const ROUNDS: usize = 4;

/// Measures, and prints: the speed of the solver under the app on a terminal of 120 × 40 against
/// that of `vesica run`, at Table 1's size, by turns.
///
/// ```text
/// cargo test --release --test app -- --ignored --nocapture solver_speed
/// ```
#[test]
#[ignore = "a measurement, of minutes, on a machine that does nothing else"]
fn solver_speed_under_the_app() {
    let folder = folder();
    let ratios: Vec<f64> = (0..ROUNDS)
        .map(|round| {
            let alone = alone(&folder, round);
            let watched = watched(&folder);
            let ratio = alone.as_secs_f64() / watched.as_secs_f64();
            let a_step = |total: Duration| 1e3 * total.as_secs_f64() / (STEPS - FIRST) as f64;
            println!(
                "vesica run {:.3} ms a step, the app {:.3} ms a step: {:.1} %",
                a_step(alone),
                a_step(watched),
                100.0 * ratio
            );
            ratio
        })
        .collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!(
        "the solver has {:.1} % of its speed under the app",
        100.0 * mean
    );
}

/// Measures, and prints, how long a key takes to be answered while the solver works at Table 1's
/// size: from the key to the answer on the screen.
///
/// ```text
/// cargo test --release --test app -- --ignored --nocapture key_latency
/// ```
#[test]
#[ignore = "a measurement"]
fn key_latency_under_load() {
    const KEYS: usize = 100;
    let folder = folder();
    let mut app = Pty::start((120, 40), folder.path(), &[VESICA, "case3"], &[]);
    wait_running(&app);
    let mut waits: Vec<Duration> = (0..KEYS)
        .map(|number| {
            let begun = Instant::now();
            let opened = number % 2 == 0;
            app.type_keys(if opened { "?" } else { "\r" });
            app.wait("an answer", |seen| seen.shows("show all keys") == opened);
            let waited = begun.elapsed();
            // Not in step with the frames.
            std::thread::sleep(Duration::from_millis(37 + 7 * (number as u64 % 9)));
            waited
        })
        .collect();
    waits.sort_unstable();
    println!(
        "answered in {:?} (median), {:?} (slowest of {KEYS})",
        waits[KEYS / 2],
        waits[KEYS - 1]
    );
    app.type_keys("qy");
    app.assert_restored(0);
}

/// Computing time of the steps, as the run tells it in its history.
fn alone(folder: &tempfile::TempDir, round: usize) -> Duration {
    let out = format!("run-{round}");
    let steps = STEPS.to_string();
    let status = Command::new(VESICA)
        .args(["run", "case3", "--steps", &steps, "--out", &out, "--quiet"])
        .current_dir(folder.path())
        .status()
        .expect("it starts");
    assert!(status.success());
    let history = std::fs::read_to_string(folder.path().join(out).join("history.csv"));
    let history = history.expect("a history");
    let wall = |step: u64| -> f64 {
        let row = history.lines().nth(step as usize + 1).expect("a row");
        row.split(',')
            .nth(13)
            .and_then(|cell| cell.parse().ok())
            .expect("a time")
    };
    Duration::from_secs_f64(wall(STEPS) - wall(FIRST))
}

/// Time by the clock between two states of the screen.
fn watched(folder: &tempfile::TempDir) -> Duration {
    let end = format!("time.end={}e-7", STEPS);
    let program = [VESICA, "case3", "--set", &end];
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    app.wait("the first steps", |seen| {
        step(&seen.text()).is_some_and(|step| step >= FIRST)
    });
    let (begun, first) = (Instant::now(), step(&app.seen().text()).expect("a step"));
    let done = app.wait_for(10 * LIMIT, |seen| step(&seen.text()) == Some(STEPS));
    assert!(done, "{}", app.seen().text());
    let elapsed = begun.elapsed();
    app.type_keys("qy");
    app.assert_restored(0);
    elapsed.mul_f64((STEPS - FIRST) as f64 / (STEPS - first) as f64)
}
