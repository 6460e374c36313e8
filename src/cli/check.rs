//! `vesica check FILE...`: whether scenes can be run.

use super::error::CliError;
use super::output;
use super::run::some_step;
use crate::record::{load_scene, step_count};
use crate::scene::{self, Mesh, Scene, Warning};
use crate::simulation;
use crate::study::run_price;
use std::ffi::{OsStr, OsString};

/// The initial state, which tells most, is computed on meshes of up to so many nodes: within about
/// a second.
const MOST_NODES: usize = 60_000;

/// Arguments of `vesica check`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scenes: TOML files or presets
    #[arg(required = true, value_name = "FILE")]
    scenes: Vec<OsString>,

    /// Override a value of each scene, such as time.step=2e-7
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Do not measure what the run would take
    #[arg(long)]
    quick: bool,
}

/// Checks every scene, also after one that is wrong.
pub(super) fn check(arguments: &Arguments) -> Result<(), CliError> {
    let mut wrong = 0;
    for source in &arguments.scenes {
        let name = source.display();
        match examine(source, &arguments.set) {
            Ok((scene, warnings)) => {
                output::line(format_args!("{name}: ok, {}", describe(&scene)))?;
                for warning in warnings {
                    output::warning(format_args!("{name}: {warning}"));
                }
                if !arguments.quick && nodes(&scene) <= MOST_NODES {
                    // Its first steps may fail where a run divides them: then there is no price.
                    if let Ok(price) = run_price(&scene) {
                        output::line(format_args!("{name}: on this machine {price}"))?;
                    }
                }
            }
            Err(error @ CliError::Load(_)) => {
                wrong += 1;
                output::error(error);
            }
            Err(error) => {
                wrong += 1;
                output::error(format_args!("{name}: {error}"));
            }
        }
    }
    match wrong {
        0 => Ok(()),
        _ => Err(CliError::Check {
            wrong,
            checked: arguments.scenes.len(),
        }),
    }
}

/// Loads a scene and goes as far as a run would before its first step.
fn examine(source: &OsStr, overrides: &[String]) -> Result<(Scene, Vec<Warning>), CliError> {
    let scene = load_scene(source, overrides)?.scene;
    some_step(&scene.time)?;
    simulation::check_memory(&scene).map_err(CliError::SetUp)?;
    let warnings = if nodes(&scene) <= MOST_NODES {
        simulation::examine(&scene).map_err(CliError::SetUp)?
    } else {
        scene::warnings(&scene)
    };
    Ok((scene, warnings))
}

fn nodes(scene: &Scene) -> usize {
    let Mesh::Structured { cells, .. } = scene.mesh;
    (cells + 1) * (cells + 1)
}

fn describe(scene: &Scene) -> String {
    let steps = step_count(&scene.time);
    let nodes = nodes(scene);
    match steps {
        Some(steps) => format!("{nodes} nodes, {steps} steps"),
        None => format!("{nodes} nodes, chosen steps"),
    }
}
