//! Lines for people and programs: results on the standard output; errors, warnings, notes and progress on the standard
//! error. With `--quiet` only results, errors and what was found damaged are left.
//!
//! `println!` and `eprintln!` panic when the other side of a pipe is gone; these do not.

use super::CliError;
use crate::record::{self, RecordedSummary};
use crate::tui::panel::wrap;
use indicatif::ProgressDrawTarget;
use rustix::termios::tcgetwinsize;
use serde::Serialize;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the process was called with `--quiet`.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Has the process print results, errors and what was found damaged only, from now on.
pub(super) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Where bars are drawn: on the standard error where that is a terminal, unless the process is quiet.
pub(super) fn progress_target() -> ProgressDrawTarget {
    match is_quiet() {
        true => ProgressDrawTarget::hidden(),
        // Hidden as well where the standard error is not a terminal.
        false => ProgressDrawTarget::stderr(),
    }
}

/// Prints text on the standard output as it is. A reader who has seen enough (`| head`) is no
/// error.
///
/// # Errors
/// [`CliError::Output`], such as a full disk.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut output = io::stdout().lock();
    match output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}

/// Prints a line on the standard output.
///
/// # Errors
/// Those of [`print`].
pub(super) fn line(text: impl Display) -> Result<(), CliError> {
    print(&format!("{text}\n"))
}

/// Prints a value on the standard output as JSON.
///
/// # Errors
/// Those of [`print`].
pub(super) fn json(value: &impl Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value);
    line(text.map_err(|error| CliError::Output(error.into()))?)
}

/// Prints on the standard output what became of a command whose result is in files, unless the process is quiet.
///
/// # Errors
/// Those of [`print`].
pub(super) fn summary(text: impl Display) -> Result<(), CliError> {
    match is_quiet() {
        true => Ok(()),
        false => line(text),
    }
}

/// Tells an error on the standard error.
pub(super) fn error(error: impl Display) {
    tell(format_args!("error: {error}"));
}

/// Tells a warning on the standard error, unless the process is quiet.
pub(super) fn warning(warning: impl Display) {
    note(format_args!("warning: {warning}"));
}

/// Tells what in a run's folder is not as the run has left it.
pub(super) fn doubts(folder: &Path, summary: &RecordedSummary) {
    for doubt in record::doubts(folder, summary) {
        damage(format_args!("{}: {doubt}", folder.display()));
    }
}

/// Tells on the standard error that a file was found damaged, also where the process is quiet: something was lost.
pub(super) fn damage(problem: impl Display) {
    tell(format_args!("warning: {problem}"));
}

/// Tells what the program does on the standard error, unless the process is quiet.
pub(super) fn note(text: impl Display) {
    if !is_quiet() {
        tell(text);
    }
}

/// Prints a line on the standard error, in a terminal broken between words.
pub(super) fn tell(text: impl Display) {
    let mut text = text.to_string();
    let mut output = io::stderr().lock();
    if output.is_terminal()
        && let Ok(size) = tcgetwinsize(&output)
        && size.ws_col > 0
    {
        text = wrap(&text, usize::from(size.ws_col)).join("\n");
    }
    // If it is closed, there is nobody to tell.
    let _ = output.write_all(format!("{text}\n").as_bytes());
}
