//! `vesica run --measure-error`: what it leaves, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A few chosen steps on a small mesh.
const SCENE: &str = "\
name = \"Small\"
[mesh]
cells = 20
[vesicle]
shape = \"ellipse\"
half_axes = [0.32, 0.22]
[time]
tolerance = 1e-2
end = 2e-4
[membrane]
interface_width = 0.06
[area]
target = 1.1
penalty = 1e-2
";

fn vesica(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesica"));
    let command = command.current_dir(folder).args(arguments);
    command
        .stdin(Stdio::null())
        .output()
        .expect("vesica starts")
}

fn folder_with_scene(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("small.toml"), scene).expect("it can be written");
    folder
}

#[track_caller]
fn told(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn run_json(folder: &Path) -> serde_json::Value {
    let text = fs::read_to_string(folder.join("runs/small/run.json")).expect("run.json");
    serde_json::from_str(&text).expect("JSON")
}

fn table(folder: &Path) -> Vec<Vec<String>> {
    let path = folder.join("runs/small/measured-error.csv");
    let text = fs::read_to_string(path).expect("a table");
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().map(cells).collect()
}

#[test]
fn every_snapshot_is_measured_and_the_provenance_is_there() {
    let folder = folder_with_scene(SCENE);
    let folder = folder.path();
    let words = told(&vesica(folder, &["run", "small.toml", "--measure-error"]));
    assert!(words.contains("2 times finer in mesh and steps"), "{words}");
    let rows = table(folder);
    let times: Vec<f64> = rows[1..]
        .iter()
        .map(|row| row[0].parse().expect("t"))
        .collect();
    let quarters: Vec<f64> = times
        .iter()
        .map(|t| (t / 5e-5 * 1e9).round() / 1e9)
        .collect();
    assert_eq!(quarters, [0.0, 1.0, 2.0, 3.0, 4.0]);
    for column in [
        "phi_error",
        "membrane_error",
        "E_total_error",
        "E_area_error",
        "length_error",
        "waist_uncertainty",
    ] {
        let place = rows[0]
            .iter()
            .position(|name| name == column)
            .expect(column);
        for row in &rows[1..] {
            let value: f64 = row[place].parse().expect(column);
            assert!(value.is_finite(), "{column} {value}");
        }
    }
    let json = run_json(folder);
    let measured = &json["measured_error"];
    assert_eq!(measured["factor"], 2.0);
    assert_eq!(measured["runs"][1]["nodes"], 41 * 41);
    assert_eq!(measured["runs"][1]["tolerance"], 2.5e-3);
    assert_eq!(measured["t"], 2e-4);
    // The interface has 1.2 cells: the error is one of the mesh, and near its interpolation's.
    let error = measured["phi_error"].as_f64().expect("an error");
    let estimate = json["errors"]["space"].as_f64().expect("an estimate");
    assert!(
        error > 0.3 * estimate && error < 3.0 * estimate,
        "{error} {estimate}"
    );

    // The run itself is the same as one that nobody measures; and a finished one can be measured.
    let table_before = rows;
    let history = fs::read_to_string(folder.join("runs/small/history.csv")).expect("rows");
    told(&vesica(
        folder,
        &["run", "small.toml", "--quiet", "--out", "plain"],
    ));
    let plain = fs::read_to_string(folder.join("plain/history.csv")).expect("rows");
    let without_clock = |text: &str| -> Vec<String> {
        let lines = text.lines();
        lines
            .map(|line| line.rsplit_once(',').expect("wall").0.to_owned())
            .collect()
    };
    assert_eq!(without_clock(&history), without_clock(&plain));
    fs::remove_file(folder.join("runs/small/measured-error.csv")).expect("it was there");
    told(&vesica(
        folder,
        &["run", "small.toml", "--resume", "--measure-error"],
    ));
    assert_eq!(table(folder), table_before);
}

/// Steps of one length, as many as do not divide into quarters; twice finer, and half as fine again.
#[test]
fn steps_of_one_length_are_measured_at_their_own_times() {
    let folder = folder_with_scene(&SCENE.replace("tolerance = 1e-2", "step = 1e-5"));
    let folder = folder.path();
    let arguments = ["run", "small.toml", "--steps", "10", "--measure-error=3"];
    let words = told(&vesica(folder, &arguments));
    assert!(words.contains("3 times finer"), "{words}");
    let rows = table(folder);
    let times: Vec<f64> = rows[1..]
        .iter()
        .map(|row| row[0].parse().expect("t"))
        .collect();
    let expected = [0.0, 3.0, 5.0, 8.0, 10.0].map(|step| step * 1e-5);
    let is_near = |(one, other): (&f64, &f64)| (one - other).abs() < 1e-15;
    assert!(
        times.len() == expected.len() && times.iter().zip(&expected).all(is_near),
        "{times:?}"
    );
    assert_eq!(
        run_json(folder)["measured_error"]["runs"][1]["nodes"],
        61 * 61
    );
}

#[test]
fn where_the_mesh_cannot_be_finer_the_steps_are() {
    let scene = SCENE.replace(
        "shape = \"ellipse\"\nhalf_axes = [0.32, 0.22]",
        "shape = \"random\"\namplitude = 0.9\nseed = 1",
    );
    let folder = folder_with_scene(
        &scene
            .replace("[area]\ntarget = 1.1\npenalty = 1e-2\n", "")
            .replace("end = 2e-4", "end = 1e-5"),
    );
    let folder = folder.path();
    let words = told(&vesica(folder, &["run", "small.toml", "--measure-error"]));
    assert!(words.contains("the mesh is the same"), "{words}");
    assert_eq!(
        run_json(folder)["measured_error"]["runs"][1]["nodes"],
        21 * 21
    );
}

#[test]
fn a_factor_that_measures_nothing_and_a_mesh_that_no_memory_holds_are_refused() {
    let folder = folder_with_scene(SCENE);
    let folder = folder.path();
    for (arguments, words) in [
        (&["--measure-error=1"][..], "from 1.5 to 8"),
        (
            &["--measure-error=8", "--set", "mesh.cells=300"],
            "the error cannot be measured",
        ),
    ] {
        let output = vesica(folder, &[&["run", "small.toml"], arguments].concat());
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_ne!(output.status.code(), Some(0));
        assert!(told.contains(words), "{told}");
        assert!(!folder.join("runs").exists(), "nothing has begun");
    }
}
