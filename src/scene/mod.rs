//! What to simulate.

mod angle;
mod director_field;
mod model;
mod outline;

pub use director_field::{initial_director, random_phase};
pub use model::*;
pub use outline::{
    BoundingBox, OutlineDistance, SignedDistance, phase_profile, union_distance, wall_distance,
};
