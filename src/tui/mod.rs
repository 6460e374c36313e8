//! The terminal app.

mod app;
pub mod canvas;
pub mod colour_map;
pub mod curve;
mod editing;
mod farewell;
pub mod figures;
pub mod glyphs;
pub mod history;
mod incoming;
mod input;
mod job_control;
pub mod keys;
pub mod layout;
pub mod message;
pub mod numbers;
mod opening;
mod output;
pub mod pace;
mod pacing;
pub mod panel;
pub mod past;
mod pricing;
pub mod reins;
pub mod sampled;
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
pub use session::{AppError, Options, run};
