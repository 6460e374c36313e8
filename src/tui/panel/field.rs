//! The field in its frame with axes and a colour bar.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::Look;
use super::director::WHOLE;
use super::external_field;
use super::plot::{Drawn, Plot, level, ramp_glyph, ramp_style};
use super::shown::Shown;
use super::{text, theory};
use crate::figure::round_ticks;
use crate::geometry::{BoundingBox, Point};
use crate::scene::Geometry;
use crate::simulation::outline_beside;
use crate::tui::canvas::Canvas;
use crate::tui::field_image;
use crate::tui::layout::{Step, centred};
use crate::tui::numbers::brief;
use crate::tui::state::{Director, Field, View, Zoom};
use crate::tui::theme::{Role, Theme};
use crate::tui::window::Window;

/// Columns left of the frame, for the numbers of the y axis.
fn labels(step: Step) -> u16 {
    match step {
        Step::TooSmall | Step::Narrow => 4,
        Step::Normal | Step::Wide => 5,
    }
}

/// Numbers on an axis, at most.
fn numbers(step: Step) -> usize {
    match step {
        Step::TooSmall | Step::Narrow | Step::Normal => 4,
        Step::Wide => 8,
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
    let title = title(view, theme);
    // The title has marks and gaps around it, and so have the notes.
    let room = usize::from(area.width).saturating_sub(title.width() + 7);
    let shape = shown.run.filter(|_| view.theory);
    let shape = shape.and_then(|run| run.theory.shape());
    let outline = match (shape, shown.picture) {
        (Some(shape), Some(now)) => outline_beside(shape, &now.mesh, &now.state.phi),
        _ => Vec::new(),
    };
    let notes = notes(shown, view, !outline.is_empty(), theme, room);
    let area = text::title(buffer, area, theme, focused, title, notes);
    let (Some(setting), Some(picture)) = (shown.setting, shown.picture) else {
        let words = match shown.run {
            None => "not started yet",
            Some(_) => "the mesh and the first fields are being made",
        };
        let area = centred(area, words.len() as u16, 1);
        return text::line(buffer, area, 0, Span::styled(words, theme.muted()));
    };
    let labels = labels(step);
    let room = (
        area.width.saturating_sub(labels + 2 + BAR),
        area.height.saturating_sub(3),
    );
    let domain = canvas.region(&picture.mesh);
    let vesicle = shown.run.and_then(|run| run.past.vesicle());
    let window = window(domain, vesicle, &outline, view.zoom, room);
    let Window { columns, rows, .. } = window;
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
        region: window.region,
        view,
    };
    let drawn = plot.draw(theme, canvas, frame, buffer);
    theory::draw(&outline, window.region, &drawn, theme, buffer);
    let Drawn { cells, range, .. } = drawn;
    let names = match picture.mesh.geometry() {
        Geometry::Planar => ["x", "y"],
        Geometry::Axisymmetric => ["r", "z"],
    };
    axes(window.region, names, numbers(step), frame, theme, buffer);
    external_field::draw(shown, frame, theme, buffer);
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

/// The part of the domain that is shown: an outline that is drawn is seen whole where the vesicle is.
fn window(
    domain: BoundingBox,
    vesicle: Option<BoundingBox>,
    outline: &[Point],
    zoom: Zoom,
    room: (u16, u16),
) -> Window {
    let seen = vesicle.map(|it| it.union(&BoundingBox::around(outline)));
    Window::new(domain, seen, zoom, room)
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

/// How it is shown: as much of it as has room.
fn notes<'a>(
    shown: &Shown<'_>,
    view: View,
    has_outline: bool,
    theme: &Theme,
    room: usize,
) -> Line<'a> {
    let line = Style::default().fg(theme.contour(theme.map(view.colour_map)));
    let mut parts = vec![vec![
        Span::styled(theme.glyphs().contour, line),
        Span::styled(theme.word(" φ = 0", " phi = 0"), theme.muted()),
    ]];
    if has_outline {
        parts.push(vec![
            Span::styled(theme.glyphs().theory, theme.style(Role::Good)),
            Span::styled(" theory at rest", theme.muted()),
        ]);
    }
    let short = theme.word("½", "1/2");
    let director = match view.director {
        _ if shown.scene().nematic.is_none() => "no director".to_owned(),
        Director::Strokes if theme.parts().is_some() => match room {
            0..50 => format!("dashed |d| < {WHOLE}"),
            _ => format!("lines along d, dashed where |d| < {WHOLE}"),
        },
        Director::Arrows | Director::Strokes => {
            let word = match view.director {
                Director::Arrows => "arrows",
                _ => "strokes",
            };
            format!("{word}, dots where |d| < {short}")
        }
        Director::Off => String::new(),
    };
    let zoom = match view.zoom {
        Zoom::Fit => "fit",
        Zoom::Domain => "domain",
        Zoom::Double => "2x",
    };
    let words = [
        Some(director).filter(|_| view.shows_director()),
        Some(zoom.to_owned()),
    ];
    let map = theme
        .paints()
        .then(|| theme.map(view.colour_map).name.to_owned());
    let words = words.into_iter().chain([map]).flatten();
    parts.extend(words.map(|words| vec![Span::styled(words, theme.muted())]));
    let mut notes = Line::default();
    for part in parts {
        let separator = match notes.spans.is_empty() {
            true => String::new(),
            false => format!(" {} ", theme.glyphs().dot),
        };
        let part = Line::from_iter(
            [Span::styled(separator, theme.muted())]
                .into_iter()
                .chain(part),
        );
        if notes.width() + part.width() <= room {
            notes.extend(part);
        }
    }
    notes
}

/// A coordinate in as few decimals as it needs, three at most, or in three digits where the domain is too small for
/// that.
fn coordinate(value: f64, span: f64) -> String {
    if span < 0.05 {
        return brief(value, 3);
    }
    let text = format!("{value:.3}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Ticks on the frame and their numbers; the axes' names stand beyond its lower right and upper left corners.
fn axes(
    region: BoundingBox,
    names: [&'static str; 2],
    most: usize,
    frame: Rect,
    theme: &Theme,
    buffer: &mut Buffer,
) {
    let glyphs = theme.glyphs();
    let (left, bottom) = (frame.x, frame.bottom() - 1);
    let corners = [
        (frame.right(), bottom + 1),
        (left.saturating_sub(2), frame.y),
    ];
    for (name, (x, y)) in names.into_iter().zip(corners) {
        let place = Rect::new(x, y, 1, 1);
        text::line(buffer, place, 0, Span::styled(name, theme.muted()));
    }
    let inner = [frame.width, frame.height].map(|cells| f64::from(cells - 2));
    for axis in [0, 1] {
        let (start, span) = (region.lower[axis], region.extent()[axis]);
        for tick in round_ticks([start, start + span], most) {
            // Between the sides of the picture, from the left or from below.
            let cell = (inner[axis] * (tick - start) / span).min(inner[axis] - 1.0) as u16;
            let number = Span::styled(coordinate(tick, span), theme.muted());
            let width = number.width() as u16;
            let (area, at, mark) = if axis == 0 {
                let x = left + 1 + cell;
                let area = Rect {
                    x: x.saturating_sub(width / 2),
                    y: bottom + 1,
                    width,
                    height: 1,
                };
                (area, (x, bottom), glyphs.ticks[0])
            } else {
                let y = bottom - 1 - cell;
                let room = left.saturating_sub(1).min(width);
                let area = Rect {
                    x: left.saturating_sub(1 + room),
                    y,
                    width: room,
                    height: 1,
                };
                (area, (left, y), glyphs.ticks[1])
            };
            text::line(buffer, area, 0, number);
            if let Some(cell) = buffer.cell_mut(at) {
                cell.set_symbol(mark);
            }
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
        let level = |share: f64| level(view.field, share);
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
    use super::*;

    /// A high vesicle, and a round outline that is wider: seen whole by the width of its room too, and no part more while
    /// it moves less than a step.
    #[test]
    fn the_outline_of_theory_is_seen_whole() {
        let rectangle = |lower: [f64; 2], upper: [f64; 2]| BoundingBox {
            lower: lower.into(),
            upper: upper.into(),
        };
        let domain = rectangle([0.0, 0.0], [1.0, 1.0]);
        let vesicle = rectangle([0.38, 0.18], [0.62, 0.82]);
        let circle = |x: f64| {
            let angles =
                (0..60).map(|number| f64::from(number) * 0.1 * std::f64::consts::FRAC_PI_3);
            angles.map(move |angle| Point::new(x + 0.21 * angle.cos(), 0.5 + 0.21 * angle.sin()))
        };
        let region =
            |outline: &[Point], zoom| window(domain, Some(vesicle), outline, zoom, (17, 17)).region;
        let outline: Vec<Point> = circle(0.5).collect();
        let holds = |region: BoundingBox| {
            let around = BoundingBox::around(&outline);
            region.union(&around) == region
        };
        assert!(holds(region(&outline, Zoom::Fit)));
        assert!(!holds(region(&[], Zoom::Fit)));
        let moved: Vec<Point> = circle(0.503).collect();
        assert_eq!(region(&outline, Zoom::Fit), region(&moved, Zoom::Fit));
        assert_eq!(region(&outline, Zoom::Domain), domain);
    }

    #[test]
    fn coordinates_of_a_small_domain_do_not_all_read_0() {
        let parts = |span: f64| [0.0, 0.25, 0.5].map(|share| coordinate(share * span, span));
        assert_eq!(parts(1.0), ["0", "0.25", "0.5"]);
        assert_eq!(coordinate(0.125, 1.0), "0.125");
        assert_eq!(coordinate(-1e-17, 1.0), "0");
        assert_eq!(parts(1e-5), ["0", "2.5e-6", "5e-6"]);
        assert_eq!(coordinate(-0.25, 1.5), "-0.25");
    }
}
