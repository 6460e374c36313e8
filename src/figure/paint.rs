//! A drawing on a canvas of plotters: one code for pixels and for SVG.
//!
//! plotters counts in whole units. A canvas here has many units a pixel, so that lines and letters
//! stand where they were put.

use super::colour::Colour;
use super::drawing::{Drawing, Shape};
use plotters::prelude::{
    DrawingArea, DrawingAreaErrorKind, DrawingBackend, IntoDrawingArea, PathElement, Polygon,
    RGBColor, ShapeStyle,
};

/// A canvas is at least so many units wide.
const LEAST_UNITS: u32 = 40_000;

/// The units a pixel of a drawing.
pub(super) fn units_a_pixel(drawing: &Drawing) -> u32 {
    LEAST_UNITS.div_ceil(drawing.width.max(1))
}

/// Draws the shapes of a drawing, which has `units` units a pixel there.
pub(super) fn paint<B: DrawingBackend>(
    drawing: &Drawing,
    units: u32,
    canvas: B,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let area: DrawingArea<B, _> = canvas.into_drawing_area();
    let scale = f64::from(units);
    // A cast from f64 saturates.
    let on_canvas = |[x, y]: [f64; 2]| ((x * scale).round() as i32, (y * scale).round() as i32);
    for shape in &drawing.shapes {
        match shape {
            Shape::Line {
                points,
                width,
                colour,
            } => {
                let points: Vec<_> = points.iter().copied().map(on_canvas).collect();
                let width = (width * scale).round().max(1.0) as u32;
                area.draw(&PathElement::new(
                    points,
                    style(*colour).stroke_width(width),
                ))?;
            }
            Shape::Area { curves, colour } => {
                let points: Vec<_> = joined(curves).into_iter().map(on_canvas).collect();
                area.draw(&Polygon::new(points, style(*colour).filled()))?;
            }
        }
    }
    area.present()
}

fn style(Colour([r, g, b]): Colour) -> ShapeStyle {
    ShapeStyle::from(RGBColor(r, g, b))
}

/// Closed curves as one polygon, which is all that plotters fills: from each curve the pen goes back
/// to where the first began. Every such way is gone there and back, and encloses nothing.
fn joined(curves: &[Vec<[f64; 2]>]) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    let Some(&home) = curves.first().and_then(|curve| curve.first()) else {
        return points;
    };
    for curve in curves {
        points.extend_from_slice(curve);
        points.extend(curve.first());
        points.push(home);
    }
    points
}
