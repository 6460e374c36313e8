//! The dialog in which parameters are changed.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;
use ratatui::text::{Line, Span};

use super::text;
use crate::record::ShortNumber;
use crate::tui::knobs::{Knob, Knobs};
use crate::tui::layout::centred;
use crate::tui::theme::{Role, Theme};

/// Columns of the names and of the values.
const NAME: usize = 32;
const VALUE: usize = 18;

/// Draws the parameters, a line each, and what is known of the chosen one.
pub fn draw(knobs: &Knobs, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let width = 76.min(screen.width.saturating_sub(4));
    let inner = usize::from(width).saturating_sub(4);
    let chosen = knobs.lines.get(knobs.chosen);
    let about = chosen.map_or_else(Vec::new, |knob| {
        let words = format!("{} Allowed: {}.", knob.words, knob.allowed);
        text::wrap(&theme.spelt(&words), inner)
    });
    let errors = knobs
        .error
        .as_deref()
        .map_or_else(Vec::new, |error| text::wrap(&theme.spelt(error), inner));
    let height = knobs.lines.len() + about.len() + errors.len() + 6;
    let area = centred(screen, width, height.min(usize::from(u16::MAX)) as u16);
    let title = "Change parameters from the next step on";
    let inside = text::frame(buffer, area, theme, title, theme.style(Role::Accent));
    // Of a long list the part about the chosen line.
    let room = usize::from(inside.height).saturating_sub(about.len() + errors.len() + 3);
    let first = knobs.chosen.saturating_sub(room.saturating_sub(1));
    let mut row = 0;
    for (index, knob) in knobs.lines.iter().enumerate().skip(first).take(room) {
        let is_chosen = index == knobs.chosen;
        let typed = knobs
            .typed
            .as_deref()
            .filter(|_| is_chosen && !knobs.types_duration);
        text::line(buffer, inside, row, line(knob, is_chosen, typed, theme));
        row += 1;
    }
    row += 1;
    let duration = match (&knobs.typed, knobs.types_duration, knobs.over) {
        (typed, true, _) => {
            let typed = typed.as_deref().unwrap_or_default();
            Line::from(vec![
                Span::raw("over a time of "),
                Span::styled(format!("{typed} "), cursor(theme)),
            ])
        }
        (_, false, over) if over > 0.0 => Line::raw(format!(
            "over a time of {}, on a straight line",
            ShortNumber(over)
        )),
        _ => Line::styled("at once; r gives it a time", theme.muted()),
    };
    text::line(buffer, inside, row, duration);
    row += 2;
    for words in about {
        text::line(buffer, inside, row, Span::styled(words, theme.muted()));
        row += 1;
    }
    for words in errors {
        text::line(
            buffer,
            inside,
            row,
            Span::styled(words, theme.style(Role::Bad)),
        );
        row += 1;
    }
}

/// The style of what is typed.
fn cursor(theme: &Theme) -> ratatui::style::Style {
    theme.strong().add_modifier(Modifier::REVERSED)
}

fn line(knob: &Knob, is_chosen: bool, typed: Option<&str>, theme: &Theme) -> Line<'static> {
    let name = format!(" {:<NAME$}", knob.key);
    let name = match is_chosen {
        true => Span::styled(name, theme.pill(Role::Accent)),
        false => Span::raw(name),
    };
    let value = match typed {
        Some(typed) => Span::styled(format!(" {typed} "), cursor(theme)),
        None => {
            let style = if knob.is_turned() {
                theme.style(Role::Warning)
            } else {
                theme.strong()
            };
            Span::styled(format!(" {:<VALUE$}", knob.value.to_string()), style)
        }
    };
    let mut spans = vec![name, value];
    if knob.is_turned() {
        spans.push(Span::styled(format!(" now {}", knob.before), theme.muted()));
    }
    Line::from(spans)
}
