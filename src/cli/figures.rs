//! `vesica figures SCENE...`: the figures of a report.

use super::error::CliError;
use super::one_of_many::{self, Ended};
use super::output;
use super::picture_size::PictureSize;
use super::progress::Progress;
use super::run::some_step;
use super::shell::{scenes, settings};
use super::signals::EndSignal;
use crate::figure::{
    Director, Existing, FigureOptions, RunData, Snapshot, Zoom, check_free, save_set,
};
use crate::record::{
    IfOccupied, RecordError, RecordedRun, RecorderBuilder, RunFolder, Settings, clean, load_scene,
    read_run, read_summary,
};
use crate::scene::{Geometry, Scene, Timetable, preset};
use crate::signals::EndingSignal;
use crate::simulation::{
    NoShapeAtRest, check_outlines, cores, free_memory, memory_needed, shape_at_rest,
};
use crate::theory::ShapeAtRest;
use clap_complete::ArgValueCompleter;
use indicatif::MultiProgress;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

/// Where figures go that are given no folder.
const FIGURES: &str = "figures";
/// Where their runs go, below.
const RUNS: &str = "runs";
/// A folder's name from several scenes is at most so long.
const LONGEST_NAME: usize = 60;

/// Arguments of `vesica figures`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Of each scene: snapshots at t = 0, T/4, T/2, 3T/4, T; the energies; the drift of the volume and the \
surface area; the size of the vesicle. Of several scenes also the same together. Each as PNG, SVG \
and CSV. A scene is simulated first, and its run is kept below the figures' folder; a run's folder \
is drawn as it is.")]
pub(super) struct Arguments {
    /// Presets (see `vesica presets`), TOML files, or folders of runs
    #[arg(required = true, value_name = "SCENE", add = ArgValueCompleter::new(scenes))]
    scenes: Vec<OsString>,

    /// The figures' folder [default: figures/NAMES, then figures/NAMES-2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Override a value of each scene, such as anchoring.kind=parallel
    #[arg(long, value_name = "KEY=VALUE", add = ArgValueCompleter::new(settings))]
    set: Vec<String>,

    #[command(flatten)]
    size: PictureSize,

    /// Draw the director without heads: d and −d mean the same physics
    #[arg(long)]
    headless: bool,

    /// Draw the shape at rest of the membrane alone over each snapshot, dashed (see `vesica shape`)
    #[arg(long)]
    theory: bool,

    /// Show the part of the domain around the vesicle, the same in all pictures of a figure: the default
    #[arg(long, overrides_with = "domain")]
    crop: bool,

    /// Show the whole domain
    #[arg(long, overrides_with = "crop")]
    domain: bool,

    /// Draw curves over the logarithm of t: what happens in the first steps is seen; t = 0 is left out
    #[arg(long)]
    log_t: bool,

    /// Leave the letters of SVG files as text that can be edited, in DejaVu Sans; else they are outlines
    #[arg(long)]
    text: bool,
    /// Also save the surface of a body of rotation in space, at N angles about its axis: NAME-surface.vtu, for ParaView
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=1024))]
    revolve: Option<u32>,

    /// Replace figures and runs that the folder holds
    #[arg(long)]
    force: bool,
}

/// Simulates what is not simulated yet, and draws.
pub(super) fn figures(arguments: &Arguments) -> Result<(), CliError> {
    let sources: Vec<Source> = arguments
        .scenes
        .iter()
        .map(|source| Source::find(source, &arguments.set))
        .collect::<Result<_, _>>()?;
    if arguments.revolve.is_some()
        && let Some(source) = sources
            .iter()
            .find(|source| source.scene().geometry == Geometry::Planar)
    {
        return Err(CliError::NothingToRevolve {
            name: source.name().to_owned(),
        });
    }
    let signal = EndSignal::listen()?;
    let folder = folder(arguments, &sources)?;
    let jobs = jobs(&sources, &folder, arguments.force)?;
    let outcomes = compute(&jobs, &signal);

    let mut failed = 0;
    for (job, outcome) in jobs.iter().zip(&outcomes) {
        if let Ended::Failed(error) = outcome {
            failed += 1;
            output::error(format_args!("{}: {error}", job.name));
        }
    }
    let stopped = outcomes.iter().find_map(|outcome| match outcome {
        Ended::Stopped(signal) => Some(*signal),
        _ => None,
    });
    if let Some(EndingSignal { name, number, .. }) = stopped {
        return Err(CliError::FiguresInterrupted {
            signal: name,
            number,
            runs: jobs
                .iter()
                .map(|job| job.folder.path().to_owned())
                .collect(),
        });
    }

    let command = Command(arguments).to_string();
    let mut jobs_left = jobs.iter().zip(&outcomes);
    let mut runs = Vec::new();
    for source in sources {
        let run = match source {
            Source::Run { name, run } => (name, *run),
            Source::Scene { .. } => match jobs_left.next() {
                // A run whose record does not reach to its first row has nothing to draw.
                Some((job, Ended::Failed(_))) => match read_run(job.folder.path()) {
                    Ok(run) => (job.name.clone(), run),
                    Err(_) => continue,
                },
                Some((job, _)) => (job.name.clone(), read_run(job.folder.path())?),
                None => continue,
            },
        };
        runs.extend(data(run, &command, arguments.theory));
    }
    let options = FigureOptions {
        director: if arguments.headless {
            Director::Strokes
        } else {
            Director::Arrows
        },
        existing: if arguments.force {
            Existing::Replace
        } else {
            Existing::Refuse
        },
        zoom: if arguments.domain && !arguments.crop {
            Zoom::Domain
        } else {
            Zoom::Fit
        },
        logarithmic_time: arguments.log_t,
        svg_text: arguments.text,
        revolve: arguments.revolve,
        ..arguments.size.options()
    };
    let files = save_set(&runs, &options, &folder)?;
    let pictures = files
        .iter()
        .filter(|file| file.extension() == Some(OsStr::new("png")))
        .count();
    output::summary(format_args!(
        "{pictures} figures, each as PNG, SVG and CSV, in {}",
        folder.display()
    ))?;
    match failed {
        0 => Ok(()),
        _ => Err(CliError::RunsFailed {
            failed,
            all: jobs.len(),
        }),
    }
}

/// What a SCENE stands for.
enum Source {
    /// A scene that is to be simulated.
    Scene { name: String, scene: Box<Scene> },
    /// A run that was simulated.
    Run { name: String, run: Box<RecordedRun> },
}

impl Source {
    fn find(source: &OsStr, overrides: &[String]) -> Result<Source, CliError> {
        let path = Path::new(source);
        // A preset's name is the preset, as everywhere; a folder of that name is `./NAME`.
        let is_preset = source.to_str().is_some_and(|name| preset(name).is_some());
        if !is_preset && path.is_dir() {
            if !overrides.is_empty() {
                return Err(CliError::SetInRun {
                    folder: path.to_owned(),
                });
            }
            // Of `.` and `..` the name is that of the folder behind them.
            let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
            let name = whole.file_name().unwrap_or(OsStr::new("run"));
            return Ok(Source::Run {
                name: name.to_string_lossy().into_owned(),
                run: Box::new(read_run(path).inspect(|run| tell_missing(path, run))?),
            });
        }
        let loaded = load_scene(source, overrides)?;
        some_step(&loaded.scene.time)?;
        check_outlines(&loaded.scene).map_err(CliError::SetUp)?;
        Ok(Source::Scene {
            name: loaded.name.to_string_lossy().into_owned(),
            scene: Box::new(loaded.scene),
        })
    }

    fn name(&self) -> &str {
        match self {
            Source::Scene { name, .. } | Source::Run { name, .. } => name,
        }
    }

    fn scene(&self) -> &Scene {
        match self {
            Source::Scene { scene, .. } => scene,
            Source::Run { run, .. } => &run.scene,
        }
    }
}

/// Tells what is not as the run has left it, and of figures that there cannot be, for it has not left what they show.
fn tell_missing(folder: &Path, run: &RecordedRun) {
    if let Ok(summary) = read_summary(folder) {
        output::doubts(folder, &summary);
    }
    let folder = folder.display();
    if run.fields.is_empty() {
        output::warning(format_args!(
            "{folder} has no fields (fields/*.vtu, final.vtu): nothing of this run is drawn"
        ));
    } else if run.history.column("length").is_none() {
        output::warning(format_args!(
            "{folder} has no shape.csv: there is no figure of the vesicle's size"
        ));
    } else if run.history.known("length").is_none() {
        output::note(format_args!(
            "{folder} has several vesicles or none at all times: no figure of the vesicle's size is drawn"
        ));
    }
}

/// The figures' folder: the given one, or a new one; with `--force` and no name, the first.
fn folder(arguments: &Arguments, sources: &[Source]) -> Result<PathBuf, CliError> {
    let folder = match (&arguments.out, arguments.force) {
        (Some(folder), _) => folder.clone(),
        (None, true) => Path::new(FIGURES).join(names(sources)),
        (None, false) => {
            let name = OsString::from(names(sources));
            let numbered = RunFolder::numbered(Path::new(FIGURES), &name);
            return Ok(numbered.map_err(CliError::Folder)?.path().to_owned());
        }
    };
    if !arguments.force {
        let runs: Vec<(&str, &Scene)> = sources.iter().map(|s| (s.name(), s.scene())).collect();
        check_free(&runs, &folder)?;
    }
    clean(&folder);
    Ok(folder)
}

/// The names of all sources, or as many as make a name of reasonable length.
fn names(sources: &[Source]) -> String {
    let mut name = String::new();
    for (number, source) in sources.iter().enumerate() {
        let longer = match number {
            0 => source.name().to_owned(),
            _ => format!("{name}-{}", source.name()),
        };
        if number > 0 && longer.len() > LONGEST_NAME {
            return format!("{name}-and-{}-more", sources.len() - number);
        }
        name = longer;
    }
    name
}

/// A scene that is to be simulated, and where.
struct Job {
    name: String,
    scene: Scene,
    folder: RunFolder,
}

/// The jobs of all scenes, with their folders claimed.
fn jobs(sources: &[Source], folder: &Path, force: bool) -> Result<Vec<Job>, CliError> {
    let if_occupied = match force {
        true => IfOccupied::Replace,
        false => IfOccupied::Refuse,
    };
    let mut jobs: Vec<Job> = Vec::new();
    for source in sources {
        let Source::Scene { name, scene } = source else {
            continue;
        };
        let same = jobs.iter().filter(|job| job.name == *name).count();
        let own = match same {
            0 => name.clone(),
            _ => format!("{name}-{}", same + 1),
        };
        let path = folder.join(RUNS).join(own);
        jobs.push(Job {
            name: name.clone(),
            scene: Scene::clone(scene),
            folder: RunFolder::at(&path, if_occupied).map_err(CliError::Folder)?,
        });
    }
    Ok(jobs)
}

/// Simulates the jobs side by side, as many at a time as there are processors and memory.
fn compute(jobs: &[Job], signal: &EndSignal) -> Vec<Ended> {
    let processors = cores();
    let needed = jobs.iter().map(|job| memory_needed(&job.scene)).max();
    let threads = match (free_memory(), needed) {
        (Some(free), Some(needed)) => {
            let fitting = usize::try_from(free.bytes / needed.max(1)).unwrap_or(processors);
            processors.min(fitting.max(1))
        }
        _ => processors,
    };
    let at_once = threads.min(jobs.len()).max(1);
    let bars = MultiProgress::with_draw_target(output::progress_target());
    let next = AtomicUsize::new(0);
    let outcomes: Vec<Mutex<Option<Ended>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let outcome = compute_one(job, processors / at_once, signal, &bars)
                .unwrap_or_else(|error| Ended::Failed(error.to_string()));
            let place = jobs.iter().position(|other| std::ptr::eq(other, job));
            if let Some(place) = place
                && let Ok(mut place) = outcomes[place].lock()
            {
                *place = Some(outcome);
            }
        }
    };
    thread::scope(|scope| {
        // One of them is this thread: where the system starts no other, it does all.
        for _ in 1..at_once {
            let helper = thread::Builder::new().spawn_scoped(scope, work);
            if helper.is_err() {
                break;
            }
        }
        work();
    });
    let outcome = |outcome: Mutex<Option<Ended>>| outcome.into_inner().ok().flatten();
    let unknown = || Ended::Failed("its thread ended too early".to_owned());
    outcomes
        .into_iter()
        .map(|result| outcome(result).unwrap_or_else(unknown))
        .collect()
}

/// Simulates one scene, in at most this number of threads.
fn compute_one(
    job: &Job,
    threads: usize,
    signal: &EndSignal,
    bars: &MultiProgress,
) -> Result<Ended, RecordError> {
    let preparation = RecorderBuilder::begin(job.folder.clone(), &job.scene, Settings::default())?;
    let begun = Instant::now();
    let simulation = match one_of_many::set_up(&job.scene, signal) {
        Ok(simulation) => simulation,
        Err(ended) => {
            preparation.end(ended.ending())?;
            return Ok(ended);
        }
    };
    let recorder = preparation.start(&simulation, begun.elapsed())?;
    let progress = Progress::among(bars, &job.name, recorder.schedule());
    progress.above(|| {
        for warning in simulation.warnings() {
            output::warning(format_args!("{}: {warning}", job.name));
        }
    });
    one_of_many::complete(simulation, recorder, threads, signal, progress)
}

/// What is drawn of a run; nothing, if no fields were saved.
pub(super) fn data(
    (name, run): (String, RecordedRun),
    command: &str,
    with_theory: bool,
) -> Option<RunData> {
    let first = run.fields.first()?;
    let theory = with_theory.then(|| theory(&run, first)).transpose();
    let theory = theory.unwrap_or_else(|reason| {
        output::warning(format_args!("{name}: {reason}"));
        None
    });
    Some(RunData {
        name,
        theory: theory.map(Arc::new),
        scene: Arc::new(run.scene),
        marks: run.marks,
        history: run.history,
        snapshots: run.fields,
        command: command.to_owned(),
    })
}

/// The shape at rest that theory foresees for a run with the parameters of its last row, from its first row and its first fields.
fn theory(run: &RecordedRun, first: &Snapshot) -> Result<ShapeAtRest, NoShapeAtRest> {
    let start = ["A", "B"].map(|name| {
        let column = run.history.column(name);
        column.and_then(|values| values.first().copied())
    });
    let start = start.map(|value| value.unwrap_or(f64::NAN));
    let times = run.history.column("t");
    let end = times.and_then(|times| times.last().copied());
    let scene = Timetable::of(&run.scene).at(end.unwrap_or_default());
    shape_at_rest(&scene, (&first.mesh, &first.state.phi), start)
}

/// The command that draws the same figures.
struct Command<'a>(&'a Arguments);

impl fmt::Display for Command<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Command(arguments) = self;
        f.write_str("vesica figures")?;
        for scene in &arguments.scenes {
            write!(f, " {}", quoted(&scene.to_string_lossy()))?;
        }
        for set in &arguments.set {
            write!(f, " --set {}", quoted(set))?;
        }
        write!(f, " {}", arguments.size)?;
        for (option, is_given) in [
            ("headless", arguments.headless),
            ("domain", arguments.domain),
            ("log-t", arguments.log_t),
            ("text", arguments.text),
        ] {
            if is_given {
                write!(f, " --{option}")?;
            }
        }
        if arguments.theory {
            f.write_str(" --theory")?;
        }
        if let Some(around) = arguments.revolve {
            write!(f, " --revolve {around}")?;
        }
        Ok(())
    }
}

/// An argument as a shell takes it.
pub(super) fn quoted(argument: &str) -> String {
    let harmless = |c: char| c.is_ascii_alphanumeric() || "-_./=+:,@%".contains(c);
    match !argument.is_empty() && argument.chars().all(harmless) {
        true => argument.to_owned(),
        false => format!("'{}'", argument.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_quoted_as_a_shell_takes_them() {
        assert_eq!(quoted("anchoring.kind=parallel"), "anchoring.kind=parallel");
        assert_eq!(quoted("my scene.toml"), "'my scene.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
