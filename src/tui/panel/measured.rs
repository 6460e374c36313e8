//! The measured error of a run, in words.

use ratatui::text::{Line, Span};

use super::shown::Shown;
use crate::record::ShortNumber;
use crate::study::{FinerRuns, error_words, quantity_words};
use crate::tui::keys::{self, Action};
use crate::tui::state::{App, Measurement, Run};
use crate::tui::theme::{Role, Theme};

/// The measured errors of the run that is shown: all of the time that is shown, then the most important ones of all times.
pub fn words(app: &App) -> String {
    let measured = app.active_run().and_then(|run| run.measurement.as_ref());
    let Some(measured) = measured else {
        return "nothing is measured".to_owned();
    };
    let row = app.report().and_then(|report| measured.at(report.t));
    let Some(row) = row.or(measured.rows.first()) else {
        return progress(measured);
    };
    let factor = FinerRuns::FACTOR;
    let mut text = format!(
        "against the same scene {factor} times finer in mesh and steps, at t = {}\n\n{}\n{}",
        ShortNumber(row.t),
        quantity_words(row),
        error_words(&measured.rows, &["waist"]),
    );
    if measured.rows.iter().any(|row| !row.has_sane_order()) {
        text.push_str("off: the observed order is not near 2; a larger safety factor\n");
    }
    if measured.is_going {
        text.push_str(&progress(measured));
    }
    text
}

fn progress(measured: &Measurement) -> String {
    let percent = (100.0 * measured.share).floor();
    match percent < 100.0 {
        true => format!("finer runs: {percent} %"),
        false => "the finer runs are done; the run goes on".to_owned(),
    }
}

/// The measured error of φ at what is shown; `None`: it is not measured.
pub fn phase_line<'a>(shown: &Shown<'_>, theme: &Theme) -> Option<Line<'a>> {
    let (run, report) = shown.run.zip(shown.report)?;
    let row = run.measurement.as_ref()?.at(report.t)?;
    Some(Line::from(vec![
        Span::styled(" measured ", theme.muted()),
        Span::raw(row.phase.to_string()),
        Span::styled(format!(" at t {}", ShortNumber(row.t)), theme.muted()),
    ]))
}

/// What the key does, or how far a measurement is.
pub fn key_line<'a>(run: &Run, theme: &Theme) -> Line<'a> {
    let key = Span::styled(
        format!(" {} ", keys::label(Action::Measure)),
        theme.style(Role::Accent),
    );
    let words = match &run.measurement {
        None => "measures the error".to_owned(),
        Some(it) if it.is_going => progress(it),
        Some(it) if it.is_of(run) && !it.rows.is_empty() => "all measured errors".to_owned(),
        Some(_) => "measures the error again".to_owned(),
    };
    Line::from(vec![key, Span::styled(words, theme.muted())])
}
