//! `vesica sweep`: many runs of one scene with other values.

mod here;
mod list;
mod point;
mod results;
mod slurm;

pub(super) use slurm::SlurmError;

use super::error::CliError;
use super::figures::quoted;
use super::numbers;
use super::output;
use crate::record::write_whole;
use crate::study::sweep::{Needs, Point, Sweep, SweepError, SweepFolder};
use clap::Subcommand;
use std::path::{Path, PathBuf};

/// Where sweeps go that are given no folder.
const SWEEPS: &str = "sweeps";

/// Arguments of `vesica sweep`.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "\
PLAN is a TOML file that says which scene, and which of its values vary; every point is checked before the first \
is run. Each point is a run's folder in DIR/points. See the guide: docs/guide/sweeps.md.

Exit status: 0 all points are done; 1 some failed, and the others are done; 2 the arguments or the plan are wrong, \
and nothing was started; 75 ended by a signal, such as Ctrl-C, with everything saved, or another process works on \
the points that are left: --resume continues it."
)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,

    #[command(flatten)]
    here: Here,
}

/// A sweep on this machine.
#[derive(Debug, Default, clap::Args)]
#[group(id = "here")]
struct Here {
    /// The plan, or with --resume the folder of a sweep
    #[arg(required = true, value_name = "PLAN")]
    plan: Option<PathBuf>,

    /// The sweep's folder [default: sweeps/NAME, then sweeps/NAME-2, …]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// So many runs at a time [default: as many as there are processors]
    #[arg(long, short, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    jobs: Option<u64>,

    /// Go on with a sweep that was ended: only what is not done
    #[arg(long)]
    resume: bool,

    /// Start no more points when more than N have failed
    #[arg(long, value_name = "N", value_parser = numbers::count, allow_negative_numbers = true)]
    max_failures: Option<u64>,

    /// List the points, with their predicted time and memory, and run nothing
    #[arg(long, conflicts_with_all = ["out", "jobs", "resume", "max_failures"])]
    list: bool,

    /// With --list: try no steps, so predict no times
    #[arg(long, requires = "list")]
    quick: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the table: a row for each point, also while the sweep runs
    Table(results::TableArguments),
    /// Draw curves, a map, or the diagram of shapes
    Figure(results::FigureArguments),
    /// Tell which points are done, running, saved, failed, damaged or waiting
    Status(results::StatusArguments),
    /// Print a command for each point that is neither done nor running
    Rerun(results::RerunArguments),
    /// Submit the points to Slurm, as a job array
    Slurm(slurm::Arguments),
    /// Run some points of a sweep's folder: what jobs.txt and the job arrays do
    Point(point::Arguments),
}

/// Runs a sweep, or what else is asked for.
pub(super) fn sweep(arguments: &Arguments) -> Result<(), CliError> {
    match &arguments.command {
        Some(Command::Table(arguments)) => results::table(arguments),
        Some(Command::Figure(arguments)) => results::figure(arguments),
        Some(Command::Status(arguments)) => results::status(arguments),
        Some(Command::Rerun(arguments)) => results::rerun(arguments),
        Some(Command::Slurm(arguments)) => slurm::slurm(arguments),
        Some(Command::Point(arguments)) => point::points(arguments),
        None => match &arguments.here.plan {
            Some(plan) if arguments.here.list => list::list(plan, arguments.here.quick),
            Some(plan) => here::run(plan, &arguments.here, |_| Ok(())).map(drop),
            None => Ok(()),
        },
    }
}

/// The folder of a sweep: that which `plan` names, or one for the plan, new or to be resumed.
fn open(
    plan: &Path,
    out: Option<&Path>,
    resume: bool,
    predicted: impl FnOnce(&Sweep) -> Result<Vec<Needs>, CliError>,
) -> Result<SweepFolder, CliError> {
    if plan.is_dir() {
        let folder = SweepFolder::open(plan)?;
        return match resume {
            true => folder
                .make_points()
                .map(|()| folder)
                .map_err(CliError::from),
            false => Err(CliError::Sweep(SweepError::Occupied {
                folder: plan.to_owned(),
            })),
        };
    }
    let sweep = Sweep::read(plan)?;
    if let Some(out) = out
        && resume
        && SweepFolder::is_one(out)
    {
        let folder = SweepFolder::resume(out, &sweep)?;
        folder.make_points()?;
        return Ok(folder);
    }
    let needs = predicted(&sweep)?;
    let path = match out {
        Some(out) => out.to_owned(),
        None => {
            let name = plan.file_stem().unwrap_or(plan.as_os_str());
            SweepFolder::numbered(Path::new(SWEEPS), &name.to_string_lossy())?
        }
    };
    let folder = SweepFolder::create(&path, &sweep, needs)?;
    write_jobs(&folder)?;
    Ok(folder)
}

/// The command that runs points, on its own: with all paths from the root.
fn command(folder: &SweepFolder, points: &[&str]) -> String {
    let program = std::env::current_exe().unwrap_or(PathBuf::from("vesica"));
    let path = |path: &Path| quoted(&path.to_string_lossy());
    let (program, sweep) = (path(&program), path(folder.path()));
    format!("{program} sweep point {sweep} {}", points.join(" "))
}

/// The lines of `jobs.txt` for some points.
fn job_lines<'a>(folder: &SweepFolder, points: impl Iterator<Item = &'a Point>) -> String {
    points
        .map(|point| command(folder, &[&point.name]) + "\n")
        .collect()
}

fn write_jobs(folder: &SweepFolder) -> Result<(), CliError> {
    let text = job_lines(folder, folder.runs());
    let path = folder.path().join("jobs.txt");
    Ok(write_whole(&path, |file| file.write_all(text.as_bytes()))?)
}

/// "1 point", "2 points".
fn count_of(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

/// Tells what is unusual about a plan.
fn tell_same(folder: &SweepFolder) {
    let same = folder.points().len() - folder.runs().count();
    if same > 0 {
        output::note(format_args!(
            "{} the same scene as another, and run once",
            match same {
                1 => "1 point is".to_owned(),
                same => format!("{same} points are"),
            }
        ));
    }
}

/// Seconds in words.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 600.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} days", s / 86_400.0),
    }
}
