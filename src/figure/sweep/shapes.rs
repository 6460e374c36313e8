//! The diagram of shapes: the last vesicle of each point at its place in the plane of two keys.

use super::page::{Frame, Layout, compose};
use super::{Arranged, Outlines, Panel};
use crate::figure::FigureError;
use crate::figure::canvas::{Drawing, Page, font, stroke, units};
use crate::figure::colour::GREY;
use crate::figure::curves::TICKS;
use crate::figure::elements::{Mark, marker};
use crate::figure::panel::line_weight;
use crate::figure::text::Label;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::{EmptyElement, IntoDynElement, PathElement, Polygon};
use plotters::style::{BLACK, Color};
use std::iter::once;

/// The part of a point's room that the largest vesicle takes.
const FILLED: f64 = 0.9;

/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw(
    arranged: &Arranged,
    outlines: &Outlines,
    width: u32,
    size: f64,
) -> Result<Drawing, FigureError> {
    let title = Label::text(&format!("Vesicles: {}", arranged.title));
    let largest = outlines.largest();
    let [x, y] = arranged.axes();
    // As high as makes the room of a point as wide and as high as the vesicles need.
    let aspect = largest[1] / largest[0] * x.narrowest() / y.narrowest();
    let aspect = aspect.clamp(0.15, 1.4);
    let layout = Layout {
        title,
        ordinate: Label::text(arranged.y.as_ref().map_or("", |y| &*y.key)),
        width,
        size,
        aspect,
        has_bar: true,
    };
    compose(arranged, &layout, &|page, frame, panel| {
        draw_panel(page, frame, panel, arranged, outlines, size)
    })
}

impl Outlines {
    /// The greatest extents of all in x and in y.
    fn largest(&self) -> [f64; 2] {
        let curves = self.curves.iter().filter(|(_, curves)| !curves.is_empty());
        let extents = curves.map(|(_, curves)| {
            let [lower, upper] = bounds(curves);
            [0, 1].map(|axis| upper[axis] - lower[axis])
        });
        extents.fold([0.1; 2], |most, own| {
            [0, 1].map(|axis| most[axis].max(own[axis]))
        })
    }
}

/// The corners of the box around some curves.
fn bounds(curves: &[Vec<[f64; 2]>]) -> [[f64; 2]; 2] {
    let points = curves.iter().flatten();
    points.fold(
        [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
        |[low, high], point| {
            let by = |choose: fn(f64, f64) -> f64, so_far: [f64; 2]| {
                [0, 1].map(|axis| choose(so_far[axis], point[axis]))
            };
            [by(f64::min, low), by(f64::max, high)]
        },
    )
}

fn draw_panel(
    page: &Page,
    frame: &Frame,
    panel: &Panel,
    arranged: &Arranged,
    outlines: &Outlines,
    size: f64,
) -> Result<(), FigureError> {
    let [x, y] = &frame.axes;
    let mut chart = ChartBuilder::on(page)
        .y_label_area_size(units(frame.rooms[0]))
        .x_label_area_size(units(frame.rooms[1]))
        .build_cartesian_2d(x.clone(), y.clone())?;
    let room = [
        frame.plot.width() * x.narrowest(),
        frame.plot.height() * y.narrowest(),
    ];
    let largest = outlines.largest();
    let pixels = FILLED * (room[0] / largest[0]).min(room[1] / largest[1]);
    let line = stroke(BLACK, 0.9 * line_weight(size));
    for row in 0..arranged.rows() {
        for column in 0..x.places.len() {
            let cell = arranged.cell(panel, column, row);
            let place = (x.places[column], y.places[row]);
            let Some(number) = cell.row else { continue };
            let Some(curves) = outlines.of(number).filter(|curves| !curves.is_empty()) else {
                // A point without a vesicle.
                let cross = marker((0, 0), Mark::Cross, size, line);
                chart.draw_series(once(EmptyElement::at(place) + cross))?;
                continue;
            };
            let [lower, upper] = bounds(curves);
            let center = [0, 1].map(|axis| 0.5 * (lower[axis] + upper[axis]));
            let colour = cell.value.map_or(GREY, |value| arranged.scale.at(value));
            for curve in curves {
                let points: Vec<(i32, i32)> = curve
                    .iter()
                    .map(|point| {
                        let [dx, dy] = [0, 1].map(|axis| pixels * (point[axis] - center[axis]));
                        (units(dx), units(-dy))
                    })
                    .collect();
                let filled = Polygon::new(points.clone(), colour.filled()).into_dyn();
                chart.draw_series(once(EmptyElement::at(place) + filled))?;
                let outline = PathElement::new(points, line).into_dyn();
                chart.draw_series(once(EmptyElement::at(place) + outline))?;
            }
        }
    }
    let thin = stroke(BLACK, 0.8 * line_weight(size));
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh()
        .axis_style(thin)
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
        .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
        .x_desc(Label::text(&arranged.x.key));
    match &arranged.y {
        Some(_) => mesh.draw()?,
        None => mesh.disable_y_axis().draw()?,
    }
    let (right, top) = (x.edges[x.edges.len() - 1], y.edges[y.edges.len() - 1]);
    let sides = [(x.edges[0], top), (right, top), (right, y.edges[0])];
    chart.draw_series(once(PathElement::new(sides, thin)))?;
    if arranged.y.is_none() {
        let left = [(x.edges[0], y.edges[0]), (x.edges[0], top)];
        chart.draw_series(once(PathElement::new(left, thin)))?;
    }
    Ok(())
}
