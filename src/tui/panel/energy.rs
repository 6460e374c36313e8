//! The energies: E_tot and the part of each effect that the scene has.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

use super::Look;
use super::chart;
use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::tui::layout::{Step, Wish, take_bottom, take_top};
use crate::tui::theme::{Role, Theme};

/// Columns of the title and of what stands around the notes.
const TITLE: u16 = 14;

/// The rows that the panel needs and can use.
pub fn wish(shown: &Shown<'_>, step: Step) -> Wish {
    let parts = shown.run.map_or(0, |run| run.history.energies.len()) as u16;
    let least = 2 + parts;
    let curve = match step {
        Step::TooSmall | Step::Narrow => 0,
        Step::Normal => 6,
        Step::Wide => 10,
    };
    Wish {
        least,
        full: least + curve,
    }
}

/// Draws the panel: the total with its curve as high as there is room for, then a row an effect.
pub fn draw(shown: &Shown<'_>, look: Look, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let title = Line::styled("Energy", theme.strong());
    let room = area.width.saturating_sub(TITLE);
    let notes = shown.notes(look.view.logarithmic, room);
    let notes = Line::styled(notes, theme.muted());
    let mut area = text::title(buffer, area, theme, look.focused, title, notes);
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let widths = Widths::of(area.width);
    let curves = shown.curves(look.view.logarithmic);
    let history = &run.history;

    let total = take_top(&mut area, 1);
    let parts = take_bottom(&mut area, history.energies.len() as u16);
    let row = Row {
        name: "total",
        colour: Some(theme.colour(Role::Total)),
        value: Some(report.total_energy),
        start: shown.energy_at_start(),
        digits: None,
        // What has a curve of its own below needs none in its row.
        series: (area.height < 2).then_some(&history.total_energy),
    };
    rows::draw(&row, widths, &curves, theme, total, buffer);
    if area.height >= 2 {
        let colour = theme.colour(Role::Total);
        chart::draw(&history.total_energy, &curves, colour, theme, area, buffer);
    }
    for (index, (name, series)) in history.energies.iter().enumerate() {
        let value = report.energies.iter().find(|energy| energy.name == *name);
        let row = Row {
            name,
            colour: Some(theme.colour(Role::Curve(index))),
            value: value.map(|energy| energy.value),
            start: series.at_start(),
            digits: None,
            series: Some(series),
        };
        let area = Rect {
            y: parts.y + index as u16,
            height: u16::from((index as u16) < parts.height),
            ..parts
        };
        rows::draw(&row, widths, &curves, theme, area, buffer);
    }
}
