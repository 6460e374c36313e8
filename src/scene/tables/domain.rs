//! `[domain]`.

use super::Rules;
use crate::scene::parameter::choice;

table! {
    /// The domain Ω: the unit square, or the polygon that a mesh from a file covers.
    pub struct Domain {
        /// What Ω stands for: itself, or the half-plane (r, z) = (x, y) that is rotated about the axis x = 0.
        geometry: Geometry = Geometry::Planar;
        /// What holds for φ at ∂Ω.
        boundary: Boundary = Boundary::Natural;
    }
}

impl Rules for Domain {}

choice! {
    /// What the domain stands for.
    pub enum Geometry {
        /// The plane: an integral over Ω is one of dx dy.
        Planar = "planar",
        /// A body of rotation: an integral over Ω is one of 2πr dr dz, with r = x and z = y.
        Axisymmetric = "axisymmetric",
    }
}

choice! {
    /// The condition on φ at ∂Ω.
    pub enum Boundary {
        /// ∇φ·n = ∇μ·n = 0, as the weak form (3.16) has it.
        Natural = "natural",
        /// φ = −1 on ∂Ω, as (2.13) states.
        Clamped = "clamped",
    }
}
