//! The command line: one file a subcommand.
//!
//! Exit status: 0 done; 1 the run failed; 2 the arguments or the scene are wrong; 128 + n the run
//! was ended early, but cleanly, by signal n (130 for Ctrl-C, as shells have it).

mod check;
mod error;
mod output;
mod presets;
mod progress;
mod run;
mod signals;

use clap::{Parser, Subcommand};
use error::CliError;
use std::ffi::OsString;
use std::process::ExitCode;

/// A vesicle with nematic order inside, simulated by an unconditionally energy-stable scheme.
#[derive(Debug, Parser)]
#[command(
    name = "vesica",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "SCENE is a preset's name (see `vesica presets`) or a TOML file."
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,

    /// The scene that the terminal app opens [default: case3]
    scene: Option<OsString>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a scene and record it in a folder
    Run(run::Arguments),
    /// List the built-in scenes
    Presets,
    /// Print a built-in scene as TOML
    Preset(presets::Arguments),
    /// Check scenes without running them
    Check(check::Arguments),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // To stderr, or to stdout for --help and --version; if that is closed, there is
            // nobody to tell.
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::from(CliError::USAGE)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    let result = match arguments.command {
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Presets) => presets::list(),
        Some(Command::Preset(arguments)) => presets::print(&arguments),
        Some(Command::Check(arguments)) => check::check(&arguments),
        None => Err(CliError::NoApp {
            scene: arguments.scene.unwrap_or("case3".into()),
        }),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            error.tell();
            ExitCode::from(error.exit_status())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }
}
