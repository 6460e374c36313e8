//! `[membrane]`.

use super::Rules;
use crate::scene::nodal_file::NodalKey;
use crate::scene::reader::POSITIVE;
use crate::scene::scalar_field::ScalarField;

const CURVATURE: NodalKey = NodalKey::scalar(
    "membrane.spontaneous_curvature",
    "spontaneous_curvature.txt",
);

table! {
    /// The membrane and its bending, E_ben = ε/2 ∫ ω².
    pub struct Membrane {
        /// ε, the width of the interface.
        interface_width: f64 = 0.01, POSITIVE;
        /// γ_ben, the mobility of the membrane.
        @tunable mobility: f64 = 0.01, POSITIVE;
        /// The spontaneous curvature k(x).
        @tunable spontaneous_curvature: ScalarField = ScalarField::Constant(0.0), CURVATURE;
    }
}

impl Rules for Membrane {}
