//! A made-up app for tests: a small mesh, fields given by formulas, a history given by formulas.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::fem::{Mesh, OutlineMeasure, Vesicle};
use crate::geometry::{Point, Vector};
use crate::physics::NamedValue;
use crate::record::{MarkKind, RunMark};
use crate::scene::{AnchoringKind, Scene, find_preset};
use crate::scheme::{Phase, State};
use crate::simulation::{Costs, Report, RunId, RunSnapshot, Setting};
use crate::study::{ErrorRow, Measured};
use crate::tui::state::{App, Measurement, Notice, Run, Severity, Slot, Status};

/// Steps of the made-up run, of 10,000.
pub const STEPS: u64 = 400;

/// √2 ε of Table 1.
const INTERFACE: f64 = std::f64::consts::SQRT_2 * 0.01;

/// A preset's scene.
pub fn scene(name: &str) -> Scene {
    let text = find_preset(name).expect("it is built in");
    Scene::of_text(text, &[])
}

/// A biconcave vesicle, long in y; `time` from 0 to 1 narrows its waist and turns the director.
pub fn state(mesh: &Mesh, time: f64) -> State {
    let phi = |node: &Point| {
        let (x, y) = (node.x - 0.5, node.y - 0.5);
        let half_width = 0.1 - 0.02 * time + 0.5 * y * y - 4.2 * y.powi(4);
        ((half_width - x.abs()) / INTERFACE).tanh()
    };
    let phi: Vec<f64> = mesh.nodes().iter().map(phi).collect();
    let omega: Vec<f64> = phi
        .iter()
        .map(|phi| 900.0 * phi * (1.0 - phi * phi))
        .collect();
    let mu = omega.iter().map(|omega| -12.5 * omega).collect();
    // Along y, turned near the membrane, weak near the lower end.
    let director = |node: &Point| {
        let (x, y) = (node.x, node.y);
        let angle = std::f64::consts::FRAC_PI_2 + 4.0 * time * (0.5 - x) * (1.0 + y);
        let length = 1.0 - 0.9 * (-40.0 * ((x - 0.5).powi(2) + (y - 0.25).powi(2))).exp();
        Vector::new(length * angle.cos(), length * angle.sin())
    };
    let director: Vec<Vector> = mesh.nodes().iter().map(director).collect();
    State {
        phi,
        omega,
        mu,
        director: Some([0, 1].map(|axis| director.iter().map(|d| d[axis]).collect())),
    }
}

/// The scalars of a step.
pub fn report(step: u64) -> Report {
    let decay = (-(step as f64) / 150.0).exp();
    let named = |name, value| NamedValue { name, value };
    let energies = vec![
        named("bending", 36.5 + 4.0 * (1.0 - decay)),
        named("area", 210.0 * decay + 3.0),
        named("nematic", 1.0 - decay),
        named("anchoring", 12.0 + 5.0 * decay),
    ];
    let mut costs = Costs::default();
    let microseconds = [900, 2100, 3300, 5200 + 40 * (step % 7), 600];
    if step > 0 {
        for (phase, cost) in Phase::ALL.into_iter().zip(microseconds) {
            costs.add(phase, Duration::from_micros(cost));
        }
    }
    Report {
        step,
        t: step as f64 * 1e-7,
        dt: 1e-7,
        total_energy: energies.iter().map(|energy| energy.value).sum(),
        energies,
        phase_integral: -0.7 + 1e-16 * (step % 3) as f64,
        surface_area: 1.5 + 0.2 * (1.0 - decay),
        law_residual: 1e-11 * (1.0 + (step % 5) as f64),
        newton: 3,
        krylov: 17 + (step % 4) as u32,
        director_iterations: 4,
        costs,
        vesicles: vec![Vesicle {
            area: 0.12,
            perimeter: 1.478,
            outline: Some(OutlineMeasure {
                length: 0.64,
                waist: 0.185 - 0.04 * (1.0 - decay),
                width: 0.246,
            }),
            ..Vesicle::default()
        }],
        ..Report::default()
    }
}

/// A slot with a run that was at step [`STEPS`].
pub fn slot(name: &str, mesh: &Arc<Mesh>) -> Slot {
    let scene = scene(name);
    let mut run = Run::new(RunId(7), None);
    run.status = Status::Running;
    run.setting = Some(Arc::new(Setting {
        scene: scene.clone(),
        steps: Some(10_000),
        warnings: Vec::new(),
    }));
    for step in 0..=STEPS {
        let report = report(step);
        run.history.take(&report);
        run.pace.take(&report, 10_000);
        if step.is_multiple_of(100) {
            let state = state(mesh, step as f64 / STEPS as f64);
            let picture = Arc::new(RunSnapshot {
                run: run.id,
                anchoring: Some(AnchoringKind::Homeotropic),
                report: report.clone(),
                mesh: mesh.clone(),
                state: Arc::new(state),
            });
            run.past.put(picture.clone());
            run.picture = Some(picture);
        }
        if step == 250 {
            run.history.marks.push(change(250, "homeotropic", 0.0));
        }
        run.report = report;
    }
    let mut slot = Slot::new(name, None, scene);
    slot.run = Some(run);
    slot
}

/// The app: four cases, of which the third is shown; the last has not been started.
pub fn app() -> App {
    let mesh = Arc::new(Mesh::structured(30, 0.0, 0).expect("a regular mesh"));
    let mut slots: Vec<Slot> = ["case1", "case2", "case3"]
        .iter()
        .map(|name| slot(name, &mesh))
        .collect();
    slots.push(Slot::new("case4", None, scene("case4")));
    App::new(slots, 2, (120, 40), 10)
}

/// The run that is shown.
pub fn run(app: &mut App) -> &mut Run {
    let slot = &mut app.slots[app.active];
    slot.run.as_mut().expect("it was started")
}

/// The error of the run that is shown is being measured, or is measured at two times, the first of which is off.
pub fn measure(app: &mut App, is_done: bool) {
    let run = run(app);
    run.report.budget.time = Some(1e-3);
    let mut measurement = Measurement::of(run);
    measurement.share = 0.43;
    let measured = |error: f64, uncertainty: f64| Measured { error, uncertainty };
    let row = |t: f64, order: f64| ErrorRow {
        t,
        order: Some(order),
        phase: measured(7.3e-3, 2e-3),
        membrane: Some(measured(4e-5, 3e-5)),
        scalars: vec![
            ("E_total".to_owned(), 155.0, measured(2.1, 0.4)),
            ("length".to_owned(), 0.65, measured(-1e-3, 1e-3)),
            ("waist".to_owned(), 0.11, measured(-2e-3, 4e-4)),
        ],
    };
    if is_done {
        measurement.is_going = false;
        measurement.rows = vec![row(0.0, 3.3), row(2.5e-5, 1.9)];
    }
    run.measurement = Some(measurement);
}

/// A notice of step 120.
pub fn notice(severity: Severity, text: &str) -> Notice {
    Notice {
        severity,
        step: 120,
        text: text.to_owned(),
    }
}

/// A path that is longer than a line.
pub fn long_path() -> PathBuf {
    PathBuf::from(format!(
        "runs/{}/phase-0000120.png",
        "a-long-name/".repeat(12)
    ))
}

/// The mark of a change.
pub fn change(step: u64, label: &str, work: f64) -> RunMark {
    RunMark {
        step,
        t: report(step).t,
        kind: MarkKind::Change {
            label: label.to_owned(),
            work: Some(work),
        },
    }
}
