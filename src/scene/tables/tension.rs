//! `[tension]`. (The example of the guide's page "Adding an effect".)

use super::Rules;
use crate::scene::reader::NOT_NEGATIVE;

table! {
    /// A line tension, E = ½ σ ∫ ∇φ·∇φ.
    #[derive(Copy)]
    pub struct Tension {
        /// σ.
        @tunable weight: f64 = 0.5, NOT_NEGATIVE;
    }
}

impl Rules for Tension {}
