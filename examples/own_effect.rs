//! An effect of one's own, added to a scheme: a line tension ½ σ ∫ |∇φ|², whose energy and dissipation then stand in
//! the report of every step, and with which the energy law closes.
//!
//!     cargo run --release --example own_effect

use vesica::{
    DirectorCoupling, Effect, Iteration, Kept, LedgerTerms, MembraneForce, MembraneJacobian, Mesh,
    Patch, PatchFields, PatchStep, Room, Scene, Scheme, SymmetricTensor, Vector, initial_fields,
};

/// A line tension.
#[derive(Debug)]
pub struct Tension {
    /// σ.
    pub weight: f64,
}

impl Effect for Tension {
    fn name(&self) -> &'static str {
        "tension"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        let squares = at.phi_gradient.iter().map(Vector::norm_squared);
        0.5 * self.weight * patch.integrate_elements_of(squares)
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let (old, new, scheme) = (step.old, step.new, step.scheme);
        let gradients = old.phi_gradient.iter().zip(&new.phi_gradient);
        for (flux, (old, new)) in force.flux.iter_mut().zip(gradients) {
            *flux += self.weight * scheme.implicit(*old, *new);
        }
    }

    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        _: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        for tensor in &mut jacobian.tensor {
            *tensor += SymmetricTensor::isotropic(step.scheme.weight() * self.weight);
        }
    }

    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        terms: &mut LedgerTerms,
        _: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let gradients = new.phi_gradient.iter().zip(&old.phi_gradient);
        let squares = gradients.map(|(new, old)| (new - old).norm_squared());
        let loss = patch.integrate_elements_of(squares);
        terms.add("ND_tension", 0.5 * self.weight * loss);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = "mesh.cells = 32\nmembrane.interface_width = 0.03\n[time]\nstep = 1e-7\n[area]";
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, "the example", &[], &mut no_files)?;
    let mesh = Mesh::of(&scene)?;
    let initial = initial_fields(&scene, &mesh)?;
    let mut scheme = Scheme::new(&scene, mesh, initial.phi, initial.director)?;
    scheme.add_effect(Tension { weight: 0.5 });
    for step in 1..=10 {
        let report = scheme.step(1e-7)?;
        let energies = report.energies.iter();
        let energies: Vec<String> = energies
            .map(|energy| format!("{} {:.4}", energy.name, energy.value))
            .collect();
        println!(
            "step {step}: {}; residual of the energy law {:.0e}",
            energies.join(", "),
            report.law_residual
        );
    }
    Ok(())
}
