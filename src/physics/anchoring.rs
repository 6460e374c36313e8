//! The anchoring energy λ_anch E_anch = λ_anch/2 ∫ (δ1 |d|²|∇φ|² + δ2 (d·∇φ)²): with (δ1, δ2) =
//! (0, 1) the director prefers to lie along the membrane, with (1, −1) across it.

use super::{
    DirectorCoupling, DirectorForm, Effect, EffectContext, LedgerTerms, MembraneForce,
    MembraneJacobian, PatchFields, PatchStep,
};
use crate::fem::{Patch, Space};
use crate::geometry::{SymmetricTensor, Vector};
use crate::scene::{self, AnchoringKind, Iteration};

/// What the anchoring is called in a report.
pub(super) const NAME: &str = "anchoring";

/// The effect, where the scene has it; the kind "none" is no effect.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let anchoring = context.scene.anchoring.as_ref()?;
    let is_one = anchoring.kind != AnchoringKind::None;
    is_one.then(|| Box::new(Anchoring::new(anchoring, context.space)) as Box<dyn Effect>)
}

/// The anchoring energy.
#[derive(Debug)]
pub struct Anchoring {
    weight: f64,
    /// δ1 and δ2.
    preference: [f64; 2],
    /// λ_anch (δ1 |d|² + δ2 d⊗d) of the new director, averaged over each triangle of the space.
    tensors: Vec<SymmetricTensor>,
    /// The same of another field, on a patch.
    other_tensors: Vec<SymmetricTensor>,
    /// d − dⁿ at the nodes.
    steps: [Vec<f64>; 2],
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
            tensors: vec![SymmetricTensor::default(); space.elements()],
            other_tensors: Vec::new(),
            steps: [Vec::new(), Vec::new()],
        }
    }

    /// tensors ← λ_anch (δ1 |v|² + δ2 v⊗v) averaged over each triangle, for a P1 vector field v given
    /// at the nodes.
    fn fill(&self, patch: &Patch<'_>, field: &[Vec<f64>; 2], tensors: &mut [SymmetricTensor]) {
        let [x, y] = field;
        patch.mean_squares([x, y], tensors);
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for tensor in tensors {
            *tensor = SymmetricTensor::isotropic(isotropic * tensor.trace()) + along * *tensor;
        }
    }

    /// The energy of a P1 vector field in a given gradient.
    fn energy_of(&mut self, patch: &Patch<'_>, field: &[Vec<f64>; 2], gradient: &[Vector]) -> f64 {
        let mut tensors = std::mem::take(&mut self.other_tensors);
        tensors.resize(patch.elements(), SymmetricTensor::default());
        self.fill(patch, field, &mut tensors);
        let energy = patch.tensor_energy(&tensors, gradient.iter().copied());
        self.other_tensors = tensors;
        energy
    }
}

impl Effect for Anchoring {
    fn name(&self) -> &'static str {
        NAME
    }

    fn integral(&mut self, patch: &Patch<'_>, at: &PatchFields) -> f64 {
        match &at.director {
            Some(director) => self.energy_of(patch, &director.nodal, &at.phi_gradient),
            None => 0.0,
        }
    }

    /// λ_anch |∇φ|²: both kinds have the eigenvalues 0 and |∇φ|².
    fn director_coupling(&self) -> Option<DirectorCoupling> {
        let at_membrane = self.weight;
        Some(DirectorCoupling {
            at_membrane,
            ..DirectorCoupling::NONE
        })
    }

    /// λ_anch (δ1 |∇φⁿ|² d + δ2 (d·∇φⁿ) ∇φⁿ, e), linear in d.
    fn add_director_force(&mut self, step: &PatchStep<'_>, form: &mut DirectorForm) {
        let old = step.old;
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for (tensor, gradient) in form.tensor.iter_mut().zip(&old.phi_gradient) {
            *tensor += SymmetricTensor::isotropic(isotropic * gradient.norm_squared())
                + SymmetricTensor::outer(along, *gradient);
        }
        form.has_tensor = true;
    }

    fn begin_membrane(&mut self, step: &PatchStep<'_>) {
        let (patch, new) = (step.patch, step.new);
        if let Some(director) = &new.director {
            let mut tensors = std::mem::take(&mut self.tensors);
            self.fill(patch, &director.nodal, &mut tensors[patch.element_range()]);
            self.tensors = tensors;
        }
    }

    /// λ_anch (δ1|d|²∇φ + δ2 (d·∇φ) d, ∇ψ) at φ_θ. (The paper's (2.11) has the divergence of this with the
    /// wrong sign; (3.21) has it right.)
    fn add_membrane_force(&mut self, step: &PatchStep<'_>, force: &mut MembraneForce) {
        let (patch, old, new, scheme) = (step.patch, step.old, step.new, step.scheme);
        let tensors = &self.tensors[patch.element_range()];
        let gradients = old.phi_gradient.iter().zip(&new.phi_gradient);
        for (flux, (tensor, (old, new))) in force.flux.iter_mut().zip(tensors.iter().zip(gradients))
        {
            *flux += *tensor * scheme.implicit(*old, *new);
        }
    }

    fn add_membrane_jacobian(
        &mut self,
        step: &PatchStep<'_>,
        _iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (patch, scheme) = (step.patch, step.scheme);
        let tensors = &self.tensors[patch.element_range()];
        for (sum, tensor) in jacobian.tensor.iter_mut().zip(tensors) {
            *sum += scheme.weight() * *tensor;
        }
    }

    /// Δt ND_anch = λ_anch/2 ∫ (δ1(|δ|²|∇φⁿ|² + |d|²|∇(φ − φⁿ)|²) + δ2((δ·∇φⁿ)² + (d·∇(φ − φⁿ))²))
    /// with δ = d − dⁿ.
    fn add_dissipation(&mut self, step: &PatchStep<'_>, terms: &mut LedgerTerms) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let (Some(old_director), Some(new_director)) = (&old.director, &new.director) else {
            return;
        };
        let mut steps = std::mem::take(&mut self.steps);
        if patch.is_first() {
            for (axis, steps) in steps.iter_mut().enumerate() {
                let nodes = new_director.nodal[axis]
                    .iter()
                    .zip(&old_director.nodal[axis]);
                steps.clear();
                steps.extend(nodes.map(|(new, old)| new - old));
            }
        }
        let of_director = self.energy_of(patch, &steps, &old.phi_gradient);
        self.steps = steps;
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let tensors = &self.tensors[patch.element_range()];
        let of_membrane = patch.tensor_energy(tensors, gradients.map(|(new, old)| new - old));
        terms.add("ND_anch", of_director + of_membrane);
    }
}
