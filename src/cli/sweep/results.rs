//! What came out of a sweep, and what is left to do: `table`, `figure`, `status`, `rerun`.

use super::{Here, count_of, here, job_lines};
use crate::cli::error::CliError;
use crate::cli::figures::quoted;
use crate::cli::output;
use crate::cli::picture_size::PictureSize;
use crate::figure::{Existing, FigureOptions, SweepView, save_sweep};
use crate::record::{clean, write_whole};
use crate::study::sweep::{Damage, Point, PointState, SweepFolder, Table, Values};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsStr;
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
#[command(after_help = "\
Over one axis: curves. Over two: a map with contour lines. Over more: a panel for each value of the others. And the \
diagram of shapes: the last vesicle of each point at its place, coloured by the column. Each as PNG, SVG and CSV.")]
pub(super) struct FigureArguments {
    /// The sweep's folder, or a plan, which is run first
    #[arg(value_name = "DIR | PLAN")]
    folder: PathBuf,

    /// The figures' folder [default: DIR/figures]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// The column of the table that is drawn, and that colours the vesicles
    #[arg(long, value_name = "NAME", default_value = "waist/length")]
    column: String,

    /// The key along the abscissa [default: of those with numbers, the one with the most values]
    #[arg(long, value_name = "KEY")]
    x: Option<String>,

    /// The key along the ordinate
    #[arg(long, value_name = "KEY")]
    y: Option<String>,

    /// Only the points at which a key has this value
    #[arg(long = "where", value_name = "KEY=VALUE", value_parser = key_and_value)]
    fixed: Vec<(String, String)>,

    /// Curves, one for each value along the ordinate, in place of a map
    #[arg(long)]
    curves: bool,

    /// Of bodies of rotation alone: their bending energy over the reduced volume, with the branches of theory
    #[arg(long, conflicts_with_all = ["column", "x", "y", "curves"])]
    branches: bool,

    #[command(flatten)]
    size: PictureSize,

    /// Replace figures that the folder holds
    #[arg(long)]
    force: bool,
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    let parts = text
        .split_once('=')
        .filter(|(key, value)| !key.is_empty() && !value.is_empty());
    let (key, value) = parts.ok_or("it must be KEY=VALUE, such as anchoring.kind=parallel")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

impl FigureArguments {
    /// The command that draws the same figures.
    fn command(&self) -> String {
        let mut text = format!(
            "vesica sweep figure {}",
            quoted(&self.folder.to_string_lossy())
        );
        text += &match self.branches {
            true => " --branches".to_owned(),
            false => format!(" --column {}", quoted(&self.column)),
        };
        for (option, key) in [("--x", &self.x), ("--y", &self.y)] {
            text += &key
                .as_ref()
                .map_or(String::new(), |key| format!(" {option} {}", quoted(key)));
        }
        for (key, value) in &self.fixed {
            text += &format!(" --where {}", quoted(&format!("{key}={value}")));
        }
        text += if self.curves { " --curves" } else { "" };
        text + &format!(" {}", self.size)
    }
}

/// Draws.
pub(super) fn figure(arguments: &FigureArguments) -> Result<(), CliError> {
    let view = SweepView {
        column: arguments.column.clone(),
        x: arguments.x.clone(),
        y: arguments.y.clone(),
        fixed: arguments.fixed.clone(),
        curves: arguments.curves,
        branches: arguments.branches,
    };
    let options = FigureOptions {
        existing: match arguments.force {
            true => Existing::Replace,
            false => Existing::Refuse,
        },
        ..arguments.size.options()
    };
    let sweep = match arguments.folder.is_file() {
        true => here::run(&arguments.folder, &Here::default(), |sweep| {
            Ok(view.check(sweep)?)
        })?,
        false => SweepFolder::open(&arguments.folder)?,
    };
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| sweep.path().join("figures"));
    // What a process that was killed had left there.
    clean(&folder);
    let files = save_sweep(&sweep, &view, &arguments.command(), &options, &folder)?;
    let pictures = files
        .iter()
        .filter(|file| file.extension() == Some(OsStr::new("png")));
    let names: Vec<String> = pictures
        .filter_map(|file| Some(file.file_stem()?.to_string_lossy().into_owned()))
        .collect();
    if !arguments.branches && !names.iter().any(|name| name.starts_with("shapes-")) {
        output::note("the shapes are there already and stay as they are; --force draws them again");
    }
    output::summary(format_args!(
        "{}, each as PNG, SVG and CSV, in {}",
        names.join(" and "),
        folder.display()
    ))
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

    /// Print all points as JSON
    #[arg(long, conflicts_with = "all")]
    json: bool,
}

/// Prints how the points stand, from their folders alone.
pub(super) fn status(arguments: &StatusArguments) -> Result<(), CliError> {
    let folder = SweepFolder::open(&arguments.folder)?;
    let states: Vec<(&Point, PointState)> = folder
        .runs()
        .map(|point| (point, folder.state(point)))
        .collect();
    if arguments.json {
        return output::json(&StatusReport::new(&states));
    }
    let mut text = String::new();
    for (point, state) in &states {
        let detail = match state {
            PointState::Done | PointState::Waiting if !arguments.all => continue,
            PointState::Running(holder) => format!(": {holder}"),
            PointState::Damaged(damage) => format!(": {}", repair(*damage, &folder)),
            PointState::Failed(reason) => {
                format!(": {} ({})", reason, Values(&point.assignments))
            }
            _ => String::new(),
        };
        text += &format!("{}  {}{detail}\n", point.name, state.word());
    }
    let counts: Vec<String> = PointState::WORDS
        .into_iter()
        .map(|word| format!("{} {word}", count(&states, word)))
        .collect();
    output::print(&format!(
        "{text}{}: {}\n",
        count_of(states.len(), "point"),
        counts.join(", ")
    ))
}

/// What is wrong with a point, and what to do about it.
fn repair(damage: Damage, folder: &SweepFolder) -> String {
    let resume = format!("`vesica sweep {} --resume`", folder.path().display());
    match damage {
        Damage::NotAFolder => {
            format!("{damage}: remove it or give it another name; then {resume} computes the point")
        }
        Damage::Missing(_) | Damage::Short(_) => {
            format!("{damage}: {resume} computes the point again")
        }
    }
}

/// How many points stand so.
fn count(states: &[(&Point, PointState)], word: &str) -> usize {
    let those = states.iter().filter(|(_, state)| state.word() == word);
    those.count()
}

/// How the points of a sweep stand, for programs.
#[derive(Debug, Serialize)]
struct StatusReport {
    /// How many stand so, by the word for it.
    counts: BTreeMap<&'static str, usize>,
    points: Vec<PointStatus>,
}

/// How a point stands.
#[derive(Debug, Serialize)]
struct PointStatus {
    /// Its folder's name.
    point: String,
    state: &'static str,
    /// Who works on it, why it failed, or what is damaged.
    detail: Option<String>,
    /// The values that it sets, as words.
    values: String,
}

impl StatusReport {
    fn new(states: &[(&Point, PointState)]) -> Self {
        let counts = PointState::WORDS.map(|word| (word, count(states, word)));
        let points = states.iter().map(|(point, state)| PointStatus {
            point: point.name.clone(),
            state: state.word(),
            detail: match state {
                PointState::Running(holder) => Some(holder.to_string()),
                PointState::Failed(reason) => Some(reason.clone()),
                PointState::Damaged(damage) => Some(damage.to_string()),
                _ => None,
            },
            values: Values(&point.assignments).to_string(),
        });
        Self {
            counts: counts.into(),
            points: points.collect(),
        }
    }
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
