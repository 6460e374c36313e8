//! `vesica presets` and `vesica preset NAME`.

use super::error::CliError;
use super::output;
use crate::scene::{find_preset, preset_description, preset_names};
use std::fmt::Write;

/// Arguments of `vesica preset`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Its name, one of those that `vesica presets` lists
    name: String,
}

/// Lists the presets: the name of each and a line about it.
pub(super) fn list() -> Result<(), CliError> {
    let width = preset_names().map(str::len).max().unwrap_or(0);
    let mut text = String::new();
    for name in preset_names() {
        let description = preset_description(name).unwrap_or_default();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:width$}  {description}");
    }
    output::print(&text)
}

/// Prints a preset's TOML, comments and all.
pub(super) fn print(arguments: &Arguments) -> Result<(), CliError> {
    output::print(find_preset(&arguments.name)?)
}
