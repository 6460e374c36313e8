//! Runs about runs: what accuracy costs in time, what each effect costs, what a run will cost before it is begun, and
//! sweeps over the values of a scene.

mod advice;
mod chart;
mod clock;
mod discretisation;
mod effects;
mod error_size;
mod errors;
mod evaluation;
mod finer_runs;
mod measure;
mod measured_error;
pub(crate) mod memory;
mod plan;
mod preset_figures;
mod price_list;
mod recorded_runs;
mod report;
mod run_estimate;
mod runner;
pub mod sweep;
mod table;
#[cfg(test)]
mod tests;

pub use chart::chart;
pub use discretisation::StepControl;
pub use effects::{Cost, Plan, Prices, prices};
pub use error_size::ErrorSize;
pub use finer_runs::{FinerNews, FinerRuns};
pub use measured_error::{ErrorRow, Sample, error_table, error_words, quantity_words};
pub use memory::CountingAllocator;
pub use preset_figures::PresetFigures;
pub use price_list::{Offer, price_words, reservations};
pub use recorded_runs::{ComparedRun, ComparedRunError, ComparedRuns};
pub use report::{Point, Study};
pub use run_estimate::{Foresight, MOST_NODES, run_estimate};
pub use runner::{Budget, StudyError, StudyNews, study};
pub use table::prices_table;

// Named by unit tests only.
#[cfg(test)]
pub(crate) use advice::Knob;
#[cfg(test)]
pub(crate) use discretisation::Discretisation;
#[cfg(test)]
pub(crate) use effects::Price;
#[cfg(test)]
pub(crate) use errors::Errors;
#[cfg(test)]
pub(crate) use measured_error::Measured;
#[cfg(test)]
pub(crate) use run_estimate::Unsolved;
