//! A drawing as pixels.
//!
//! The canvas is tiny-skia's, driven through plotters. plotters' own bitmap has whole pixels for
//! coordinates, and leaves out what stands before each letter of a text.

use super::FigureError;
use super::drawing::{Drawing, Image};
use super::paint::{paint, units_a_pixel};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform,
};

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
    let units = units_a_pixel(drawing);
    let canvas = Canvas {
        pixmap: &mut pixmap,
        units,
    };
    paint(drawing, units, canvas).map_err(|error| FigureError::Draw(error.to_string()))?;
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
            pixel[..3].copy_from_slice(&cells[(2 * column + 1) * columns / (2 * across)].0);
        }
    }
}

struct Canvas<'a> {
    pixmap: &'a mut Pixmap,
    units: u32,
}

impl Canvas<'_> {
    fn path(&self, points: impl IntoIterator<Item = BackendCoord>, closed: bool) -> Option<Path> {
        let scale = 1.0 / self.units as f32;
        let mut builder = PathBuilder::new();
        for (number, (x, y)) in points.into_iter().enumerate() {
            let (x, y) = (x as f32 * scale, y as f32 * scale);
            match number {
                0 => builder.move_to(x, y),
                _ => builder.line_to(x, y),
            }
        }
        if closed {
            builder.close();
        }
        builder.finish()
    }
}

fn colour(colour: BackendColor) -> Paint<'static> {
    let (r, g, b) = colour.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (255.0 * colour.alpha).round() as u8);
    paint.anti_alias = true;
    paint
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        let (width, height) = (self.pixmap.width(), self.pixmap.height());
        (width * self.units, height * self.units)
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    /// A unit.
    fn draw_pixel(
        &mut self,
        (x, y): BackendCoord,
        style: BackendColor,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let scale = 1.0 / self.units as f32;
        let corner = (x as f32 * scale, y as f32 * scale);
        if let Some(rectangle) = Rect::from_xywh(corner.0, corner.1, scale, scale) {
            let place = Transform::identity();
            self.pixmap
                .fill_rect(rectangle, &colour(style), place, None);
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let stroke = Stroke {
            width: style.stroke_width() as f32 / self.units as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        let points: Vec<BackendCoord> = path.into_iter().collect();
        let closed = points.len() > 2 && points.first() == points.last();
        if let Some(path) = self.path(points, closed) {
            let paint = colour(style.color());
            self.pixmap
                .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        points: I,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        if let Some(path) = self.path(points, true) {
            let paint = colour(style.color());
            let place = Transform::identity();
            self.pixmap
                .fill_path(&path, &paint, FillRule::Winding, place, None);
        }
        Ok(())
    }
}
