//! The screen, one file a panel: each a pure function of the state. No panel computes physics, takes
//! a lock, reads a clock or touches a file.

mod accuracy;
mod area;
mod banner;
mod chart;
mod cost;
mod dialog;
mod director;
mod energy;
mod external_field;
mod field;
mod footer;
mod gallery;
mod header;
mod help;
mod knobs;
mod measured;
mod plot;
mod rows;
mod shown;
#[cfg(test)]
mod tests;
mod text;
mod theory;

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

use super::canvas::Canvas;
use super::glyphs;
use super::layout::{LEAST, Step, Wish, divide, take_bottom};
use super::state::{App, Overlay, Panel, Screen, View};
use super::theme::{Role, Theme};
use shown::Shown;

pub(super) use dialog::message_overflow;
pub(super) use help::{draw_lines as draw_help, table as help_table};
pub use text::wrap;

#[cfg(test)]
pub(super) use dialog::{kept_words, quit_words};

/// How a panel is to look.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// What the user has chosen to see.
    view: View,
    /// Whether the panel has the focus.
    focused: bool,
    /// How much there is room for.
    step: Step,
}

/// Draws everything. The [`Canvas`] keeps from frame to frame where the samples of a picture lie in
/// their mesh: it belongs to the caller, begins as `Canvas::default()`, and only saves time.
pub fn draw(app: &App, theme: &Theme, canvas: &mut Canvas, frame: &mut Frame<'_>) {
    let screen = frame.area();
    let buffer = frame.buffer_mut();
    if Step::of(screen.width, screen.height) == Step::TooSmall {
        too_small(app, theme, screen, buffer);
    } else {
        match app.screen {
            Screen::Run => one_run(app, theme, canvas, screen, buffer),
            Screen::Gallery => several_runs(app, theme, canvas, screen, buffer),
        }
        overlay(app, theme, screen, buffer);
    }
    if !theme.unicode {
        to_ascii(buffer);
    }
}

/// One run: its field, and its scalars beside it.
fn one_run(app: &App, theme: &Theme, canvas: &mut Canvas, screen: Rect, buffer: &mut Buffer) {
    let shown = Shown::active(app);
    let banner_rows = banner::rows(app, shown.as_ref(), theme, screen.width);
    let step = Step::of(screen.width, screen.height);
    let wishes = wishes(shown.as_ref(), screen);
    let areas = divide(screen, app.focus, banner_rows, wishes);
    if let Some(shown) = &shown {
        header::draw(shown, theme, areas.header, buffer);
        let look = |panel: Panel| Look {
            view: app.view,
            focused: app.focus == panel,
            step,
        };
        let field = look(Panel::Field);
        field::draw(shown, field, theme, canvas, areas.field, buffer);
        energy::draw(shown, look(Panel::Energy), theme, areas.energy, buffer);
        area::draw(shown, look(Panel::Area), theme, areas.area, buffer);
        cost::draw(shown, look(Panel::Cost), theme, areas.cost, buffer);
    }
    banner::draw(app, shown.as_ref(), theme, areas.banner, buffer);
    footer::draw(app, theme, areas.footer, buffer);
}

/// The rows that energy, area and cost need and can use.
fn wishes(shown: Option<&Shown<'_>>, screen: Rect) -> [Wish; 3] {
    let step = Step::of(screen.width, screen.height);
    let nothing = Wish { least: 2, full: 2 };
    let energy = shown.map_or(nothing, |shown| energy::wish(shown, step));
    [energy, area::wish(step), cost::wish(step)]
}

/// The gallery.
fn several_runs(app: &App, theme: &Theme, canvas: &mut Canvas, screen: Rect, buffer: &mut Buffer) {
    let shown = Shown::active(app);
    let mut area = screen;
    let footer = take_bottom(&mut area, 1);
    let rows = banner::rows(app, shown.as_ref(), theme, screen.width);
    let banner = take_bottom(&mut area, rows);
    gallery::draw(app, theme, canvas, area, buffer);
    banner::draw(app, shown.as_ref(), theme, banner, buffer);
    footer::draw(app, theme, footer, buffer);
}

/// What lies over the screen.
fn overlay(app: &App, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    match &app.overlay {
        None => {}
        Some(Overlay::Help { scroll }) => help::draw(*scroll, theme, screen, buffer),
        Some(Overlay::Confirm(question)) => {
            dialog::confirm(app, *question, theme, screen, buffer);
        }
        Some(Overlay::Open {
            text,
            chosen,
            error,
        }) => {
            let typed = (text.as_str(), *chosen, error.as_deref());
            dialog::open(app, typed, theme, screen, buffer);
        }
        Some(Overlay::Knobs(knobs)) => knobs::draw(knobs, theme, screen, buffer),
        Some(Overlay::Prices { text }) => {
            dialog::table("What each effect costs", text, theme, screen, buffer);
        }
        Some(Overlay::Accuracy(list)) => accuracy::draw(list, theme, screen, buffer),
        Some(Overlay::Measured) => {
            let words = measured::words(app);
            dialog::table("Measured error", &words, theme, screen, buffer);
        }
        Some(Overlay::Message {
            title,
            text,
            scroll,
        }) => {
            dialog::message((title, text, *scroll), theme, screen, buffer);
        }
    }
}

/// What is needed, and what is there.
fn too_small(app: &App, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let (columns, rows) = LEAST;
    let cross = theme.word("×", "x");
    // A question takes the keys also where there is no room for its frame.
    let first = match app.overlay {
        Some(Overlay::Confirm(question)) => format!("{}? y/n", question.title()),
        _ => "too small".to_owned(),
    };
    let lines = [
        Line::styled(first, theme.style(Role::Warning)),
        Line::raw(format!("needs {columns}{cross}{rows}")),
        Line::raw(format!("is {}{cross}{}", screen.width, screen.height)),
    ];
    for (row, line) in lines.into_iter().enumerate() {
        text::line(buffer, screen, row as u16, line);
    }
}

/// Where only ASCII may be written nothing else is, wherever it comes from: a scene's name, a path.
fn to_ascii(buffer: &mut Buffer) {
    for cell in &mut buffer.content {
        if !cell.symbol().is_ascii() {
            let substitute = cell.symbol().chars().next().map_or(' ', glyphs::ascii);
            cell.set_char(substitute);
        }
    }
}
