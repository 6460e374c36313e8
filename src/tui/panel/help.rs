//! All keys, and what the screen means.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::text;
use crate::tui::keys;
use crate::tui::layout::centred;
use crate::tui::theme::{Role, Theme};

/// Draws the list, scrolled by `scroll` lines, over the middle of the screen.
pub fn draw(scroll: u16, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let width = screen.width.saturating_sub(4).min(88);
    let lines = lines(theme, usize::from(width).saturating_sub(4));
    let height = (lines.len() as u16 + 2).min(screen.height.saturating_sub(2));
    let area = centred(screen, width, height);
    let inside = text::frame(buffer, area, theme, "Keys", theme.style(Role::Accent));
    // The last line is never scrolled further up than to the end of the frame.
    let last = lines.len().saturating_sub(usize::from(inside.height));
    let first = usize::from(scroll).min(last);
    let count = lines.len();
    for (row, line) in lines.into_iter().skip(first).enumerate() {
        if row >= usize::from(inside.height) {
            break;
        }
        text::line(buffer, inside, row as u16, line);
    }
    if last > 0 {
        let shown = (first + usize::from(inside.height)).min(count);
        let words = format!(" {}-{shown} of {count} ", first + 1);
        let below = Rect {
            y: area.bottom().saturating_sub(1),
            height: 1,
            width: area.width.saturating_sub(2),
            ..area
        };
        text::line_right(buffer, below, 0, Span::styled(words, theme.muted()));
    }
}

fn lines<'a>(theme: &Theme, width: usize) -> Vec<Line<'a>> {
    let label = |binding: &keys::Binding| theme.word(binding.label, binding.plain_label);
    let labels = keys::help().map(|binding| label(binding).chars().count());
    let keys = labels.max().unwrap_or(0) + 2;
    let mut lines = Vec::new();
    for binding in keys::help() {
        let label = label(binding);
        let words = text::wrap(binding.words, width.saturating_sub(keys));
        for (row, words) in words.into_iter().enumerate() {
            let label = if row == 0 { label } else { "" };
            lines.push(Line::from(vec![
                Span::styled(format!("{label:<keys$}"), theme.style(Role::Accent)),
                Span::raw(words),
            ]));
        }
    }
    lines
}
