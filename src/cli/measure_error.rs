//! `vesica run SCENE --measure-error`: the same scene, finer, on another core beside the run, and what the two differ by.
//!
//! The run itself is recorded as ever, and can be resumed. The finer runs are in memory only: where the process is ended before
//! they are done they begin again with `--resume --measure-error`, which measures a finished run from its snapshots.

use super::error::CliError;
use super::output;
use super::signals::EndSignal;
use crate::record::{
    FinerRun, MeasuredErrorRecord, RecordedRun, RunSummary, ShortNumber, read_run,
    write_error_table,
};
use crate::scene::Scene;
use crate::simulation::{Schedule, SimulationError, check_memory};
use crate::study::{ErrorRow, FinerNews, FinerRuns, Sample, error_table, error_words};
use indicatif::{ProgressBar, ProgressStyle};
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How often it is looked whether the finer runs are done, and how far they are.
const INTERVAL: Duration = Duration::from_millis(100);

/// Parts of the bar.
const PARTS: u64 = 1000;

/// The states of the two finer runs at the times of the snapshots, and what the runs were.
struct Computed {
    samples: [Vec<Sample>; 2],
    runs: [FinerRun; 2],
}

/// The finer runs that are computed beside a run.
pub(super) struct MeasuredRun {
    finer: FinerRuns,
    times: Vec<f64>,
    end: f64,
    thread: Option<JoinHandle<Result<Option<Computed>, SimulationError>>>,
    /// How much of them is done, in parts.
    done: Arc<AtomicU64>,
    /// Ends them.
    called_off: Arc<AtomicBool>,
}

/// Refuses what cannot be measured, before anything begins.
///
/// # Errors
/// [`CliError::FinerRun`]: there is no memory for the finer run.
pub(super) fn check(scene: &Scene, factor: f64) -> Result<(), CliError> {
    let finer = FinerRuns::of(scene, factor);
    let [_, finest] = finer.scenes();
    check_memory(finest).map_err(|error| CliError::FinerRun {
        words: finer.words(),
        error,
    })
}

impl MeasuredRun {
    /// Begins the finer runs on a thread of their own; they end when a signal comes, or when this is dropped.
    ///
    /// # Errors
    /// [`CliError::Thread`].
    pub(super) fn begin(
        scene: &Scene,
        schedule: &Schedule,
        factor: f64,
        signal: &EndSignal,
    ) -> Result<Self, CliError> {
        let finer = FinerRuns::of(scene, factor);
        // A run without snapshots has the fields at its end.
        let schedule = Schedule {
            snapshots: schedule.snapshots.max(1),
            ..*schedule
        };
        let times = schedule.snapshot_times(scene.time.step);
        let done = Arc::new(AtomicU64::new(0));
        let called_off = Arc::new(AtomicBool::new(false));
        let compute = {
            let (finer, times, signal) = (finer.clone(), times.clone(), signal.clone());
            let (done, called_off) = (Arc::clone(&done), Arc::clone(&called_off));
            move || {
                let mut samples = [Vec::new(), Vec::new()];
                let runs = finer.compute(&times, &mut |news| {
                    match news {
                        FinerNews::Share(share) => {
                            done.store((PARTS as f64 * share) as u64, Ordering::Relaxed);
                        }
                        FinerNews::Sample(run, _, state) => samples[run].push(Sample::of(state)),
                    }
                    !called_off.load(Ordering::Relaxed) && signal.received().is_none()
                })?;
                Ok(runs.map(|runs| Computed { samples, runs }))
            }
        };
        let thread = thread::Builder::new()
            .name("finer runs".to_owned())
            .spawn(compute)
            .map_err(CliError::Thread)?;
        Ok(Self {
            finer,
            times,
            end: schedule.end,
            thread: Some(thread),
            done,
            called_off,
        })
    }

    /// Waits for the finer runs, compares the recorded run with them, and writes what is measured into its folder.
    ///
    /// # Errors
    /// [`CliError`]: a signal came, a finer run failed, or something cannot be read or written. The run itself
    /// is recorded.
    pub(super) fn finish(
        mut self,
        folder: &Path,
        mut summary: RunSummary,
        signal: &EndSignal,
    ) -> Result<(), CliError> {
        let computed = self.wait();
        let computed = match computed.map_err(|error| CliError::FinerRun {
            words: self.finer.words(),
            error,
        })? {
            Some(computed) => computed,
            None => {
                let signal = signal.received();
                let name = signal.map_or("a signal", |it| it.name);
                return Err(CliError::MeasurementInterrupted {
                    signal: name,
                    folder: folder.to_owned(),
                });
            }
        };
        let rows = self.compare(&read_run(folder)?, &computed);
        let table = write_error_table(folder, &error_table(&rows)).map_err(CliError::Record)?;
        let last = rows.last();
        summary.measured_error = Some(MeasuredErrorRecord {
            table,
            factor: self.finer.factor(),
            same_mesh: self.finer.same_mesh().map(str::to_owned),
            runs: computed.runs,
            t: last.map(|row| row.t),
            observed_order: last.and_then(|row| row.order),
            phi_error: last.map(|row| row.phase.error),
            phi_uncertainty: last.map(|row| row.phase.uncertainty),
        });
        summary.write_in(folder).map_err(CliError::Record)?;
        output::summary(self.words(&rows, &computed.runs).trim_end())
    }

    fn wait(&mut self) -> Result<Option<Computed>, SimulationError> {
        let Some(thread) = self.thread.take() else {
            return Ok(None);
        };
        let bar = ProgressBar::with_draw_target(Some(PARTS), output::progress_target());
        // The template is right; if it ever were not, the plain bar serves.
        if let Ok(style) =
            ProgressStyle::with_template("finer runs  {bar:24} {percent} %  {elapsed}")
        {
            bar.set_style(style);
        }
        while !thread.is_finished() {
            bar.set_position(self.done.load(Ordering::Relaxed));
            thread::sleep(INTERVAL);
        }
        bar.finish_and_clear();
        // A panic there is a mistake of the program, as it is here.
        thread.join().unwrap_or_else(|panic| resume_unwind(panic))
    }

    /// The errors at all times of which the run has a snapshot.
    fn compare(&self, run: &RecordedRun, computed: &Computed) -> Vec<ErrorRow> {
        let rows = self.times.iter().enumerate().filter_map(|(index, &t)| {
            let is_there = |known: f64| (known - t).abs() <= 1e-9 * self.end;
            let fields = run.fields.iter().find(|fields| is_there(fields.t))?;
            let own = Sample::recorded(&fields.mesh, &fields.state, fields.step, &run.history);
            let [between, finer] = &computed.samples;
            let factor = self.finer.factor();
            ErrorRow::new(t, factor, &own, between.get(index)?, finer.get(index)?)
        });
        rows.collect()
    }

    fn words(&self, rows: &[ErrorRow], runs: &[FinerRun; 2]) -> String {
        let run = |run: &FinerRun| {
            format!(
                "{} nodes, {} steps, {} s",
                run.nodes,
                run.steps,
                ShortNumber((10.0 * run.seconds).round() / 10.0)
            )
        };
        let [between, finer] = runs;
        let mut text = format!(
            "measured error, against the same scene {} ({}; between them {}):\n{}",
            self.finer.words(),
            run(finer),
            run(between),
            error_words(rows, &["E_total", "length", "waist"])
        );
        if rows.iter().any(|row| !row.has_sane_order()) {
            text.push_str(
                "off: the observed order is not near 2, and the uncertainty has a safety factor of 3\n",
            );
        }
        if rows.len() < self.times.len() {
            let missing = self.times.len() - rows.len();
            text.push_str(&format!("{missing} snapshots of the run are not there\n"));
        }
        text
    }
}

impl Drop for MeasuredRun {
    fn drop(&mut self) {
        self.called_off.store(true, Ordering::Relaxed);
    }
}
