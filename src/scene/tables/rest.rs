//! `[rest]`.

use super::Rules;
use crate::scene::reader::POSITIVE;

table! {
    /// A run ends before its time when nothing moves any more: when the energy that is lost in a relaxation time is at most a part of the energy.
    #[derive(Copy)]
    pub struct Rest {
        /// The part: with 1e-6 the shape is at rest to about a thousandth of its size.
        tolerance: f64 = 1e-6, POSITIVE;
    }
}

impl Rules for Rest {}
