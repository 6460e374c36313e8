//! Reading back what a run left.

mod doubts;
mod error;
mod fields;
mod run;
mod summary;
mod table;

/// Bytes of a table, or of a file of fields, at most.
pub(super) const LARGEST: u64 = 1 << 32;

pub use doubts::doubts;
pub use error::{ReadError, WrongArray};
pub use fields::{StoredFields, read_fields};
pub use run::{RecordedRun, Snapshot, read_run};
pub use summary::{RecordedSummary, read_summary};
pub(super) use table::{parse_table, read_table};
