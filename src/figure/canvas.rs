//! The back end of plotters that every figure is drawn on.
//!
//! It records what plotters draws; `pixels` and `svg` make it a file. So both files show the same, text is
//! outlines of a font in the program, and what is drawn has its place to a fraction of a pixel: plotters
//! counts in whole units, of which a pixel has [`UNITS`] here. plotters' own back ends have whole pixels,
//! and the fonts of the machine.

use super::FigureError;
use super::text::{Label, TextPiece, line_height};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::PathElement;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, FontDesc, FontFamily, FontStyle, RGBColor, ShapeStyle, TextStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::iter::once;
use tiny_skia::{Path, PathBuilder};

/// A pixel has so many units of plotters.
pub(super) const UNITS: f64 = 64.0;

/// A length in pixels in units of plotters. The cast saturates.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

/// A length in units in pixels.
pub(super) fn in_pixels(units: impl Into<f64>) -> f64 {
    units.into() / UNITS
}

/// A rectangle in a picture, in pixels. y points down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rectangle {
    /// From its upper left corner down.
    pub fn new([left, top]: [f64; 2], [width, height]: [f64; 2]) -> Rectangle {
        let (right, bottom) = (left + width, top + height);
        Rectangle {
            left,
            top,
            right,
            bottom,
        }
    }

    /// With room at its left, at its right and below.
    pub fn with_room(&self, [left, right, below]: [f64; 3]) -> Rectangle {
        let corner = [self.left - left, self.top];
        let size = [left + self.width() + right, self.height() + below];
        Rectangle::new(corner, size)
    }

    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// With each side on the nearest boundary between pixels.
    pub fn on_pixels(&self) -> Rectangle {
        let corner = [self.left, self.top].map(f64::round);
        let size = [
            self.right.round() - corner[0],
            self.bottom.round() - corner[1],
        ];
        Rectangle::new(corner, size)
    }
}

/// A picture of colours, each cell of `size` as large as another, row by row from above.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Image {
    /// Its place, on boundaries between pixels.
    pub place: Rectangle,
    /// Columns and rows.
    pub size: [usize; 2],
    /// The colours.
    pub cells: Vec<RGBColor>,
}

/// Something drawn with one colour.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    pub path: Path,
    /// The width of a line along the path, with round caps and joins; without, what the path winds around
    /// is filled.
    pub stroke: Option<f32>,
    pub colour: RGBColor,
    /// Which of the picture's texts the path is the outlines of.
    pub text: Option<usize>,
}

/// A text and the frame that it takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedText {
    pub text: String,
    pub frame: Rectangle,
    /// The same in pieces of one size.
    pub pieces: Vec<TextPiece>,
}

/// A picture: images, and over them shapes, the later over the earlier. Lengths are in pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Drawing {
    pub width: u32,
    pub height: u32,
    pub images: Vec<Image>,
    pub shapes: Vec<Shape>,
    /// Every text again, for tests, for readers of an SVG, and for one whose text can be edited.
    pub texts: Vec<PlacedText>,
}

/// While a picture is drawn there is so much room below, in pixels.
const OPEN: u32 = 1 << 20;

impl Drawing {
    /// A picture of this width, and as high as `draw` says when it is done.
    ///
    /// # Errors
    /// Those of `draw`.
    pub fn compose(
        width: u32,
        draw: impl FnOnce(&Page) -> Result<f64, FigureError>,
    ) -> Result<Drawing, FigureError> {
        let mut drawing = Drawing {
            width,
            height: OPEN,
            ..Drawing::default()
        };
        let bottom = draw(&(&mut drawing).into_drawing_area())?;
        drawing.height = bottom.ceil() as u32;
        Ok(drawing)
    }

    fn push(&mut self, path: Option<Path>, stroke: Option<u32>, colour: BackendColor) {
        self.push_text(path, stroke, colour, None);
    }

    fn push_text(
        &mut self,
        path: Option<Path>,
        stroke: Option<u32>,
        colour: BackendColor,
        text: Option<usize>,
    ) {
        let (r, g, b) = colour.rgb;
        // What is not wholly transparent is opaque here.
        if let Some(path) = path.filter(|_| colour.alpha > 0.0) {
            self.shapes.push(Shape {
                path,
                stroke: stroke.map(|width| in_pixels(width) as f32),
                colour: RGBColor(r, g, b),
                text,
            });
        }
    }
}

fn path(points: impl IntoIterator<Item = BackendCoord>, is_closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (x, y) in points {
        let (x, y) = (in_pixels(x) as f32, in_pixels(y) as f32);
        match path.is_empty() {
            true => path.move_to(x, y),
            false => path.line_to(x, y),
        }
    }
    if is_closed {
        path.close();
    }
    path.finish()
}

/// What a back end of plotters gives for drawing.
pub(super) type Done = Result<(), DrawingErrorKind<FigureError>>;

impl DrawingBackend for &mut Drawing {
    type ErrorType = FigureError;

    fn get_size(&self) -> (u32, u32) {
        (self.width * UNITS as u32, self.height * UNITS as u32)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        let first = (left, top);
        let corners = [first, (right, top), (right, bottom), (left, bottom), first];
        match fill {
            true => self.fill_polygon(corners, style),
            false => self.draw_path(corners, style),
        }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        points: I,
        style: &S,
    ) -> Done {
        let points: Vec<BackendCoord> = points.into_iter().collect();
        let is_closed = points.len() > 2 && points.first() == points.last();
        let stroke = Some(style.stroke_width());
        self.push(path(points, is_closed), stroke, style.color());
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        let [x, y, radius] = [in_pixels(x), in_pixels(y), in_pixels(radius)].map(|it| it as f32);
        let circle = PathBuilder::from_circle(x, y, radius);
        let stroke = (!fill).then(|| style.stroke_width());
        self.push(circle, stroke, style.color());
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        points: I,
        style: &S,
    ) -> Done {
        self.push(path(points, true), None, style.color());
        Ok(())
    }

    /// A label; of the style its size, its colour and its anchor count.
    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Done {
        let label = Label::of_string(text);
        let at = [x, y].map(in_pixels);
        let size = style.size() / UNITS;
        let (frame, outlines) = label.set(size, at, style.anchor());
        let number = outlines.is_some().then_some(self.texts.len());
        if number.is_some() {
            self.texts.push(PlacedText {
                text: label.plain(),
                frame,
                pieces: label.pieces(size, frame),
            });
        }
        self.push_text(outlines, None, style.color(), number);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<FigureError>> {
        let width = Label::of_string(text).width(style.size());
        Ok((width.ceil() as u32, line_height(style.size()).ceil() as u32))
    }
}

impl From<DrawingAreaErrorKind<FigureError>> for FigureError {
    fn from(error: DrawingAreaErrorKind<FigureError>) -> FigureError {
        match error {
            DrawingAreaErrorKind::BackendError(DrawingErrorKind::DrawingError(error)) => error,
            other => FigureError::Draw(other.to_string()),
        }
    }
}

/// The whole of a picture, or a part of it, to be drawn on.
pub(super) type Page<'a> = DrawingArea<&'a mut Drawing, Shift>;

/// A line of this colour, so many pixels wide.
pub(super) fn stroke(colour: RGBColor, width: f64) -> ShapeStyle {
    ShapeStyle::from(colour).stroke_width(units(width).max(1) as u32)
}

/// Black text of this size in pixels.
pub(super) fn font(size: f64) -> TextStyle<'static> {
    let family = FontFamily::Name("DejaVu Sans");
    FontDesc::new(family, size * UNITS, FontStyle::Normal).into()
}

/// The greatest coordinate, in pixels: farther away nothing shows.
const FARTHEST: f64 = 1e6;

/// The largest number in a chart: the span of an axis is one yet.
pub(super) const LARGEST: f64 = 1e300;

/// Whether a point is in the picture or near it. plotters makes a place of any number, of NaN too: numbers
/// that are no place are kept out here, whatever they came from.
fn is_somewhere(point: &[f64; 2]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= FARTHEST)
}

/// The pieces of a curve in a chart between the points that are no place there.
pub(super) fn pieces(
    points: impl IntoIterator<Item = (f64, f64)>,
) -> impl Iterator<Item = Vec<(f64, f64)>> {
    let mut points = points.into_iter();
    let is_place = |(x, y): &(f64, f64)| x.abs() <= LARGEST && y.abs() <= LARGEST;
    std::iter::from_fn(move || {
        let first = points.by_ref().find(is_place)?;
        Some(
            once(first)
                .chain(points.by_ref().take_while(is_place))
                .collect(),
        )
    })
}

fn in_units([x, y]: [f64; 2]) -> BackendCoord {
    (units(x), units(y))
}

/// A part of a page.
pub(super) fn part<'a>(page: &Page<'a>, place: Rectangle) -> Page<'a> {
    let corner = (units(place.left), units(place.top));
    let size = (
        units(place.right) - corner.0,
        units(place.bottom) - corner.1,
    );
    page.clone().shrink(corner, size)
}

/// Draws a black line through points; it has a gap where a point is nowhere.
pub(super) fn draw_line(page: &Page, points: &[[f64; 2]], width: f64) -> Result<(), FigureError> {
    for piece in points.split(|point| !is_somewhere(point)) {
        let piece: Vec<_> = piece.iter().copied().map(in_units).collect();
        page.draw(&PathElement::new(piece, stroke(BLACK, width)))?;
    }
    Ok(())
}

/// Writes a label, unless its place is nowhere.
pub(super) fn write_label(
    page: &Page,
    label: &Label,
    size: f64,
    at: [f64; 2],
    (h_pos, v_pos): (HPos, VPos),
) -> Result<(), FigureError> {
    if is_somewhere(&at) {
        let style = font(size).pos(Pos::new(h_pos, v_pos));
        page.draw_text(label.as_str(), &style, in_units(at))?;
    }
    Ok(())
}

/// Writes a label that begins at a place, in lines that are no wider than `width`. Gives where it ends.
pub(super) fn write_paragraph(
    page: &Page,
    label: &Label,
    size: f64,
    [left, mut top]: [f64; 2],
    width: f64,
) -> Result<f64, FigureError> {
    for line in label.wrapped(size, width) {
        write_label(page, &line, size, [left, top], (HPos::Left, VPos::Top))?;
        top += line_height(size);
    }
    Ok(top)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiny_skia::Point;

    #[test]
    fn what_is_nowhere_is_not_drawn() {
        let at = |x: f64| [x, 1.0];
        for nowhere in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            let points = [0.0, 1.0, nowhere, 2.0, nowhere, 3.0, 4.0, 5.0].map(at);
            let drawing = Drawing::compose(9, |page| {
                draw_line(page, &points, 1.0)?;
                let place = (HPos::Left, VPos::Top);
                write_label(page, &Label::text("a"), 9.0, at(nowhere), place)?;
                Ok(9.0)
            });
            let drawing = drawing.expect("it is drawn");
            let lines = drawing.shapes.iter().map(|shape| shape.path.points());
            let at = |x: f32| Point::from_xy(x, 1.0);
            let expected = [vec![at(0.0), at(1.0)], [3.0, 4.0, 5.0].map(at).to_vec()];
            assert_eq!(lines.collect::<Vec<_>>(), expected);
            assert!(drawing.texts.is_empty());
        }
    }
}
