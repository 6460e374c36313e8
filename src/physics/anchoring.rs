//! The anchoring energy λ_anch E_anch = λ_anch/2 ∫ (δ1 |d|²|∇φ|² + δ2 (d·∇φ)²): with (δ1, δ2) =
//! (0, 1) the director prefers to lie along the membrane, with (1, −1) across it.

use super::{
    DirectorForm, DirectorSample, Effect, MembraneForce, MembraneLinearisation, NamedValue, Sample,
};
use crate::fem::{Space, SymmetricTensor};
use crate::scene::{self, AnchoringKind, Iteration};

/// The anchoring energy.
#[derive(Debug)]
pub struct Anchoring {
    weight: f64,
    /// δ1 and δ2.
    preference: [f64; 2],
    /// λ_anch (δ1 |d|² + δ2 d⊗d) of a director, averaged over each triangle.
    tensors: Vec<SymmetricTensor>,
    other_tensors: Vec<SymmetricTensor>,
    points: Vec<f64>,
    elements: Vec<f64>,
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
            points: vec![0.0; space.points()],
            elements: vec![0.0; space.elements()],
            differences: vec![[0.0; 2]; space.elements()],
        }
    }

    /// other_tensors ← λ_anch (δ1 |v|² + δ2 v⊗v) averaged over each triangle, for a vector field v
    /// at the points.
    fn fill_other_tensors(&mut self, space: &Space, v: impl Fn(usize) -> [f64; 2]) {
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for entry in 0..3 {
            for (point, value) in self.points.iter_mut().enumerate() {
                let [x, y] = v(point);
                let square = isotropic * (x * x + y * y);
                *value = match entry {
                    0 => square + along * x * x,
                    1 => along * x * y,
                    _ => square + along * y * y,
                };
            }
            space.element_means(&self.points, &mut self.elements);
            for (tensor, mean) in self.other_tensors.iter_mut().zip(&self.elements) {
                tensor[entry] = *mean;
            }
        }
    }

    fn fill_from_director(&mut self, space: &Space, director: &DirectorSample) {
        let [x, y] = &director.values;
        self.fill_other_tensors(space, |point| [x[point], y[point]]);
    }
}

impl Effect for Anchoring {
    fn name(&self) -> &'static str {
        "anchoring"
    }

    fn energy(&mut self, space: &Space, at: &Sample) -> f64 {
        let Some(director) = &at.director else {
            return 0.0;
        };
        self.fill_from_director(space, director);
        space.tensor_energy(&self.other_tensors, &at.phi_gradient)
    }

    /// λ_anch (δ1 |∇φⁿ|² d + δ2 (d·∇φⁿ) ∇φⁿ, e), linear in d.
    fn add_director_force(&mut self, space: &Space, old: &Sample, form: &mut DirectorForm) {
        let Some(director) = &old.director else {
            return;
        };
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        let [x, y] = &director.values;
        for entry in 0..3 {
            for (value, gradient) in self.elements.iter_mut().zip(&old.phi_gradient) {
                let square = isotropic * (gradient[0] * gradient[0] + gradient[1] * gradient[1]);
                *value = match entry {
                    0 => square + along * gradient[0] * gradient[0],
                    1 => along * gradient[0] * gradient[1],
                    _ => square + along * gradient[1] * gradient[1],
                };
            }
            space.from_elements(&self.elements, &mut self.points);
            let [load_x, load_y] = &mut form.load;
            let reaction = &mut form.reaction[entry];
            for (point, value) in self.points.iter().enumerate() {
                reaction[point] += value;
                match entry {
                    0 => load_x[point] += value * x[point],
                    1 => {
                        load_x[point] += value * y[point];
                        load_y[point] += value * x[point];
                    }
                    _ => load_y[point] += value * y[point],
                }
            }
        }
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
        let difference = |axis: usize, point: usize| {
            new_director.values[axis][point] - old_director.values[axis][point]
        };
        self.fill_other_tensors(space, |point| [difference(0, point), difference(1, point)]);
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
