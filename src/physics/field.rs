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
//! A field that is switched on or off changes the energy of a state and not the state; it does so
//! between two steps only, and the scheme then measures the energies again, so that the law of each step
//! is that of one energy. A step has the field if it is on in the middle of the step: `from` and
//! `until` are so rounded to the nearest end of a step.

use super::potentials::{
    INDICATOR_CONVEXITY, indicator_secant, indicator_secant_derivative, phase_indicator,
    phase_indicator_derivative,
};
use super::{
    DirectorCoupling, DirectorForm, Effect, EffectContext, Interval, LedgerTerms, MembraneForce,
    MembraneJacobian, PatchFields, PatchStep,
};
use crate::fem::{Patch, Space};
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{self, Iteration, TimeScheme};

/// The effect, where the scene has it.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let field = context.scene.field.as_ref()?;
    Some(Box::new(Field::new(field, context.space)))
}

/// An external field on the director.
#[derive(Debug)]
pub struct Field {
    /// χ.
    weight: f64,
    /// H.
    vector: Vector,
    from: f64,
    until: f64,
    /// Whether it is switched on.
    on: bool,
    /// ⟨½ (d·H)²⟩ of the new director, brought to the points of the space, kept over substep 2.
    squares: Vec<f64>,
    points: Vec<f64>,
    elements: Vec<f64>,
    weights: Vec<f64>,
}

impl Field {
    /// χ, H and the times of a scene.
    pub fn new(field: &scene::Field, space: &Space) -> Self {
        Self {
            weight: field.weight,
            vector: field.vector(),
            from: field.from,
            until: field.until.unwrap_or(f64::INFINITY),
            on: field.from <= 0.0,
            squares: vec![0.0; space.points()],
            points: Vec::new(),
            elements: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// elements ← ⟨½ (v·H)²⟩ for a vector field v at the points.
    fn fill_squares(&mut self, patch: &Patch<'_>, values: impl Iterator<Item = Vector>) {
        self.points.clear();
        self.points.extend(values.map(|v| {
            let component = self.vector.dot(&v);
            0.5 * component * component
        }));
        self.elements.resize(patch.elements(), 0.0);
        patch.element_means(&self.points, &mut self.elements);
    }

    /// weights ← ⟨I(φ)⟩.
    fn fill_indicator(&mut self, patch: &Patch<'_>, phi: &[f64]) {
        self.points.clear();
        self.points
            .extend(phi.iter().map(|phi| phase_indicator(*phi)));
        self.weights.resize(patch.elements(), 0.0);
        patch.element_means(&self.points, &mut self.weights);
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

    fn set_interval(&mut self, interval: Interval) -> bool {
        let middle = interval.begin + 0.5 * interval.length;
        let on = (self.from..self.until).contains(&middle);
        std::mem::replace(&mut self.on, on) != on
    }

    fn integral(&mut self, patch: &Patch<'_>, at: &PatchFields) -> f64 {
        let Some(director) = at.director.as_ref().filter(|_| self.on) else {
            return 0.0;
        };
        self.fill_indicator(patch, &at.phi);
        self.fill_squares(patch, director.vectors());
        for (square, weight) in self.elements.iter_mut().zip(&self.weights) {
            *square *= weight;
        }
        -self.weight * patch.integrate_elements(&self.elements)
    }

    /// |χ| H² I(φ): the field turns the director only inside.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        let inside = if self.on {
            self.weight.abs() * self.vector.norm_squared()
        } else {
            0.0
        };
        Some(DirectorCoupling {
            inside,
            ..DirectorCoupling::NONE
        })
    }

    fn add_director_force(&mut self, step: &PatchStep<'_>, form: &mut DirectorForm) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        let (Some(old_director), Some(new_director), true) =
            (&old.director, &new.director, self.on)
        else {
            return;
        };
        self.fill_indicator(patch, &old.phi);
        if self.weight < 0.0 {
            for (tensor, weight) in form.tensor.iter_mut().zip(&self.weights) {
                *tensor += SymmetricTensor::outer(-self.weight * weight, self.vector);
            }
            form.has_tensor = true;
            return;
        }
        patch.from_elements(&self.weights, &mut self.points);
        let [load_x, load_y] = &mut form.load;
        let loads = load_x.iter_mut().zip(load_y).zip(&self.points);
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

    fn begin_membrane(&mut self, step: &PatchStep<'_>) {
        let (patch, new) = (step.patch, step.new);
        if let Some(director) = new.director.as_ref().filter(|_| self.on) {
            self.fill_squares(patch, director.vectors());
            patch.from_elements(&self.elements, &mut self.squares[patch.point_range()]);
        }
    }

    fn add_membrane_force(&mut self, step: &PatchStep<'_>, force: &mut MembraneForce) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        if !self.on {
            return;
        }
        let squares = &self.squares[patch.point_range()];
        let values = squares.iter().zip(new.phi.iter().zip(&old.phi));
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
        &mut self,
        step: &PatchStep<'_>,
        _iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        if !self.on {
            return;
        }
        let squares = &self.squares[patch.point_range()];
        let values = squares.iter().zip(new.phi.iter().zip(&old.phi));
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
    fn add_dissipation(&mut self, step: &PatchStep<'_>, terms: &mut LedgerTerms) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let (Some(old_director), Some(new_director), true) =
            (&old.director, &new.director, self.on)
        else {
            return;
        };
        self.fill_indicator(patch, &old.phi);
        let steps = new_director.vectors().zip(old_director.vectors());
        self.fill_squares(patch, steps.map(|(new, old)| new - old));
        for (square, weight) in self.elements.iter_mut().zip(&self.weights) {
            *square *= weight;
        }
        let of_director = self.weight.abs() * patch.integrate_elements(&self.elements);
        terms.add("ND_field_director", of_director);

        let mut points = std::mem::take(&mut self.points);
        let squares = &self.squares[patch.point_range()];
        let values = squares.iter().zip(new.phi.iter().zip(&old.phi));
        points.clear();
        points.extend(values.map(|(square, (new, old))| {
            let change = phase_indicator(*new) - phase_indicator(*old);
            -self.weight * square * (self.indicator_tangent(*new, *old) * (new - old) - change)
        }));
        terms.add("ND_field_membrane", patch.integrate(&points));
        self.points = points;
    }
}
