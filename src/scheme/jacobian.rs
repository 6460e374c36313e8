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
use crate::fem::Space;
use crate::linalg::SparseMatrix;
use crate::physics::{Effects, MembraneJacobian, PatchFields, PatchStep, RankOne};
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
    form: MembraneJacobian,
    coefficient: Vec<f64>,
}

impl Jacobian {
    pub(super) fn new(space: &Space) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        Self {
            tangent: matrix(),
            secant: matrix(),
            local: matrix(),
            rank_one: Vec::new(),
            weight: 1.0,
            form: MembraneJacobian::default(),
            coefficient: Vec::new(),
        }
    }

    /// Assembles everything at φ and ω_θ, from φⁿ.
    pub(super) fn assemble(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        [old, new]: [&mut PatchFields; 2],
        [phi_old, phi, omega]: [&[f64]; 3],
        interface_width: f64,
        (iteration, scheme): (Iteration, TimeScheme),
    ) {
        self.weight = scheme.weight();
        let stiffness = &space.stiffness().values;
        let width = interface_width;
        self.tangent.values.copy_from_slice(stiffness);
        for (entry, k) in self.secant.values.iter_mut().zip(stiffness) {
            *entry = self.weight * width * k;
        }
        self.local.values.fill(0.0);
        for patch in space.patches() {
            old.begin();
            old.set_phi(&patch, phi_old);
            new.begin();
            new.set_phi(&patch, phi);
            new.set_omega(&patch, omega);
            let step = PatchStep {
                patch: &patch,
                old,
                new,
                scheme,
            };

            let coefficient = &mut self.coefficient;
            effects.bending.tangent(&patch, new, coefficient);
            coefficient.iter_mut().for_each(|entry| *entry /= width);
            patch.add_mass(coefficient, &mut self.tangent.values);

            effects.bending.secant(&step, coefficient);
            if self.weight != 1.0 {
                coefficient.iter_mut().for_each(|it| *it *= self.weight);
            }
            patch.add_mass(coefficient, &mut self.secant.values);

            let form = &mut self.form;
            form.clear(&patch);
            for effect in effects.iter_mut() {
                effect.add_membrane_jacobian(&step, iteration, form);
            }
            patch.add_mass_and_stiffness(&form.reaction, &form.tensor, &mut self.local.values);
        }

        fault_injection::tap(Place::Tangent, &mut self.tangent.values);
        fault_injection::tap(Place::Secant, &mut self.secant.values);
        fault_injection::tap(Place::Local, &mut self.local.values);

        let mut used = 0;
        for term in effects.iter().filter_map(|effect| effect.rank_one()) {
            match self.rank_one.get_mut(used) {
                Some(kept) => {
                    kept.scale = term.scale;
                    kept.column.copy_from_slice(&term.column);
                    kept.row.copy_from_slice(&term.row);
                }
                None => self.rank_one.push(term.clone()),
            }
            used += 1;
        }
        self.rank_one.truncate(used);
    }
}
