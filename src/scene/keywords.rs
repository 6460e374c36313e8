//! The words of a scene's choices, for reading and for writing.

use super::model::{AnchoringKind, Boundary, Iteration, LinearMethod, Projection, Quadrature};

/// A choice's words, each with what it means.
pub(super) type Names<T> = [(&'static str, T)];

pub(super) const BOUNDARIES: &Names<Boundary> = &[
    ("natural", Boundary::Natural),
    ("clamped", Boundary::Clamped),
];

pub(super) const PROJECTIONS: &Names<Projection> = &[
    ("ritz", Projection::Ritz),
    ("l2", Projection::L2),
    ("nodal", Projection::Nodal),
];

pub(super) const ANCHORINGS: &Names<AnchoringKind> = &[
    ("homeotropic", AnchoringKind::Homeotropic),
    ("parallel", AnchoringKind::Parallel),
    ("none", AnchoringKind::None),
];

pub(super) const QUADRATURES: &Names<Quadrature> = &[
    ("consistent", Quadrature::Consistent),
    ("lumped", Quadrature::Lumped),
];

pub(super) const ITERATIONS: &Names<Iteration> =
    &[("newton", Iteration::Newton), ("lagged", Iteration::Lagged)];

pub(super) const LINEAR_METHODS: &Names<LinearMethod> = &[
    ("automatic", LinearMethod::Automatic),
    ("transform", LinearMethod::Transform),
    ("shifted", LinearMethod::Shifted),
    ("factor", LinearMethod::Factor),
];

/// The word that means `value`; every table above is complete (a test of each round trip).
pub(super) fn name_of<T: PartialEq>(names: &Names<T>, value: T) -> &'static str {
    names
        .iter()
        .find(|(_, meant)| *meant == value)
        .map_or("", |(name, _)| name)
}

impl AnchoringKind {
    /// The word for it in a scene.
    pub fn name(self) -> &'static str {
        name_of(ANCHORINGS, self)
    }
}

impl std::fmt::Display for AnchoringKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
