//! Sweeps: many runs of one scene with other values, by a [`Plan`].
//!
//! A [`Sweep`] is a plan whose points were all checked; [`SweepFolder`] is where it is run, by one process or by
//! many: each takes the [`PointLock`] of a point before it touches its run. [`Table`] is what came out.

mod error;
mod folder;
mod lock;
mod measure;
mod outline;
mod plan;
mod points;
mod predict;
mod table;
#[cfg(test)]
mod tests;

pub use error::{SweepError, Values};
pub use folder::{Damage, PointState, Sweep, SweepFolder};
pub use lock::{Holder, PointLock, Taken};
pub use outline::{last_fields, last_outline};
pub use plan::{Plan, Spacing};
pub use points::{Needs, Point};
pub use predict::predict;
pub use table::{Table, plain};
