//! The bar that shows how far a run is.

use super::output;
use crate::scene::significant;
use crate::simulation::{Report, Schedule};
use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How often the bar is brought up to date.
const INTERVAL: Duration = Duration::from_millis(200);

/// A bar on the standard error, where that is a terminal: step, rate, time left and energy.
#[derive(Debug)]
pub(super) struct Progress {
    bar: ProgressBar,
    schedule: Schedule,
    updated: Instant,
    /// Where it leaves its share, if another one shows it; `bar` is that one.
    share: Option<Arc<AtomicU64>>,
}

/// Parts of a bar whose number of steps is not known.
const PARTS: u64 = 1000;

impl Progress {
    /// A bar for a run of this schedule.
    pub fn new(schedule: &Schedule) -> Progress {
        let length = schedule.steps.unwrap_or(PARTS);
        let bar = ProgressBar::with_draw_target(Some(length), output::progress_target());
        Progress::with(schedule, bar)
    }

    /// A bar among others, for the run of this name.
    pub fn among(bars: &MultiProgress, name: &str, schedule: &Schedule) -> Progress {
        let bar = bars.add(ProgressBar::new(schedule.steps.unwrap_or(PARTS)));
        bar.set_prefix(format!("{name}  "));
        Progress::with(schedule, bar)
    }

    /// A part of what `bar` shows: leaves the share that is done, as the bits of a number, in `share`.
    pub fn part_of(bar: &ProgressBar, share: Arc<AtomicU64>, schedule: &Schedule) -> Progress {
        Progress {
            bar: bar.clone(),
            schedule: *schedule,
            updated: Instant::now(),
            share: Some(share),
        }
    }

    fn with(schedule: &Schedule, bar: ProgressBar) -> Progress {
        let template = match schedule.steps {
            Some(_) => "{prefix}{bar:24} {pos}/{len}  {rate}  {eta} left  {msg}",
            None => "{prefix}{bar:24} {percent} %  {eta} left  {msg}",
        };
        // The template is right; if it ever were not, the plain bar serves.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", rate));
        }
        Progress {
            bar,
            schedule: *schedule,
            updated: Instant::now(),
            share: None,
        }
    }

    /// Shows a step, unless the last was shown just now.
    pub fn show(&mut self, report: &Report) {
        if let Some(share) = &self.share {
            let done = self.schedule.share(report.step, report.t);
            share.store(done.to_bits(), Ordering::Relaxed);
            return;
        }
        if self.bar.is_hidden() || self.updated.elapsed() < INTERVAL {
            return;
        }
        self.updated = Instant::now();
        self.bar
            .set_message(format!("E = {}", significant(report.total_energy, 6)));
        self.bar.set_position(match self.schedule.steps {
            Some(_) => report.step,
            None => (PARTS as f64 * self.schedule.share(report.step, report.t)) as u64,
        });
    }

    /// Prints something on the standard error, above the bar.
    pub fn above(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }
}

/// Takes the bar away, so that what is printed next stands where it was.
impl Drop for Progress {
    fn drop(&mut self) {
        if self.share.is_none() {
            self.bar.finish_and_clear();
        }
    }
}

/// Steps a second.
fn rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    // The bar has no use for an error.
    let _ = write!(text, "{:.1} steps/s", state.per_sec());
}
