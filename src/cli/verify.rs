//! `vesica verify RUN`: whether a run's scene gives the same numbers again.

use super::error::CliError;
use super::numbers;
use super::output;
use super::progress::Progress;
use super::set_up::{Outcome, set_up};
use super::signals::EndSignal;
use crate::record::{
    Build, Columns, Ending, IfOccupied, LoadError, RecordError, RecordedSummary, Recorder,
    RecorderBuilder, RunFolder, Settings, changed_inputs, load_run_scene, read_summary,
};
use crate::simulation::{Simulation, check_memory, cores, threads_that_pay};
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Arguments of `vesica verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The scene in the run's folder is computed again, up to the last row of its history.csv, and nothing in the folder is \
changed. All columns of history.csv and shape.csv are compared, but for wall.

Exit status: 0 the numbers are the same, bit for bit or within --tolerance; 1 they are not; 2 it is not a run's \
folder; 128 + n ended by signal n (130 for Ctrl-C), with nothing found out.")]
pub(super) struct Arguments {
    /// The folder of a run
    #[arg(value_name = "RUN", value_hint = clap::ValueHint::DirPath)]
    run: PathBuf,

    /// Compare the first N steps only
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Take a column as the same where it differs by at most E times its largest value
    #[arg(long, value_name = "E", value_parser = numbers::accuracy, allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Compute in N threads; the numbers are the same [default: as many as there are and pay]
    #[arg(long, value_name = "N", env = "VESICA_THREADS", value_parser = numbers::threads,
          allow_negative_numbers = true)]
    threads: Option<usize>,

    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
}

/// What came out.
#[derive(Debug, Serialize)]
struct Verdict {
    /// The run's folder.
    run: String,
    /// Whether all numbers are the same, bit for bit.
    identical: bool,
    /// Whether they are the same within the tolerance.
    same: bool,
    /// Rows that were compared.
    rows: usize,
    /// Rows of the run that the repetition does not have.
    missing_rows: usize,
    /// Rows of the repetition that the run does not have.
    lost_rows: usize,
    /// The last step that was compared.
    last_step: u64,
    /// Inputs that are not the files that the run was computed from.
    changed_inputs: Vec<String>,
    /// Whether the program is the one that computed the run.
    same_program: Option<bool>,
    /// The columns that differ.
    differences: Vec<Difference>,
}

/// How a column differs.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    /// Its name.
    column: String,
    /// The first step at which it differs.
    first_step: u64,
    /// In how many rows.
    rows: usize,
    /// The largest difference; `null`: there is a number in one of the two only.
    largest: Option<f64>,
    /// Over the largest value of the column.
    relative: Option<f64>,
}

/// Computes the run again, and compares.
pub(super) fn verify(arguments: &Arguments) -> Result<(), CliError> {
    let run = &arguments.run;
    let summary = read_summary(run)?;
    let recorded = Columns::read(run)?;
    let scene = load_run_scene(run, &[]).map_err(|error| match error {
        LoadError::NoScene { folder } => CliError::NothingToRepeat { folder },
        error => CliError::Load(error),
    })?;
    let scene = scene.scene;
    // Of a run that was killed the table is ahead of run.json; of no run it is behind.
    let end = last_step(&recorded).max(summary.steps);
    let last = end.min(arguments.steps.unwrap_or(end));
    check_memory(&scene).map_err(CliError::SetUp)?;
    let changed_inputs = changed_inputs(run, &summary.inputs)?;
    output::doubts(run, &summary);
    let signal = EndSignal::listen()?;
    let temporary = tempfile::tempdir().map_err(|reason| {
        CliError::Record(RecordError::MakeFolder {
            path: std::env::temp_dir(),
            reason,
        })
    })?;
    let folder = RunFolder::at(temporary.path(), IfOccupied::Refuse)?;
    let settings = Settings {
        every: summary.every,
        snapshots: summary.snapshots,
        checkpoint: Duration::MAX,
        ..Settings::default()
    };
    let builder = RecorderBuilder::begin(folder, &scene, settings)?;
    let mut simulation = match set_up(&scene, &signal)? {
        Outcome::Ready(simulation) => *simulation,
        Outcome::Signal(signal) => return Err(CliError::VerifyEnded(signal)),
        Outcome::Failed(error) => return Err(CliError::SetUp(error)),
    };
    let nodes = simulation.mesh().nodes().len();
    let threads = arguments.threads;
    simulation.set_threads(threads.unwrap_or_else(|| threads_that_pay(nodes, cores())));
    simulation.follow(builder.schedule());
    let mut recorder = builder.start(&simulation, Duration::ZERO)?;
    let mut progress = Progress::new(recorder.schedule());
    let begun = Instant::now();
    while simulation.report().step < last && !is_over(&simulation, &recorder) {
        if let Some(signal) = signal.received() {
            return Err(CliError::VerifyEnded(signal));
        }
        let is_whole = simulation
            .advance_unless(&mut |_| signal.received().is_some())
            .map_err(CliError::Repeat)?;
        if is_whole {
            recorder.step(&mut simulation, begun.elapsed())?;
            progress.show(simulation.report());
        }
    }
    drop(progress);
    recorder.finish(&mut simulation, Ending::Done)?;
    let repeated = Columns::read(temporary.path())?;
    let verdict = verdict(
        arguments,
        (&summary, changed_inputs),
        (&recorded, &repeated),
        (last, end),
    );
    tell(&verdict, arguments.json)?;
    match verdict.same {
        true => Ok(()),
        false => Err(CliError::Differs {
            folder: run.clone(),
        }),
    }
}

fn is_over(simulation: &Simulation, recorder: &Recorder) -> bool {
    let report = simulation.report();
    recorder.schedule().is_over(report.step, report.t)
}

fn last_step(columns: &Columns) -> u64 {
    let last = columns.column("step").and_then(|steps| steps.last());
    last.map_or(0, |step| *step as u64)
}

fn verdict(
    arguments: &Arguments,
    (summary, changed_inputs): (&RecordedSummary, Vec<String>),
    (recorded, repeated): (&Columns, &Columns),
    (last, end): (u64, u64),
) -> Verdict {
    let pairs = pairs(recorded, repeated, last);
    let rows: Vec<(usize, usize)> = pairs.iter().flatten().copied().collect();
    let missing_rows = pairs.len() - rows.len();
    // A repetition that ends earlier than the run has its last row wherever that is.
    let is_due =
        |step: u64| last == end || step < last || step.is_multiple_of(summary.every.max(1));
    let is_lost = |row: &usize| rows.binary_search_by_key(row, |(_, other)| *other).is_err();
    let again = repeated.column("step").unwrap_or_default();
    let again = again.iter().enumerate();
    let lost_rows = again.filter(|(row, step)| is_due(**step as u64) && is_lost(row));
    let lost_rows = lost_rows.count();
    let only_repeated = repeated
        .names()
        .filter(|name| recorded.column(name).is_none());
    let differences: Vec<Difference> = recorded
        .names()
        .chain(only_repeated)
        .filter(|name| *name != "wall")
        .filter_map(|name| difference(name, recorded, repeated, &rows))
        .collect();
    let tolerance = arguments.tolerance.unwrap_or(0.0);
    let is_within = |difference: &Difference| {
        difference
            .relative
            .is_some_and(|relative| relative <= tolerance)
    };
    let programs: Vec<&Build> = summary.sessions.iter().map(|it| &it.program).collect();
    let present = Build::present();
    Verdict {
        run: arguments.run.display().to_string(),
        identical: missing_rows + lost_rows == 0 && differences.is_empty(),
        same: missing_rows + lost_rows == 0 && differences.iter().all(is_within),
        rows: rows.len(),
        missing_rows,
        lost_rows,
        last_step: last,
        changed_inputs,
        same_program: (!programs.is_empty())
            .then(|| programs.iter().all(|program| **program == present)),
        differences,
    }
}

/// Of each row of the run up to a step its number, and that of the row of the same step in the repetition.
fn pairs(recorded: &Columns, repeated: &Columns, last: u64) -> Vec<Option<(usize, usize)>> {
    let steps = |columns: &Columns| columns.column("step").unwrap_or_default().to_vec();
    let again = steps(repeated);
    let mut rows = Vec::new();
    for (row, step) in steps(recorded).into_iter().enumerate() {
        if step > last as f64 {
            break;
        }
        let other = again.binary_search_by(|other| other.total_cmp(&step)).ok();
        rows.push(other.map(|other| (row, other)));
    }
    rows
}

/// How a column differs over these pairs of rows, if it does.
fn difference(
    name: &str,
    recorded: &Columns,
    repeated: &Columns,
    rows: &[(usize, usize)],
) -> Option<Difference> {
    // Where one of the two has no such column, it has no number in any row.
    let value = |columns: &Columns, row: usize| {
        let values = columns.column(name);
        values.map_or(f64::NAN, |values| values[row])
    };
    let steps = recorded.column("step")?;
    let is_same = |one: f64, other: f64| one == other || (one.is_nan() && other.is_nan());
    let different: Vec<(usize, f64)> = rows
        .iter()
        .map(|&(row, other)| (row, value(repeated, other)))
        .filter(|&(row, other)| !is_same(value(recorded, row), other))
        .collect();
    let &(first, _) = different.first()?;
    // What is a number in one of the two only is infinitely different.
    let size = |&(row, other): &(usize, f64)| {
        let size = (value(recorded, row) - other).abs();
        if size.is_nan() { f64::INFINITY } else { size }
    };
    let largest = different.iter().map(size).fold(0.0, f64::max);
    let scale = rows
        .iter()
        .map(|&(row, _)| value(recorded, row).abs())
        .fold(0.0, f64::max);
    let finite = |number: f64| number.is_finite().then_some(number);
    Some(Difference {
        column: name.to_owned(),
        first_step: steps[first] as u64,
        rows: different.len(),
        largest: finite(largest),
        relative: finite(largest / scale),
    })
}

/// Prints what came out.
fn tell(verdict: &Verdict, json: bool) -> Result<(), CliError> {
    if json {
        return output::json(verdict);
    }
    let Verdict {
        run,
        rows,
        last_step,
        ..
    } = verdict;
    let program = match verdict.same_program {
        Some(true) => "by the program that computed it",
        Some(false) => "by another program than computed it",
        None => "which program computed it is not recorded",
    };
    if verdict.identical {
        return output::line(format_args!(
            "{run}: the same, bit for bit: {rows} rows up to step {last_step} ({program})"
        ));
    }
    let word = match verdict.same {
        true => "the same within the tolerance",
        false => "not the same",
    };
    let mut text =
        format!("{run}: {word}: {rows} rows up to step {last_step} compared ({program})\n");
    if verdict.missing_rows > 0 {
        text += &format!(
            "{} rows of the run are not there when it is repeated\n",
            verdict.missing_rows
        );
    }
    if verdict.lost_rows > 0 {
        text += &format!(
            "{} rows of the repetition are not there in the run\n",
            verdict.lost_rows
        );
    }
    let number =
        |number: Option<f64>| number.map_or("a gap".to_owned(), |number| format!("{number:.1e}"));
    for difference in &verdict.differences {
        text += &format!(
            "{:<14} differs in {} rows, from step {} on, by at most {}; over its largest value {}\n",
            difference.column,
            difference.rows,
            difference.first_step,
            number(difference.largest),
            number(difference.relative),
        );
    }
    output::print(&text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// The columns of a table.
    fn columns(rows: &str) -> Columns {
        let folder = tempfile::tempdir().expect("a folder");
        let head = crate::record::HISTORY_COLUMNS.join(",");
        fs::write(folder.path().join("history.csv"), format!("{head}\n{rows}"))
            .expect("it is written");
        Columns::read(folder.path()).expect("a table")
    }

    #[test]
    fn a_bit_is_a_difference_and_the_clock_is_none() {
        let row = |step: u32, energy: &str, area: &str, wall: &str| {
            format!("{step},{step},1,{energy},1,,,,1,{area},0,1,1,{wall}\n")
        };
        let one = columns(&(row(0, "4", "2", "0") + &row(1, "3", "2", "0.1")));
        let same = columns(&(row(0, "4", "2", "7") + &row(1, "3", "2", "8")));
        let rows: Vec<(usize, usize)> = pairs(&one, &same, 1).into_iter().flatten().collect();
        assert_eq!(rows, [(0, 0), (1, 1)]);
        let all = |other: &Columns| {
            let names = one.names().filter(|name| *name != "wall");
            let found: Vec<Difference> = names
                .filter_map(|name| difference(name, &one, other, &rows))
                .collect();
            found
        };
        assert_eq!(all(&same), []);
        let other = columns(&(row(0, "4", "2", "0") + &row(1, "3.0000000000000004", "", "0")));
        let [energy, area] = &all(&other)[..] else {
            panic!("two columns differ");
        };
        let bit = 3.0 * f64::EPSILON / 3.0 * 2.0;
        assert_eq!((energy.first_step, energy.rows), (1, 1));
        assert_eq!(energy.largest, Some(bit));
        assert_eq!(energy.relative, Some(bit / 4.0));
        assert_eq!((area.largest, area.relative), (None, None));
        // A row that is not there is not passed over.
        let short = columns(&row(0, "4", "2", "0"));
        assert_eq!(pairs(&one, &short, 1), [Some((0, 0)), None]);
        assert_eq!(pairs(&one, &short, 0), [Some((0, 0))]);
    }
}
