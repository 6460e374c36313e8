//! What happens to the state: one pure function.

mod actions;
mod expecting;
mod news;
mod overlays;
mod saving;
mod stage;
#[cfg(test)]
mod tests;

use crossterm::event::{KeyEvent, KeyEventKind};

use super::keys::{self, Place};
use super::message::{Effect, Message};
use super::state::{App, Ending};

pub use expecting::wanted as expectation_wanted;
pub use overlays::offered;
pub(super) use stage::SNAPSHOTS;

/// Takes a message into the state; what is to be done about it is the caller's.
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
        Message::Solver(message) => news::hear(app, message),
        Message::Fields(picture) => news::show(app, picture),
        Message::Computing(run, computing) => {
            if let Some((index, run)) = news::run_of(app, run)
                && run.pace.computing != computing
            {
                run.pace.computing = computing;
                app.stale |= app.shows(index);
            }
        }
        Message::Loaded(Ok(slot)) => overlays::loaded(app, slot, &mut effects),
        Message::Loaded(Err(reason)) => overlays::not_loaded(app, reason),
        Message::Prices(text) => overlays::priced(app, text),
        Message::Expected(name, words) => expecting::expected(app, name, words),
        Message::Saved(outcome) => saving::saved(app, outcome, &mut effects),
        Message::Signal(number) => end(app, Ending::Signal(number), &mut effects),
        Message::HungUp => end(app, Ending::HungUp, &mut effects),
        Message::Remark(text) => remark(app, text),
        Message::Tick => {}
    }
    if app.ending.is_none() {
        expecting::follow(app, &mut effects);
        stage::direct(app, &mut effects);
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
            } else {
                overlays::act(app, action, effects);
            }
        }
        Some(Err(reason)) => remark(app, reason),
        None if place == Place::Open => overlays::type_in(app, event),
        None => {}
    }
}

/// Says something in passing: until the next key.
fn remark(app: &mut App, text: impl Into<String>) {
    app.remark = Some(text.into());
    app.stale = true;
}

/// Ends the app because someone else wants it: what was computed is saved without asking.
///
/// The active run comes first: there may be no time for all.
fn end(app: &mut App, ending: Ending, effects: &mut Vec<Effect>) {
    let is_unsaved = |index: &usize| {
        let run = app.slots[*index].run.as_ref();
        run.is_some_and(|run| run.unsaved)
    };
    let mut unsaved: Vec<usize> = (0..app.slots.len()).filter(is_unsaved).collect();
    unsaved.sort_by_key(|index| *index != app.active);
    effects.extend(unsaved.into_iter().map(Effect::SaveSet));
    leave(app, ending, effects);
}

fn leave(app: &mut App, ending: Ending, effects: &mut Vec<Effect>) {
    app.ending = Some(ending);
    app.stale = true;
    effects.push(Effect::Quit);
}
