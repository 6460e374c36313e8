//! What the command line changes in a scene.

use super::numbers;
use super::shell::settings;
use clap_complete::ArgValueCompleter;

/// Values that take the place of a scene's own.
#[derive(Debug, clap::Args)]
pub(super) struct Overrides {
    /// Override a value of the scene, such as anchoring.kind=parallel
    #[arg(long, value_name = "KEY=VALUE", add = ArgValueCompleter::new(settings))]
    set: Vec<String>,

    /// Choose mesh and steps for about this error of φ at the end, in L2, such as 1e-2; in place of those of the scene
    #[arg(long, value_name = "E", value_parser = numbers::accuracy, allow_negative_numbers = true)]
    pub(super) accuracy: Option<f64>,
}

impl Overrides {
    /// All of them as `KEY=VALUE`.
    pub(super) fn all(&self) -> Vec<String> {
        let accuracy = self.accuracy.map(|error| format!("accuracy={error:e}"));
        self.set.iter().cloned().chain(accuracy).collect()
    }
}
