//! Why a command ends without success, and its exit status.

use super::output;
use super::sweep::SlurmError;
use crate::figure::{FigureError, SweepFigureError};
use crate::record::{CheckpointError, LoadError, ReadError, RecordError, Whereabouts};
use crate::scene::UnknownPreset;
use crate::signals::EndingSignal;
use crate::simulation::{NoShapeAtRest, SimulationError};
use crate::study::sweep::SweepError;
use crate::study::{ComparedRunError, StudyError};
use crate::tui::AppError;
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;

/// Why a command ends without success.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// The scene could not be had.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There is no such command.
    #[error("there is no command '{word}', and no scene of this name. Commands: {commands}")]
    NoCommand {
        /// What stands in its place.
        word: String,
        /// The names of all there are.
        commands: String,
    },
    /// There is no such preset.
    #[error(transparent)]
    Preset(#[from] UnknownPreset),
    /// A surface in space was asked for of a scene in the plane.
    #[error(
        "--revolve is for bodies of rotation, and {name} is in the plane: leave it out, or give scenes with \
         domain.geometry = \"axisymmetric\""
    )]
    NothingToRevolve {
        /// The scene or the run.
        name: String,
    },
    /// The scene ends before its first step.
    #[error(
        "the end, t = {end:e}, comes before the first step of length {step:e}: nothing would be \
         simulated. Raise {end_key}, or lower time.step"
    )]
    NoStep {
        /// Where T comes from.
        end_key: &'static str,
        /// T.
        end: f64,
        /// Δt.
        step: f64,
    },
    /// The run that the error is to be measured against cannot be had.
    #[error("the error cannot be measured: the same scene {words}: {error}")]
    FinerRun {
        /// How much finer.
        words: String,
        /// Why.
        #[source]
        error: SimulationError,
    },
    /// The finer runs were ended; the run itself is done.
    #[error(
        "{signal}: the run is complete in {0}, but its error is not measured: the finer runs are not kept. \
         `vesica run {0} --resume --measure-error` begins them again", folder.display()
    )]
    MeasurementInterrupted {
        /// What ended them.
        signal: &'static str,
        /// The run's folder.
        folder: PathBuf,
    },
    /// The number of chosen steps cannot be given.
    #[error(
        "--steps needs steps of one length, but the scene has them chosen by time.tolerance; give \
         --until T, or --set time.step=…"
    )]
    StepsOfChosen,
    /// The folder for the run could not be had.
    #[error(transparent)]
    Folder(RecordError),
    /// A run cannot be resumed.
    #[error(transparent)]
    Resume(#[from] CheckpointError),
    /// The app has nowhere to be.
    #[error(
        "the standard {stream} is not a terminal, and the app needs one; without one simulate the \
         scene with: vesica run {}",
        scene.display()
    )]
    NoTerminal {
        /// "input" or "output".
        stream: &'static str,
        /// What it was to open.
        scene: OsString,
    },
    /// The app cannot be drawn on this terminal.
    #[error(
        "the terminal cannot show the app: TERM {}; name the terminal, as in TERM=xterm-256color, or simulate \
         the scene without it: vesica run {}",
        if name.is_empty() { "is not set".to_owned() } else { format!("is '{name}'") },
        scene.display()
    )]
    IncapableTerminal {
        /// What TERM says.
        name: String,
        /// What it was to open.
        scene: OsString,
    },
    /// The app could not start or go on.
    #[error(transparent)]
    App(#[from] AppError),
    /// A run of the app had failed when it was left.
    #[error("a run failed in the app")]
    AppFailed {
        /// Whether its scene asks for what cannot be.
        is_of_scene: bool,
    },
    /// A signal ended the app.
    #[error("the app was ended by signal {number}")]
    AppEnded {
        /// The signal's number.
        number: i32,
    },
    /// Scenes that were checked are wrong; each was reported already.
    #[error("{wrong} of {checked} scenes cannot be run")]
    Check {
        /// How many.
        wrong: usize,
        /// Of how many.
        checked: usize,
    },
    /// The first steps of scenes that were checked were not solved in the time; each was reported already.
    #[error("whether {undecided} of {checked} scenes can be run was not found out")]
    Undecided {
        /// How many.
        undecided: usize,
        /// Of how many.
        checked: usize,
    },
    /// The simulation could not be set up; if it is for the mesh or the vesicle, then the scene asks for
    /// what cannot be.
    #[error("the run could not be set up: {0}")]
    SetUp(#[source] SimulationError),
    /// A first step that was tried failed.
    #[error("a run would fail: {0}")]
    Foreseen(#[source] SimulationError),
    /// The simulation could not go on.
    #[error("the run failed: {error}\n{whereabouts}")]
    Run {
        /// Why.
        #[source]
        error: SimulationError,
        /// Of what was recorded.
        whereabouts: Box<Whereabouts>,
    },
    /// A file cannot be written, or a folder made.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is no study of accuracy.
    #[error(transparent)]
    Accuracy(#[from] StudyError),
    /// A finished run cannot take part in it.
    #[error(transparent)]
    ComparedRun(#[from] ComparedRunError),
    /// A run was made but not all of it could be recorded.
    #[error("not all of the run could be recorded: {error}\n{whereabouts}")]
    Unrecorded {
        /// Why.
        #[source]
        error: RecordError,
        /// Of what was recorded.
        whereabouts: Box<Whereabouts>,
    },
    /// A signal ended the run.
    #[error(
        "ended by {signal} after step {step}{of}{within}; saved in {0}. Go on with: vesica run {0} --resume",
        folder.display()
    )]
    Interrupted {
        /// The signal's name.
        signal: &'static str,
        /// The last step.
        step: u64,
        /// " of N", where N steps were planned.
        of: String,
        /// Where in the next step, if it was begun.
        within: String,
        /// The run's folder.
        folder: PathBuf,
    },
    /// A run was ended by a signal before its first step, and the folder says so.
    #[error(
        "ended by {signal} while the run was set up; no step was made. Go on with: vesica run {0} --resume",
        folder.display()
    )]
    SetUpInterrupted {
        /// The signal's name.
        signal: &'static str,
        /// The run's folder.
        folder: PathBuf,
    },
    /// The system starts no thread.
    #[error("the system starts no thread for the run: {0}")]
    Thread(#[source] io::Error),
    /// A scene could not be measured.
    #[error("the effects cannot be measured: {0}")]
    Study(#[source] SimulationError),
    /// A signal ended the measuring.
    #[error("ended by {signal}; nothing was measured to the end")]
    StudyEnded {
        /// The signal's name.
        signal: &'static str,
        /// The signal's number.
        number: i32,
    },
    /// A signal ended a study of accuracy after its first runs.
    #[error(
        "ended by {signal}; what was computed is in {}",
        files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(" ")
    )]
    AccuracyInterrupted {
        /// The signal's name.
        signal: &'static str,
        /// The signal's number.
        number: i32,
        /// What was saved.
        files: Vec<PathBuf>,
    },
    /// A signal ended the runs of a set of figures.
    #[error(
        "ended by {signal}; what was computed is saved. Draw it with `vesica figures {}`",
        runs.iter().map(|run| run.display().to_string()).collect::<Vec<_>>().join(" ")
    )]
    FiguresInterrupted {
        /// The signal's name.
        signal: &'static str,
        /// The signal's number.
        number: i32,
        /// The runs' folders.
        runs: Vec<PathBuf>,
    },
    /// A run's folder cannot be read back.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Values are to be set in a run that is done.
    #[error(
        "--set cannot change {}, whose run is done. To run its scene again, name {} instead",
        folder.display(),
        folder.join("scene.toml").display()
    )]
    SetInRun {
        /// The run's folder.
        folder: PathBuf,
    },
    /// Theory foresees no shape at rest.
    #[error(transparent)]
    NoShape(#[from] NoShapeAtRest),
    /// The figures could not be made.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// Some of the runs of a set of figures failed; each was reported already.
    #[error("{failed} of {all} runs failed; the figures show what there is")]
    RunsFailed {
        /// How many.
        failed: usize,
        /// Of how many.
        all: usize,
    },
    /// There is no such sweep, or it cannot be run.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Some points of a sweep failed; each was reported already.
    #[error(
        "{failed} of {all} points failed{}{}; what is not done can be tried again with: vesica sweep {} --resume",
        if *busy > 0 { format!(", {}", worked_on(*busy)) } else { String::new() },
        if *untried > 0 { format!(" and {untried} were not tried") } else { String::new() },
        folder.display()
    )]
    PointsFailed {
        /// How many.
        failed: usize,
        /// How many another process works on.
        busy: usize,
        /// How many were not tried, for too many had failed.
        untried: usize,
        /// Of how many.
        all: usize,
        /// The sweep's folder.
        folder: PathBuf,
    },
    /// No point of a sweep failed, but another process works on some.
    #[error(
        "{done} of {all} points are done, {}. `vesica sweep status {1}` shows how far they are. Once they \
         are done, run: vesica sweep {1} --resume",
        worked_on(*busy),
        folder.display()
    )]
    PointsBusy {
        /// How many it works on.
        busy: usize,
        /// How many are done.
        done: usize,
        /// Of how many.
        all: usize,
        /// The sweep's folder.
        folder: PathBuf,
    },
    /// A signal ended a sweep.
    #[error(
        "ended by {signal}; {done} of {all} points are done, what was begun is saved. Go on with: vesica sweep {} \
         --resume",
        folder.display()
    )]
    SweepInterrupted {
        /// The signal's name.
        signal: &'static str,
        /// How many points are done.
        done: usize,
        /// Of how many.
        all: usize,
        /// The sweep's folder.
        folder: PathBuf,
    },
    /// A signal ended a task of a sweep.
    #[error("ended by {signal}; point {point} is saved, and the same command continues it")]
    PointSaved {
        /// The signal's name.
        signal: &'static str,
        /// The point.
        point: String,
    },
    /// Points of a task were not done; each was reported already.
    #[error("{failed} of {all} points were not done")]
    TaskFailed {
        /// How many.
        failed: usize,
        /// Of how many.
        all: usize,
    },
    /// There is no such figure of a sweep.
    #[error(transparent)]
    SweepFigure(#[from] SweepFigureError),
    /// The batch system did not take the jobs.
    #[error(transparent)]
    Slurm(#[from] SlurmError),
    /// A file is there that is not to be replaced.
    #[error("{} is there already: give another file with --out, or --force to replace it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A run has no scene to be computed again.
    #[error(
        "{0} holds a run, but no scene.toml, its scene: nothing can be computed again. Put back the scene that the run \
         was begun with, as {1}",
        folder.display(),
        folder.join("scene.toml").display()
    )]
    NothingToRepeat {
        /// The folder.
        folder: PathBuf,
    },
    /// A signal ended an export.
    #[error("ended by {}; nothing is exported", .0.name)]
    ExportEnded(EndingSignal),
    /// The steps of a run could not be counted.
    #[error(
        "{end_key} has the run end at t = {end:e}, more steps of length {step:e} away than can be counted: lower it, or raise \
         time.step"
    )]
    TooManySteps {
        /// Where T comes from.
        end_key: &'static str,
        /// T.
        end: f64,
        /// Δt.
        step: f64,
    },
    /// A run cannot be computed again.
    #[error("the run failed when it was repeated: {0}")]
    Repeat(#[source] SimulationError),
    /// A run does not give the same numbers again; how they differ was printed already.
    #[error("{} does not give the same numbers again", folder.display())]
    Differs {
        /// The run's folder.
        folder: PathBuf,
    },
    /// A signal ended the repetition of a run.
    #[error("ended by {}; nothing was found out", .0.name)]
    VerifyEnded(EndingSignal),
    /// Signals cannot be received.
    #[error("cannot set up the handling of Ctrl-C: {0}")]
    Signals(#[source] io::Error),
    /// The standard output is broken.
    #[error("cannot write to the standard output: {0}")]
    Output(#[source] io::Error),
}

/// That another process works on some points.
fn worked_on(points: usize) -> String {
    match points {
        1 => "1 is worked on by another process".to_owned(),
        points => format!("{points} are worked on by another process"),
    }
}

impl CliError {
    /// The exit status of wrong arguments and wrong scenes.
    pub const USAGE: u8 = 2;
    const FAILED: u8 = 1;
    /// A signal ended a run, a sweep or a task, and all of it is saved, or another process works on the rest of a sweep:
    /// it is to be started again. EX_TEMPFAIL of sysexits.h.
    pub const SAVED: u8 = 75;

    /// What the process ends with.
    pub fn exit_status(&self) -> u8 {
        match self {
            CliError::Load(_)
            | CliError::NoCommand { .. }
            | CliError::Preset(_)
            | CliError::NoStep { .. }
            | CliError::TooManySteps { .. }
            | CliError::NothingToRepeat { .. }
            | CliError::NothingToRevolve { .. }
            | CliError::StepsOfChosen
            | CliError::Folder(_)
            | CliError::Resume(
                CheckpointError::None { .. }
                | CheckpointError::Foreign { .. }
                | CheckpointError::Record(RecordError::InUse { .. }),
            )
            | CliError::NoTerminal { .. }
            | CliError::IncapableTerminal { .. }
            | CliError::Check { .. }
            | CliError::Foreseen(_)
            | CliError::Accuracy(StudyError::Budget { .. })
            | CliError::Read(_)
            | CliError::ComparedRun(_)
            | CliError::SetInRun { .. }
            | CliError::Exists { .. }
            | CliError::NoShape(_)
            | CliError::Slurm(SlurmError::Arguments { .. })
            | CliError::Figure(
                FigureError::Width { .. }
                | FigureError::Resolution { .. }
                | FigureError::Occupied { .. }
                | FigureError::Nothing,
            )
            | CliError::AppFailed { is_of_scene: true } => CliError::USAGE,
            CliError::Study(error)
            | CliError::SetUp(error)
            | CliError::Accuracy(StudyError::Failed { source: error, .. })
                if error.is_of_scene() =>
            {
                CliError::USAGE
            }
            CliError::Sweep(error) => match error {
                SweepError::Record(_) => CliError::FAILED,
                _ => CliError::USAGE,
            },
            CliError::SweepFigure(
                SweepFigureError::Figure(FigureError::Occupied { .. })
                | SweepFigureError::NoNumbers { .. },
            ) => CliError::USAGE,
            CliError::SweepFigure(SweepFigureError::Figure(_)) => CliError::FAILED,
            CliError::SweepFigure(_) => CliError::USAGE,
            CliError::PointSaved { .. }
            | CliError::Interrupted { .. }
            | CliError::SetUpInterrupted { .. }
            | CliError::SweepInterrupted { .. }
            | CliError::PointsBusy { .. }
            | CliError::MeasurementInterrupted { .. } => CliError::SAVED,
            CliError::PointsFailed { .. }
            | CliError::TaskFailed { .. }
            | CliError::Slurm(_)
            | CliError::SetUp(_)
            | CliError::FinerRun { .. }
            | CliError::Study(_)
            | CliError::Undecided { .. }
            | CliError::Run { .. }
            | CliError::Resume(_)
            | CliError::Record(_)
            | CliError::Accuracy(_)
            | CliError::Unrecorded { .. }
            | CliError::App(_)
            | CliError::AppFailed { is_of_scene: false }
            | CliError::Figure(_)
            | CliError::RunsFailed { .. }
            | CliError::Repeat(_)
            | CliError::Differs { .. }
            | CliError::Signals(_)
            | CliError::Thread(_)
            | CliError::Output(_) => CliError::FAILED,
            // A signal's number is below 65.
            CliError::FiguresInterrupted { number, .. }
            | CliError::AccuracyInterrupted { number, .. }
            | CliError::StudyEnded { number, .. }
            | CliError::VerifyEnded(EndingSignal { number, .. })
            | CliError::ExportEnded(EndingSignal { number, .. })
            | CliError::AppEnded { number } => 128_u8.saturating_add(*number as u8),
        }
    }

    /// Tells it on the standard error.
    pub fn tell(&self) {
        match self {
            CliError::Interrupted { .. }
            | CliError::SetUpInterrupted { .. }
            | CliError::FiguresInterrupted { .. }
            | CliError::SweepInterrupted { .. }
            | CliError::PointsBusy { .. }
            | CliError::PointSaved { .. }
            | CliError::AccuracyInterrupted { .. }
            | CliError::VerifyEnded(_)
            | CliError::ExportEnded(_)
            | CliError::Differs { .. }
            | CliError::StudyEnded { .. } => output::tell(self),
            // It has left a line that says how far it came, and what failed.
            CliError::AppEnded { .. } | CliError::AppFailed { .. } => {}
            _ => output::error(self),
        }
    }
}
