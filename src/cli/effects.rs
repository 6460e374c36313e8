//! `vesica effects SCENE`: what each effect costs.

use super::error::CliError;
use super::numbers;
use super::output;
use super::signals::EndSignal;
use crate::record::load_scene;
use crate::scene::Mesh;
use crate::study::{Cost, Plan, Prices, prices};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::ffi::OsString;
use std::fmt::Write;
use std::io::IsTerminal;

/// Arguments of `vesica effects`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The scene is run as it is and again without each of its effects, all of them in turn, step by step, and \
nothing is saved. `ms` is the median of a step.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file
    scene: OsString,

    /// Override a value of the scene, such as solver.quadrature=lumped
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Steps that are timed, after ten others
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    steps: u64,
}

/// Measures the scene and prints the table.
pub(super) fn effects(arguments: &Arguments) -> Result<(), CliError> {
    let scene = load_scene(&arguments.scene, &arguments.set)?.scene;
    let plan = Plan {
        steps: arguments.steps,
        ..Plan::default()
    };
    let signal = EndSignal::listen()?;
    let target = if std::io::stderr().is_terminal() {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(None, target);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} steps, {eta} left") {
        bar.set_style(style);
    }
    let mut ended = None;
    let found = prices(&scene, plan, &mut |progress| {
        bar.set_length(progress.of);
        bar.set_position(progress.done);
        ended = signal.received();
        ended.is_none()
    });
    bar.finish_and_clear();
    let found = found.map_err(CliError::Study)?;
    match (found, ended) {
        (Some(prices), _) => {
            let Mesh::Structured { cells, .. } = scene.mesh;
            let Plan { warm_up, steps } = plan;
            output::line(format_args!(
                "{}: {cells} × {cells} cells, steps {} to {}\n",
                scene.name,
                warm_up + 1,
                warm_up + steps
            ))?;
            output::print(&table(&prices))
        }
        (None, Some(signal)) => Err(CliError::StudyEnded {
            signal: signal.name,
            number: signal.number,
        }),
        (None, None) => Ok(()),
    }
}

/// The table: the scene, what it is without each effect, and what the effect therefore costs.
fn table(prices: &Prices) -> String {
    let header = [
        "effect", "energy", "ms", "share", "Newton", "Krylov", "director", "MB",
    ];
    let mut rows = vec![header.map(str::to_owned)];
    rows.push(row("all", Some(prices.total_energy), prices.whole, None));
    rows.push(row(
        "bending alone",
        Some(prices.bending),
        prices.alone,
        Some(prices.alone.step.as_secs_f64() / prices.whole.step.as_secs_f64()),
    ));
    for price in &prices.effects {
        let label = match &price.with_it[..] {
            [] => format!("without {}", price.effect),
            others => format!("without {} ({})", price.effect, others.join(", ")),
        };
        let saved = 1.0 - price.without.step.as_secs_f64() / prices.whole.step.as_secs_f64();
        rows.push(row(&label, price.energy, price.without, Some(saved)));
    }
    let mut widths = [0; 8];
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
                _ => write!(text, "  {cell:>width$}"),
            };
        }
        text.push('\n');
    }
    text.push_str(
        "\nenergy: of the effect, weighted as in E_total. share: of a step's time, by what is saved\n\
         without the effect. Newton, Krylov, director: iterations a step. MB: memory of the run.\n",
    );
    text
}

fn row(label: &str, energy: Option<f64>, cost: Cost, share: Option<f64>) -> [String; 8] {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    [
        label.to_owned(),
        or_dash(energy.map(|energy| format!("{energy:.4}"))),
        format!("{:.2}", 1e3 * cost.step.as_secs_f64()),
        or_dash(share.map(|share| format!("{:.0} %", 100.0 * share))),
        format!("{:.1}", cost.newton),
        format!("{:.1}", cost.krylov),
        format!("{:.1}", cost.director),
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
    fn the_table_says_what_is_saved() {
        let cost = |ms, director| Cost {
            step: Duration::from_millis(ms),
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
        };
        let text = table(&prices);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[1].starts_with("all "), "{text}");
        assert!(lines[2].contains(" 50 %"), "{text}");
        assert!(
            lines[3].starts_with("without nematic (anchoring)") && lines[3].contains(" 25 %"),
            "{text}"
        );
        let width = lines[0].chars().count();
        assert!(
            lines[..4].iter().all(|line| line.chars().count() == width),
            "{text}"
        );
    }
}
