//! The shape at rest that theory foresees, over the field: solved for in the background, again where a change of parameters
//! makes it another one.

use std::sync::Arc;

use super::super::message::{Effect, TheoryJob};
use super::super::state::{App, Run, Theory};
use super::{remark, worker_events};
use crate::scene::{ScalarField, Scene, Timetable};
use crate::simulation::RunId;
use crate::theory::ShapeAtRest;

/// Shows the shape, or hides it; says why there is none.
pub(super) fn turn(app: &mut App) {
    app.view.theory = !app.view.theory;
    let run = app.active_slot().and_then(|slot| slot.run.as_ref());
    if let Some(Err(reason)) = run.and_then(|run| run.theory.known.as_ref()) {
        let reason = reason.clone();
        refuse(app, reason);
    }
}

/// Asks for the shapes that are to be shown and are not known.
pub(super) fn follow(app: &mut App, effects: &mut Vec<Effect>) {
    if !app.view.theory {
        return;
    }
    for slot in &mut app.slots {
        let Some(run) = slot.run.as_mut().filter(|run| !run.theory.is_going) else {
            continue;
        };
        effects.extend(wanted(&slot.scene, run));
    }
}

/// What a shape is to be solved for from, if that is not what it was solved for last.
fn wanted(scene: &Scene, run: &mut Run) -> Option<Effect> {
    let picture = run.picture.as_ref()?;
    let surface_area = run.history.surface_area.at_start()?;
    let scene = Timetable::of(scene).at(run.report.t);
    let is_curved = scene.membrane.spontaneous_curvature != ScalarField::Constant(0.0);
    let asked = Some((scene.area, is_curved, picture.report.vesicles.len()));
    if run.theory.asked == asked {
        return None;
    }
    let picture = Arc::clone(picture);
    run.theory = Theory {
        asked,
        is_going: true,
        known: run.theory.known.take(),
    };
    let job = TheoryJob {
        scene,
        surface_area,
    };
    Some(Effect::Foresee(picture, Box::new(job)))
}

/// Takes a shape, or why there is none.
pub(super) fn foreseen(app: &mut App, run: RunId, shape: Result<Arc<ShapeAtRest>, String>) {
    let reason = shape.as_ref().err().cloned();
    let Some((index, run)) = worker_events::run_of(app, run) else {
        return;
    };
    run.theory.is_going = false;
    run.theory.known = Some(shape);
    app.stale |= app.shows(index);
    if let Some(reason) = reason.filter(|_| app.view.theory && index == app.active) {
        refuse(app, reason);
    }
}

/// Says why there is no shape to be shown.
fn refuse(app: &mut App, reason: String) {
    if app.view.theory {
        app.view.theory = false;
        remark(app, reason);
    }
}
