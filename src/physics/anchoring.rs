//! The anchoring energy λ_anch E_anch = λ_anch/2 ∫ (δ1 |d|²|∇φ|² + δ2 (d·∇φ)²): with (δ1, δ2) =
//! (0, 1) the director prefers to lie along the membrane, with (1, −1) across it.

use super::{
    DirectorForm, DirectorSample, Effect, MembraneForce, MembraneLinearisation, NamedValue, Sample,
};
use crate::fem::{Space, SymmetricTensor};
use crate::scene::{self, AnchoringKind, Iteration};

/// What the anchoring is called in a report.
pub(super) const NAME: &str = "anchoring";

/// The anchoring energy.
#[derive(Debug)]
pub struct Anchoring {
    weight: f64,
    /// δ1 and δ2.
    preference: [f64; 2],
    /// λ_anch (δ1 |d|² + δ2 d⊗d) of a director, averaged over each triangle.
    tensors: Vec<SymmetricTensor>,
    other_tensors: Vec<SymmetricTensor>,
    /// d − dⁿ at the nodes.
    steps: [Vec<f64>; 2],
    differences: Vec<[f64; 2]>,
}

impl Anchoring {
    /// λ_anch and (δ1, δ2) of a scene.
    pub fn new(anchoring: &scene::Anchoring, space: &Space) -> Self {
        Self {
            weight: anchoring.weight,
            preference: match anchoring.kind {
                AnchoringKind::None => [0.0, 0.0],
                AnchoringKind::Parallel => [0.0, 1.0],
                AnchoringKind::Homeotropic => [1.0, -1.0],
            },
            tensors: vec![[0.0; 3]; space.elements()],
            other_tensors: vec![[0.0; 3]; space.elements()],
            steps: [vec![0.0; space.nodes()], vec![0.0; space.nodes()]],
            differences: vec![[0.0; 2]; space.elements()],
        }
    }

    /// other_tensors ← λ_anch (δ1 |v|² + δ2 v⊗v) averaged over each triangle, for a P1 vector field.
    fn fill_other_tensors(&mut self, space: &Space, field: [&[f64]; 2]) {
        space.mean_squares(field, &mut self.other_tensors);
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for [xx, xy, yy] in &mut self.other_tensors {
            let square = isotropic * (*xx + *yy);
            (*xx, *xy, *yy) = (square + along * *xx, along * *xy, square + along * *yy);
        }
    }

    fn fill_from_director(&mut self, space: &Space, director: &DirectorSample) {
        let [x, y] = &director.nodal;
        self.fill_other_tensors(space, [x, y]);
    }
}

impl Effect for Anchoring {
    fn name(&self) -> &'static str {
        NAME
    }

    fn energy(&mut self, space: &Space, at: &Sample) -> f64 {
        let Some(director) = &at.director else {
            return 0.0;
        };
        self.fill_from_director(space, director);
        space.tensor_energy(&self.other_tensors, &at.phi_gradient)
    }

    /// λ_anch (δ1 |∇φⁿ|² d + δ2 (d·∇φⁿ) ∇φⁿ, e), linear in d.
    fn add_director_force(&mut self, _space: &Space, old: &Sample, form: &mut DirectorForm) {
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        let [xx, xy, yy] = &mut form.tensor;
        let entries = xx.iter_mut().zip(xy).zip(yy).zip(&old.phi_gradient);
        for (((xx, xy), yy), [x, y]) in entries {
            let square = isotropic * (x * x + y * y);
            *xx += square + along * x * x;
            *xy += along * x * y;
            *yy += square + along * y * y;
        }
        form.has_tensor = true;
    }

    fn begin_membrane(&mut self, space: &Space, _old: &Sample, new: &Sample) {
        if let Some(director) = &new.director {
            self.fill_from_director(space, director);
            std::mem::swap(&mut self.tensors, &mut self.other_tensors);
        }
    }

    /// λ_anch (δ1|d|²∇φ + δ2 (d·∇φ) d, ∇ψ). (The paper's (2.11) has the divergence of this with the
    /// wrong sign; (3.21) has it right.)
    fn add_membrane_force(
        &mut self,
        _space: &Space,
        _old: &Sample,
        new: &Sample,
        force: &mut MembraneForce,
    ) {
        let values = self.tensors.iter().zip(&new.phi_gradient);
        for (flux, ([xx, xy, yy], [x, y])) in force.flux.iter_mut().zip(values) {
            flux[0] += xx * x + xy * y;
            flux[1] += xy * x + yy * y;
        }
    }

    fn add_membrane_linearisation(
        &mut self,
        _space: &Space,
        _old: &Sample,
        _new: &Sample,
        _iteration: Iteration,
        linearisation: &mut MembraneLinearisation,
    ) {
        for (sum, tensor) in linearisation.tensor.iter_mut().zip(&self.tensors) {
            for (sum, entry) in sum.iter_mut().zip(tensor) {
                *sum += entry;
            }
        }
    }

    /// Δt ND_anch = λ_anch/2 ∫ (δ1(|δ|²|∇φⁿ|² + |d|²|∇(φ − φⁿ)|²) + δ2((δ·∇φⁿ)² + (d·∇(φ − φⁿ))²))
    /// with δ = d − dⁿ.
    fn dissipation(
        &mut self,
        space: &Space,
        old: &Sample,
        new: &Sample,
        terms: &mut Vec<NamedValue>,
    ) {
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return;
        };
        for axis in 0..2 {
            let nodes = new_director.nodal[axis]
                .iter()
                .zip(&old_director.nodal[axis]);
            for (step, (new, old)) in self.steps[axis].iter_mut().zip(nodes) {
                *step = new - old;
            }
        }
        let steps = std::mem::take(&mut self.steps);
        self.fill_other_tensors(space, [&steps[0], &steps[1]]);
        self.steps = steps;
        let of_director = space.tensor_energy(&self.other_tensors, &old.phi_gradient);
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        for (difference, (new, old)) in self.differences.iter_mut().zip(gradients) {
            *difference = [new[0] - old[0], new[1] - old[1]];
        }
        let of_membrane = space.tensor_energy(&self.tensors, &self.differences);
        terms.push(NamedValue {
            name: "ND_anch",
            value: of_director + of_membrane,
        });
    }
}
