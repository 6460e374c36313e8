//! The keys that do something at present, as many as fit: each whole or not at all.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::text;
use crate::tui::keys::{Binding, Footer};
use crate::tui::state::App;
use crate::tui::theme::{Role, Theme};

/// Between two keys.
const GAP: usize = 2;

/// Draws the footer. What does not fit is left out, and something of less weight that does fit may take its place; the
/// key of the help, which names all, is always there.
pub fn draw(app: &App, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let Footer { first, always } = Footer::of(app);
    let label = |binding: &Binding| theme.word(binding.label, binding.plain_label);
    let width = |binding: &Binding| {
        let words = (binding.brief)(app);
        label(binding).chars().count() + 1 + words.chars().count() + GAP
    };
    // The last gap needs no room.
    let room = (usize::from(area.width) + GAP).saturating_sub(1);
    let mut room = room.saturating_sub(always.iter().map(|it| width(it)).sum());
    let fitting = first.into_iter().filter(|binding| {
        let fits = width(binding) <= room;
        room -= if fits { width(binding) } else { 0 };
        fits
    });
    let mut spans = vec![Span::raw(" ")];
    for binding in fitting.collect::<Vec<_>>().into_iter().chain(always) {
        let words = (binding.brief)(app);
        spans.push(Span::styled(label(binding), theme.style(Role::Accent)));
        spans.push(Span::styled(format!(" {words}  "), theme.muted()));
    }
    text::line(buffer, area, 0, Line::from(spans));
}
