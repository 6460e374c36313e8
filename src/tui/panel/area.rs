//! The surface area against its target, what is conserved, and the size of the vesicle.

use std::fmt::Write as _;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::Look;
use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::record::Quantity;
use crate::scene::Geometry;
use crate::simulation::{OutlineMeasure, Vesicle};
use crate::tui::layout::{Step, Wish};
use crate::tui::numbers::{brief, significant};
use crate::tui::series::Series;
use crate::tui::theme::{Role, Theme};

/// The rows that the panel needs and can use.
pub fn wish(_: Step) -> Wish {
    Wish { least: 7, full: 8 }
}

/// Draws the panel.
pub fn draw(shown: &Shown<'_>, look: Look, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let title = Line::styled("Area and shape", theme.strong());
    let notes = Line::styled("% since t = 0", theme.muted());
    let area = text::title(buffer, area, theme, look.focused, title, notes);
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let history = &run.history;
    let widths = Widths::of(area.width);
    let curves = shown.curves(look.view.logarithmic);
    let mut row = area;
    row.height = 1;
    let mut next = |area: Rect| {
        let here = row;
        row.y += 1;
        // What there is no row for is not drawn.
        here.intersection(area)
    };

    let surface = Row {
        name: name_of("B"),
        colour: Some(theme.colour(Role::Curve(1))),
        value: Some(report.surface_area),
        start: history.surface_area.at_start(),
        digits: None,
        series: Some(&history.surface_area),
    };
    rows::draw(&surface, widths, &curves, theme, next(area), buffer);
    if let Some(target) = shown.target() {
        let share = Row {
            name: "area/target",
            value: Some(report.surface_area / target),
            digits: Some(4),
            ..Row::default()
        };
        let row = next(area);
        rows::draw(&share, widths, &curves, theme, row, buffer);
        // In the place of a change and a curve.
        let place = Rect {
            width: row.right().saturating_sub(widths.relative(row).x),
            ..widths.relative(row)
        };
        let words = format!("  target {}", brief(target, 4));
        let words = match words.chars().count() <= usize::from(place.width) {
            true => words,
            false => format!("  of {}", brief(target, 4)),
        };
        text::line(buffer, place, 0, Span::styled(words, theme.muted()));
    }
    match &report.vesicles[..] {
        [vesicle] => {
            let outline = vesicle.outline;
            let sizes = [
                ("length", outline.map(|it| it.length), Some(&history.length)),
                ("waist", outline.map(|it| it.waist), Some(&history.waist)),
                ("width", outline.map(|it| it.width), Some(&history.width)),
            ];
            for (name, value, series) in sizes {
                let size = Row {
                    name,
                    value,
                    start: series.and_then(Series::at_start),
                    series,
                    ..Row::default()
                };
                rows::draw(&size, widths, &curves, theme, next(area), buffer);
            }
            let reduced = Row {
                name: reduced_size(shown.scene().geometry),
                value: vesicle.reduced_size(),
                digits: Some(4),
                ..Row::default()
            };
            let row = next(area);
            rows::draw(&reduced, widths, &curves, theme, row, buffer);
            let place = widths.relative(row);
            let words = match vesicle.is_at_wall {
                true => "  at the wall",
                false if vesicle.body.is_some() => "  sphere 1",
                false => "  circle 1",
            };
            let place = Rect {
                width: row.right().saturating_sub(place.x),
                ..place
            };
            text::line(buffer, place, 0, Span::styled(words, theme.muted()));
        }
        several => {
            for line in table(several, shown.scene().geometry, area.width, theme) {
                text::line(buffer, next(area), 0, line);
            }
        }
    }
    let drift = history
        .phase_integral
        .map(|start| report.phase_integral - start);
    let conserved = Row {
        name: "volume change",
        value: drift,
        digits: Some(2),
        series: Some(&history.phase_drift),
        ..Row::default()
    };
    rows::draw(&conserved, widths, &curves, theme, next(area), buffer);
}

/// The name of the quantity of a column.
fn name_of(column: &str) -> &'static str {
    Quantity::of_column(column).map_or("", |quantity| quantity.name)
}

/// What compares the size of a vesicle with its membrane.
fn reduced_size(geometry: Geometry) -> &'static str {
    match geometry {
        Geometry::Planar => "reduced area",
        Geometry::Axisymmetric => "reduced volume",
    }
}

/// Sizes of several vesicles, a column for each, from left to right; how many there are, where there is no room for all.
fn table<'a>(vesicles: &[Vesicle], geometry: Geometry, width: u16, theme: &Theme) -> Vec<Line<'a>> {
    const NAME: usize = 14;
    const COLUMN: usize = 8;
    let room = usize::from(width).saturating_sub(NAME) / COLUMN;
    let seen = &vesicles[..room.min(vesicles.len())];
    let words = match vesicles.len() {
        0 => "no vesicle".to_owned(),
        count => format!("{count} vesicles"),
    };
    let mut numbers = String::new();
    for number in 1..=seen.len() {
        // Writing to a string cannot fail.
        let _ = write!(numbers, "{number:>COLUMN$}");
    }
    let mut lines = vec![Line::from(vec![
        Span::styled(format!(" {words:<0$}", NAME - 1), theme.strong()),
        Span::styled(numbers, theme.muted()),
    ])];
    if seen.is_empty() {
        return lines;
    }
    let size =
        |of: fn(&OutlineMeasure) -> f64| move |vesicle: &Vesicle| vesicle.outline.as_ref().map(of);
    type Of<'f> = &'f dyn Fn(&Vesicle) -> Option<f64>;
    let rows: [(&str, Of<'_>); 4] = [
        ("length", &size(|outline| outline.length)),
        ("waist", &size(|outline| outline.waist)),
        ("width", &size(|outline| outline.width)),
        (reduced_size(geometry), &Vesicle::reduced_size),
    ];
    for (name, of) in rows {
        let mut text = format!(" {name:<0$}", NAME - 1);
        for vesicle in seen {
            let value = of(vesicle);
            let value = value.map_or("-".to_owned(), |value| significant(value, 4));
            let _ = write!(text, "{value:>COLUMN$}");
        }
        lines.push(Line::raw(text));
    }
    lines
}
