//! What a picture consists of, before it is a file.

use super::colour::Colour;
use super::text::{Across, Along, Label, set_label};

/// A rectangle in a picture. y points down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rectangle {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Its outline, closed.
    pub fn corners(&self) -> [[f64; 2]; 5] {
        let Rectangle {
            left,
            top,
            right,
            bottom,
        } = *self;
        let first = [left, top];
        [first, [right, top], [right, bottom], [left, bottom], first]
    }

    /// With each side on the nearest boundary between pixels.
    pub fn on_pixels(&self) -> Rectangle {
        Rectangle {
            left: self.left.round(),
            top: self.top.round(),
            right: self.right.round(),
            bottom: self.bottom.round(),
        }
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
    pub cells: Vec<Colour>,
}

/// Something drawn with one colour.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// A line through points.
    Line {
        points: Vec<[f64; 2]>,
        width: f64,
        colour: Colour,
    },
    /// What closed curves enclose (where they wind around a point at all).
    Area {
        curves: Vec<Vec<[f64; 2]>>,
        colour: Colour,
    },
}

/// A text and the frame that it takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedText {
    pub text: String,
    pub frame: Rectangle,
}

/// The greatest coordinate: farther away nothing shows, and what it is drawn with may overflow.
const FARTHEST: f64 = 1e6;

/// Whether a point is in the picture or near it: numbers that are no place are kept out here, whatever
/// they came from.
fn is_somewhere(point: &[f64; 2]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= FARTHEST)
}

/// A picture: images, and over them shapes, the later over the earlier. Lengths are in pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Drawing {
    pub width: u32,
    pub height: u32,
    pub images: Vec<Image>,
    pub shapes: Vec<Shape>,
    /// Every text again, for tests and for readers of an SVG.
    pub texts: Vec<PlacedText>,
}

impl Drawing {
    /// Draws a line through points; it has a gap where a point is nowhere.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: f64, colour: Colour) {
        if points.iter().all(is_somewhere) {
            return self.piece(points, width, colour);
        }
        for piece in points.split(|point| !is_somewhere(point)) {
            self.piece(piece.to_vec(), width, colour);
        }
    }

    fn piece(&mut self, points: Vec<[f64; 2]>, width: f64, colour: Colour) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line {
                points,
                width,
                colour,
            });
        }
    }

    /// Fills a polygon, unless one of its corners is nowhere.
    pub fn polygon(&mut self, points: Vec<[f64; 2]>, colour: Colour) {
        if points.iter().all(is_somewhere) {
            let curves = vec![points];
            self.shapes.push(Shape::Area { curves, colour });
        }
    }

    /// Writes a label, unless its place is nowhere.
    pub fn label(&mut self, label: &Label, size: f64, at: [f64; 2], across: Across, along: Along) {
        if !is_somewhere(&at) {
            return;
        }
        let (frame, curves) = set_label(label, size, at, across, along);
        let text = label.plain();
        if curves.is_empty() {
            return;
        }
        let colour = Colour::BLACK;
        self.shapes.push(Shape::Area { curves, colour });
        self.texts.push(PlacedText { text, frame });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nowhere_is_not_drawn() {
        let mut drawing = Drawing::default();
        let at = |x: f64| [x, 1.0];
        for nowhere in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            let points = [0.0, 1.0, nowhere, 2.0, nowhere, 3.0, 4.0, 5.0].map(at);
            drawing.shapes.clear();
            drawing.line(points.to_vec(), 1.0, Colour::BLACK);
            let lines = drawing.shapes.iter().map(|shape| match shape {
                Shape::Line { points, .. } => points.clone(),
                Shape::Area { .. } => panic!("no area was drawn"),
            });
            let expected = [vec![at(0.0), at(1.0)], [3.0, 4.0, 5.0].map(at).to_vec()];
            assert_eq!(lines.collect::<Vec<_>>(), expected);
            drawing.polygon(points.to_vec(), Colour::BLACK);
            let (left, top) = (Across::Left, Along::Top);
            drawing.label(&Label::text("a"), 9.0, at(nowhere), left, top);
            assert_eq!((drawing.shapes.len(), drawing.texts.len()), (2, 0));
        }
    }
}
