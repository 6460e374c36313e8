//! Runs about runs: what accuracy costs in time, what each effect costs, and what a run will cost before
//! it is begun.

mod advice;
mod chart;
mod choice;
mod clock;
mod distance;
mod effects;
mod error_size;
mod evaluation;
mod finished;
mod ladder;
mod measure;
pub(crate) mod memory;
mod plan;
mod price;
mod report;
mod suggestion;
mod table;
#[cfg(test)]
mod tests;

pub use advice::{Advice, Knob};
pub use chart::chart;
pub use choice::{Choice, MeshKind, Pace};
pub use distance::Errors;
pub use effects::{Cost, Plan, Price, Prices, Progress, prices};
pub use error_size::ErrorSize;
pub use finished::{FinishedRun, FinishedRunError, FinishedRuns};
pub use ladder::{Budget, StudyError, StudyNews, study};
pub use memory::CountingAllocator;
pub use price::{Foresight, MOST_NODES, RunPrice, Unsolved, run_price};
pub use report::{ObservedOrder, Point, Reference, Study};
pub use suggestion::Suggestion;
pub use table::prices_table;
