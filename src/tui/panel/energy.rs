//! The energies: E_tot and the part of each effect that the scene has.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::Look;
use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::tui::curve;
use crate::tui::layout::{Step, Wish, take_bottom, take_top};
use crate::tui::numbers::significant;
use crate::tui::theme::{Role, Theme};

/// The rows that the panel needs and can use.
pub fn wish(shown: &Shown<'_>, step: Step) -> Wish {
    let parts = shown.run.map_or(0, |run| run.history.energies.len()) as u16;
    let least = 2 + parts;
    let curve = match step {
        Step::TooSmall | Step::Narrow => 0,
        Step::Normal => 5,
        Step::Wide => 9,
    };
    Wish {
        least,
        full: least + curve,
    }
}

/// Draws the panel: the total with its curve as high as there is room for, then a row an effect.
pub fn draw(shown: &Shown<'_>, look: Look, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let scale = if look.view.logarithmic { "log" } else { "" };
    let title = Line::styled("Energy", theme.strong());
    let notes = Line::styled(scale, theme.muted());
    let mut area = text::title(buffer, area, theme, look.focused, title, notes);
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let widths = Widths::of(area.width);
    let marks = shown.marks();
    let curves = shown.curves(&marks, look.view.logarithmic);
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
        tall_curve(shown, &curves, theme, area, buffer);
    }
    for (index, (name, series)) in history.energies.iter().enumerate() {
        let value = report.energies.iter().find(|energy| energy.name == *name);
        let row = Row {
            name,
            colour: Some(theme.colour(Role::Curve(index))),
            value: value.map(|energy| energy.value),
            start: series.first(),
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

/// The curve of the total over several rows, with the values of its ends and the names of what was
/// switched to.
fn tall_curve(
    shown: &Shown<'_>,
    curves: &curve::Frame<'_>,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    const LABELS: u16 = 10;
    let Some(run) = shown.run else {
        return;
    };
    let plot = Rect {
        x: area.x + LABELS.min(area.width),
        width: area.width.saturating_sub(LABELS),
        ..area
    };
    let labels = Rect {
        width: area.width.min(LABELS - 1),
        ..area
    };
    let colour = theme.colour(Role::Total);
    let series = &run.history.total_energy;
    let ends = curve::draw(series, curves, colour, theme, plot, buffer);
    if let Some([least, greatest]) = ends {
        let label = |value| Span::styled(significant(value, 4), theme.muted());
        text::line_right(buffer, labels, 0, label(greatest));
        text::line_right(buffer, labels, area.height - 1, label(least));
    }
    // From the last one back: the name of a switch ends before the line of the next, or is left out.
    let mut end = plot.width;
    for (step, name) in run.history.changes().rev() {
        let share = step as f64 / (curves.horizon as f64 + 1.0);
        let line = (share * f64::from(plot.width)) as u16;
        let offset = line + 1;
        let room = end.saturating_sub(offset);
        end = line;
        if name.chars().count() as u16 <= room {
            let area = Rect {
                x: plot.x + offset,
                width: room,
                ..plot
            };
            text::line(
                buffer,
                area,
                0,
                Span::styled(name, theme.style(Role::Warning)),
            );
        }
    }
}
