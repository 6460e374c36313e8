//! `[pull]`.

use super::Rules;
use crate::scene::nodal_file::NodalKey;
use crate::scene::scalar_field::ScalarField;

const POTENTIAL: NodalKey = NodalKey::scalar("pull.potential", "pull.txt");

table! {
    /// A pull on the membrane, E = −∫ φ U: the vesicle is drawn to where U is large.
    pub struct Pull {
        /// U(x).
        @tunable potential: ScalarField, POTENTIAL;
    }
}

/// No pull: what a change of the potential starts from where the scene has none.
impl Default for Pull {
    fn default() -> Self {
        Self {
            potential: ScalarField::Constant(0.0),
        }
    }
}

impl Rules for Pull {}
