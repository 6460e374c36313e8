//! The memory that a picture takes, asked for before it is drawn.
//!
//! What is measured is the most that the heap held while a figure was saved, beyond what it held before
//! (`cargo test --lib figure::tests::memory -- --nocapture`), in MB (10⁶ bytes):
//!
//! | figure | pixels | PNG | SVG | foreseen |
//! |---|---|---|---|---|
//! | strip of five, arrows | 400 × 274 | 0.89 | 3.78 | 7.3 |
//! | view of φ | 400 × 383 | 1.07 | 3.45 | 6.2 |
//! | strip of five, arrows | 2000 × 480 | 5.22 | 5.97 | 11.1 |
//!
//! Beyond that the drawing itself takes three bytes for each cell of its images, for which [`colours`] asks.
//! Tables with a row a node are written as they are made.

use super::FigureError;
use super::canvas::Drawing;
use crate::simulation::Claim;
use plotters::style::RGBColor;

/// A pixel of a picture while it is drawn.
const PIXEL: u64 = 4;
/// And what its PNG may take of it: pictures of fields are the least compressible.
const ENCODED: u64 = 1;
/// A cell of the largest image while that is encoded for an SVG,
const CELL: f64 = 3.0;
/// and one of any image there, in letters: fields are smooth, and half a byte is left of a cell.
const CELL_IN_LETTERS: f64 = 1.5;
/// A point of a shape in an SVG.
const POINT: u64 = 64;
/// Whatever else: tables of the encoder, letters, the words of where the picture comes from.
const BESIDES: u64 = 2 << 20;

/// Sets aside what the colours of a field take.
///
/// # Errors
/// [`FigureError::Memory`].
pub(super) fn colours([columns, rows]: [usize; 2]) -> Result<Claim, FigureError> {
    let bytes = columns * rows * size_of::<RGBColor>();
    claim(
        format!("a field in colour, {columns} \u{d7} {rows}"),
        bytes as u64,
    )
}

/// Sets aside what it takes to make a drawing a file.
///
/// # Errors
/// [`FigureError::Memory`].
pub(super) fn picture(drawing: &Drawing) -> Result<Claim, FigureError> {
    let (width, height) = (drawing.width, drawing.height);
    let what = format!("a picture of {width} \u{d7} {height} px");
    claim(what, bytes_of_picture(drawing))
}

/// What it takes to make a drawing a PNG and then an SVG, beyond the drawing itself.
pub(super) fn bytes_of_picture(drawing: &Drawing) -> u64 {
    let pixels = u64::from(drawing.width) * u64::from(drawing.height);
    let cells = drawing.images.iter().map(|image| image.cells.len());
    let (largest, all) = (cells.clone().max().unwrap_or(0), cells.sum::<usize>());
    let points: usize = drawing.shapes.iter().map(|it| it.path.points().len()).sum();
    let images = CELL * largest as f64 + CELL_IN_LETTERS * all as f64;
    let svg = images as u64 + POINT * points as u64;
    BESIDES + svg.max((PIXEL + ENCODED) * pixels)
}

fn claim(what: String, bytes: u64) -> Result<Claim, FigureError> {
    Claim::of(bytes).map_err(|shortage| FigureError::Memory { what, shortage })
}
