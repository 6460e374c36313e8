//! The surface area against its target, what is conserved, and the size of the vesicle.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::tui::layout::{Step, Wish};
use crate::tui::numbers::{percent, signed, significant};
use crate::tui::state::View;
use crate::tui::theme::{Role, Theme};

/// The rows that the panel needs and can use.
pub fn wish(_: Step) -> Wish {
    Wish { least: 7, full: 9 }
}

/// Draws the panel.
pub fn draw(
    shown: &Shown<'_>,
    view: View,
    focused: bool,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let title = Line::styled("Area and shape", theme.strong());
    let area = text::title(buffer, area, theme, focused, title, Line::default());
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let history = &run.history;
    let widths = Widths::of(area.width);
    let marks = shown.marks();
    let curves = shown.curves(&marks, view.logarithmic);
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
        series: Some(&history.surface_area),
    };
    rows::draw(&surface, widths, &curves, theme, next(area), buffer);
    if let Some(target) = shown.target() {
        text::line(
            buffer,
            next(area),
            0,
            target_line(report.surface_area, target, theme),
        );
    }
    if let Some(outline) = report.outline {
        let sizes = [
            ("length", outline.length, &history.length),
            ("waist", outline.waist, &history.waist),
            ("width", outline.width, &history.width),
        ];
        for (name, value, series) in sizes {
            let size = Row {
                name,
                colour: None,
                value: Some(value),
                start: series.first(),
                series: Some(series),
            };
            rows::draw(&size, widths, &curves, theme, next(area), buffer);
        }
    }
    let drift = history
        .phase_integral
        .map(|start| report.phase_integral - start);
    let conserved = Row {
        name: theme.word("∫φ drift", "phi drift"),
        colour: None,
        value: drift,
        start: None,
        series: Some(&history.phase_drift),
    };
    rows::draw(&conserved, widths, &curves, theme, next(area), buffer);
    if let Some(quotient) = report.isoperimetric_quotient {
        let name = theme.word(" 4π area/length²   ", " 4 pi area/length^2   ");
        let spans = vec![
            Span::raw(name),
            Span::raw(significant(quotient, 4)),
            Span::styled("   circle: 1", theme.muted()),
        ];
        text::line(buffer, next(area), 0, spans);
    }
}

/// β, and how far B is from it.
fn target_line<'a>(surface_area: f64, target: f64, theme: &Theme) -> Line<'a> {
    let gap = surface_area - target;
    Line::from(vec![
        Span::raw(format!(" {:<2}", theme.word("β", "beta"))),
        Span::raw(format!(" {}", significant(target, 5))),
        Span::styled(theme.word("   B-β ", "   gap "), theme.muted()),
        Span::raw(signed(gap, 3)),
        Span::styled(format!("  {}", percent(gap, target)), theme.muted()),
    ])
}
