//! `vesica sweep PLAN --list`: the points, and what they will take.

use super::{count_of, duration};
use crate::cli::error::CliError;
use crate::cli::output;
use crate::study::sweep::{Needs, Point, Sweep, plain, predict};
use std::num::NonZero;
use std::path::Path;
use std::thread;

/// Prints a line for each point, and their sum.
pub(super) fn list(plan: &Path, quick: bool) -> Result<(), CliError> {
    let sweep = Sweep::read(plan)?;
    let needs = match quick {
        true => sweep.needs.clone(),
        // Nobody is there who might not want to wait: Ctrl-C ends the process.
        false => predict(&sweep, &mut || true)?,
    };
    output::print(&text(&sweep, &needs))
}

fn text(sweep: &Sweep, needs: &[Needs]) -> String {
    let keys = sweep.plan.varied_keys();
    let has_repetitions = sweep.plan.repeat.is_some();
    let mut head = vec!["point".to_owned()];
    head.extend(keys.iter().cloned());
    head.extend(has_repetitions.then(|| "repetition".to_owned()));
    head.extend(["time", "memory", ""].map(str::to_owned));
    let row = |(point, needs): (&Point, &Needs)| {
        let mut cells = vec![point.name.clone()];
        cells.extend(point.values.iter().map(|value| plain(value)));
        cells.extend(has_repetitions.then(|| point.repetition.to_string()));
        cells.push(needs.seconds.map_or("?".to_owned(), duration));
        cells.push(format!("{:.0} MB", needs.memory as f64 / 1e6));
        cells.push(match point.same_as {
            Some(other) => format!("same as {}", sweep.points[other - 1].name),
            None => String::new(),
        });
        cells
    };
    let rows = sweep.points.iter().zip(needs).map(row);
    let lines: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    let widths: Vec<usize> = (0..lines[0].len())
        .map(|column| {
            let widths = lines.iter().map(|line| line[column].chars().count());
            widths.max().unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for line in &lines {
        let cells = line.iter().zip(&widths);
        let padded: Vec<String> = cells
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        text += padded.join("  ").trim_end();
        text.push('\n');
    }
    text + &total(sweep, needs) + "\n"
}

fn total(sweep: &Sweep, needs: &[Needs]) -> String {
    let runs = sweep.points.iter().zip(needs);
    let runs: Vec<&Needs> = runs
        .filter(|(point, _)| point.same_as.is_none())
        .map(|(_, needs)| needs)
        .collect();
    let mut text = count_of(sweep.points.len(), "point");
    if runs.len() < sweep.points.len() {
        text += &format!(", {} to be run", runs.len());
    }
    let seconds: Option<f64> = runs.iter().map(|needs| needs.seconds).sum();
    match seconds {
        Some(seconds) => {
            let processors = thread::available_parallelism().map_or(1, NonZero::get);
            text += &format!(
                ": about {} of computing, {} on the {processors} processors here",
                duration(seconds),
                duration(seconds / processors.min(runs.len().max(1)) as f64),
            );
        }
        None => text += ": how long they take was not found out",
    }
    let most = runs.iter().map(|needs| needs.memory).max().unwrap_or(0);
    text + &format!("; at most {:.0} MB a run", most as f64 / 1e6)
}
