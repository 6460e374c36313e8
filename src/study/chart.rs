//! The work–precision diagram as text.

use super::error_size::ErrorSize;
use super::report::{Point, Study};
use std::fmt::Write;

const COLUMNS: usize = 64;
const ROWS: usize = 18;

/// The logarithm of the error of φ, upward, against the logarithm of the seconds, in characters: a
/// letter for each mesh, a digit for each finished run, a star for the scene's own choice, a cross for a run without result.
pub fn chart(study: &Study) -> String {
    let points: Vec<&Point> = study
        .points
        .iter()
        .filter(|point| point.seconds.is_finite() && point.seconds > 0.0)
        .collect();
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value.log10()), high.max(value.log10())]
        });
        [low.floor(), high.ceil().max(low.floor() + 1.0)]
    };
    let seconds = range(&mut points.iter().map(|point| point.seconds));
    let errors = points.iter().filter_map(|point| point.error());
    let errors = range(&mut errors.map(ErrorSize::get));
    if !seconds.iter().chain(&errors).all(|end| end.is_finite()) {
        return String::new();
    }
    let meshes = study.meshes();
    let runs: Vec<&String> = study
        .points
        .iter()
        .filter_map(|it| it.run.as_ref())
        .collect();
    let place = |value: f64, [low, high]: [f64; 2], count: usize| {
        (((value.log10() - low) / (high - low) * (count - 1) as f64).round() as usize)
            .min(count - 1)
    };
    let mut cells = vec![[' '; COLUMNS]; ROWS];
    for point in points {
        let column = place(point.seconds, seconds, COLUMNS);
        let mesh = meshes
            .iter()
            .position(|cells| *cells == point.cells)
            .unwrap_or(0);
        let letter = match runs.iter().position(|run| Some(*run) == point.run.as_ref()) {
            Some(run) => char::from(b'1' + (run as u8).min(8)),
            None => char::from(b'a' + (mesh as u8).min(25)),
        };
        match point.error() {
            Some(error) => {
                let row = ROWS - 1 - place(error.get(), errors, ROWS);
                cells[row][column] = if point.is_own { '*' } else { letter };
            }
            None => cells[0][column] = 'x',
        }
    }
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(text, "error of φ in L2");
    for (row, line) in cells.iter().enumerate() {
        let exponent = errors[1] - (errors[1] - errors[0]) * row as f64 / (ROWS - 1) as f64;
        let label = if row == 0 || row + 1 == ROWS {
            format!("1e{exponent:<+3.0}")
        } else {
            String::new()
        };
        let line: String = line.iter().collect();
        let _ = writeln!(text, "{label:>6} |{}", line.trim_end());
    }
    let _ = writeln!(text, "       +{}", "-".repeat(COLUMNS));
    let ends = [
        format!("1e{:+.0}", seconds[0]),
        format!("1e{:+.0} s", seconds[1]),
    ];
    let _ = writeln!(
        text,
        "        {}{:>2$}",
        ends[0],
        ends[1],
        COLUMNS - ends[0].len()
    );
    let letters = meshes.iter().enumerate();
    let mut letters: Vec<String> = letters
        .map(|(mesh, cells)| {
            format!(
                "{} {}",
                char::from(b'a' + (mesh as u8).min(25)),
                study.mesh_words(*cells)
            )
        })
        .collect();
    let digits = runs.iter().enumerate();
    letters.extend(digits.map(|(run, name)| format!("{} {name}", run + 1)));
    let _ = writeln!(
        text,
        "        {}   * the scene's own   x no result",
        letters.join("   ")
    );
    text
}
