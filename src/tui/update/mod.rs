//! What happens to the state: one pure function.

mod accuracy;
mod actions;
mod estimates;
mod knobs;
mod measuring;
mod overlays;
mod pacing;
mod saving;
mod scheduling;
#[cfg(test)]
mod tests;
mod theory;
mod worker_events;

use crossterm::event::{KeyEvent, KeyEventKind, KeyModifiers};

use super::keys::{self, Place};
use super::message::{Effect, Message};
use super::state::{App, Ending};

pub use estimates::wanted as expectation_wanted;
pub use overlays::offered;
pub use pacing::time_counts;
pub(super) use scheduling::SNAPSHOTS;
pub use scheduling::common_time;

/// Takes a message into the state; the caller carries out the returned effects.
///
/// `app.stale` is set if something that shows has changed, and left as it is if not. The caller
/// clears it when it has drawn.
pub fn update(app: &mut App, message: Message) -> Vec<Effect> {
    let mut effects = Vec::new();
    if app.ending.is_some() {
        return effects;
    }
    match message {
        Message::Key(event) => press(app, &event, &mut effects),
        Message::Resized(columns, rows) => {
            app.stale |= app.size != (columns, rows);
            app.size = (columns, rows);
        }
        Message::Continued => app.stale = true,
        Message::Solver(message) => worker_events::hear(app, message),
        Message::Fields(picture) => worker_events::show(app, picture),
        Message::Computing(run, computing) => {
            if let Some((index, run)) = worker_events::run_of(app, run)
                && run.pace.computing != computing
            {
                run.pace.computing = computing;
                app.stale |= app.shows(index);
            }
        }
        Message::Kept(run, keeping) => {
            if let Some((index, run)) = worker_events::run_of(app, run) {
                run.keeping = keeping;
                app.stale |= app.shows(index) || app.overlay.is_some();
            }
        }
        Message::Loaded(Ok(slot)) => overlays::loaded(app, slot, &mut effects),
        Message::Loaded(Err(reason)) => overlays::not_loaded(app, reason),
        Message::Prices(text) => overlays::priced(app, text),
        Message::Expected(name, words) => estimates::expected(app, name, words),
        Message::Saved(outcome) => saving::saved(app, outcome, &mut effects),
        // What was computed is kept without asking.
        Message::Signal(number) => leave(app, Ending::Signal(number), &mut effects),
        Message::HungUp => leave(app, Ending::HungUp, &mut effects),
        Message::FreeMemory(free) => worker_events::find_room(app, free),
        Message::Foreseen(run, shape) => theory::foreseen(app, run, shape),
        Message::Measured(run, news) => measuring::measured(app, run, news),
        Message::NotEdited => {
            app.editing = None;
            remark(
                app,
                "nothing was changed: the scene stays, and no copy is left",
            );
        }
        Message::Remark(text) => remark(app, text),
        Message::Passed(passed) => pacing::passed(app, passed),
        Message::Tick => {}
    }
    if app.ending.is_none() {
        estimates::follow(app, &mut effects);
        theory::follow(app, &mut effects);
        scheduling::direct(app, &mut effects);
    }
    effects
}

fn press(app: &mut App, event: &KeyEvent, effects: &mut Vec<Effect>) {
    if event.kind == KeyEventKind::Release {
        return;
    }
    let place = Place::of(app);
    match keys::action(app, event) {
        Some(Ok(action)) => {
            app.remark = None;
            app.stale = true;
            if place == Place::Main {
                actions::act(app, action, effects);
            } else if place == Place::Knobs {
                let is_fine = event.modifiers.contains(KeyModifiers::SHIFT);
                knobs::act(app, action, is_fine, effects);
            } else {
                overlays::act(app, action, effects);
            }
        }
        Some(Err(reason)) => remark(app, reason),
        None if place == Place::Open => overlays::type_in(app, event),
        None if place == Place::Knobs => knobs::type_in(app, event),
        None => {}
    }
}

/// Says something in passing: until the next key.
fn remark(app: &mut App, text: impl Into<String>) {
    app.remark = Some(text.into());
    app.stale = true;
}

fn leave(app: &mut App, ending: Ending, effects: &mut Vec<Effect>) {
    app.ending = Some(ending);
    app.stale = true;
    effects.push(Effect::Quit);
}
