//! `vesica effects SCENE`: what each effect costs.

use super::error::CliError;
use super::numbers;
use super::output;
use super::shell::{scenes, settings};
use super::signals::EndSignal;
use crate::record::load_scene;
use crate::simulation::node_count;
use crate::study::{Plan, prices, prices_table};
use clap_complete::ArgValueCompleter;
use indicatif::{ProgressBar, ProgressStyle};
use std::ffi::OsString;

/// Arguments of `vesica effects`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The scene is run as it is and again without each of its effects, all of them in turn, step by step, and \
nothing is saved. `ms` is the median of a step. Where the steps of the scene are chosen, steps of one length are timed instead.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file
    #[arg(add = ArgValueCompleter::new(scenes))]
    scene: OsString,

    /// Override a value of the scene, such as solver.quadrature=lumped
    #[arg(long, value_name = "KEY=VALUE", add = ArgValueCompleter::new(settings))]
    set: Vec<String>,

    /// Print what was found as JSON
    #[arg(long)]
    json: bool,

    /// Steps before anything is timed; the first of a run are harder than the rest
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = numbers::count,
          allow_negative_numbers = true)]
    after: u64,

    /// Steps that are timed
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    steps: u64,
}

/// Measures the scene and prints the table.
pub(super) fn effects(arguments: &Arguments) -> Result<(), CliError> {
    let scene = load_scene(&arguments.scene, &arguments.set)?.scene;
    let plan = Plan {
        warm_up: arguments.after,
        steps: arguments.steps,
    };
    let signal = EndSignal::listen()?;
    let bar = ProgressBar::with_draw_target(None, output::progress_target());
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
            let mesh = match scene.mesh.cells() {
                Some(cells) => format!("{cells} × {cells} cells"),
                None => format!("about {:.0} nodes", node_count(&scene)),
            };
            if arguments.json {
                return output::json(&prices);
            }
            let Plan { warm_up, steps } = plan;
            output::line(format_args!(
                "{}: {mesh}, steps {} to {}\n",
                scene.name,
                warm_up + 1,
                warm_up + steps
            ))?;
            output::print(&prices_table(&prices))
        }
        (None, Some(signal)) => Err(CliError::StudyEnded {
            signal: signal.name,
            number: signal.number,
        }),
        (None, None) => Ok(()),
    }
}
