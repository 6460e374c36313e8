//! What a scene would take that could be opened: measured in the background, one at a time, for the one
//! that is shown.

use std::sync::Arc;

use super::super::message::Effect;
use super::super::state::{App, Expectation, Overlay, PriceList};
use super::accuracy;
use super::overlays::candidate;
use crate::scene::Scene;

/// Asks for what the dialog that is open would show, unless that is known or something else is being
/// measured.
pub(super) fn follow(app: &mut App, effects: &mut Vec<Effect>) {
    let Some(name) = wanted(app) else {
        return;
    };
    let expectation = &app.expectation;
    if expectation.asked.is_some() || expectation.words(&name).is_some() {
        return;
    }
    let scene = match &app.overlay {
        Some(Overlay::Accuracy(list)) => unknown(list).map(Arc::clone),
        _ => None,
    };
    app.expectation.asked = Some(name.clone());
    effects.push(Effect::Expect(name, scene));
}

/// The name of the scene whose price is shown.
pub fn wanted(app: &App) -> Option<String> {
    match &app.overlay {
        Some(Overlay::Open { text, chosen, .. }) => candidate(text, *chosen),
        Some(Overlay::Accuracy(list)) => unknown(list).map(|scene| scene.name.clone()),
        _ => None,
    }
}

/// The scene of the first line whose price is not known.
fn unknown(list: &PriceList) -> Option<&Arc<Scene>> {
    list.rows.iter().find_map(|(offer, known)| {
        let offered = offer.offered.as_ref().ok().filter(|_| known.is_none())?;
        Some(&offered.scene)
    })
}

/// Takes what was measured; `None`: nothing, because it is no longer shown.
pub(super) fn expected(app: &mut App, name: String, words: Option<Result<String, String>>) {
    app.stale |= wanted(app).as_ref() == Some(&name);
    if let (Some(Overlay::Accuracy(list)), Some(words)) = (&mut app.overlay, &words) {
        accuracy::priced(list, &name, words);
    }
    let known = words.map(|words| (name, words));
    app.expectation = Expectation {
        asked: None,
        known: known.or_else(|| app.expectation.known.take()),
    };
}
