//! The terminal app.

pub mod message;
pub mod panel;
pub mod past;
pub mod series;
pub mod state;
pub mod theme;
pub mod update;
