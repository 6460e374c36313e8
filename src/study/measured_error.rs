//! The measured error of a run: how far it is from the same scene computed finer, and how uncertain that is.
//!
//! Three runs R, M and F have edges h, h/√f and h/f, and steps whose errors are in the proportion 1, 1/f and 1/f². With an error
//! of order p in h the distances of their states in L2 are in the proportion ‖R − M‖/‖M − F‖ = √f^p, which gives the observed
//! order p. The measured error is ‖R − F‖. What the finer run itself misses is by Richardson's extrapolation
//! ‖M − F‖/(√f^p − 1) with p at most 2, times a safety factor (Roache 1998): 1.25 where the observed order is between half
//! of 2 and twice 2; else it is off, and the factor is 3.

use super::errors::Solution;
use crate::fem::Mesh;
use crate::record::{Columns, ShortNumber, push_cells};
use crate::scene::significant;
use crate::scheme::State;
use crate::simulation::{OutlineMeasure, Report};
use std::fmt;
use std::sync::Arc;

/// The order of linear elements and of the secant scheme.
const FORMAL_ORDER: f64 = 2.0;

/// An observed order between these is near enough to it.
const SANE: [f64; 2] = [0.5 * FORMAL_ORDER, 2.0 * FORMAL_ORDER];

/// With a lower observed order nothing is known of the finer run.
const LEAST_ORDER: f64 = 0.5;

/// The safety factors where the observed order is sane, and where it is not.
const SAFETY: [f64; 2] = [1.25, 3.0];

/// The state of a run at one time, with its scalars.
#[derive(Debug, Clone)]
pub struct Sample {
    solution: Solution,
    scalars: Vec<(String, f64)>,
}

impl Sample {
    /// A state and its report.
    pub fn new(mesh: &Arc<Mesh>, state: &State, report: &Report) -> Self {
        let mut scalars = vec![("E_total".to_owned(), report.total_energy)];
        let energies = report.energies.iter();
        scalars.extend(energies.map(|energy| (format!("E_{}", energy.name), energy.value)));
        if let Some(OutlineMeasure { length, waist, .. }) = report.outline() {
            scalars.push(("length".to_owned(), length));
            scalars.push(("waist".to_owned(), waist));
        }
        Self::with(mesh, state, scalars)
    }

    /// A recorded state, and the tables of its run, whose row of that step has the scalars.
    pub fn recorded(mesh: &Arc<Mesh>, state: &State, step: u64, tables: &Columns) -> Self {
        let row = tables
            .known("step")
            .and_then(|steps| steps.iter().rposition(|known| *known == step as f64));
        let is_wanted = |name: &&str| name.starts_with("E_") || ["length", "waist"].contains(name);
        let scalar = |name: &str| Some((name.to_owned(), tables.known(name)?[row?]));
        let scalars = tables.names().filter(is_wanted).filter_map(scalar);
        let scalars = scalars.filter(|(_, value)| value.is_finite()).collect();
        Self::with(mesh, state, scalars)
    }

    fn with(mesh: &Arc<Mesh>, state: &State, scalars: Vec<(String, f64)>) -> Self {
        Self {
            // The scalars are compared one by one.
            solution: Solution::new(Arc::clone(mesh), state, f64::NAN, f64::NAN),
            scalars,
        }
    }

    fn scalar(&self, name: &str) -> Option<f64> {
        let found = self.scalars.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| *value)
    }
}

/// A measured error with its uncertainty: the true one is expected between |error| ∓ uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value of the run less that of the finer one; of fields the size of that.
    pub error: f64,
    /// Of the error: what the finer run itself misses, with the safety factor.
    pub uncertainty: f64,
}

impl Measured {
    /// The least and the greatest size of the error.
    pub fn bounds(self) -> [f64; 2] {
        let size = self.error.abs();
        [(size - self.uncertainty).max(0.0), size + self.uncertainty]
    }
}

/// The measured errors at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorRow {
    /// The time.
    pub t: f64,
    /// The observed order; `None` where the distances have none.
    pub order: Option<f64>,
    /// ‖φ − φ*‖ in L2.
    pub phase: Measured,
    /// The mean distance of the membranes; `None` without a membrane.
    pub membrane: Option<Measured>,
    /// Energies, length and waist: name, value of the run, error.
    pub scalars: Vec<(String, f64, Measured)>,
}

impl ErrorRow {
    /// Compares a run with the one between and with the finer one, all at the time t. `None` where the fields cannot be
    /// compared: they have no common domain, or a value is not finite.
    pub fn new(
        t: f64,
        factor: f64,
        run: &Sample,
        between: &Sample,
        finer: &Sample,
    ) -> Option<Self> {
        let distances = |one: &Sample, other: &Sample| {
            // No difference is none, not an unknown one.
            let size = |error: Option<super::ErrorSize>| error.map_or(0.0, super::ErrorSize::get);
            let is_finite = one.solution.is_finite() && other.solution.is_finite();
            let errors = one.solution.errors(&other.solution);
            is_finite.then_some((
                size(errors.phase),
                errors.membrane.map(super::ErrorSize::get),
            ))
        };
        let (to_between, _) = distances(run, between)?;
        let (phase, membrane) = distances(run, finer)?;
        let (rest, rest_of_membrane) = distances(between, finer)?;
        let ratio = factor.sqrt();
        let order = Some((to_between / rest).ln() / ratio.ln()).filter(|order| order.is_finite());
        let is_sane = order.is_some_and(is_sane);
        let used = order
            .unwrap_or(LEAST_ORDER)
            .clamp(LEAST_ORDER, FORMAL_ORDER);
        let safety = SAFETY[usize::from(!is_sane)];
        let left = safety / (ratio.powf(used) - 1.0);
        let measured = |error: f64, rest: f64| Measured {
            error,
            uncertainty: left * rest,
        };
        // A scalar may happen to be the same in two runs: the finer one misses at least the part of it that it
        // misses of φ.
        let part = if phase > 0.0 { rest / phase } else { 0.0 };
        let scalars = run.scalars.iter().filter_map(|(name, value)| {
            let (between, finer) = (between.scalar(name)?, finer.scalar(name)?);
            let error = value - finer;
            let rest = (between - finer).abs().max(part * error.abs());
            Some((name.clone(), *value, measured(error, rest)))
        });
        Some(Self {
            t,
            order,
            phase: measured(phase, rest),
            membrane: membrane
                .zip(rest_of_membrane)
                .map(|(error, rest)| measured(error, rest)),
            scalars: scalars.collect(),
        })
    }

    /// Whether the observed order is near the formal one: else the uncertainty has the larger safety factor.
    pub fn has_sane_order(&self) -> bool {
        self.order.is_some_and(is_sane)
    }
}

fn is_sane(order: f64) -> bool {
    (SANE[0]..=SANE[1]).contains(&order)
}

/// A measured error, as people read it: with its uncertainty, or how large it is at most where that is larger.
impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [_, most] = self.bounds();
        match self.uncertainty <= self.error.abs() {
            true => write!(f, "{:.1e} ± {:.0e}", self.error.abs(), self.uncertainty),
            false => write!(f, "at most {most:.1e}"),
        }
    }
}

/// The errors of a run as a CSV table, a row a time. Of each quantity: its error, and the uncertainty of that; of a scalar
/// its value too.
pub fn error_table(rows: &[ErrorRow]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (name, ..) in rows.iter().flat_map(|row| &row.scalars) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let mut table =
        "t,observed_order,phi_error,phi_uncertainty,membrane_error,membrane_uncertainty".to_owned();
    for name in &names {
        table.push_str(&format!(",{name},{name}_error,{name}_uncertainty"));
    }
    table.push('\n');
    for row in rows {
        let mut cells = vec![Some(row.t), row.order];
        let pair = |measured: Option<Measured>| {
            [
                measured.map(|it| it.error),
                measured.map(|it| it.uncertainty),
            ]
        };
        cells.extend(pair(Some(row.phase)));
        cells.extend(pair(row.membrane));
        for name in &names {
            let found = row.scalars.iter().find(|(known, ..)| known == name);
            cells.push(found.map(|(_, value, _)| *value));
            cells.extend(pair(found.map(|(.., measured)| *measured)));
        }
        push_cells(&mut table, cells);
        table.push('\n');
    }
    table
}

/// The errors of φ and of these scalars for people, a row a time: sizes with their uncertainties, those of scalars in per
/// cent of the value.
pub fn error_words(rows: &[ErrorRow], scalars: &[&str]) -> String {
    let first = ["t", "order", "phi in L2"].into_iter();
    let heading = first.chain(scalars.iter().copied()).map(str::to_owned);
    let mut lines = vec![heading.collect()];
    for row in rows {
        let order = row
            .order
            .map_or("-".to_owned(), |order| format!("{order:.1}"));
        let is_off = if row.has_sane_order() { "" } else { " off" };
        let mut line = vec![
            ShortNumber(row.t).to_string(),
            order + is_off,
            row.phase.to_string(),
        ];
        line.extend(scalars.iter().map(|name| {
            let found = row.scalars.iter().find(|(known, ..)| known == name);
            found.map_or("-".to_owned(), |(_, value, measured)| {
                percent(*measured, *value)
            })
        }));
        lines.push(line);
    }
    aligned(&lines)
}

/// All errors at one time for people, a row a quantity.
pub fn quantity_words(row: &ErrorRow) -> String {
    let mut lines = vec![vec![
        "phi in L2".to_owned(),
        String::new(),
        row.phase.to_string(),
    ]];
    if let Some(membrane) = row.membrane {
        lines.push(vec![
            "membrane".to_owned(),
            String::new(),
            membrane.to_string(),
        ]);
    }
    for (name, value, measured) in &row.scalars {
        lines.push(vec![
            name.clone(),
            significant(*value, 5),
            percent(*measured, *value),
        ]);
    }
    aligned(&lines)
}

/// Columns below each other.
fn aligned(lines: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = lines.iter().map(|line| line[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths);
        let cells: Vec<String> = cells
            .map(|(cell, width)| format!("{cell:width$}"))
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// An error in per cent of a value, with its sign where that is certain.
fn percent(measured: Measured, value: f64) -> String {
    let [error, uncertainty] =
        [measured.error, measured.uncertainty].map(|it| 1e2 * it / value.abs());
    match uncertainty <= error.abs() {
        true => format!("{error:+.2} ± {uncertainty:.2} %"),
        false => format!("at most {:.2} %", error.abs() + uncertainty),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run whose φ and energy miss x and 10 by these sizes.
    fn sample(missed: f64) -> Sample {
        let mesh = Arc::new(Mesh::structured(8, 0.0, 1).expect("a mesh"));
        let phi = |x: f64| 2.0 * x - 1.0 + missed * (1.0 + x);
        let state = State {
            phi: mesh.nodes().iter().map(|node| phi(node.x)).collect(),
            omega: Vec::new(),
            mu: Vec::new(),
            director: None,
        };
        let scalars = vec![("E_total".to_owned(), 10.0 - 3.0 * missed)];
        Sample::with(&mesh, &state, scalars)
    }

    /// Runs with edges h, h/√f and h/f and errors of this order.
    fn row(factor: f64, order: f64) -> ErrorRow {
        let error = |factor: f64| 1e-2 * factor.powf(-order);
        let [run, between, finer] = [1.0, factor.sqrt(), factor].map(|it| sample(error(it)));
        ErrorRow::new(1e-3, factor, &run, &between, &finer).expect("one domain")
    }

    /// ‖missed·(1 + x)‖ = missed·√(7/3).
    const TRUE_ERROR: f64 = 1.527_525_231_651_947 * 1e-2;

    #[test]
    fn the_order_is_observed_and_the_truth_is_within_the_uncertainty() {
        for factor in [1.5, 2.0, 3.0] {
            for order in [0.7, 1.2, 1.6, 2.0, 2.4, 3.0, 5.0] {
                let row = row(factor, order);
                let observed = row.order.expect("an order");
                assert!((observed - order).abs() < 1e-3, "{observed} {order}");
                assert_eq!(row.has_sane_order(), (1.0..=4.0).contains(&order));
                let [least, most] = row.phase.bounds();
                assert!(
                    least < TRUE_ERROR && TRUE_ERROR < most,
                    "{factor} {order}: {least} {most}"
                );
                let (name, value, energy) = &row.scalars[0];
                assert_eq!((name.as_str(), *value), ("E_total", 10.0 - 3e-2));
                assert!(energy.error < 0.0, "the run's energy is too small");
                let [least, most] = energy.bounds();
                assert!(least < 3e-2 && 3e-2 < most, "{least} {most}");
            }
        }
        // The uncertainty is worth something.
        let row = row(3.0, 2.0);
        assert!(row.phase.uncertainty < 0.2 * TRUE_ERROR);
    }

    #[test]
    fn a_wrong_factor_shows_in_the_order() {
        let [run, between, finer] = [1e-2, 5e-3, 2.5e-3].map(sample);
        let order = |factor: f64| {
            let row = ErrorRow::new(1e-3, factor, &run, &between, &finer);
            row.and_then(|row| row.order).expect("an order")
        };
        assert!((order(2.0) - 2.0).abs() < 1e-3);
        assert!(order(4.0) < 1.01);
    }

    #[test]
    fn a_scalar_that_happens_to_agree_is_no_more_certain_than_the_field() {
        let [run, mut between, finer] = [1e-2, 5e-3, 2.5e-3].map(sample);
        between.scalars.clone_from(&finer.scalars);
        let row = ErrorRow::new(1e-3, 2.0, &run, &between, &finer).expect("one domain");
        let (_, _, energy) = &row.scalars[0];
        let part = energy.uncertainty / energy.error.abs();
        assert!(part > 0.2, "{part}");
    }

    #[test]
    fn what_is_no_number_is_not_compared() {
        let [run, between, finer] = [1e-2, 5e-3, f64::NAN].map(sample);
        assert_eq!(ErrorRow::new(1e-3, 2.0, &run, &between, &finer), None);
        // Three times the same: no order, and no error.
        let same = [0.0; 3].map(sample);
        let row = ErrorRow::new(1e-3, 2.0, &same[0], &same[1], &same[2]).expect("one domain");
        assert_eq!(
            (row.order, row.phase.error, row.phase.uncertainty),
            (None, 0.0, 0.0)
        );
    }

    #[test]
    fn the_table_has_a_row_a_time_and_three_columns_a_scalar() {
        let table = error_table(&[row(2.0, 2.0), row(2.0, 5.0)]);
        let lines: Vec<Vec<&str>> = table
            .lines()
            .map(|line| line.split(',').collect())
            .collect();
        assert_eq!(lines[0][..3], ["t", "observed_order", "phi_error"]);
        assert_eq!(
            lines[0][6..],
            ["E_total", "E_total_error", "E_total_uncertainty"]
        );
        assert!(
            lines.len() == 3 && lines.iter().all(|line| line.len() == 9),
            "{table}"
        );
        assert_eq!(lines[1][6].parse(), Ok(9.97));
        let words = error_words(&[row(2.0, 2.0), row(2.0, 5.0)], &["E_total", "waist"]);
        assert!(
            words.contains("2.0 ") && words.contains("5.0 off"),
            "{words}"
        );
    }
}
