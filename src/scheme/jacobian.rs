//! The equations of substep 2 linearised about an iterate (φ, ω):
//!
//!   M δφ + Δtγ_ben K δμ                  = −r₁
//!   C δφ + A δω − M δμ + Σ s c (rᵀδφ)    = −r₂
//!   ε M δω − ε T δφ                      = −r₃
//!
//! with A = θ(εK + (1/ε)∫G_sec), T = K + (1/ε²)∫G', C from the effects' tensors and reactions, and
//! their rank-one terms. Where G_sec = G' and without the rank-one terms this is symmetric after a
//! change of signs, since then A = ε T.

use super::fault_injection::{self, Place};
use super::strips::{Strip, Strips};
use crate::fem::{LoadEntries, MatrixEntries, QuadratureRule, Space};
use crate::linalg::{SparseMatrix, op_counts};
use crate::physics::{Effects, MembraneJacobian, PatchStep, RankOne};
use crate::scene::{Iteration, TimeScheme};

/// The assembled matrices.
#[derive(Debug)]
pub(super) struct Jacobian {
    /// T.
    pub(super) tangent: SparseMatrix,
    /// A.
    pub(super) secant: SparseMatrix,
    /// C.
    pub(super) local: SparseMatrix,
    /// The rank-one terms.
    pub(super) rank_one: Vec<RankOne>,
    /// θ.
    pub(super) weight: f64,
    /// Of the tangent, of the secant and of C; with the lumped rule of C alone.
    entries: [Vec<MatrixEntries>; 3],
    /// Of a rank-one term's column and row.
    vector_entries: [Vec<LoadEntries>; 2],
}

impl Jacobian {
    pub(super) fn new(space: &Space) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        let entries = |groups| vec![MatrixEntries::default(); groups];
        let all = space.groups();
        let of_mass = match space.rule() {
            QuadratureRule::Lumped => 0,
            QuadratureRule::Consistent => all,
        };
        Self {
            tangent: matrix(),
            secant: matrix(),
            local: matrix(),
            rank_one: Vec::new(),
            weight: 1.0,
            entries: [of_mass, of_mass, all].map(entries),
            vector_entries: [Vec::new(), Vec::new()],
        }
    }

    /// Assembles everything at φ and ω_θ, from φⁿ.
    pub(super) fn assemble(
        &mut self,
        space: &Space,
        effects: &Effects,
        strips: &mut Strips,
        [phi_old, phi, omega]: [&[f64]; 3],
        width: f64,
        (iteration, scheme): (Iteration, TimeScheme),
    ) {
        op_counts::assemblies(3);
        let weight = scheme.weight();
        self.weight = weight;
        let entries = self.entries.each_mut().map(|entries| &mut entries[..]);
        strips.over(space, entries, |patch, number, strip, entries| {
            let [tangent_entries, secant_entries, local_entries] = entries;
            let Strip {
                old,
                new,
                kept,
                jacobian,
                coefficients: [tangent, secant],
                ..
            } = strip;
            old.begin();
            old.set_phi(patch, phi_old);
            new.begin();
            new.set_phi(patch, phi);
            new.set_omega(patch, omega);
            let step = PatchStep {
                patch,
                old,
                new,
                scheme,
            };

            effects.bending.tangent(patch, new, tangent);
            tangent.iter_mut().for_each(|entry| *entry /= width);
            patch.mass_entries(tangent, tangent_entries);

            effects.bending.secant(&step, secant);
            if weight != 1.0 {
                secant.iter_mut().for_each(|it| *it *= weight);
            }
            patch.mass_entries(secant, secant_entries);

            jacobian.clear(patch);
            for (effect, kept) in effects.iter().zip(&kept[number]) {
                effect.add_membrane_jacobian(&step, kept, iteration, jacobian);
            }
            let MembraneJacobian { tensor, reaction } = jacobian;
            patch.mass_and_stiffness_entries(reaction, tensor, local_entries);
        });

        let stiffness = &space.stiffness().values;
        let [tangent, secant, local] = [&mut self.tangent, &mut self.secant, &mut self.local]
            .map(|matrix| &mut matrix.values[..]);
        tangent.copy_from_slice(stiffness);
        for (entry, k) in secant.iter_mut().zip(stiffness) {
            *entry = weight * width * k;
        }
        local.fill(0.0);
        let Strip {
            coefficients,
            jacobian,
            ..
        } = strips.first();
        space.add_diagonal(&coefficients[0], tangent);
        space.add_diagonal(&coefficients[1], secant);
        space.add_diagonal(&jacobian.reaction, local);
        let assembly = space.assembly();
        match (
            space.rule(),
            self.entries.each_ref().map(|entries| &entries[..]),
        ) {
            (QuadratureRule::Lumped, [_, _, entries]) => {
                assembly.collect_matrices([entries], [local]);
            }
            (QuadratureRule::Consistent, entries) => {
                assembly.collect_matrices(entries, [tangent, secant, local]);
            }
        }
        fault_injection::tap(Place::Tangent, &mut self.tangent.values);
        fault_injection::tap(Place::Secant, &mut self.secant.values);
        fault_injection::tap(Place::Local, &mut self.local.values);
        self.assemble_rank_one(space, effects, strips, [phi_old, phi], (iteration, scheme));
    }

    fn assemble_rank_one(
        &mut self,
        space: &Space,
        effects: &Effects,
        strips: &mut Strips,
        [phi_old, phi]: [&[f64]; 2],
        (iteration, scheme): (Iteration, TimeScheme),
    ) {
        let mut used = 0;
        for (number, effect) in effects.iter().enumerate() {
            let Some(scale) = effect.rank_one(iteration) else {
                continue;
            };
            for entries in &mut self.vector_entries {
                entries.resize(space.groups(), LoadEntries::default());
            }
            let entries = self
                .vector_entries
                .each_mut()
                .map(|entries| &mut entries[..]);
            strips.over(space, entries, |patch, _, strip, [of_column, of_row]| {
                let Strip {
                    old,
                    new,
                    force: column,
                    row,
                    ..
                } = strip;
                old.begin();
                old.set_phi(patch, phi_old);
                new.begin();
                new.set_phi(patch, phi);
                column.clear(patch);
                row.clear(patch);
                let step = PatchStep {
                    patch,
                    old,
                    new,
                    scheme,
                };
                effect.add_rank_one(&step, column, row);
                patch.load_entries(&column.load, &column.flux, of_column);
                patch.load_entries(&row.load, &row.flux, of_row);
            });
            if used == self.rank_one.len() {
                self.rank_one.push(RankOne {
                    effect: number,
                    scale,
                    column: vec![0.0; space.nodes()],
                    row: vec![0.0; space.nodes()],
                });
            }
            let term = &mut self.rank_one[used];
            (term.effect, term.scale) = (number, scale);
            let Strip { force, row, .. } = strips.first();
            let vectors = [&mut term.column, &mut term.row];
            let parts = self.vector_entries.iter().zip([&force.load, &row.load]);
            for (vector, (entries, density)) in vectors.into_iter().zip(parts) {
                vector.fill(0.0);
                space.collect_load(entries, density, vector);
            }
            used += 1;
        }
        self.rank_one.truncate(used);
    }
}
