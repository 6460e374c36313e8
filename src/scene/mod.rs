//! What to simulate.

mod model;

pub use model::*;
