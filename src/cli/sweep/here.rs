//! A sweep on this machine: several runs at a time, each on a thread.

use super::point::{Ended, failure, run_point};
use super::{Here, count_of, duration, open, tell_same};
use crate::cli::error::CliError;
use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::signals::EndSignal;
use crate::record::write_whole;
use crate::signals::EndingSignal;
use crate::simulation::{cores, free_memory};
use crate::study::sweep::{Holder, Point, PointState, Sweep, SweepFolder, Table};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How often the bar is brought up to date.
const INTERVAL: Duration = Duration::from_millis(200);

/// Parts of the bar.
const PARTS: u64 = 1000;

/// Before so long there is no telling how long it will take.
const LEAST_FOR_ESTIMATE: Duration = Duration::from_secs(2);

/// Runs all points that are not done, and gives the sweep's folder. `check` may refuse a new sweep.
pub(super) fn run(
    plan: &Path,
    arguments: &Here,
    check: impl FnOnce(&Sweep) -> Result<(), CliError>,
) -> Result<SweepFolder, CliError> {
    let folder = open(plan, arguments.out.as_deref(), arguments.resume, |sweep| {
        check(sweep)?;
        Ok(sweep.needs.clone())
    })?;
    let signal = EndSignal::listen()?;
    tell_same(&folder);
    let is_left = |point: &&Point| folder.state(point) != PointState::Done;
    let left: Vec<&Point> = folder.runs().filter(is_left).collect();
    let were_done = folder.runs().count() - left.len();
    if were_done > 0 {
        let points = count_of(were_done, "point");
        output::note(format_args!("{points} done before; {} to do", left.len()));
    }
    let jobs = arguments.jobs.map_or(cores(), |jobs| jobs as usize);
    let jobs = jobs.min(left.len()).max(1);
    let work = Work::new(&folder, &left, cores() / jobs, arguments);
    work.all(jobs, &signal);

    // Before the table is read, so that it has all that is counted as done. Other processes may do points meanwhile.
    let is_left = |point: &&&Point| folder.state(point) != PointState::Done;
    let all = folder.runs().count();
    let done = all - left.iter().filter(is_left).count();
    let busy = work.busy().iter().filter(is_left).count();
    let untried = work.untried().iter().filter(is_left).count();
    let table = folder.path().join("table.csv");
    let text = Table::read(&folder).to_csv();
    write_whole(&table, |file| file.write_all(text.as_bytes()))?;
    if let Some(EndingSignal { name, .. }) = work.stopped() {
        return Err(CliError::SweepInterrupted {
            signal: name,
            done,
            all,
            folder: folder.path().to_owned(),
        });
    }
    let failed = work.failed.load(Ordering::Relaxed);
    if failed > 0 {
        return Err(CliError::PointsFailed {
            failed,
            busy,
            untried,
            all,
            folder: folder.path().to_owned(),
        });
    }
    if busy > 0 {
        return Err(CliError::PointsBusy {
            busy,
            done,
            all,
            folder: folder.path().to_owned(),
        });
    }
    output::summary(format_args!(
        "{}: {} done, in {}; the table: {}",
        folder.title(),
        count_of(folder.points().len(), "point"),
        folder.path().display(),
        table.display()
    ))?;
    Ok(folder)
}

/// The points that are to be run, and how far they are.
struct Work<'a> {
    folder: &'a SweepFolder,
    points: &'a [&'a Point],
    /// Shares of the runs that are done, as the bits of numbers.
    shares: Vec<Arc<AtomicU64>>,
    /// How much work each is beside the others.
    weights: Vec<f64>,
    next: AtomicUsize,
    running: AtomicUsize,
    done: AtomicUsize,
    failed: AtomicUsize,
    most_failures: usize,
    /// Those that another process works on.
    busy: Mutex<Vec<&'a Point>>,
    stopped: Mutex<Option<EndingSignal>>,
    memory: MemoryInUse,
    bar: ProgressBar,
    begun: Instant,
    /// Of a point.
    threads: usize,
    /// Without a terminal each point has a line.
    has_lines: bool,
    is_over: AtomicBool,
}

impl<'a> Work<'a> {
    fn new(
        folder: &'a SweepFolder,
        points: &'a [&'a Point],
        threads: usize,
        arguments: &Here,
    ) -> Self {
        let bar = ProgressBar::with_draw_target(Some(PARTS), output::progress_target());
        // The template is right; if it ever were not, the plain bar serves.
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {percent} %  {msg}") {
            bar.set_style(style);
        }
        let weight = |point: &&Point| {
            let needs = folder.needs(point);
            needs.map_or(1.0, |needs| needs.seconds.unwrap_or(needs.work))
        };
        Work {
            folder,
            points,
            shares: points.iter().map(|_| Arc::default()).collect(),
            weights: points.iter().map(weight).collect(),
            next: AtomicUsize::new(0),
            running: AtomicUsize::new(0),
            done: AtomicUsize::new(0),
            failed: AtomicUsize::new(0),
            most_failures: arguments
                .max_failures
                .map_or(usize::MAX, |most| most as usize),
            busy: Mutex::default(),
            stopped: Mutex::new(None),
            threads,
            memory: MemoryInUse::new(),
            has_lines: bar.is_hidden(),
            bar,
            begun: Instant::now(),
            is_over: AtomicBool::new(false),
        }
    }

    /// Runs all points, `jobs` at a time.
    fn all(&self, jobs: usize, signal: &EndSignal) {
        thread::scope(|scope| {
            let show = || {
                while !self.is_over.load(Ordering::Relaxed) {
                    self.show();
                    thread::sleep(INTERVAL);
                }
            };
            if !self.bar.is_hidden() {
                // Without this thread the bar stands still.
                let _ = thread::Builder::new().spawn_scoped(scope, show);
            }
            let work = || self.some(signal);
            let others =
                (1..jobs).map_while(|_| thread::Builder::new().spawn_scoped(scope, work).ok());
            // One of them is this thread: where the system starts no other, it does all.
            let others: Vec<_> = others.collect();
            work();
            for other in others {
                if let Err(panic) = other.join() {
                    self.is_over.store(true, Ordering::Relaxed);
                    std::panic::resume_unwind(panic);
                }
            }
            self.is_over.store(true, Ordering::Relaxed);
        });
        self.bar.finish_and_clear();
    }

    /// Runs one point after the other, as long as there are any.
    fn some(&self, signal: &EndSignal) {
        while self.stopped().is_none() && self.failed.load(Ordering::Relaxed) <= self.most_failures
        {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(point) = self.points.get(number) else {
                return;
            };
            if let Some(signal) = signal.received() {
                self.stop(signal);
                return;
            }
            let memory = self.folder.needs(point).map_or(0, |needs| needs.memory);
            let _memory = self.memory.take(memory);
            self.running.fetch_add(1, Ordering::Relaxed);
            let ended = run_point(self.folder, point, self.threads, signal, &|schedule| {
                Progress::part_of(&self.bar, Arc::clone(&self.shares[number]), schedule)
            });
            self.running.fetch_sub(1, Ordering::Relaxed);
            self.shares[number].store(1.0_f64.to_bits(), Ordering::Relaxed);
            match ended {
                Ok(Ended::Done | Ended::WasDone) => {
                    let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
                    if self.has_lines {
                        let all = self.points.len();
                        output::note(format_args!("{}: done, {done} of {all}", point.name));
                    }
                }
                Ok(Ended::Stopped(signal)) => self.stop(signal),
                Ok(Ended::Failed(reason)) => self.fail(point, &reason),
                Ok(Ended::Busy(holder)) => self.leave(point, &holder),
                Err(error) => self.fail(point, &error.to_string()),
            }
        }
    }

    fn fail(&self, point: &Point, reason: &str) {
        self.failed.fetch_add(1, Ordering::Relaxed);
        self.bar.suspend(|| output::error(failure(point, reason)));
    }

    /// Leaves a point to the process that works on it.
    fn leave(&self, point: &'a Point, holder: &Holder) {
        let mut busy = self.busy.lock().unwrap_or_else(PoisonError::into_inner);
        busy.push(point);
        let note = || output::note(format_args!("{}: {holder} works on it", point.name));
        self.bar.suspend(note);
    }

    /// The points that were left to other processes.
    fn busy(&self) -> Vec<&'a Point> {
        let busy = self.busy.lock().unwrap_or_else(PoisonError::into_inner);
        busy.clone()
    }

    /// The points that no thread has come to.
    fn untried(&self) -> &'a [&'a Point] {
        let tried = self.next.load(Ordering::Relaxed);
        self.points.get(tried..).unwrap_or_default()
    }

    fn stop(&self, signal: EndingSignal) {
        *self.stopped.lock().unwrap_or_else(PoisonError::into_inner) = Some(signal);
    }

    fn stopped(&self) -> Option<EndingSignal> {
        *self.stopped.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn show(&self) {
        let all: f64 = self.weights.iter().sum();
        let share = |share: &Arc<AtomicU64>| f64::from_bits(share.load(Ordering::Relaxed));
        let parts = self.weights.iter().zip(&self.shares);
        let done =
            parts.map(|(weight, it)| weight * share(it)).sum::<f64>() / all.max(f64::MIN_POSITIVE);
        let elapsed = self.begun.elapsed();
        let left = match done > 0.0 && elapsed > LEAST_FOR_ESTIMATE {
            true => format!(
                "  {} left",
                duration(elapsed.as_secs_f64() * (1.0 - done) / done)
            ),
            false => String::new(),
        };
        let count = |number: &AtomicUsize| number.load(Ordering::Relaxed);
        let failed = match count(&self.failed) {
            0 => String::new(),
            failed => format!(", {failed} failed"),
        };
        self.bar.set_position((PARTS as f64 * done) as u64);
        self.bar.set_message(format!(
            "{} of {} points, {} running{failed}{left}",
            count(&self.done),
            self.points.len(),
            count(&self.running)
        ));
    }
}

/// The memory that runs in hand may come to take, so that no more are started than there is memory for.
struct MemoryInUse {
    /// `None`: the system does not say.
    free: Option<u64>,
    used: Mutex<u64>,
    given_back: Condvar,
}

/// A part of it, until it is dropped.
struct Taken<'a> {
    memory: &'a MemoryInUse,
    bytes: u64,
}

impl MemoryInUse {
    fn new() -> Self {
        Self::of(free_memory().map(|free| free.bytes))
    }

    fn of(free: Option<u64>) -> Self {
        MemoryInUse {
            free,
            used: Mutex::new(0),
            given_back: Condvar::new(),
        }
    }

    /// Waits until there is so much. A run that needs more than all there is goes alone.
    fn take(&self, bytes: u64) -> Taken<'_> {
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let is_short = |used: u64| {
            let is_more = |free| used.saturating_add(bytes) > free;
            used > 0 && self.free.is_some_and(is_more)
        };
        while is_short(*used) {
            let waited = self.given_back.wait(used);
            used = waited.unwrap_or_else(PoisonError::into_inner);
        }
        *used += bytes;
        Taken {
            memory: self,
            bytes,
        }
    }
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        let mut used = self
            .memory
            .used
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *used = used.saturating_sub(self.bytes);
        drop(used);
        self.memory.given_back.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;

    #[test]
    fn never_more_at_a_time_than_there_is() {
        let memory = MemoryInUse::of(Some(100));
        let (now, most) = (AtomicU64::new(0), AtomicU64::new(0));
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let _taken = memory.take(40);
                    let used = now.fetch_add(40, Ordering::SeqCst) + 40;
                    most.fetch_max(used, Ordering::SeqCst);
                    thread::sleep(Duration::from_millis(5));
                    now.fetch_sub(40, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(most.load(Ordering::SeqCst), 80);
        // Alone, even if it is too large; and together, if nothing is known.
        drop(memory.take(1000));
        let unknown = MemoryInUse::of(None);
        let _both = (unknown.take(u64::MAX / 2), unknown.take(1));
    }
}
