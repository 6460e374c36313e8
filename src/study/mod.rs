//! Runs about runs: what accuracy costs in time, and what a run will cost before it is begun.

mod advice;
mod chart;
mod choice;
mod clock;
mod distance;
mod ladder;
mod measure;
mod price;
mod report;
#[cfg(test)]
mod tests;

pub use advice::{Advice, Knob};
pub use chart::chart;
pub use choice::{Choice, Pace};
pub use distance::Errors;
pub use ladder::{Budget, StudyError, study};
pub use price::{Price, price};
pub use report::{ObservedOrder, Point, Reference, Study};
