//! The field in its frame with axes and a colour bar.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Widget};

use super::plot::{Plot, level, ramp_glyph, ramp_style};
use super::shown::Shown;
use super::text;
use crate::fem::Rectangle;
use crate::tui::canvas::Canvas;
use crate::tui::layout::{Step, centred, fit};
use crate::tui::numbers::significant;
use crate::tui::sampled;
use crate::tui::state::{DirectorStyle, Field, View};
use crate::tui::theme::Theme;

/// Columns left of the frame, for the numbers of the y axis.
const LABELS: u16 = 4;
/// Columns right of the frame: a gap, the colour bar, a gap, its numbers.
const BAR: u16 = 9;

/// Draws the panel.
pub fn draw(
    shown: &Shown<'_>,
    view: View,
    focused: bool,
    step: Step,
    theme: &Theme,
    canvas: &mut Canvas,
    area: Rect,
    buffer: &mut Buffer,
) {
    let area = text::title(
        buffer,
        area,
        theme,
        focused,
        title(view, theme),
        notes(shown, view, theme),
    );
    let (Some(run), Some(setting), Some(picture)) = (shown.run, shown.setting, shown.picture)
    else {
        let words = match shown.run {
            None => "not started yet",
            Some(_) => "the mesh and the first fields are being made",
        };
        let area = centred(area, words.len() as u16, 1);
        return text::line(buffer, area, 0, Span::styled(words, theme.muted()));
    };
    let _ = run;
    let region = canvas.region(&setting.mesh);
    let room = (
        area.width.saturating_sub(LABELS + 2 + BAR),
        area.height.saturating_sub(3),
    );
    let (columns, rows) = fit(region.width() / region.height(), room.0, room.1);
    if columns < 2 || rows < 1 {
        return;
    }
    // The picture with all that belongs to it stands in the middle of its area.
    let outer = centred(area, columns + LABELS + 2 + BAR, rows + 3);
    let frame = Rect {
        x: outer.x + LABELS,
        y: outer.y,
        width: columns + 2,
        height: rows + 2,
    };
    let block = Block::bordered()
        .border_set(theme.glyphs().border)
        .border_style(theme.muted());
    let cells = block.inner(frame);
    block.render(frame, buffer);
    let plot = Plot {
        state: &picture.state,
        mesh: &setting.mesh,
        interface_width: setting.scene.membrane.interface_width,
        view,
    };
    let range = plot.draw(theme, canvas, cells, buffer);
    let ticks = if step == Step::Wide { 4 } else { 2 };
    axes(region, ticks, frame, theme, buffer);
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
    let (symbol, words) = sampled::names(view.field, theme);
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
        DirectorStyle::Arrows => "arrows",
        DirectorStyle::Strokes => "strokes",
        DirectorStyle::Off => "director off",
    };
    let words = if theme.paints() {
        let map = theme.map(view.colour_map).name;
        format!("{director} {} {map}", theme.glyphs().dot)
    } else {
        director.to_owned()
    };
    Line::styled(words, theme.muted())
}

/// Ticks on the frame and their numbers.
fn axes(region: Rectangle, parts: u16, frame: Rect, theme: &Theme, buffer: &mut Buffer) {
    let glyphs = theme.glyphs();
    let (left, bottom) = (frame.x, frame.bottom() - 1);
    for tick in 0..=parts {
        let share = f64::from(tick) / f64::from(parts);
        let label = |range: [f64; 2]| {
            let value = range[0] + share * (range[1] - range[0]);
            let text = format!("{value:.2}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            Span::styled(text.to_owned(), theme.muted())
        };
        let inner = tick > 0 && tick < parts;
        let x = left + (share * f64::from(frame.width - 1)).round() as u16;
        let number = label(region.x);
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
            x: left.saturating_sub(LABELS),
            y,
            width: LABELS.min(left) - 1,
            height: 1,
        };
        text::line_right(buffer, area, 0, label(region.y));
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
        let number = compact(value);
        text::line(buffer, labels, row, Span::styled(number, theme.muted()));
    }
}

/// A round number in at most five characters where that is possible.
fn compact(value: f64) -> String {
    let text = significant(value, 3);
    let (digits, exponent) = match text.split_once('e') {
        Some((digits, exponent)) => (digits.to_owned(), format!("e{exponent}")),
        None => (text, String::new()),
    };
    let digits = if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        &digits
    };
    format!("{digits}{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_the_bar_are_short() {
        let table = [
            (-1.0, "-1"),
            (0.0, "0"),
            (1.01, "1.01"),
            (2000.0, "2000"),
            (-1.5e6, "-1.5e6"),
            (0.03, "0.03"),
        ];
        for (value, text) in table {
            assert_eq!(compact(value), text);
        }
    }
}
