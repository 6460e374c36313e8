//! What being watched costs a run.

use super::pty::{LIMIT, Pty, computed};
use super::{VESICA, folder, wait_running};
use std::process::Command;
use std::time::{Duration, Instant};
use vesica::internal::simulation::Worker;

const STEPS: u64 = 400;
const ROUNDS: usize = 4;

/// Measures, and prints: what a run costs its thread under the app on a terminal of 120 × 40,
/// against `vesica run`, at Table 1's size, by turns. Counted is the time that the thread computes,
/// not that of the clock: other programs take turns with both.
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
            let (watched, screen) = watched(&folder);
            let ratio = alone.as_secs_f64() / watched.as_secs_f64();
            let a_step = |total: Duration| 1e3 * total.as_secs_f64() / STEPS as f64;
            println!(
                "vesica run {:.3} ms a step, the app {:.3} ms a step: {:.1} %; all its other \
                 threads {:.3} ms a step",
                a_step(alone),
                a_step(watched),
                100.0 * ratio,
                a_step(screen)
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
            app.wait("an answer", |seen| seen.shows("the keys follow") == opened);
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

/// What `vesica run` computes, from its start to its end.
fn alone(folder: &tempfile::TempDir, round: usize) -> Duration {
    let out = format!("run-{round}");
    let steps = STEPS.to_string();
    let mut run = Command::new(VESICA)
        .args(["run", "case3", "--steps", &steps, "--out", &out, "--quiet"])
        .current_dir(folder.path())
        .spawn()
        .expect("it starts");
    let mut last = Duration::ZERO;
    loop {
        last = last.max(computed(run.id(), ""));
        if let Some(status) = run.try_wait().expect("a child") {
            assert!(status.success());
            return last;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// What the thread of the same run computes under the app, and what all other threads do.
fn watched(folder: &tempfile::TempDir) -> (Duration, Duration) {
    let end = format!("time.end={STEPS}e-7");
    let program = [VESICA, "case3", "--set", &end];
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    let done = app.wait_for(10 * LIMIT, |seen| seen.shows("done"));
    assert!(done, "{}", app.seen().text());
    let solver = computed(app.pid(), Worker::THREAD_NAME);
    let screen = computed(app.pid(), "").saturating_sub(solver);
    app.type_keys("qy");
    app.assert_restored(0);
    (solver, screen)
}
