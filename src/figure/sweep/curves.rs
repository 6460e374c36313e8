//! A column over one axis: a curve, or one for each value of a second axis.

use super::axis::DIGITS;
use super::page::{Frame, Layout, compose};
use super::{Arranged, Panel, column_label, numeric};
use crate::figure::FigureError;
use crate::figure::canvas::{Drawing, Page, font, stroke, units};
use crate::figure::colour::LINE_COLOURS;
use crate::figure::curves::TICKS;
use crate::figure::elements::{Mark, marker};
use crate::figure::number::{Axis, number, roomy_range};
use crate::figure::panel::line_weight;
use crate::figure::text::Label;
use crate::study::sweep::plain;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::{EmptyElement, PathElement, Text};
use plotters::series::LineSeries;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, RGBColor};
use std::iter::once;

/// The height of a panel to its width.
const ASPECT: f64 = 0.66;

/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw(arranged: &Arranged, width: u32, size: f64) -> Result<Drawing, FigureError> {
    let mut title = column_label(&arranged.column).and(&format!(": {}", arranged.title));
    if let Some(y) = &arranged.y {
        title = title.and(&format!("; a curve for each {}", y.key));
    }
    let layout = Layout {
        title,
        ordinate: values(arranged, 2).name(column_label(&arranged.column)),
        width,
        size,
        aspect: ASPECT,
        has_bar: false,
    };
    compose(arranged, &layout, &|page, frame, panel| {
        draw_panel(page, frame, panel, arranged, size)
    })
}

/// The colour of curve `number` of `of` curves: from a colour map where the curves outnumber the line colours.
fn colour(number: usize, of: usize) -> RGBColor {
    if of <= LINE_COLOURS.len() {
        return LINE_COLOURS[number];
    }
    let share = number as f64 / (of - 1) as f64;
    let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(0.9 * share);
    RGBColor(r, g, b)
}

/// The axis of the values, the same for all panels.
fn values(arranged: &Arranged, most: usize) -> Axis {
    let cells = arranged.panels.iter().flat_map(|panel| &panel.cells);
    Axis::new(roomy_range(cells.filter_map(|cell| cell.value)), most)
}

fn draw_panel(
    page: &Page,
    frame: &Frame,
    panel: &Panel,
    arranged: &Arranged,
    size: f64,
) -> Result<(), FigureError> {
    let [x, _] = &frame.axes;
    let most = ((frame.plot.height() / (1.8 * size)) as usize).clamp(2, 8);
    let value = values(arranged, most);
    let mut chart = ChartBuilder::on(page)
        .y_label_area_size(units(frame.rooms[0]))
        .x_label_area_size(units(frame.rooms[1]))
        .build_cartesian_2d(x.clone(), value.clone())?;
    let thin = stroke(BLACK, 0.8 * line_weight(size));
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(thin)
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
        .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
        .x_desc(Label::text(&arranged.x.key))
        .draw()?;
    let rows = arranged.rows();
    for row in 0..rows {
        let at = |column: usize| {
            let value = arranged.cell(panel, column, row).value?;
            Some((x.places[column], value))
        };
        let points: Vec<Option<(f64, f64)>> = (0..x.places.len()).map(at).collect();
        let colour = colour(row, rows);
        // Where a point has no value the curve has a gap.
        for piece in points.split(Option::is_none) {
            let piece: Vec<(f64, f64)> = piece.iter().flatten().copied().collect();
            let style = stroke(colour, 1.6 * line_weight(size));
            chart.draw_series(LineSeries::new(piece, style))?;
        }
        let known: Vec<(f64, f64)> = points.into_iter().flatten().collect();
        for place in &known {
            let mark = marker((0, 0), Mark::Disc, 0.7 * size, colour.filled());
            chart.draw_series(once(EmptyElement::at(*place) + mark))?;
        }
        // Each curve has its value at its right end, where there is room.
        if let (Some(y), Some(end)) = (&arranged.y, known.last()) {
            let style = font(0.85 * size).pos(Pos::new(HPos::Right, VPos::Bottom));
            let label: String = match numeric(&y.values[row]) {
                Some(value) => number(value, DIGITS),
                None => Label::text(&plain(&y.values[row])),
            }
            .into();
            let text = Text::new(label, (0, units(-0.35 * size)), style);
            chart.draw_series(once(EmptyElement::at(*end) + text))?;
        }
    }
    let ([low, high], range) = (value.range, [x.edges[0], x.edges[x.edges.len() - 1]]);
    let sides = [(range[0], high), (range[1], high), (range[1], low)];
    chart.draw_series(once(PathElement::new(sides, thin)))?;
    Ok(())
}
