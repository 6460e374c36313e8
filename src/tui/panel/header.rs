//! Scene, anchoring, state and progress: two rows.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::shown::Shown;
use super::text;
use crate::study::PresetFigures;
use crate::tui::keys::{self, Action};
use crate::tui::numbers::{brief, duration, significant};
use crate::tui::theme::{Role, Theme};

/// Draws the header of one run.
pub fn draw(shown: &Shown<'_>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let (word, role) = shown.status();
    let mut state = Vec::new();
    if let Some((index, count)) = shown.back {
        state.push(Span::styled(
            format!(" looking back {} of {count} ", index + 1),
            theme.pill(Role::Warning),
        ));
        state.push(Span::raw(" "));
    }
    state.push(Span::styled(format!(" {word} "), theme.pill(role)));
    let state = Line::from(state);
    let left = Rect {
        width: area.width.saturating_sub(state.width() as u16 + 1),
        ..area
    };
    text::line_right(buffer, area, 0, state);
    text::line(buffer, left, 0, scene(shown, theme, left.width));
    progress(shown, theme, area, buffer);
}

/// Which scene it is, and where it is a case in one of its forms, how accurate that is, and the other one. Words and
/// parts that there is no room for are left out.
fn scene<'a>(shown: &'a Shown<'_>, theme: &Theme, room: u16) -> Line<'a> {
    let whole = scene_parts(shown, theme, true);
    match whole.width() <= usize::from(room) {
        true => whole,
        false => scene_parts(shown, theme, false),
    }
}

fn scene_parts<'a>(shown: &'a Shown<'_>, theme: &Theme, with_all_words: bool) -> Line<'a> {
    let dot = || Span::styled(format!(" {} ", theme.glyphs().dot), theme.muted());
    let muted = |words: &'static str| Span::styled(words, theme.muted());
    let error_of = theme.word(" error of φ ", " error of phi ");
    let mut spans = vec![
        Span::styled(" vesica ", theme.style(Role::Accent)),
        Span::styled(shown.slot.name.as_str(), theme.strong()),
    ];
    let figures = shown.slot.figures();
    let title = shown.scene().name.trim();
    if let Some(figures) = figures {
        spans.push(Span::styled(
            if with_all_words { error_of } else { " error " },
            theme.muted(),
        ));
        spans.push(Span::raw(match with_all_words {
            true => accuracy(figures),
            false => error(figures),
        }));
    } else if !title.is_empty() && title != shown.slot.name {
        spans.push(dot());
        spans.push(Span::raw(title));
    }
    if shown.scene().nematic.is_some() {
        spans.push(dot());
        let anchoring = shown.anchoring.map_or("none", |kind| kind.name());
        if with_all_words {
            spans.push(muted("anchoring "));
        }
        spans.push(Span::raw(anchoring));
    }
    if let Some((other, word)) = shown.other_form {
        spans.push(dot());
        let key = keys::label(Action::OtherForm);
        spans.push(Span::styled(key, theme.style(Role::Accent)));
        spans.push(Span::styled(format!(" {word}"), theme.muted()));
        if let Some(figures) = other.figures().filter(|_| with_all_words) {
            spans.push(muted(": error "));
            spans.push(Span::raw(accuracy(figures)));
        }
    }
    Line::from(spans)
}

/// An error of φ and a time.
fn accuracy(figures: PresetFigures) -> String {
    format!("{} in {} s", error(figures), brief(figures.seconds, 2))
}

fn error(figures: PresetFigures) -> String {
    format!("{:.1e}", figures.error)
}

/// How far it is: parts that there is no room for are left out, the least important first.
fn progress(shown: &Shown<'_>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let steps = shown.setting.and_then(|setting| setting.steps);
    let digits = steps.unwrap_or(0).max(report.step).max(1).ilog10() as usize + 1;
    let muted = |words: &str| Span::styled(words.to_owned(), theme.muted());
    // Within a step that takes long its own figures say more than those of the last one.
    let underway = run.underway.filter(|_| shown.back.is_none());
    let (t, dt) = underway.map_or((report.t, report.dt), |underway| (underway.t, underway.dt));
    let mut parts = vec![Line::from(vec![
        muted(" step "),
        Span::raw(format!("{:>digits$}", report.step)),
        muted(&steps.map_or(String::new(), |steps| format!("/{steps}"))),
    ])];
    parts.push(Line::from(vec![muted("t "), Span::raw(format!("{t:.3e}"))]));
    if let Some(underway) = underway {
        parts.push(Line::from(vec![
            muted("within step "),
            Span::raw(underway.step.to_string()),
        ]));
    }
    // Rates are those of the present, whatever is shown.
    let pace = &run.pace;
    // The brake may take longer than computing.
    let left = pace
        .left
        .map(|left| left.max(shown.braked.unwrap_or_default()));
    if let Some(left) = left.filter(|_| shown.back.is_none() && !run.is_done()) {
        parts.push(Line::from(vec![Span::raw(duration(left)), muted(" left")]));
    }
    if pace.steps_per_second > 0.0 {
        let rate = significant(pace.steps_per_second, 3);
        parts.push(Line::from(vec![Span::raw(rate), muted(" steps/s")]));
    }
    parts.push(Line::from(vec![
        muted(theme.word("Δt ", "dt ")),
        Span::raw(brief(dt, 3)),
    ]));
    const GAP: &str = "   ";
    const BAR: usize = 12;
    let width =
        |parts: &[Line<'_>]| -> usize { parts.iter().map(|part| part.width() + GAP.len()).sum() };
    while parts.len() > 1 && width(&parts) > usize::from(area.width) {
        parts.pop();
    }
    let room = usize::from(area.width).saturating_sub(width(&parts) + 6);
    let mut spans = Vec::new();
    for (index, part) in parts.into_iter().enumerate() {
        spans.extend(part.spans);
        spans.push(Span::raw(GAP));
        if index == 0 && room >= BAR && shown.setting.is_some() {
            let share = shown.share();
            let wide = room.min(40) as u16;
            let bar = text::bar(share, wide, theme);
            let rest = usize::from(wide) - bar.chars().count();
            spans.push(Span::styled(bar, theme.style(Role::Accent)));
            spans.push(muted(&theme.glyphs().rest.repeat(rest)));
            spans.push(Span::raw(format!(
                " {:>3.0}%{GAP}",
                (100.0 * share).floor()
            )));
        }
    }
    text::line(buffer, area, 1, Line::from(spans));
}
