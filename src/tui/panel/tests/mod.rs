//! The whole screen and its panels: snapshots, sizes, characters, bytes.

mod bytes;
mod footer;
mod made_up;
mod screens;
mod theory;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier};

use super::super::canvas::Canvas;
use super::super::state::App;
use super::super::theme::{ColorTier, Theme};
use super::draw;

/// All themes with their names.
const THEMES: [(&str, ColorTier, bool); 5] = [
    ("true", ColorTier::True, true),
    ("256", ColorTier::Palette, true),
    ("16", ColorTier::Basic, true),
    ("none", ColorTier::None, true),
    ("ascii", ColorTier::None, false),
];

/// What the app looks like.
fn drawn(app: &App, theme: &Theme, columns: u16, rows: u16) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).expect("it cannot fail");
    let mut canvas = Canvas::default();
    terminal
        .draw(|frame| draw(app, theme, &mut canvas, frame))
        .expect("it cannot fail");
    terminal.backend().buffer().clone()
}

/// The characters of a part of a buffer.
fn characters(buffer: &Buffer, area: Rect) -> String {
    let row = |y| {
        let cells = (area.left()..area.right()).map(|x| buffer[(x, y)].symbol());
        cells.collect::<String>().trim_end().to_owned()
    };
    let rows: Vec<String> = (area.top()..area.bottom()).map(row).collect();
    rows.join("\n")
}

/// The characters of a part of a buffer and, below, the styles of each row as runs of cells.
fn with_styles(buffer: &Buffer, area: Rect) -> String {
    let mut text = characters(buffer, area);
    text.push_str("\n\nstyles: cells, foreground on background, modifiers\n");
    for y in area.top()..area.bottom() {
        let mut runs: Vec<(usize, String)> = Vec::new();
        for x in area.left()..area.right() {
            let cell = &buffer[(x, y)];
            let style = name(cell.fg, cell.bg, cell.modifier);
            match runs.last_mut() {
                Some((count, last)) if *last == style => *count += 1,
                _ => runs.push((1, style)),
            }
        }
        let runs = runs.iter().map(|(count, style)| format!("{count}:{style}"));
        text.push_str(&runs.collect::<Vec<_>>().join(" "));
        text.push('\n');
    }
    text
}

fn name(foreground: Color, background: Color, modifier: Modifier) -> String {
    let colour = |colour| match colour {
        Color::Reset => "-".to_owned(),
        other => other.to_string(),
    };
    let mut name = colour(foreground);
    if background != Color::Reset {
        name = format!("{name}/{}", colour(background));
    }
    if !modifier.is_empty() {
        name = format!("{name}+{modifier:?}");
    }
    name
}
