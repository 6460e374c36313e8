//! The terminal app.

mod editing;
mod farewell;
mod incoming;
mod input;
mod job_control;
pub mod message;
mod opening;
mod output;
mod pacing;
pub mod panel;
pub mod past;
pub mod saving;
pub mod series;
mod session;
pub mod state;
mod stub;
mod surface;
mod terminal;
pub mod theme;
pub mod update;
mod watch;

pub use opening::open;
pub use session::{AppError, Ended, Options, run};
