//! A curve with its axes: the values at its ends, and what happened when.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::text::Span;

use super::text;
use crate::tui::curve::{self, Frame};
use crate::tui::layout::{take_bottom, take_left};
use crate::tui::numbers::brief;
use crate::tui::series::Series;
use crate::tui::theme::{Role, Theme};

/// Columns to the left, for the values at the ends.
const LABELS: u16 = 9;

/// Draws a curve with its axes: the values at round ends at the left, and below what happened, where there is a row
/// for it.
pub fn draw(
    series: &Series,
    frame: &Frame<'_>,
    colour: Color,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let mut area = area.intersection(buffer.area);
    let mut axis = match area.height {
        0..3 => Rect::ZERO,
        _ => take_bottom(&mut area, 1),
    };
    let labels = take_left(&mut area, LABELS);
    take_left(&mut area, 1);
    let ends = curve::draw_to_round_ends(series, frame, colour, theme, area, buffer);
    let label = |value: f64| Span::styled(brief(value, 4), theme.muted());
    if let Some([low, high]) = ends {
        text::line_right(buffer, labels, 0, label(high));
        if labels.height > 1 {
            text::line_right(buffer, labels, labels.height - 1, label(low));
        }
    }
    let left = take_left(&mut axis, LABELS + 1);
    text::line_right(buffer, left, 0, Span::styled("t = 0 ", theme.muted()));
    marks(frame, theme, axis, buffer);
}

/// The line below a plot, with what happened at its time.
fn marks(frame: &Frame<'_>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let glyphs = theme.glyphs();
    let rule = glyphs.rule.repeat(usize::from(area.width));
    text::line(buffer, area, 0, Span::styled(rule, theme.muted()));
    let mut end = format!(" {}", brief(frame.end, 3));
    // From the last one back: a name ends before the next mark, or is left out.
    let mut room = area.width;
    for mark in frame.marks.iter().rev() {
        let x = curve::column(mark.t, frame, area);
        let (name, style) = match mark.name() {
            Some(name) => (name, theme.style(Role::Warning)),
            None => ("", theme.muted()),
        };
        let glyph = match name {
            "" => glyphs.dot,
            _ => glyphs.arrows[2],
        };
        let width = 1 + name.chars().count() as u16;
        if x + width + 1 > area.width.saturating_sub(end.len() as u16) {
            // It stands where the time at the end would.
            end.clear();
        }
        let words = match x + width <= room {
            true => format!("{glyph}{name}"),
            false => glyph.to_owned(),
        };
        if x < room {
            let place = Rect {
                x: area.x + x,
                width: area.width - x,
                ..area
            };
            text::line(buffer, place, 0, Span::styled(words, style));
            room = x;
        }
    }
    text::line_right(buffer, area, 0, Span::styled(end, theme.muted()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{MarkKind, RunMark};
    use crate::tui::theme::ColorTier;

    #[test]
    fn a_plot_has_round_ends_and_names_what_happened_below() {
        let theme = Theme::new(ColorTier::None, true);
        let change = MarkKind::Change {
            label: "parallel".to_owned(),
            work: None,
        };
        let mark = |step: u64, kind| RunMark {
            step,
            t: step as f64,
            kind,
        };
        let marks = [mark(2, MarkKind::Mesh), mark(3, change)];
        let frame = Frame {
            marks: &marks,
            cursor: Some(8.0),
            end: 10.0,
            logarithmic: false,
        };
        let area = Rect::new(0, 0, 40, 4);
        let mut buffer = Buffer::empty(area);
        let mut falling = Series::default();
        for (step, value) in [640.0, 600.0, 500.0, 400.0, 350.0, 320.0, 310.0]
            .iter()
            .enumerate()
        {
            falling.push(step as f64, *value);
        }
        draw(&falling, &frame, Color::Reset, &theme, area, &mut buffer);
        let row = |y| -> String { (0..40).map(|x| buffer[(x, y)].symbol()).collect() };
        let rows: Vec<String> = (0..4).map(row).collect();
        assert!(rows[0].starts_with("      700 "), "{rows:#?}");
        assert!(rows[2].starts_with("      300 "), "{rows:#?}");
        assert!(rows[3].starts_with("    t = 0 "), "{rows:#?}");
        assert!(rows[3].contains("·──↑parallel──"), "{rows:#?}");
        assert!(rows[3].ends_with(" 10"), "{rows:#?}");
        // The time that is looked at is marked where there is no curve.
        assert_eq!(buffer[(10 + 24, 0)].symbol(), "│");
    }
}
