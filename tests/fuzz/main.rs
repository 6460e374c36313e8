//! Fuzzing of everything that is read back: the scene, with its overrides, formulas and files of nodal
//! values, and a run's folder with its tables, fields and checkpoints. Whatever the bytes: no panic, no hang, no
//! memory beyond a bound; and a scene that is read is written and read again as the same.
//!
//! (`run.json` is for others to read; vesica never reads it back.)
//!
//! An input is a good file with a few changes, or noise; it follows from its number alone, so that
//! what fails can be repeated. The quick part runs with all tests; a million inputs with
//!
//!     cargo test --release --test fuzz -- --ignored --nocapture
//!
//! FUZZ_FIRST=N begins with input N: for others than were run before, or one again.

mod memory;
mod mutation;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use mutation::Mutation;
use vesica::internal::record::{
    Columns, Ending, Found, IfOccupied, KeptRuns, RecorderBuilder, Resumption, RunFolder, Settings,
    read_fields, read_run,
};
use vesica::internal::scene::{Expression, Triangulation, preset, preset_names, write_mesh};
use vesica::internal::simulation::SimulationCheckpoint;
use vesica::{Scene, Simulation};

/// Inputs of each target in the quick part, and in the long one.
const QUICK: u64 = 1500;
const LONG: u64 = 200_000;

/// Bytes that reading an input of a few kilobytes may hold at once.
const MOST_MEMORY: usize = 64 << 20;

/// A scene with every kind of value.
const RICH: &str = r#"
name = "Rich"
domain.boundary = "clamped"
mesh = { cells = 4, jitter = 0.2, seed = 3 }
vesicle = { parts = [{ shape = "cassini", ratio = 0.9 }, { shape = "ellipse", half_axes = [0.2, 0.1], angle = 30 }], scale = 1.5 }
time = { step = 1e-6, end = 2e-6 }
membrane.spontaneous_curvature = "sin(pi*x)^2 + max(y, 0.5) * exp(-(x - 0.5)^2)"
area.target = 0.9
nematic.initial = { kind = "defects", at = [{ center = [0.5, 0.5], winding = -0.5 }] }
anchoring.kind = "parallel"
solver = { quadrature = "lumped", iteration = "lagged" }
"#;

const FORMULAS: [&str; 3] = [
    "exp(-(x-0.5)^2 / 1e-2)",
    "sign(x - 0.5) * hypot(x, atan2(y, 1))",
    "((((1 + x))))^-2^y",
];

/// Small, so that its run's files are.
const SMALL: &str = "mesh.cells = 4\nmembrane.interface_width = 0.2\n[nematic]\n[area]\n";

fn read_scene(text: &str, nodal: &[u8]) -> Option<Scene> {
    let mut read = |_: &str| Ok(nodal.to_vec());
    Scene::parse(text, "fuzz", &[], &mut read)
        .inspect_err(|error| assert!(!error.to_string().is_empty()))
        .ok()
}

/// Reads an input.
type Read = Box<dyn Fn(&[u8])>;

/// What is read, given an input.
struct Target {
    name: &'static str,
    seeds: Vec<Vec<u8>>,
    read: Read,
}

fn scene_target() -> Target {
    let mut seeds: Vec<Vec<u8>> = preset_names()
        .filter_map(preset)
        .map(|text| text.as_bytes().to_vec())
        .collect();
    seeds.push(RICH.as_bytes().to_vec());
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        if let Some(scene) = read_scene(&text, b"") {
            let again = read_scene(&scene.to_toml(), b"");
            assert_eq!(again, Some(scene), "a scene is not what was written of it");
        }
    };
    Target {
        name: "scene",
        seeds,
        read: Box::new(read),
    }
}

fn formula_target() -> Target {
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        if let Ok(formula) = text.parse::<Expression>() {
            let _ = formula.evaluate(0.25, 0.75);
        }
    };
    Target {
        name: "formula",
        seeds: FORMULAS.map(|text| text.as_bytes().to_vec()).to_vec(),
        read: Box::new(read),
    }
}

fn nodal_target() -> Target {
    let scalars: String = (0..25)
        .map(|n| format!("{}\n", f64::from(n) * 0.04))
        .collect();
    let pairs: String = (0..25).map(|n| format!("{n} {}, # two\n", 1e-3)).collect();
    let read = |bytes: &[u8]| {
        let fields = [
            "vesicle = { shape = 'file', values = 'phi0.txt' }",
            "membrane.spontaneous_curvature = { file = 'k.txt' }",
            "nematic.initial = { kind = 'file', values = 'd0.txt' }",
        ];
        for field in fields {
            read_scene(&format!("mesh.cells = 4\n{field}"), bytes);
        }
    };
    Target {
        name: "nodal values",
        seeds: vec![scalars.into_bytes(), pairs.into_bytes()],
        read: Box::new(read),
    }
}

/// Files of meshes, of which those that are read are written and read again.
fn mesh_target() -> Target {
    let seeds = ["square-22.msh", "square-41.msh", "square-41-binary.msh"];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let seeds = seeds.map(|name| fs::read(folder.join(name)).expect("a mesh"));
    let read = |bytes: &[u8]| {
        let Some(mesh) = Triangulation::parse(bytes)
            .inspect_err(|error| assert!(!error.to_string().is_empty()))
            .ok()
        else {
            return;
        };
        let mut text = Vec::new();
        write_mesh(&mut text, &mesh).expect("a vector takes everything");
        let again = Triangulation::parse(&text).expect("what was written is a mesh");
        assert_eq!((again.nodes, again.triangles), (mesh.nodes, mesh.triangles));
    };
    Target {
        name: "mesh",
        seeds: seeds.to_vec(),
        read: Box::new(read),
    }
}

/// Records a run of two steps, and gives its scene.
fn record(folder: &Path) -> Scene {
    let mut no_files = |_: &str| Err(ErrorKind::NotFound.into());
    let mut scene = Scene::parse(SMALL, "small", &[], &mut no_files).expect("a scene");
    scene.time.end = 2.0 * scene.time.step;
    let folder = RunFolder::at(folder, IfOccupied::Refuse).expect("a folder");
    let settings = Settings {
        snapshots: 2,
        ..Settings::default()
    };
    let preparation = RecorderBuilder::begin(folder, &scene, settings).expect("it is written");
    let mut simulation = Simulation::new(&scene).expect("a small scene");
    let mut recorder = preparation
        .start(&simulation, Duration::ZERO)
        .expect("it is written");
    for _ in 0..2 {
        simulation.advance().expect("a solvable step");
        recorder
            .step(&mut simulation, Duration::ZERO)
            .expect("it is written");
    }
    recorder
        .finish(&mut simulation, Ending::Done)
        .expect("it is written");
    scene
}

fn run_targets(folder: &Path) -> Vec<Target> {
    record(folder);
    let seed = |path: &PathBuf| fs::read(path).expect("the run has written it");
    let (history, shape) = (folder.join("history.csv"), folder.join("shape.csv"));
    let last = folder.join("final.vtu");
    let scene = folder.join("scene.toml");
    let original = seed(&history);
    let tables = Target {
        name: "tables of a run",
        seeds: vec![seed(&history), seed(&shape)],
        read: Box::new({
            let folder = folder.to_owned();
            move |bytes| {
                for path in [&shape, &history] {
                    fs::write(path, bytes).expect("it is written");
                    let _ = Columns::read(&folder).map(|columns| columns.to_csv());
                }
                fs::write(&history, &original).expect("it is written");
            }
        }),
    };
    let fields = Target {
        name: "fields of a run",
        seeds: vec![seed(&last)],
        read: Box::new(move |bytes| {
            fs::write(&last, bytes).expect("it is written");
            let _ = read_fields(&last);
        }),
    };
    let whole = Target {
        name: "scene of a run",
        seeds: vec![seed(&scene)],
        read: Box::new({
            let folder = folder.to_owned();
            move |bytes| {
                fs::write(&scene, bytes).expect("it is written");
                let _ = read_run(&folder);
            }
        }),
    };
    vec![tables, fields, whole]
}

/// How a checkpoint begins: eight bytes that tell what it is, and four of its version; then its length.
const CHECKPOINT_HEADER: usize = 8 + 4 + 8;

/// Makes a checkpoint's length and checksum fit what stands between them, so that what is wrong is
/// in the content alone.
fn seal(bytes: &mut Vec<u8>) {
    if let Some(length) = bytes.len().checked_sub(CHECKPOINT_HEADER + 4) {
        bytes[CHECKPOINT_HEADER - 8..CHECKPOINT_HEADER]
            .copy_from_slice(&(length as u64).to_le_bytes());
        bytes.truncate(CHECKPOINT_HEADER + length);
        let checksum = crc32fast::hash(bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
    }
}

/// The checkpoint of a run, and the state that the app keeps of one: as the bytes are, and sealed. What
/// is accepted goes on for a step, which is solved or not.
fn checkpoint_targets(folder: &Path) -> Vec<Target> {
    let scene = record(folder);
    let newest = folder.join("checkpoint.bin");
    let older = folder.join("checkpoint-older.bin");
    let seed = fs::read(&newest).expect("the run has written it");
    let names = ["history.csv", "shape.csv", "ledger.csv"].map(|name| folder.join(name));
    let tables = names.map(|path| (fs::read(&path).expect("the run has written it"), path));
    let taken_up = Target {
        name: "checkpoint of a run",
        seeds: vec![seed],
        read: Box::new({
            let (folder, scene) = (folder.to_owned(), scene.clone());
            move |bytes| {
                let mut sealed = bytes.to_vec();
                seal(&mut sealed);
                for bytes in [bytes, &sealed] {
                    fs::write(&newest, bytes).expect("it is written");
                    let _ = fs::remove_file(&older);
                    let Ok(Found::Run(found)) = Resumption::find(&folder, &scene) else {
                        continue;
                    };
                    let mut simulation = Simulation::new(&scene).expect("a small scene");
                    let settings = found.settings();
                    if found.start(&scene, settings, &mut simulation).is_ok() {
                        let _ = simulation.advance();
                    }
                    for (text, path) in &tables {
                        fs::write(path, text).expect("it is written");
                    }
                }
            }
        }),
    };
    let parent = folder.join("kept");
    let mut simulation = Simulation::new(&scene).expect("a small scene");
    simulation.advance().expect("a solvable step");
    let scene = Arc::new(scene);
    let kept = KeptRuns::new(&parent, "small", &scene);
    let mut keeper = kept.begin();
    keeper.step(simulation.report());
    let mut memory = SimulationCheckpoint::default();
    simulation.save(&mut memory);
    keeper.keep(memory).expect("it is written");
    let folder = keeper.kept().expect("it is kept").folder.clone();
    drop(keeper);
    let files = fs::read_dir(&folder).expect("a folder").flatten();
    let files: Vec<(PathBuf, Vec<u8>)> = files
        .map(|entry| (entry.path(), fs::read(entry.path()).expect("a file")))
        .collect();
    let path = folder.join("checkpoint.bin");
    let in_the_app = Target {
        name: "kept run of the app",
        seeds: vec![fs::read(&path).expect("it is there")],
        read: Box::new(move |bytes| {
            let mut sealed = bytes.to_vec();
            seal(&mut sealed);
            for bytes in [bytes, &sealed] {
                // What is damaged is put aside.
                fs::remove_dir_all(&parent).expect("it is removed");
                fs::create_dir_all(&folder).expect("a folder");
                for (path, text) in &files {
                    fs::write(path, text).expect("it is written");
                }
                fs::write(&path, bytes).expect("it is written");
                let Some(run) = kept.find().run else {
                    continue;
                };
                let mut simulation = Simulation::new(&scene).expect("a small scene");
                if simulation.restore(run.checkpoint()).is_ok() {
                    let _ = simulation.advance();
                }
                let _ = kept.go_on(&run);
            }
        }),
    };
    vec![taken_up, in_the_app]
}

/// The number of the first input.
fn first() -> u64 {
    let first = std::env::var("FUZZ_FIRST").ok();
    first.map_or(0, |first| {
        first.parse().expect("FUZZ_FIRST is a whole number")
    })
}

fn fuzz(count: u64) {
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let [for_reading, for_resuming] = folders.each_ref().map(|folder| folder.path());
    let mut targets = vec![
        scene_target(),
        formula_target(),
        nodal_target(),
        mesh_target(),
    ];
    targets.extend(run_targets(for_reading));
    targets.extend(checkpoint_targets(for_resuming));
    for target in &targets {
        let (mut slowest, mut most) = ((Duration::ZERO, 0), 0);
        for number in first()..first() + count {
            let input = Mutation::new(number).of(&target.seeds);
            memory::start();
            let begun = Instant::now();
            let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                (target.read)(&input);
            }));
            slowest = slowest.max((begun.elapsed(), number));
            most = most.max(memory::most());
            let shown = String::from_utf8_lossy(&input);
            assert!(outcome.is_ok(), "{} {number}: {shown}", target.name);
            assert!(most < MOST_MEMORY, "{} {number}: {shown}", target.name);
        }
        println!(
            "{}: {count} inputs; at most {:.1} MB, {:.0} ms (input {})",
            target.name,
            most as f64 / 1e6,
            slowest.0.as_secs_f64() * 1e3,
            slowest.1
        );
    }
}

#[test]
fn bytes_are_read_or_refused() {
    fuzz(QUICK);
}

#[test]
#[ignore = "minutes: 1.6 million inputs"]
fn a_million_inputs_are_read_or_refused() {
    fuzz(LONG);
}
