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
    DirectorCoupling, Effect, LedgerTerms, MembraneForce, MembraneJacobian, PatchFields, PatchStep,
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
    scratch: Vec<f64>,
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
            scratch: Vec::new(),
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

    /// load ← load + (∇φ, ∇χ) + (1/ε²)(G(φ), χ): what (ω, χ) must equal.
    pub fn add_omega_load(&mut self, patch: &Patch<'_>, at: &PatchFields, load: &mut [f64]) {
        let scale = (self.interface_width * self.interface_width).recip();
        self.scratch.resize(patch.points(), 0.0);
        let phi = &at.phi[..self.scratch.len()];
        Self::at_points(
            &self.curved,
            patch,
            &mut self.scratch,
            |point, curved, out| {
                *out = scale * bending_derivative(phi[point], curved);
            },
        );
        patch.add_load(&self.scratch, &at.phi_gradient, load);
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
        #[cfg(test)]
        if let Some(wrong) = self.wrong_secant {
            Self::at_points(&self.curved, patch, out, |point, curved, out| {
                *out = scale * wrong(phi[point], phi_old[point], curved);
            });
        }
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

    fn integral(&mut self, patch: &Patch<'_>, at: &PatchFields) -> f64 {
        0.5 * self.interface_width * patch.integrate_of(&at.omega, |omega| omega * omega)
    }

    fn director_coupling(&self) -> Option<DirectorCoupling> {
        Some(DirectorCoupling::NONE)
    }

    fn add_membrane_force(&mut self, step: &PatchStep<'_>, force: &mut MembraneForce) {
        let new = step.new;
        let mut scratch = std::mem::take(&mut self.scratch);
        self.secant(step, &mut scratch);
        let terms = force.load.iter_mut().zip(&scratch).zip(&new.omega);
        terms.for_each(|((load, secant), omega)| *load += secant * omega);
        self.scratch = scratch;
        for (flux, gradient) in force.flux.iter_mut().zip(&new.omega_gradient) {
            *flux += self.interface_width * gradient;
        }
    }

    /// (1/ε) ∂G_sec/∂φ ω, which (4.35) leaves out.
    fn add_membrane_jacobian(
        &mut self,
        step: &PatchStep<'_>,
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
    fn add_dissipation(&mut self, step: &PatchStep<'_>, terms: &mut LedgerTerms) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        self.scratch.resize(patch.points(), 0.0);
        for ((density, old), new) in self.scratch.iter_mut().zip(&old.omega).zip(&new.omega) {
            *density = (new - old) * (new - old);
        }
        let value = 0.5 * self.interface_width * patch.integrate(&self.scratch);
        terms.add("ND_omega", value);
    }
}
