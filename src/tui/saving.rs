//! Saving on a thread of its own: what is saved is decided by the app's state, how by a function
//! that is given.

use std::ffi::OsString;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};

use super::autosave::SharedAutosave;
use super::event::{AppEvent, spawn};
use super::message::Message;
use super::state::View;
use crate::record::{RunFolder, RunMark, write_state, write_states};
use crate::scene::Scene;
use crate::simulation::{RunSnapshot, panic_words};
use crate::theory::ShapeAtRest;

/// Where what is saved goes, within the working folder: a new folder each time.
pub(super) const PARENT: &str = "saved";

/// Something to save.
#[derive(Debug)]
pub struct Job {
    /// The word for the scene: the folder's name begins with it.
    pub name: String,
    /// The scene, with the changes that were made while the run went.
    pub scene: Arc<Scene>,
    /// What the curves are marked with.
    pub marks: Vec<RunMark>,
    /// The shape at rest of the membrane alone, where it is shown.
    pub theory: Option<Arc<ShapeAtRest>>,
    /// What.
    pub what: What,
}

/// What is saved.
#[derive(Debug)]
pub enum What {
    /// One picture, shown in this way.
    View(Arc<RunSnapshot>, View),
    /// Pictures in the order of their steps, and the autosave of the run: it has all scalars.
    Set(Vec<Arc<RunSnapshot>>, SharedAutosave),
}

impl Job {
    /// The name of its folder, which may get a number.
    fn folder_name(&self) -> OsString {
        match &self.what {
            What::View(picture, _) => format!("{}-step-{:07}", self.name, picture.report.step),
            What::Set(..) => format!("{}-set", self.name),
        }
        .into()
    }
}

/// How a job is carried out: writes its files into a new folder. An error is in words.
pub type Save = fn(&Job, &RunFolder) -> Result<(), String>;

/// Saves the states alone: fields as VTU, scalars as tables, the scene.
///
/// # Errors
/// What could not be written, and why.
pub fn save_states(job: &Job, folder: &RunFolder) -> Result<(), String> {
    let written = match &job.what {
        What::View(picture, _) => {
            let state = (&picture.report, &*picture.mesh, &*picture.state);
            write_state(folder, &job.scene, state)
        }
        What::Set(pictures, autosave) => {
            let mut autosave = autosave.lock().unwrap_or_else(PoisonError::into_inner);
            let rows = autosave.rows().map_err(|error| error.to_string())?;
            drop(autosave);
            let states: Vec<_> = pictures
                .iter()
                .map(|picture| (&picture.report, &*picture.mesh, &*picture.state))
                .collect();
            write_states(folder, &job.scene, &states, rows)
        }
    };
    written.map_err(|error| error.to_string())
}

/// The saving thread.
#[derive(Debug)]
pub(super) struct Saver {
    jobs: Sender<Job>,
    /// Jobs that were given and not answered.
    pending: usize,
    /// The folder that is being filled.
    unfinished: Unfinished,
}

/// The folder that is being filled, if there is one.
type Unfinished = Arc<Mutex<Option<PathBuf>>>;

impl Saver {
    /// Starts the thread. Every job gets a folder in `parent`, and is answered by a
    /// [`Message::Saved`].
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(save: Save, parent: PathBuf, incoming: Sender<AppEvent>) -> io::Result<Self> {
        let (jobs, queue) = mpsc::channel();
        let answers = incoming.clone();
        let unfinished = Unfinished::default();
        let shared = Arc::clone(&unfinished);
        spawn("saving", incoming, move || {
            for job in queue {
                let saved = carry_out(save, &job, &parent, &shared);
                // If the loop has ended, nobody wants to know.
                let _ = answers.send(AppEvent::Message(Message::Saved(saved)));
            }
        })?;
        Ok(Self {
            jobs,
            pending: 0,
            unfinished,
        })
    }

    /// Gives the thread a job. The state of the app sees to it that they do not pile up.
    pub fn give(&mut self, job: Job) {
        // If the thread has ended, its panic was reported.
        if self.jobs.send(job).is_ok() {
            self.pending += 1;
        }
    }

    /// A job was answered.
    pub fn answered(&mut self) {
        self.pending = self.pending.saturating_sub(1);
    }

    /// Removes the half of a job that there is no time for: the process is about to end.
    pub fn abandon(&self) {
        let unfinished = self.unfinished.lock();
        if let Some(path) = &*unfinished.unwrap_or_else(PoisonError::into_inner) {
            // The thread may still make files; without the folder it cannot.
            for _ in 0..3 {
                if std::fs::remove_dir_all(path).is_ok() {
                    break;
                }
            }
        }
    }

    /// Whether a job is under way.
    pub fn is_busy(&self) -> bool {
        self.pending > 0
    }
}

/// Makes a folder, saves into it, and gives it its name when it is whole; where anything fails nothing of it
/// stays. The folder's path, whole.
fn carry_out(
    save: Save,
    job: &Job,
    parent: &Path,
    unfinished: &Unfinished,
) -> Result<PathBuf, String> {
    let note = |path: Option<PathBuf>| {
        *unfinished.lock().unwrap_or_else(PoisonError::into_inner) = path;
    };
    let folder = RunFolder::unpublished(parent).map_err(|error| error.to_string())?;
    let path = folder.path().to_owned();
    note(Some(path.clone()));
    let outcome = catch_unwind(AssertUnwindSafe(|| save(job, &folder))).unwrap_or_else(|panic| {
        let words = panic_words(panic.as_ref());
        Err(format!("saving has a mistake and stopped: {words}"))
    });
    let name = job.folder_name();
    let published = outcome.and_then(|()| folder.publish(&name).map_err(|error| error.to_string()));
    note(None);
    match published {
        Ok(folder) => {
            Ok(std::path::absolute(folder.path()).unwrap_or_else(|_| folder.path().into()))
        }
        Err(words) => {
            // The folder is new, so all in it is the half of what was to be saved.
            let _ = std::fs::remove_dir_all(path);
            Err(words)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::autosave::Autosave;
    use super::*;
    use crate::record::KeptRuns;
    use crate::scene::{Scene, preset};
    use crate::simulation::{Report, RunId, Simulation, WorkerEvent};

    fn job(step: u64) -> Job {
        let overrides = ["mesh.cells=8", "membrane.interface_width=0.1"].map(str::to_owned);
        let text = preset("circle").unwrap();
        let scene = Scene::parse(text, "circle", &overrides, &mut |_| unreachable!()).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let picture = RunSnapshot {
            run: RunId(1),
            anchoring: None,
            report: Report {
                step,
                ..simulation.report().clone()
            },
            mesh: simulation.mesh().clone(),
            state: Arc::new(simulation.state().clone()),
        };
        let scene = Arc::new(scene);
        let kept = KeptRuns::new(Path::new("/nowhere"), "circle", &scene);
        let mut autosave = Autosave::new(kept.begin());
        autosave.take(WorkerEvent::Reports(vec![simulation.report().clone()]));
        Job {
            name: "circle".into(),
            scene,
            marks: Vec::new(),
            theory: None,
            what: What::Set(vec![Arc::new(picture)], Arc::new(Mutex::new(autosave))),
        }
    }

    fn carry_out(save: Save, job: &Job, parent: &Path) -> Result<PathBuf, String> {
        super::carry_out(save, job, parent, &Unfinished::default())
    }

    #[test]
    fn every_job_has_a_new_folder_and_its_whole_path_is_told() {
        let parent = tempfile::tempdir().unwrap();
        let first = carry_out(save_states, &job(0), parent.path()).unwrap();
        let second = carry_out(save_states, &job(3), parent.path()).unwrap();
        assert_eq!(first, parent.path().join("circle-set"));
        assert_eq!(second, parent.path().join("circle-set-2"));
        assert!(first.is_absolute() && first.join("fields/step-0000000.vtu").is_file());
        assert!(first.join("ledger.csv").is_file());
        assert!(second.join("history.csv").is_file());
    }

    #[test]
    fn failures_are_told_with_their_reason_and_leave_nothing() {
        let parent = tempfile::tempdir().unwrap();
        let full: Save = |_, _| Err("cannot write a.png: No space left on device".into());
        let broken: Save = |_, _| panic!("no such colour");
        let error = carry_out(full, &job(0), parent.path()).unwrap_err();
        assert!(error.ends_with("No space left on device"));
        let error = carry_out(broken, &job(0), parent.path()).unwrap_err();
        assert!(error.ends_with("stopped: no such colour"), "{error}");
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 0);

        let file = parent.path().join("saved");
        std::fs::write(&file, "").unwrap();
        let error = carry_out(save_states, &job(0), &file).unwrap_err();
        assert!(error.contains("there is a file of this name"), "{error}");
    }

    #[test]
    fn a_folder_has_its_name_when_it_is_whole_and_what_is_abandoned_leaves_nothing() {
        static PARENT: Mutex<Option<PathBuf>> = Mutex::new(None);
        let parent = tempfile::tempdir().unwrap();
        *PARENT.lock().unwrap() = Some(parent.path().to_owned());
        let looks: Save = |job, folder| {
            let parent = PARENT.lock().unwrap().clone().unwrap();
            let names = || {
                std::fs::read_dir(&parent)
                    .unwrap()
                    .map(|entry| entry.unwrap().path())
            };
            assert_eq!(names().collect::<Vec<_>>(), [folder.path()]);
            save_states(job, folder)?;
            assert!(!parent.join("circle-set").exists());
            Ok(())
        };
        carry_out(looks, &job(0), parent.path()).unwrap();
        std::fs::remove_dir_all(parent.path().join("circle-set")).unwrap();
        // It is still saving when the process ends.
        let endless: Save = |_, folder| {
            while std::fs::write(folder.path().join("a"), [0; 1000]).is_ok() {}
            Err("it has gone".to_owned())
        };
        let (incoming, answers) = mpsc::channel();
        let mut saver = Saver::start(endless, parent.path().into(), incoming).unwrap();
        saver.give(job(0));
        let is_begun = || std::fs::read_dir(parent.path()).unwrap().count() == 1;
        while !is_begun() {
            std::thread::yield_now();
        }
        while saver.unfinished.lock().unwrap().is_none() {
            std::thread::yield_now();
        }
        saver.abandon();
        let answer = answers.recv_timeout(std::time::Duration::from_secs(20));
        assert!(
            matches!(&answer, Ok(AppEvent::Message(Message::Saved(Err(words)))) if words == "it has gone"),
            "{answer:?}"
        );
        assert_eq!(std::fs::read_dir(parent.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_thread_answers_every_job() {
        let (incoming, answers) = mpsc::channel();
        let save: Save = |job, _| Err(job.name.clone());
        let parent = tempfile::tempdir().unwrap();
        let mut saver = Saver::start(save, parent.path().into(), incoming).unwrap();
        for _ in 0..2 {
            saver.give(job(0));
        }
        for _ in 0..2 {
            assert!(saver.is_busy());
            let answer = answers.recv_timeout(std::time::Duration::from_secs(20));
            assert!(
                matches!(&answer, Ok(AppEvent::Message(Message::Saved(Err(words)))) if words == "circle"),
                "{answer:?}"
            );
            saver.answered();
        }
        assert!(!saver.is_busy());
    }
}
