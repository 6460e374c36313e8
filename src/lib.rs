//! vesica simulates a vesicle (a closed membrane) with a nematic liquid crystal inside, by the unconditionally
//! energy-stable P1 finite-element scheme of "Nematic order on a deformable vesicle with anchoring effects: phase field
//! modelling and an unconditionally energy-stable scheme" (Results in Applied Mathematics, 2020, doi
//! 10.1016/j.rinam.2020.100102), called *the paper* throughout. Equation numbers are the paper's; all quantities are
//! dimensionless.
//!
//! A run is a [`scene::Scene`] and a [`simulation::Simulation`]:
//!
//! ```
//! use vesica::scene::Scene;
//! use vesica::simulation::Simulation;
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
//! The interface is what the examples of the package use, of [`scene`], [`simulation`], [`scheme`], [`physics`], [`fem`],
//! [`geometry`] and [`figure`]: it changes by the rules of semantic versioning. The rest is public for the program, its
//! tests and its benchmarks, and may change in any version.
//!
//! Modules import downward only, in this order:
//!
//! | module | what is in it |
//! | --- | --- |
//! | `cli` | the program's subcommands |
//! | `tui` | the terminal app |
//! | [`figure`] | the pictures of a report |
//! | [`study`] | runs about runs: accuracy against time, the cost of each effect, sweeps |
//! | [`record`] | the files that a run leaves and resumes from |
//! | [`simulation`] | a run in time, and its background worker |
//! | [`scheme`] | one time step: the director, the membrane, the energy law |
//! | [`physics`] | the energies: potentials, and one file an effect |
//! | [`fem`] | meshes, P1 elements, quadrature, assembly, projections |
//! | [`linalg`] | sparse matrices and factors, Krylov methods, transforms of a grid |
//! | [`scene`] | what to simulate: TOML, presets, every check of a value |
//! | [`theory`] | the sharp-interface theory: shapes at rest, relaxation |
//! | [`geometry`] | points, vectors and symmetric tensors (nalgebra), segments, distances |

#![warn(missing_docs)]

#[doc(hidden)]
pub mod cli;
pub mod fem;
pub mod figure;
pub mod geometry;
pub mod linalg;
pub mod physics;
pub mod record;
pub mod scene;
pub mod scheme;
mod signals;
pub mod simulation;
pub mod study;
pub mod theory;
#[doc(hidden)]
pub mod tui;

/// The guide's example of an effect is built with the tests; this one follows it through the program.
#[cfg(test)]
#[path = "../tests/adding_an_effect/mod.rs"]
mod adding_an_effect;

/// Counts what each thread holds, as in the program, for the tests of what is needed.
#[cfg(test)]
#[global_allocator]
static ALLOCATOR: study::CountingAllocator = study::CountingAllocator;
