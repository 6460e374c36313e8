//! `vesica run SCENE`: simulate a scene and record it in a folder.

use super::error::CliError;
use super::numbers;
use super::output;
use super::progress::Progress;
use super::signals::{EndSignal, Signal};
use crate::record::{
    Brief, Ending, EventRecord, IfOccupied, Preparation, RecordError, Recorder, RunFolder,
    RunSummary, Settings, load_scene, step_count,
};
use crate::scene::{Scene, Time};
use crate::simulation::{Simulation, SimulationError};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where runs go that are given no folder.
const RUNS: &str = "runs";

/// Arguments of `vesica run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit status: 0 done; 1 the run failed; 2 the arguments or the scene are wrong; 130 ended by Ctrl-C \
(in general 128 + the signal's number), with everything written up to the last step.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file
    scene: OsString,

    /// The run's folder [default: runs/NAME, then runs/NAME-2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Override a value of the scene, such as anchoring.kind=parallel
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// End at the step nearest to this time, in place of time.end
    #[arg(long, value_name = "T", conflicts_with = "steps", value_parser = numbers::time,
          allow_negative_numbers = true)]
    until: Option<f64>,

    /// End after so many steps, in place of time.end
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Record a row every N steps, and at the end
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    every: u64,

    /// Save the fields at N times, evenly from 0 to the end
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = numbers::count,
          allow_negative_numbers = true)]
    snapshots: u64,

    /// Replace the run that the folder holds
    #[arg(long, conflicts_with = "resume")]
    force: bool,

    /// Take up the run that the folder holds (not possible yet)
    #[arg(long)]
    resume: bool,

    /// Tell nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// Simulates the scene and records it.
pub(super) fn run(arguments: &Arguments) -> Result<(), CliError> {
    if arguments.resume {
        return Err(CliError::Resume);
    }
    let (scene, name) = scene(arguments)?;
    let signal = EndSignal::listen()?;
    let folder = folder(arguments, &name).map_err(CliError::Folder)?;
    let path = folder.path().to_owned();

    let settings = Settings {
        every: arguments.every,
        snapshots: arguments.snapshots,
    };
    let preparation = Preparation::begin(folder, &scene, settings)?;
    let begun = Instant::now();
    let mut simulation = match Simulation::new(&scene) {
        Ok(simulation) => simulation,
        Err(error) => {
            // The error of the set-up is the one to tell.
            let _ = preparation.fail(error.to_string());
            return Err(CliError::SetUp(error));
        }
    };
    simulation.follow(preparation.schedule());
    let mut recorder = preparation.start(&simulation, begun.elapsed())?;
    if !arguments.quiet {
        simulation.warnings().iter().for_each(output::warning);
    }

    let progress = Progress::new(recorder.schedule(), arguments.quiet);
    let stop = simulate(
        &mut simulation,
        &mut recorder,
        &signal,
        progress,
        arguments.quiet,
    );

    let steps = recorder.schedule().steps;
    let finished = recorder.finish(&mut simulation, stop.ending());
    match stop {
        Stop::Unrecorded(error) => Err(error.into()),
        Stop::Failed(error) => {
            if let Err(unrecorded) = finished {
                output::error(unrecorded);
            }
            Err(CliError::Run {
                error,
                folder: path,
            })
        }
        Stop::Signal(Signal { name, number }) => {
            let step = finished?.steps;
            Err(CliError::Interrupted {
                signal: name,
                number,
                step,
                of: steps.map_or(String::new(), |steps| format!(" of {steps}")),
                folder: path,
            })
        }
        Stop::Done => {
            let summary = finished?;
            if arguments.quiet {
                return Ok(());
            }
            output::line(result_line(&summary, &path))
        }
    }
}

/// Why the loop over the steps ended.
pub(super) enum Stop {
    Done,
    Signal(Signal),
    Failed(SimulationError),
    Unrecorded(RecordError),
}

impl Stop {
    /// How the record is to end.
    pub fn ending(&self) -> Ending {
        match self {
            Stop::Done => Ending::Done,
            Stop::Signal(_) => Ending::Interrupted,
            Stop::Failed(error) => Ending::Failed(error.to_string()),
            Stop::Unrecorded(error) => Ending::Failed(error.to_string()),
        }
    }
}

/// Makes the steps, recording each, until one of them is the last.
pub(super) fn simulate(
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    signal: &EndSignal,
    mut progress: Progress,
    quiet: bool,
) -> Stop {
    let mut computing = Duration::ZERO;
    let mut told = 0;
    loop {
        let report = simulation.report();
        if recorder.schedule().is_over(report.step, report.t) {
            return Stop::Done;
        }
        if let Some(signal) = signal.received() {
            return Stop::Signal(signal);
        }
        let begun = Instant::now();
        let advanced = simulation.advance().map(|_| ());
        computing += begun.elapsed();
        if let Err(error) = advanced {
            return Stop::Failed(error);
        }
        if let Err(error) = recorder.step(simulation, computing) {
            return Stop::Unrecorded(error);
        }
        let events = &recorder.events()[told..];
        if !events.is_empty() && !quiet {
            progress.above(|| events.iter().for_each(tell));
        }
        told += events.len();
        progress.show(simulation.report());
    }
}

/// Tells of something that happened in a run.
fn tell(event: &EventRecord) {
    let EventRecord { step, t, text, .. } = event;
    output::note(format_args!("step {step}, t = {}: {text}", Brief(*t)));
}

/// The scene with all overrides, and what to call its runs.
fn scene(arguments: &Arguments) -> Result<(Scene, OsString), CliError> {
    let mut loaded = load_scene(&arguments.scene, &arguments.set)?;
    let time = &mut loaded.scene.time;
    match (arguments.until, arguments.steps) {
        (Some(end), _) => time.end = end,
        (None, Some(_)) if time.tolerance.is_some() => return Err(CliError::StepsOfChosen),
        (None, Some(steps)) => time.end = steps as f64 * time.step,
        (None, None) => {}
    }
    some_step(time)?;
    Ok((loaded.scene, loaded.name))
}

/// Refuses a scene that ends before its first step.
pub(super) fn some_step(time: &Time) -> Result<(), CliError> {
    match step_count(time) {
        Some(0) => Err(CliError::NoStep {
            end: time.end,
            step: time.step,
        }),
        _ => Ok(()),
    }
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
        "{}: {steps}, t = {}, E_total = {energy:.6}, largest law residual {:.1e}, \
         {per_step:.2} ms a step, in {}",
        summary.scene,
        Brief(summary.t),
        summary.largest_law_residual,
        folder.display(),
    )
}
