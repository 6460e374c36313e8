//! Small studies, whole.

use super::*;
use crate::scene::Scene;
use crate::simulation::{Schedule, Simulation};
use std::sync::LazyLock;
use std::time::Duration;

pub(super) fn scene(settings: &str) -> Scene {
    let text = format!(
        "
        mesh.cells = 24
        vesicle = {{ shape = 'ellipse', half_axes = [0.3, 0.2], angle = 70 }}
        area.target = 1.1
        membrane.interface_width = 0.06
        {settings}"
    );
    Scene::of_text(&text, &[])
}

/// Made once for all tests.
static CALM_STUDY: LazyLock<Study> = LazyLock::new(|| {
    let budget = Budget {
        time: Duration::from_secs(600),
        full: false,
    };
    study(&scene(CALM), budget, ComparedRuns::default(), &mut |_| true).expect("it is small")
});

/// The error at T of some cells and steps against a fine run, by another way than the study's.
fn error(settings: &str, cells: usize, tolerance: f64, reference: &Solved) -> f64 {
    reference.distance(&solve(settings, cells, tolerance))
}

struct Solved {
    cells: usize,
    phi: Vec<f64>,
}

impl Solved {
    /// In L2 at the nodes of the coarser mesh.
    fn distance(&self, coarse: &Self) -> f64 {
        let ratio = self.cells / coarse.cells;
        let side = coarse.cells + 1;
        let mut sum = 0.0;
        for row in 0..side {
            for column in 0..side {
                let fine = self.phi[row * ratio * (self.cells + 1) + column * ratio];
                sum += (fine - coarse.phi[row * side + column]).powi(2);
            }
        }
        (sum / (side * side) as f64).sqrt()
    }
}

fn solve(settings: &str, cells: usize, tolerance: f64) -> Solved {
    let choice = Discretisation {
        cells,
        pace: StepControl::Tolerance(tolerance),
        ..Discretisation::of(&scene(settings))
    };
    let scene = choice.applied_to(&scene(settings));
    let mut simulation = Simulation::new(&scene).expect("it is small");
    while simulation.report().t < scene.time.end {
        simulation.advance().expect("solved");
    }
    let phi = simulation.state().phi.clone();
    Solved { cells, phi }
}

pub(super) const CALM: &str = "time = { tolerance = 1e-3, end = 1e-4 }";

#[test]
fn where_the_mesh_dominates_it_is_the_knob_and_the_other_gains_nothing() {
    let study = &*CALM_STUDY;
    let advice = study.advice.expect("enough was run");
    assert_eq!(advice.knob, Knob::Mesh, "{:?}", study.sentences);
    assert!(study.points.iter().all(|point| point.failure.is_none()));
    assert!(
        study
            .points
            .iter()
            .any(|point| point.is_own && point.error().is_some())
    );
    assert!(study.points.iter().any(|point| point.is_pareto));
    // As advised, and against the advice: measured again, by a finer run.
    let reference = solve(CALM, 96, 1e-4);
    let before = error(CALM, 24, 1e-3, &reference);
    let finer_mesh = error(CALM, 48, 1e-3, &reference);
    let shorter_steps = error(CALM, 24, 1e-4, &reference);
    assert!(finer_mesh < 0.6 * before, "{finer_mesh:e} {before:e}");
    assert!(shorter_steps > 0.8 * before, "{shorter_steps:e} {before:e}");
}

#[test]
fn orders_floors_and_tables_are_consistent() {
    let study = &*CALM_STUDY;
    let order = study.order_in_space.expect("two meshes");
    assert!(order.least <= order.last && order.last <= order.greatest);
    let reference = study.reference.as_ref().expect("one");
    assert!(reference.cells > 24 && reference.time_error.is_some());
    assert!(study.floors.windows(2).all(|pair| pair[1].1 < pair[0].1));
    let table = study.to_csv();
    assert_eq!(table.lines().count(), 1 + study.points.len());
    let cells = |line: &str| line.split(',').count();
    let counts: Vec<usize> = table.lines().map(cells).collect();
    assert!(counts.iter().all(|count| *count == counts[0]));
    let picture = chart(study);
    assert!(
        picture.contains('*') && picture.contains("24 cells"),
        "{picture}"
    );
}

#[test]
fn a_study_that_is_ended_keeps_what_it_has() {
    let mut asked = 0;
    let budget = Budget {
        time: Duration::from_secs(600),
        full: false,
    };
    let ended = study(&scene(CALM), budget, ComparedRuns::default(), &mut |news| {
        asked += 1;
        !matches!(news, StudyNews::Run(choice, _) if choice.cells > 12)
    });
    let ended = ended.expect("the first mesh was run");
    assert!(asked > 3);
    // The best of what was run serves as the reference, and is no point itself.
    let reference = ended.reference.as_ref().expect("the best of them");
    assert!(reference.cells <= 12, "{reference:?}");
    let is_reference = |it: &Point| (it.cells, it.pace) == (reference.cells, reference.pace);
    assert!(!ended.points.iter().any(is_reference));
    assert!(ended.points.iter().any(|it| it.error().is_some()));
    assert!(
        ended
            .points
            .iter()
            .any(|point| point.failure.as_deref() == Some("ended"))
    );
    let none = study(&scene(CALM), budget, ComparedRuns::default(), &mut |_| {
        false
    });
    assert_eq!(none, Err(StudyError::Ended));
}

#[test]
fn the_number_of_chosen_steps_is_foreseen() {
    let scene = scene(CALM);
    let Ok(Foresight::Price(foreseen)) = run_estimate(&scene, &mut || true) else {
        panic!("it can be run");
    };
    let mut simulation = Simulation::new(&scene).expect("it is small");
    simulation.follow(&Schedule::new(&scene.time, 1, 5));
    while simulation.report().t < scene.time.end {
        simulation.advance().expect("solved");
    }
    assert_eq!(foreseen.steps, simulation.report().step);
    assert!(foreseen.seconds > 0.0 && foreseen.memory > 6_000_000);
}

#[test]
fn estimates_are_compared_with_what_was_measured() {
    let [time, space] = CALM_STUDY.effectivities();
    let ([least, greatest], [low, high]) = (time.expect("steps"), space.expect("mesh"));
    assert!(0.0 < least && least <= greatest, "{least} {greatest}");
    // A sum of what the equations damp: no less than a third of the error.
    assert!(least > 0.33, "{least}");
    assert!(0.0 < low && low <= high, "{low} {high}");
}

/// A study of a scene whose mesh is that of a file, or has values at its nodes.
fn study_of(text: &str, file: &'static str) -> Study {
    let mut read = |_: &str| Ok(file.as_bytes().to_vec());
    let scene = Scene::parse(text, "the test", &[], &mut read).expect("right");
    let budget = Budget {
        time: Duration::from_secs(600),
        full: false,
    };
    study(&scene, budget, ComparedRuns::default(), &mut |_| true).expect("it is small")
}

/// Two squares beside each other and one above the first, of two triangles each.
const L_SHAPE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 2 0 0\n\
    4 0 1 0\n5 1 1 0\n6 2 1 0\n7 0 2 0\n8 1 2 0\n$EndNodes\n$Elements\n6\n1 2 0 1 2 5\n2 2 0 1 5 4\n\
    3 2 0 2 3 6\n4 2 0 2 6 5\n5 2 0 4 5 8\n6 2 0 4 8 7\n$EndElements\n";

/// All that is written of a study is a number, or nothing.
fn assert_finite(study: &Study) {
    for point in &study.points {
        assert!(point.error().is_none() || point.errors.is_some());
    }
    let table = study.to_csv();
    let words = study.sentences.join("\n") + &chart(study);
    for word in ["NaN", "inf"] {
        assert!(
            !table.contains(word) && !words.contains(word),
            "{table}{words}"
        );
    }
}

#[test]
fn a_mesh_that_cannot_be_refined_has_errors_of_the_steps_alone() {
    let text = "mesh = { kind = 'file', path = 'l.msh' }
        vesicle = { shape = 'circle', radius = 0.5, center = [0.9, 0.9] }
        membrane.interface_width = 0.3
        time = { step = 1e-7, end = 1e-6 }";
    let study = study_of(text, L_SHAPE);
    assert_finite(&study);
    let own = study.points.iter().find(|point| point.is_own);
    let own = own.expect("the scene's own");
    assert!(own.error().is_some() && own.time_error.is_some(), "{own:?}");
    // Of the mesh nothing is known, and nothing is advised.
    assert_eq!((study.advice, &*study.floors), (None, &[][..]));
    let said = |words: &str| study.sentences.iter().any(|it| it.contains(words));
    assert!(said(
        "for it is that of l.msh: the errors are those of the steps alone"
    ));
    assert!(said("the error of φ from the steps is about"));
    let jittered = "mesh = { cells = 12, jitter = 0.1 }
        vesicle = { shape = 'circle', radius = 0.3 }
        membrane.interface_width = 0.1
        time = { step = 1e-7, end = 1e-6 }";
    let study = study_of(jittered, "");
    assert_finite(&study);
    assert!(study.advice.is_none() && study.floors.is_empty());
}
