//! The energy law (3.26): the energies, every term of the law, its residual, and whether a step obeys it.
//!
//!   (Eⁿ⁺¹ − Eⁿ)/Δt + γ_ben ‖∇μ‖² + γ_nem ‖z‖² + Σ ND = 0
//!
//! is an identity of a solved step, with each numerical dissipation ND ≥ 0. All terms are multiplied by Δt, so that
//! nothing is divided by a small number, and the residual is that sum over S, the sum of the absolute energies and
//! works: it measures the algebraic error alone.

use crate::fem::{Patch, Space};
use crate::linalg::vector;
use crate::physics::{
    Effect, Effects, LedgerTerms, NamedValue, PatchFields, PatchStep, area_integral,
};
use crate::scene::TimeScheme;

use super::fault_injection::{self, Place};
use super::membrane::Scratch;
use super::{Scheme, State, StepError, StepReport};

impl Scheme {
    /// S without work: the sum of the absolute energies, but at least what the law can resolve.
    pub(super) fn energy_scale(&self, energies: &[NamedValue]) -> f64 {
        let sum: f64 = energies.iter().map(|energy| energy.value.abs()).sum();
        sum.max(self.membrane.least_energy())
    }

    /// The energies of the state as it is, and which terms the law has: so the ledgers of all steps have the same, by whatever
    /// scheme they are taken.
    pub(super) fn evaluate_present_energies(&mut self) {
        self.terms.clear();
        evaluate_energies(
            (&self.space, self.membrane.interface_width()),
            &mut self.effects,
            &mut self.scratch,
            [&self.state, &self.state],
            &mut self.report,
            Some(&mut self.terms),
        );
    }

    /// Adds the terms of the law that substep 1 has in a step of the secant scheme, once for each half; returns the work that
    /// effects have done on the director from outside. (In a step of first order the terms of both substeps come together.)
    pub(super) fn add_terms(&mut self, half: Half) -> f64 {
        let scheme = self.director_schemes[half as usize];
        let is_part = self.next_scheme() == TimeScheme::Secant;
        let has_terms = |effect: &(dyn Effect + 'static)| is_part && effect.has_terms(scheme);
        if !self
            .effects
            .iter()
            .any(|effect| effect.does_work() || has_terms(effect))
        {
            return 0.0;
        }
        let (state, directors) = match half {
            Half::First => (&self.state, [&self.state.director, &self.next.director]),
            Half::Second => (&self.next, [&self.middle, &self.next.director]),
        };
        let Scratch { old, new } = &mut self.scratch;
        let mut work = 0.0;
        for patch in self.space.patches() {
            fill(old, &patch, state, directors[0]);
            fill(new, &patch, state, directors[1]);
            let step = PatchStep {
                patch: &patch,
                old,
                new,
                scheme,
            };
            for effect in self.effects.iter_mut() {
                if effect.does_work() {
                    work += effect.work(&step);
                }
                if is_part && effect.has_terms(scheme) {
                    effect.add_dissipation(&step, &mut self.terms);
                }
            }
        }
        work
    }

    /// The energies of the new state and every term of (3.26), given the work from outside and what the
    /// director's mobility dissipates; refuses a step whose law is broken.
    pub(super) fn check_energy_law(
        &mut self,
        (dt, scheme): (f64, TimeScheme),
        [work, dissipated]: [f64; 2],
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let State {
            phi,
            omega,
            mu,
            director,
        } = &mut self.next;
        let director = director.iter_mut().flatten();
        for (number, field) in [phi, omega, mu].into_iter().chain(director).enumerate() {
            fault_injection::tap(Place::Solved(number), field);
        }
        let space = &self.space;
        evaluate_energies(
            (space, self.membrane.interface_width()),
            &mut self.effects,
            &mut self.scratch,
            [&self.state, &self.next],
            report,
            // In the secant scheme the parts of the step have added theirs.
            (scheme == TimeScheme::FirstOrder).then_some(&mut self.terms),
        );
        report.phase_integral = space.integrate_nodal(&self.next.phi);
        let scales = [&report.energies, &self.report.energies].map(|it| self.energy_scale(it));
        let scale = scales[0].max(scales[1]) + work.abs();
        let ledger = &mut report.ledger;
        ledger.clear();
        let change = report.total_energy - self.report.total_energy;
        ledger.push(NamedValue {
            name: "dE",
            value: change,
        });
        let value = dt * self.membrane.mobility() * space.stiffness().quadratic_form(&self.next.mu);
        ledger.push(NamedValue {
            name: "membrane_mobility",
            value,
        });
        if self.director.is_some() {
            ledger.push(NamedValue {
                name: "director_mobility",
                value: dissipated,
            });
        }
        ledger.extend_from_slice(self.terms.values());
        let sum: f64 = ledger.iter().map(|term| term.value).sum();
        report.law_residual = sum / scale;
        if let Some(place) = self.next.first_not_finite() {
            return Err(StepError::NotFinite {
                place,
                iteration: report.newton,
            });
        }
        if !report.law_residual.is_finite() {
            return Err(StepError::NotFinite {
                place: "the energy law",
                iteration: report.newton,
            });
        }
        if report.law_residual.abs() > self.solver.law_tolerance {
            return Err(StepError::LawBroken {
                residual: report.law_residual,
                tolerance: self.solver.law_tolerance,
            });
        }
        Ok(())
    }
}

/// The energies and B of the new state, and the numerical dissipation from the old one to it.
pub(super) fn evaluate_energies(
    (space, interface_width): (&Space, f64),
    effects: &mut Effects,
    scratch: &mut Scratch,
    [old_state, new_state]: [&State; 2],
    report: &mut StepReport,
    mut terms: Option<&mut LedgerTerms>,
) {
    report.energies.clear();
    report.energies.extend(
        effects
            .iter()
            .filter(|effect| effect.has_energy())
            .map(|effect| NamedValue {
                name: effect.name(),
                value: 0.0,
            }),
    );
    report.surface_area = 0.0;
    for patch in space.patches() {
        fill(&mut scratch.new, &patch, new_state, &new_state.director);
        report.surface_area += area_integral(&patch, &scratch.new, interface_width);
        if terms.is_some() {
            fill(&mut scratch.old, &patch, old_state, &old_state.director);
        }
        let step = PatchStep {
            patch: &patch,
            old: &scratch.old,
            new: &scratch.new,
            scheme: TimeScheme::FirstOrder,
        };
        let mut energies = report.energies.iter_mut();
        for effect in effects.iter_mut() {
            if effect.has_energy()
                && let Some(energy) = energies.next()
            {
                energy.value += effect.integral(&patch, &scratch.new);
            }
            if let Some(terms) = &mut terms {
                effect.add_dissipation(&step, terms);
            }
        }
    }
    let effects = effects.iter().filter(|effect| effect.has_energy());
    for (effect, energy) in effects.zip(&mut report.energies) {
        energy.value = effect.energy(energy.value);
        fault_injection::tap(Place::Energy, std::slice::from_mut(&mut energy.value));
    }
    report.total_energy = report.energies.iter().map(|energy| energy.value).sum();
}

/// Which solve of substep 1: the only one, or the first of two; or the second, after substep 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Half {
    First,
    Second,
}

/// All fields of a state on a patch, with this director.
fn fill(
    sample: &mut PatchFields,
    patch: &Patch<'_>,
    state: &State,
    director: &Option<[Vec<f64>; 2]>,
) {
    sample.begin();
    sample.set_phi(patch, &state.phi);
    sample.set_omega(patch, &state.omega);
    if let Some(director) = director {
        sample.set_director(patch, director);
    }
}

/// By how much the law will miss, over S, from the residuals of the first and of the second equation of (3.21) and the
/// states before and after: (r₁ᵀμ + r₂ᵀ(φ − φⁿ))/S. `clamped`: only there the second equation has a residual.
pub(super) fn expected_residual(
    [first, second]: &[Vec<f64>; 2],
    [old, new]: [&State; 2],
    clamped: bool,
    energy_scale: f64,
) -> f64 {
    let mut defect = vector::dot(first, &new.mu);
    if clamped {
        let steps = new.phi.iter().zip(&old.phi).zip(second);
        defect += steps.map(|((new, old), r)| (new - old) * r).sum::<f64>();
    }
    defect / energy_scale
}
