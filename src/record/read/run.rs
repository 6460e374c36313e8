//! A run's folder, read back.

use super::super::bounded_read::read_file_text;
use super::super::folder::{FIELDS, SCENE, SUMMARY};
use super::super::summary::EventRecord;
use super::super::{Columns, LoadedScene, RunMark, load_run_scene};
use super::{LARGEST, ReadError, read_fields};
use crate::fem::Mesh;
use crate::scene::{self, Scene};
use crate::scheme::State;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The fields of a run at one time.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// The step.
    pub step: u64,
    /// Its time.
    pub t: f64,
    /// The mesh at that time.
    pub mesh: Arc<Mesh>,
    /// The fields.
    pub state: Arc<State>,
}

/// What a run left, as far as it got.
#[derive(Debug, Clone)]
pub struct RecordedRun {
    /// What was simulated.
    pub scene: Scene,
    /// The scalars of the rows.
    pub history: Columns,
    /// After which steps, and when, the mesh has followed the membrane.
    pub marks: Vec<RunMark>,
    /// The fields that were saved, in the order of time, those at the end included.
    pub fields: Vec<Snapshot>,
}

/// Reads a run's folder: `scene.toml`, `history.csv`, `shape.csv`, `fields/step-*.vtu` and
/// `final.vtu`. A run that is not finished, or was ended early, gives what there is.
///
/// # Errors
/// `ReadError`: what is missing or damaged.
pub fn read_run(folder: &Path) -> Result<RecordedRun, ReadError> {
    for missing in [SCENE, "history.csv"] {
        if !folder.join(missing).exists() {
            return Err(ReadError::NotARun {
                folder: folder.to_owned(),
                missing,
            });
        }
    }
    let LoadedScene { scene, .. } = load_run_scene(folder, &[])?;
    let history = Columns::read(folder)?;
    let follows = matches!(scene.mesh, scene::Mesh::Adaptive { .. });
    let mut last_mesh: Option<(Arc<Mesh>, PathBuf)> = None;
    let mut fields: Vec<Snapshot> = Vec::new();
    let last = folder.join("final.vtu");
    let last_step = history.column("step").and_then(|steps| steps.last());
    let snapshots = snapshots(&folder.join(FIELDS))?;
    let last = last_step
        .filter(|_| last.is_file())
        .map(|step| (*step as u64, last));
    for (step, path) in snapshots.into_iter().chain(last) {
        if fields.iter().any(|fields| fields.step == step) {
            continue;
        }
        let stored = read_fields(&path)?;
        let is_same = |mesh: &Mesh| {
            mesh.nodes() == stored.mesh.nodes() && mesh.triangles() == stored.mesh.triangles()
        };
        let mesh = match &last_mesh {
            Some((mesh, _)) if is_same(mesh) => mesh.clone(),
            Some((_, first)) if !follows => {
                let first = first.clone();
                return Err(ReadError::OtherMesh { path, first });
            }
            _ => {
                let mesh = Arc::new(stored.mesh);
                last_mesh = Some((mesh.clone(), path));
                mesh
            }
        };
        fields.push(Snapshot {
            step,
            t: stored.t,
            mesh,
            state: Arc::new(stored.state),
        });
    }
    fields.sort_by_key(|fields| fields.step);
    Ok(RecordedRun {
        scene,
        history,
        marks: marks(folder),
        fields,
    })
}

/// What its curves are marked with, by `run.json`. A run of which that cannot be read has no marks.
fn marks(folder: &Path) -> Vec<RunMark> {
    let events = read_file_text(&folder.join(SUMMARY), LARGEST)
        .ok()
        .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok())
        .and_then(|mut summary| serde_json::from_value(summary.get_mut("events")?.take()).ok());
    let events: Vec<EventRecord> = events.unwrap_or_default();
    events.iter().filter_map(RunMark::of_record).collect()
}

/// The files `step-N.vtu` of a folder, by N; none, if it is not there.
fn snapshots(folder: &Path) -> Result<Vec<(u64, PathBuf)>, ReadError> {
    let unreadable = |reason| ReadError::Unreadable {
        path: folder.to_owned(),
        reason,
    };
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        let step = name
            .and_then(|name| name.strip_prefix("step-")?.strip_suffix(".vtu"))
            .and_then(|digits| digits.parse().ok());
        found.extend(step.map(|step| (step, path)));
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::super::super::scene_file::tests::scene;
    use super::super::super::{Ending, IfOccupied, RecorderBuilder, RunFolder, Settings};
    use super::*;
    use crate::simulation::Simulation;
    use std::time::Duration;

    /// Records `steps` of the small scene's three, and gives the last state.
    fn record(path: &Path, steps: u64) -> (Scene, State) {
        let scene = scene("[nematic]\n");
        let folder = RunFolder::at(path, IfOccupied::Refuse).expect("a folder");
        let preparation =
            RecorderBuilder::begin(folder, &scene, Settings::default()).expect("it is written");
        let mut simulation = Simulation::new(&scene).expect("a small scene");
        let mut recorder = preparation
            .start(&simulation, Duration::ZERO)
            .expect("it is written");
        for _ in 0..steps {
            simulation.advance().expect("a solvable step");
            recorder
                .step(&mut simulation, Duration::ZERO)
                .expect("it is written");
        }
        let state = simulation.state().clone();
        recorder
            .finish(&mut simulation, Ending::Interrupted("SIGTERM"))
            .expect("it is written");
        (scene, state)
    }

    #[test]
    fn a_run_reads_back_with_all_that_it_has() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, state) = record(folder.path(), 3);
        let run = read_run(folder.path()).expect("a run");
        assert_eq!(run.scene, scene);
        assert_eq!(run.history.rows(), 4);
        assert!(run.history.known("E_nematic").is_some());
        assert!(run.history.known("E_area").is_none());
        assert!(run.history.known("waist").is_some());
        assert_eq!(run.fields[3].mesh.nodes().len(), 81);
        let steps: Vec<u64> = run.fields.iter().map(|fields| fields.step).collect();
        assert_eq!(steps, [0, 1, 2, 3]);
        assert_eq!(*run.fields[3].state, state);
        assert_eq!(run.fields[3].t, 3e-7);
    }

    #[test]
    fn a_run_that_was_ended_early_has_its_last_state() {
        let folder = tempfile::tempdir().expect("a folder");
        let (_, state) = record(folder.path(), 2);
        fs::remove_file(folder.path().join("fields/step-0000002.vtu")).expect("it was there");
        let run = read_run(folder.path()).expect("a run");
        let steps: Vec<u64> = run.fields.iter().map(|fields| fields.step).collect();
        assert_eq!(steps, [0, 1, 2]);
        assert_eq!(*run.fields[2].state, state);
    }

    #[test]
    fn what_is_no_run_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = read_run(folder.path()).expect_err("empty").to_string();
        assert!(error.contains("has no scene.toml"), "{error}");
        record(folder.path(), 1);
        fs::write(folder.path().join("history.csv"), "step,t\n0,0\n").expect("it is written");
        let error = read_run(folder.path()).expect_err("damaged").to_string();
        assert!(error.contains("history.csv has no column dt"), "{error}");
    }

    /// Each snapshot has its own mesh, and what each energy did in a transfer is in `run.json`.
    #[test]
    fn a_run_whose_mesh_follows_the_membrane_reads_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = scene("[nematic]\n");
        scene.mesh = crate::scene::Mesh::Adaptive {
            size: 0.2,
            refine: crate::scene::Refinement {
                band: 0.1,
                size: 0.08,
            },
            seed: 1,
        };
        let claimed = RunFolder::at(folder.path(), IfOccupied::Refuse).expect("a folder");
        let builder =
            RecorderBuilder::begin(claimed, &scene, Settings::default()).expect("written");
        let mut simulation = Simulation::new(&scene).expect("a small scene");
        let mut recorder = builder.start(&simulation, Duration::ZERO).expect("written");
        let mut nodes = vec![simulation.mesh().nodes().to_vec()];
        for _ in 0..3 {
            simulation.advance().expect("a solvable step");
            recorder
                .step(&mut simulation, Duration::ZERO)
                .expect("written");
            nodes.push(simulation.mesh().nodes().to_vec());
            if simulation.report().step == 1 {
                assert_eq!(simulation.renew_mesh(), Ok(true));
            }
        }
        let before = simulation.report().total_energy;
        let summary = recorder
            .finish(&mut simulation, Ending::Done)
            .expect("written");
        assert!(
            summary.largest_energy_rise <= 1e-9 * before.abs(),
            "{summary:?}"
        );
        let run = read_run(folder.path()).expect("a run");
        assert_eq!(run.fields.len(), 4);
        for (fields, nodes) in run.fields.iter().zip(&nodes) {
            assert_eq!(fields.mesh.nodes(), nodes);
            assert_eq!(fields.state.phi.len(), nodes.len());
        }
        assert!(Arc::ptr_eq(&run.fields[2].mesh, &run.fields[3].mesh));
        assert!(!Arc::ptr_eq(&run.fields[1].mesh, &run.fields[2].mesh));
        let mark = |mark: &RunMark| (mark.step, mark.t);
        assert_eq!(run.marks.iter().map(mark).collect::<Vec<_>>(), [(1, 1e-7)]);
        let text = fs::read_to_string(folder.path().join("run.json")).expect("a file");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let event = &summary["events"][0];
        assert_eq!(
            (&event["kind"], &event["step"]),
            (&"mesh-changed".into(), &1.into())
        );
        for name in [
            "nodes_before",
            "nodes_after",
            "E_total",
            "E_bending",
            "E_nematic",
        ] {
            assert!(event["values"][name].is_number(), "{event}");
        }
    }

    #[test]
    fn fields_of_another_mesh_are_told() {
        let folder = tempfile::tempdir().expect("a folder");
        record(folder.path(), 1);
        let other = tempfile::tempdir().expect("a folder");
        let mut finer = scene("[nematic]\n");
        finer.mesh = crate::scene::Mesh::Structured {
            cells: 9,
            jitter: 0.0,
            seed: 1,
        };
        let simulation = Simulation::new(&finer).expect("a small scene");
        let path = other.path().join("a.vtu");
        super::super::super::vtu::write_fields(&path, simulation.mesh(), simulation.state(), 0.0)
            .expect("it is written");
        fs::rename(path, folder.path().join("fields/step-0000001.vtu")).expect("it is moved");
        let error = read_run(folder.path()).expect_err("two meshes").to_string();
        assert!(
            error.contains("step-0000001.vtu is not on the mesh of"),
            "{error}"
        );
    }
}
