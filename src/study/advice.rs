//! Which knob is the one to turn, from what was measured.

use super::discretisation::StepControl;
use super::error_size::ErrorSize;
use super::report::{Point, Study};
use serde::Serialize;

/// What can be turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Knob {
    /// mesh.cells.
    Mesh,
    /// time.step or time.tolerance.
    Steps,
    /// Neither stands out.
    Both,
}

/// Of two parts of an error one dominates if it is so many times the other.
const DOMINATES: f64 = 2.0;

/// What to turn, and what it brings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Advice {
    /// The knob.
    pub knob: Knob,
    /// The part of φ's error that is due to the mesh.
    pub space: ErrorSize,
    /// The part that is due to the steps.
    pub time: ErrorSize,
    /// 1/h of the point that is judged: the scene's own, or one on its mesh, or on the finest that was run.
    pub cells: usize,
    /// How long its steps are.
    pub pace: StepControl,
}

impl Knob {
    /// The knob for these parts of the error.
    pub fn of(space: ErrorSize, time: ErrorSize) -> Self {
        let (space, time) = (space.get(), time.get());
        if space >= DOMINATES * time {
            Self::Mesh
        } else if time >= DOMINATES * space {
            Self::Steps
        } else {
            Self::Both
        }
    }
}

/// The advice for a study, and sentences that say it.
pub(super) fn advice(study: &Study) -> (Option<Advice>, Vec<String>) {
    let Some(judged) = judged(study) else {
        let sentence = "Too little was run within the budget to say what to turn: raise --budget.";
        return (None, vec![sentence.to_owned()]);
    };
    let floor = study
        .floors
        .iter()
        .find(|(cells, _)| *cells == judged.cells);
    let (space, time) = (floor.map(|(_, space)| *space), time_error(study, judged));
    let (mesh, pace, what) = (&judged.mesh, judged.pace, whose(study, judged));
    let (Some(space), Some(time)) = (space, time) else {
        let known = match (space, time) {
            (Some(space), None) => format!(
                "At {mesh} and {pace}{what} the error of φ from the mesh is about {space:.1e}; that of the \
                 steps is not known."
            ),
            (None, Some(time)) => format!(
                "At {mesh} and {pace}{what} the error of φ from the steps is about {time:.1e}; that of the \
                 mesh is not known."
            ),
            _ => "What part of the error is that of the mesh and of the steps is not known."
                .to_owned(),
        };
        return (None, vec![known]);
    };
    let advice = Advice {
        knob: Knob::of(space, time),
        space,
        time,
        cells: judged.cells,
        pace,
    };
    let mut sentences = vec![format!(
        "At {mesh} and {pace}{what} the error of φ is about {space:.1e} from the mesh and {time:.1e} \
         from the steps: {}.",
        match advice.knob {
            Knob::Mesh => "the mesh dominates",
            Knob::Steps => "the steps dominate",
            Knob::Both => "the two are of the same size",
        }
    )];
    sentences.extend(coarse_reference(study, judged));
    sentences.extend(finer_mesh(study, judged));
    sentences.push(match advice.knob {
        Knob::Mesh => "Shorter steps gain nothing here.".to_owned(),
        Knob::Steps => "A finer mesh gains nothing before the steps are shorter.".to_owned(),
        Knob::Both => "Turn both together: neither gains much alone.".to_owned(),
    });
    sentences.extend(cheaper(study, judged));
    (Some(advice), sentences)
}

/// Whose point is judged, where it is not the scene's own.
fn whose(study: &Study, judged: &Point) -> String {
    let own = &study.own;
    match judged {
        it if it.is_own => String::new(),
        it if it.cells == own.cells => " (the scene's mesh, but not its steps)".to_owned(),
        _ => format!(" (not the scene's mesh of {})", study.mesh_words(own.cells)),
    }
}

/// The scene's own point, or one on its mesh, or the finest one that was run: with its iteration and
/// rule, and the smallest tolerance.
fn judged(study: &Study) -> Option<&Point> {
    let known = || study.points.iter().filter(|point| point.error().is_some());
    let own = known().find(|point| point.is_own);
    own.or_else(|| {
        let meshes = study.meshes();
        let others = meshes.into_iter().rev();
        std::iter::once(study.own.cells)
            .chain(others)
            .find_map(|cells| {
                let rungs = study.rungs(cells);
                let mut rungs = rungs.iter().map(|(_, point)| *point).rev();
                rungs.find(|point| point.error().is_some())
            })
    })
    .or_else(|| known().max_by_key(|point| point.nodes))
}

/// The part of a point's error that is due to its steps: measured on its mesh, or on the finest one
/// on which the same steps were measured.
fn time_error(study: &Study, point: &Point) -> Option<ErrorSize> {
    point.time_error.or_else(|| {
        let same = study.points.iter().filter(|other| {
            other.pace == point.pace && other.time_error.is_some() && other.cells <= point.cells
        });
        same.max_by_key(|other| other.cells)?.time_error
    })
}

/// A reference whose own error is this part of what it measures, or more, is no measure of it: about what is left
/// where it has half the width, and the order is 2.
const COARSE: f64 = 0.35;

/// That the reference's own error is no small part of what it measures.
fn coarse_reference(study: &Study, judged: &Point) -> Option<String> {
    let reference = study.reference.as_ref()?;
    let measured = judged.error()?.get();
    let parts = [reference.space_error, reference.time_error];
    let own: f64 = parts.into_iter().flatten().map(ErrorSize::get).sum();
    let share = own / measured;
    (share >= COARSE).then(|| {
        format!(
            "The reference's own error, about {own:.1e}, is {:.0} % of what it measures there, {measured:.1e}: the \
             errors of fine meshes are too small by about as much. A larger --budget pays for a finer reference.",
            100.0 * share
        )
    })
}

/// What the last refinement of the mesh cost and brought.
fn finer_mesh(study: &Study, judged: &Point) -> Option<String> {
    let floor = |cells: usize| study.floors.iter().find(|(known, _)| *known == cells);
    let coarser = study
        .meshes()
        .into_iter()
        .rfind(|cells| *cells < judged.cells)?;
    let (_, before) = floor(coarser)?;
    let (_, after) = floor(judged.cells)?;
    let (old, new) = (study.rungs(coarser), study.rungs(judged.cells));
    let pair = new.iter().find_map(|(tolerance, point)| {
        let same = old.iter().find(|(other, _)| other == tolerance)?;
        Some((same.1.seconds, point.seconds))
    })?;
    Some(format!(
        "From {} to {} took {:.1}× the time and gave {:.1}× less error from the mesh.",
        study.mesh_words(coarser),
        judged.mesh,
        pair.1 / pair.0.max(1e-9),
        before.get() / after.get(),
    ))
}

/// A point that is as accurate and cheaper.
fn cheaper(study: &Study, judged: &Point) -> Option<String> {
    let error = judged.error()?;
    let best = study
        .points
        .iter()
        .filter(|point| {
            point
                .error()
                .is_some_and(|it| it.get() <= 1.05 * error.get())
        })
        .min_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
    (best.seconds < 0.8 * judged.seconds).then(|| {
        let mesh = match &best.run {
            Some(run) => format!("The run {run} with {} nodes", best.nodes),
            None => best.mesh.clone(),
        };
        format!(
            "{mesh} and {} ({}, {}) give the same error in {:.2} of the time.",
            best.pace,
            best.quadrature,
            best.iteration,
            best.seconds / judged.seconds,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::discretisation::Discretisation;
    use super::super::errors::Errors;
    use super::super::report::Reference;
    use super::*;
    use crate::study::tests::{CALM, scene};

    /// Points of 60 and 120 cells with an error of second order, measured against a reference.
    fn study(reference: usize, own_cells: usize) -> Study {
        let own = Discretisation {
            cells: own_cells,
            pace: StepControl::Step(1e-7),
            ..Discretisation::of(&scene(CALM))
        };
        let error = |cells: usize| {
            let square = |cells: usize| (cells as f64).powi(-2);
            ErrorSize::new(square(cells) - square(reference))
        };
        let point = |cells: usize, tolerance: f64| Point {
            cells,
            mesh: format!("{cells} cells"),
            nodes: (cells + 1) * (cells + 1),
            pace: StepControl::Tolerance(tolerance),
            quadrature: "consistent",
            iteration: "newton",
            run: None,
            is_own: false,
            seconds: cells as f64,
            memory: None,
            steps: 10,
            refused: 0,
            newton: 10,
            krylov: 10,
            errors: Some(Errors {
                phase: error(cells),
                membrane: None,
                director: None,
                energy: None,
                surface_area: None,
            }),
            time_error: ErrorSize::new(1e-3 * tolerance),
            estimated_time: None,
            estimated_space: None,
            estimated_algebra: None,
            failure: None,
            is_pareto: false,
        };
        let points = [60, 120].map(|cells| [1e-3, 1e-4].map(|tolerance| point(cells, tolerance)));
        let reference = Reference {
            run: None,
            cells: reference,
            mesh: format!("{reference} cells"),
            nodes: (reference + 1) * (reference + 1),
            pace: StepControl::Tolerance(1e-4),
            seconds: 100.0,
            time_error: None,
            space_error: None,
        };
        let points = points.into_iter().flatten().collect();
        Study::new("made up", own, points, Some(reference), Vec::new())
    }

    #[test]
    fn a_reference_that_is_no_measure_is_said_to_be_none() {
        let said = |study: &Study| {
            let words = study.sentences.iter();
            words.filter(|it| it.contains("own error, about")).count()
        };
        assert_eq!(said(&study(180, 120)), 1);
        assert_eq!(said(&study(210, 120)), 1);
        assert_eq!(said(&study(360, 120)), 0);
    }

    #[test]
    fn whose_errors_are_told_is_said() {
        let first = |own_cells: usize| study(240, own_cells).sentences[0].clone();
        let mesh = first(120);
        assert!(
            mesh.contains("At 120 cells and tolerance 1e-4 (the scene's mesh, but not its steps)"),
            "{mesh}"
        );
        let coarser = first(60);
        assert!(
            coarser.contains("At 60 cells and tolerance 1e-4 (the scene's mesh,"),
            "{coarser}"
        );
        let other = first(200);
        assert!(
            other.contains("At 120 cells and tolerance 1e-4 (not the scene's mesh of 200 cells)"),
            "{other}"
        );
    }

    /// On the reference's own mesh nothing is known of the mesh.
    #[test]
    fn a_mesh_has_no_error_against_itself() {
        let study = study(120, 120);
        let meshes: Vec<usize> = study.floors.iter().map(|(cells, _)| *cells).collect();
        assert_eq!(meshes, [60]);
        assert_eq!(study.advice.map(|it| it.cells), Some(60));
        let told = &study.sentences[0];
        assert!(
            told.contains("(not the scene's mesh of 120 cells)"),
            "{told}"
        );
    }
}
