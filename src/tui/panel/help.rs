//! What the numbers on the screen are, and all keys.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::text;
use crate::record::QUANTITIES;
use crate::tui::keys;
use crate::tui::layout::centred;
use crate::tui::theme::{Role, Theme};

/// Draws the list, scrolled by `scroll` lines, over the middle of the screen.
pub fn draw(scroll: u16, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    draw_lines(scroll, theme, screen, buffer, |width| lines(theme, width));
}

/// Draws other lines in the same way, which are made for a width.
pub fn draw_lines<'a>(
    scroll: u16,
    theme: &Theme,
    screen: Rect,
    buffer: &mut Buffer,
    lines: impl FnOnce(usize) -> Vec<Line<'a>>,
) {
    let width = screen.width.saturating_sub(4).min(88);
    let lines = lines(usize::from(width).saturating_sub(4));
    let height = (lines.len() as u16 + 2).min(screen.height.saturating_sub(2));
    let area = centred(screen, width, height);
    let inside = text::frame(buffer, area, theme, "Help", theme.style(Role::Accent));
    let count = lines.len();
    text::scrolled(buffer, (area, inside), theme, count, scroll, |first| {
        lines.into_iter().skip(first).collect()
    });
}

fn lines<'a>(theme: &Theme, width: usize) -> Vec<Line<'a>> {
    let label = |binding: &keys::Binding| theme.word(binding.label, binding.plain_label);
    let heading = |words: &'static str| Line::styled(words, theme.strong());
    let mut lines = vec![heading("The numbers (the keys follow)")];
    let numbers = QUANTITIES.iter().filter(|it| !UNSEEN.contains(&it.column));
    let numbers: Vec<(&str, &str)> = numbers.map(|it| (it.name, it.words)).collect();
    table(&numbers, width, theme, &mut lines);
    lines.extend([Line::default(), heading("The picture")]);
    table(&PICTURE, width, theme, &mut lines);
    lines.extend([Line::default(), heading("The keys")]);
    let keys: Vec<(&str, &str)> = keys::help().map(|it| (label(it), it.words)).collect();
    table(&keys, width, theme, &mut lines);
    lines
}

/// Columns of quantities that need no explanation, or are not on the screen.
const UNSEEN: [&str; 4] = ["step", "t", "dt", "wall"];

/// What the picture shows.
const PICTURE: [(&str, &str); 3] = [
    (
        "φ",
        "the phase: 1 inside the vesicle, -1 outside, 0 on its membrane",
    ),
    (
        "d",
        "the director, inside the vesicle: where the molecules point",
    ),
    (
        "|d|",
        "its length: a line along d is whole where |d| is 0.6 or more; where it is less, dashes cover the share |d|",
    ),
];

/// Names and what they are, the latter wrapped.
pub fn table(
    entries: &[(&'static str, &'static str)],
    width: usize,
    theme: &Theme,
    lines: &mut Vec<Line<'_>>,
) {
    let names = entries.iter().map(|(name, _)| theme.spelt(name));
    let names = names.map(|name| name.chars().count());
    let column = names.max().unwrap_or(0) + 2;
    for (name, words) in entries {
        let name = theme.spelt(name);
        let words = text::wrap(&theme.spelt(words), width.saturating_sub(column));
        for (row, words) in words.into_iter().enumerate() {
            let name = if row == 0 { &name } else { "" };
            lines.push(Line::from(vec![
                Span::styled(format!("{name:<column$}"), theme.style(Role::Accent)),
                Span::raw(words),
            ]));
        }
    }
}
