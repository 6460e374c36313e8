//! What a step costs, how hard it was to solve, and how well it was solved.
//!
//! Below, where there is room: the measured error, or as long as there is none the estimates that can be trusted.

use std::time::Duration;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::Look;
use super::measured;
use super::rows::{self, Row, Widths};
use super::shown::Shown;
use super::text;
use crate::simulation::{Costs, ErrorPart, Phase, Report};
use crate::tui::curve;
use crate::tui::keys::{self, Action};
use crate::tui::layout::{Step, Wish};
use crate::tui::numbers::{brief, milliseconds, significant};
use crate::tui::theme::{Role, Theme};

/// The rows that the panel needs and can use.
pub fn wish(_: Step) -> Wish {
    Wish {
        least: 4,
        full: 7 + Phase::ALL.len() as u16,
    }
}

/// The part of a step in a word.
fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Director => "director",
        Phase::Residual => "residual",
        Phase::Linearisation => "Jacobian",
        Phase::Krylov => "linear solver",
        Phase::Ledger => "energy law",
    }
}

/// Draws the panel: the cost with its curve, the parts of it while there is room, the iterations, and
/// the energy law.
pub fn draw(shown: &Shown<'_>, look: Look, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let title = Line::styled("Cost of a step", theme.strong());
    let notes = Line::styled("ms and % of a step", theme.muted());
    let area = text::title(buffer, area, theme, look.focused, title, notes);
    let Some((run, report)) = shown.run.zip(shown.report) else {
        return;
    };
    let widths = Widths::of(area.width);
    let curves = shown.curves(look.view.logarithmic);
    // Of an older picture, what that step took; now, what steps take.
    let costs = match shown.back {
        None => run.pace.cost(),
        Some(_) => report.costs,
    };
    let total = costs.total();
    let at = |row: u16| {
        let row = Rect {
            y: area.y + row,
            height: 1,
            ..area
        };
        row.intersection(area)
    };
    let cost = Row {
        name: "total",
        colour: Some(theme.colour(Role::Accent)),
        value: (!total.is_zero()).then_some(1e3 * total.as_secs_f64()),
        start: None,
        digits: Some(3),
        series: Some(&run.history.cost),
    };
    rows::draw(&cost, widths, &curves, theme, at(0), buffer);
    // All parts or none: some of them would say nothing of the rest.
    let all = Phase::ALL.len() as u16;
    let parts = if area.height >= all + 3 { all } else { 0 };
    for (index, phase) in Phase::ALL.into_iter().enumerate().take(usize::from(parts)) {
        let area = at(1 + index as u16);
        phase_row(phase, index, costs.of(phase), total, theme, area, buffer);
    }
    text::line(
        buffer,
        area,
        1 + parts,
        iterations(report, area.width, theme),
    );
    let law = law_line(shown, report, area.width, theme);
    let used = law.width() as u16;
    // A measured error is worth more than any estimate.
    let errors = measured::phase_line(shown, theme)
        .or_else(|| budget(shown, report, &costs, area.width, theme));
    let key = Some(measured::key_line(run, theme));
    let prices = Line::from(vec![
        Span::styled(
            format!(" {} ", keys::label(Action::Accuracy)),
            theme.style(Role::Accent),
        ),
        Span::styled("what other accuracies cost", theme.muted()),
    ]);
    let further = [errors, key, Some(prices)].into_iter().flatten();
    for (row, line) in (3 + parts..area.height).zip(further) {
        text::line(buffer, area, row, line);
    }
    text::line(buffer, area, 2 + parts, law);
    let beside = widths.beside(at(2 + parts));
    if beside.x > area.x + used {
        let series = &run.history.law_residual;
        curve::draw(series, &curves, theme.curve(), theme, beside, buffer);
    }
}

/// The estimated errors of φ, as far as they can be trusted, the largest in colour, with what is spent on them where there
/// is room.
fn budget<'a>(
    shown: &Shown<'_>,
    report: &Report,
    costs: &Costs,
    width: u16,
    theme: &Theme,
) -> Option<Line<'a>> {
    // Nothing is known of it yet.
    report.budget.largest()?;
    let budget = report.budget.trusted(shown.scene());
    let Some((largest, _)) = budget.largest() else {
        return Some(Line::styled(" no estimate of the error", theme.muted()));
    };
    let mut parts = [
        (ErrorPart::Time, "time", budget.time),
        (ErrorPart::Space, "mesh", budget.space),
    ];
    // What is known first: a narrow panel cuts the other.
    parts.sort_by_key(|(_, _, error)| error.is_none());
    let mut spans = vec![Span::styled(" estimated error:", theme.muted())];
    for (part, name, error) in parts {
        spans.push(Span::styled(format!(" {name} "), theme.muted()));
        let value = error.map_or("not known".to_owned(), |error| brief(error, 2));
        spans.push(match largest == part {
            true => Span::styled(value, theme.style(Role::Warning)),
            false => Span::raw(value),
        });
        if width >= 74 && !costs.total().is_zero() {
            let spent: Duration = part.phases().iter().map(|phase| costs.of(*phase)).sum();
            let words = format!(" ({} ms)", milliseconds(spent));
            spans.push(Span::styled(words, theme.muted()));
        }
    }
    Some(Line::from(spans))
}

/// A part of a step: its milliseconds, its share, and a bar.
fn phase_row(
    phase: Phase,
    index: usize,
    cost: Duration,
    total: Duration,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    if total.is_zero() {
        return;
    }
    let share = cost.as_secs_f64() / total.as_secs_f64();
    let colour = theme.style(Role::Curve(index));
    let spans = vec![
        Span::styled(format!(" {:<13}", name(phase)), colour),
        Span::raw(format!("{:>7}", milliseconds(cost))),
        Span::styled(format!("{:>5.0}% ", 100.0 * share), theme.muted()),
    ];
    let spans = Line::from(spans);
    let used = spans.width() as u16 + 1;
    text::line(buffer, area, 0, spans);
    let bar = Rect {
        x: area.x + used.min(area.width),
        width: area.width.saturating_sub(used),
        ..area
    };
    text::line(
        buffer,
        bar,
        0,
        Span::styled(text::bar(share, bar.width, theme), colour),
    );
}

fn iterations<'a>(report: &Report, width: u16, theme: &Theme) -> Line<'a> {
    let line = |names| iterations_with(names, report, width, theme);
    let whole = line(["Newton", "linear", "director"]);
    match whole.width() <= usize::from(width) {
        true => whole,
        // None of the numbers is left out.
        false => line(["Newton", "lin.", "dir."]),
    }
}

fn iterations_with<'a>(
    [newton, linear, director]: [&'static str; 3],
    report: &Report,
    width: u16,
    theme: &Theme,
) -> Line<'a> {
    let counts = [
        (newton, report.newton),
        (linear, report.krylov),
        (director, report.director_iterations),
    ];
    let prefix = if width >= 50 { " iterations: " } else { " " };
    let mut spans = vec![Span::styled(prefix, theme.muted())];
    let gap = if width >= 40 { "  " } else { " " };
    for (number, (name, count)) in counts.into_iter().enumerate() {
        let gap = if number < 2 { gap } else { "" };
        spans.push(Span::styled(format!("{name} "), theme.muted()));
        spans.push(Span::raw(format!("{count}{gap}")));
    }
    Line::from(spans)
}

/// The residual of the energy law against what is allowed.
fn law_line<'a>(shown: &Shown<'_>, report: &Report, width: u16, theme: &Theme) -> Line<'a> {
    let tolerance = shown.scene().solver.law_tolerance;
    let residual = report.law_residual.abs();
    let style = if residual <= tolerance {
        theme.style(Role::Good)
    } else {
        theme.style(Role::Bad)
    };
    let allowed = match width {
        0..36 => String::new(),
        _ => format!(" of {}", brief(tolerance, 2)),
    };
    Line::from(vec![
        Span::styled(" energy law error ", theme.muted()),
        Span::styled(significant(residual, 2), style),
        Span::styled(allowed, theme.muted()),
    ])
}
