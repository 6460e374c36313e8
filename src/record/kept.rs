//! The state of a run in the app, kept from one time to the next.

use super::checkpoint::{APP, Keeper, Problem};
use super::scene_file::identity;
use super::{Columns, Found, RecordError, Resumption};
use crate::scene::{AnchoringKind, Scene};
use crate::simulation::Memory;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A run as it was: its state, its scalars, and when its anchoring was switched.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct KeptRun {
    scene: String,
    /// The state.
    pub memory: Memory,
    /// The scalars of every step.
    pub rows: Columns,
    /// The steps at which the anchoring was switched, and to what.
    pub switches: Vec<(u64, AnchoringKind)>,
}

/// Where the state of a run is kept, in two generations.
#[derive(Debug)]
pub struct RunKeeper(Keeper);

impl RunKeeper {
    /// For the run of a scene of this name, with others in a folder.
    pub fn new(folder: &Path, name: &str, scene: &Scene) -> RunKeeper {
        RunKeeper(Keeper::new(APP, paths(folder, name, scene), true))
    }

    /// Keeps a run in place of what was kept.
    ///
    /// # Errors
    /// [`RecordError`]: what could not be written.
    pub fn keep(&mut self, run: &KeptRun) -> Result<(), RecordError> {
        self.0.make_folder()?;
        self.0.write(run)
    }
}

impl KeptRun {
    /// A run of a scene of which nothing is known yet.
    pub fn new(scene: &Scene) -> KeptRun {
        KeptRun {
            scene: identity(scene),
            ..KeptRun::default()
        }
    }

    /// The run of a scene that was recorded in a folder of its own, up to its latest checkpoint: nothing
    /// where none can be used.
    pub fn of_folder(folder: &Path, scene: &Scene) -> Option<KeptRun> {
        let Ok(Found::Run(found)) = Resumption::find(folder, scene) else {
            return None;
        };
        let memory = found.memory()?.clone();
        let mut rows = Columns::read_with_ledger(folder).ok()?;
        rows.end_at(memory.step());
        Some(KeptRun {
            memory,
            rows,
            ..KeptRun::new(scene)
        })
    }

    /// The run of a scene of this name that is kept in a folder: of what is damaged, the one before.
    pub fn find(folder: &Path, name: &str, scene: &Scene) -> Option<KeptRun> {
        let wanted = identity(scene);
        let right = |kept: &KeptRun| kept.scene == wanted && kept.rows.is_whole();
        let read = |path: PathBuf| -> Result<KeptRun, Problem> { Keeper::read(APP, &path) };
        let mut generations = paths(folder, name, scene).into_iter();
        generations.find_map(|path| read(path).ok().filter(right))
    }
}

/// The names of both generations. Runs of another scene of the same name have others.
fn paths(folder: &Path, name: &str, scene: &Scene) -> [PathBuf; 2] {
    let number = crc32fast::hash(identity(scene).as_bytes());
    ["", "-older"].map(|which| folder.join(format!("{name}-{number:08x}{which}.bin")))
}

#[cfg(test)]
mod tests {
    use super::super::scene_file::tests::scene;
    use super::*;
    use crate::record::{Ending, IfOccupied, Preparation, RunFolder, Settings};
    use crate::simulation::Simulation;
    use std::fs;
    use std::time::Duration;

    #[test]
    fn the_run_of_a_folder_is_found_up_to_its_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene("[nematic]\n");
        assert!(KeptRun::of_folder(folder.path(), &scene).is_none());
        let settings = Settings {
            every: 2,
            ..Settings::default()
        };
        let run = RunFolder::at(folder.path(), IfOccupied::Refuse).unwrap();
        let preparation = Preparation::begin(run, &scene, settings).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut recorder = preparation.start(&simulation, Duration::ZERO).unwrap();
        for _ in 0..3 {
            simulation.advance().unwrap();
            recorder.step(&mut simulation, Duration::ZERO).unwrap();
        }
        recorder
            .finish(&mut simulation, Ending::Interrupted)
            .unwrap();
        let kept = KeptRun::of_folder(folder.path(), &scene).expect("it has a checkpoint");
        assert_eq!(kept.memory.step(), 3);
        // The last row is that of the state, however far apart the rows are.
        assert_eq!(kept.rows.column("step"), Some(&[0.0, 2.0, 3.0][..]));
        let other = self::scene("");
        assert!(KeptRun::of_folder(folder.path(), &other).is_none());
    }

    #[test]
    fn a_run_is_found_again_and_of_a_damaged_one_the_one_before() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("unfinished");
        let (scene, other) = (scene("[nematic]\n"), scene(""));
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut kept = KeptRun::new(&scene);
        let mut keeper = RunKeeper::new(&folder, "small", &scene);
        for _ in 0..2 {
            kept.rows.push(simulation.advance().unwrap());
            simulation.remember(&mut kept.memory);
            keeper.keep(&kept).unwrap();
        }
        let found = KeptRun::find(&folder, "small", &scene).expect("it was kept");
        assert_eq!((found.memory.step(), found.rows.rows()), (2, 2));
        assert!(KeptRun::find(&folder, "small", &other).is_none());
        assert!(KeptRun::find(&folder, "large", &scene).is_none());
        let [newest, _] = paths(&folder, "small", &scene);
        fs::write(newest, "damaged").unwrap();
        let found = KeptRun::find(&folder, "small", &scene).expect("the one before");
        assert_eq!(found.memory.step(), 1);
    }
}
