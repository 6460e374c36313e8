//! The map of a sweep: a grid of small vesicles, from which a run is opened.
//!
//! It has a loop of its own, with the app's terminal: the map is left when a run is opened in the app, and shown again
//! when that is left. A thread follows the folders, so that the map grows while the sweep runs.

mod draw;
mod help;
mod labels;
mod loader;
mod state;

use super::event::AppEvent;
use super::input::Input;
use super::job_control;
use super::message::Message;
use super::session::AppError;
use super::signals::Watch;
use super::state::Ending;
use super::terminal::{self, Terminal};
use super::theme::{ColorTier, Theme};
use crate::study::sweep::SweepFolder;
use loader::Loader;
pub use state::SweepMap;
use state::Wish;
use std::path::PathBuf;
use std::sync::mpsc;

/// How the map was left.
#[derive(Debug)]
pub enum SweepOutcome {
    /// To open the run in a folder.
    Open(PathBuf),
    /// For good.
    Ended(Ending),
}

/// Shows the map on the terminal that the standard input and output are, until it is left; `map` keeps where the
/// cursor is.
///
/// # Errors
/// [`AppError`]; the terminal is as it was before.
pub fn show_sweep(
    folder: &SweepFolder,
    map: &mut SweepMap,
    tier: Option<ColorTier>,
) -> Result<SweepOutcome, AppError> {
    let theme = Theme::detect(tier, |name| std::env::var(name).ok());
    // NO_COLOR is the theme's affair, as in the app.
    crossterm::style::force_color_output(true);
    let (incoming, queue) = mpsc::channel();
    let mut terminal = Terminal::open(incoming.clone()).map_err(AppError::Terminal)?;
    // In this order, so that the terminal is restored after all that use it are gone.
    let _watch = Watch::start(incoming.clone(), terminal.modes()).map_err(AppError::Threads)?;
    let _input = Input::start(incoming.clone()).map_err(AppError::Threads)?;
    let loader = Loader::start(folder.clone(), incoming).map_err(AppError::Threads)?;
    let mut size = terminal::size();
    let mut is_stale = true;
    loop {
        if is_stale && terminal.is_free() {
            terminal.draw(size, |frame| {
                draw::draw(map, folder, &theme, frame.area(), frame.buffer_mut());
            });
            is_stale = false;
        }
        let Ok(event) = queue.recv() else {
            return Ok(SweepOutcome::Ended(Ending::HungUp));
        };
        match event {
            AppEvent::Written(Ok(buffer)) => terminal.written(buffer),
            AppEvent::Written(Err(_)) | AppEvent::Message(Message::HungUp) => {
                return Ok(SweepOutcome::Ended(Ending::HungUp));
            }
            AppEvent::Message(Message::Signal(number)) => {
                return Ok(SweepOutcome::Ended(Ending::Signal(number)));
            }
            AppEvent::Message(Message::Key(key)) => {
                is_stale = true;
                match map.key(key) {
                    Some(Wish::Quit) => return Ok(SweepOutcome::Ended(Ending::Quit)),
                    Some(Wish::Stop) => suspend(map, &terminal)?,
                    Some(Wish::Open(row)) => {
                        let run = folder.run(&folder.points()[row]);
                        if run.join("scene.toml").is_file() {
                            return Ok(SweepOutcome::Open(run));
                        }
                        map.remark = Some("this point has no run yet".to_owned());
                    }
                    None => {}
                }
            }
            // The loader has something.
            AppEvent::Message(Message::Tick) => {
                is_stale |= loader.take(map);
            }
            AppEvent::SizeChanged => {
                size = terminal::size();
                is_stale = true;
            }
            AppEvent::Stop => suspend(map, &terminal)?,
            AppEvent::Continued => {
                if terminal.take_back().is_err() {
                    return Ok(SweepOutcome::Ended(Ending::HungUp));
                }
                size = terminal::size();
                is_stale = true;
            }
            AppEvent::Crashed(words) => return Err(AppError::Crashed(words)),
            AppEvent::Message(_) | AppEvent::Pasted(_) | AppEvent::Edited(_) => {}
        }
    }
}

/// Stops the process until a shell continues it.
fn suspend(map: &mut SweepMap, terminal: &Terminal) -> Result<(), AppError> {
    if !job_control::can_stop() {
        map.remark = Some("cannot stop here: there is no shell that would continue it".to_owned());
        return Ok(());
    }
    terminal.give_away();
    job_control::stop().map_err(AppError::Terminal)
}
