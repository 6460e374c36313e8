//! `[pull]`.

use super::Rules;
use crate::scene::nodal_file::NodalKey;
use crate::scene::scalar_field::ScalarField;

const POTENTIAL: NodalKey = NodalKey::scalar("pull.potential", "pull.txt");

table! {
    /// A pull on the membrane, E = −∫ φ U: the vesicle is drawn to where U is large.
    pub struct Pull {
        /// U(x).
        potential: ScalarField, POTENTIAL;
    }
}

impl Rules for Pull {}
