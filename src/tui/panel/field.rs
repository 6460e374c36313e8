//! The field in its frame with axes and a colour bar.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::Look;
use super::plot::{Plot, level, ramp_glyph, ramp_style};
use super::shown::Shown;
use super::{text, theory};
use crate::geometry::BoundingBox;
use crate::tui::canvas::Canvas;
use crate::tui::field_image;
use crate::tui::layout::{Step, centred, fit};
use crate::tui::numbers::brief;
use crate::tui::state::{Director, Field, Run, View};
use crate::tui::theme::Theme;

/// Columns left of the frame, for the numbers of the y axis.
fn labels(step: Step) -> u16 {
    match step {
        Step::TooSmall | Step::Narrow => 2,
        Step::Normal => 4,
        Step::Wide => 5,
    }
}

/// Parts of an axis that have numbers at their ends.
fn parts(step: Step) -> u16 {
    match step {
        Step::TooSmall | Step::Narrow => 1,
        Step::Normal => 2,
        Step::Wide => 4,
    }
}

/// Columns right of the frame: a gap, the colour bar, a gap, its numbers.
const BAR: u16 = 9;

/// Draws the panel.
pub fn draw(
    shown: &Shown<'_>,
    look: Look,
    theme: &Theme,
    canvas: &mut Canvas,
    area: Rect,
    buffer: &mut Buffer,
) {
    let Look {
        view,
        focused,
        step,
    } = look;
    let area = text::title(
        buffer,
        area,
        theme,
        focused,
        title(view, theme),
        notes(shown, view, theme),
    );
    let (Some(setting), Some(picture)) = (shown.setting, shown.picture) else {
        let words = match shown.run {
            None => "not started yet",
            Some(_) => "the mesh and the first fields are being made",
        };
        let area = centred(area, words.len() as u16, 1);
        return text::line(buffer, area, 0, Span::styled(words, theme.muted()));
    };
    let region = canvas.region(&picture.mesh);
    let labels = labels(step);
    let room = (
        area.width.saturating_sub(labels + 2 + BAR),
        area.height.saturating_sub(3),
    );
    let (columns, rows) = fit(region.aspect(), room.0, room.1);
    if columns < 2 || rows < 1 {
        return;
    }
    // The picture with all that belongs to it stands in the middle of its area.
    let outer = centred(area, columns + labels + 2 + BAR, rows + 3);
    let frame = Rect {
        x: outer.x + labels,
        y: outer.y,
        width: columns + 2,
        height: rows + 2,
    };
    let plot = Plot {
        mesh: &picture.mesh,
        state: &picture.state,
        setting,
        view,
    };
    let (cells, range) = plot.draw(theme, canvas, frame, buffer);
    if view.theory
        && let Some(Ok(shape)) = shown.run.and_then(Run::shape_at_rest)
    {
        theory::draw(shape, picture, region, cells, theme, buffer);
    }
    axes(region, parts(step), frame, theme, buffer);
    let bar = Rect {
        x: frame.right() + 1,
        width: BAR - 1,
        ..cells
    };
    colour_bar(range, view, theme, bar, buffer);
    if view.field == Field::DirectorLength && picture.state.director.is_none() {
        let words = " this scene has no director ";
        let area = centred(cells, words.len() as u16, 1);
        text::line(buffer, area, 0, words);
    }
}

/// What is shown.
fn title<'a>(view: View, theme: &Theme) -> Line<'a> {
    let (symbol, words) = field_image::names(view.field, theme);
    Line::from(vec![
        Span::styled(symbol, theme.strong()),
        Span::raw(" "),
        Span::raw(words),
    ])
}

/// How it is shown.
fn notes<'a>(shown: &Shown<'_>, view: View, theme: &Theme) -> Line<'a> {
    let director = match view.director {
        _ if shown.scene().nematic.is_none() => "no director",
        Director::Arrows => "arrows",
        Director::Strokes => "strokes",
        Director::Off => "director off",
    };
    let words = if theme.paints() {
        let map = theme.map(view.colour_map).name;
        format!("{director} {} {map}", theme.glyphs().dot)
    } else {
        director.to_owned()
    };
    Line::styled(words, theme.muted())
}

/// A coordinate in at most two decimals, or in three digits where the domain is too small for that.
fn coordinate(value: f64, span: f64) -> String {
    if span < 0.05 {
        return brief(value, 3);
    }
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Ticks on the frame and their numbers.
fn axes(region: BoundingBox, parts: u16, frame: Rect, theme: &Theme, buffer: &mut Buffer) {
    let glyphs = theme.glyphs();
    let (left, bottom) = (frame.x, frame.bottom() - 1);
    for tick in 0..=parts {
        let share = f64::from(tick) / f64::from(parts);
        let label = |axis: usize| {
            let (start, span) = (region.lower[axis], region.extent()[axis]);
            Span::styled(coordinate(start + share * span, span), theme.muted())
        };
        let inner = tick > 0 && tick < parts;
        let x = left + (share * f64::from(frame.width - 1)).round() as u16;
        let number = label(0);
        let width = number.width() as u16;
        let area = Rect {
            x: x.saturating_sub(width / 2),
            y: bottom + 1,
            width,
            height: 1,
        };
        text::line(buffer, area, 0, number);
        if let Some(cell) = buffer.cell_mut((x, bottom)).filter(|_| inner) {
            cell.set_symbol(glyphs.ticks[0]);
        }
        let y = bottom - (share * f64::from(frame.height - 1)).round() as u16;
        let area = Rect {
            x: 0,
            y,
            width: left.saturating_sub(1),
            height: 1,
        };
        text::line_right(buffer, area, 0, label(1));
        if let Some(cell) = buffer.cell_mut((left, y)).filter(|_| inner) {
            cell.set_symbol(glyphs.ticks[1]);
        }
    }
}

/// The colour bar, its greatest value on top, with the numbers of both ends and of the middle.
fn colour_bar(range: [f64; 2], view: View, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let map = theme.map(view.colour_map);
    let rows = f64::from(area.height.max(1));
    for row in 0..area.height {
        // The shares at the middle of the upper and of the lower half of the cell.
        let share = |quarter: f64| 1.0 - (f64::from(row) + quarter) / rows;
        let (upper, lower) = (level(share(0.25)), level(share(0.75)));
        let (symbol, style) = match theme.glyphs().upper_half.filter(|_| theme.paints()) {
            Some(half) => {
                let style = Style::default()
                    .fg(theme.level(map, upper))
                    .bg(theme.level(map, lower));
                (half, style)
            }
            None if theme.paints() => (
                " ",
                Style::default().bg(theme.level(map, level(share(0.5)))),
            ),
            None => (
                ramp_glyph(share(0.5), view, theme),
                ramp_style(share(0.5), theme),
            ),
        };
        text::line(buffer, area, row, Span::styled(symbol.repeat(2), style));
    }
    let labels = Rect {
        x: area.x + 3,
        width: area.width.saturating_sub(3),
        ..area
    };
    let middle = 0.5 * (range[0] + range[1]);
    let last = area.height.saturating_sub(1);
    for (row, value) in [(0, range[1]), (last / 2, middle), (last, range[0])] {
        if row == last / 2 && area.height < 5 {
            continue;
        }
        let number = brief(value, 3);
        text::line(buffer, labels, row, Span::styled(number, theme.muted()));
    }
}

#[cfg(test)]
mod tests {
    use super::coordinate;

    #[test]
    fn coordinates_of_a_small_domain_do_not_all_read_0() {
        let parts = |span: f64| [0.0, 0.25, 0.5].map(|share| coordinate(share * span, span));
        assert_eq!(parts(1.0), ["0", "0.25", "0.5"]);
        assert_eq!(parts(1e-5), ["0", "2.5e-6", "5e-6"]);
        assert_eq!(coordinate(-0.25, 1.5), "-0.25");
    }
}
