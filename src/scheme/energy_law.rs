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
use super::strips::{Strip, Strips};
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
        let state = (&self.state.phi[..], self.state.director.as_ref());
        let (space, strips) = (&self.space, &mut self.strips);
        self.membrane
            .begin(space, &self.effects, strips, state, TimeScheme::FirstOrder);
        self.terms.clear();
        evaluate_energies(
            (space, self.membrane.interface_width()),
            &self.effects,
            strips,
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
        let effects = &self.effects;
        let (space, strips) = (&self.space, &mut self.strips);
        let sums = strips.sum_over(space, ((), 1), |patch, number, strip, ()| {
            let Strip {
                old,
                new,
                room,
                kept,
                sums,
                terms,
                ..
            } = strip;
            fill(old, patch, state, directors[0]);
            fill(new, patch, state, directors[1]);
            let step = PatchStep {
                patch,
                old,
                new,
                scheme,
            };
            for (effect, kept) in effects.iter().zip(&kept[number]) {
                if effect.does_work() {
                    sums[0] += effect.work(&step, room);
                }
                if is_part && effect.has_terms(scheme) {
                    effect.add_dissipation(&step, kept, terms, room);
                }
            }
        });
        let work = sums[0];
        strips.move_terms(&mut self.terms);
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
            &self.effects,
            &mut self.strips,
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
        if self.changes_begun() > 0 {
            // The sum starts from the energy that the old state has with the parameters of this step.
            let work = self.change_work.unwrap_or_default();
            ledger[0].value += work;
            ledger.push(NamedValue {
                name: "change_work",
                value: 0.0 - work,
            });
        }
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
    effects: &Effects,
    strips: &mut Strips,
    [old_state, new_state]: [&State; 2],
    report: &mut StepReport,
    terms: Option<&mut LedgerTerms>,
) {
    let with_terms = terms.is_some();
    // Those of the effects, and B.
    let count = effects.count() + 1;
    let sums = strips.sum_over(space, ((), count), |patch, number, strip, ()| {
        let Strip {
            old,
            new,
            room,
            kept,
            sums,
            terms,
            ..
        } = strip;
        fill(new, patch, new_state, &new_state.director);
        sums[count - 1] += area_integral(patch, new, interface_width);
        if with_terms {
            fill(old, patch, old_state, &old_state.director);
        }
        let step = PatchStep {
            patch,
            old,
            new,
            scheme: TimeScheme::FirstOrder,
        };
        for (effect, (sum, kept)) in effects.iter().zip(sums.iter_mut().zip(&kept[number])) {
            if effect.has_energy() {
                *sum += effect.integral(patch, new, room);
            }
            if with_terms {
                effect.add_dissipation(&step, kept, terms, room);
            }
        }
    });
    report.surface_area = sums[count - 1];
    report.energies.clear();
    let effects = effects.iter().zip(sums);
    let effects = effects.filter(|(effect, _)| effect.has_energy());
    report
        .energies
        .extend(effects.map(|(effect, integral)| NamedValue {
            name: effect.name(),
            value: effect.energy(*integral),
        }));
    for energy in &mut report.energies {
        fault_injection::tap(Place::Energy, std::slice::from_mut(&mut energy.value));
    }
    report.total_energy = report.energies.iter().map(|energy| energy.value).sum();
    if let Some(terms) = terms {
        strips.move_terms(terms);
    }
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
