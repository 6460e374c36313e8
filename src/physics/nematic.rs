//! The nematic energy λ_nem E_nem = λ_nem ∫ I(φ) (½|∇d|² + P(d)) with the truncated potential P
//! that keeps |d| near 1. By rotation |∇d|² has the part d_r²/r² along the circle: the director has no component along it
//! (no twist), and the elastic energy with one constant is that of |∇d|², saddle-splay included (K₂₄ = K).

use super::potentials::{
    INDICATOR_CONVEXITY, indicator_secant, indicator_secant_bound, indicator_secant_derivative,
    phase_indicator, unit_length_penalty, unit_length_penalty_derivative,
    unit_length_penalty_slope,
};
use super::{
    DirectorCoupling, DirectorFields, DirectorForm, Effect, EffectContext, Kept, LedgerTerms,
    MembraneForce, MembraneJacobian, PatchFields, PatchStep, Room,
};
use crate::fem::Patch;
use crate::geometry::SymmetricTensor;
use crate::scene::{self, Iteration, TimeScheme};

/// The effect, where the scene has it.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let nematic = context.scene.nematic.as_ref()?;
    Some(Box::new(Nematic::new(nematic)))
}

/// The nematic energy.
#[derive(Debug)]
pub struct Nematic {
    weight: f64,
    /// 1/η_d². As the constant of p_Δt (3.33) it is sharp: half the largest eigenvalue of the
    /// Hessian of P over all d, which is 2/η_d². (The paper prints the value at dⁿ.)
    stiffness: f64,
}

impl Nematic {
    /// λ_nem and η_d of a scene.
    pub fn new(nematic: &scene::Nematic) -> Self {
        Self {
            weight: nematic.weight,
            stiffness: (nematic.penalty * nematic.penalty).recip(),
        }
    }

    /// density ← λ_nem (½|∇d|² + P(d)) at the points.
    fn fill_density(
        &self,
        patch: &Patch<'_>,
        director: &DirectorFields,
        density: &mut Vec<f64>,
        elements: &mut Vec<f64>,
    ) {
        let [along_x, along_y] = &director.gradients;
        elements.clear();
        elements.extend(
            along_x
                .iter()
                .zip(along_y)
                .map(|(x, y)| 0.5 * self.weight * (x.norm_squared() + y.x * y.x + y.y * y.y)),
        );
        for (element, hoop) in elements.iter_mut().zip(&director.hoop) {
            *element += 0.5 * self.weight * hoop * hoop;
        }
        density.resize(patch.points(), 0.0);
        patch.from_elements(elements, density);
        let scale = self.weight * self.stiffness;
        let terms = density.iter_mut().zip(director.vectors());
        terms.for_each(|(density, d)| *density += scale * unit_length_penalty(d));
    }

    /// Adds what the slope of p_sec makes of its derivative, nearly, with `weights` at the points: where |d| and |dⁿ| are near 1 it
    /// is (1/η_d²) m⊗m/max(1, |m|³), with m their mean.
    fn add_tangent(
        &self,
        patch: &Patch<'_>,
        [old, new]: [&DirectorFields; 2],
        form: &mut DirectorForm,
        room: &mut Room,
    ) {
        let Room {
            points: weights,
            more_points: entries,
            elements: means,
            ..
        } = room;
        for (number, (i, j)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
            entries.clear();
            let vectors = old.vectors().zip(new.vectors()).zip(&*weights);
            entries.extend(vectors.map(|((old, new), weight)| {
                let mean = 0.5 * (old + new);
                let length = mean.norm().max(1.0);
                weight * self.stiffness * mean[i] * mean[j] / (length * length * length)
            }));
            patch.element_means(entries, means);
            for (tangent, mean) in form.tangent.iter_mut().zip(&*means) {
                let mut entries = [0.0; 3];
                entries[number] = *mean;
                let [xx, xy, yy] = entries;
                *tangent += SymmetricTensor::new(xx, xy, yy);
            }
        }
    }

    /// room.points ← λ_nem I(φ), and room.elements ← its means.
    fn fill_indicator(&self, patch: &Patch<'_>, phi: &[f64], room: &mut Room) {
        room.points.clear();
        let weights = phi.iter().map(|phi| self.weight * phase_indicator(*phi));
        room.points.extend(weights);
        room.elements.resize(patch.elements(), 0.0);
        patch.element_means(&room.points, &mut room.elements);
    }
}

impl Effect for Nematic {
    fn name(&self) -> &'static str {
        "nematic"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, room: &mut Room) -> f64 {
        let Some(director) = &at.director else {
            return 0.0;
        };
        let density = &mut room.points;
        self.fill_density(patch, director, density, &mut room.elements);
        let terms = density.iter_mut().zip(&at.phi);
        terms.for_each(|(density, phi)| *density *= phase_indicator(*phi));
        patch.integrate(density)
    }

    /// λ_nem I(φ) with ∇d, and since |p̃(d)| ≤ 2 max(1, |d|)/η_d², 2 λ_nem I(φ)/η_d² with d.
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling {
            stiffness: self.weight,
            inside: 2.0 * self.weight * self.stiffness,
            at_membrane: 0.0,
        })
    }

    /// λ_nem [(I(φⁿ) ∇d_θ, ∇e) + (I(φⁿ) p, e)] with p_Δt = p̃(dⁿ) + (1/η_d²)(d − dⁿ) (3.33) for p, or the secant p_sec,
    /// whose derivative is at most that of p_Δt.
    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, room: &mut Room) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return;
        };
        self.fill_indicator(patch, &old.phi, room);
        for (stiffness, weight) in form.stiffness.iter_mut().zip(&room.elements) {
            *stiffness += weight;
        }
        let [load_x, load_y] = &mut form.load;
        let loads = load_x.iter_mut().zip(load_y).zip(&mut form.reaction);
        let vectors = old_director.vectors().zip(new_director.vectors());
        let terms = loads.zip(vectors).zip(&room.points);
        match scheme {
            TimeScheme::FirstOrder => {
                terms.for_each(|((((load_x, load_y), reaction), (old, _)), weight)| {
                    let scale = weight * self.stiffness;
                    let force = scale * unit_length_penalty_derivative(old);
                    *load_x += force.x;
                    *load_y += force.y;
                    *reaction += scale;
                });
            }
            TimeScheme::Secant => {
                terms.for_each(|((((load_x, load_y), reaction), (old, new)), weight)| {
                    let scale = weight * self.stiffness;
                    let slope = unit_length_penalty_slope(new, old);
                    let force = scale * slope * (new + old);
                    *load_x += force.x;
                    *load_y += force.y;
                    *reaction += scale * slope.max(0.0);
                });
                if form.with_derivative {
                    self.add_tangent(patch, [old_director, new_director], form, room);
                }
            }
        }
    }

    fn begin_membrane(&self, step: &PatchStep<'_>, kept: &mut Kept, room: &mut Room) {
        if let Some(director) = &step.new.director {
            let elements = &mut room.elements;
            self.fill_density(step.patch, director, &mut kept.points, elements);
        }
    }

    /// λ_nem (i (½|∇d|² + P(d)), ψ) with i_Δt for i, or the secant of I.
    fn add_membrane_force(&self, step: &PatchStep<'_>, kept: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        let terms = force.load.iter_mut().zip(values);
        match scheme {
            TimeScheme::FirstOrder => terms.for_each(|(load, (density, (new, old)))| {
                *load += density * indicator_secant_bound(*new, *old);
            }),
            TimeScheme::Secant => terms.for_each(|(load, (density, (new, old)))| {
                *load += density * indicator_secant(*new, *old);
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
        match scheme {
            TimeScheme::FirstOrder => terms.for_each(|(reaction, (density, _))| {
                *reaction += INDICATOR_CONVEXITY * density;
            }),
            TimeScheme::Secant => terms.for_each(|(reaction, (density, (new, old)))| {
                *reaction += density * indicator_secant_derivative(*new, *old);
            }),
        }
    }

    /// Δt ND_elast = λ_nem/2 ∫ I(φⁿ)|∇δ|², Δt ND_penal = λ_nem ∫ I(φⁿ)(p_Δt·δ − P(d) + P(dⁿ)) and
    /// Δt ND_interp = λ_nem ∫ (½|∇d|² + P(d))(i_Δt (φ − φⁿ) − I(φ) + I(φⁿ)), with δ = d − dⁿ.
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
        self.fill_indicator(patch, &old.phi, room);
        let Room {
            points, elements, ..
        } = room;
        for (triangle, weight) in elements.iter_mut().enumerate() {
            let [x, y] = [0, 1].map(|axis| {
                new_director.gradients[axis][triangle] - old_director.gradients[axis][triangle]
            });
            let hoops = [new_director, old_director].map(|it| it.hoop.get(triangle));
            let along_circle = match hoops {
                [Some(new), Some(old)] => (new - old) * (new - old),
                _ => 0.0,
            };
            *weight *= 0.5 * (x.norm_squared() + y.norm_squared() + along_circle);
        }
        terms.add("ND_elast", patch.integrate_elements(elements));

        let vectors = old_director.vectors().zip(new_director.vectors());
        let weights = points.iter_mut().zip(vectors);
        weights.for_each(|(weight, (old, new))| {
            let step = new - old;
            let work = (unit_length_penalty_derivative(old) + step).dot(&step);
            let change = unit_length_penalty(new) - unit_length_penalty(old);
            *weight *= self.stiffness * (work - change);
        });
        terms.add("ND_penal", patch.integrate(points));

        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        let points = points.iter_mut().zip(values);
        points.for_each(|(term, (density, (new, old)))| {
            let change = phase_indicator(*new) - phase_indicator(*old);
            *term = density * (indicator_secant_bound(*new, *old) * (new - old) - change);
        });
        terms.add("ND_interp", patch.integrate(&room.points));
    }
}
