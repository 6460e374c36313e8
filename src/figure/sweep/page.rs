//! What the figures of a sweep have in common: a title, panels in rows, and a colour bar beside them.

use super::{Arranged, Panel, PlaceAxis, column_label};
use crate::figure::FigureError;
use crate::figure::canvas::{Drawing, Page, Rectangle, part, write_label, write_paragraph};
use crate::figure::panel::{bar_room, draw_bar};
use crate::figure::text::{Label, line_height};
use plotters::style::text_anchor::{HPos, VPos};

/// Below a panel for its numbers and the name of its axis, in sizes of the text.
const LOWER: f64 = 3.2;

/// A panel's place and what is around it.
pub(super) struct Frame {
    pub plot: Rectangle,
    /// At the left for numbers and the name of the axis, and below.
    pub rooms: [f64; 2],
    pub axes: [PlaceAxis; 2],
}

/// How a figure is laid out.
pub(super) struct Layout {
    pub title: Label,
    /// The name of the ordinate: above each plot, for letters are not turned.
    pub ordinate: Label,
    /// In pixels.
    pub width: u32,
    /// Of the text, in pixels.
    pub size: f64,
    /// The height of a plot to its width.
    pub aspect: f64,
    /// Whether there is a colour bar.
    pub has_bar: bool,
}

/// Draws every panel by `draw`, on a part of the page that has the plot and its rooms.
pub(super) fn compose(
    arranged: &Arranged,
    layout: &Layout,
    draw: &dyn Fn(&Page, &Frame, &Panel) -> Result<(), FigureError>,
) -> Result<Drawing, FigureError> {
    let Layout {
        title,
        ordinate,
        width,
        size,
        aspect,
        has_bar,
    } = layout;
    let (width, size, aspect, has_bar) = (*width, *size, *aspect, *has_bar);
    let [x, y] = arranged.axes();
    let margin = 0.7 * size;
    let left_room = y.widest(size).max(3.0 * size) + size;
    let name = column_label(&arranged.column);
    let bar = match has_bar {
        true => bar_room(&arranged.scale, size, &name) + 1.2 * size,
        false => 0.0,
    };
    let columns = arranged.columns.min(arranged.panels.len()).max(1);
    let all = f64::from(width) - 2.0 * margin - bar;
    let cell = all / columns as f64;
    // A single panel is not to fill a page.
    let inner = (cell - left_room - 0.8 * size).max(4.0 * size);
    let inner = inner.min(0.75 * f64::from(width));
    let height = aspect * inner;
    let frame = |left: f64, top: f64| Frame {
        plot: Rectangle::new([left + left_room, top], [inner, height]).on_pixels(),
        rooms: [left_room, LOWER * size],
        axes: [
            x.clone().fitted(inner, size, false),
            y.clone().fitted(height, size, true),
        ],
    };
    Drawing::compose(width, |page| {
        let room = f64::from(width) - 2.0 * margin;
        let mut top = write_paragraph(page, title, size, [margin, margin], room)? + 0.5 * size;
        for panels in arranged.panels.chunks(columns) {
            let lines = |panel: &Panel| Label::text(&panel.title).wrapped(size, inner).len();
            let lines = panels
                .iter()
                .filter(|it| !it.title.is_empty())
                .map(lines)
                .max();
            let lines = lines.unwrap_or(0);
            let names = line_height(size) * lines as f64;
            // Above the plots stands the name of the ordinate, above the bar what it shows, and its power of ten.
            let names =
                (names + line_height(size) * 1.1).max(if has_bar { 2.8 * size } else { 0.0 });
            for (column, panel) in panels.iter().enumerate() {
                let left = margin + column as f64 * (left_room + inner + 0.8 * size);
                let frame = frame(left, top + names);
                if !panel.title.is_empty() {
                    let above = 1.1 * line_height(size);
                    let own = line_height(size) * lines as f64;
                    let at = [frame.plot.left, frame.plot.top - above - own];
                    write_paragraph(page, &Label::text(&panel.title), size, at, inner)?;
                }
                let at = [
                    frame.plot.left - left_room,
                    frame.plot.top - 1.1 * line_height(size),
                ];
                write_paragraph(page, ordinate, size, at, inner + left_room)?;
                let place = frame.plot.with_room([frame.rooms[0], 0.0, frame.rooms[1]]);
                draw(&part(page, place), &frame, panel)?;
            }
            if has_bar {
                let right = margin + panels.len() as f64 * (left_room + inner + 0.8 * size);
                let corner = [right + 0.4 * size, top + names];
                draw_bar(
                    page,
                    &arranged.scale,
                    corner,
                    height,
                    size,
                    &Label::default(),
                )?;
                let at = [corner[0], corner[1] - 2.7 * size];
                write_label(page, &name, size, at, (HPos::Left, VPos::Top))?;
            }
            top += names + height + LOWER * size + 0.6 * size;
        }
        Ok(top - 0.6 * size + margin)
    })
}
