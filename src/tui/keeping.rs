//! The runs of the app, kept from one time to the next: what a worker tells is noted down on its own
//! thread, and written whenever it tells its state.

use std::path::Path;
use std::sync::Arc;

use crate::record::{KeptRun, RunKeeper};
use crate::scene::Scene;
use crate::simulation::News;

use super::saving::PARENT;
use super::state::Slot;

/// The folder of the runs that can be gone on with, beside what was saved.
const UNFINISHED: &str = "unfinished";

/// The kept run of a scene of this name, if anything of it was computed.
pub(super) fn find(parent: &Path, name: &str, scene: &Scene) -> Option<KeptRun> {
    let kept = KeptRun::find(&parent.join(UNFINISHED), name, scene)?;
    kept.memory.is_begun().then_some(kept)
}

/// Looks for a run that a slot can go on with: one that the app has kept, or the one that its folder
/// holds, whichever has come further. Where a folder has none that is to be said.
pub(super) fn look_for(slot: &mut Slot) {
    let here = find(Path::new(PARENT), &slot.name, &slot.loaded);
    let folder = slot.folder.as_deref();
    let there = folder.and_then(|folder| KeptRun::of_folder(folder, &slot.loaded));
    if let (Some(folder), None, None) = (folder, &here, &there) {
        slot.remark = Some(format!(
            "{} has no checkpoint to go on from: the run begins anew",
            folder.display()
        ));
    }
    let furthest = [here, there].into_iter().flatten();
    let furthest = furthest.max_by(|one, other| one.memory.t().total_cmp(&other.memory.t()));
    slot.kept = furthest.map(Arc::new);
}

/// What is known of a run, noted down as its worker tells it.
#[derive(Debug)]
pub(super) struct Logbook {
    run: KeptRun,
    keeper: RunKeeper,
}

impl Logbook {
    /// For the run of a scene as it was loaded, which may go on from a kept one.
    pub fn new(parent: &Path, name: &str, scene: &Scene, from: Option<&KeptRun>) -> Self {
        let mut run = from.cloned().unwrap_or_else(|| KeptRun::new(scene));
        // Its last row is told again.
        run.rows.take_back();
        Self {
            run,
            keeper: RunKeeper::new(&parent.join(UNFINISHED), name, scene),
        }
    }

    /// Notes news down; gives them back unless they were for this alone.
    ///
    /// # Errors
    /// Why the run could not be kept, in words.
    pub fn take(&mut self, news: News) -> Result<Option<News>, String> {
        match news {
            News::Reports(reports) => {
                reports.iter().for_each(|report| self.run.rows.push(report));
                Ok(Some(News::Reports(reports)))
            }
            News::Anchored { kind, report } => {
                self.run.rows.push(&report);
                self.run.switches.push((report.step, kind));
                Ok(Some(News::Anchored { kind, report }))
            }
            News::State(memory) => {
                self.run.memory = *memory;
                let kept = self.keeper.keep(&self.run);
                kept.map(|()| None).map_err(|error| error.to_string())
            }
            other => Ok(Some(other)),
        }
    }
}
