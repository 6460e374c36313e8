//! Single states of a run, saved on demand.

use super::atomic::write_whole;
use super::folder::SERIES;
use super::history::{LEDGER, Tables};
use super::scene_file::write_scene;
use super::{KeptRows, RecordError, RunFolder, vtu};
use crate::fem::Mesh;
use crate::scene::Scene;
use crate::simulation::{Report, State};
use std::path::Path;

/// Digits of a step in a file name, at least.
const STEP_DIGITS: usize = 7;

/// Writes one state of a run into a folder: `scene.toml`, the tables with its row, in which `wall` is not a
/// number (only the run knows it), and the fields as `state.vtu`.
///
/// # Errors
/// [`RecordError`] with the file that could not be written. What was written before stays.
pub fn write_state(
    folder: &RunFolder,
    scene: &Scene,
    (report, mesh, state): (&Report, &Mesh, &State),
) -> Result<(), RecordError> {
    write_scene(folder.path(), scene)?;
    write_rows(folder.path(), [report])?;
    let path = folder.path().join("state.vtu");
    vtu::write_fields(&path, mesh, state, report.t)
}

/// Writes a run up to now into a folder, as a run's own has it: `scene.toml`, the tables, and states in
/// `fields/`. The tables are those of the run where its rows are given, else they have a row a state. A run
/// that has no step yet has a ledger without rows.
///
/// # Errors
/// [`RecordError`] with the file that could not be written. What was written before stays.
pub fn write_states(
    folder: &RunFolder,
    scene: &Scene,
    states: &[(&Report, &Mesh, &State)],
    rows: Option<KeptRows>,
) -> Result<(), RecordError> {
    write_scene(folder.path(), scene)?;
    match rows {
        Some(rows) => rows.0.write(folder.path())?,
        None => write_rows(folder.path(), states.iter().map(|(report, ..)| *report))?,
    }
    let ledger = folder.path().join(LEDGER);
    if !ledger.exists() {
        write_whole(&ledger, |file| file.write_all(b"step,t\n"))?;
    }
    let fields = folder.make_fields()?;
    let mut series = Vec::with_capacity(states.len());
    for (report, mesh, state) in states {
        let name = format!("step-{:0STEP_DIGITS$}.vtu", report.step);
        vtu::write_fields(&fields.join(&name), mesh, state, report.t)?;
        series.push((report.t, name));
    }
    vtu::write_series(&fields.join(SERIES), &series)
}

/// Writes tables with a row a state.
fn write_rows<'a>(
    folder: &Path,
    reports: impl IntoIterator<Item = &'a Report>,
) -> Result<(), RecordError> {
    let mut reports = reports.into_iter().peekable();
    let Some(first) = reports.peek() else {
        return Ok(());
    };
    let mut tables = Tables::create(folder, first)?;
    for report in reports {
        tables.observe(report);
        tables.append(report, f64::NAN);
    }
    tables.finish()
}

#[cfg(test)]
mod tests {
    use super::super::scene_file::tests::scene;
    use super::*;
    use crate::record::KeptRuns;
    use crate::simulation::Simulation;
    use std::ffi::OsStr;
    use std::fs;
    use std::sync::Arc;

    #[test]
    fn one_state_is_one_file_of_fields_and_several_are_a_series() {
        let parent = tempfile::tempdir().unwrap();
        let scene = scene("");
        let mut simulation = Simulation::new(&scene).unwrap();
        let initial = (simulation.report().clone(), simulation.state().clone());
        simulation.advance().unwrap();
        let first = simulation.report().clone();
        simulation.advance().unwrap();
        let stepped = (simulation.report().clone(), simulation.state().clone());
        let mesh = &**simulation.mesh();
        let states = [
            (&initial.0, mesh, &initial.1),
            (&stepped.0, mesh, &stepped.1),
        ];

        let one = RunFolder::numbered(parent.path(), OsStr::new("one")).unwrap();
        write_state(&one, &scene, states[1]).unwrap();
        let history = fs::read_to_string(one.path().join("history.csv")).unwrap();
        assert_eq!(history.lines().count(), 2);
        assert!(history.lines().nth(1).unwrap().starts_with("2,2e-7,1e-7,"));
        assert!(one.path().join("state.vtu").is_file());
        assert!(one.path().join("scene.toml").is_file());
        assert!(!one.path().join("fields").exists());

        // Of a run without a step, as far as it is known.
        let begun = RunFolder::numbered(parent.path(), OsStr::new("begun")).unwrap();
        write_states(&begun, &scene, &states[..1], None).unwrap();
        assert!(begun.path().join("fields/step-0000000.vtu").is_file());
        assert!(begun.path().join("fields").join(SERIES).is_file());
        let ledger = fs::read_to_string(begun.path().join("ledger.csv")).unwrap();
        assert_eq!(ledger, "step,t\n");

        let both = RunFolder::numbered(parent.path(), OsStr::new("both")).unwrap();
        let scene = Arc::new(scene);
        let mut keeper = KeptRuns::new(&parent.path().join("kept"), "a", &scene).begin();
        for report in [&initial.0, &first, &stepped.0] {
            keeper.step(report);
        }
        let rows = keeper.rows().unwrap();
        write_states(&both, &scene, &states, rows).unwrap();
        let fields = both.path().join("fields");
        assert!(fields.join("step-0000000.vtu").is_file());
        assert_eq!(
            fs::read(fields.join("step-0000002.vtu")).unwrap(),
            fs::read(one.path().join("state.vtu")).unwrap()
        );
        // All rows, in the columns that a run's own table has.
        let read = |folder: &RunFolder| fs::read_to_string(folder.path().join("history.csv"));
        let (whole, single) = (read(&both).unwrap(), read(&one).unwrap());
        assert_eq!(whole.lines().count(), 4);
        assert_eq!(whole.lines().next(), single.lines().next());
        // But for `wall`, the last one, and the residual since the row before.
        let row = |table: &str, row: usize| {
            let cells = table.lines().nth(row).unwrap().split(',');
            cells.take(10).map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(row(&whole, 3), row(&single, 1));
        // The ledger has every step, as that of a run.
        let read = |folder: &RunFolder| fs::read_to_string(folder.path().join("ledger.csv"));
        let (whole, single) = (read(&both).unwrap(), read(&one).unwrap());
        assert_eq!(whole.lines().count(), 3);
        assert!(whole.lines().nth(1).unwrap().starts_with("1,1e-7,"));
        assert_eq!(whole.lines().next(), single.lines().next());
        assert_eq!(whole.lines().nth(2), single.lines().nth(1));
        let series = fs::read_to_string(fields.join(SERIES)).unwrap();
        assert_eq!(series.matches("<DataSet ").count(), 2);
    }
}
