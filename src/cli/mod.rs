//! The command line: one file a subcommand.
//!
//! Exit status: 0 done; 1 the run failed, or a check did not come to an end; 2 the arguments or the scene are wrong; 75 a
//! run, a sweep or a task of one was ended by a signal, and is saved and to be started again; 128 + n something else was
//! ended by signal n (130 for Ctrl-C, as shells have it).

mod accuracy;
mod allocator;
mod app;
mod check;
mod effects;
mod error;
mod export;
mod figures;
mod measure_error;
mod numbers;
mod one_of_many;
mod output;
mod overrides;
mod picture_size;
mod presets;
mod progress;
mod run;
mod scales;
mod set_up;
mod shape;
mod shell;
mod signals;
mod sweep;
mod verify;

use crate::scene::preset;
use clap::{CommandFactory, Parser, Subcommand};
use error::CliError;
use std::env;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

/// A vesicle with nematic order inside, simulated by an unconditionally energy-stable scheme.
#[derive(Debug, Parser)]
#[command(
    name = "vesica",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "\
SCENE is a preset's name (see `vesica presets`), a TOML file, or the folder of a run or of a sweep; without a command it \
is opened in the terminal app."
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,

    #[command(flatten)]
    app: app::Arguments,

    /// Of a command: print nothing but its result and errors; no progress, notes and warnings
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a scene and record it in a folder
    Run(run::Arguments),
    /// Draw the figures of a report
    Figures(figures::Arguments),
    /// Tell what each effect of a scene costs
    Effects(effects::Arguments),
    /// List the built-in scenes
    Presets,
    /// Print a built-in scene as TOML
    Preset(presets::Arguments),
    /// Check scenes by their first step, without running them
    Check(check::Arguments),
    /// Tell what accuracy costs in time, and which knob to turn
    Accuracy(accuracy::Arguments),
    /// Tell the shape at rest that theory foresees for a scene
    Shape(shape::Arguments),
    /// Simulate a scene many times with other values, here or on a cluster
    Sweep(sweep::Arguments),
    /// Compute a run again and tell whether its numbers are the same
    Verify(verify::Arguments),
    /// Pack a run into one file, with a description for programs and people
    Export(export::Arguments),
    /// Print what a shell needs to complete commands, scenes and keys
    Completions(shell::CompletionArguments),
    /// Print the manual
    Man(shell::ManArguments),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    shell::answer();
    allocator::share_one();
    let (words, is_quiet) = without_leading_quiet(env::args_os().collect());
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(error) => return refuse(&error),
    };
    if arguments.quiet || is_quiet {
        output::be_quiet();
    }
    let result = match arguments.command {
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Figures(arguments)) => figures::figures(&arguments),
        Some(Command::Accuracy(arguments)) => accuracy::accuracy(&arguments),
        Some(Command::Verify(arguments)) => verify::verify(&arguments),
        Some(Command::Export(arguments)) => export::export(&arguments),
        Some(Command::Effects(arguments)) => effects::effects(&arguments),
        Some(Command::Sweep(arguments)) => sweep::sweep(&arguments),
        Some(Command::Completions(arguments)) => shell::completions(&arguments),
        Some(Command::Man(arguments)) => shell::man(&arguments),
        Some(Command::Shape(arguments)) => shape::shape(&arguments),
        Some(Command::Presets) => presets::list(),
        Some(Command::Preset(arguments)) => presets::print(&arguments),
        Some(Command::Check(arguments)) => check::check(&arguments),
        None => {
            let scene = arguments.app.scene.as_deref();
            match scene.and_then(mistaken_command) {
                Some(error) => Err(error),
                None => app::open(arguments.app),
            }
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => end(&error),
    }
}

/// The arguments without `--quiet` where it comes before a command, and whether it did: there clap takes it for an argument
/// of the app, which excludes all commands.
fn without_leading_quiet(mut words: Vec<OsString>) -> (Vec<OsString>, bool) {
    let mut command = Arguments::command();
    let mut is_quiet = false;
    for at in 1.. {
        let flags = words.iter().skip(at).take_while(|word| is_quiet_flag(word));
        let flags = flags.count();
        let word = words.get(at + flags);
        let Some(inner) = word.and_then(|word| command.find_subcommand(word)) else {
            break;
        };
        command = inner.clone();
        words.drain(at..at + flags);
        is_quiet |= flags > 0;
    }
    (words, is_quiet)
}

fn is_quiet_flag(word: &OsStr) -> bool {
    word == "-q" || word == "--quiet"
}

fn end(error: &CliError) -> ExitCode {
    error.tell();
    ExitCode::from(error.exit_status())
}

/// Ends for arguments that cannot be parsed, or that ask for help or the version.
fn refuse(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // If stdout is closed, there is nobody to tell.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    // A misspelt command passes for the app's SCENE, and the blame falls on what follows it.
    let mut words = env::args_os().skip(1);
    let word = words.find(|word| !is_quiet_flag(word));
    if let Some(mistaken) = word.as_deref().and_then(mistaken_command) {
        return end(&mistaken);
    }
    let _ = error.print();
    ExitCode::from(CliError::USAGE)
}

/// The error for a word that is not a command, nor anything else that a first argument may be.
fn mistaken_command(argument: &OsStr) -> Option<CliError> {
    let word = argument.to_str()?;
    let program = Arguments::command();
    let is_word = word.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
    let is_known = word.starts_with('-')
        || program.find_subcommand(word).is_some()
        || preset(word).is_some()
        || Path::new(word).exists();
    if !is_word || is_known {
        return None;
    }
    let commands: Vec<&str> = program
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    Some(CliError::NoCommand {
        word: word.to_owned(),
        commands: commands.join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn quiet_may_come_before_a_command() {
        for (given, left, is_quiet) in [
            ("vesica -q run case3", "vesica run case3", true),
            ("vesica run -q case3", "vesica run -q case3", false),
            (
                "vesica --quiet -q sweep -q table a",
                "vesica sweep table a",
                true,
            ),
            ("vesica sweep -q plan", "vesica sweep -q plan", false),
            ("vesica -q case3", "vesica -q case3", false),
            ("vesica -q", "vesica -q", false),
        ] {
            let words = given.split(' ').map(OsString::from).collect();
            let expected: Vec<OsString> = left.split(' ').map(OsString::from).collect();
            assert_eq!(
                without_leading_quiet(words),
                (expected, is_quiet),
                "{given}"
            );
        }
    }
}
