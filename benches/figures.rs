//! What figures cost: `cargo bench --bench figures`.
//!
//! On the paper's mesh, 14,641 nodes. A view is the picture that the app saves, as PNG, SVG, CSV and
//! VTU (goal of the PNG: 300 ms); a set is all figures of four runs of 10,000 steps (goal: 5 s). The
//! files are written and brought to the disk, as in use.

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use std::sync::Arc;
use std::time::Duration;
use vesica::internal::figure::{Existing, RunData, Snapshot, save_set};
use vesica::internal::record::Columns;
use vesica::{Field, FigureOptions, Mesh, Report, Scene, Simulation, View, find_preset, save_view};

fn run(name: &str) -> RunData {
    let text = find_preset(name).expect("it is built in");
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, name, &[], &mut no_files).expect("a sound scene");
    let simulation = Simulation::new(&scene).expect("it can be set up");
    let mut history = Columns::default();
    for step in 0..=10_000 {
        let decay = (-(step as f64) / 1000.0).exp();
        history.push(&Report {
            step,
            t: step as f64 / 1e7,
            total_energy: 100.0 + 500.0 * decay,
            ..simulation.report().clone()
        });
    }
    let state = Arc::new(simulation.state().clone());
    let mesh = Arc::new(Mesh::structured(120, 0.0, 1).expect("a fair mesh"));
    let snapshots = (0..5).map(|quarter| Snapshot {
        step: 2500 * quarter,
        t: 2.5e-4 * quarter as f64,
        mesh: mesh.clone(),
        state: state.clone(),
    });
    RunData {
        name: name.to_owned(),
        scene: Arc::new(scene),
        theory: None,
        history,
        marks: Vec::new(),
        snapshots: snapshots.collect(),
        command: format!("vesica figures {name}"),
    }
}

fn figures(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut group = criterion.benchmark_group("figures");
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(5));
    let runs = ["case1", "case2", "case3", "case4"].map(run);
    let report = Report::default();
    let replace = |options: FigureOptions| FigureOptions {
        existing: Existing::Replace,
        ..options
    };
    let view = View {
        name: &runs[2].name,
        scene: &runs[2].scene,
        mesh: &runs[2].snapshots[0].mesh,
        state: &runs[2].snapshots[0].state,
        report: &report,
        field: Field::Phase,
        theory: None,
        command: "",
    };
    let options = replace(FigureOptions::view());
    group.bench_function("view", |bencher| {
        bencher.iter(|| save_view(&view, &options, folder.path()).expect("it is saved"));
    });
    let options = replace(FigureOptions::default());
    group.bench_function("set/1", |bencher| {
        bencher.iter(|| save_set(&runs[2..3], &options, folder.path()).expect("it is saved"));
    });
    group.bench_function("set/4", |bencher| {
        bencher.iter(|| save_set(&runs, &options, folder.path()).expect("it is saved"));
    });
    group.finish();
}

criterion_group!(benches, figures);
criterion_main!(benches);
