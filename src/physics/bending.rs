//! The bending energy E_ben = ε/2 ∫ ω² with ω = −Δφ + G(φ)/ε² (2.2), and the spontaneous curvature
//! k(x) in G.
//!
//! ω is an unknown of the scheme, tied to φ by the third equation of (3.21),
//!   ε(ω, χ) = ε(∇φ, ∇χ) + (1/ε)(G(φ), χ),
//! so the force of this effect is (∇ω, G_sec ω) and its share of the energy law needs that equation
//! at both times: with χ = ω,
//!   E_ben(ω) − E_ben(ωⁿ) = ε(∇(φ − φⁿ), ∇ω) + (1/ε)(G_sec (φ − φⁿ), ω) − ε/2 ‖ω − ωⁿ‖².

use super::patch_fields::at_points;
use super::potentials::{
    bending_derivative, bending_secant, bending_secant_derivative, bending_tangent,
};
use super::{
    DirectorCoupling, Effect, Kept, LedgerTerms, MembraneForce, MembraneJacobian, PatchFields,
    PatchStep, Room,
};
use crate::fem::{Patch, Space};
use crate::scene::{Iteration, Membrane, ScalarField};

/// ε/2 ω², whose integral is E_ben.
pub fn bending_energy_density(interface_width: f64, omega: f64) -> f64 {
    0.5 * interface_width * omega * omega
}

/// The bending energy of a membrane.
#[derive(Debug)]
pub struct Bending {
    interface_width: f64,
    /// ε k at the points; `None` where k = 0 everywhere.
    curved: Option<Vec<f64>>,
    /// What stands for G_sec(φ, φⁿ, ε k) in tests of a wrong one.
    #[cfg(test)]
    wrong_secant: Option<fn(f64, f64, f64) -> f64>,
}

impl Bending {
    /// ε and k(x) of a scene; a formula for k is taken at the quadrature points, nodal values are
    /// interpolated there.
    pub fn new(membrane: &Membrane, space: &Space) -> Self {
        let width = membrane.interface_width;
        let curvature = &membrane.spontaneous_curvature;
        let curved = (*curvature != ScalarField::Constant(0.0)).then(|| {
            let mut curved = at_points(curvature, space);
            curved.iter_mut().for_each(|k| *k *= width);
            curved
        });
        Self {
            interface_width: width,
            curved: curved.filter(|curved| curved.iter().any(|k| *k != 0.0)),
            #[cfg(test)]
            wrong_secant: None,
        }
    }

    /// Replaces G_sec: for tests of what a wrong one does.
    #[cfg(test)]
    pub(crate) fn set_secant(&mut self, secant: fn(f64, f64, f64) -> f64) {
        self.wrong_secant = Some(secant);
    }
    /// Calls f(point, ε k, out) for every point of a patch.
    #[inline(always)]
    fn at_points(
        curved: &Option<Vec<f64>>,
        patch: &Patch<'_>,
        out: &mut [f64],
        f: impl Fn(usize, f64, &mut f64),
    ) {
        match curved {
            None => {
                for (point, out) in out.iter_mut().enumerate() {
                    f(point, 0.0, out);
                }
            }
            Some(curved) => {
                let curved = &curved[patch.point_range()];
                for (point, (out, curved)) in out.iter_mut().zip(curved).enumerate() {
                    f(point, *curved, out);
                }
            }
        }
    }

    /// density ← (1/ε²) G(φ) at the points: with ∇φ as the flux it makes the load that (ω, χ) must equal,
    /// (∇φ, ∇χ) + (1/ε²)(G(φ), χ).
    pub fn omega_density(&self, patch: &Patch<'_>, at: &PatchFields, density: &mut Vec<f64>) {
        let scale = (self.interface_width * self.interface_width).recip();
        density.resize(patch.points(), 0.0);
        let phi = &at.phi[..density.len()];
        Self::at_points(&self.curved, patch, density, |point, curved, out| {
            *out = scale * bending_derivative(phi[point], curved);
        });
    }

    /// (1/ε) G_sec at the points: how ω acts in the second equation.
    pub fn secant(&self, step: &PatchStep<'_>, out: &mut Vec<f64>) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let scale = self.interface_width.recip();
        out.resize(patch.points(), 0.0);
        let (phi, phi_old) = (&new.phi[..out.len()], &old.phi[..out.len()]);
        Self::at_points(&self.curved, patch, out, |point, curved, out| {
            *out = scale * bending_secant(phi[point], phi_old[point], curved);
        });
    }

    /// (1/ε) G'(φ) at the points: how φ acts in the linearised third equation.
    pub fn tangent(&self, patch: &Patch<'_>, new: &PatchFields, out: &mut Vec<f64>) {
        let scale = self.interface_width.recip();
        out.resize(patch.points(), 0.0);
        let phi = &new.phi[..out.len()];
        Self::at_points(&self.curved, patch, out, |point, curved, out| {
            *out = scale * bending_tangent(phi[point], curved);
        });
    }
}

impl Effect for Bending {
    fn name(&self) -> &'static str {
        "bending"
    }

    fn integral(&self, patch: &Patch<'_>, at: &PatchFields, _: &mut Room) -> f64 {
        0.5 * self.interface_width * patch.integrate_of(&at.omega, |omega| omega * omega)
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let points = patch.points();
        let (phi, phi_old) = (&new.phi[..points], &old.phi[..points]);
        let omega = &new.omega[..points];
        let scale = self.interface_width.recip();
        let load = &mut force.load;
        #[cfg(test)]
        if let Some(wrong) = self.wrong_secant {
            Self::at_points(&self.curved, patch, load, |point, curved, load| {
                let right = bending_secant(phi[point], phi_old[point], curved);
                let secant = wrong(phi[point], phi_old[point], curved) - right;
                *load += scale * secant * omega[point];
            });
        }
        Self::at_points(&self.curved, patch, load, |point, curved, load| {
            let secant = bending_secant(phi[point], phi_old[point], curved);
            *load += scale * secant * omega[point];
        });
        for (flux, gradient) in force.flux.iter_mut().zip(&new.omega_gradient) {
            *flux += self.interface_width * gradient;
        }
    }

    /// (1/ε) ∂G_sec/∂φ ω, which (4.35) leaves out.
    fn add_membrane_jacobian(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        iteration: Iteration,
        jacobian: &mut MembraneJacobian,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        if iteration == Iteration::Lagged {
            return;
        }
        let scale = self.interface_width.recip();
        let reaction = &mut jacobian.reaction;
        let points = reaction.len();
        let (phi, phi_old) = (&new.phi[..points], &old.phi[..points]);
        let omega = &new.omega[..points];
        Self::at_points(&self.curved, patch, reaction, |point, curved, reaction| {
            let slope = bending_secant_derivative(phi[point], phi_old[point], curved);
            *reaction += scale * slope * omega[point];
        });
    }

    /// Δt ND_ω = ε/2 ‖ω − ωⁿ‖².
    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        terms: &mut LedgerTerms,
        room: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let density = &mut room.points;
        density.clear();
        let pairs = new.omega.iter().zip(&old.omega);
        density.extend(pairs.map(|(new, old)| (new - old) * (new - old)));
        let value = 0.5 * self.interface_width * patch.integrate(density);
        terms.add("ND_omega", value);
    }
}
