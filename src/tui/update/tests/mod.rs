//! The app without a terminal and without threads: small scripts of what happens to it.

mod gallery;
mod measuring;
mod overlays;
mod pacing;
mod random_walk;
mod real_workers;
mod rig;
mod runs;
mod saving;
mod view;
