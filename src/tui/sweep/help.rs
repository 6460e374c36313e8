//! What the map of a sweep shows, and all its keys.

use crate::tui::panel::{draw_help, help_table};
use crate::tui::theme::Theme;
use crossterm::event::KeyCode;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

/// What is on the screen.
const MAP: [(&str, &str); 3] = [
    (
        "vesicle",
        "the last one of the point's run, at the place of its values; where there is none yet, how the point stands",
    ),
    (
        "colour",
        "the column that is named above the map with its least and its greatest value; the values of the point stand \
         beside the map",
    ),
    (
        "panel",
        "where more than two keys vary: the points with the values that are named above the map",
    ),
];

/// The keys, their names in ASCII, and what they do.
const KEYS: [(&str, &str, &str); 9] = [
    ("← → ↑ ↓", "arrows", "another point; also h l k j"),
    (
        "Home End",
        "Home End",
        "the first point of the row, the last one",
    ),
    (
        "Tab Shift-Tab",
        "Tab Shift-Tab",
        "the next panel or the one before; also PgDn PgUp",
    ),
    (
        "space",
        "space",
        "the next page of the point's values, where not all have room",
    ),
    (
        "Enter",
        "Enter",
        "open the point's run, as vesica opens any; leaving it leads back to the map",
    ),
    ("?", "?", "these words; also F1. Esc closes them"),
    ("q Esc", "q Esc", "quit"),
    ("Ctrl-C", "Ctrl-C", "quit, whatever lies over the map"),
    (
        "Ctrl-Z",
        "Ctrl-Z",
        "stop the program; fg in the shell continues it",
    ),
];

/// Lines of a page of the help.
const PAGE: u16 = 10;

/// Lines that are scrolled at most: more than there are on the narrowest screen. The drawing stops at the last.
const MOST: u16 = 60;

/// How far the help is scrolled after a key; `None`: it is closed.
pub(super) fn scrolled(scroll: u16, code: KeyCode) -> Option<u16> {
    let scroll = match code {
        KeyCode::Up | KeyCode::Char('k') => scroll.saturating_sub(1),
        KeyCode::Down | KeyCode::Char('j') => scroll + 1,
        KeyCode::PageUp => scroll.saturating_sub(PAGE),
        KeyCode::PageDown => scroll + PAGE,
        KeyCode::Home => 0,
        KeyCode::End => MOST,
        KeyCode::Esc | KeyCode::Enter | KeyCode::F(1) | KeyCode::Char('?' | 'q') => return None,
        _ => scroll,
    };
    Some(scroll.min(MOST))
}

/// Draws it over the middle of the screen.
pub(super) fn draw(scroll: u16, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    draw_help(scroll, theme, screen, buffer, |width| {
        let heading = |words: &'static str| Line::styled(words, theme.strong());
        let mut lines = vec![heading("The map")];
        help_table(&MAP, width, theme, &mut lines);
        lines.extend([Line::default(), heading("The keys")]);
        let keys = KEYS.map(|(key, plain, words)| (theme.word(key, plain), words));
        help_table(&keys, width, theme, &mut lines);
        lines
    });
}
