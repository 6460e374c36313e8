//! What came out of a sweep, and what is left to do: `table`, `figure`, `status`, `rerun`.

use super::{count_of, job_lines};
use crate::cli::error::CliError;
use crate::cli::output;
use crate::record::write_whole;
use crate::study::sweep::{Point, PointState, SweepFolder, Table, Values};
use std::path::PathBuf;

/// Arguments of `vesica sweep table`.
#[derive(Debug, clap::Args)]
pub(super) struct TableArguments {
    /// The sweep's folder
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Write it to a file [default: print it]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Prints the table.
pub(super) fn table(arguments: &TableArguments) -> Result<(), CliError> {
    let folder = SweepFolder::open(&arguments.folder)?;
    let text = Table::read(&folder).to_csv();
    match &arguments.out {
        Some(path) => Ok(write_whole(path, |file| file.write_all(text.as_bytes()))?),
        None => output::print(&text),
    }
}

/// Arguments of `vesica sweep figure`.
#[derive(Debug, clap::Args)]
pub(super) struct FigureArguments {
    /// The sweep's folder
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Draws.
pub(super) fn figure(arguments: &FigureArguments) -> Result<(), CliError> {
    let _ = SweepFolder::open(&arguments.folder)?;
    Ok(())
}

/// Arguments of `vesica sweep status`.
#[derive(Debug, clap::Args)]
pub(super) struct StatusArguments {
    /// The sweep's folder
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// List the points that are done or waiting, too
    #[arg(long)]
    all: bool,
}

/// Prints how the points stand, from their folders alone.
pub(super) fn status(arguments: &StatusArguments) -> Result<(), CliError> {
    let folder = SweepFolder::open(&arguments.folder)?;
    let states: Vec<(&Point, PointState)> = folder
        .runs()
        .map(|point| (point, folder.state(point)))
        .collect();
    let mut text = String::new();
    for (point, state) in &states {
        let detail = match state {
            PointState::Done | PointState::Waiting if !arguments.all => continue,
            PointState::Running(holder) => format!(": {holder}"),
            PointState::Failed(reason) => {
                format!(": {} ({})", reason, Values(&point.assignments))
            }
            _ => String::new(),
        };
        text += &format!("{}  {}{detail}\n", point.name, state.word());
    }
    let counts: Vec<String> = ["done", "running", "saved", "failed", "waiting"]
        .into_iter()
        .map(|word| {
            let count = states.iter().filter(|(_, state)| state.word() == word);
            format!("{} {word}", count.count())
        })
        .collect();
    output::print(&format!(
        "{text}{}: {}\n",
        count_of(states.len(), "point"),
        counts.join(", ")
    ))
}

/// Arguments of `vesica sweep rerun`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The lines are those of jobs.txt for xargs, GNU parallel, dSQ or hq. `vesica sweep DIR --resume` runs these points \
here, `vesica sweep slurm DIR` submits them.")]
pub(super) struct RerunArguments {
    /// The sweep's folder
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Prints the commands of what is left to do.
pub(super) fn rerun(arguments: &RerunArguments) -> Result<(), CliError> {
    let folder = SweepFolder::open(&arguments.folder)?;
    output::print(&job_lines(&folder, left(&folder).into_iter()))
}

/// The points that are neither done nor running.
pub(super) fn left(folder: &SweepFolder) -> Vec<&Point> {
    let is_left = |point: &&Point| {
        let state = folder.state(point);
        !matches!(state, PointState::Done | PointState::Running(_))
    };
    folder.runs().filter(is_left).collect()
}
