//! The price list of accuracy: what a scene costs at several errors of φ, measured line by line, and the run of one of
//! them.

use super::super::state::{App, Overlay, PriceList, Slot};
use super::{overlays, remark};
use crate::study::Offer;

/// The key: shows the list of the active scene.
pub(super) fn open(app: &mut App) {
    let Some(slot) = app.active_slot() else {
        return;
    };
    let offers = Offer::all(&slot.scene);
    // Where none can be had, all have the same reason.
    if let Some(Err(why)) = offers.last().map(|offer| &offer.offered) {
        return remark(app, why.to_string());
    }
    let chosen = offers.iter().position(|offer| offer.offered.is_ok());
    let list = PriceList {
        name: slot.name.clone(),
        rows: offers.into_iter().map(|offer| (offer, None)).collect(),
        chosen: chosen.unwrap_or(0),
    };
    app.expectation.known = None;
    app.overlay = Some(Overlay::Accuracy(list));
}

/// Takes what the run of a line will take.
pub(super) fn priced(list: &mut PriceList, name: &str, words: &Result<String, String>) {
    for (offer, known) in &mut list.rows {
        if matches!(&offer.offered, Ok(offered) if offered.scene.name == name) {
            *known = Some(words.clone());
        }
    }
}

/// Runs the chosen line, in a place of its own.
pub(super) fn run(app: &mut App) {
    let Some(Overlay::Accuracy(list)) = app.overlay.take() else {
        return;
    };
    let Some((offer, _)) = list.rows.get(list.chosen) else {
        return;
    };
    match &offer.offered {
        Ok(offered) => {
            let name = format!("{}-{:e}", list.name, offer.error);
            let scene = (*offered.scene).clone();
            overlays::add(app, Slot::new(name, None, scene));
        }
        Err(why) => remark(app, why.to_string()),
    }
}
