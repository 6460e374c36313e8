//! Passes over the patches of a space: strips of patches, each with room of its own, several at a time where there are
//! threads. The strips are the same for every number of threads, and so are the sums over them.

use std::ops::Range;

use crate::fem::{Patch, Space};
use crate::linalg::parallel::{Divide, over_items};
use crate::physics::{
    DirectorForm, Effects, Kept, LedgerTerms, MembraneForce, MembraneJacobian, PatchFields,
    PatchStep, Room,
};
use crate::scene::TimeScheme;

/// Strips of a space, if it has as many patches: enough for eight threads.
const STRIPS: usize = 8;

/// The strips of a space.
#[derive(Debug)]
pub(super) struct Strips {
    strips: Vec<Strip>,
    /// Patches of a strip, but for the last one, which may have fewer.
    patches: usize,
    /// The sums of all strips.
    totals: Vec<f64>,
}

/// Some consecutive patches, and room for what is worked out on one of them.
#[derive(Debug, Default)]
pub(super) struct Strip {
    patches: Range<usize>,
    pub(super) old: PatchFields,
    pub(super) new: PatchFields,
    pub(super) room: Room,
    pub(super) form: DirectorForm,
    pub(super) force: MembraneForce,
    /// The row of a rank-one term, whose column is the force.
    pub(super) row: MembraneForce,
    pub(super) jacobian: MembraneJacobian,
    /// At the points: of the second and of the third of the linearised equations.
    pub(super) coefficients: [Vec<f64>; 2],
    /// What each effect keeps of each patch.
    pub(super) kept: Vec<Vec<Kept>>,
    /// Sums over the strip.
    pub(super) sums: Vec<f64>,
    pub(super) terms: LedgerTerms,
}

impl Strips {
    /// Of a space, for states with or without a director.
    pub(super) fn new(space: &Space, with_director: bool) -> Self {
        let all = space.pieces();
        let patches = all.div_ceil(STRIPS).max(1);
        let strips = (0..all).step_by(patches).map(|first| Strip {
            patches: first..(first + patches).min(all),
            old: PatchFields::new(with_director),
            new: PatchFields::new(with_director),
            ..Strip::default()
        });
        Self {
            strips: strips.collect(),
            patches,
            totals: Vec::new(),
        }
    }

    /// The first strip, which is the only one with the lumped rule: its points are all nodes.
    pub(super) fn first(&self) -> &Strip {
        &self.strips[0]
    }

    /// Calls f(patch, its number in the strip, strip, entries) for every patch, with its part of entries of the groups of
    /// triangles.
    pub(super) fn over<D: Divide>(
        &mut self,
        space: &Space,
        entries: D,
        f: impl Fn(&Patch<'_>, usize, &mut Strip, D) + Sync,
    ) {
        let of_patch = space.groups_of_piece();
        let of_strip = self.patches * of_patch;
        over_items(
            &mut self.strips,
            (entries, of_strip),
            |_, strip, entries| {
                let mut rest = entries;
                for (number, patch) in strip.patches.clone().enumerate() {
                    let entries;
                    (entries, rest) = rest.divide_at(of_patch);
                    f(&space.nth_patch(patch), number, strip, entries);
                }
            },
        );
    }

    /// The same, where f adds to the sums of the strip, of which there are `count`; returns those of all strips.
    pub(super) fn sum_over<D: Divide>(
        &mut self,
        space: &Space,
        (entries, count): (D, usize),
        f: impl Fn(&Patch<'_>, usize, &mut Strip, D) + Sync,
    ) -> &[f64] {
        for strip in &mut self.strips {
            strip.sums.clear();
            strip.sums.resize(count, 0.0);
        }
        self.over(space, entries, f);
        self.totals.clear();
        self.totals.resize(count, 0.0);
        for strip in &self.strips {
            for (total, sum) in self.totals.iter_mut().zip(&strip.sums) {
                *total += sum;
            }
        }
        &self.totals
    }

    /// Takes the terms of the ledger of all strips, which are then zero.
    pub(super) fn move_terms(&mut self, terms: &mut LedgerTerms) {
        for strip in &mut self.strips {
            for term in strip.terms.values() {
                terms.add(term.name, term.value);
            }
            strip.terms.clear();
        }
    }

    /// Prepares the effects for substep 2 from φⁿ with the new director; returns the integrals that forces need, at φⁿ.
    pub(super) fn begin_membrane(
        &mut self,
        space: &Space,
        effects: &Effects,
        (phi, director): (&[f64], Option<&[Vec<f64>; 2]>),
        scheme: TimeScheme,
    ) -> &[f64] {
        for strip in &mut self.strips {
            let patches = strip.patches.len();
            strip.kept.resize_with(patches, Vec::new);
            for kept in &mut strip.kept {
                kept.resize_with(effects.count(), Kept::default);
            }
        }
        self.sum_over(space, ((), effects.count()), |patch, number, strip, ()| {
            let Strip {
                old,
                new,
                room,
                kept,
                sums,
                ..
            } = strip;
            old.begin();
            old.set_phi(patch, phi);
            effects.add_integrals(patch, old, sums, room);
            new.begin();
            if let Some(director) = director {
                new.set_director(patch, director);
            }
            let step = PatchStep {
                patch,
                old,
                new,
                scheme,
            };
            for (effect, kept) in effects.iter().zip(&mut kept[number]) {
                effect.begin_membrane(&step, kept, room);
            }
        })
    }
}
