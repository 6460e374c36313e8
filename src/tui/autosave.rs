//! The runs of the app, kept from one session to the next: what a worker reports is recorded on its own
//! thread, and written about once a second; its state whenever it is reported.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::record::{KeptRows, KeptRun, KeptRuns, RecordError, RunKeeper, ShortNumber};
use crate::scene::Scene;
use crate::simulation::{Failure, Report, Schedule, StepProgress, WorkerEvent};

use super::saving::PARENT;
use super::state::{History, Keeping, Slot};

/// The folder of the runs that can be resumed, beside what was saved.
const UNFINISHED: &str = "unfinished";

/// A run of an earlier session.
#[derive(Debug, Default)]
pub struct Kept {
    /// The run.
    pub run: KeptRun,
    /// Its scalars up to now.
    pub curves: History,
    /// The folders of other runs of the scene that are kept.
    pub others: Vec<PathBuf>,
}

impl Kept {
    /// Whether it has come to the end of a scene, or to rest.
    pub fn is_over(&self, scene: &Scene) -> bool {
        let checkpoint = self.run.checkpoint();
        let schedule = Schedule::new(&scene.time, 1, 1);
        checkpoint.is_at_rest() || schedule.share(checkpoint.step(), checkpoint.t()) >= 1.0
    }

    /// How far it has come: at a step, or within one.
    pub fn place(&self) -> String {
        let checkpoint = self.run.checkpoint();
        place(
            checkpoint.step(),
            checkpoint.t(),
            checkpoint.underway().as_ref(),
        )
    }
}

/// Where a run is: at a step and its time, or within the next one.
pub(super) fn place(step: u64, t: f64, underway: Option<&StepProgress>) -> String {
    match underway {
        None => format!("at step {step} (t = {})", ShortNumber(t)),
        Some(underway) => format!(
            "within step {} (t = {})",
            underway.step,
            ShortNumber(underway.t)
        ),
    }
}

/// The kept runs of a slot's scene.
pub(super) fn runs_of(slot: &Slot) -> KeptRuns {
    KeptRuns::new(
        &Path::new(PARENT).join(UNFINISHED),
        &slot.name,
        &slot.loaded,
    )
}

/// Looks for a run that a slot can resume: one that the app has kept, or the one that its folder
/// holds, whichever has come further. What is wrong with any is reported.
pub(super) fn look_for(slot: &mut Slot) {
    let runs = runs_of(slot);
    let mut search = runs.find();
    if let Some(folder) = &slot.folder {
        let there = runs.find_in(folder);
        if search.run.is_none() || there.run.is_some() {
            search.notes.extend(there.notes);
        }
        search.run = search
            .run
            .into_iter()
            .chain(there.run)
            .max_by(|one, other| one.checkpoint().t().total_cmp(&other.checkpoint().t()));
    }
    let mut words: Vec<String> = search.notes.iter().map(ToString::to_string).collect();
    slot.kept = search.run.map(|run| {
        let curves = match run.rows() {
            Ok(rows) => History::of(&rows, run.marks()),
            Err(error) => {
                words.push(format!("the curves up to now are lost: {error}"));
                History::default()
            }
        };
        Arc::new(Kept {
            run,
            curves,
            others: search.others,
        })
    });
    words.splice(0..0, slot.remark.take());
    if !words.is_empty() {
        slot.remark = Some(words.join("\n"));
    }
}

/// Begins the autosave of a slot's run, which may resume a kept one. With it comes what is lost if that
/// cannot be written any more.
pub(super) fn begin(slot: &Slot, kept: Option<&Kept>) -> (Autosave, Option<String>) {
    let runs = runs_of(slot);
    match kept.map(|kept| runs.go_on(&kept.run)) {
        Some(Ok(keeper)) => (Autosave::new(keeper), None),
        Some(Err(error)) => {
            let words = format!("the rows up to now are lost: {error}");
            (Autosave::new(runs.begin()), Some(words))
        }
        None => (Autosave::new(runs.begin()), None),
    }
}

/// Puts kept runs of slots aside, and says where they are.
pub(super) fn put_aside(slots: &[Slot], kept: &[(usize, Arc<Kept>)]) -> String {
    let words = kept.iter().filter_map(|(slot, kept)| {
        let slot = slots.get(*slot)?;
        let place = kept.place();
        Some(match runs_of(slot).put_aside(&kept.run) {
            Ok(path) => format!("{} {place}: vesica {}", slot.name, path.display()),
            Err(error) => format!("{} {place} stays where it is: {error}", slot.name),
        })
    });
    let words: Vec<String> = words.collect();
    format!(
        "put aside, to be resumed another time: {}",
        words.join("; ")
    )
}

/// The autosave of a run, for its worker's thread and the saving thread.
pub type SharedAutosave = Arc<Mutex<Autosave>>;

/// What is known of a run, recorded as its worker reports it.
#[derive(Debug)]
pub struct Autosave {
    keeper: RunKeeper,
    /// The step that it began from.
    from: Option<u64>,
    /// Why nothing could be written when it was tried last.
    failure: Option<String>,
    /// Why the run has failed.
    failed: Option<Failure>,
}

/// What remains of an event after the autosave has taken it.
#[derive(Debug, Default)]
pub(super) struct Noted {
    /// The event, unless it was for the autosave alone.
    pub event: Option<WorkerEvent>,
    /// Whether the run is kept, where that has changed.
    pub keeping: Option<Keeping>,
    /// What was kept and has vanished.
    pub lost: Option<String>,
}

impl Autosave {
    /// For a run that is kept so.
    pub fn new(keeper: RunKeeper) -> Self {
        Self {
            from: keeper.reached(),
            keeper,
            failure: None,
            failed: None,
        }
    }

    /// Takes an event.
    pub(super) fn take(&mut self, event: WorkerEvent) -> Noted {
        let mut noted = Noted::default();
        match event {
            WorkerEvent::Reports(reports) => {
                reports.iter().for_each(|report| self.keeper.step(report));
                let before = self.failure.clone();
                if let Some(outcome) = self.keeper.flush_in_time() {
                    self.hear(outcome);
                }
                if self.failure != before {
                    noted.keeping = Some(self.keeping());
                }
                noted.event = Some(WorkerEvent::Reports(reports));
            }
            WorkerEvent::Changed(change) => {
                let outcome = self.keeper.changed(&change);
                self.hear(outcome);
                noted.event = Some(WorkerEvent::Changed(change));
            }
            WorkerEvent::Event(event) => {
                self.keeper.mark(&event);
                noted.event = Some(WorkerEvent::Event(event));
            }
            WorkerEvent::State(checkpoint) => {
                let outcome = self.keeper.keep(*checkpoint);
                self.hear(outcome);
                noted.keeping = Some(self.keeping());
            }
            WorkerEvent::Failed(failure) => {
                self.failed = Some(failure.clone());
                noted.event = Some(WorkerEvent::Failed(failure));
            }
            other => noted.event = Some(other),
        }
        noted.lost = self.keeper.take_lost().map(|lost| lost.to_string());
        noted
    }

    fn hear(&mut self, outcome: Result<(), RecordError>) {
        self.failure = outcome.err().map(|error| error.to_string());
    }

    /// Whether the run is kept.
    pub fn keeping(&self) -> Keeping {
        match (&self.failure, self.keeper.kept()) {
            (Some(why), _) => Keeping::Failed(why.clone()),
            (None, Some(kept)) => Keeping::Kept(kept.clone()),
            (None, None) => Keeping::Pending,
        }
    }

    /// The scalars of the last step.
    pub fn latest(&self) -> Option<&Report> {
        self.keeper.latest()
    }

    /// How far the run is kept in the step after that.
    pub fn underway(&self) -> Option<StepProgress> {
        self.keeper.underway()
    }

    /// Why the run failed.
    pub fn failed(&self) -> Option<&Failure> {
        self.failed.as_ref()
    }

    /// Whether it has steps that it did not begin with.
    pub fn has_steps(&self) -> bool {
        self.keeper.reached().unwrap_or(0) > self.from.unwrap_or(0)
    }

    /// The rows up to now.
    ///
    /// # Errors
    /// They cannot be read.
    pub fn rows(&mut self) -> Result<Option<KeptRows>, RecordError> {
        self.keeper.rows()
    }

    /// Removes all that was kept of the run.
    ///
    /// # Errors
    /// What could not be removed.
    pub fn discard(&mut self) -> Result<(), RecordError> {
        self.keeper.discard()
    }
}
