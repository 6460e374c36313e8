//! A map: a column in colours over two axes, a cell a point, with contour lines between the points.

use super::page::{Frame, Layout, compose};
use super::{Arranged, Panel, column_label};
use crate::figure::FigureError;
use crate::figure::canvas::{Drawing, Page, font, stroke, units};
use crate::figure::curves::TICKS;
use crate::figure::elements::{Mark, marker};
use crate::figure::panel::{bar_axis, line_weight};
use crate::figure::text::Label;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::{EmptyElement, PathElement, Rectangle};
use plotters::style::{BLACK, Color};
use std::iter::once;

/// The height of a panel to its width.
const ASPECT: f64 = 0.8;

/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw(arranged: &Arranged, width: u32, size: f64) -> Result<Drawing, FigureError> {
    let title = column_label(&arranged.column).and(&format!(": {}", arranged.title));
    let layout = Layout {
        title,
        ordinate: Label::text(arranged.y.as_ref().map_or("", |y| &*y.key)),
        width,
        size,
        aspect: ASPECT,
        has_bar: true,
    };
    compose(arranged, &layout, &|page, frame, panel| {
        draw_panel(page, frame, panel, arranged, size)
    })
}

fn draw_panel(
    page: &Page,
    frame: &Frame,
    panel: &Panel,
    arranged: &Arranged,
    size: f64,
) -> Result<(), FigureError> {
    let [x, y] = &frame.axes;
    let mut chart = ChartBuilder::on(page)
        .y_label_area_size(units(frame.rooms[0]))
        .x_label_area_size(units(frame.rooms[1]))
        .build_cartesian_2d(x.clone(), y.clone())?;
    for row in 0..arranged.rows() {
        for column in 0..x.places.len() {
            let cell = arranged.cell(panel, column, row);
            let corners = [
                (x.edges[column], y.edges[row]),
                (x.edges[column + 1], y.edges[row + 1]),
            ];
            let place = (x.places[column], y.places[row]);
            match cell.value {
                Some(value) => {
                    // With a line of the same colour: no paper is to show between two cells.
                    let colour = arranged.scale.at(value);
                    for style in [colour.filled(), stroke(colour, 1.0)] {
                        chart.draw_series(once(Rectangle::new(corners, style)))?;
                    }
                }
                // A point without a value is marked; where there is no point the paper shows.
                None if cell.row.is_some() => {
                    let style = stroke(BLACK, line_weight(size));
                    let cross = marker((0, 0), Mark::Cross, size, style);
                    chart.draw_series(once(EmptyElement::at(place) + cross))?;
                }
                None => {}
            }
        }
    }
    let value = |column: usize, row: usize| arranged.cell(panel, column, row).value;
    let line = stroke(BLACK, 1.1 * line_weight(size));
    let height = frame.plot.height();
    for level in bar_axis(&arranged.scale, height, size).ticks {
        for segment in contour([&x.places, &y.places], &value, level) {
            chart.draw_series(once(PathElement::new(segment, line)))?;
        }
    }
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(stroke(BLACK, 0.8 * line_weight(size)))
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
        .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
        .x_desc(Label::text(&arranged.x.key))
        .draw()?;
    let (across, along) = (
        x.edges[0]..x.edges[x.edges.len() - 1],
        y.edges[y.edges.len() - 1],
    );
    let sides = [
        (across.start, along),
        (across.end, along),
        (across.end, y.edges[0]),
    ];
    let thin = stroke(BLACK, 0.8 * line_weight(size));
    chart.draw_series(once(PathElement::new(sides, thin)))?;
    Ok(())
}

/// The segments of a level line, linear on both triangles of each cell between four places; where a corner has no
/// value there is none.
fn contour(
    [xs, ys]: [&[f64]; 2],
    value: &dyn Fn(usize, usize) -> Option<f64>,
    level: f64,
) -> Vec<[(f64, f64); 2]> {
    let mut segments = Vec::new();
    for row in 1..ys.len() {
        for column in 1..xs.len() {
            let corner = |dx: usize, dy: usize| {
                let (column, row) = (column - dx, row - dy);
                Some(((xs[column], ys[row]), value(column, row)? - level))
            };
            let triangles = [
                [corner(1, 1), corner(0, 1), corner(0, 0)],
                [corner(1, 1), corner(0, 0), corner(1, 0)],
            ];
            for triangle in triangles {
                let [Some(a), Some(b), Some(c)] = triangle else {
                    continue;
                };
                let crossing = |((x0, y0), v0): ((f64, f64), f64),
                                ((x1, y1), v1): ((f64, f64), f64)| {
                    let share = v0 / (v0 - v1);
                    ((v0 > 0.0) != (v1 > 0.0))
                        .then_some((x0 + share * (x1 - x0), y0 + share * (y1 - y0)))
                };
                let ends = [crossing(a, b), crossing(b, c), crossing(c, a)];
                let ends: Vec<(f64, f64)> = ends.into_iter().flatten().collect();
                if let [first, second] = ends[..] {
                    segments.push([first, second]);
                }
            }
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::contour;

    /// Of a linear function a level line is straight and exact, and ends where a value is missing.
    #[test]
    fn level_lines_are_exact_for_linear_functions() {
        let places = [0.0, 1.0, 2.5];
        let linear = |x: usize, y: usize| Some(places[x] + 2.0 * places[y]);
        let segments = contour([&places, &places], &linear, 1.7);
        assert!(segments.len() > 2);
        for (x, y) in segments.into_iter().flatten() {
            assert!((x + 2.0 * y - 1.7).abs() < 1e-14);
        }
        let holed = |x: usize, y: usize| linear(x, y).filter(|_| (x, y) != (0, 0));
        let segments = contour([&places, &places], &holed, 0.5);
        assert!(segments.is_empty(), "{segments:?}");
    }
}
