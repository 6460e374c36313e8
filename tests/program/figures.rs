//! `vesica figures`: the real binary, on meshes of seconds.

#[cfg(unix)]
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Five steps on a small mesh.
const SMALL: [&str; 6] = [
    "--set",
    "mesh.cells=16",
    "--set",
    "time.end=5e-7",
    "--set",
    "membrane.interface_width=0.1",
];

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesica"));
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null());
    command
}

fn vesica(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("vesica starts")
}

/// Draws small scenes with further arguments.
fn figures(folder: &Path, arguments: &[&str]) -> Output {
    vesica(folder, &[&["figures"], arguments, &SMALL].concat())
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("text")
}

#[track_caller]
fn assert_status(output: &Output, status: i32) {
    assert_eq!(output.status.code(), Some(status), "{}", stderr(output));
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("a name")
        })
        .collect();
    names.sort();
    names
}

fn temporary() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The texts of a PNG file.
fn texts(path: PathBuf) -> Vec<(String, String)> {
    let file = fs::File::open(path).expect("the picture");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file))
        .read_info()
        .expect("a PNG");
    reader.finish().expect("whole");
    let info = reader.info();
    let latin = info
        .uncompressed_latin1_text
        .iter()
        .map(|c| (c.keyword.clone(), c.text.clone()));
    let unicode = info
        .utf8_text
        .iter()
        .map(|chunk| (chunk.keyword.clone(), chunk.get_text().expect("a text")));
    latin.chain(unicode).collect()
}

fn text(path: PathBuf, keyword: &str) -> String {
    let texts = texts(path);
    let found = texts.into_iter().find(|(key, _)| key == keyword);
    found.expect(keyword).1
}

#[test]
fn scenes_are_simulated_kept_and_drawn() {
    let folder = temporary();
    let path = folder.path();
    let output = figures(path, &["case3", "case4", "--width", "400"]);
    assert_status(&output, 0);
    assert_eq!(
        std::str::from_utf8(&output.stdout).expect("text"),
        "12 figures, each as PNG, SVG and CSV, in figures/case3-case4\n"
    );
    // No bars where there is no terminal.
    assert!(!stderr(&output).contains('\u{1b}'), "{}", stderr(&output));
    let made = path.join("figures/case3-case4");
    let mut expected = vec!["runs".to_owned()];
    for name in ["all", "case3-homeotropic", "case4-homeotropic"] {
        for figure in ["energies", "outline", "snapshots", "volume-area"] {
            expected.extend(["csv", "png", "svg"].map(|end| format!("{name}-{figure}.{end}")));
        }
    }
    expected.sort();
    assert_eq!(names(&made), expected);
    assert_eq!(names(&made.join("runs")), ["case3", "case4"]);
    let summary = fs::read_to_string(made.join("runs/case4/run.json")).expect("a run");
    assert!(summary.contains(r#""status": "done""#), "{summary}");

    let picture = made.join("all-snapshots.png");
    assert_eq!(text(picture.clone(), "Step 2"), "0 1 3 4 5");
    let command = text(picture.clone(), "Command");
    assert!(
        command.starts_with("vesica figures case3 case4 --set mesh.cells=16"),
        "{command}"
    );
    // The scene in the picture is one that can be run, and it is the run's.
    fs::write(path.join("again.toml"), text(picture, "Scene 1")).expect("it is written");
    assert_status(&vesica(path, &["check", "again.toml"]), 0);
    assert_eq!(
        fs::read(path.join("again.toml")).expect("it is there"),
        fs::read(made.join("runs/case3/scene.toml")).expect("it is there")
    );
}

#[test]
fn a_folder_of_a_run_is_drawn_as_it_is() {
    let folder = temporary();
    let path = folder.path();
    assert_status(
        &figures(path, &["case3", "--width", "400", "--out", "a"]),
        0,
    );
    let run = path.join("a/runs/case3");
    let history = fs::read(run.join("history.csv")).expect("it is there");
    let output = vesica(
        path,
        &["figures", "a/runs/case3", "--width", "400", "--out", "b"],
    );
    assert_status(&output, 0);
    assert!(!path.join("b/runs").exists(), "nothing is simulated");
    assert_eq!(
        fs::read(run.join("history.csv")).expect("it is there"),
        history
    );
    for figure in ["energies", "outline", "snapshots", "volume-area"] {
        let table = |out: &str| {
            let file = format!("{out}/case3-homeotropic-{figure}.csv");
            fs::read_to_string(path.join(file)).expect("it is there")
        };
        assert_eq!(table("a"), table("b"), "{figure}");
    }
    // Half of a run: what there is.
    for file in [
        "fields/step-0000004.vtu",
        "fields/step-0000005.vtu",
        "final.vtu",
        "shape.csv",
    ] {
        fs::remove_file(run.join(file)).expect("it was there");
    }
    assert_status(
        &vesica(
            path,
            &["figures", "a/runs/case3", "--width", "400", "--out", "c"],
        ),
        0,
    );
    assert_eq!(
        text(path.join("c/case3-homeotropic-snapshots.png"), "Step"),
        "0 1 3"
    );
    assert!(!path.join("c/case3-homeotropic-outline.png").exists());
}

#[test]
fn figures_are_not_overwritten_without_force() {
    let folder = temporary();
    let path = folder.path();
    let arguments = ["circle", "--width", "400", "--out", "a"];
    assert_status(&figures(path, &arguments), 0);
    let before = fs::read(path.join("a/runs/circle/run.json")).expect("it is there");
    let output = figures(path, &arguments);
    assert_status(&output, 2);
    assert!(
        stderr(&output).contains("is there already"),
        "{}",
        stderr(&output)
    );
    let after = fs::read(path.join("a/runs/circle/run.json")).expect("it is there");
    assert_eq!(before, after, "the run is not touched");
    assert_status(&figures(path, &[&arguments[..], &["--force"]].concat()), 0);
    // Without a folder's name a new one is found.
    for expected in ["circle", "circle-2"] {
        assert_status(&figures(path, &["circle", "--width", "400"]), 0);
        assert!(path.join("figures").join(expected).is_dir());
    }
}

#[test]
fn what_is_wrong_is_told_before_anything_is_simulated() {
    let folder = temporary();
    let path = folder.path();
    assert_status(
        &figures(path, &["circle", "--width", "400", "--out", "a"]),
        0,
    );
    let refused = |arguments: &[&str], part: &str| {
        let output = vesica(path, arguments);
        assert_status(&output, 2);
        assert!(
            stderr(&output).contains(part),
            "no '{part}' in:\n{}",
            stderr(&output)
        );
    };
    let run = "a/runs/circle";
    refused(&["figures", "circle", "--width", "399"], "399");
    refused(&["figures", "circle", "--dpi", "0"], "0");
    refused(&["figures", "circel"], "did you mean 'circle'?");
    refused(&["figures"], "SCENE");
    refused(
        &["figures", run, "--set", "time.end=1"],
        "a/runs/circle/scene.toml",
    );
    refused(
        &["figures", "a"],
        "a is not the folder of a run: it has no scene.toml",
    );
    let fields = path.join(run).join("fields/step-0000003.vtu");
    let whole = fs::read(&fields).expect("it is there");
    fs::write(&fields, &whole[..whole.len() / 2]).expect("it is written");
    refused(
        &["figures", run],
        "step-0000003.vtu is damaged: it is not XML",
    );
    fs::write(&fields, &whole).expect("it is written");
    let history = path.join(run).join("history.csv");
    let text = fs::read_to_string(&history).expect("it is there");
    fs::write(&history, text.replacen("\n2,", "\ntwo,", 1)).expect("it is written");
    refused(
        &["figures", run],
        "history.csv is damaged: line 4, column step has \"two\"",
    );
    assert!(!path.join("figures").exists());
}

#[test]
fn one_run_that_fails_leaves_the_others_figures() {
    let folder = temporary();
    let path = folder.path();
    let text = "name = \"Hopeless\"\n[solver]\nlaw_tolerance = 1e-300\n[area]\n";
    fs::write(path.join("bad.toml"), text).expect("it is written");
    let output = figures(
        path,
        &["bad.toml", "circle", "--width", "400", "--out", "a"],
    );
    assert_status(&output, 1);
    assert!(
        stderr(&output).contains("error: bad: step 1"),
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("1 of 2 runs failed"),
        "{}",
        stderr(&output)
    );
    assert!(path.join("a/circle-energies.png").is_file());
}

#[cfg(unix)]
#[test]
fn an_interrupt_saves_what_was_computed() {
    ended_by("TERM", 143);
}

/// Ctrl-C.
#[cfg(unix)]
#[test]
fn ctrl_c_saves_what_was_computed() {
    if !crate::ignored::is_ignored(2) {
        ended_by("INT", 130);
    }
}

/// Ends a run by a signal when it is under way.
#[cfg(unix)]
fn ended_by(signal: &str, status: i32) {
    let folder = temporary();
    let path = folder.path();
    let arguments = ["figures", "circle", "--set", "mesh.cells=16", "--out", "a"];
    let mut child = command(path, &arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("vesica starts");
    while !path.join("a/runs/circle/fields/step-0000000.vtu").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let killed = Command::new("kill")
        .args([&format!("-{signal}"), &child.id().to_string()])
        .status();
    assert!(killed.expect("kill starts").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(status));
    let summary = fs::read_to_string(path.join("a/runs/circle/run.json")).expect("a run");
    assert!(summary.contains(r#""status": "interrupted""#), "{summary}");
    // Its folder can be drawn.
    let output = vesica(
        path,
        &["figures", "a/runs/circle", "--width", "400", "--out", "b"],
    );
    assert_status(&output, 0);
}

/// Nothing of the machine is looked for: with an empty environment, and so without any font
/// configuration or home, the pictures are the same to the byte.
#[test]
fn a_bare_machine_makes_the_same_pictures() {
    let folder = temporary();
    let path = folder.path();
    assert_status(
        &figures(path, &["circle", "--width", "400", "--out", "run"]),
        0,
    );
    let arguments = ["figures", "run/runs/circle", "--width", "600", "--out"];
    assert_status(&vesica(path, &[&arguments[..], &["a"]].concat()), 0);
    let bare = command(path, &[&arguments[..], &["b"]].concat())
        .env_clear()
        .output();
    assert_status(&bare.expect("vesica starts"), 0);
    for name in names(&path.join("a")) {
        let read = |out: &str| fs::read(path.join(out).join(&name)).expect("it is there");
        assert!(read("a") == read("b"), "{name} differs");
    }
}

/// VTU files open in another program, with the same numbers:
///
/// ```text
/// python3 -m venv venv && venv/bin/pip install meshio
/// PYTHON=venv/bin/python cargo test --test program meshio -- --ignored
/// ```
#[test]
#[ignore = "needs Python with meshio"]
fn meshio_reads_the_fields() {
    let folder = temporary();
    let path = folder.path();
    assert_status(
        &figures(path, &["case3", "--width", "400", "--out", "a"]),
        0,
    );
    let script = r#"
import csv, math, meshio
mesh = meshio.read("a/runs/case3/fields/step-0000005.vtu")
with open("a/case3-homeotropic-snapshots.csv") as file:
    rows = [row for row in csv.DictReader(file) if row["step"] == "5"]
assert mesh.points.shape == (17 * 17, 3) and len(rows) == 17 * 17
assert [cells.type for cells in mesh.cells] == ["triangle"]
assert mesh.cells[0].data.shape == (2 * 16 * 16, 3)
for n, row in enumerate(rows):
    assert mesh.points[n, 0] == float(row["x"]) and mesh.points[n, 1] == float(row["y"])
    assert mesh.point_data["phi"][n] == float(row["phi"]), n
    assert list(mesh.point_data["director"][n]) == [float(row["d_x"]), float(row["d_y"]), 0]
for name in ("phi", "omega", "mu"):
    values = mesh.point_data[name]
    assert values.shape == (17 * 17,) and math.isfinite(sum(values)), name
print("read", len(rows), "nodes")
"#;
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    // Tests run in the package's folder; a path to Python is relative to it.
    let program = fs::canonicalize(&python).map_or_else(
        |_| PathBuf::from(&python),
        |_| std::env::current_dir().expect("a folder").join(&python),
    );
    let output = Command::new(program)
        .current_dir(path)
        .args(["-c", script])
        .output();
    let output = output.expect("Python starts");
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(output.stdout, b"read 289 nodes\n");
}

/// Where there is no memory for a picture, the numbers are there, and words.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_does_not_fit_is_told_and_the_numbers_are_saved() {
    let folder = temporary();
    let path = folder.path();
    assert_status(
        &figures(path, &["circle", "--width", "400", "--out", "a"]),
        0,
    );
    let limited = "ulimit -v 60000 && exec \"$0\" figures a/runs/circle --width 10000 --out b";
    let output = Command::new("sh")
        .args(["-c", limited, env!("CARGO_BIN_EXE_vesica")])
        .current_dir(path)
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    assert_status(&output, 1);
    let told = stderr(&output);
    assert!(
        told.contains("needs about") && told.contains("ulimit -v"),
        "{told}"
    );
    assert_eq!(
        names(&path.join("b")).len(),
        4,
        "{:?}",
        names(&path.join("b"))
    );
    assert!(
        names(&path.join("b"))
            .iter()
            .all(|name| name.ends_with(".csv"))
    );
}
