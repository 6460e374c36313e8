//! What to simulate: TOML ⇄ [`Scene`], presets, and every check of a value.
//!
//! ```
//! use vesica::{Scene, find_preset};
//!
//! let text = find_preset("case3")?;
//! let overrides = ["anchoring.kind=parallel".to_owned()];
//! let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
//! let scene = Scene::parse(text, "preset case3", &overrides, &mut no_files)?;
//! assert_eq!(scene.time.end, 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accuracy;
mod change;
mod document;
mod error;
mod expression;
mod initial_director;
mod mesh_file;
mod mesh_size;
mod nodal_file;
mod outline;
mod overrides;
mod parameter;
mod parse;
mod presets;
mod reader;
mod scalar_field;
mod significant;
mod suggest;
mod tables;
#[cfg(test)]
mod tests;
mod timetable;
mod warning;
mod write;

pub(crate) use accuracy::LONGEST_OVER_WIDTH;
pub use change::{Assignment, Change};
pub(crate) use document::{Value as TomlValue, read as read_document};
pub use error::{Problem, SceneError};
pub use expression::Expression;
pub use initial_director::{initial_director, random_phase};
pub use mesh_file::{Triangulation, write_mesh};
pub use mesh_size::MeshSize;
pub use nodal_file::{NodalKey, NodalValues};
pub use outline::{OutlineDistance, phase_profile, union_distance, wall_distance};
pub use parameter::ParameterValue;
pub use presets::{UnknownPreset, find_preset, preset, preset_description, preset_names};
pub(crate) use reader::{FINITE, Field as TomlField, Reader as TomlReader};
pub use scalar_field::ScalarField;
pub use significant::significant;
pub(crate) use suggest::nearest;
pub use tables::*;
pub use timetable::Timetable;
pub use warning::{Warning, isoperimetric_power, warnings};

// Named by unit tests only.
#[cfg(test)]
pub(crate) use error::Origin;
#[cfg(test)]
pub(crate) use mesh_file::MeshFile;
#[cfg(test)]
pub(crate) use parameter::{DefaultValue, Parameter};
