//! The numerics: the scheme against its energy law, against theory, against another program, and in hard cases.
//! One binary, so that both cores are busy until its end.

#[path = "../common/mod.rs"]
mod common;

mod adaptive;
mod combinations;
mod energy_law;
mod freedericksz;
#[path = "../hard_cases/mod.rs"]
mod hard_cases;
mod limits;
#[path = "../manufactured/mod.rs"]
mod manufactured;
mod paths;
mod quick;
mod random_scenes;
mod reference;
mod rest;
mod secant;
mod symmetry;
mod threads;
mod unstructured;
#[path = "../wrong_effects/mod.rs"]
mod wrong_effects;
