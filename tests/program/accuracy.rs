//! `vesica accuracy` with runs that are finished.

#[cfg(unix)]
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// An ellipse that rounds off.
const SCENE: &str = "\
[mesh]
cells = 16
[vesicle]
shape = \"ellipse\"
half_axes = [0.3, 0.2]
angle = 90
[time]
tolerance = 1e-3
end = 2e-5
[membrane]
interface_width = 0.06
[area]
target = 1.1
";

fn vesica(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vesica"))
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("vesica starts")
}

#[track_caller]
fn done(output: &Output) {
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
}

#[test]
fn finished_runs_on_any_mesh_are_compared_with_one_of_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), SCENE).expect("it can be written");
    let run = |name: &str, settings: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--quiet", "--out", name];
        settings
            .iter()
            .for_each(|setting| arguments.extend(["--set", setting]));
        done(&vesica(folder, &arguments));
    };
    run("own", &[]);
    run("finer", &["mesh.cells=32"]);
    run("finest", &["mesh.cells=64"]);
    run("scattered", &["mesh.kind=delaunay", "mesh.size=0.03"]);
    run("short", &["time.end=1e-5"]);

    let compared = ["accuracy", "scene.toml", "--budget", "600"];
    let beside = [
        "--beside",
        "own",
        "--beside",
        "finer",
        "--beside",
        "scattered",
    ];
    let against = ["--against", "finest"];
    let output = vesica(folder, &[&compared[..], &beside, &against].concat());
    done(&output);
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(told.contains("Reference: finest"), "{told}");
    let text =
        fs::read_to_string(folder.join("accuracy/scene-accuracy.json")).expect("it is there");
    let study: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let points = study["points"].as_array().expect("points");
    let point = |run: &str| {
        let mut points = points.iter();
        points.find(|it| it["run"] == run).expect("it is there")
    };
    let error = |run: &str| point(run)["errors"]["phase"].as_f64().expect("a number");
    assert!(error("finer") < 0.5 * error("own"), "{told}");
    assert!(error("scattered") < 0.5 * error("own"), "{told}");
    assert_eq!(point("own")["is_own"], true);
    assert_eq!(point("finer")["is_own"], false);
    // What was made before is not made again; what was made now agrees with it.
    let made: Vec<_> = points.iter().filter(|it| it["run"].is_null()).collect();
    assert!(!made.is_empty() && made.iter().all(|it| it["is_own"] == false));
    assert_eq!(study["reference"]["run"], "finest");
    // What a run takes is its own, whatever the study holds besides.
    let memory = |cells: u64| {
        let of_mesh = made.iter().filter(|it| it["cells"] == cells);
        of_mesh.filter_map(|it| it["memory"].as_u64()).max()
    };
    assert!(memory(8).is_some() && memory(8) < memory(16), "{made:?}");

    fs::create_dir(folder.join("rotated")).expect("it can be made");
    let rotated = "domain.geometry = 'axisymmetric'";
    fs::write(folder.join("rotated/scene.toml"), rotated).expect("it can be written");
    for (wrong, message) in [
        ("short", "--resume"),
        ("nowhere", "no run in nowhere"),
        ("rotated", "domain.geometry"),
    ] {
        let output = vesica(folder, &[&compared[..], &["--against", wrong]].concat());
        assert_eq!(output.status.code(), Some(2));
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains(message), "{told}");
        assert!(output.stdout.is_empty(), "the prices take seconds");
    }
    let output = vesica(folder, &[&compared[..], &["--out", "scene.toml"]].concat());
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("scene.toml") && output.stdout.is_empty(),
        "{told}"
    );
}

/// A square of four triangles.
const SQUARE: &str = "\
$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
5
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0.5 0.5 0
$EndNodes
$Elements
4
1 2 0 1 2 5
2 2 0 2 3 5
3 2 0 3 4 5
4 2 0 4 1 5
$EndElements
";

/// Such studies took all memory and left no files: errors of nothing were drawn on a logarithmic axis.
#[test]
fn a_mesh_that_cannot_be_refined_leaves_its_files_within_bounded_memory() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let phase = "0.9\n".repeat(40) + &"-0.9\n".repeat(41);
    fs::write(folder.join("square.msh"), SQUARE).expect("it can be written");
    fs::write(folder.join("phase.txt"), phase).expect("it can be written");
    let rest = "membrane.interface_width = 0.3\ntime = { step = 1e-7, end = 1e-6 }\n";
    for (name, scene) in [
        (
            "square",
            "mesh = { kind = 'file', path = 'square.msh' }\nvesicle = { shape = 'circle', radius = 0.3 }\n",
        ),
        (
            "jitter",
            "mesh = { cells = 8, jitter = 0.1 }\nvesicle = { shape = 'circle', radius = 0.3 }\n",
        ),
        (
            "phase",
            "mesh.cells = 8\nvesicle = { shape = 'file', values = 'phase.txt' }\n",
        ),
    ] {
        fs::write(folder.join(format!("{name}.toml")), scene.to_owned() + rest).expect("written");
        // A hundred times what it takes.
        let command = format!("ulimit -v 1500000 && exec \"$0\" accuracy {name}.toml --budget 600");
        let output = Command::new("sh")
            .args(["-c", &command, env!("CARGO_BIN_EXE_vesica")])
            .current_dir(folder)
            .stdin(Stdio::null())
            .output()
            .expect("it starts");
        done(&output);
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(
            told.contains("errors are those of the steps alone"),
            "{told}"
        );
        for extension in ["png", "svg", "csv", "json"] {
            let file = folder.join(format!("accuracy/{name}-accuracy.{extension}"));
            let bytes = fs::read(&file).expect("it is there");
            let text = String::from_utf8_lossy(&bytes);
            let is_number = extension == "png" || !text.contains("NaN") && !text.contains("inf,");
            assert!(!bytes.is_empty() && is_number, "{name}.{extension}");
        }
    }
}

/// Ctrl-C ends a study with the status that shells have for it.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_a_study() {
    const SIGINT: i32 = 2;
    if crate::ignored::is_ignored(SIGINT) {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let child = Command::new(env!("CARGO_BIN_EXE_vesica"))
        .current_dir(folder.path())
        .args(["accuracy", "case3", "--budget", "100000"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    // Once it listens.
    let status = format!("/proc/{}/status", child.id());
    let listens = || {
        let text = fs::read_to_string(&status).expect("it lives");
        let mask = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        let mask = u64::from_str_radix(mask.expect("a line").trim(), 16).expect("a mask");
        mask >> (SIGINT - 1) & 1 == 1
    };
    while !listens() {
        std::thread::yield_now();
    }
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(killed.expect("kill starts").success());
    let output = child.wait_with_output().expect("it ends");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("ended by Ctrl-C"), "{told}");
}

/// What is wrong with the scene is no failure of a run.
#[test]
fn a_scene_without_a_vesicle_is_a_wrong_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = SCENE.replace("[0.3, 0.2]", "[0.001, 0.001]");
    fs::write(folder.path().join("none.toml"), scene).expect("it can be written");
    let output = vesica(folder.path(), &["accuracy", "none.toml", "--budget", "5"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("no vesicle"), "{told}");
}

/// Under a bound of memory there is a word, and a status: the program never just ends.
#[cfg(target_os = "linux")]
#[test]
fn a_study_that_does_not_fit_into_memory_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("it can be written");
    for (kilobytes, status) in [(30_000, 2), (54_000, 1)] {
        let limited =
            format!("ulimit -v {kilobytes} && exec \"$0\" accuracy scene.toml --budget 600");
        let output = Command::new("sh")
            .args(["-c", &limited, env!("CARGO_BIN_EXE_vesica")])
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .output()
            .expect("it starts");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{kilobytes}: {told}");
        assert!(told.contains("ulimit -v"), "{kilobytes}: {told}");
    }
}
