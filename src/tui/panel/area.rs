//! The surface area against its target, what is conserved, and the size of the vesicle.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::Look;
use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::simulation::Vesicle;
use crate::tui::layout::{Step, Wish};
use crate::tui::numbers::{percent, significant};
use crate::tui::theme::{Role, Theme};

/// The rows that the panel needs and can use.
pub fn wish(_: Step) -> Wish {
    Wish { least: 7, full: 8 }
}

/// Draws the panel.
pub fn draw(shown: &Shown<'_>, look: Look, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let title = Line::styled("Area and shape", theme.strong());
    let area = text::title(buffer, area, theme, look.focused, title, Line::default());
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let history = &run.history;
    let widths = Widths::of(area.width);
    let marks = shown.marks();
    let curves = shown.curves(&marks, look.view.logarithmic);
    let mut row = area;
    row.height = 1;
    let mut next = |area: Rect| {
        let here = row;
        row.y += 1;
        // What there is no row for is not drawn.
        here.intersection(area)
    };

    let surface = Row {
        name: "B",
        colour: Some(theme.colour(Role::Curve(1))),
        value: Some(report.surface_area),
        start: history.surface_area.first(),
        digits: None,
        series: Some(&history.surface_area),
    };
    rows::draw(&surface, widths, &curves, theme, next(area), buffer);
    if let Some(target) = shown.target() {
        let gap = Row {
            name: theme.word("B-β", "B-target"),
            value: Some(report.surface_area - target),
            digits: Some(4),
            ..Row::default()
        };
        let row = next(area);
        rows::draw(&gap, widths, &curves, theme, row, buffer);
        let relative = percent(report.surface_area - target, target);
        let column = widths.relative(row);
        text::line_right(buffer, column, 0, Span::styled(relative, theme.muted()));
        let name = theme.word("β", "to");
        let beside = widths.beside(row);
        let digits = if beside.width < 8 { 3 } else { 5 };
        let words = format!("{name} {}", significant(target, digits));
        text::line(buffer, beside, 0, Span::styled(words, theme.muted()));
    }
    if let Some(words) = shown.vesicles() {
        let words = Span::styled(format!(" {words}"), theme.muted());
        text::line(buffer, next(area), 0, words);
    }
    if let Some(outline) = report.outline() {
        let sizes = [
            ("length", outline.length, &history.length),
            ("waist", outline.waist, &history.waist),
            ("width", outline.width, &history.width),
        ];
        for (name, value, series) in sizes {
            let size = Row {
                name,
                value: Some(value),
                start: series.first(),
                series: Some(series),
                ..Row::default()
            };
            rows::draw(&size, widths, &curves, theme, next(area), buffer);
        }
    }
    let drift = history
        .phase_integral
        .map(|start| report.phase_integral - start);
    let conserved = Row {
        name: theme.word("∫φ drift", "A drift"),
        value: drift,
        digits: Some(3),
        series: Some(&history.phase_drift),
        ..Row::default()
    };
    rows::draw(&conserved, widths, &curves, theme, next(area), buffer);
    if let Some(quotient) = report.only_vesicle().and_then(Vesicle::reduced_area) {
        let quotient = Row {
            name: theme.word("4πa/l²", "4pi a/l^2"),
            value: Some(quotient),
            digits: Some(4),
            ..Row::default()
        };
        let row = next(area);
        rows::draw(&quotient, widths, &curves, theme, row, buffer);
        let (words, beside) = ("circle: 1", widths.beside(row));
        if usize::from(beside.width) >= words.len() {
            text::line(buffer, beside, 0, Span::styled(words, theme.muted()));
        }
    }
}
