//! Sweeps, as a user calls them: here, killed and resumed, with points that fail, and as job arrays that are written.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Three steps on a small mesh.
const SCENE: &str = "\
name = \"Small\"
[mesh]
cells = 12
[vesicle]
shape = \"ellipse\"
half_axes = [0.3, 0.2]
[time]
step = 1e-6
end = 3e-6
[membrane]
interface_width = 0.06
[area]
target = 1.1
[nematic]
[anchoring]
kind = \"parallel\"
";

/// Four points that are three scenes, of a zipped group and a list, and a result.
const PLAN: &str = "\
name = \"A study\"
scene = \"small.toml\"
[vary]
\"area.target\" = [1.0, 1.2]
zip = [{ \"mesh.cells\" = [10, 12], \"anchoring.weight\" = [3, 10] }]
[[point]]
\"area.target\" = 1.2
\"mesh.cells\" = 10
\"anchoring.weight\" = 3
[result]
narrowest = \"min(waist)\"
";

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vesica"));
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null());
    command
}

/// Calls the program, which ends with this status; gives the standard output and the standard error.
#[track_caller]
fn vesica(folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    let output: Output = command(folder, arguments).output().expect("vesica starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, error) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(status), "{out}\n{error}");
    (out, error)
}

fn folder(plan: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("small.toml"), SCENE).expect("written");
    fs::write(folder.path().join("plan.toml"), plan).expect("written");
    folder
}

#[test]
fn a_sweep_has_a_folder_a_point_and_a_table() {
    let folder = folder(PLAN);
    let path = folder.path();
    let (list, _) = vesica(path, &["sweep", "plan.toml", "--list", "--quick"], 0);
    assert_eq!(list.lines().count(), 7, "{list}");
    assert!(list.contains("same as 0003-"), "{list}");
    assert!(!path.join("sweeps").exists());

    let (out, error) = vesica(path, &["sweep", "plan.toml"], 0);
    assert!(out.contains("A study: 5 points done"), "{out}");
    assert!(error.contains("1 point is the same scene"), "{error}");
    let sweep = path.join("sweeps/plan");
    let points = fs::read_dir(sweep.join("points")).expect("points");
    assert_eq!(points.count(), 4, "folders, and no locks");
    let table = fs::read_to_string(sweep.join("table.csv")).expect("the table");
    let head = "area.target,mesh.cells,anchoring.weight,point,state,step,t,dt,E_total,E_bending,E_area,E_nematic,\
                E_anchoring,A,B,law_residual,length,waist,width,waist/length,narrowest\n";
    assert!(table.starts_with(head), "{table}");
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 6);
    for row in &rows[1..] {
        assert_eq!(row.len(), rows[0].len());
        assert_eq!((row[4], row[5]), ("done", "3"));
        assert!(
            row[20]
                .parse::<f64>()
                .is_ok_and(|waist| waist > 0.3 && waist < 0.5)
        );
    }
    assert_eq!(rows[5][..3], ["1.2", "10", "3"]);
    assert_eq!(rows[5][5..], rows[3][5..]);
    let (printed, _) = vesica(path, &["sweep", "table", "sweeps/plan"], 0);
    assert_eq!(printed, table);

    let (status, _) = vesica(path, &["sweep", "status", "sweeps/plan"], 0);
    assert_eq!(
        status,
        "4 points: 4 done, 0 running, 0 saved, 0 failed, 0 damaged, 0 waiting\n"
    );
    assert_eq!(vesica(path, &["sweep", "rerun", "sweeps/plan"], 0).0, "");
    let (_, error) = vesica(path, &["sweep", "plan.toml", "--out", "sweeps/plan"], 2);
    assert!(error.contains("holds a sweep already"), "{error}");
    // A run of it is a run as others.
    let run = fs::read_dir(sweep.join("points"))
        .expect("points")
        .flatten()
        .next();
    let run = run.expect("one").path();
    vesica(
        path,
        &["figures", &run.to_string_lossy(), "--width", "500"],
        0,
    );

    let figure = ["sweep", "figure", "sweeps/plan", "--width", "600"];
    let (out, _) = vesica(path, &figure, 0);
    assert!(
        out.contains("map-waist-length and shapes-waist-length"),
        "{out}"
    );
    for file in [
        "map-waist-length.svg",
        "shapes-waist-length.png",
        "shapes-waist-length.csv",
    ] {
        assert!(sweep.join("figures").join(file).is_file(), "{file}");
    }
    let svg = fs::read_to_string(sweep.join("figures/map-waist-length.svg")).expect("there");
    assert!(svg.contains("anchoring.weight") && svg.contains("vesica sweep figure"));
    let (_, error) = vesica(path, &figure, 2);
    assert!(error.contains("--force"), "{error}");
    let (_, error) = vesica(path, &[&figure[..], &["--column", "waste"]].concat(), 2);
    assert!(error.contains("no column 'waste'"), "{error}");
    // Curves are new, and the shapes are what they were.
    let shapes = || fs::read(sweep.join("figures/shapes-waist-length.svg")).expect("there");
    let before = shapes();
    let curves = [&figure[..], &["--curves"]].concat();
    let (out, error) = vesica(path, &curves, 0);
    assert!(out.starts_with("curves-waist-length, each"), "{out}");
    assert!(error.contains("the shapes are there already"), "{error}");
    assert!(error.contains("--force"), "{error}");
    assert!(shapes() == before);
    let (_, error) = vesica(path, &curves, 2);
    assert!(
        error.contains("curves-waist-length.png is there already"),
        "{error}"
    );
    let forced = [&curves[..], &["--where", "area.target=1.2", "--force"]].concat();
    let (out, _) = vesica(path, &forced, 0);
    assert!(
        out.contains("curves-waist-length and shapes-waist-length"),
        "{out}"
    );
}

/// What another process works on has not failed.
#[test]
fn points_of_another_process_are_left_to_it() {
    let folder = folder("scene = \"small.toml\"\n[vary]\n\"area.target\" = [1.0, 1.1, 1.2]\n");
    let path = folder.path();
    let (list, _) = vesica(path, &["sweep", "plan.toml", "--list", "--quick"], 0);
    let row = list.lines().find(|line| line.starts_with("0002-"));
    let name = row.and_then(|row| row.split(' ').next()).expect("a name");
    fs::create_dir_all(path.join("a/points")).expect("made");
    let lock = path.join(format!("a/points/{name}.lock"));
    let hold = || {
        let holder = r#"{"host": "elsewhere", "pid": 1, "job": null}"#;
        fs::write(&lock, holder).expect("written");
    };
    hold();
    let sweep = ["sweep", "plan.toml", "--out", "a", "--resume", "-q"];
    for _ in 0..2 {
        let (_, error) = vesica(path, &sweep, 75);
        assert!(
            error.starts_with("2 of 3 points are done, 1 is worked on by another process."),
            "{error}"
        );
        for part in ["vesica sweep status ", "/a --resume"] {
            assert!(error.contains(part), "{error}");
        }
    }
    fs::remove_file(&lock).expect("removed");
    vesica(path, &sweep, 0);
    // A point that fails is told apart from it.
    fs::remove_dir_all(path.join("a/points")).expect("removed");
    fs::create_dir(path.join("a/points")).expect("made");
    hold();
    let row = list.lines().find(|line| line.starts_with("0003-"));
    let third = row.and_then(|row| row.split(' ').next()).expect("a name");
    fs::write(path.join("a/points").join(third), "a file").expect("written");
    let (_, error) = vesica(path, &[&sweep[..], &["--jobs", "1"]].concat(), 1);
    assert!(
        error.contains("1 of 3 points failed, 1 is worked on by another process; "),
        "{error}"
    );
}

/// Both do what the other has not begun; what the other is at is no failure of either.
#[test]
fn two_processes_share_a_sweep() {
    let folder = folder(
        "scene = \"small.toml\"\n[set]\n\"time.end\" = 3e-5\n[vary]\n\
         \"area.target\" = { from = 1, to = 1.2, count = 12 }\n",
    );
    let path = folder.path();
    let sweep = ["sweep", "plan.toml", "--out", "a", "--resume", "-q"];
    let both = [(); 2].map(|()| {
        let mut command = command(path, &sweep);
        let command = command.stderr(Stdio::piped());
        command.spawn().expect("vesica starts")
    });
    for child in both {
        let output = child.wait_with_output().expect("it ends");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 75)), "{error}");
        assert!(!error.contains("failed"), "{error}");
    }
    vesica(path, &sweep, 0);
    let (status, _) = vesica(path, &["sweep", "status", "a"], 0);
    assert!(status.starts_with("12 points: 12 done"), "{status}");
}

/// A run that was done and has lost a table is computed again, to the same numbers.
#[test]
fn a_point_that_has_lost_a_table_is_damaged() {
    let folder = folder("scene = \"small.toml\"\n[vary]\n\"area.target\" = [1.0, 1.1, 1.2]\n");
    let path = folder.path();
    vesica(path, &["sweep", "plan.toml", "--out", "a"], 0);
    let table = fs::read_to_string(path.join("a/table.csv")).expect("there");
    let run = |row: usize| {
        let name = table.lines().nth(row).and_then(|row| row.split(',').nth(1));
        path.join("a/points").join(name.expect("a point"))
    };
    fs::remove_file(run(1).join("history.csv")).expect("removed");
    let shape = run(3).join("shape.csv");
    let text = fs::read_to_string(&shape).expect("there");
    let (kept, _) = text.trim_end().rsplit_once('\n').expect("rows");
    fs::write(&shape, format!("{kept}\n")).expect("written");

    let (status, _) = vesica(path, &["sweep", "status", "a"], 0);
    assert!(status.contains("1 done, 0 running, 0 saved, 0 failed, 2 damaged"));
    for words in [
        "damaged: its history.csv is missing: `vesica sweep ",
        "damaged: its shape.csv has no row of its last step: `vesica sweep ",
        "/a --resume` computes the point again",
    ] {
        assert!(status.contains(words), "{status}");
    }
    let (printed, _) = vesica(path, &["sweep", "table", "a"], 0);
    assert_eq!(printed.matches(",damaged,").count(), 2, "{printed}");
    let (rerun, _) = vesica(path, &["sweep", "rerun", "a"], 0);
    assert_eq!(rerun.lines().count(), 2, "{rerun}");

    let (_, error) = vesica(path, &["sweep", "a", "--resume", "-q"], 0);
    assert!(
        error.contains("was done, but its history.csv is missing: it is computed again"),
        "{error}"
    );
    let again = fs::read_to_string(path.join("a/table.csv")).expect("there");
    assert_eq!(again, table);
}

#[test]
fn folders_that_are_gone_are_made_and_files_in_their_place_are_told() {
    let folder = folder("scene = \"small.toml\"\n[vary]\n\"area.target\" = [1.0, 1.1]\n");
    let path = folder.path();
    let points = path.join("a/points");
    vesica(path, &["sweep", "plan.toml", "--out", "a"], 0);
    let name = |number: &str| {
        let names = fs::read_dir(&points).expect("points").flatten();
        let mut names = names.map(|it| it.file_name().to_string_lossy().into_owned());
        names.find(|name| name.starts_with(number)).expect("one")
    };
    let second = name("0002");
    for sweep in [
        &["sweep", "a", "--resume"][..],
        &["sweep", "plan.toml", "--out", "a", "--resume"],
        &["sweep", "point", "a", "1", "2"],
    ] {
        fs::remove_dir_all(&points).expect("removed");
        vesica(path, sweep, 0);
        name("0001");
    }
    fs::remove_dir_all(points.join(&second)).expect("removed");
    fs::write(points.join(&second), "a file").expect("written");
    let (status, _) = vesica(path, &["sweep", "status", "a"], 0);
    assert!(
        status.contains("damaged: a file is in the place of its folder: remove it"),
        "{status}"
    );
    let (_, error) = vesica(path, &["sweep", "a", "--resume"], 1);
    let told = format!("{second} is a file, where a folder of the sweep");
    assert_eq!(error.matches(&told).count(), 1, "{error}");
    assert!(
        error.contains("remove it or give it another name"),
        "{error}"
    );
    fs::remove_dir_all(&points).expect("removed");
    fs::write(&points, "a file").expect("written");
    let (_, error) = vesica(path, &["sweep", "a", "--resume"], 2);
    assert_eq!(error.matches("is a file").count(), 1, "{error}");
}

/// The first plan that the guide shows can be run as it stands.
#[test]
fn the_plan_of_the_guide_is_listed_without_a_refused_point() {
    let guide = include_str!("../../docs/guide/sweeps.md");
    let block = guide.split("```toml\n").nth(1).expect("a plan");
    let plan = block.split("```").next().expect("its end");
    let folder = folder(plan);
    let list = ["sweep", "plan.toml", "--list", "--quick"];
    let (out, _) = vesica(folder.path(), &list, 0);
    assert!(out.contains("\n87 points: "), "{out}");
    // Seeds make a difference: no point is the same as another.
    assert!(!out.contains("same as"), "{out}");
}

#[test]
fn points_that_fail_are_reported_and_the_others_are_done() {
    // No step meets this tolerance of the energy law.
    let folder = folder(
        "scene = \"small.toml\"\n[vary]\n\"solver.law_tolerance\" = [1e-8, 1e-30, 1e-9, 1e-31]\n",
    );
    let path = folder.path();
    let (_, error) = vesica(
        path,
        &["sweep", "plan.toml", "--out", "a", "--jobs", "1"],
        1,
    );
    assert!(
        error.contains("(solver.law_tolerance = 1e-30) failed: "),
        "{error}"
    );
    assert!(error.contains("2 of 4 points failed; "), "{error}");
    let (status, _) = vesica(path, &["sweep", "status", "a"], 0);
    assert!(
        status.contains("4 points: 2 done, 0 running, 0 saved, 2 failed"),
        "{status}"
    );
    let (rerun, _) = vesica(path, &["sweep", "rerun", "a"], 0);
    assert_eq!(rerun.lines().count(), 2, "{rerun}");
    let arguments = [
        "sweep",
        "plan.toml",
        "--out",
        "b",
        "--jobs",
        "1",
        "--max-failures",
        "0",
    ];
    let (_, error) = vesica(path, &arguments, 1);
    assert!(
        error.contains("1 of 4 points failed and 2 were not tried"),
        "{error}"
    );
}

#[test]
fn a_wrong_plan_starts_nothing() {
    let folder = folder("scene = \"small.toml\"\n[vary]\n\"area.target\" = [1, -1]\n");
    let path = folder.path();
    let (out, error) = vesica(path, &["sweep", "plan.toml", "--out", "a"], 2);
    assert_eq!(out, "");
    assert!(error.contains("point 2 (area.target = -1)"), "{error}");
    assert!(error.contains("nothing was started"), "{error}");
    assert!(!path.join("a").exists());
    let (_, error) = vesica(path, &["sweep", "nothing.toml"], 2);
    assert!(error.contains("cannot read nothing.toml"), "{error}");
    for command in ["table", "status", "rerun", "figure"] {
        let (_, error) = vesica(path, &["sweep", command, "."], 2);
        assert!(error.contains("holds no sweep"), "{error}");
    }
}

/// Killed twenty times, and stopped by a signal: in the end the table is that of a sweep that was left alone.
#[test]
fn killed_sweeps_are_resumed() {
    let folder = folder(&PLAN.replace(
        "\"area.target\" = [1.0, 1.2]",
        "\"area.target\" = [1.0, 1.1, 1.2]\n\"time.end\" = [2e-5, 4e-5]",
    ));
    let path = folder.path();
    let begun = Instant::now();
    vesica(
        path,
        &["sweep", "plan.toml", "--out", "whole", "--quiet"],
        0,
    );
    let all = begun.elapsed();
    let killed = [
        "sweep",
        "plan.toml",
        "--out",
        "killed",
        "--resume",
        "--quiet",
    ];
    for number in 0..20 {
        let mut child = command(path, &killed).spawn().expect("vesica starts");
        std::thread::sleep(all.mul_f64(0.3 * f64::from(number % 7 + 1) / 7.0));
        let _ = child.kill();
        child.wait().expect("it has ended");
    }
    vesica(path, &killed, 0);
    let table =
        |sweep: &str| fs::read_to_string(path.join(sweep).join("table.csv")).expect("there");
    assert_eq!(table("killed"), table("whole"));
    let left: Vec<_> = fs::read_dir(path.join("killed/points"))
        .expect("points")
        .flatten()
        .filter(|entry| entry.path().is_file())
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

/// A task that is stopped has a status of its own and goes on; two cannot have one point.
#[test]
fn a_task_is_saved_and_continued() {
    let plan =
        "scene = \"small.toml\"\n[set]\n\"time.end\" = 1.0\n[vary]\n\"area.target\" = [1.2]\n";
    let folder = folder(plan);
    let path = folder.path();
    // Slurm is not asked by --dry-run.
    let dry = [
        "sweep",
        "slurm",
        "plan.toml",
        "--out",
        "a",
        "--dry-run",
        "--throttle",
        "3",
        "--",
        "--time=5",
    ];
    let (out, _) = vesica(path, &dry, 0);
    assert!(out.contains("1 task of 1 point"), "{out}");
    let script = fs::read_to_string(path.join("a/slurm/array-1.sbatch")).expect("there");
    for line in [
        "#SBATCH --array=0-0%3\n",
        "#SBATCH --requeue\n",
        "#SBATCH --open-mode=append\n",
    ] {
        assert!(script.contains(line), "{line}");
    }
    let syntax = Command::new("bash")
        .arg("-n")
        .arg(path.join("a/slurm/array-1.sbatch"))
        .status();
    assert!(syntax.is_ok_and(|status| status.success()));
    let jobs = fs::read_to_string(path.join("a/jobs.txt")).expect("there");
    assert!(
        jobs.contains(" sweep point ") && jobs.ends_with('\n'),
        "{jobs}"
    );

    let child = command(path, &["sweep", "point", "a", "1"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("vesica starts");
    let deadline = Instant::now() + Duration::from_secs(60);
    let is_running = || {
        vesica(path, &["sweep", "status", "a"], 0)
            .0
            .contains("1 running")
    };
    while !is_running() {
        assert!(Instant::now() < deadline, "it does not run");
        std::thread::sleep(Duration::from_millis(20));
    }
    let (_, error) = vesica(path, &["sweep", "point", "a", "1"], 1);
    assert!(
        error.contains(&format!("process {} on ", child.id())),
        "{error}"
    );
    for _ in 0..2 {
        // Twice, as a batch system does.
        let sent = Command::new("kill")
            .args(["-TERM", &child.id().to_string()])
            .status();
        assert!(sent.is_ok());
    }
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(75));
    let (status, _) = vesica(path, &["sweep", "status", "a"], 0);
    assert!(status.contains("1 saved"), "{status}");
}

/// Nothing is computed for a figure that there cannot be.
#[test]
fn a_figure_that_cannot_be_is_refused_before_any_run() {
    let folder = folder(PLAN);
    let path = folder.path();
    let figure = ["sweep", "figure", "plan.toml"];
    for (arguments, words) in [
        (&["--branches"][..], "no point is a body of rotation"),
        (&["--x", "time.step"], "'time.step' is no axis of the sweep"),
        (&["--where", "area.target=7"], "area.target is never 7"),
        (&["--column", "wasit"], "no column 'wasit'"),
        (
            &["--x", "area.target", "--y", "area.target"],
            "the key area.target is given twice, with --x and --y",
        ),
        (
            &["--x", "area.target", "--where", "area.target=1.0"],
            "the key area.target is given twice, with --x and --where",
        ),
    ] {
        let (_, error) = vesica(path, &[&figure, arguments].concat(), 2);
        assert!(error.contains(words), "{arguments:?}: {error}");
        assert!(!path.join("sweeps").exists(), "{arguments:?}");
    }
}
