//! `[anchoring]`.

use serde::{Deserialize, Serialize};

use super::Rules;
use crate::scene::error::{Problem, SceneError};
use crate::scene::parameter::Choice;
use crate::scene::reader::{NOT_NEGATIVE, Reader};

table! {
    /// The anchoring of the director at the membrane,
    /// E_anch = λ_anch/2 ∫ (δ1 d·d ∇φ·∇φ + δ2 (d·∇φ)²).
    #[derive(Copy, Serialize, Deserialize)]
    pub struct Anchoring {
        /// The direction that the membrane prefers: across it, along it, or none.
        @tunable kind: AnchoringKind = AnchoringKind::Homeotropic;
        /// λ_anch, the weight of the energy.
        @tunable weight: f64 = 10.1, NOT_NEGATIVE;
    }
}

impl Rules for Anchoring {
    fn needs_director() -> bool {
        true
    }

    fn without_director(&self, _: &'static str, table: &Reader<'_>) -> Result<(), SceneError> {
        if self.kind == AnchoringKind::None {
            return Ok(());
        }
        let problem = Problem::AnchoringWithoutNematic {
            kind: self.kind.name(),
        };
        Err(match table.get("kind") {
            Some(kind) => kind.error(problem),
            None => table.error(problem),
        })
    }
}

/// The direction that the membrane prefers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AnchoringKind {
    /// (δ1, δ2) = (0, 0).
    None,
    /// Along the membrane: (δ1, δ2) = (0, 1).
    Parallel,
    /// Across the membrane: (δ1, δ2) = (1, −1).
    Homeotropic,
}

impl Choice for AnchoringKind {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("homeotropic", Self::Homeotropic),
        ("parallel", Self::Parallel),
        ("none", Self::None),
    ];
}

impl AnchoringKind {
    /// The word for it in a scene.
    pub fn name(self) -> &'static str {
        self.word()
    }

    /// The one after it, in a circle over all there are.
    #[must_use]
    pub fn next(self) -> Self {
        let kinds = Self::NAMES.iter().map(|(_, kind)| *kind);
        let mut after = kinds.clone().cycle().skip_while(|kind| *kind != self);
        after.nth(1).unwrap_or(self)
    }
}

impl std::fmt::Display for AnchoringKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
