//! Changing parameters while the run goes.

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::super::keys::Action;
use super::super::knobs::Knobs;
use super::super::message::Effect;
use super::super::state::{App, Overlay};
use super::{overlays, remark};
use crate::scene::{Assignment, Change};
use crate::simulation::Command;

/// Shows the parameters of the active run.
pub(super) fn open(app: &mut App) {
    let knobs = app.active_slot().and_then(|slot| {
        let t = slot.run.as_ref()?.report.t;
        Some(Knobs::of(&slot.scene, t))
    });
    app.overlay = knobs.map(Overlay::Knobs);
}

/// Carries out a key of the dialog; `is_fine`: with Shift.
pub(super) fn act(app: &mut App, action: Action, is_fine: bool, effects: &mut Vec<Effect>) {
    let Some(Overlay::Knobs(knobs)) = &mut app.overlay else {
        return;
    };
    knobs.error = None;
    match action {
        Action::Choose(by) => knobs.choose(by),
        Action::Turn(by) => knobs.turn(by, is_fine),
        Action::Erase => {
            let is_left = knobs.typed.as_mut().is_some_and(|typed| {
                typed.pop();
                !typed.is_empty()
            });
            knobs.typed = knobs.typed.take().filter(|_| is_left);
        }
        Action::Clear => knobs.typed = None,
        Action::Duration => {
            knobs.typed = None;
            knobs.types_duration = !knobs.types_duration;
        }
        // What is typed is given up first.
        Action::Close if knobs.typed.is_some() || knobs.types_duration => {
            knobs.typed = None;
            knobs.types_duration = false;
        }
        Action::Apply => apply(app, effects),
        other => overlays::act(app, other, effects),
    }
}

/// Types a character of a number.
pub(super) fn type_in(app: &mut App, event: &KeyEvent) {
    let plain = (event.modifiers - KeyModifiers::SHIFT).is_empty();
    if let KeyCode::Char(character) = event.code
        && plain
        && let Some(Overlay::Knobs(knobs)) = &mut app.overlay
    {
        knobs.error = None;
        knobs.type_in(character);
        app.stale = true;
    }
}

/// Takes the number that is typed; a further time makes the change.
fn apply(app: &mut App, effects: &mut Vec<Effect>) {
    let Some(Overlay::Knobs(knobs)) = &mut app.overlay else {
        return;
    };
    match knobs.take_typed() {
        Err(reason) => knobs.error = Some(reason),
        Ok(true) => {}
        Ok(false) => {
            knobs.types_duration = false;
            let (set, over) = (knobs.assignments(), knobs.over);
            if set.is_empty() {
                app.overlay = None;
                remark(app, "nothing was changed");
                return;
            }
            match request(app, set, over, effects) {
                Ok(()) => app.overlay = None,
                Err(reason) => {
                    if let Some(Overlay::Knobs(knobs)) = &mut app.overlay {
                        knobs.error = Some(reason);
                    }
                }
            }
        }
    }
}

/// Takes the last change back, by a further one.
pub(super) fn take_back(app: &mut App, effects: &mut Vec<Effect>) {
    let Some(set) = app.active_run_mut().and_then(|run| run.undo.pop()) else {
        return;
    };
    match request(app, set, 0.0, effects) {
        Ok(()) => {
            if let Some(run) = app.active_run_mut() {
                run.undoing = true;
            }
        }
        Err(reason) => remark(app, reason),
    }
}

/// Asks the worker for a change; refuses one that the scene cannot have.
fn request(
    app: &mut App,
    set: Vec<Assignment>,
    over: f64,
    effects: &mut Vec<Effect>,
) -> Result<(), String> {
    let Some((slot, run)) = app
        .active_slot()
        .and_then(|slot| Some((slot, slot.run.as_ref()?)))
    else {
        return Ok(());
    };
    let change = Change {
        at: run.report.t,
        over,
        set,
    };
    let mut scene = (*slot.scene).clone();
    if let Err(error) = scene.add_change(&change) {
        return Err(error.problem.to_string());
    }
    let id = run.id;
    let words = format!("{change} from the next step on");
    let set = change.set;
    effects.push(Effect::Tell(id, Command::Change { set, over }));
    remark(app, words);
    Ok(())
}
