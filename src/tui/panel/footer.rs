//! The keys that do something at present, as many as fit.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::text;
use crate::tui::keys;
use crate::tui::state::App;
use crate::tui::theme::{Role, Theme};

/// Draws the footer. The bindings come in the order of their weight: what does not fit is left out,
/// and something lighter that does fit may take its place.
pub fn draw(app: &App, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let mut spans = vec![Span::raw(" ")];
    let mut room = usize::from(area.width).saturating_sub(1);
    for binding in keys::footer(app) {
        let label = theme.word(binding.label, binding.plain_label);
        let words = (binding.brief)(app);
        let width = label.chars().count() + 1 + words.chars().count();
        if width > room {
            continue;
        }
        room = room.saturating_sub(width + 2);
        spans.push(Span::styled(label, theme.style(Role::Accent)));
        spans.push(Span::styled(format!(" {words}  "), theme.muted()));
    }
    text::line(buffer, area, 0, Line::from(spans));
}
