//! The terminal app.

mod incoming;
mod input;
mod job_control;
pub mod message;
mod output;
pub mod panel;
pub mod past;
pub mod series;
pub mod state;
mod surface;
mod terminal;
pub mod theme;
pub mod update;
mod watch;
