//! The terminal app.

pub mod message;
pub mod past;
pub mod series;
pub mod state;
