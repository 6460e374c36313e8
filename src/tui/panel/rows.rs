//! Rows of scalars: a name, the present value, the change, and the curve of the whole run.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};

use super::text;
use crate::tui::curve;
use crate::tui::numbers::{brief, percent, signed, significant};
use crate::tui::series::Series;
use crate::tui::theme::Theme;

/// How wide the parts of a row are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Widths {
    name: usize,
    value: usize,
    digits: usize,
    change: usize,
    relative: usize,
}

impl Widths {
    /// The widths for a panel: what there is no room for is left out, the curves last of all.
    pub fn of(panel: u16) -> Self {
        let narrow = Self {
            name: 14,
            value: 8,
            digits: 4,
            change: 0,
            relative: 7,
        };
        match panel {
            0..40 => narrow,
            40..56 => Self {
                name: 14,
                value: 9,
                digits: 6,
                relative: 8,
                ..narrow
            },
            _ => Self {
                name: 15,
                value: 10,
                digits: 7,
                change: 11,
                relative: 9,
            },
        }
    }

    /// The column of the relative change.
    pub fn relative(&self, row: Rect) -> Rect {
        let before = ((self.name + self.value + self.change) as u16).min(row.width);
        Rect {
            x: row.x + before,
            width: (self.relative as u16).min(row.width - before),
            ..row
        }
    }

    /// What the numbers leave of a row.
    pub fn beside(&self, row: Rect) -> Rect {
        let numbers = (self.name + self.value + self.change + self.relative) as u16;
        let gap = if self.value > 8 { 2 } else { 1 };
        let used = (numbers + gap).min(row.width);
        Rect {
            x: row.x + used,
            width: row.width - used,
            height: row.height.min(1),
            ..row
        }
    }
}

/// A curve of fewer columns says nothing.
const LEAST_CURVE: u16 = 6;

/// A row: what it is called, what it is, and how it became so.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row<'a> {
    /// Its name.
    pub name: &'a str,
    /// The colour of its name and of its curve; none for a name in the text's own colour.
    pub colour: Option<Color>,
    /// The present value.
    pub value: Option<f64>,
    /// What the change is counted from; `None`: none is shown.
    pub start: Option<f64>,
    /// Digits of the value, where not as many as there is room for.
    pub digits: Option<usize>,
    /// The values of the whole run.
    pub series: Option<&'a Series>,
}

/// Draws a row; the curve takes what the numbers leave of the width.
pub fn draw(
    row: &Row<'_>,
    widths: Widths,
    curves: &curve::Frame<'_>,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    text::line(buffer, area, 0, numbers(row, widths, theme));
    if let Some(series) = row.series {
        let area = widths.beside(area);
        if area.width < LEAST_CURVE {
            return;
        }
        let colour = row.colour.unwrap_or(theme.curve());
        curve::draw(series, curves, colour, theme, area, buffer);
    }
}

/// The numbers of a row in columns.
pub fn numbers<'a>(row: &Row<'_>, widths: Widths, theme: &Theme) -> Line<'a> {
    let name = row
        .colour
        .map_or_else(Style::default, |colour| Style::default().fg(colour));
    let value = row.value.map_or_else(
        || theme.word("–", "-").to_owned(),
        |value| {
            let text = significant(value, row.digits.unwrap_or(widths.digits));
            // What is nearly nothing has a long exponent.
            let shorter = [text, brief(value, 2), brief(value, 1)].into_iter();
            let mut fitting = shorter.filter(|text| text.chars().count() < widths.value);
            fitting.next().unwrap_or_else(|| brief(value, 1))
        },
    );
    let mut spans = vec![
        Span::styled(format!(" {:<1$}", row.name, widths.name - 1), name),
        Span::raw(format!("{value:>0$}", widths.value)),
    ];
    let (change, relative) = match row.value.zip(row.start) {
        Some((value, start)) => (signed(value - start, 4), percent(value - start, start)),
        None => Default::default(),
    };
    if widths.change > 0 {
        spans.push(Span::styled(
            format!("{change:>0$}", widths.change),
            theme.muted(),
        ));
    }
    spans.push(Span::styled(
        format!("{relative:>0$}", widths.relative),
        theme.muted(),
    ));
    Line::from(spans)
}
