//! The terminal app.

mod app;
pub mod canvas;
pub mod colour_map;
pub mod curve;
pub mod glyphs;
pub mod history;
pub mod keys;
pub mod layout;
pub mod message;
pub mod numbers;
pub mod pace;
pub mod panel;
pub mod past;
pub mod reins;
pub mod sampled;
pub mod series;
pub mod state;
pub mod theme;
pub mod update;
