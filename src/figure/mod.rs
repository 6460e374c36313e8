//! The pictures of a report, as PNG and SVG, with their data as CSV and VTU.
//!
//! plotters draws the charts, on a back end that PNG and SVG have in common (`canvas`). Letters are outlines
//! of a font in the program, so that a picture is the same on every machine. φ = 0 is the exact zero set of the P1 function, triangle by triangle; the colour of a
//! pixel is that of the P1 function at the pixel's centre.
//!
//! Every PNG holds its physical size and, in text chunks, what it takes to make it again: the
//! complete scene, step, t, the version and the command; every SVG has the same in its metadata.
//!
//! Nothing here knows a thread: call it where neither the solver nor the screen has to wait.

mod axes;
mod canvas;
mod colour;
mod curves;
mod data;
mod elements;
mod error;
mod legend;
mod needs;
mod number;
mod outline;
mod panel;
mod pixels;
mod png;
mod provenance;
mod sampling;
mod save;
mod scalars;
mod strip;
mod svg;
mod sweep;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod view;
mod work_precision;

use crate::geometry::{BoundingBox, crop, widened};
pub use colour::ColourMap;
pub use data::{Field, RunData, Snapshot, View};
pub use error::FigureError;
pub(crate) use number::round_ticks;
pub use save::{check_free, save_set, save_shape, save_view};
pub(crate) use sweep::Arranged;
pub use sweep::{SweepFigureError, SweepView, save_sweep};
pub use work_precision::save_study;

/// The least width of a figure, in pixels: below it there is no room for its numbers.
pub const LEAST_WIDTH: u32 = 400;
/// The largest width of a figure, in pixels.
pub const LARGEST_WIDTH: u32 = 10_000;

/// The colours of |d| reach at least so far to both sides of 1: what the scheme itself leaves of a
/// departure is no pattern to look at.
pub const LEAST_DEPARTURE: f64 = 0.1;

const MILLIMETRES_AN_INCH: f64 = 25.4;

/// The width of a set's figures, in sizes of their text: at 170 mm, two columns of a journal, the
/// text has 7.5 points.
const TEXT_SIZES_A_WIDTH: f64 = 64.0;
/// The width of a view, in sizes of its text.
const VIEW_TEXT_SIZES_A_WIDTH: f64 = 38.0;
/// Smaller text cannot be read on a screen.
const LEAST_TEXT_SIZE: f64 = 9.0;

fn text_size(width: u32, sizes_a_width: f64) -> f64 {
    (f64::from(width) / sizes_a_width).max(LEAST_TEXT_SIZE)
}

/// How the director is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Director {
    /// As arrows.
    #[default]
    Arrows,
    /// As strokes without heads: d and −d mean the same physics.
    Strokes,
    /// Not at all.
    Off,
}

/// How much of the domain is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Zoom {
    /// The vesicle, wherever it is at the times that are shown, with a margin.
    #[default]
    Fit,
    /// All of it.
    Domain,
    /// The middle of the vesicle, twice as large as with `Fit`.
    Double,
}

impl Zoom {
    /// The part of a domain that is shown where there is room of an aspect (width by height). `vesicle` is the
    /// rectangle around the vesicle at all times.
    pub fn region(
        self,
        domain: &BoundingBox,
        vesicle: Option<&BoundingBox>,
        aspect: f64,
    ) -> BoundingBox {
        let Some(vesicle) = vesicle.filter(|_| self != Self::Domain) else {
            return *domain;
        };
        let fitted = widened(&crop(domain, vesicle), domain, aspect);
        if self == Self::Fit {
            return fitted;
        }
        let (center, quarter) = (vesicle.center(), 0.25 * fitted.extent());
        BoundingBox {
            lower: center - quarter,
            upper: center + quarter,
        }
    }
}

/// What to do where a file of a figure's name is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Take another name: `…-2`, `…-3`, ….
    #[default]
    Number,
    /// Save nothing.
    Refuse,
    /// Replace the file.
    Replace,
}

/// How figures look and where they may go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FigureOptions {
    /// In pixels, from `LEAST_WIDTH` to `LARGEST_WIDTH`. The height follows.
    pub width: u32,
    /// Dots an inch: with the width, how large it prints.
    pub dpi: u32,
    /// How the director is drawn.
    pub director: Director,
    /// How much of the domain is shown.
    pub zoom: Zoom,
    /// The colours of the fields.
    pub colours: ColourMap,
    /// Whether the time axis of curves is logarithmic.
    pub logarithmic_time: bool,
    /// Whether the letters of an SVG stay text that can be edited, and need its font; else they are outlines.
    pub svg_text: bool,
    /// What to do where a file of a figure's name is there.
    pub existing: Existing,
    /// Whether a set has the snapshots as VTU files and the whole history as well.
    pub fields: bool,
    /// At how many angles about the axis the surface of a body of rotation is saved; `None`: it is not.
    pub revolve: Option<u32>,
}

impl Default for FigureOptions {
    /// 2000 pixels at 300 dots an inch: 169 mm, two columns of a journal.
    fn default() -> Self {
        FigureOptions {
            width: 2000,
            dpi: 300,
            director: Director::default(),
            zoom: Zoom::default(),
            logarithmic_time: false,
            svg_text: false,
            colours: ColourMap::default(),
            existing: Existing::default(),
            fields: false,
            revolve: None,
        }
    }
}

impl FigureOptions {
    /// For a view: 1200 pixels at 300 dots an inch, 102 mm.
    pub fn view() -> Self {
        FigureOptions {
            width: 1200,
            ..FigureOptions::default()
        }
    }

    /// # Errors
    /// [`FigureError::Width`], [`FigureError::Resolution`].
    fn check(&self) -> Result<(), FigureError> {
        let FigureOptions { width, dpi, .. } = *self;
        if !(LEAST_WIDTH..=LARGEST_WIDTH).contains(&width) {
            return Err(FigureError::Width { width });
        }
        if !(1..=10_000).contains(&dpi) {
            return Err(FigureError::Resolution { dpi });
        }
        Ok(())
    }
}
