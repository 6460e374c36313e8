//! What lies over the screen and takes the keys first, and scenes that come from there.

use std::path::Path;
use std::sync::Arc;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::super::autosave::Kept;
use super::super::keys::{self, Action};
use super::super::message::Effect;
use super::super::panel::message_overflow;
use super::super::state::{App, Ending, Overlay, Question, Slot};
use super::actions::{ask, consent, look_at};
use super::{accuracy, leave, remark};
use crate::scene::preset_names;

/// The presets that are offered for what was typed: those that contain it.
pub fn offered(text: &str) -> Vec<&'static str> {
    preset_names()
        .filter(|name| name.contains(text.trim()))
        .collect()
}

/// The scene that would be opened for what was typed and chosen, if that is a scene's name.
pub(super) fn candidate(text: &str, chosen: Option<usize>) -> Option<String> {
    let names = offered(text);
    if let Some(name) = chosen.and_then(|index| names.get(index)) {
        return Some((*name).to_owned());
    }
    let text = text.trim();
    (names.contains(&text) || text.ends_with(".toml")).then(|| text.to_owned())
}

pub(super) fn act(app: &mut App, action: Action, effects: &mut Vec<Effect>) {
    match (action, &mut app.overlay) {
        (Action::Quit, Some(Overlay::Confirm(Question::Quit))) => {
            leave(app, Ending::Quit, effects);
        }
        (Action::Quit, _) => {
            app.reloaded = None;
            app.overlay = None;
            ask(app, Question::Quit, effects);
        }
        (Action::Suspend, _) => effects.push(Effect::Suspend),
        (Action::Yes, Some(Overlay::Confirm(question))) => {
            let question = *question;
            app.overlay = None;
            consent(app, question, effects);
        }
        (Action::Close, Some(Overlay::Confirm(Question::GoOn))) => {
            app.overlay = None;
            take_kept(app);
            remark(
                app,
                "what was kept stays as it is, to be asked about the next time; the runs of now are \
                 kept beside it",
            );
        }
        (Action::No | Action::Close, Some(Overlay::Confirm(question))) => {
            let question = *question;
            app.overlay = None;
            if question == Question::GoOn {
                let kept = take_kept(app);
                effects.push(Effect::PutAside(kept));
            }
            if question == Question::Reload {
                app.reloaded = None;
                remark(
                    app,
                    "the run continues with the scene as it was before it was edited",
                );
            }
        }
        (Action::Close, _) => app.overlay = None,
        (Action::Choose(by), Some(Overlay::Accuracy(list))) => {
            let last = list.rows.len().saturating_sub(1);
            list.chosen = list.chosen.saturating_add_signed(by as isize).min(last);
        }
        (Action::Load, Some(Overlay::Accuracy(_))) => accuracy::run(app),
        (Action::Scroll(lines), Some(Overlay::Help { scroll })) => {
            let last = keys::help().count() as i32 - 1;
            *scroll = i32::from(*scroll)
                .saturating_add(lines)
                .clamp(0, last.max(0)) as u16;
        }
        (Action::Scroll(lines), Some(Overlay::Message { text, scroll, .. })) => {
            let last = message_overflow(text, app.size) as i32;
            *scroll = i32::from(*scroll).saturating_add(lines).clamp(0, last) as u16;
        }
        (
            action,
            Some(Overlay::Open {
                text,
                chosen,
                error,
            }),
        ) => {
            *error = None;
            let names = offered(text);
            match action {
                Action::Choose(by) => *chosen = next_choice(*chosen, by, names.len()),
                Action::Complete => {
                    let index = chosen.unwrap_or(0);
                    if let Some(name) = names.get(index) {
                        *text = (*name).to_owned();
                        *chosen = None;
                    }
                }
                Action::Erase => {
                    text.pop();
                    *chosen = None;
                }
                Action::Clear => {
                    text.clear();
                    *chosen = None;
                }
                Action::Load => {
                    let name = chosen.and_then(|index| names.get(index).copied());
                    let name = name.unwrap_or(text.trim());
                    if name.is_empty() {
                        *error = Some("type a preset's name or a file's path".to_owned());
                    } else {
                        effects.push(Effect::Load(name.to_owned()));
                    }
                }
                _ => {}
            }
        }
        _ => {}
    }
}

/// The kept runs that were offered, and are no longer, with their slots.
fn take_kept(app: &mut App) -> Vec<(usize, Arc<Kept>)> {
    let slots = app.slots.iter_mut().enumerate();
    let slots = slots.filter(|(_, slot)| slot.offered().is_some());
    let kept = slots.filter_map(|(index, slot)| Some((index, slot.kept.take()?)));
    kept.collect()
}

/// The next line of a list; before the first and after the last there is none chosen.
fn next_choice(chosen: Option<usize>, by: i32, count: usize) -> Option<usize> {
    let lines = count as i32 + 1;
    let present = chosen.map_or(0, |index| index as i32 + 1);
    let line = (present + by).rem_euclid(lines);
    usize::try_from(line - 1).ok()
}

/// Types a character.
pub(super) fn type_in(app: &mut App, event: &KeyEvent) {
    let plain = (event.modifiers - KeyModifiers::SHIFT).is_empty();
    if let KeyCode::Char(character) = event.code
        && plain
        && let Some(Overlay::Open {
            text,
            chosen,
            error,
        }) = &mut app.overlay
    {
        text.push(character);
        *chosen = None;
        *error = None;
        app.stale = true;
    }
}

/// Takes a scene that was loaded: one that has a slot already is shown, or replaces the
/// one there if it was edited; another one gets a slot of its own.
pub(super) fn loaded(app: &mut App, slot: Box<Slot>, effects: &mut Vec<Effect>) {
    app.stale = true;
    if matches!(app.overlay, Some(Overlay::Open { .. })) {
        app.overlay = None;
    }
    let edited = app.editing.take().and_then(|index| app.slots.get(index));
    if edited.is_some_and(|edited| is_unchanged(edited, &slot)) {
        remark(app, "the scene is unchanged");
        return;
    }
    let known = app.slots.iter().position(|other| match &slot.file {
        Some(file) => other.file.as_ref() == Some(file),
        None => other.file.is_none() && other.name == slot.name,
    });
    let Some(index) = known else {
        add(app, *slot);
        app.offer_to_go_on();
        return;
    };
    look_at(app, index);
    if slot.file.is_none() {
        return;
    }
    if is_unchanged(&app.slots[index], &slot) {
        remark(app, format!("the scene of {} is unchanged", slot.name));
    } else {
        app.reloaded = Some((index, slot));
        ask(app, Question::Reload, effects);
    }
}

/// Gives a scene a slot of its own and shows it.
pub(super) fn add(app: &mut App, mut slot: Slot) {
    slot.name = own_name(app, slot.name, slot.file.as_deref());
    app.slots.push(slot);
    look_at(app, app.slots.len() - 1);
}

/// A name that no other slot has: a file with the name of another scene keeps its extension.
fn own_name(app: &App, name: String, file: Option<&Path>) -> String {
    let is_taken = |name: &str| app.slots.iter().any(|slot| slot.name == name);
    let whole = file
        .and_then(Path::file_name)
        .map(|it| it.to_string_lossy());
    let whole = whole.map_or(name.clone(), |whole| whole.into_owned());
    let numbered = (2..).map(|number: u64| format!("{name}-{number}"));
    let mut names = [name.clone(), whole].into_iter().chain(numbered);
    names.find(|name| !is_taken(name)).unwrap_or(name)
}

/// Whether a scene is that of a slot, but for the anchoring that was chosen since it was loaded.
fn is_unchanged(slot: &Slot, loaded: &Slot) -> bool {
    let run = slot.run.as_ref();
    let started = run.and_then(|run| run.setting.as_ref());
    slot.scene == loaded.scene
        || slot.loaded == loaded.loaded
        || started.is_some_and(|setting| setting.scene == *loaded.scene)
}

/// Takes what effects cost, if that is still looked at.
pub(super) fn priced(app: &mut App, event: String) {
    if let Some(Overlay::Prices { text }) = &mut app.overlay {
        *text = event;
        app.stale = true;
    }
}

/// Takes why a scene could not be loaded.
pub(super) fn not_loaded(app: &mut App, reason: String) {
    app.stale = true;
    app.editing = None;
    match &mut app.overlay {
        Some(Overlay::Open { error, .. }) => *error = Some(reason),
        overlay => {
            *overlay = Some(Overlay::Message {
                title: "The scene cannot be loaded".to_owned(),
                text: reason,
                scroll: 0,
            });
        }
    }
}
