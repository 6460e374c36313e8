//! Runs that are killed at random moments, and resumed, are the same run.

use std::process::Child;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{assert_same, check, command, folder_with_scene, resumed, summary, vesica};

/// Kills `kills` runs at random moments and resumes each until it is done. Its files must be those of a run that was not
/// killed.
fn kill_test(seed: u64, kills: usize, settings: &[&str]) {
    let folder = folder_with_scene();
    let path = folder.path();
    let mut arguments = vec![
        "run",
        "small.toml",
        "--quiet",
        "--checkpoint",
        "0.01",
        "--every",
        "7",
    ];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let begun = Instant::now();
    vesica(path, &[&arguments[..], &["--out", "whole"]].concat(), 0);
    // So that about one run is killed all those times.
    let longest = begun.elapsed().mul_f64(2.0 / kills as f64);

    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut killed, mut runs) = (0, 0);
    while killed < kills {
        runs += 1;
        let name = format!("run{runs}");
        let arguments = [&arguments[..], &["--out", &name, "--resume"]].concat();
        while killed < kills {
            let mut child = command(path, &arguments).spawn().expect("vesica starts");
            std::thread::sleep(longest.mul_f64(random.random::<f64>()));
            // It may be done already.
            if child.try_wait().expect("a child").is_some() {
                check(child.wait_with_output().expect("it has ended"), 0);
                break;
            }
            child.kill().expect("it is there to be killed");
            check_killed(child);
            killed += 1;
        }
        vesica(path, &arguments, 0);
        assert_same(&path.join(&name), &path.join("whole"));
    }
    let run = summary(&path.join("run1"));
    assert_eq!(run["status"], "done");
    let whole = summary(&path.join("whole"));
    for name in ["newton", "refused", "errors"] {
        assert_eq!(run[name], whole[name], "{name}");
    }
    // Which of the runs were killed after their first state was saved is up to the machine.
    let resumptions =
        (1..=runs).map(|number| resumed(&summary(&path.join(format!("run{number}")))));
    assert!(resumptions.sum::<usize>() > 0);
}

fn check_killed(child: Child) {
    let output = child.wait_with_output().expect("it has ended");
    let told = String::from_utf8(output.stderr).expect("text");
    assert_eq!(told, "");
}

#[test]
fn a_run_that_is_killed_fifty_times_is_the_same_run() {
    kill_test(1, 50, &[]);
}

#[test]
fn also_with_the_sparse_factor() {
    kill_test(2, 8, &["solver.linear=factor", "time.end=5e-4"]);
}

#[test]
fn also_with_chosen_steps() {
    kill_test(3, 8, &["time.tolerance=1e-6"]);
}

#[test]
fn also_with_noise_and_a_field_that_is_switched() {
    let field = "field={ strength = 10, from = 1e-4, until = 3e-4 }";
    kill_test(4, 8, &["noise.strength=1", field, "time.end=5e-4"]);
}
