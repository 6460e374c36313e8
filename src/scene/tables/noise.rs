//! `[noise]`.

use super::Rules;
use crate::scene::parameter::{SEED, SEEDS};
use crate::scene::reader::NOT_NEGATIVE;

table! {
    /// Thermal noise on the director inside the vesicle.
    #[derive(Copy)]
    pub struct Noise {
        /// The temperature k_B T, in units of the energy.
        @tunable strength: f64 = 1e-3, NOT_NEGATIVE;
        /// Of the random numbers.
        seed: u64 = SEED, SEEDS;
    }
}

impl Rules for Noise {
    fn needs_director() -> bool {
        true
    }
}
