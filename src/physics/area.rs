//! The penalty of the surface area, E_pen = (B − β)²/(2η), where
//! B = ∫ (ε/2 |∇φ|² + F(φ)/ε).

use super::potentials::{
    double_well, double_well_derivative, double_well_secant, double_well_secant_derivative,
};
use super::{
    DirectorCoupling, Effect, EffectContext, Kept, MembraneForce, MembraneJacobian, PatchFields,
    PatchStep, Room,
};
use crate::fem::{Patch, Space};
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{self, Iteration};

/// B(φ) = ∫ (ε/2 |∇φ|² + F(φ)/ε), for nodal values of φ: 2√2/3 times the length of the membrane for
/// a tanh profile.
pub fn surface_area(space: &Space, phi: &[f64], width: f64) -> f64 {
    let mut sample = PatchFields::new(false);
    let share = |patch: Patch<'_>| {
        sample.set_phi(&patch, phi);
        area_integral(&patch, &sample, width)
    };
    space.patches().map(share).sum()
}

/// The patch's share of B(φ).
pub fn area_integral(patch: &Patch<'_>, at: &PatchFields, width: f64) -> f64 {
    let squares = patch.integrate_elements_of(at.phi_gradient.iter().map(Vector::norm_squared));
    0.5 * width * squares + patch.integrate_of(&at.phi, double_well) / width
}

/// The effect, where the scene has it.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let EffectContext {
        scene,
        initial_area,
        ..
    } = *context;
    let area = scene.area.as_ref()?;
    let width = scene.membrane.interface_width;
    Some(Box::new(Area::new(area, width, initial_area)))
}

/// The penalty of the surface area.
#[derive(Debug)]
pub struct Area {
    interface_width: f64,
    penalty: f64,
    target: f64,
    /// (1/η)((B(φ) + B(φⁿ))/2 − β): the tension that the penalty puts on the membrane.
    tension: f64,
    /// The tension as an unknown of its own, for the derivative: that to which Newton's corrections
    /// have led, and that to which the last one leads if it is taken whole.
    followed: Option<f64>,
    corrected: f64,
}

impl Area {
    /// η of a scene, and β as its fraction of B(φ⁰).
    pub fn new(area: &scene::Area, interface_width: f64, initial_area: f64) -> Self {
        Self {
            interface_width,
            penalty: area.penalty,
            target: area.target * initial_area,
            tension: 0.0,
            followed: None,
            corrected: 0.0,
        }
    }
}

impl Effect for Area {
    fn name(&self) -> &'static str {
        "area"
    }

    /// B.
    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        area_integral(patch, at, self.interface_width)
    }

    fn energy(&self, area: f64) -> f64 {
        let excess = area - self.target;
        excess * excess / (2.0 * self.penalty)
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    fn needs_integrals(&self) -> bool {
        true
    }

    fn set_integrals(&mut self, old: f64, new: f64) {
        self.tension = (0.5 * (old + new) - self.target) / self.penalty;
    }

    fn newton_correction(&mut self, along: f64) {
        self.corrected = self.tension + 0.5 / self.penalty * along;
        self.followed.get_or_insert(self.tension);
    }

    fn accept_correction(&mut self, part: f64) {
        self.followed = match self.followed {
            Some(followed) if part > 0.0 => Some(followed + part * (self.corrected - followed)),
            _ => None,
        };
    }

    /// tension · [ε/2 (∇(φ + φⁿ), ∇ψ) + (1/ε)(F_sec, ψ)]: the bracket is an exact secant of B, so
    /// this effect has no numerical dissipation.
    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let (old, new) = (step.old, step.new);
        let tension = self.tension;
        let (along, across) = (
            0.5 * self.interface_width * tension,
            tension / self.interface_width,
        );
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        for (flux, (new, old)) in force.flux.iter_mut().zip(gradients) {
            *flux += along * (new + old);
        }
        let terms = force.load.iter_mut().zip(new.phi.iter().zip(&old.phi));
        terms.for_each(|(load, (new, old))| *load += across * double_well_secant(*new, *old));
    }

    /// The derivative of the bracket.
    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (old, new) = (step.old, step.new);
        let width = self.interface_width;
        let tension = match iteration {
            Iteration::Newton => self.followed.unwrap_or(self.tension),
            Iteration::Lagged => self.tension,
        };
        let (along, across) = (0.5 * width * tension, tension / width);
        for tensor in &mut jacobian.tensor {
            *tensor += SymmetricTensor::isotropic(along);
        }
        let values = new.phi.iter().zip(&old.phi);
        let terms = jacobian.reaction.iter_mut().zip(values);
        terms.for_each(|(reaction, (new, old))| {
            *reaction += across * double_well_secant_derivative(*new, *old);
        });
    }

    /// With Newton's method that of the tension too: 1/(2η) · bracket ⊗ B'(φ).
    fn rank_one(&self, iteration: Iteration) -> Option<f64> {
        (iteration == Iteration::Newton).then_some(0.5 / self.penalty)
    }

    fn add_rank_one(
        &self,
        step: &PatchStep<'_>,
        column: &mut MembraneForce,
        row: &mut MembraneForce,
    ) {
        let (old, new, width) = (step.old, step.new, self.interface_width);
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let fluxes = column.flux.iter_mut().zip(&mut row.flux);
        for ((column, row), (new, old)) in fluxes.zip(gradients) {
            *column += 0.5 * width * (new + old);
            *row += width * new;
        }
        let values = new.phi.iter().zip(&old.phi);
        let loads = column.load.iter_mut().zip(&mut row.load);
        for ((column, row), (new, old)) in loads.zip(values) {
            *column += double_well_secant(*new, *old) / width;
            *row += double_well_derivative(*new) / width;
        }
    }
}
