//! What an effect is: an energy and how the scheme treats it, side by side.
//!
//! Let (φⁿ, dⁿ) be the old state, d the new director and φ the new phase field. An effect with the
//! energy E gives
//! - in substep 1 a *director force* f_d(φⁿ; dⁿ → d), affine in d: its value at dⁿ and its linear
//!   part ([`DirectorForm`]);
//! - in substep 2 a *membrane force* f_φ(φⁿ → φ; d) ([`MembraneForce`]) and its derivative with
//!   respect to φ ([`MembraneLinearisation`], [`RankOne`]);
//! - a *numerical dissipation* ND ≥ 0,
//!
//! such that, identically for any states,
//!
//!   E(φ, d) − E(φⁿ, dⁿ) = ⟨f_d, d − dⁿ⟩ + ⟨f_φ, φ − φⁿ⟩ − Δt ND.
//!
//! That is the effect's share of the energy law (3.26); the tests of this room check it for every
//! effect alone, and the derivative against differences. (Bending is the one whose force acts
//! through ω: see its file.)

use super::Sample;
use crate::fem::{Space, SymmetricTensor};
use crate::scene::Iteration;

/// A value with a name: an energy, or a term of the ledger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedValue {
    /// What it is.
    pub name: &'static str,
    /// How much it is.
    pub value: f64,
}

/// One energy and how the scheme treats it.
pub trait Effect: Send + std::fmt::Debug {
    /// Its name: the column `E_<name>` of a history.
    fn name(&self) -> &'static str;

    /// Its energy, weighted as in E_tot.
    fn energy(&mut self, space: &Space, at: &Sample) -> f64;

    /// Adds the director force at dⁿ and its linear part.
    fn add_director_force(&mut self, _space: &Space, _old: &Sample, _form: &mut DirectorForm) {}

    /// Called once a step before substep 2, when the new director is known: the place to prepare
    /// what depends on φⁿ and d only.
    fn begin_membrane(&mut self, _space: &Space, _old: &Sample, _new: &Sample) {}

    /// Adds the membrane force.
    fn add_membrane_force(
        &mut self,
        _space: &Space,
        _old: &Sample,
        _new: &Sample,
        _force: &mut MembraneForce,
    ) {
    }

    /// Adds the derivative of the membrane force with respect to φ, for the given iteration.
    fn add_membrane_linearisation(
        &mut self,
        _space: &Space,
        _old: &Sample,
        _new: &Sample,
        _iteration: Iteration,
        _linearisation: &mut MembraneLinearisation,
    ) {
    }

    /// The part of the derivative that is a product of two vectors, as of the last call of
    /// [`add_membrane_linearisation`](Self::add_membrane_linearisation).
    fn rank_one(&self) -> Option<&RankOne> {
        None
    }

    /// Appends the terms of the numerical dissipation, each Δt·ND ≥ 0 (times Δt, so that nothing is
    /// divided by a small number).
    fn dissipation(
        &mut self,
        _space: &Space,
        _old: &Sample,
        _new: &Sample,
        _terms: &mut Vec<NamedValue>,
    ) {
    }
}

/// The director force, affine in d, tested with e:
/// f_d(d) = ∫ (flux:∇e + load·e) + ∫ (stiffness ∇d:∇e + (R d)·e) + ∫ reaction δ·e, δ = d − dⁿ.
#[derive(Debug)]
pub struct DirectorForm {
    /// For each component, a vector on each triangle.
    pub flux: [Vec<[f64; 2]>; 2],
    /// For each component, a value at each point.
    pub load: [Vec<f64>; 2],
    /// A weight ≥ 0 on each triangle, of ∇d.
    pub stiffness: Vec<f64>,
    /// R ≥ 0, a tensor on each triangle, of d: its entries xx, xy, yy.
    pub tensor: [Vec<f64>; 3],
    /// Whether any effect has given a tensor.
    pub has_tensor: bool,
    /// A weight ≥ 0 at each point, of δ.
    pub reaction: Vec<f64>,
}

impl DirectorForm {
    /// Zero.
    pub fn new(space: &Space) -> Self {
        let points = || vec![0.0; space.points()];
        let elements = || vec![0.0; space.elements()];
        let fluxes = || vec![[0.0; 2]; space.elements()];
        Self {
            flux: [fluxes(), fluxes()],
            load: [points(), points()],
            stiffness: elements(),
            tensor: [elements(), elements(), elements()],
            has_tensor: false,
            reaction: points(),
        }
    }

    /// Makes it zero again.
    pub fn clear(&mut self) {
        self.flux.iter_mut().for_each(|flux| flux.fill([0.0; 2]));
        self.load.iter_mut().for_each(|load| load.fill(0.0));
        self.stiffness.fill(0.0);
        if self.has_tensor {
            self.tensor.iter_mut().for_each(|entry| entry.fill(0.0));
        }
        self.has_tensor = false;
        self.reaction.fill(0.0);
    }
}

/// The membrane force, tested with ψ: ∫ flux·∇ψ + ∫ load ψ.
#[derive(Debug)]
pub struct MembraneForce {
    /// On the triangles.
    pub flux: Vec<[f64; 2]>,
    /// At the points.
    pub load: Vec<f64>,
}

impl MembraneForce {
    /// Zero.
    pub fn new(space: &Space) -> Self {
        Self {
            flux: vec![[0.0; 2]; space.elements()],
            load: vec![0.0; space.points()],
        }
    }

    /// Makes it zero again.
    pub fn clear(&mut self) {
        self.flux.fill([0.0; 2]);
        self.load.fill(0.0);
    }
}

/// The derivative of the membrane force at fixed ω: ∫ (T ∇δ)·∇ψ + ∫ reaction δ ψ.
#[derive(Debug)]
pub struct MembraneLinearisation {
    /// T, on the triangles.
    pub tensor: Vec<SymmetricTensor>,
    /// At the points.
    pub reaction: Vec<f64>,
}

impl MembraneLinearisation {
    /// Zero.
    pub fn new(space: &Space) -> Self {
        Self {
            tensor: vec![[0.0; 3]; space.elements()],
            reaction: vec![0.0; space.points()],
        }
    }

    /// Makes it zero again.
    pub fn clear(&mut self) {
        self.tensor.fill([0.0; 3]);
        self.reaction.fill(0.0);
    }
}

/// The matrix scale · column rowᵀ, in nodal loads.
#[derive(Debug, Clone)]
pub struct RankOne {
    /// Its factor.
    pub scale: f64,
    /// The column vector.
    pub column: Vec<f64>,
    /// The row vector.
    pub row: Vec<f64>,
}
