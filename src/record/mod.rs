//! The files that a run leaves.
//!
//! A run owns a folder. In it stand
//!
//! | file | what | written |
//! |---|---|---|
//! | `scene.toml` | the complete scene, with defaults and overrides | at the start, whole |
//! | `inputs/` | the nodal values that the scene had from files | at the start, whole |
//! | `history.csv` | the scalars of a step ([`HISTORY_COLUMNS`]) | grows by whole lines |
//! | `ledger.csv` | every term of the energy law (3.26), from step 1 on: the law is about steps | grows by whole lines |
//! | `shape.csv` | length, waist and greatest width of the vesicle | grows by whole lines |
//! | `fields/` | VTU files at evenly spaced times, and `fields.pvd`, their list | each whole |
//! | `final.vtu` | the fields at the end | at the end, whole |
//! | `checkpoint.bin` | the state, for the run to be resumed; `checkpoint-older.bin` is the one before | every half minute and at the end, whole |
//! | `history.csv.as-found` and the like | a table as somebody has left it who changed it, where not all of that is in the table now | when the run is resumed |
//! | `run.json` | version, times, totals, warnings, events, status ([`RunSummary`]); which programs computed it, where and from what | replaced whole |
//!
//! *Whole* means written beside its place and then renamed: a reader sees all of a file or none.
//! The tables appear whole with their first line and then grow: their lines are collected in
//! memory and appended, whole lines only, about once a second, so that the disk does not slow the
//! solver and a killed run leaves readable tables. Their rest is written when a run ends, however
//! it ends. A run that was killed is known by the status "running" in `run.json`.
//!
//! [`read_run`] reads a folder back, also of a run that is not finished; [`Columns`] are the scalars of a run
//! in memory, read back or collected while it goes.

mod app_checkpoint;
mod atomic;
mod bounded_read;
mod checkpoint;
mod error;
mod folder;
mod history;
mod lenient;
mod load_scene;
mod mark;
mod number;
mod provenance;
mod quantity;
mod read;
mod recorder;
mod resume;
mod ro_crate;
mod scalar_columns;
mod scene_file;
mod shortened;
mod snapshots;
mod summary;
mod table;
mod table_checks;
mod table_repair;
mod vtu;

/// Bytes of `run.json`, at most.
const LARGEST_SUMMARY: u64 = 1 << 28;

pub use app_checkpoint::{KeptAt, KeptRows, KeptRun, KeptRuns, RunKeeper};
pub use atomic::Leftover;
pub(crate) use atomic::{clean, try_to_write, unfinished_name, write_new, write_whole};
pub(crate) use bounded_read::{read_bytes, read_file_text, read_text};
pub use checkpoint::CheckpointError;
pub use error::RecordError;
pub use folder::{IfOccupied, RunFolder, Whereabouts, write_error_table};
pub(crate) use folder::{clear as clear_run, files_of_run, make as make_folder};
pub use history::HISTORY_COLUMNS;
pub use mark::{MarkKind, RunMark};
pub(crate) use number::push_cells;
pub use number::{Number, ShortNumber};
pub(crate) use provenance::sha256;
pub use provenance::{Build, changed_inputs};
pub use quantity::{QUANTITIES, Quantity};
pub use read::{
    ReadError, RecordedRun, RecordedSummary, Snapshot, StoredFields, doubts, read_fields, read_run,
    read_summary,
};
pub use recorder::{Recorder, RecorderBuilder, Settings};
pub use resume::{Found, Resumption};
pub use ro_crate::{CRATE_FILE, CrateDescription, CrateFile, Role, ro_crate};
pub use scalar_columns::Columns;

pub use crate::simulation::{Schedule, step_count};
pub(crate) use load_scene::{LARGEST_INPUT, LARGEST_SCENE};
pub use load_scene::{LoadError, LoadedScene, load_run_scene, load_scene};
pub use scene_file::same_run;
pub(crate) use scene_file::{identity as scene_identity, write_scene};
pub use snapshots::{write_state, write_states};
pub use summary::{Ending, EventRecord, FinerRun, MeasuredErrorRecord, RunSummary, Status};
pub use vtu::{write_fields, write_series, write_surface};
