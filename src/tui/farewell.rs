//! What the app says at its end, and of what an earlier one left.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::keeping::SharedLogbook;
use super::state::{App, Keeping, Run, Slot, Status};
use crate::record::{Brief, KeptAt, Leftover};
use crate::simulation::RunId;

/// More folders than this are counted, not named.
const NAMED: usize = 3;

/// How a run is left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Left {
    /// The word for its scene.
    pub name: String,
    /// The step that it came to.
    pub step: u64,
    /// Whether its state is kept.
    pub keeping: Keeping,
}

/// How the runs are left, whose workers have been told to end.
pub(super) fn left(app: &App, logbooks: &BTreeMap<RunId, SharedLogbook>) -> Vec<Left> {
    let of_slot = |slot: &Slot| {
        let run = slot.run.as_ref()?;
        let logbook = logbooks.get(&run.id)?;
        // Where the disk does not answer nobody waits for it.
        let keeping = match logbook.try_lock() {
            Ok(logbook) if logbook.keeping() != Keeping::Pending => logbook.keeping(),
            Ok(logbook) if logbook.has_steps() => {
                Keeping::Failed("the step in hand took too long".to_owned())
            }
            Ok(_) => return None,
            Err(_) => Keeping::Failed("it could not be written in time".to_owned()),
        };
        Some(Left {
            name: slot.name.clone(),
            step: run.report.step,
            keeping,
        })
    };
    app.slots.iter().filter_map(of_slot).collect()
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
                // The news of the last steps are on their way.
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
            Some(run) => format!("{}: {}", slot.name, progress(run)),
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

fn progress(run: &Run) -> String {
    let Some(setting) = &run.setting else {
        return match &run.status {
            Status::Failed(why) => format!("failed: {why}"),
            _ => "not yet at its first state".to_owned(),
        };
    };
    let report = &run.report;
    let of = match setting.steps {
        Some(steps) => format!(" of {steps}"),
        None => String::new(),
    };
    let failed = match &run.status {
        Status::Failed(why) => format!("; failed: {why}"),
        _ => String::new(),
    };
    format!(
        "step {}{of}, t = {}, E_total = {}{failed}",
        report.step,
        Brief(report.t),
        Brief(report.total_energy),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(name: &str, step: u64, keeping: Keeping) -> Left {
        Left {
            name: name.to_owned(),
            step,
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
