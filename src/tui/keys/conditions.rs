//! When keys do something, why they do not, and their words that depend on it.

use super::super::panel::message_overflow;
use super::super::state::{App, Overlay, Run, Screen, Slot, Status};

pub(super) fn always(_: &App) -> Result<(), &'static str> {
    Ok(())
}

pub(super) fn with_more_lines(app: &App) -> Result<(), &'static str> {
    match &app.overlay {
        Some(Overlay::Message { text, .. }) if message_overflow(text, app.size) > 0 => Ok(()),
        _ => Err("all of it is shown"),
    }
}

pub(super) fn on_one_run(app: &App) -> Result<(), &'static str> {
    match app.screen {
        Screen::Run => Ok(()),
        Screen::Gallery => Err("not in the gallery: Esc leaves it"),
    }
}

pub(super) fn when_not_over(app: &App) -> Result<(), &'static str> {
    let status = app.active_run().map(|run| &run.status);
    match (app.screen, status) {
        (Screen::Run, Some(Status::Failed(_))) => {
            Err("the run has failed: r restarts it, e edits its scene")
        }
        (Screen::Gallery, _) if app.slots[app.gallery()].iter().all(is_over) => {
            Err("all runs are over: Enter looks at one of them")
        }
        _ => Ok(()),
    }
}

fn is_over(slot: &Slot) -> bool {
    slot.run.as_ref().is_some_and(Run::is_over)
}

pub(super) fn when_a_step_is_left(app: &App) -> Result<(), &'static str> {
    on_one_run(app).and_then(|()| when_not_over(app))
}

pub(super) fn with_a_past(app: &App) -> Result<(), &'static str> {
    on_one_run(app)?;
    match app.active_run() {
        Some(run) if run.past.len() > 1 => Ok(()),
        _ => Err("nothing older is stored yet"),
    }
}

pub(super) fn at_present_with_director(app: &App) -> Result<(), &'static str> {
    with_director(app)?;
    match app.looking_back {
        None => Ok(()),
        Some(_) => {
            Err("this is the past: End shows the present, where the anchoring can be changed")
        }
    }
}

pub(super) fn when_it_can_change(app: &App) -> Result<(), &'static str> {
    on_one_run(app)?;
    if app.looking_back.is_some() {
        return Err("this is the past: End shows the present, which can be changed");
    }
    match app.active_run() {
        None => Err("the run has not begun: e edits its scene"),
        Some(run) if run.setting.is_none() => Err("the run is still set up"),
        Some(run) if run.is_done() => {
            Err("the run is over: space continues it, then it can be changed")
        }
        Some(run) if run.is_over() => Err("the run has failed: r restarts it, e edits its scene"),
        Some(_) => Ok(()),
    }
}

pub(super) fn with_a_change(app: &App) -> Result<(), &'static str> {
    when_it_can_change(app)?;
    match app.active_run() {
        Some(run) if !run.undo.is_empty() && !run.undoing => Ok(()),
        _ => Err("nothing was changed by hand"),
    }
}

pub(super) fn on_a_case(app: &App) -> Result<(), &'static str> {
    match app.other_form() {
        Some(_) => Ok(()),
        None => Err("only for the four cases: 1 to 4 show them"),
    }
}

/// The other form of the cases, in a word or two.
pub fn other_form(app: &App) -> &'static str {
    match app.form {
        0 => "as printed",
        _ => "quick",
    }
}

pub(super) fn brake(app: &App) -> &'static str {
    match app.brake.on {
        true => "brake off",
        false => "brake on",
    }
}

pub(super) fn measure(app: &App) -> &'static str {
    match app.active_run().and_then(|run| run.measurement.as_ref()) {
        Some(measurement) if !measurement.rows.is_empty() => "errors",
        Some(measurement) if measurement.is_going => "measure no more",
        _ => "measure error",
    }
}

pub(super) fn play(app: &App) -> &'static str {
    match app.replay {
        Some(_) => "stop",
        None => "play again",
    }
}

pub(super) fn with_director(app: &App) -> Result<(), &'static str> {
    match app.active_slot() {
        Some(slot) if slot.scene.nematic.is_none() => {
            Err("this scene has no director: give it a table [nematic]")
        }
        _ => Ok(()),
    }
}

pub(super) fn with_notices(app: &App) -> Result<(), &'static str> {
    on_one_run(app)?;
    match app.active_run() {
        Some(run) if !run.notices.is_empty() => Ok(()),
        _ => Err("there is no warning, and nothing to note"),
    }
}

pub(super) fn with_picture(app: &App) -> Result<(), &'static str> {
    match app.picture() {
        Some(_) => Ok(()),
        None => Err("there is nothing to save yet"),
    }
}

pub(super) fn with_picture_alone(app: &App) -> Result<(), &'static str> {
    on_one_run(app)?;
    with_picture(app)
}

pub(super) fn with_opened_scenes(app: &App) -> Result<(), &'static str> {
    if app.slots.len() > app.opened() {
        Ok(())
    } else {
        Err("no other scene is open: o opens one")
    }
}

pub(super) fn pause_or_resume(app: &App) -> &'static str {
    match app.active_run() {
        Some(run) if app.screen == Screen::Run && run.is_done() => "go on to 2T",
        _ if app.is_going() => "pause",
        _ => "resume",
    }
}

pub(super) fn gallery(app: &App) -> &'static str {
    match app.screen {
        Screen::Gallery if !app.gallery_of_opened => "one run",
        _ => "four cases",
    }
}

pub(super) fn gallery_of_opened(app: &App) -> &'static str {
    match app.screen {
        Screen::Gallery if app.gallery_of_opened => "one run",
        _ => "opened scenes",
    }
}

pub(super) fn next_panel(app: &App) -> &'static str {
    match app.screen {
        Screen::Run => "panel",
        Screen::Gallery => "next run",
    }
}

pub(super) fn in_gallery(app: &App) -> Result<(), &'static str> {
    match app.screen {
        Screen::Gallery => Ok(()),
        Screen::Run => Err("only in the gallery: g opens it"),
    }
}
