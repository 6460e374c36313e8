//! Values with which nothing can be computed: the run ends, with an error that says what to change.

use super::*;

/// Ends of itself, far within this time.
const SOON: Duration = Duration::from_secs(60);

#[track_caller]
fn refused(folder: &Path, settings: &[&str], status: i32) -> String {
    let mut arguments = vec!["run", "small.toml", "--out", "a", "--force"];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let mut child = command(folder, &arguments)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("vesica starts");
    let deadline = Instant::now() + SOON;
    while child.try_wait().expect("a status").is_none() {
        if Instant::now() > deadline {
            child.kill().expect("it can be ended");
            panic!("{settings:?}: it does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().expect("it has ended");
    let error = stderr(&output).to_owned();
    assert_eq!(output.status.code(), Some(status), "{settings:?}: {error}");
    error
}

/// Forces whose squares are infinite: no step can be made, of any length.
#[test]
fn a_step_that_no_length_makes_possible_fails() {
    let folder = folder_with_scene();
    for settings in [
        &["noise.strength=1e300"][..],
        &["noise.strength=1e300", "solver.linear=factor"],
        &["noise.strength=1e300", "time.tolerance=1e-3"],
    ] {
        let error = refused(folder.path(), settings, 1);
        assert!(error.contains("the run failed: step 1"), "{error}");
    }
}

#[test]
fn values_that_make_the_initial_state_infinite_are_named() {
    let folder = folder_with_scene();
    for setting in ["nematic.penalty=1e-200", "area={ penalty = 1e-310 }"] {
        let error = refused(folder.path(), &[setting], 2);
        assert!(error.contains("that is not finite, for "), "{error}");
        let key = match setting {
            "nematic.penalty=1e-200" => "nematic.penalty = 1e-200",
            _ => "area.penalty = 1e-310",
        };
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn more_steps_than_can_be_counted_are_refused() {
    let folder = folder_with_scene();
    let error = refused(folder.path(), &["time.step=1e-300"], 2);
    assert!(error.contains("--set time.step=1e-300"), "{error}");
    assert!(error.contains("more than 1e18 steps"), "{error}");
    for (option, value) in [("--until", "1e300"), ("--steps", "18446744073709551615")] {
        let output = vesica(folder.path(), &["run", "small.toml", option, value]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        let error = stderr(&output);
        assert!(
            error.contains(option) && error.contains("can be counted"),
            "{error}"
        );
    }
}

#[test]
fn quiet_may_come_before_the_command() {
    let folder = folder_with_scene();
    for arguments in [
        &["-q", "run", "small.toml", "--out", "a"][..],
        &["--quiet", "run", "small.toml", "--out", "b"],
        &["run", "-q", "small.toml", "--out", "c"],
    ] {
        let output = vesica(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(
            [stdout(&output), stderr(&output)],
            ["", ""],
            "{arguments:?}"
        );
    }
    let output = vesica(folder.path(), &["-q", "rnu", "small.toml"]);
    assert!(stderr(&output).contains("rnu"), "{}", stderr(&output));
}
