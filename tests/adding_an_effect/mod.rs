//! The example of the guide's page "Adding an effect": two files and a line in each list, which the tests compile.
//! Nothing else in the program knows of it, and it is everywhere that an effect must be.

use std::fs;
use std::sync::Arc;
use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::TestBackend;

use crate::fem::Mesh;
use crate::figure::{FigureOptions, RunData, save_set};
use crate::physics::NamedValue;
use crate::record::{Columns, Ending, IfOccupied, RecorderBuilder, RunFolder, Settings};
use crate::scene::{Scene, SceneError};
use crate::scheme::{Scheme, initial_fields};
use crate::simulation::{RunId, RunSnapshot, Setting, Simulation};
use crate::study::memory;
use crate::tui::canvas::Canvas;
use crate::tui::panel::draw;
use crate::tui::state::{App, Run, Slot, Status};
use crate::tui::theme::{ColorTier, Theme};

const SCENE: &str = r#"
name = "Small"
[mesh]
cells = 16
[vesicle]
shape = "ellipse"
half_axes = [0.3, 0.2]
center = [0.48, 0.51]
angle = 70
[time]
step = 1e-6
end = 2e-6
[membrane]
interface_width = 0.06
[area]
target = 1.1
[nematic]
initial = [0.6, 0.8]
[solver]
tolerance = 1e-10
law_tolerance = 1e-12
[tension]
weight = 3.0
"#;

fn read(text: &str, settings: &[&str]) -> Result<Scene, SceneError> {
    let settings: Vec<String> = settings.iter().map(|s| (*s).to_owned()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(text, "a.toml", &settings, &mut no_files)
}

fn scene(settings: &[&str]) -> Scene {
    read(SCENE, settings).unwrap_or_else(|error| panic!("{error}"))
}

fn scheme(scene: &Scene) -> Scheme {
    let mesh = Mesh::of(scene).expect("a fair mesh");
    let initial = initial_fields(scene, &mesh).expect("initial fields");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("a scheme")
}

fn named(values: &[NamedValue], name: &str) -> Option<f64> {
    let value = values.iter().find(|value| value.name == name);
    value.map(|value| value.value)
}

#[test]
fn its_table_is_read_written_and_checked() {
    let scene = scene(&[]);
    assert_eq!(scene.tension.map(|tension| tension.weight), Some(3.0));
    let written = scene.to_toml();
    assert!(written.contains("\n[tension]\nweight = 3.0\n"), "{written}");
    assert_eq!(read(&written, &[]).as_ref(), Ok(&scene));
    let weight = |scene: Result<Scene, _>| scene.map(|scene| scene.tension.map(|it| it.weight));
    assert_eq!(weight(read("", &[])), Ok(None));
    assert_eq!(weight(read("[tension]", &[])), Ok(Some(0.5)));
    assert_eq!(weight(read("", &["tension.weight=2"])), Ok(Some(2.0)));
    assert_eq!(weight(read(SCENE, &["tension=false"])), Ok(None));
    let refused = [
        (
            "[tension]\nwieght = 2",
            "a.toml:2:1: unknown key 'wieght' in [tension]; did you mean 'weight'? Allowed: weight",
        ),
        (
            "[tension]\nweight = -2",
            "a.toml:2:10: tension.weight must be a finite number ≥ 0, not -2",
        ),
        (
            "[tention]",
            "a.toml:1:2: unknown key 'tention' at the top level; did you mean 'tension'?",
        ),
    ];
    for (text, words) in refused {
        let error = read(text, &[]).expect_err(text).to_string();
        assert!(error.starts_with(words), "{error}");
    }
}

#[test]
fn it_keeps_the_energy_law_and_allocates_nothing_in_a_step() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        let without = scheme(&scene(&[quadrature, "tension=false"]));
        let without = without.report().total_energy;
        let mut scheme = scheme(&scene(&[quadrature]));
        assert!(scheme.report().total_energy != without);
        for step in 1..=8 {
            let before = memory::forget_most();
            let report = match scheme.step(1e-6) {
                Ok(report) => report,
                Err(error) => panic!("{quadrature} step {step}: {error}"),
            };
            // The first steps give every vector its size.
            let taken = memory::most() - before;
            assert!(
                step <= 5 || taken == 0,
                "{quadrature} step {step}: {taken} bytes"
            );
            let residual = report.law_residual;
            assert!(
                residual.abs() <= 1e-12,
                "{quadrature} step {step}: {residual:e}"
            );
            let is_above = |value: Option<f64>, least| value.is_some_and(|value| value > least);
            assert!(is_above(named(&report.energies, "tension"), 0.1));
            assert!(is_above(named(&report.ledger, "ND_tension"), 0.0));
            assert!(named(&report.ledger, "dE").is_some_and(|change| change < 0.0));
        }
    }
}

#[test]
fn it_can_be_taken_away() {
    let mut scene = scene(&[]);
    assert!(scene.remove_effect("tension") && scene.tension.is_none());
    assert!(!scene.remove_effect("tension"));
    assert!(scene.remove_effect("nematic"));
    assert!(crate::physics::EFFECTS.contains(&"tension"));
}

#[test]
fn its_energy_is_in_the_record_in_a_figure_and_in_the_app() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    let scene = scene(&[]);
    let mut simulation = Simulation::new(&scene).expect("a run");
    let mut run = Run::new(RunId(1), None);
    run.history.take(simulation.report());

    let claimed = RunFolder::at(&path, IfOccupied::Refuse).expect("a free folder");
    let recorder = RecorderBuilder::begin(claimed, &scene, Settings::default());
    let recorder = recorder.expect("a record");
    let mut recorder = recorder.start(&simulation, Duration::ZERO).expect("tables");
    for _ in 0..2 {
        simulation.advance().expect("a step");
        run.history.take(simulation.report());
        let recorded = recorder.step(&mut simulation, Duration::ZERO);
        recorded.expect("a row");
    }
    let finished = recorder.finish(&mut simulation, Ending::Done);
    finished.expect("the end");
    let header = |file: &str| {
        let text = fs::read_to_string(path.join(file)).expect(file);
        text.lines().next().unwrap_or_default().to_owned()
    };
    assert!(header("history.csv").ends_with(",wall,E_tension"));
    assert!(header("ledger.csv").contains(",ND_tension"));
    let history = Columns::read(&path).expect("a history");
    let energies = history.known("E_tension").expect("energies");
    let last = named(&simulation.report().energies, "tension");
    assert_eq!((energies.len(), energies.last().copied()), (3, last));

    let data = RunData {
        name: "small".to_owned(),
        scene: Arc::new(scene.clone()),
        marks: Vec::new(),
        theory: None,
        history,
        snapshots: Vec::new(),
        command: String::new(),
    };
    let figures = folder.path().join("figures");
    fs::create_dir(&figures).expect("a folder");
    let options = FigureOptions::view();
    save_set(&[data], &options, &figures).expect("figures");
    let table = fs::read_to_string(figures.join("small-energies.csv")).expect("a table");
    assert!(table.contains("E_tension"), "{table}");
    let picture = fs::read_to_string(figures.join("small-energies.svg")).expect("a picture");
    assert!(picture.contains("tension"));

    run.report = simulation.report().clone();
    run.status = Status::Running;
    run.picture = Some(Arc::new(RunSnapshot {
        run: run.id,
        anchoring: None,
        report: simulation.report().clone(),
        mesh: Arc::clone(simulation.mesh()),
        state: Arc::new(simulation.state().clone()),
    }));
    run.setting = Some(Arc::new(Setting {
        scene: scene.clone(),
        steps: Some(2),
        warnings: Vec::new(),
    }));
    let mut slot = Slot::new("small", None, scene);
    slot.run = Some(run);
    let app = App::new(vec![slot], 0, (120, 40), 10);
    let mut terminal = Terminal::new(TestBackend::new(120, 40)).expect("it cannot fail");
    let theme = Theme::new(ColorTier::Palette, true);
    let mut canvas = Canvas::default();
    let drawn = terminal.draw(|frame| draw(&app, &theme, &mut canvas, frame));
    let buffer = drawn.expect("it cannot fail").buffer;
    let screen: String = buffer.content().iter().map(|cell| cell.symbol()).collect();
    assert!(screen.contains("tension"), "{screen}");
}

#[test]
fn the_guide_prints_its_files_and_its_lines() {
    let guide = include_str!("../../docs/guide/effects.md");
    for file in [
        include_str!("../../src/physics/tension.rs"),
        include_str!("../../src/scene/tables/tension.rs"),
    ] {
        assert!(guide.contains(&format!("```rust\n{file}```")), "{file}");
    }
    for (list, line) in [
        (include_str!("../../src/physics/mod.rs"), "    tension,\n"),
        (
            include_str!("../../src/scene/tables/mod.rs"),
            "    tension: Tension,\n",
        ),
    ] {
        assert!(
            guide.contains(&format!("\n\n{line}")) && list.contains(line),
            "{line}"
        );
    }
}
