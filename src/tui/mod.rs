//! The terminal app.

mod app;
mod editing;
mod farewell;
pub mod history;
mod incoming;
mod input;
mod job_control;
pub mod keys;
pub mod message;
mod opening;
mod output;
pub mod pace;
mod pacing;
pub mod panel;
pub mod past;
pub mod reins;
pub mod saving;
pub mod series;
mod session;
pub mod state;
mod surface;
mod terminal;
pub mod theme;
pub mod update;
mod watch;

pub use opening::{open, open_with_cases};
pub use session::{AppError, Ended, Options, run};
