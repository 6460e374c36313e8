//! One point of a sweep: its run, begun or continued. All that run sweeps come here, each with the point's lock.

use crate::cli::error::CliError;
use crate::cli::one_of_many;
use crate::cli::output;
use crate::cli::progress::Progress;
use crate::cli::signals::EndSignal;
use crate::record::{
    CheckpointError, Found, IfOccupied, RecordError, RecorderBuilder, Resumption, RunFolder,
    Schedule, Settings, clear_run,
};
use crate::scene::Scene;
use crate::signals::EndingSignal;
use crate::simulation::cores;
use crate::study::sweep::{
    Holder, Point, PointLock, PointState, SweepError, SweepFolder, Taken, Values,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `vesica sweep point`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A point that is done is left as it is, so the same command can be given again and again.

Exit status: 0 the points are done; 1 some are not: they failed, or another process works on them; 2 the arguments \
are wrong; 75 ended by a signal, with the state saved: the same command continues.")]
pub(super) struct Arguments {
    /// The sweep's folder
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Points by their names or numbers
    #[arg(required = true, value_name = "POINT")]
    points: Vec<String>,
}

/// Runs points, one after the other.
pub(super) fn points(arguments: &Arguments) -> Result<(), CliError> {
    let folder = SweepFolder::open(&arguments.folder)?;
    folder.make_points()?;
    let points: Vec<&Point> = arguments
        .points
        .iter()
        .map(|name| folder.point(name))
        .collect::<Result<_, _>>()?;
    let signal = EndSignal::listen_in_batch()?;
    let mut failed = 0;
    for point in &points {
        let name = &point.name;
        match run_point(&folder, point, cores(), &signal, &|schedule| {
            Progress::new(schedule)
        }) {
            Ok(Ended::Done) => output::note(format_args!("{name}: done")),
            Ok(Ended::WasDone) => output::note(format_args!("{name}: was done already")),
            Ok(Ended::Stopped(signal)) => {
                return Err(CliError::PointSaved {
                    signal: signal.name,
                    point: name.clone(),
                });
            }
            Ok(Ended::Busy(holder)) => {
                failed += 1;
                output::error(format_args!("{name}: {holder} works on it"));
            }
            Ok(Ended::Failed(reason)) => {
                failed += 1;
                output::error(failure(point, &reason));
            }
            Err(error) => {
                failed += 1;
                output::error(failure(point, &error.to_string()));
            }
        }
    }
    match failed {
        0 => Ok(()),
        _ => Err(CliError::TaskFailed {
            failed,
            all: points.len(),
        }),
    }
}

/// That a point failed, with its values.
pub(super) fn failure(point: &Point, reason: &str) -> String {
    let values = Values(&point.assignments);
    format!("point {} ({values}) failed: {reason}", point.name)
}

/// How work on a point ended.
pub(super) enum Ended {
    Done,
    WasDone,
    Stopped(EndingSignal),
    Failed(String),
    /// Another one works on it.
    Busy(Holder),
}

impl From<one_of_many::Ended> for Ended {
    fn from(ended: one_of_many::Ended) -> Self {
        match ended {
            one_of_many::Ended::Done => Self::Done,
            one_of_many::Ended::Stopped(signal) => Self::Stopped(signal),
            one_of_many::Ended::Failed(reason) => Self::Failed(reason),
        }
    }
}

/// Why there was none.
#[derive(Debug, thiserror::Error)]
pub(super) enum PointRunError {
    /// Its scene cannot be had any more.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Its run cannot be resumed.
    #[error(transparent)]
    Resume(#[from] CheckpointError),
    /// Its run cannot be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Runs a point to its end, or resumes it, in at most `threads` threads.
pub(super) fn run_point(
    folder: &SweepFolder,
    point: &Point,
    threads: usize,
    signal: &EndSignal,
    progress: &dyn Fn(&Schedule) -> Progress,
) -> Result<Ended, PointRunError> {
    let is_done = || folder.state(point) == PointState::Done;
    if is_done() {
        return Ok(Ended::WasDone);
    }
    let _lock = match PointLock::take(&folder.lock(point))? {
        Taken::Held(lock) => lock,
        Taken::By(holder) => return Ok(Ended::Busy(holder)),
    };
    // By another one, until a moment ago.
    if is_done() {
        return Ok(Ended::WasDone);
    }
    let (scene, run) = (folder.scene(point)?, folder.run(point));
    folder.check_folder(&run)?;
    // Its end cannot be continued, and what is missing of its tables can only be computed again.
    let damage = match folder.recorded(point) {
        PointState::Damaged(damage) => Some(damage),
        _ => None,
    };
    if let Some(damage) = damage {
        let name = &point.name;
        output::damage(format_args!(
            "point {name} was done, but {damage}: it is computed again"
        ));
    }
    let found = match damage {
        Some(_) => None,
        None => to_resume(&run, &scene)?,
    };
    let preparation = match found {
        Some(_) => None,
        None => {
            let settings = Settings::default();
            Some(RecorderBuilder::begin(new_run(&run)?, &scene, settings)?)
        }
    };
    let begun = Instant::now();
    let mut simulation = match one_of_many::set_up(&scene, signal) {
        Ok(simulation) => simulation,
        Err(ended) => {
            preparation.map_or(Ok(()), |it| it.end(ended.ending()))?;
            return Ok(ended.into());
        }
    };
    let recorder = match (preparation, found) {
        (Some(preparation), _) => preparation.start(&simulation, begun.elapsed())?,
        (None, Some(resumption)) => {
            let settings = resumption.settings();
            let (recorder, problems) = resumption.start(&scene, settings, &mut simulation)?;
            for problem in problems {
                output::damage(format_args!("{}: {problem}", point.name));
            }
            recorder
        }
        // There is one of the two.
        (None, None) => return Ok(Ended::WasDone),
    };
    let progress = progress(recorder.schedule());
    let ended = one_of_many::complete(simulation, recorder, threads, signal, progress)?;
    Ok(ended.into())
}

/// The run in a folder, if it can be resumed.
fn to_resume(run: &Path, scene: &Scene) -> Result<Option<Box<Resumption>>, CheckpointError> {
    match Resumption::find(run, scene) {
        Ok(Found::Run(resumption)) => Ok(Some(resumption)),
        Ok(Found::Nothing | Found::Abandoned) => Ok(None),
        // What was killed before its first checkpoint is begun again, and so is what has none that can be used: the
        // folder is the sweep's own.
        Err(CheckpointError::None { .. } | CheckpointError::Unusable { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The folder for a run that begins, without what one before it had left.
fn new_run(run: &Path) -> Result<RunFolder, RecordError> {
    if run.exists() {
        clear_run(run)?;
    }
    RunFolder::at(run, IfOccupied::Refuse)
}
