//! The equations of substep 2 linearised about an iterate (φ, ω):
//!
//!   M δφ + Δtγ_ben K δμ                  = −r₁
//!   C δφ + A δω − M δμ + Σ s c (rᵀδφ)    = −r₂
//!   ε M δω − ε T δφ                      = −r₃
//!
//! with A = εK + (1/ε)∫G_sec, T = K + (1/ε²)∫G', C from the effects' tensors and reactions, and
//! their rank-one terms. Where G_sec = G' and without the rank-one terms this is symmetric after a
//! change of signs, since then A = ε T.

use crate::fem::Space;
use crate::linalg::SparseMatrix;
use crate::physics::{Effects, MembraneLinearisation, RankOne, Sample};
use crate::scene::Iteration;

/// The assembled matrices.
#[derive(Debug)]
pub(super) struct Linearised {
    /// T.
    pub(super) tangent: SparseMatrix,
    /// A.
    pub(super) secant: SparseMatrix,
    /// C.
    pub(super) local: SparseMatrix,
    /// The rank-one terms.
    pub(super) rank_one: Vec<RankOne>,
    form: MembraneLinearisation,
    coefficient: Vec<f64>,
    mass: crate::fem::MassForm,
}

impl Linearised {
    pub(super) fn new(space: &Space) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        Self {
            tangent: matrix(),
            secant: matrix(),
            local: matrix(),
            rank_one: Vec::new(),
            form: MembraneLinearisation::new(space),
            coefficient: vec![0.0; space.points()],
            mass: space.new_form(),
        }
    }

    /// Assembles everything at `new`.
    pub(super) fn assemble(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        old: &Sample,
        new: &Sample,
        iteration: Iteration,
    ) {
        let diagonal = &space.assembly().diagonal;
        let stiffness = &space.stiffness().values;
        let width = effects.bending.interface_width();

        effects.bending.tangent(new, &mut self.coefficient);
        space.assemble_mass(&self.coefficient, &mut self.mass);
        self.tangent.values.copy_from_slice(stiffness);
        self.mass
            .add_to(width.recip(), diagonal, &mut self.tangent.values);

        effects.bending.secant(old, new, &mut self.coefficient);
        space.assemble_mass(&self.coefficient, &mut self.mass);
        for (entry, k) in self.secant.values.iter_mut().zip(stiffness) {
            *entry = width * k;
        }
        self.mass.add_to(1.0, diagonal, &mut self.secant.values);

        self.form.clear();
        for effect in effects.iter_mut() {
            effect.add_membrane_linearisation(space, old, new, iteration, &mut self.form);
        }
        self.local.values.fill(0.0);
        space
            .assembly()
            .add_stiffness(space.mesh(), &self.form.tensor, &mut self.local.values);
        space.assemble_mass(&self.form.reaction, &mut self.mass);
        self.mass.add_to(1.0, diagonal, &mut self.local.values);

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
