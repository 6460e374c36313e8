//! What an effect is: an energy and how the scheme treats it, side by side.
//!
//! Let (φⁿ, dⁿ) be the old state, d the new director and φ the new phase field. An effect with the
//! energy E gives
//! - in substep 1 a *director force* f_d(φⁿ; dⁿ → d), affine in d in the scheme of first order: its value at an iterate
//!   and its linear part ([`DirectorForm`]);
//! - in substep 2 a *membrane force* f_φ(φⁿ → φ; d) ([`MembraneForce`]) and its derivative with
//!   respect to φ ([`MembraneJacobian`], [`RankOne`]);
//! - a *numerical dissipation* ND ≥ 0,
//!
//! such that, identically for any states,
//!
//!   E(φ, d) − E(φⁿ, dⁿ) = ⟨f_d, d − dⁿ⟩ + ⟨f_φ, φ − φⁿ⟩ − Δt ND.
//!
//! That is the effect's share of the energy law (3.26); the tests of this room check it for every
//! effect alone, and the derivative against differences. In the secant scheme the forces are secants of E, exactly, and
//! there is no dissipation: ND = 0. (There substep 1 is solved twice in a step, with φⁿ before substep 2 and with the new φ
//! after it.) (Bending is the one whose force acts
//! through ω: see its file.)

use serde::{Deserialize, Serialize};

use super::PatchFields;
use crate::fem::Patch;
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{Iteration, TimeScheme};

/// A value with a name: an energy, or a term of the ledger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedValue {
    /// What it is.
    pub name: &'static str,
    /// How much it is.
    pub value: f64,
}

impl NamedValue {
    /// Adds values to those of the same names, and those that have none to the end.
    pub fn add_all(sums: &mut Vec<Self>, more: impl IntoIterator<Item = Self>) {
        for value in more {
            match sums.iter_mut().find(|sum| sum.name == value.name) {
                Some(sum) => sum.value += value.value,
                None => sums.push(value),
            }
        }
    }

    /// Whether it is a term of the ledger for the work that comes from outside.
    pub fn is_work(&self) -> bool {
        self.name.ends_with("_work")
    }
}

/// LedgerTerms by name, each the sum of what the patches have added.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LedgerTerms(Vec<NamedValue>);

impl LedgerTerms {
    /// Adds a patch's share of a term.
    pub fn add(&mut self, name: &'static str, value: f64) {
        match self.0.iter_mut().find(|term| term.name == name) {
            Some(term) => term.value += value,
            None => self.0.push(NamedValue { name, value }),
        }
    }

    /// Makes all terms zero.
    pub fn reset(&mut self) {
        self.0.iter_mut().for_each(|term| term.value = 0.0);
    }

    /// Forgets all terms.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The terms, in the order in which they came up.
    pub fn values(&self) -> &[NamedValue] {
        &self.0
    }
}

/// The time that a step covers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Interval {
    /// When it begins, on the clock of the scheme, which starts at 0.
    pub begin: f64,
    /// Δt.
    pub length: f64,
}

impl Interval {
    /// The middle: what changes in time has its value there during the step.
    pub fn middle(&self) -> f64 {
        self.begin + 0.5 * self.length
    }
}

/// How strongly an effect acts on the director, place by place. Where |d| ≤ D (D ≥ 1) and the
/// discrete Laplacian of d is at most κ D, the director force per area is at most
///   (I(φ) (κ stiffness + phase_indicator) + |∇φ|² at_membrane) D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectorCoupling {
    /// Of ∇d, inside.
    pub stiffness: f64,
    /// Of d, inside.
    pub inside: f64,
    /// Of d, at the membrane.
    pub at_membrane: f64,
}

impl DirectorCoupling {
    /// Of an effect that does not act on the director.
    pub const NONE: Self = Self {
        stiffness: 0.0,
        inside: 0.0,
        at_membrane: 0.0,
    };

    /// Whether it is of an effect that does not act on the director.
    pub fn is_nowhere(&self) -> bool {
        *self == Self::NONE
    }
}

impl std::ops::Add for DirectorCoupling {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            stiffness: self.stiffness + other.stiffness,
            inside: self.inside + other.inside,
            at_membrane: self.at_membrane + other.at_membrane,
        }
    }
}

/// A step on a patch: the state that it starts from and the one that it leads to.
#[derive(Debug, Clone, Copy)]
pub struct PatchStep<'a> {
    /// The patch.
    pub patch: &'a Patch<'a>,
    /// The old state.
    pub old: &'a PatchFields,
    /// The new state.
    pub new: &'a PatchFields,
    /// How the step is taken.
    pub scheme: TimeScheme,
}

/// What an effect keeps of a patch over substep 2, from [`Effect::begin_membrane`] to the end of the step. It is empty at first.
#[derive(Debug, Clone, Default)]
pub struct Kept {
    /// Values at the points.
    pub points: Vec<f64>,
    /// Tensors on the triangles.
    pub tensors: Vec<SymmetricTensor>,
}

/// Room for what an effect works out on a patch, so that nothing is allocated in a step. Others have used it before.
#[derive(Debug, Default)]
pub struct Room {
    /// Values at the points.
    pub points: Vec<f64>,
    /// The same.
    pub more_points: Vec<f64>,
    /// Values on the triangles.
    pub elements: Vec<f64>,
    /// The same.
    pub more_elements: Vec<f64>,
    /// Tensors on the triangles.
    pub tensors: Vec<SymmetricTensor>,
    /// Numbers of the points.
    pub numbers: Vec<u32>,
}

/// One energy and how the scheme treats it.
///
/// Everything is worked out one [`Patch`] of the space at a time, several at once where there are threads: slices belong to
/// the patch. What an effect keeps of a patch over a step it puts into [`Kept`]. Of the
/// states, only what is known and of use is sampled, and nothing else may be looked at (tests see to
/// that):
///
/// | in | of the old state | of the new state |
/// |---|---|---|
/// | `integral` | | φ, ω, d (φ alone for the sake of `set_integrals`) |
/// | `add_director_force` | φ, d | d |
/// | `work` | φ, d | d |
/// | `begin_membrane` | φ | d |
/// | `add_membrane_force`, `add_membrane_jacobian` | φ | φ, ω_θ |
/// | `add_dissipation` | φ, ω, d | φ, ω, d |
pub trait Effect: Send + Sync + std::fmt::Debug {
    /// Its name: the column `E_<name>` of a history.
    fn name(&self) -> &'static str;

    /// The patch's share of the integral that the energy follows from; most energies *are* an
    /// integral, weighted as in E_tot.
    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, room: &mut Room) -> f64;

    /// The energy, weighted as in E_tot, from the integral over the whole domain.
    fn energy(&self, integral: f64) -> f64 {
        integral
    }

    /// Whether there is an energy at all; without one there is no column of it.
    fn has_energy(&self) -> bool {
        true
    }

    /// Told the time of a step before it begins.
    fn set_interval(&mut self, _interval: Interval) {}

    /// Where it acts on the director; `None`: nobody knows, so everywhere. Substep 1 solves for the
    /// director only where the effects together say that it matters.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        None
    }

    /// Whether the membrane force depends on the integral over the whole, as that of a penalty does;
    /// then the integral depends on φ alone.
    fn needs_integrals(&self) -> bool {
        false
    }

    /// Told the integrals over the whole at φⁿ and at φ, before the membrane force there is asked for,
    /// if it [`needs_integrals`](Self::needs_integrals).
    fn set_integrals(&mut self, _old: f64, _new: f64) {}

    /// Adds the director force at the new d, an iterate (dⁿ itself in the scheme of first order, where it is affine), and
    /// its linear part.
    fn add_director_force(
        &self,
        _step: &PatchStep<'_>,
        _form: &mut DirectorForm,
        _room: &mut Room,
    ) {
    }

    /// Called once a step before substep 2, when the new director is known: the place to prepare
    /// what depends on φⁿ and d only.
    fn begin_membrane(&self, _step: &PatchStep<'_>, _kept: &mut Kept, _room: &mut Room) {}

    /// Adds the membrane force.
    fn add_membrane_force(&self, _step: &PatchStep<'_>, _kept: &Kept, _force: &mut MembraneForce) {}

    /// Adds the derivative of the membrane force with respect to φ, for the given iteration.
    fn add_membrane_jacobian(
        &self,
        _step: &PatchStep<'_>,
        _kept: &Kept,
        _iteration: Iteration,
        _jacobian: &mut MembraneJacobian,
    ) {
    }

    /// Whether a part of the derivative, for the given iteration, is a product of two vectors, scale · column rowᵀ: its scale.
    fn rank_one(&self, _iteration: Iteration) -> Option<f64> {
        None
    }

    /// Adds the densities of these two vectors, if there is such a part. In `step` only φ is sampled.
    fn add_rank_one(
        &self,
        _step: &PatchStep<'_>,
        _column: &mut MembraneForce,
        _row: &mut MembraneForce,
    ) {
    }

    /// Told what the correction of Newton's method that was just solved for makes of the rank-one term:
    /// rowᵀδφ.
    ///
    /// An effect whose force has a stiff factor p(φ) = B(φ)/η may treat p as an unknown of its own, as the
    /// mixed form of a penalty method does: the residual stays what it is, but the derivative of the rest
    /// of the force is taken with the p that the correction leads to, not with p(φ), which is off by
    /// δφ²/η after it.
    fn newton_correction(&mut self, _along: f64) {}

    /// Told that an iterate lies by this part of the correction further; 0: an iteration begins.
    fn accept_correction(&mut self, _part: f64) {}

    /// Whether it does work from outside, beyond its energy.
    fn does_work(&self) -> bool {
        false
    }

    /// The patch's share of the work that it has done from outside on the director in substep 1, if it
    /// [`does_work`](Self::does_work).
    fn work(&self, _step: &PatchStep<'_>, _room: &mut Room) -> f64 {
        0.0
    }

    /// Whether it has terms of a ledger in a scheme. In the secant scheme nothing is dissipated numerically.
    fn has_terms(&self, scheme: TimeScheme) -> bool {
        scheme == TimeScheme::FirstOrder || self.does_work()
    }

    /// Adds the terms of the numerical dissipation, each Δt·ND ≥ 0 (times Δt, so that nothing is
    /// divided by a small number); and minus the work that comes from outside, of either sign.
    fn add_dissipation(
        &self,
        _step: &PatchStep<'_>,
        _kept: &Kept,
        _terms: &mut LedgerTerms,
        _room: &mut Room,
    ) {
    }
}

/// The director force near an iterate d*, tested with e:
/// f_d(d) = ∫ (flux:∇e + load·e) + ∫ (stiffness ∇d_θ:∇e + (R d_θ)·e) + ∫ reaction (d − d*)·e,
/// with d_θ = dⁿ + θ(d − dⁿ). In the scheme of first order θ = 1, d* = dⁿ and this is exact; in the secant scheme θ = ½ and
/// it is exact at d = d*.
#[derive(Debug, Default)]
pub struct DirectorForm {
    /// For each component, a vector on each triangle.
    pub flux: [Vec<Vector>; 2],
    /// By rotation the component of the flux along the circle, which is tested with e_r/r, on each triangle.
    pub hoop: Vec<f64>,
    /// For each component, a value at each point.
    pub load: [Vec<f64>; 2],
    /// A weight ≥ 0 on each triangle, of ∇d with all its components.
    pub stiffness: Vec<f64>,
    /// R ≥ 0, a tensor on each triangle, of d.
    pub tensor: Vec<SymmetricTensor>,
    /// Whether any effect has given a tensor.
    pub has_tensor: bool,
    /// A weight ≥ 0 at each point, of d − d*.
    pub reaction: Vec<f64>,
    /// The same as a tensor ≥ 0 on each triangle; asked for where the derivative is.
    pub tangent: Vec<SymmetricTensor>,
    /// Whether the derivative is asked for, or only the force at d*.
    pub with_derivative: bool,
}

impl DirectorForm {
    /// Makes it zero, for a patch.
    pub fn clear(&mut self, patch: &Patch<'_>) {
        let (points, elements) = (patch.points(), patch.elements());
        for axis in 0..2 {
            zero(&mut self.flux[axis], elements);
            zero(&mut self.load[axis], points);
        }
        zero(&mut self.stiffness, elements);
        zero(&mut self.tensor, elements);
        zero(&mut self.tangent, elements);
        self.has_tensor = false;
        zero(&mut self.reaction, points);
    }

    /// flux ← flux + stiffness ∇d_θ.
    pub fn add_flux_of_stiffness(&mut self, step: &PatchStep<'_>) {
        let (Some(old), Some(new)) = (&step.old.director, &step.new.director) else {
            return;
        };
        for axis in 0..2 {
            let gradients = old.gradients[axis].iter().zip(&new.gradients[axis]);
            let terms = self.stiffness.iter().zip(gradients);
            for (flux, (weight, (old, new))) in self.flux[axis].iter_mut().zip(terms) {
                *flux += *weight * step.scheme.implicit(*old, *new);
            }
        }
        self.hoop.clear();
        let hoops = self.stiffness.iter().zip(old.hoop.iter().zip(&new.hoop));
        let hoops = hoops.map(|(weight, (old, new))| weight * step.scheme.implicit(*old, *new));
        self.hoop.extend(hoops);
    }

    /// Makes of stiffness and R the derivative with respect to d: of what acts on d_θ, and with the tangent.
    pub fn differentiate(&mut self, scheme: TimeScheme) {
        if scheme == TimeScheme::FirstOrder {
            return;
        }
        let weight = scheme.weight();
        self.stiffness.iter_mut().for_each(|it| *it *= weight);
        for (tensor, tangent) in self.tensor.iter_mut().zip(&self.tangent) {
            *tensor = weight * *tensor + *tangent;
        }
        self.has_tensor = true;
    }
}

/// As many zeros.
fn zero<T: Copy + Default>(values: &mut Vec<T>, count: usize) {
    values.clear();
    values.resize(count, T::default());
}

/// The membrane force, tested with ψ: ∫ flux·∇ψ + ∫ load ψ.
#[derive(Debug, Default)]
pub struct MembraneForce {
    /// On the triangles.
    pub flux: Vec<Vector>,
    /// At the points.
    pub load: Vec<f64>,
}

impl MembraneForce {
    /// Makes it zero, for a patch.
    pub fn clear(&mut self, patch: &Patch<'_>) {
        zero(&mut self.flux, patch.elements());
        zero(&mut self.load, patch.points());
    }
}

/// The derivative of the membrane force at fixed ω: ∫ (T ∇δ)·∇ψ + ∫ reaction δ ψ.
#[derive(Debug, Default)]
pub struct MembraneJacobian {
    /// T, on the triangles.
    pub tensor: Vec<SymmetricTensor>,
    /// At the points.
    pub reaction: Vec<f64>,
}

impl MembraneJacobian {
    /// Makes it zero, for a patch.
    pub fn clear(&mut self, patch: &Patch<'_>) {
        zero(&mut self.tensor, patch.elements());
        zero(&mut self.reaction, patch.points());
    }
}

/// The matrix scale · column rowᵀ, in nodal loads.
#[derive(Debug, Clone)]
pub struct RankOne {
    /// The number of the effect that it belongs to.
    pub effect: usize,
    /// Its factor.
    pub scale: f64,
    /// The column vector.
    pub column: Vec<f64>,
    /// The row vector.
    pub row: Vec<f64>,
}
