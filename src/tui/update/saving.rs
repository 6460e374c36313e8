//! What is saved in the background: one job at a time, and one that waits.

use std::path::PathBuf;

use super::super::message::Effect;
use super::super::state::{App, Save, Saving};
use super::{remark, worker_events};

/// Has something saved, now or after what is being saved.
pub(super) fn save(app: &mut App, save: Save, effects: &mut Vec<Effect>) {
    if app.saving_now.is_none() {
        begin(app, save, effects);
    } else if app.saving_next.is_none() {
        let text = format!("{} follows", words(app, &save));
        app.saving_next = Some(save);
        remark(app, text);
    } else {
        remark(
            app,
            "two things are being saved already: try again when one is done",
        );
    }
}

/// Takes how it went.
pub(super) fn saved(app: &mut App, outcome: Result<PathBuf, String>, effects: &mut Vec<Effect>) {
    app.stale = true;
    let done = app.saving_now.take();
    match outcome {
        Ok(path) => {
            if let Some(Save::Set { run, step, .. }) = done
                && let Some((_, run)) = worker_events::run_of(app, run)
            {
                run.saved = Some(step);
                run.unsaved &= run.report.step != step;
            }
            effects.push(Effect::Copy(path.display().to_string()));
            // Over what a failed run has to say, until the next key.
            remark(app, format!("saved {}", path.display()));
            app.saving = Saving::Saved(path);
        }
        Err(reason) => app.saving = Saving::Failed(reason),
    }
    if let Some(next) = app.saving_next.take() {
        // What came out must be seen although the next one takes its place.
        let text = match &app.saving {
            Saving::Saved(path) => format!("saved {}", path.display()),
            Saving::Failed(reason) => format!("not saved: {reason}"),
            Saving::Idle | Saving::Busy(_) => String::new(),
        };
        remark(app, text);
        begin(app, next, effects);
    }
}

fn begin(app: &mut App, save: Save, effects: &mut Vec<Effect>) {
    app.saving = Saving::Busy(words(app, &save));
    effects.push(match &save {
        Save::View(picture, slot) => Effect::SaveView(picture.clone(), *slot),
        Save::Set { slot, .. } => Effect::SaveSet(*slot),
    });
    app.saving_now = Some(save);
}

fn words(app: &App, save: &Save) -> String {
    let name = |slot: usize| app.slots.get(slot).map_or("", |slot| &slot.name);
    match save {
        Save::View(picture, slot) => {
            let step = picture.report.step;
            format!("the view of {} at step {step}", name(*slot))
        }
        Save::Set { slot, step, .. } => format!("the set of {} up to step {step}", name(*slot)),
    }
}
