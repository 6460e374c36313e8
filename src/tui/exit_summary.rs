//! What the app says at its end, and of what an earlier one left.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::autosave::SharedAutosave;
use super::session::Failed;
use super::state::{App, Keeping, Run, Slot};
use crate::record::{KeptAt, Leftover, ShortNumber};
use crate::simulation::{Failure, Report, RunId, StepProgress};

/// More folders than this are counted, not named.
const NAMED: usize = 3;

/// How a run is left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Left {
    /// Which slot's it is.
    pub slot: usize,
    /// The word for its scene.
    pub name: String,
    /// The step that it came to.
    pub step: u64,
    /// The time and the energy of that step, where they are known.
    pub scalars: Option<(f64, f64)>,
    /// How far it is kept in the next step.
    pub underway: Option<StepProgress>,
    /// Why it failed.
    pub failed: Option<Failure>,
    /// Whether its state is kept.
    pub keeping: Keeping,
}

/// How the runs are left whose workers have been asked to end: what their autosaves know, because the last events are
/// not on the screen any more.
pub(super) fn left(app: &App, logbooks: &BTreeMap<RunId, SharedAutosave>) -> Vec<Left> {
    let of_slot = |(slot, place): (usize, &Slot)| {
        let run = place.run.as_ref()?;
        let autosave = logbooks.get(&run.id)?;
        let left = |report: Option<&Report>, keeping| Left {
            slot,
            name: place.name.clone(),
            step: report.map_or(0, |report| report.step),
            scalars: report.map(|report| (report.t, report.total_energy)),
            underway: None,
            failed: None,
            keeping,
        };
        // Where the disk does not answer nobody waits for it.
        let Ok(autosave) = autosave.try_lock() else {
            let why = "it could not be written in time".to_owned();
            let report = run.setting.is_some().then_some(&run.report);
            return Some(left(report, Keeping::Failed(why)));
        };
        let keeping = match autosave.keeping() {
            Keeping::Pending if autosave.has_steps() => {
                Keeping::Failed("the step in hand took too long".to_owned())
            }
            keeping => keeping,
        };
        let kept_step = match &keeping {
            Keeping::Kept(kept) => kept.step,
            Keeping::Pending | Keeping::Failed(_) => 0,
        };
        let left = left(autosave.latest(), keeping);
        Some(Left {
            // Before it has reported its first state it is where it was kept.
            step: left.scalars.map_or(kept_step, |_| left.step),
            underway: autosave.underway(),
            failed: autosave.failed().cloned(),
            ..left
        })
    };
    let slots = app.slots.iter().enumerate();
    slots.filter_map(of_slot).collect()
}

/// Whether runs have failed.
pub(super) fn failed(left: &[Left]) -> Option<Failed> {
    let failures = || left.iter().filter_map(|left| left.failed.as_ref());
    failures().next()?;
    Some(Failed {
        is_of_scene: failures().all(|failure| failure.is_of_scene),
    })
}

/// Why the states of runs are lost.
pub(super) fn failures(left: &[Left]) -> Vec<String> {
    let failure = |run: &Left| match &run.keeping {
        Keeping::Failed(why) => Some(format!("{} (step {}): {why}", run.name, run.step)),
        Keeping::Pending | Keeping::Kept(_) => None,
    };
    left.iter().filter_map(failure).collect()
}

/// What was removed that processes had left behind which were killed.
pub(super) fn leftovers(removed: &[Leftover]) -> Option<String> {
    let first = removed.first()?;
    let bytes = removed.iter().map(|leftover| leftover.bytes).sum();
    let more = match removed.len() {
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    Some(format!(
        "removed what a process that was killed had saved by half: {}{more} ({})",
        first.path.display(),
        size(bytes)
    ))
}

fn size(bytes: u64) -> String {
    indicatif::DecimalBytes(bytes).to_string()
}

/// Where the states of runs are kept.
fn kept_words(left: &[Left]) -> Option<String> {
    let kept = |run: &'_ Left| match &run.keeping {
        Keeping::Kept(kept) => Some((run.step, kept.clone())),
        Keeping::Pending | Keeping::Failed(_) => None,
    };
    let kept: Vec<(u64, KeptAt)> = left.iter().filter_map(kept).collect();
    let bytes = size(kept.iter().map(|(_, kept)| kept.bytes).sum());
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.into());
    match &kept[..] {
        [] => None,
        [(step, kept)] => {
            let at = match kept.step {
                at if at < *step => format!(" at step {at}"),
                _ => String::new(),
            };
            let path = whole(&kept.folder);
            Some(format!("kept{at} in {} ({bytes})", path.display()))
        }
        [(_, first), ..] => {
            let path = whole(first.folder.parent().unwrap_or(&first.folder));
            let count = kept.len();
            Some(format!("{count} runs kept in {} ({bytes})", path.display()))
        }
    }
}

/// The scene that was shown last, how far it came, and where things were saved and kept.
pub(super) fn line(app: &App, saved: &[PathBuf], left: &[Left]) -> String {
    let mut line = match app.slots.get(app.active) {
        Some(slot) => match &slot.run {
            Some(run) => {
                let left = left.iter().find(|left| left.slot == app.active);
                format!("{}: {}", slot.name, progress(run, left))
            }
            None => format!("{}: not run", slot.name),
        },
        None => "nothing was run".to_owned(),
    };
    let others = app
        .slots
        .iter()
        .enumerate()
        .filter(|(index, slot)| *index != app.active && slot.run.is_some())
        .count();
    // Writing to a String cannot fail.
    let _ = match others {
        0 => Ok(()),
        1 => write!(line, " (and 1 other run)"),
        _ => write!(line, " (and {others} other runs)"),
    };
    for left in left.iter().filter(|left| left.slot != app.active) {
        if let Some(failure) = &left.failed {
            let _ = write!(line, "; {} failed: {failure}", left.name);
        }
    }
    let kept = kept_words(left);
    if let Some(kept) = &kept {
        let _ = write!(line, "; {kept}");
    }
    match saved {
        [] if kept.is_none() => line.push_str("; nothing was saved"),
        [] => {}
        _ => {
            let named: Vec<String> = saved
                .iter()
                .rev()
                .take(NAMED)
                .map(|path| path.display().to_string())
                .collect();
            let _ = write!(line, "; saved in {}", named.join(", "));
            if saved.len() > NAMED {
                let _ = write!(line, " and {} more", saved.len() - NAMED);
            }
        }
    }
    line
}

/// How far a run came, and why it failed, if it did.
fn progress(run: &Run, left: Option<&Left>) -> String {
    let failure = left.and_then(|left| left.failed.as_ref());
    let left = left.filter(|left| left.scalars.is_some() || left.step > 0);
    let Some(left) = left else {
        return match failure {
            Some(failure) => format!("failed: {failure}"),
            None => "not yet at its first state".to_owned(),
        };
    };
    let of = match run.steps() {
        Some(steps) => format!(" of {steps}"),
        None => String::new(),
    };
    let mut words = format!("step {}{of}", left.step);
    // Writing to a String cannot fail.
    if let Some((t, energy)) = left.scalars {
        let _ = write!(
            words,
            ", t = {}, E_total = {}",
            ShortNumber(t),
            ShortNumber(energy)
        );
    }
    if let Some(StepProgress { step, t, .. }) = left.underway {
        let _ = write!(words, ", and within step {step} at t = {}", ShortNumber(t));
    }
    if let Some(failure) = failure {
        let _ = write!(words, "; failed: {failure}");
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::simulation::Setting;
    use std::sync::Arc;

    fn left(name: &str, step: u64, keeping: Keeping) -> Left {
        Left {
            slot: 0,
            name: name.to_owned(),
            step,
            scalars: None,
            underway: None,
            failed: None,
            keeping,
        }
    }

    fn kept(name: &str, step: u64, bytes: u64) -> Left {
        let folder = PathBuf::from("/here/saved/unfinished").join(name);
        left(
            name,
            9,
            Keeping::Kept(KeptAt {
                folder,
                step,
                bytes,
            }),
        )
    }

    fn tail(saved: &[PathBuf], left: &[Left]) -> String {
        let app = App::new(Vec::new(), 0, (80, 24), 10);
        let line = line(&app, saved, left);
        line.strip_prefix("nothing was run")
            .expect(&line)
            .to_owned()
    }

    #[test]
    fn the_line_says_what_is_kept_and_what_was_saved() {
        let saved = [PathBuf::from("/here/saved/a-set")];
        assert_eq!(tail(&[], &[]), "; nothing was saved");
        assert_eq!(tail(&saved, &[]), "; saved in /here/saved/a-set");
        let one = [kept("a", 9, 2_700_000)];
        assert_eq!(
            tail(&[], &one),
            "; kept in /here/saved/unfinished/a (2.70 MB)"
        );
        let late = [kept("a", 7, 999)];
        assert_eq!(
            tail(&saved, &late),
            "; kept at step 7 in /here/saved/unfinished/a (999 B); saved in /here/saved/a-set"
        );
        let two = [kept("a", 9, 2_000_000), kept("b", 9, 1_000_000)];
        assert_eq!(
            tail(&[], &two),
            "; 2 runs kept in /here/saved/unfinished (3.00 MB)"
        );
    }

    fn run_of(steps: u64) -> (Slot, Run) {
        let text = "[time]\nstep = 1e-6\nend = 1e-3";
        let scene = Scene::of_text(text, &[]);
        let mut run = Run::new(RunId(1), None);
        run.setting = Some(Arc::new(Setting {
            scene: scene.clone(),
            steps: Some(steps),
            warnings: Vec::new(),
        }));
        (Slot::new("a", None, scene), run)
    }

    #[test]
    fn the_line_tells_what_the_logbook_knows_and_not_the_screen() {
        let (_, mut run) = run_of(1000);
        run.report.step = 7;
        let mut left = kept("a", 9, 1);
        left.scalars = Some((9e-6, 30.5));
        assert_eq!(
            progress(&run, Some(&left)),
            "step 9 of 1000, t = 9e-6, E_total = 30.5"
        );
        left.underway = Some(StepProgress {
            step: 10,
            t: 9.5e-6,
            end: 1e-5,
            dt: 1e-9,
            parts: 3,
            refused: 2,
        });
        assert_eq!(
            progress(&run, Some(&left)),
            "step 9 of 1000, t = 9e-6, E_total = 30.5, and within step 10 at t = 9.5e-6"
        );
        left.failed = Some(Failure {
            words: "it did not converge".to_owned(),
            is_of_scene: false,
        });
        assert!(progress(&run, Some(&left)).ends_with("t = 9.5e-6; failed: it did not converge"));
        left.scalars = None;
        left.step = 0;
        assert_eq!(progress(&run, Some(&left)), "failed: it did not converge");
        assert_eq!(progress(&run, None), "not yet at its first state");
    }

    #[test]
    fn a_run_that_failed_is_named_and_decides_the_exit_status() {
        let failing = |slot, is_of_scene| Left {
            slot,
            failed: Some(Failure {
                words: "too large".to_owned(),
                is_of_scene,
            }),
            ..left("b", 0, Keeping::Pending)
        };
        let good = left("a", 4, Keeping::Pending);
        assert_eq!(failed(std::slice::from_ref(&good)), None);
        let of = |runs: &[Left]| failed(runs).map(|failed| failed.is_of_scene);
        assert_eq!(of(&[good.clone(), failing(1, true)]), Some(true));
        assert_eq!(of(&[failing(0, false), failing(1, true)]), Some(false));
        assert_eq!(
            tail(&[], &[good, failing(1, true)]),
            "; b failed: too large; nothing was saved"
        );
    }

    #[test]
    fn what_is_lost_is_no_line_but_an_error() {
        let why = Keeping::Failed("cannot write a: it is full".to_owned());
        let runs = [kept("a", 9, 1), left("b", 4, why)];
        assert_eq!(failures(&runs), ["b (step 4): cannot write a: it is full"]);
        assert!(failures(&runs[..1]).is_empty());
        assert_eq!(tail(&[], &runs[1..]), "; nothing was saved");
    }

    #[test]
    fn leftovers_are_told_with_their_size() {
        let leftover = |name: &str, bytes| Leftover {
            path: name.into(),
            bytes,
        };
        assert_eq!(leftovers(&[]), None);
        let words = leftovers(&[
            leftover("saved/x.part", 239_000_000),
            leftover("b", 1_000_000),
        ]);
        let words = words.expect("words");
        assert!(
            words.ends_with("saved/x.part and 1 more (240.00 MB)"),
            "{words}"
        );
    }
}
