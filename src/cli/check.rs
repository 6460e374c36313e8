//! `vesica check FILE...`: whether scenes can be run.

use super::error::CliError;
use super::output;
use crate::record::{load_scene, step_count};
use crate::scene::{self, Mesh, Scene};
use std::ffi::OsString;

/// Arguments of `vesica check`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scenes: TOML files or presets
    #[arg(required = true, value_name = "FILE")]
    scenes: Vec<OsString>,

    /// Override a value of each scene, such as time.step=2e-7
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Checks every scene, also after one that is wrong.
pub(super) fn check(arguments: &Arguments) -> Result<(), CliError> {
    let mut wrong = 0;
    for source in &arguments.scenes {
        match load_scene(source, &arguments.set) {
            Ok(loaded) => {
                let source = source.display();
                output::line(format_args!("{source}: ok, {}", describe(&loaded.scene)))?;
                for warning in scene::warnings(&loaded.scene) {
                    output::warning(format_args!("{source}: {warning}"));
                }
            }
            Err(error) => {
                wrong += 1;
                output::error(error);
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

fn describe(scene: &Scene) -> String {
    let Mesh::Structured { cells, .. } = scene.mesh;
    let nodes = (cells + 1) * (cells + 1);
    let steps = step_count(&scene.time);
    format!("{nodes} nodes, {steps} steps")
}
