//! `[area]`.

use super::Rules;
use crate::scene::reader::POSITIVE;

table! {
    /// The penalty of the surface area, E_area = (B − β)²/(2η). Without it the area is free.
    #[derive(Copy)]
    pub struct Area {
        /// β as a fraction of B(φ⁰), the area at the start.
        @tunable target: f64 = 1.25, POSITIVE;
        /// η: the smaller, the more strictly the area is kept.
        @tunable penalty: f64 = 1e-3, POSITIVE;
    }
}

impl Rules for Area {}
