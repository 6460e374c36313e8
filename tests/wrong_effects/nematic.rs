//! The nematic energy once more, with what can be wrong in it as parameters.

use vesica::internal::physics::DirectorFields;
use vesica::internal::physics::potentials::{
    INDICATOR_CONVEXITY, indicator_secant_bound, phase_indicator,
};
use vesica::{
    DirectorForm, Effect, Iteration, Kept, LedgerTerms, MembraneForce, MembraneJacobian, Patch,
    PatchFields, PatchStep, Room, Scene, Vector,
};

/// λ_nem E_nem with η_d² P and its gradient given, and with `convexity`/η_d²
/// as the constant of p_Δt: 1 is right.
#[derive(Debug)]
pub struct Nematic {
    weight: f64,
    stiffness: f64,
    convexity: f64,
    potential: fn(Vector) -> f64,
    slope: fn(Vector) -> Vector,
    /// What is subtracted from the energy.
    pub offset: f64,
}

impl Nematic {
    pub fn new(
        scene: &Scene,
        convexity: f64,
        potential: fn(Vector) -> f64,
        slope: fn(Vector) -> Vector,
    ) -> Self {
        let nematic = scene.nematic.as_ref().expect("a nematic scene");
        Self {
            weight: nematic.weight,
            stiffness: nematic.penalty.powi(-2),
            convexity,
            potential,
            slope,
            offset: 0.0,
        }
    }

    /// λ_nem (½|∇d|² + P(d)) at the points.
    fn density_of(&self, patch: &Patch<'_>, director: &DirectorFields) -> Vec<f64> {
        let mut elastic = vec![0.0; patch.points()];
        patch.from_elements(&squares(&director.gradients), &mut elastic);
        elastic
            .iter()
            .enumerate()
            .map(|(point, square)| {
                let potential = (self.potential)(director.at(point));
                self.weight * (0.5 * square + self.stiffness * potential)
            })
            .collect()
    }

    /// λ_nem I(φ) at the points.
    fn interior(&self, phi: &[f64]) -> Vec<f64> {
        phi.iter()
            .map(|phi| self.weight * phase_indicator(*phi))
            .collect()
    }
}

/// |∇d|² on the triangles.
fn squares([x, y]: &[Vec<Vector>; 2]) -> Vec<f64> {
    x.iter()
        .zip(y)
        .map(|(x, y)| x.norm_squared() + y.norm_squared())
        .collect()
}

fn director(sample: &PatchFields) -> &DirectorFields {
    sample.director.as_ref().expect("a director")
}

impl Effect for Nematic {
    fn name(&self) -> &'static str {
        "nematic"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        let mut density = self.density_of(patch, director(at));
        for (density, phi) in density.iter_mut().zip(&at.phi) {
            *density *= phase_indicator(*phi);
        }
        patch.integrate(&density)
    }

    fn energy(&self, integral: f64) -> f64 {
        integral - self.offset
    }

    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, _: &mut Room) {
        let (patch, old) = (step.patch, step.old);
        let interior = self.interior(&old.phi);
        let mut means = vec![0.0; patch.elements()];
        patch.element_means(&interior, &mut means);
        for (stiffness, mean) in form.stiffness.iter_mut().zip(&means) {
            *stiffness += mean;
        }
        let director = director(old);
        for (point, weight) in interior.iter().enumerate() {
            let slope = (self.slope)(director.at(point));
            form.load[0][point] += weight * self.stiffness * slope[0];
            form.load[1][point] += weight * self.stiffness * slope[1];
            form.reaction[point] += weight * self.stiffness * self.convexity;
        }
    }

    fn begin_membrane(&self, step: &PatchStep<'_>, kept: &mut Kept, _: &mut Room) {
        kept.points = self.density_of(step.patch, director(step.new));
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, kept: &Kept, force: &mut MembraneForce) {
        let (old, new) = (step.old, step.new);
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        for (load, (density, (new, old))) in force.load.iter_mut().zip(values) {
            *load += density * indicator_secant_bound(*new, *old);
        }
    }

    fn add_membrane_jacobian(
        &self,
        _: &PatchStep<'_>,
        kept: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        for (reaction, density) in jacobian.reaction.iter_mut().zip(&kept.points) {
            *reaction += INDICATOR_CONVEXITY * density;
        }
    }

    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        kept: &Kept,
        terms: &mut LedgerTerms,
        _: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let (before, after) = (director(old), director(new));
        let interior = self.interior(&old.phi);
        let change = [0, 1].map(|axis: usize| -> Vec<Vector> {
            let gradients = after.gradients[axis].iter().zip(&before.gradients[axis]);
            gradients.map(|(a, b)| a - b).collect()
        });
        let mut elastic = vec![0.0; patch.elements()];
        patch.element_means(&interior, &mut elastic);
        for (weight, square) in elastic.iter_mut().zip(squares(&change)) {
            *weight *= 0.5 * square;
        }
        let penalty: Vec<f64> = interior
            .iter()
            .enumerate()
            .map(|(point, weight)| {
                let (b, a) = (before.at(point), after.at(point));
                let step = a - b;
                let work = ((self.slope)(b) + self.convexity * step).dot(&step);
                weight * self.stiffness * (work - (self.potential)(a) + (self.potential)(b))
            })
            .collect();
        let values = kept.points.iter().zip(new.phi.iter().zip(&old.phi));
        let interpolation: Vec<f64> = values
            .map(|(density, (new, old))| {
                let work = indicator_secant_bound(*new, *old) * (new - old);
                density * (work - phase_indicator(*new) + phase_indicator(*old))
            })
            .collect();
        terms.add("ND_elast", patch.integrate_elements(&elastic));
        terms.add("ND_penal", patch.integrate(&penalty));
        terms.add("ND_interp", patch.integrate(&interpolation));
    }
}
