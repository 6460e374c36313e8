//! An external field on the director, magnetic or electric: E_field = −½ χ ∫ I(φ)(d·H)² with the same
//! H everywhere. Where χ > 0 the director turns along the field, where χ < 0 across it.
//!
//! With q(d) = ½ (d·H)² and ⟨.⟩ the mean over a triangle by the rule, the energy is taken as
//! −χ Σ_T |T| ⟨I(φ)⟩ ⟨q(d)⟩: so the matrix of substep 1 needs one tensor a triangle, as that of the
//! anchoring. It differs from ∫ I q by the rule in the order h², as the rules themselves do.
//!
//! **The energy law holds for both signs of χ**, because each half of a step takes what is convex at
//! the new state and what is concave at the old one.
//!
//! *Substep 1*, φⁿ fixed, δ = d − dⁿ, w = ⟨I(φⁿ)⟩ ≥ 0. For χ < 0 the energy is convex in d, and its
//! force is taken at d: (|χ| w (d·H) H, e). From a² − b² = 2a(a − b) − (a − b)²,
//!   E(φⁿ, d) − E(φⁿ, dⁿ) = ⟨f_d, δ⟩ − ½ |χ| ∫ w (δ·H)².
//! For χ > 0 it is concave, and its force is taken at dⁿ: (−χ w (dⁿ·H) H, e). From
//! a² − b² = 2b(a − b) + (a − b)² and the sign −χ, the change is again
//!   E(φⁿ, d) − E(φⁿ, dⁿ) = ⟨f_d, δ⟩ − ½ |χ| ∫ w (δ·H)².
//! What is implicit is positive semidefinite in both cases, so substep 1 stays positive definite for
//! any Δt.
//!
//! *Substep 2*, d fixed, Q = ⟨q(d)⟩ ≥ 0. The force is (−χ Q i*, ψ) with
//! i* = i(φⁿ) − sign(χ) c (φ − φⁿ), where c = 5√3/12 is half the maximum of |I''| ([`INDICATOR_CONVEXITY`]):
//! for χ < 0 the i_Δt of the nematic energy, for χ > 0 its mirror image. By Taylor's formula
//! |I(φ) − I(φⁿ) − i(φⁿ)(φ − φⁿ)| ≤ c (φ − φⁿ)², so at every point
//!   −χ [i* (φ − φⁿ) − (I(φ) − I(φⁿ))] = |χ| [c (φ − φⁿ)² ± (I(φ) − I(φⁿ) − i(φⁿ)(φ − φⁿ))] ≥ 0:
//! E(φ, d) − E(φⁿ, d) = ⟨f_φ, φ − φⁿ⟩ − Δt ND with ND ≥ 0. The force is linear in φ, with the derivative
//! |χ| c Q ≥ 0.
//!
//! A field that is off is no effect; a change of the scene switches it (`scene/change.rs`).

use super::potentials::{
    INDICATOR_CONVEXITY, indicator_secant, indicator_secant_derivative, phase_indicator,
    phase_indicator_derivative,
};
use super::{
    DirectorCoupling, DirectorForm, Effect, EffectContext, Kept, LedgerTerms, MembraneForce,
    MembraneJacobian, PatchFields, PatchStep, Room,
};
use crate::fem::Patch;
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{self, Iteration, TimeScheme};

/// The effect, where the scene has it and it is on.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let field = context.scene.field.as_ref()?;
    field
        .on
        .then(|| Box::new(Field::new(field)) as Box<dyn Effect>)
}

/// An external field on the director.
#[derive(Debug)]
pub struct Field {
    /// χ.
    weight: f64,
    /// H.
    vector: Vector,
}

impl Field {
    /// χ and H of a scene.
    pub fn new(field: &scene::Field) -> Self {
        Self {
            weight: field.weight,
            vector: field.vector(),
        }
    }

    /// room.elements ← ⟨½ (v·H)²⟩ for a vector field v at the points.
    fn fill_squares(
        &self,
        patch: &Patch<'_>,
        values: impl Iterator<Item = Vector>,
        room: &mut Room,
    ) {
        room.points.clear();
        room.points.extend(values.map(|v| {
            let component = self.vector.dot(&v);
            0.5 * component * component
        }));
        room.elements.resize(patch.elements(), 0.0);
        patch.element_means(&room.points, &mut room.elements);
    }

    /// room.more_elements ← ⟨I(φ)⟩.
    fn fill_indicator(patch: &Patch<'_>, phi: &[f64], room: &mut Room) {
        room.points.clear();
        let values = phi.iter().map(|phi| phase_indicator(*phi));
        room.points.extend(values);
        room.more_elements.resize(patch.elements(), 0.0);
        patch.element_means(&room.points, &mut room.more_elements);
    }

    /// ∫ ⟨I(φ)⟩ ½ (v·H)² for a vector field v at the points.
    fn integral_of(
        &self,
        patch: &Patch<'_>,
        phi: &[f64],
        values: impl Iterator<Item = Vector>,
        room: &mut Room,
    ) -> f64 {
        Self::fill_indicator(patch, phi, room);
        self.fill_squares(patch, values, room);
        for (square, weight) in room.elements.iter_mut().zip(&room.more_elements) {
            *square *= weight;
        }
        patch.integrate_elements(&room.elements)
    }

    /// i* = i(φⁿ) − sign(χ) c (φ − φⁿ).
    fn indicator_tangent(&self, phi: f64, old: f64) -> f64 {
        phase_indicator_derivative(old) - self.weight.signum() * INDICATOR_CONVEXITY * (phi - old)
    }
}

impl Effect for Field {
    fn name(&self) -> &'static str {
        "field"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, room: &mut Room) -> f64 {
        let Some(director) = &at.director else {
            return 0.0;
        };
        -self.weight * self.integral_of(patch, &at.phi, director.vectors(), room)
    }

    /// |χ| H² I(φ): the field turns the director only inside.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling {
            inside: self.weight.abs() * self.vector.norm_squared(),
            ..DirectorCoupling::NONE
        })
    }

    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, room: &mut Room) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return;
        };
        Self::fill_indicator(patch, &old.phi, room);
        if self.weight < 0.0 {
            for (tensor, weight) in form.tensor.iter_mut().zip(&room.more_elements) {
                *tensor += SymmetricTensor::outer(-self.weight * weight, self.vector);
            }
            form.has_tensor = true;
            return;
        }
        patch.from_elements(&room.more_elements, &mut room.points);
        let [load_x, load_y] = &mut form.load;
        let loads = load_x.iter_mut().zip(load_y).zip(&room.points);
        let vectors = old_director.vectors().zip(new_director.vectors());
        for (((load_x, load_y), weight), (old, new)) in loads.zip(vectors) {
            let d = match scheme {
                TimeScheme::FirstOrder => old,
                TimeScheme::Secant => 0.5 * (old + new),
            };
            let force = -self.weight * weight * self.vector.dot(&d) * self.vector;
            *load_x += force.x;
            *load_y += force.y;
        }
    }

    fn begin_membrane(&self, step: &PatchStep<'_>, kept: &mut Kept, room: &mut Room) {
        let (patch, new) = (step.patch, step.new);
        kept.points.clear();
        if let Some(director) = &new.director {
            self.fill_squares(patch, director.vectors(), room);
            kept.points.resize(patch.points(), 0.0);
            patch.from_elements(&room.elements, &mut kept.points);
        }
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, kept: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        let terms = force.load.iter_mut().zip(values);
        match scheme {
            TimeScheme::FirstOrder => terms.for_each(|(load, (square, (new, old)))| {
                *load -= self.weight * square * self.indicator_tangent(*new, *old);
            }),
            TimeScheme::Secant => terms.for_each(|(load, (square, (new, old)))| {
                *load -= self.weight * square * indicator_secant(*new, *old);
            }),
        }
    }

    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        kept: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        let terms = jacobian.reaction.iter_mut().zip(values);
        let scale = self.weight.abs() * INDICATOR_CONVEXITY;
        match scheme {
            TimeScheme::FirstOrder => terms.for_each(|(reaction, (square, _))| {
                *reaction += scale * square;
            }),
            TimeScheme::Secant => terms.for_each(|(reaction, (square, (new, old)))| {
                *reaction -= self.weight * square * indicator_secant_derivative(*new, *old);
            }),
        }
    }

    /// Of substep 1, ½ |χ| ∫ w (δ·H)², and of substep 2, −χ ∫ Q (i* (φ − φⁿ) − I(φ) + I(φⁿ)).
    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        kept: &Kept,
        terms: &mut LedgerTerms,
        room: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return;
        };
        let steps = new_director.vectors().zip(old_director.vectors());
        let steps = steps.map(|(new, old)| new - old);
        let of_director = self.weight.abs() * self.integral_of(patch, &old.phi, steps, room);
        terms.add("ND_field_director", of_director);

        let points = &mut room.points;
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        points.clear();
        points.extend(values.map(|(square, (new, old))| {
            let change = phase_indicator(*new) - phase_indicator(*old);
            -self.weight * square * (self.indicator_tangent(*new, *old) * (new - old) - change)
        }));
        terms.add("ND_field_membrane", patch.integrate(points));
    }
}
