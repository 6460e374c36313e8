//! `[domain]`.

use super::Rules;
use crate::scene::parameter::choice;

table! {
    /// The domain Ω: the unit square, or the polygon that a mesh from a file covers.
    pub struct Domain {
        /// What holds for φ at ∂Ω.
        boundary: Boundary = Boundary::Natural;
    }
}

impl Rules for Domain {}

choice! {
    /// The condition on φ at ∂Ω.
    pub enum Boundary {
        /// ∇φ·n = ∇μ·n = 0, as the weak form (3.16) has it.
        Natural = "natural",
        /// φ = −1 on ∂Ω, as (2.13) states.
        Clamped = "clamped",
    }
}
