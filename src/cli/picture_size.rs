//! How large figures are drawn.

use crate::figure::{FigureOptions, LARGEST_WIDTH, LEAST_WIDTH};
use std::fmt;

/// The size of each figure.
#[derive(Debug, clap::Args)]
pub(super) struct PictureSize {
    /// The width of each figure in pixels
    #[arg(long, value_name = "PX", default_value_t = 2000,
          value_parser = clap::value_parser!(u32).range(i64::from(LEAST_WIDTH)..=i64::from(LARGEST_WIDTH)))]
    width: u32,

    /// The resolution in dots an inch, for print
    #[arg(long, value_name = "N", default_value_t = 300,
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    dpi: u32,
}

impl PictureSize {
    /// Options of figures with this size, all else by default.
    pub(super) fn options(&self) -> FigureOptions {
        FigureOptions {
            width: self.width,
            dpi: self.dpi,
            ..FigureOptions::default()
        }
    }
}

/// As it is given on the command line.
impl fmt::Display for PictureSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--width {} --dpi {}", self.width, self.dpi)
    }
}
