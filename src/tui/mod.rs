//! The terminal app.

mod app;
pub mod history;
pub mod keys;
pub mod message;
pub mod pace;
pub mod panel;
pub mod past;
pub mod reins;
pub mod series;
pub mod state;
pub mod theme;
pub mod update;
