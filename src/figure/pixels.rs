//! A drawing as pixels.

use super::FigureError;
use super::canvas::{Drawing, Image};
use plotters::style::RGBColor;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Pixmap, Stroke, Transform};

/// The pixels of a drawing, row by row from above: red, green, blue.
///
/// # Errors
/// [`FigureError::TooLarge`].
pub(super) fn pixels(drawing: &Drawing) -> Result<Vec<u8>, FigureError> {
    let (width, height) = (drawing.width, drawing.height);
    let too_large = FigureError::TooLarge { width, height };
    let mut pixmap = Pixmap::new(width, height).ok_or(too_large)?;
    pixmap.fill(Color::WHITE);
    for image in &drawing.images {
        put(image, &mut pixmap);
    }
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    let place = Transform::identity();
    for shape in &drawing.shapes {
        let RGBColor(r, g, b) = shape.colour;
        paint.set_color_rgba8(r, g, b, u8::MAX);
        let Some(width) = shape.stroke else {
            pixmap.fill_path(&shape.path, &paint, FillRule::Winding, place, None);
            continue;
        };
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        pixmap.stroke_path(&shape.path, &paint, &stroke, place, None);
    }
    // Nothing is transparent on white. In place: a picture is large.
    let mut pixels = pixmap.take();
    let count = pixels.len() / 4;
    for number in 1..count {
        pixels.copy_within(4 * number..4 * number + 3, 3 * number);
    }
    pixels.truncate(3 * count);
    Ok(pixels)
}

/// Each pixel of the image's place takes the colour of the cell that its centre is in.
fn put(image: &Image, pixmap: &mut Pixmap) {
    let [columns, rows] = image.size;
    let place = image.place;
    let stride = pixmap.width() as usize;
    let (across, down) = (place.width() as usize, place.height() as usize);
    let (left, top) = (place.left as usize, place.top as usize);
    for row in 0..down.min((pixmap.height() as usize).saturating_sub(top)) {
        let cells = &image.cells[(2 * row + 1) * rows / (2 * down) * columns..][..columns];
        let line = &mut pixmap.data_mut()[4 * ((top + row) * stride + left)..];
        let visible = across.min(stride.saturating_sub(left));
        for (column, pixel) in line.chunks_exact_mut(4).take(visible).enumerate() {
            let RGBColor(r, g, b) = cells[(2 * column + 1) * columns / (2 * across)];
            pixel[..3].copy_from_slice(&[r, g, b]);
        }
    }
}
