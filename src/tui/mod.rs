//! The terminal app.

pub mod canvas;
pub mod colour_map;
pub mod curve;
pub mod glyphs;
pub mod layout;
pub mod message;
pub mod numbers;
pub mod panel;
pub mod past;
pub mod sampled;
pub mod series;
pub mod state;
pub mod theme;
pub mod update;
