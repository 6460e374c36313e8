//! The external field H: whether it is on and where it points, in the upper side of a picture's frame.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::shown::Shown;
use super::text;
use crate::scene::Timetable;
use crate::tui::numbers::brief;
use crate::tui::theme::{Role, Theme};

/// Draws it, if the scene has such a field.
pub fn draw(shown: &Shown<'_>, frame: Rect, theme: &Theme, buffer: &mut Buffer) {
    let (scene, Some(report)) = (shown.scene(), shown.report) else {
        return;
    };
    if scene.field.is_none() {
        return;
    }
    let Some(field) = Timetable::of(scene).at(report.t).field else {
        return;
    };
    let (words, style) = if field.is_on() {
        let h = field.vector();
        let arrow = theme.glyphs().arrow(h.x, h.y);
        let degree = theme.word("°", " deg");
        let words = format!(" H {arrow} {}{degree} ", brief(field.angle, 4));
        (words, theme.style(Role::Accent))
    } else if report.t < field.from {
        (
            format!(" H off until {} ", brief(field.from, 3)),
            theme.muted(),
        )
    } else {
        (" H off ".to_owned(), theme.muted())
    };
    let line = Line::from(vec![Span::styled(words, style)]);
    let width = line.width() as u16;
    if width + 2 <= frame.width {
        let area = Rect {
            x: frame.right() - 1 - width,
            width,
            height: 1,
            ..frame
        };
        text::line(buffer, area, 0, line);
    }
}
