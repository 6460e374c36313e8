//! `vesica accuracy SCENE`: what accuracy costs in time.

use super::error::CliError;
use super::numbers;
use super::output;
use super::run::some_step;
use super::shell::{scenes, settings};
use super::signals::EndSignal;
use crate::figure::{FigureOptions, save_study};
use crate::record::{RecordError, load_scene, try_to_write};
use crate::scene::Scene;
use crate::signals::EndingSignal;
use crate::study::{
    Budget, ComparedRun, ComparedRuns, ErrorSize, Offer, Point, Study, StudyError, StudyNews,
    chart, price_words, study,
};
use clap_complete::ArgValueCompleter;
use indicatif::{ProgressBar, ProgressStyle};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Without `--budget`, in seconds.
const QUICK: u64 = 120;
/// With `--full`.
const FULL: u64 = 1800;

/// Arguments of `vesica accuracy`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The scene is computed on several meshes with several tolerances, each compared with a finer run, within \
the budget; what would not fit is left out. A budget that does not pay for an answer is refused, with one \
that does. Ctrl-C ends the study with what there is.

The list of prices comes first: what vesica run SCENE --accuracy E will take for five errors E. It takes some seconds \
beside the budget.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file
    #[arg(add = ArgValueCompleter::new(scenes))]
    scene: OsString,

    /// Where the diagram and its data go
    #[arg(long, value_name = "DIR", default_value = "accuracy")]
    out: PathBuf,

    /// How long it may take, in seconds [default: 120, with --full 1800]
    #[arg(long, value_name = "SECONDS", value_parser = numbers::budget, allow_negative_numbers = true)]
    budget: Option<u64>,

    /// The folder of a finished run, of any scene that ends at the same time, to be compared with the
    /// others; can be given several times
    #[arg(long, value_name = "RUN")]
    beside: Vec<PathBuf>,

    /// The folder of a finished run to measure the errors against, in place of a finer run
    #[arg(long, value_name = "RUN")]
    against: Option<PathBuf>,

    /// More meshes, smaller tolerances, a finer reference
    #[arg(long)]
    full: bool,

    /// Print what was found as JSON, without the list of prices
    #[arg(long)]
    json: bool,

    /// The list of prices alone: nodes, seconds and memory for five errors of φ
    #[arg(long, conflicts_with_all = ["out", "budget", "beside", "against", "full", "json"])]
    prices: bool,

    /// Override a value of the scene, such as anchoring.kind=parallel
    #[arg(long, value_name = "KEY=VALUE", add = ArgValueCompleter::new(settings))]
    set: Vec<String>,
}

/// Makes the study, saves and prints it.
pub(super) fn accuracy(arguments: &Arguments) -> Result<(), CliError> {
    let loaded = load_scene(&arguments.scene, &arguments.set)?;
    some_step(&loaded.scene.time)?;
    let read = |path: &PathBuf| ComparedRun::read(path, &loaded.scene);
    let finished = ComparedRuns {
        beside: arguments
            .beside
            .iter()
            .map(read)
            .collect::<Result<_, _>>()?,
        against: arguments.against.as_ref().map(read).transpose()?,
    };
    let signal = EndSignal::listen()?;
    let is_new = !arguments.prices && make_room(&arguments.out)?;
    if !arguments.json {
        print_prices(&loaded.scene, &signal)?;
    }
    if arguments.prices {
        return Ok(());
    }
    let default = if arguments.full { FULL } else { QUICK };
    let budget = Budget {
        time: Duration::from_secs(arguments.budget.unwrap_or(default)),
        full: arguments.full,
    };
    let bar = ProgressBar::with_draw_target(Some(1000), output::progress_target());
    // The template is right; if it ever were not, the plain bar serves.
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let begun = Instant::now();
    // The bar shows the time that is used up, which never becomes less; the words, how far the run is.
    let mut watch = |event: StudyNews| {
        let used = begun.elapsed().as_secs_f64() / budget.time.as_secs_f64();
        bar.set_position((1000.0 * used).min(1000.0) as u64);
        match event {
            StudyNews::FirstSteps => bar.set_message("of the budget; the first steps"),
            StudyNews::Run(choice, share) => {
                bar.set_message(format!("of the budget; {choice}: {:.0} %", 100.0 * share));
            }
            StudyNews::Note(words) => bar.suspend(|| output::note(words)),
        }
        signal.received().is_none()
    };
    let result = study(&loaded.scene, budget, finished, &mut watch);
    bar.finish_and_clear();
    if result.is_err() && is_new {
        // It is empty.
        let _ = fs::remove_dir(&arguments.out);
    }
    let ended = signal.received();
    let result = match (result, ended) {
        (Err(StudyError::Ended), Some(EndingSignal { name, number, .. })) => {
            return Err(CliError::StudyEnded {
                signal: name,
                number,
            });
        }
        (result, _) => result?,
    };
    match arguments.json {
        true => output::json(&result)?,
        false => print(&result)?,
    }
    let name = loaded.name.to_string_lossy();
    let command = format!(
        "vesica accuracy {name}{}{}{} --budget {}{}",
        arguments
            .beside
            .iter()
            .map(|run| format!(" --beside {}", run.display()))
            .collect::<String>(),
        arguments
            .against
            .iter()
            .map(|run| format!(" --against {}", run.display()))
            .collect::<String>(),
        if arguments.full { " --full" } else { "" },
        budget.time.as_secs(),
        arguments
            .set
            .iter()
            .map(|set| format!(" --set {set}"))
            .collect::<String>(),
    );
    let options = FigureOptions::default();
    let files = save_study(&result, &name, &command, &options, &arguments.out)?;
    for file in files.iter().filter(|_| !arguments.json) {
        output::summary(file.display())?;
    }
    match ended {
        None => Ok(()),
        Some(EndingSignal { name, number, .. }) => Err(CliError::AccuracyInterrupted {
            signal: name,
            number,
            files,
        }),
    }
}

/// Makes the folder of the study, before anything is computed in vain; whether it was not there.
fn make_room(folder: &Path) -> Result<bool, RecordError> {
    let is_new = !folder.exists();
    fs::create_dir_all(folder).map_err(|reason| RecordError::MakeFolder {
        path: folder.to_owned(),
        reason,
    })?;
    try_to_write(&folder.join("accuracy"))?;
    Ok(is_new)
}

/// Prints what each error of the list will take on this machine.
fn print_prices(scene: &Scene, signal: &EndSignal) -> Result<(), CliError> {
    output::line(format_args!(
        "{:>8} {:>9} {:>7}  on this machine",
        "accuracy", "edges", "nodes"
    ))?;
    for offer in Offer::all(scene) {
        let row = match &offer.offered {
            Ok(offered) => {
                let mut go_on = || signal.received().is_none();
                let Some(price) = price_words(&offered.scene, &mut go_on) else {
                    break;
                };
                let (Ok(price) | Err(price)) = price;
                format!("{:>9} {:>7}  {price}", offered.edge, offered.nodes)
            }
            Err(why) => why.to_string(),
        };
        output::line(format_args!("{:>8} {row}", format!("{:e}", offer.error)))?;
    }
    output::line("")
}

fn print(study: &Study) -> Result<(), CliError> {
    output::line(format_args!(
        "{:<17}  {:>6} {:<18} {:<10} {:>9} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}",
        "mesh",
        "nodes",
        "steps",
        "",
        "seconds",
        "MB",
        "steps",
        "φ",
        "membrane",
        "E_total",
        "of steps"
    ))?;
    for point in &study.points {
        output::line(row(point))?;
    }
    if let Some(reference) = &study.reference {
        let part = |error: Option<ErrorSize>| {
            error.map_or("of unknown size".to_owned(), |error| {
                format!("about {error:.1e}")
            })
        };
        output::line(format_args!(
            "Reference: {}, {} ({:.1} s); its own error in φ is {} from its mesh and {} from its steps.",
            match &reference.run {
                Some(run) => run.clone(),
                None => reference.mesh.clone(),
            },
            reference.pace,
            reference.seconds,
            part(reference.space_error),
            part(reference.time_error),
        ))?;
    }
    for (what, order) in [
        ("h", study.order_in_space),
        ("the tolerance", study.order_in_tolerance),
    ] {
        if let Some(order) = order {
            output::line(format_args!(
                "Observed order in {what}: {:.2} ({:.2} to {:.2}).",
                order.last, order.least, order.greatest
            ))?;
        }
    }
    let effectivities = ["steps", "mesh"].into_iter().zip(study.effectivities());
    for (what, range) in effectivities {
        if let Some([least, greatest]) = range {
            output::line(format_args!(
                "The runs' own estimates of the error of the {what} are {least:.2} to {greatest:.2} times \
                 what was measured."
            ))?;
        }
    }
    output::line(chart(study))?;
    for sentence in &study.sentences {
        output::line(sentence)?;
    }
    Ok(())
}

fn row(point: &Point) -> String {
    let number =
        |error: Option<ErrorSize>| error.map_or("-".to_owned(), |error| format!("{error:.2e}"));
    let memory = point
        .memory
        .map_or("-".to_owned(), |bytes| format!("{:.0}", bytes as f64 / 1e6));
    let how = match (point.quadrature, point.iteration) {
        ("consistent", "newton") => "",
        ("consistent", other) => other,
        (rule, _) => rule,
    };
    let errors = point.errors;
    let mut row = format!(
        "{:<17}{} {:>6} {:<18} {how:<10} {:>9} {memory:>7} {:>7} {:>9} {:>9} {:>9} {:>9}",
        point.mesh,
        if point.is_own { "*" } else { " " },
        point.nodes,
        point.pace.to_string(),
        format!("{:.2}", point.seconds),
        point.steps,
        number(point.error()),
        number(errors.and_then(|it| it.membrane)),
        number(errors.and_then(|it| it.energy)),
        number(point.time_error),
    );
    if let Some(run) = &point.run {
        row.push_str("  ");
        row.push_str(run);
    }
    if let Some(reason) = &point.failure {
        row.push_str("  ");
        row.push_str(reason);
    }
    row
}
