//! The vesicle of a point as it is at present: at the end of its run, or at the last snapshot.

use crate::fem::Contour;
use crate::record::{StoredFields, read_fields};
use std::fs;
use std::path::{Path, PathBuf};

/// The last fields that a run has saved; `None` where there are none yet, or they cannot be read.
pub fn last_fields(run: &Path) -> Option<StoredFields> {
    let last = run.join("final.vtu");
    let path = match last.is_file() {
        true => last,
        false => last_snapshot(&run.join("fields"))?,
    };
    read_fields(&path).ok()
}

/// The outline of the vesicle there, φ = 0, by rotation on both sides of the axis.
pub fn last_outline(run: &Path) -> Option<Contour> {
    let fields = last_fields(run)?;
    Some(Contour::of_section(&fields.mesh, &fields.state.phi))
}

/// The snapshot with the greatest number of a step: all have as many digits, or more.
fn last_snapshot(folder: &Path) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).ok()?.flatten();
    let snapshots = entries.filter_map(|entry| {
        let name = entry.file_name();
        let step = name.to_str()?.strip_prefix("step-")?.strip_suffix(".vtu")?;
        Some((step.parse::<u64>().ok()?, entry.path()))
    });
    snapshots.max().map(|(_, path)| path)
}
