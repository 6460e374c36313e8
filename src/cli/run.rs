//! `vesica run SCENE`: simulate a scene and record it in a folder.

use super::error::CliError;
use super::measure_error::{self, MeasuredRun};
use super::numbers;
use super::output;
use super::overrides::Overrides;
use super::progress::Progress;
use super::set_up::{Outcome, set_up};
use super::shell::scenes;
use super::signals::EndSignal;
use crate::record::{
    Ending, EventRecord, Found, IfOccupied, RecordError, Recorder, RecorderBuilder, Resumption,
    RunFolder, RunSummary, Schedule, Settings, ShortNumber, Status, load_run_scene, load_scene,
    same_run, step_count,
};
use crate::scene::{Scene, Time, preset};
use crate::signals::EndingSignal;
use crate::simulation::{
    Simulation, SimulationError, StepProgress, check_memory, check_outlines, cores,
    threads_that_pay,
};
use clap_complete::ArgValueCompleter;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where runs go that are given no folder.
const RUNS: &str = "runs";

/// Arguments of `vesica run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit status: 0 done; 1 the run failed; 2 the arguments or the scene are wrong; 75 ended by a signal, such as \
Ctrl-C, with everything saved: --resume continues it; 128 + n ended at once by a second signal n.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file; with --resume also a run's folder
    #[arg(add = ArgValueCompleter::new(scenes))]
    scene: OsString,

    /// The run's folder [default: runs/NAME, then runs/NAME-2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    overrides: Overrides,

    /// End at the step nearest to this time, in place of time.end
    #[arg(long, value_name = "T", conflicts_with = "steps", value_parser = numbers::time,
          allow_negative_numbers = true)]
    until: Option<f64>,

    /// End after so many steps, in place of time.end
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Record a row every N steps, and at the end [default: 1]
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    every: Option<u64>,

    /// Save the fields at N times, evenly from 0 to the end [default: 5]
    #[arg(long, value_name = "N", value_parser = numbers::count, allow_negative_numbers = true)]
    snapshots: Option<u64>,

    /// Save the state every so many seconds, to go on from; 0: after every step [default: 30]
    #[arg(long, value_name = "SECONDS", env = "VESICA_CHECKPOINT", value_parser = numbers::seconds,
          allow_negative_numbers = true)]
    checkpoint: Option<Duration>,

    /// Compute in N threads; the numbers are the same [default: as many as there are and pay]
    #[arg(long, value_name = "N", env = "VESICA_THREADS", value_parser = numbers::threads,
          allow_negative_numbers = true)]
    threads: Option<usize>,

    /// Measure the error: compute the same scene beside it FACTOR times finer, in mesh and steps, on another core, and
    /// compare at every snapshot. With --resume also of a finished run
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, require_equals = true,
          default_missing_value = "2", value_parser = numbers::factor)]
    measure_error: Option<f64>,

    /// Leave the computer's name out of run.json, as where VESICA_NO_HOST is set
    #[arg(long)]
    no_host: bool,

    /// Replace the run that the folder holds
    #[arg(long, conflicts_with = "resume")]
    force: bool,

    /// Go on with a run that was ended, in DIR or else the latest of this scene; where there is none,
    /// begin it
    #[arg(long)]
    resume: bool,
}

impl Arguments {
    /// What is recorded; where nothing is said, what `default` has.
    fn settings(&self, default: Settings) -> Settings {
        Settings {
            every: self.every.unwrap_or(default.every),
            snapshots: self.snapshots.unwrap_or(default.snapshots),
            checkpoint: self.checkpoint.unwrap_or(default.checkpoint),
            host: default.host && !self.no_host,
        }
    }

    fn with_threads(&self, mut simulation: Simulation) -> Simulation {
        let nodes = simulation.mesh().nodes().len();
        let threads = self.threads;
        simulation.set_threads(threads.unwrap_or_else(|| threads_that_pay(nodes, cores())));
        simulation
    }
}

/// Simulates the scene and records it.
pub(super) fn run(arguments: &Arguments) -> Result<(), CliError> {
    let (scene, name) = scene(arguments)?;
    check_memory(&scene).map_err(CliError::SetUp)?;
    // Before a folder is made.
    check_outlines(&scene).map_err(CliError::SetUp)?;
    if let Some(factor) = arguments.measure_error {
        measure_error::check(&scene, factor)?;
    }
    let signal = EndSignal::listen()?;
    let found = if arguments.resume {
        find(arguments, &scene, &name)?
    } else {
        Found::Nothing
    };
    let folder = match (found, taken_folder(arguments)) {
        (Found::Run(resumption), _) => {
            return reopen(arguments, &scene, *resumption, &signal);
        }
        (Found::Abandoned, Some(path)) => RunFolder::at(&path, IfOccupied::Replace),
        _ => folder(arguments, &name),
    };
    let folder = folder.map_err(CliError::Folder)?;
    let settings = arguments.settings(Settings::default());
    let preparation = RecorderBuilder::begin(folder, &scene, settings)?;
    let begun = Instant::now();
    let simulation = match set_up(&scene, &signal)? {
        Outcome::Ready(simulation) => arguments.with_threads(*simulation),
        Outcome::Signal(signal) => {
            let folder = preparation.folder().to_owned();
            preparation.end(Ending::Interrupted(signal.name))?;
            return Err(ended_in_set_up(signal, folder));
        }
        Outcome::Failed(error) => {
            // The error of the set-up is the one to tell.
            let _ = preparation.end(Ending::Failed(error.to_string()));
            return Err(CliError::SetUp(error));
        }
    };
    let recorder = preparation.start(&simulation, begun.elapsed())?;
    simulation.warnings().iter().for_each(output::warning);
    record(simulation, recorder, &signal, arguments)
}

/// Takes a run up again.
fn reopen(
    arguments: &Arguments,
    scene: &Scene,
    resumption: Resumption,
    signal: &EndSignal,
) -> Result<(), CliError> {
    let settings = arguments.settings(resumption.settings());
    let schedule = Schedule::new(&scene.time, settings.every, settings.snapshots);
    let (step, t) = (resumption.step(), resumption.t());
    let end = match schedule.steps {
        Some(steps) => format!("step {steps}"),
        None => format!("t = {}", ShortNumber(schedule.end)),
    };
    let path = resumption.folder().to_owned();
    let folder = path.display();
    let status = resumption.status();
    match status {
        Some(Status::Running) => {
            // It stays so if the run cannot be set up, or another signal comes.
            resumption.end_killed()?;
            output::note(format_args!(
                "the run in {folder} was killed: its run.json says \"running\", but no process has the \
                 folder"
            ));
        }
        None => output::note(format_args!(
            "how the run in {folder} ended is not known: its run.json cannot be read, and is rewritten"
        )),
        Some(_) => {}
    }
    let is_at_rest = resumption.is_at_rest();
    let is_over = is_at_rest || schedule.is_over(step, t);
    let is_beyond = match schedule.steps {
        Some(steps) => step > steps,
        None => t > schedule.end * (1.0 + 1e-9),
    };
    // The record of a run that was killed or interrupted, or failed, at its very end is yet to be ended.
    let is_to_end = match status {
        None | Some(Status::Running) => is_over,
        Some(Status::Failed | Status::Interrupted) => is_over && !is_beyond,
        Some(Status::Done) => false,
    };
    // A finished run is measured as it is.
    let is_to_end = is_to_end || (is_over && !is_beyond && arguments.measure_error.is_some());
    if is_over && (is_beyond || !is_to_end) {
        let left = if is_to_end {
            "its record is ended there"
        } else {
            "nothing to do"
        };
        let t = ShortNumber(t);
        match is_at_rest {
            true => output::note(format_args!(
                "the run in {folder} is at rest since step {step}, t = {t}: {left}"
            )),
            false => output::note(format_args!(
                "the run in {folder} is at step {step} already, t = {t}, and the end is {end}: {left} (a later \
                 end: --until T or --steps N)"
            )),
        }
    }
    if is_over && !is_to_end {
        return Ok(());
    }
    // A run that is beyond this end keeps its own.
    let own = (is_over && is_beyond)
        .then(|| load_run_scene(&path, &[]).ok())
        .flatten()
        .map(|loaded| loaded.scene)
        .filter(|own| same_run(own, scene));
    let scene = own.as_ref().unwrap_or(scene);
    let mut simulation = match set_up(scene, signal)? {
        Outcome::Ready(simulation) => arguments.with_threads(*simulation),
        Outcome::Signal(signal) => return Err(ended_in_set_up(signal, path)),
        Outcome::Failed(error) => return Err(CliError::SetUp(error)),
    };
    let (recorder, problems) = resumption.start(scene, settings, &mut simulation)?;
    problems.iter().for_each(output::damage);
    if is_over && is_beyond {
        recorder.finish(&mut simulation, Ending::Interrupted("an earlier end"))?;
        return Ok(());
    }
    let report = simulation.report();
    output::note(format_args!(
        "the run in {folder} goes on from step {}, t = {}, to {end}",
        report.step,
        ShortNumber(report.t)
    ));
    record(simulation, recorder, signal, arguments)
}

fn ended_in_set_up(EndingSignal { name, .. }: EndingSignal, folder: PathBuf) -> CliError {
    CliError::SetUpInterrupted {
        signal: name,
        folder,
    }
}

/// Simulates what is left to do, and ends the record.
fn record(
    mut simulation: Simulation,
    mut recorder: Recorder,
    signal: &EndSignal,
    arguments: &Arguments,
) -> Result<(), CliError> {
    let path = recorder.folder().to_owned();
    simulation.follow(recorder.schedule());
    let measured = arguments
        .measure_error
        .map(|factor| MeasuredRun::begin(simulation.scene(), recorder.schedule(), factor, signal));
    let measured = measured.transpose()?;
    let steps = recorder.schedule().steps;
    let progress = Progress::new(recorder.schedule());
    let stop = simulate(
        &mut simulation,
        &mut recorder,
        signal,
        progress,
        Events::Told,
    );
    let whereabouts = Box::new(recorder.whereabouts());
    let finished = recorder.finish(&mut simulation, stop.ending());
    let unrecorded = |error| CliError::Unrecorded {
        error,
        whereabouts: whereabouts.clone(),
    };
    match stop {
        Stop::Failed(error) => {
            if let Err(error) = finished {
                output::error(unrecorded(error));
            }
            Err(CliError::Run { error, whereabouts })
        }
        Stop::Signal(EndingSignal { name, .. }) => {
            let summary = finished.map_err(unrecorded)?;
            let within = summary.underway.filter(|underway| underway.refused > 0);
            Err(CliError::Interrupted {
                signal: name,
                step: summary.steps,
                of: steps.map_or(String::new(), |steps| format!(" of {steps}")),
                within: within.map_or(String::new(), |StepProgress { step, t, .. }| {
                    format!(", within step {step}, at t = {}", ShortNumber(t))
                }),
                folder: path,
            })
        }
        Stop::Done => {
            let summary = finished.map_err(unrecorded)?;
            output::summary(result_line(&summary, &path))?;
            match measured {
                Some(measured) => measured.finish(&path, summary, signal),
                None => Ok(()),
            }
        }
    }
}

/// Whether the events of a run are printed as they happen; `run.json` lists them in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Events {
    Told,
    /// For one of many runs.
    Untold,
}

/// Why the loop over the steps ended.
pub(super) enum Stop {
    Done,
    Signal(EndingSignal),
    Failed(SimulationError),
}

impl Stop {
    /// How the record is to end.
    pub fn ending(&self) -> Ending {
        match self {
            Stop::Done => Ending::Done,
            Stop::Signal(signal) => Ending::Interrupted(signal.name),
            Stop::Failed(error) => Ending::Failed(error.to_string()),
        }
    }
}

/// Makes the steps that are left, recording each, until one of them is the last. That something
/// cannot be written is reported once; it is written later, if it can be.
pub(super) fn simulate(
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    signal: &EndSignal,
    mut progress: Progress,
    told_events: Events,
) -> Stop {
    let mut computing = recorder.computed();
    let mut told = recorder.events().len();
    let mut is_behind = false;
    let mut patience = Patience::new(told_events);
    loop {
        let report = simulation.report();
        if recorder.schedule().is_done(report) {
            return Stop::Done;
        }
        if let Some(signal) = signal.received() {
            return Stop::Signal(signal);
        }
        let begun = Instant::now();
        let advanced = simulation.advance_unless(&mut |underway| {
            patience.look(underway, &progress);
            signal.received().is_some() || recorder.checkpoint_is_due()
        });
        computing += begun.elapsed();
        let recorded = match advanced {
            Ok(true) => recorder.step(simulation, computing),
            Ok(false) => recorder.within_step(simulation, computing),
            Err(error) => return Stop::Failed(error),
        };
        if let Err(error) = recorded
            && !is_behind
        {
            progress.above(|| output::error(format_args!("{error}; {GOES_ON}")));
        }
        if is_behind && !recorder.is_behind() {
            progress.above(|| output::note("the run is recorded again"));
        }
        is_behind = recorder.is_behind();
        let events = &recorder.events()[told..];
        if !events.is_empty() && told_events == Events::Told {
            progress.above(|| events.iter().for_each(tell));
        }
        told += events.len();
        progress.show(simulation.report());
    }
}

/// Tells of a step that takes long, seldom and more seldom.
struct Patience {
    told_events: Events,
    /// The step, since when, and after how long it is reported.
    step: Option<(u64, Instant, Duration)>,
}

impl Patience {
    /// After so long a step is reported for the first time.
    const FIRST: Duration = Duration::from_secs(10);

    fn new(told_events: Events) -> Self {
        Self {
            told_events,
            step: None,
        }
    }

    fn look(&mut self, underway: &StepProgress, progress: &Progress) {
        let (begun, told_after) = match self.step {
            Some((step, begun, told_after)) if step == underway.step => (begun, told_after),
            _ => (Instant::now(), Self::FIRST),
        };
        let is_told = begun.elapsed() >= told_after;
        let next = if is_told { 2 * told_after } else { told_after };
        self.step = Some((underway.step, begun, next));
        if is_told && self.told_events == Events::Told {
            progress.above(|| {
                output::note(format_args!(
                    "{underway}; Ctrl-C ends the run here, and --resume goes on"
                ));
            });
        }
    }
}

/// What a run does that cannot be recorded.
const GOES_ON: &str = "the run goes on in memory, and tries again every second";

/// Tells of something that happened in a run.
fn tell(event: &EventRecord) {
    let EventRecord { step, t, text, .. } = event;
    output::note(format_args!("step {step}, t = {}: {text}", ShortNumber(*t)));
}

/// The scene with all overrides, and what to call its runs.
fn scene(arguments: &Arguments) -> Result<(Scene, OsString), CliError> {
    let overrides = arguments.overrides.all();
    let mut loaded = match run_folder(arguments) {
        Some(folder) => load_run_scene(folder, &overrides)?,
        None => load_scene(&arguments.scene, &overrides)?,
    };
    let time = &mut loaded.scene.time;
    match (arguments.until, arguments.steps) {
        (Some(end), _) => time.end = end,
        (None, Some(_)) if time.tolerance.is_some() => return Err(CliError::StepsOfChosen),
        (None, Some(steps)) => time.end = steps as f64 * time.step,
        (None, None) => {}
    }
    let end_key = match (arguments.until, arguments.steps) {
        (Some(_), _) => "--until",
        (None, Some(_)) => "--steps",
        (None, None) => "time.end",
    };
    some_step_before(end_key, time)?;
    Ok((loaded.scene, loaded.name))
}

/// Refuses a scene that ends before its first step.
pub(super) fn some_step(time: &Time) -> Result<(), CliError> {
    some_step_before("time.end", time)
}

/// The same, of an end that is given by this key or option, and one that is too many steps away.
fn some_step_before(end_key: &'static str, time: &Time) -> Result<(), CliError> {
    let Time { end, step, .. } = *time;
    match step_count(time) {
        Some(0) => Err(CliError::NoStep { end_key, end, step }),
        _ if time.has_too_many_steps() => Err(CliError::TooManySteps { end_key, end, step }),
        _ => Ok(()),
    }
}

/// The folder of a run that is named in place of a scene, to be resumed.
fn run_folder(arguments: &Arguments) -> Option<&Path> {
    let path = Path::new(&arguments.scene);
    let is_preset = arguments.scene.to_str().and_then(preset).is_some();
    (arguments.resume && !is_preset && path.is_dir()).then_some(path)
}

/// The folder that the arguments name.
fn taken_folder(arguments: &Arguments) -> Option<PathBuf> {
    let named = arguments.out.as_deref();
    named.or(run_folder(arguments)).map(Path::to_owned)
}

/// The run to resume: in the folder that is named, or else the latest of the scene.
fn find(arguments: &Arguments, scene: &Scene, name: &OsStr) -> Result<Found, CliError> {
    let found = match taken_folder(arguments) {
        Some(path) => Resumption::find(&path, scene),
        None => Resumption::find_latest(Path::new(RUNS), name, scene),
    }?;
    if !matches!(found, Found::Run(_)) {
        output::note("there is no run to go on with: it begins at t = 0");
    }
    Ok(found)
}

/// The run's folder: the given one, or a new one; with `--force` and no name, the first.
fn folder(arguments: &Arguments, name: &OsStr) -> Result<RunFolder, RecordError> {
    let runs = Path::new(RUNS);
    match (&arguments.out, arguments.force) {
        (Some(path), true) => RunFolder::at(path, IfOccupied::Replace),
        (Some(path), false) => RunFolder::at(path, IfOccupied::Refuse),
        (None, true) => RunFolder::at(&runs.join(name), IfOccupied::Replace),
        (None, false) => RunFolder::numbered(runs, name),
    }
}

/// What came out, in one line.
fn result_line(summary: &RunSummary, folder: &Path) -> String {
    let energy = summary.total_energy.unwrap_or(f64::NAN);
    let per_step = 1e3 * summary.seconds / summary.steps.max(1) as f64;
    let steps = match summary.steps {
        1 => "1 step".to_owned(),
        steps => format!("{steps} steps"),
    };
    format!(
        "{}: {steps}, t = {}, E_total = {}, largest law residual {:.1e}, \
         {per_step:.2} ms a step, in {}",
        summary.scene,
        ShortNumber(summary.t),
        ShortNumber(energy),
        summary.largest_law_residual,
        folder.display(),
    )
}
