//! What to simulate.

mod model;
mod stub;

pub use model::*;
pub use stub::*;
