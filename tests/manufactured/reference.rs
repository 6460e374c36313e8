//! The committed errors: `errors.csv` beside this file. Written again, lines of runs that are not
//! made any more stay until they are deleted by hand.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Mutex;

use super::study::{Errors, FIELDS, Run};

/// By how much an error may differ from the committed one, relative.
pub const MARGIN: f64 = 0.01;

/// If this environment variable is set, errors are written instead of compared.
const REWRITE: &str = "VESICA_WRITE_ERRORS";

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/manufactured/errors.csv");

/// What a line is about.
const KEYS: [&str; 6] = ["refined", "problem", "quadrature", "mesh", "cells", "steps"];

/// The columns of [`KEYS`], numbers as numbers so that lines are sorted by them.
type Key = ([String; 4], [usize; 2]);

type Table = BTreeMap<Key, Errors>;

/// What errors are measured against: they mean different things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refined {
    /// The exact solution, while h and Δt ∝ h² fall.
    Space,
    /// The limit Δt → 0 on the same mesh, while Δt falls.
    Time,
}

fn key(refined: Refined, run: Run) -> Key {
    let words = [
        format!("{refined:?}").to_lowercase(),
        format!("{:?}", run.problem).to_lowercase(),
        run.quadrature.to_owned(),
        run.mesh.name().to_owned(),
    ];
    (words, [run.cells, run.steps])
}

fn parse(text: &str) -> Table {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [
            refined,
            problem,
            quadrature,
            mesh,
            cells,
            steps,
            errors @ ..,
        ] = &cells[..]
        else {
            panic!("too few columns in errors.csv: {line}");
        };
        let words = [refined, problem, quadrature, mesh].map(|word| (*word).to_owned());
        let counts = [cells, steps].map(|count| count.parse().expect("a count"));
        let errors: Vec<Option<f64>> = errors
            .iter()
            .map(|cell| (!cell.is_empty()).then(|| cell.parse().expect("an error")))
            .collect();
        let errors = errors.try_into().expect("an error for each field");
        ((words, counts), errors)
    };
    lines.map(row).collect()
}

fn print(table: &Table) -> String {
    let mut text = String::from(
        "# L2 errors against manufactured solutions; see main.rs. To write them anew:\n\
         #     VESICA_WRITE_ERRORS=1 cargo test --test numerics manufactured\n",
    );
    text.push_str(&[&KEYS[..], &FIELDS[..]].concat().join(","));
    text.push('\n');
    for ((words, [cells, steps]), errors) in table {
        write!(text, "{},{cells},{steps}", words.join(",")).expect("a string grows");
        for error in errors {
            let cell = error.map_or(String::new(), |error| format!("{error:.4e}"));
            write!(text, ",{cell}").expect("a string grows");
        }
        text.push('\n');
    }
    text
}

/// The largest relative deviation of the errors from the committed ones.
pub fn deviation(refined: Refined, run: Run, errors: &Errors) -> f64 {
    let committed = parse(include_str!("errors.csv"));
    let references = committed
        .get(&key(refined, run))
        .unwrap_or_else(|| panic!("errors.csv has no line for {refined:?}, {run:?}"));
    let pairs = FIELDS.iter().zip(errors.iter().zip(references));
    let deviations = pairs.map(|(field, (error, reference))| match (error, reference) {
        (Some(error), Some(reference)) => (error / reference - 1.0).abs(),
        (None, None) => 0.0,
        _ => panic!("{refined:?}, {run:?}: {field} is tested, or in errors.csv, but not both"),
    });
    // A NaN must not pass for a small number.
    deviations.fold(0.0, |largest, deviation| {
        if deviation <= largest {
            largest
        } else {
            deviation
        }
    })
}

/// Demands the committed errors, or commits these.
pub fn check(refined: Refined, run: Run, errors: &Errors) {
    static FILE: Mutex<()> = Mutex::new(());
    if std::env::var_os(REWRITE).is_none() {
        let deviation = deviation(refined, run, errors);
        assert!(
            deviation <= MARGIN,
            "{refined:?}, {run:?}: the errors {errors:?} are not those of errors.csv, by {deviation:.1e}"
        );
        return;
    }
    let _guard = FILE
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut table = parse(&std::fs::read_to_string(PATH).unwrap_or_default());
    table.insert(key(refined, run), *errors);
    std::fs::write(PATH, print(&table)).expect("errors.csv can be written");
}

#[test]
fn the_committed_table_is_what_would_be_written() {
    let committed = include_str!("errors.csv");
    assert_eq!(print(&parse(committed)), committed);
}
