//! What plotters does not have among its elements: a field in colour, an arrow, a star.

use super::FigureError;
use super::canvas::{Done, Drawing, Image, Rectangle, in_pixels, units};
use plotters::element::{Circle, Cross, DynElement, IntoDynElement, Polygon};
use plotters::element::{Drawable, PointCollection};
use plotters::style::ShapeStyle;
use plotters_backend::{BackendCoord, DrawingBackend, DrawingErrorKind};

/// What a function draws between two places of a chart.
pub(super) struct Between<F> {
    places: [(f64, f64); 2],
    draw: F,
}

impl<F: Fn([BackendCoord; 2], &mut Drawing) -> Done> Between<F> {
    pub fn new(places: [(f64, f64); 2], draw: F) -> Self {
        Between { places, draw }
    }
}

impl<'a, F> PointCollection<'a, (f64, f64)> for &'a Between<F> {
    type Point = &'a (f64, f64);
    type IntoIter = &'a [(f64, f64); 2];

    fn point_iter(self) -> Self::IntoIter {
        &self.places
    }
}

impl<F> Drawable<&mut Drawing> for Between<F>
where
    F: Fn([BackendCoord; 2], &mut Drawing) -> Done,
{
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        mut places: I,
        drawing: &mut &mut Drawing,
        _: (u32, u32),
    ) -> Done {
        match (places.next(), places.next()) {
            (Some(a), Some(b)) => (self.draw)([a, b], drawing),
            _ => Ok(()),
        }
    }
}

/// Colours on the rectangle that has these corners: `image` makes them for its pixels.
pub(super) fn raster<F: Fn(Rectangle) -> Result<Image, FigureError>>(
    corners: [(f64, f64); 2],
    image: F,
) -> Between<impl Fn([BackendCoord; 2], &mut Drawing) -> Done> {
    Between::new(corners, move |[a, b], drawing| {
        let corner = [a.0.min(b.0), a.1.min(b.1)].map(in_pixels);
        let size = [a.0.abs_diff(b.0), a.1.abs_diff(b.1)].map(in_pixels);
        let place = Rectangle::new(corner, size).on_pixels();
        drawing
            .images
            .push(image(place).map_err(DrawingErrorKind::DrawingError)?);
        Ok(())
    })
}

/// An arrow from one place to another.
pub(super) fn arrow(
    ends: [(f64, f64); 2],
    style: ShapeStyle,
) -> Between<impl Fn([BackendCoord; 2], &mut Drawing) -> Done> {
    Between::new(ends, move |[tail, tip], mut drawing| {
        let along = [tip.0 - tail.0, tip.1 - tail.1].map(|part| 0.5 * f64::from(part));
        let center = [tip.0 + tail.0, tip.1 + tail.1].map(|part| 0.5 * f64::from(part));
        // In halves of the length: along the arrow from its middle, and to its left.
        let at = |forward: f64, aside: f64| {
            let x = center[0] + forward * along[0] - aside * along[1];
            let y = center[1] + forward * along[1] + aside * along[0];
            (x.round() as i32, y.round() as i32)
        };
        let head = 0.95;
        let barb = 0.4 * head;
        let corners = [
            tip,
            at(1.0 - head, barb),
            at(1.0 - 0.75 * head, 0.0),
            at(1.0 - head, -barb),
        ];
        drawing.draw_path([tail, at(1.0 - 0.7 * head, 0.0)], &style)?;
        drawing.fill_polygon(corners, &style)
    })
}

/// What stands at a point of a diagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Disc,
    Square,
    Star,
    Cross,
}

/// A mark at a place, beside text of this size in pixels.
pub(super) fn marker<'a>(
    (x, y): BackendCoord,
    mark: Mark,
    size: f64,
    style: ShapeStyle,
) -> DynElement<'static, &'a mut Drawing, BackendCoord> {
    let half = units(0.3 * size);
    match mark {
        Mark::Disc => Circle::new((x, y), half, style).into_dyn(),
        Mark::Square => {
            let corners = [(x - half, y - half), (x + half, y + half)];
            plotters::element::Rectangle::new(corners, style).into_dyn()
        }
        Mark::Star => {
            let corner = |number: usize| {
                let angle = std::f64::consts::TAU * number as f64 / 10.0;
                let radius = size * [0.55, 0.23][number % 2];
                (
                    x + units(radius * angle.sin()),
                    y - units(radius * angle.cos()),
                )
            };
            Polygon::new((0..10).map(corner).collect::<Vec<_>>(), style).into_dyn()
        }
        Mark::Cross => Cross::new((x, y), units(0.35 * size), style).into_dyn(),
    }
}
