//! Which knob is the one to turn, from what was measured.

use super::choice::Pace;
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
    pub pace: Pace,
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
    let (cells, pace, what) = (judged.cells, judged.pace, whose(study, judged));
    let (Some(space), Some(time)) = (space, time) else {
        let known = match (space, time) {
            (Some(space), None) => format!(
                "At {cells} cells and {pace}{what} the error of φ from the mesh is about {space:.1e}; that of the \
                 steps is not known."
            ),
            (None, Some(time)) => format!(
                "At {cells} cells and {pace}{what} the error of φ from the steps is about {time:.1e}; that of the \
                 mesh is not known."
            ),
            _ => "What part of the error is that of the mesh and of the steps is not known.".to_owned(),
        };
        return (None, vec![known]);
    };
    let advice = Advice {
        knob: Knob::of(space, time),
        space,
        time,
        cells,
        pace,
    };
    let mut sentences = vec![format!(
        "At {cells} cells and {pace}{what} the error of φ is about {space:.1e} from the mesh and {time:.1e} \
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
        _ => format!(" (not the scene's mesh of {} cells)", own.cells),
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
        std::iter::once(study.own.cells).chain(others).find_map(|cells| {
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

/// A reference whose own error is this part of what it measures, or more, is no measure of it.
const COARSE: f64 = 0.5;

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
        "From {coarser} to {} cells took {:.1}× the time and gave {:.1}× less error from the mesh.",
        judged.cells,
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
        .filter(|point| point.error().is_some_and(|it| it.get() <= 1.05 * error.get()))
        .min_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
    (best.seconds < 0.8 * judged.seconds).then(|| {
        let mesh = match &best.run {
            Some(run) => format!("The run {run} with {} nodes", best.nodes),
            None => format!("{} cells", best.cells),
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
