//! Runs about runs.

mod effects;
mod memory;

pub use effects::{Cost, Plan, Price, Prices, Progress, prices};
pub use memory::CountingAllocator;
