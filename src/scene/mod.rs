//! What to simulate.

mod angle;
mod director_field;
mod model;

pub use director_field::{initial_director, random_phase};
pub use model::*;
