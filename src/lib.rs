//! vesica simulates a vesicle (a closed membrane) with a nematic liquid crystal inside, by the unconditionally
//! energy-stable P1 finite-element scheme of "Nematic order on a deformable vesicle with anchoring effects: phase field
//! modelling and an unconditionally energy-stable scheme" (Results in Applied Mathematics, 2020, doi
//! 10.1016/j.rinam.2020.100102), called *the paper* throughout. Equation numbers are the paper's; all quantities are
//! dimensionless.
//!
//! A run is a [`Scene`] and a [`Simulation`]:
//!
//! ```
//! use vesica::{Scene, Simulation};
//!
//! let text = "mesh.cells = 24\nmembrane.interface_width = 0.04\n[area]\ntarget = 1.1";
//! let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
//! let scene = Scene::parse(text, "my scene", &["time.step=1e-7".to_owned()], &mut no_files)?;
//! let mut simulation = Simulation::new(&scene)?;
//! let start = simulation.report().total_energy;
//! for _ in 0..3 {
//!     let report = simulation.advance()?;
//!     assert!(report.law_residual.abs() <= 1e-8, "the energy law holds in every step");
//! }
//! assert!(simulation.report().total_energy < start);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What stands on this page is the interface: what the examples of the package use, and what that returns. It changes by
//! the rules of semantic versioning. Everything else is private.
//!
//! | for | see |
//! | --- | --- |
//! | a run | [`Scene`], [`find_preset`], [`Simulation`], [`Report`] (`examples/run.rs`) |
//! | its fields | [`State`], [`Mesh`], [`Point`], [`Vector`] |
//! | a picture of it | [`View`], [`Field`], [`FigureOptions`], [`save_view`] (`examples/picture.rs`) |
//! | single steps | [`initial_fields`], [`Scheme`], [`StepReport`] |
//! | an effect of one's own | [`Effect`], [`Patch`], [`PatchFields`], [`PatchStep`] and what it fills in (`examples/own_effect.rs`) |

#![warn(missing_docs)]

// Imports run downward only, in this order.
mod cli;
mod tui;

mod figure;
mod study;

mod record;
mod simulation;

mod scheme;

mod physics;

mod fem;
mod linalg;

mod scene;
mod theory;

mod geometry;

mod signals;

pub use fem::{FemError, Mesh, Patch};
pub use figure::{Field, FigureError, FigureOptions, View, save_view};
pub use geometry::{Point, SymmetricTensor, Vector};
pub use physics::{
    DirectorCoupling, DirectorForm, Effect, Interval, Kept, LedgerTerms, MembraneForce,
    MembraneJacobian, NamedValue, PatchFields, PatchStep, Room,
};
pub use scene::{Iteration, Scene, SceneError, UnknownPreset, find_preset};
pub use scheme::{InitialError, Scheme, State, StepError, StepReport, initial_fields};
pub use simulation::{Report, Simulation, SimulationError};

/// What the program, the benchmarks and the tests in `tests/` use beyond the interface. They are crates of their own, so it
/// must be public; it may change in any version.
#[doc(hidden)]
pub mod internal {
    pub use crate::cli::main;
    pub use crate::study::CountingAllocator;

    pub mod fem {
        pub use crate::fem::{
            Contour, LoadEntries, Locator, MatrixEntries, QuadratureRule, Raster, Space, long_axis,
            ritz_projection,
        };
    }
    pub mod figure {
        pub use crate::figure::{Existing, RunData, Snapshot, save_set};
    }
    pub mod geometry {
        pub use crate::geometry::length;
    }
    pub mod linalg {
        pub use crate::linalg::{ConjugateGradients, LinearOperator, SparseMatrix};
    }
    pub mod physics {
        pub use crate::physics::{
            Anchoring, Area, Bending, DirectorFields, Effects, Field, Nematic, Noise, potentials,
            surface_area,
        };
    }
    pub mod record {
        pub use crate::record::{
            Columns, Ending, Found, IfOccupied, KeptRuns, RecorderBuilder, Resumption, RunFolder,
            Settings, read_fields, read_run,
        };
    }
    pub mod scene {
        pub use crate::scene::{
            AnchoringKind, Boundary, Change, Curve, Expression, Field, Geometry, InitialDirector,
            Nematic, NodalValues, Noise, ScalarField, Shape, TableInfo, TimeScheme, Triangulation,
            preset, preset_names, tables, write_mesh,
        };
    }
    pub mod scheme {
        pub use crate::scheme::{SchemeCheckpoint, bench_support};
    }
    pub mod simulation {
        pub use crate::simulation::{
            Event, EventKind, OutlineMeasure, RunId, RunSnapshot, Schedule, Setting,
            SimulationCheckpoint, StepProgress, Worker, enclosed_area, memory_needed, node_count,
        };
    }
    pub mod theory {
        pub use crate::theory::{Branch, RoundBody, RoundVesicle};
    }
    pub mod tui {
        pub use crate::tui::canvas::Canvas;
        pub use crate::tui::panel::draw;
        pub use crate::tui::state::{App, Run, Screen, Slot, Status};
        pub use crate::tui::theme::{ColorTier, Theme};
    }
}

/// The guide's example of an effect is built with the tests; this one follows it through the program.
#[cfg(test)]
#[path = "../tests/adding_an_effect/mod.rs"]
mod adding_an_effect;

/// Counts what each thread holds, as in the program, for the tests of what is needed.
#[cfg(test)]
#[global_allocator]
static ALLOCATOR: study::CountingAllocator = study::CountingAllocator;
