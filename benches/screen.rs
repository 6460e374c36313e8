//! What the screen costs: `cargo bench --bench screen`. At ten frames a second one per cent of a core
//! is a millisecond a frame.
//!
//! A run of case 3 on the paper's mesh, a few steps old, with a history of ten thousand.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use vesica::internal::fem::Raster;
use vesica::internal::simulation::{RunId, RunSnapshot, Setting};
use vesica::internal::tui::{App, Canvas, ColorTier, Run, Screen, Slot, Status, Theme, draw};
use vesica::{Mesh, Scene, Simulation, find_preset};

fn slot(name: &str) -> Slot {
    let text = find_preset(name).expect("it is built in");
    let overrides = ["solver.quadrature=lumped".to_owned()];
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, name, &overrides, &mut no_files).expect("a sound scene");
    let mut simulation = Simulation::new(&scene).expect("it can be set up");
    let mut run = Run::new(RunId(1), None);
    run.history.take(simulation.report());
    for _ in 0..3 {
        simulation.advance().expect("a step");
        run.history.take(simulation.report());
    }
    let mut report = simulation.report().clone();
    for step in report.step + 1..10_000 {
        report.step = step;
        run.history.take(&report);
    }
    run.picture = Some(Arc::new(RunSnapshot {
        run: run.id,
        anchoring: None,
        report: report.clone(),
        mesh: Arc::clone(simulation.mesh()),
        state: Arc::new(simulation.state().clone()),
    }));
    run.report = report;
    run.status = Status::Running;
    run.setting = Some(Arc::new(Setting {
        scene: scene.clone(),
        steps: Some(10_000),
        warnings: Vec::new(),
    }));
    let mut slot = Slot::new(name, None, scene);
    slot.run = Some(run);
    slot
}

fn screen(criterion: &mut Criterion) {
    let slots = ["case1", "case2", "case3", "case4"].map(slot);
    let mut app = App::new(slots.into(), 2, (120, 40), 10);
    for screen in [Screen::Run, Screen::Gallery] {
        app.screen = screen;
        for (columns, rows) in [(120, 40), (200, 60)] {
            let mut terminal =
                Terminal::new(TestBackend::new(columns, rows)).expect("it cannot fail");
            let theme = Theme::new(ColorTier::Palette, true);
            let mut canvas = Canvas::default();
            let name = format!("draw/{screen:?}/{columns}x{rows}");
            criterion.bench_function(&name, |bencher| {
                bencher.iter(|| {
                    terminal
                        .draw(|frame| draw(black_box(&app), &theme, &mut canvas, frame))
                        .expect("it cannot fail");
                });
            });
        }
    }
}

fn raster(criterion: &mut Criterion) {
    let mesh = Mesh::structured(120, 0.2, 1).expect("a fair mesh");
    let values: Vec<f64> = mesh.nodes().iter().map(|at| at.x * at.y).collect();
    let region = mesh.bounding_box();
    for (columns, rows) in [(62, 62), (102, 102)] {
        criterion.bench_function(&format!("raster/build/{columns}x{rows}"), |bencher| {
            bencher.iter(|| Raster::new(black_box(&mesh), region, columns, rows));
        });
        let raster = Raster::new(&mesh, region, columns, rows);
        let mut samples = Vec::new();
        criterion.bench_function(&format!("raster/gather/{columns}x{rows}"), |bencher| {
            bencher.iter(|| raster.gather(black_box(&values), &mut samples));
        });
    }
}

criterion_group!(benches, screen, raster);
criterion_main!(benches);
