//! Single states of a run, saved on demand.

use super::folder::SERIES;
use super::history::Tables;
use super::scene_file::write_scene;
use super::{Columns, RecordError, RunFolder, vtu, write_whole};
use crate::fem::Mesh;
use crate::scene::Scene;
use crate::simulation::{Report, State};

/// Digits of a step in a file name, at least.
const STEP_DIGITS: usize = 7;

/// Writes states of a run into a folder: `scene.toml`, the tables, and the fields; of one state as
/// `state.vtu`, of several in `fields/`, as a run's snapshots. The tables have a row a state, or all rows
/// of the `history` where that is given. `wall` is not a number: only the run itself knows it.
///
/// # Errors
/// [`RecordError`] with the file that could not be written. What was written before stays.
pub fn write_states(
    folder: &RunFolder,
    scene: &Scene,
    mesh: &Mesh,
    states: &[(&Report, &State)],
    history: Option<&Columns>,
) -> Result<(), RecordError> {
    write_scene(folder.path(), scene)?;
    let Some((first, _)) = states.first() else {
        return Ok(());
    };
    let mut tables = Tables::create(folder.path(), first)?;
    for (report, _) in states {
        tables.observe(report);
        tables.append(report, f64::NAN);
    }
    tables.finish()?;
    if let Some(history) = history {
        for (file, text) in [
            ("history.csv", Some(history.to_history())),
            ("shape.csv", Some(history.to_shape())),
            ("ledger.csv", history.to_ledger()),
        ] {
            let Some(text) = text else { continue };
            write_whole(&folder.path().join(file), |out| {
                out.write_all(text.as_bytes())
            })?;
        }
    }
    if let [(report, state)] = states {
        let path = folder.path().join("state.vtu");
        return vtu::write_fields(&path, mesh, state, report.t);
    }
    let fields = folder.make_fields()?;
    let mut series = Vec::with_capacity(states.len());
    for (report, state) in states {
        let name = format!("step-{:0STEP_DIGITS$}.vtu", report.step);
        vtu::write_fields(&fields.join(&name), mesh, state, report.t)?;
        series.push((report.t, name));
    }
    vtu::write_series(&fields.join(SERIES), &series)
}

#[cfg(test)]
mod tests {
    use super::super::scene_file::tests::scene;
    use super::*;
    use crate::simulation::Simulation;
    use std::ffi::OsStr;
    use std::fs;

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
        let states = [(&initial.0, &initial.1), (&stepped.0, &stepped.1)];

        let one = RunFolder::numbered(parent.path(), OsStr::new("one")).unwrap();
        write_states(&one, &scene, simulation.mesh(), &states[1..], None).unwrap();
        let history = fs::read_to_string(one.path().join("history.csv")).unwrap();
        assert_eq!(history.lines().count(), 2);
        assert!(history.lines().nth(1).unwrap().starts_with("2,2e-7,1e-7,"));
        assert!(one.path().join("state.vtu").is_file());
        assert!(one.path().join("scene.toml").is_file());
        assert!(!one.path().join("fields").exists());

        let both = RunFolder::numbered(parent.path(), OsStr::new("both")).unwrap();
        let mut rows = Columns::default();
        for report in [&initial.0, &first, &stepped.0] {
            rows.push(report);
        }
        // A run that was gone on with tells its last row again, without the ledger.
        rows.take_back();
        rows.push(&Report {
            ledger: Vec::new(),
            ..stepped.0.clone()
        });
        write_states(&both, &scene, simulation.mesh(), &states, Some(&rows)).unwrap();
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
        // But for `wall`, the last one.
        let row = |table: &str, row: usize| {
            let line = table.lines().nth(row).unwrap();
            line.rsplit_once(',').unwrap().0.to_owned()
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
