//! Runs about runs.

mod effects;
mod memory;
mod table;

pub use effects::{Cost, Plan, Price, Prices, Progress, prices};
pub use memory::CountingAllocator;
pub use table::prices_table;
