//! The line that the app leaves in the scrollback.

use std::fmt::Write;
use std::path::PathBuf;

use super::state::{App, Run};
use crate::record::Brief;

/// More folders than this are counted, not named.
const NAMED: usize = 3;

/// The scene that was shown last, how far it came, and where things were saved.
pub(super) fn line(app: &App, saved: &[PathBuf]) -> String {
    let mut line = match app.slots.get(app.active) {
        Some(slot) => match &slot.run {
            Some(run) => format!("{}: {}", slot.name, progress(run)),
            None => format!("{}: not run", slot.name),
        },
        None => "nothing was run".to_owned(),
    };
    let others = app
        .slots
        .iter()
        .enumerate()
        .filter(|(index, slot)| *index != app.active && slot.run.is_some())
        .count();
    // Writing to a String cannot fail.
    let _ = match others {
        0 => Ok(()),
        1 => write!(line, " (and 1 other run)"),
        _ => write!(line, " (and {others} other runs)"),
    };
    match saved {
        [] => line.push_str("; nothing was saved"),
        _ => {
            let named: Vec<String> = saved
                .iter()
                .rev()
                .take(NAMED)
                .map(|path| path.display().to_string())
                .collect();
            let _ = write!(line, "; saved in {}", named.join(", "));
            if saved.len() > NAMED {
                let _ = write!(line, " and {} more", saved.len() - NAMED);
            }
        }
    }
    line
}

fn progress(run: &Run) -> String {
    let Some(setting) = &run.setting else {
        return "not yet at its first state".to_owned();
    };
    let report = &run.report;
    let of = match setting.steps {
        Some(steps) => format!(" of {steps}"),
        None => String::new(),
    };
    format!(
        "step {}{of}, t = {}, E_total = {}",
        report.step,
        Brief(report.t),
        Brief(report.total_energy),
    )
}
