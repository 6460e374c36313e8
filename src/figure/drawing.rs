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
    /// Draws a line through points.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: f64, colour: Colour) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line {
                points,
                width,
                colour,
            });
        }
    }

    /// Fills a polygon.
    pub fn polygon(&mut self, points: Vec<[f64; 2]>, colour: Colour) {
        let curves = vec![points];
        self.shapes.push(Shape::Area { curves, colour });
    }

    /// Writes a label.
    pub fn label(&mut self, label: &Label, size: f64, at: [f64; 2], across: Across, along: Along) {
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
