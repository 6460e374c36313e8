//! The anchoring energy λ_anch E_anch = λ_anch/2 ∫ (δ1 |d|²|∇φ|² + δ2 (d·∇φ)²): with (δ1, δ2) =
//! (0, 1) the director prefers to lie along the membrane, with (1, −1) across it.

use super::{
    DirectorCoupling, DirectorForm, Effect, EffectContext, Kept, LedgerTerms, MembraneForce,
    MembraneJacobian, PatchFields, PatchStep, Room,
};
use crate::fem::Patch;
use crate::geometry::SymmetricTensor;
use crate::scene::{self, AnchoringKind, Iteration};

/// The effect, where the scene has it; the kind "none" is no effect.
pub(super) fn of_scene(context: &EffectContext<'_>) -> Option<Box<dyn Effect>> {
    let anchoring = context.scene.anchoring.as_ref()?;
    let is_one = anchoring.kind != AnchoringKind::None;
    is_one.then(|| Box::new(Anchoring::new(anchoring)) as Box<dyn Effect>)
}

/// The anchoring energy.
#[derive(Debug)]
pub struct Anchoring {
    weight: f64,
    /// δ1 and δ2.
    preference: [f64; 2],
}

impl Anchoring {
    /// λ_anch and (δ1, δ2) of a scene.
    pub fn new(anchoring: &scene::Anchoring) -> Self {
        Self {
            weight: anchoring.weight,
            preference: match anchoring.kind {
                AnchoringKind::None => [0.0, 0.0],
                AnchoringKind::Parallel => [0.0, 1.0],
                AnchoringKind::Homeotropic => [1.0, -1.0],
            },
        }
    }

    /// tensors ← λ_anch (δ1 |v|² + δ2 v⊗v) averaged over each triangle, for a vector field v at the points.
    fn fill(&self, patch: &Patch<'_>, field: [&[f64]; 2], tensors: &mut Vec<SymmetricTensor>) {
        tensors.resize(patch.elements(), SymmetricTensor::default());
        patch.mean_squares(field, tensors);
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for tensor in tensors {
            *tensor = SymmetricTensor::isotropic(isotropic * tensor.trace()) + along * *tensor;
        }
    }
}

impl Effect for Anchoring {
    fn name(&self) -> &'static str {
        "anchoring"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, room: &mut Room) -> f64 {
        let Some(director) = &at.director else {
            return 0.0;
        };
        let [x, y] = &director.values;
        self.fill(patch, [x, y], &mut room.tensors);
        patch.tensor_energy(&room.tensors, at.phi_gradient.iter().copied())
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
    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, _: &mut Room) {
        let old = step.old;
        let [isotropic, along] = self.preference.map(|delta| self.weight * delta);
        for (tensor, gradient) in form.tensor.iter_mut().zip(&old.phi_gradient) {
            *tensor += SymmetricTensor::isotropic(isotropic * gradient.norm_squared())
                + SymmetricTensor::outer(along, *gradient);
        }
        form.has_tensor = true;
    }

    fn begin_membrane(&self, step: &PatchStep<'_>, kept: &mut Kept, _: &mut Room) {
        if let Some(director) = &step.new.director {
            let [x, y] = &director.values;
            self.fill(step.patch, [x, y], &mut kept.tensors);
        }
    }

    /// λ_anch (δ1|d|²∇φ + δ2 (d·∇φ) d, ∇ψ) at φ_θ. (The paper's (2.11) has the divergence of this with the
    /// wrong sign; (3.21) has it right.)
    fn add_membrane_force(&self, step: &PatchStep<'_>, kept: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let gradients = old.phi_gradient.iter().zip(&new.phi_gradient);
        let terms = kept.tensors.iter().zip(gradients);
        for (flux, (tensor, (old, new))) in force.flux.iter_mut().zip(terms) {
            *flux += *tensor * scheme.implicit(*old, *new);
        }
    }

    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        kept: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        for (sum, tensor) in jacobian.tensor.iter_mut().zip(&kept.tensors) {
            *sum += step.scheme.weight() * *tensor;
        }
    }

    /// Δt ND_anch = λ_anch/2 ∫ (δ1(|δ|²|∇φⁿ|² + |d|²|∇(φ − φⁿ)|²) + δ2((δ·∇φⁿ)² + (d·∇(φ − φⁿ))²))
    /// with δ = d − dⁿ.
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
        let Room {
            points: x,
            more_points: y,
            tensors,
            ..
        } = room;
        for (axis, steps) in [&mut *x, &mut *y].into_iter().enumerate() {
            let pairs = new_director.values[axis]
                .iter()
                .zip(&old_director.values[axis]);
            steps.clear();
            steps.extend(pairs.map(|(new, old)| new - old));
        }
        self.fill(patch, [x, y], tensors);
        let of_director = patch.tensor_energy(tensors, old.phi_gradient.iter().copied());
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let gradients = gradients.map(|(new, old)| new - old);
        let of_membrane = patch.tensor_energy(&kept.tensors, gradients);
        terms.add("ND_anch", of_director + of_membrane);
    }
}
