//! `vesica presets` and `vesica preset NAME`.

use super::error::CliError;
use super::output;
use crate::record::load_scene;
use crate::scene;
use std::ffi::OsString;
use std::fmt::Write;

/// Arguments of `vesica preset`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Its name, one of those that `vesica presets` lists
    name: String,
}

/// Lists the presets: the name and the title of each.
pub(super) fn list() -> Result<(), CliError> {
    let names: Vec<_> = scene::preset_names().collect();
    let width = names.iter().map(|name| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for name in names {
        let scene = load_scene(&OsString::from(name), &[])?.scene;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:width$}  {}", scene.name);
    }
    output::print(&text)
}

/// Prints a preset's TOML, comments and all.
pub(super) fn print(arguments: &Arguments) -> Result<(), CliError> {
    match scene::preset(&arguments.name) {
        Some(text) => output::print(text),
        None => Err(crate::record::unknown_preset(&arguments.name).into()),
    }
}
