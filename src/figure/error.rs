//! Why a figure cannot be made.

use super::{LARGEST_WIDTH, LEAST_WIDTH};
use crate::record::RecordError;
use crate::simulation::Shortage;
use std::path::PathBuf;

/// A figure could not be made or saved.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The width is not one that figures can have.
    #[error("a figure cannot be {width} px wide: from {LEAST_WIDTH} to {LARGEST_WIDTH}")]
    Width {
        /// In pixels.
        width: u32,
    },
    /// The resolution is none.
    #[error("a figure cannot have a resolution of {dpi} dots an inch: from 1 to 10000")]
    Resolution {
        /// In dots an inch.
        dpi: u32,
    },
    /// A file of the name is there.
    #[error("{} is there already: give another folder, or --force to replace it", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
    },
    /// There is nothing to draw.
    #[error("there is nothing to draw: no run has any data yet")]
    Nothing,
    /// The fields do not fit the mesh.
    #[error(
        "{name} at t = {t:e} cannot be drawn: it has {found} values of {field}, its mesh has \
         {nodes} nodes"
    )]
    Mismatch {
        /// The run.
        name: String,
        /// The time.
        t: f64,
        /// Which field.
        field: &'static str,
        /// How many values it has.
        found: usize,
        /// How many it should have.
        nodes: usize,
    },
    /// The picture needs more memory than there is.
    #[error("{what} needs {shortage}: draw it smaller, or where there is more memory")]
    Memory {
        /// What, in words.
        what: String,
        /// How much it needs, and what there is.
        shortage: Shortage,
    },
    /// The picture is larger than any can be.
    #[error(
        "a picture of {width} × {height} px is too large: lower the width, or draw fewer scenes"
    )]
    TooLarge {
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
    },
    /// The drawing library gave up.
    #[error("the picture cannot be drawn: {0}")]
    Draw(String),
    /// The picture cannot be made a PNG.
    #[error("the picture cannot be encoded: {0}")]
    Encode(#[from] png::EncodingError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] RecordError),
}

/// Of writing to a string, which does not fail.
impl From<std::fmt::Error> for FigureError {
    fn from(error: std::fmt::Error) -> Self {
        FigureError::Draw(error.to_string())
    }
}
