//! vesica: a vesicle (a closed membrane) with a nematic liquid crystal inside, simulated by the
//! unconditionally energy-stable P1 finite-element scheme of "Nematic order on a deformable
//! vesicle with anchoring effects: phase field modelling and an unconditionally energy-stable
//! scheme" (Results in Applied Mathematics, 2020, doi 10.1016/j.rinam.2020.100102), called
//! *the paper* throughout. Equation numbers are the paper's; all quantities are dimensionless.

pub mod cli;
pub mod fem;
pub mod figure;
pub mod linalg;
pub mod physics;
pub mod record;
pub mod scene;
pub mod scheme;
mod signals;
pub mod simulation;
pub mod study;
pub mod tui;

/// Counts what each thread holds, as in the program, for the tests of what is needed.
#[cfg(test)]
#[global_allocator]
static ALLOCATOR: study::CountingAllocator = study::CountingAllocator;
