//! The prices of effects as a table for people.

use std::fmt::Write;

use super::{Cost, Prices};

const COLUMNS: usize = 9;
const HEADER: [&str; COLUMNS] = [
    "", "energy", "ms", "saved", "Newton", "Krylov", "CG", "CG ms", "MB",
];
const LEGEND: &str = "\
energy: of the effect, as in E_total. ms: the median of a step.
saved: share of a step's time that is saved without the effect.
Newton, Krylov, CG: iterations a step. CG is of the director, CG ms all
of its substep.
";

/// The table: the scene, the membrane alone, and the scene without one effect after the other.
pub fn prices_table(prices: &Prices) -> String {
    let whole = prices.whole.step.as_secs_f64();
    let share = |cost: &Cost| cost.step.as_secs_f64() / whole;
    let mut rows = vec![
        HEADER.map(str::to_owned),
        row("all effects", Some(prices.total_energy), prices.whole, None),
        row(
            "bending alone",
            Some(prices.bending),
            prices.alone,
            Some(1.0 - share(&prices.alone)),
        ),
    ];
    for price in &prices.effects {
        let mut label = format!("no {}", price.effect);
        for other in &price.with_it {
            let _ = write!(label, ", {other}");
        }
        let saved = 1.0 - share(&price.without);
        rows.push(row(&label, price.energy, price.without, Some(saved)));
    }
    let mut widths = [0; COLUMNS];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    for row in &rows {
        for (column, (cell, width)) in row.iter().zip(widths).enumerate() {
            // Writing to a String cannot fail.
            let _ = match column {
                0 => write!(text, "{cell:width$}"),
                _ => write!(text, " {cell:>width$}"),
            };
        }
        text.push('\n');
    }
    text += "\n";
    text += LEGEND;
    if let Some(step) = prices.fixed_step {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "The scene's steps are chosen: here all have \u{394}t = {step:e}."
        );
    }
    text
}

fn row(label: &str, energy: Option<f64>, cost: Cost, share: Option<f64>) -> [String; COLUMNS] {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    [
        label.to_owned(),
        or_dash(energy.map(|energy| format!("{energy:.4}"))),
        format!("{:.2}", 1e3 * cost.step.as_secs_f64()),
        or_dash(share.map(|share| format!("{:.0}%", 100.0 * share))),
        format!("{:.1}", cost.newton),
        format!("{:.1}", cost.krylov),
        format!("{:.1}", cost.director),
        format!("{:.2}", 1e3 * cost.substep_1.as_secs_f64()),
        or_dash(
            cost.memory
                .map(|bytes| format!("{:.1}", bytes as f64 / 1e6)),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Price;
    use std::time::Duration;

    #[test]
    fn the_table_says_what_is_saved_and_fits_a_terminal() {
        let cost = |ms, director| Cost {
            step: Duration::from_millis(ms),
            substep_1: Duration::from_millis(2),
            newton: 1.0,
            krylov: 7.5,
            director,
            memory: Some(36_000_000),
        };
        let prices = Prices {
            whole: cost(20, 3.0),
            total_energy: 640.5,
            bending: 40.25,
            alone: cost(10, 0.0),
            effects: vec![Price {
                effect: "nematic",
                energy: None,
                with_it: vec!["anchoring"],
                without: cost(15, 0.0),
            }],
            fixed_step: Some(1e-7),
        };
        let text = prices_table(&prices);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[1].starts_with("all effects "), "{text}");
        assert!(lines[2].contains(" 50%"), "{text}");
        let expected = lines[3].starts_with("no nematic, anchoring ") && lines[3].contains(" 25%");
        assert!(expected, "{text}");
        assert!(text.ends_with("here all have Δt = 1e-7.\n"), "{text}");
        let width = lines[0].chars().count();
        assert!(
            lines[..4].iter().all(|line| line.chars().count() == width),
            "{text}"
        );
        assert!(
            text.lines().all(|line| line.chars().count() <= 72),
            "{text}"
        );
    }
}
