//! Second and third order in time, by extrapolation: a step of Δt is taken whole, in two parts, and
//! for the third order in three.
//!
//! One step of the scheme, S(Δt), has an error of first order: from the same state y the result in j
//! parts is
//!
//!   T_j = S(Δt/j)ʲ y = Y + C₁ Δt²/j + C₂ Δt³/j² + …
//!
//! with Y the exact solution and y = (φ, d); ω and μ are no part of the state, for the scheme makes them
//! again from φ and d. With the weights w_j = Π_{i≠j} j/(j − i) the combination Σ w_j T_j of k results
//! has an error of the order k over a run (Aitken and Neville; the harmonic sequence):
//!
//!   k = 2:  2 T₂ − T₁                      three steps of the scheme in each
//!   k = 3:  (9 T₃ − 8 T₂ + T₁)/2           six
//!
//! The estimate of the error is the norm of its distance to the best result of the order below, T₂ or
//! 3 T₃ − 2 T₂; it falls as Δtᵏ, and is that of the solution which is improved on. What S takes at the new
//! time (ω, and so the bending) is damped by the combination as by S, however long the step: for
//! y' = −λy its factor tends to 0 with Δt → ∞. The force of the area is taken in the middle, for which
//! there is no such bound; a step that is too long for it shows in the estimate.
//!
//! **The energy law.** (3.26) is an identity of each step of the scheme, and is checked on all of them.
//! The ledger of the accepted step is the sum of those of the k parts that lead from the old state to
//! T_k, with the term
//!
//!   extrapolation = E(T_k) − E(yⁿ⁺¹),
//!
//! so that dE + Σ terms = 0 holds to the solver's tolerance with dE = E(yⁿ⁺¹) − E(yⁿ). The term may have
//! either sign. E(yⁿ⁺¹) is that of an ω that solves its equation at φⁿ⁺¹. No theorem says that it is at
//! most E(yⁿ); where it is not, T_k itself is the new state, whose energy (3.26) bounds. ∫φ is the
//! same for all results and so for the combination, whose weights have the sum 1; at a clamped wall φ is
//! −1 for the same reason.
//!
//! **What depends on time.** A field is on or off for the whole step, and noise is the same force in
//! all parts of it: else the results would belong to different equations. The work of noise may raise
//! the energy; the combination is then compared with E(yⁿ) and that work.

use super::energy_law::evaluate_energies;
use super::{Phase, Scheme, State, StepError, StepReport, StoppingCriterion};
use crate::linalg::vector;
use crate::physics::{NamedValue, potentials};
use serde::{Deserialize, Serialize};

/// A step that was taken in several ways and waits to be accepted, and what the guesses of the
/// next one are made from.
#[derive(Debug)]
pub(super) struct ExtrapolatedStep {
    /// The state before the step, while the scheme stands in the middle of it.
    ///
    /// At the step's end also room for what its own states are compared with.
    start: State,
    start_report: StepReport,
    /// T_1 … T_k.
    results: Vec<State>,
    /// The report of T_k: its ledger is that of all its parts.
    finest: StepReport,
    combined: State,
    combined_report: StepReport,
    /// What was learnt in the accepted step before, and in this one.
    last: PredictorErrors,
    now: PredictorErrors,
    waiting: Option<Waiting>,
}

#[derive(Debug, Clone, Copy)]
struct Waiting {
    dt: f64,
    combine: bool,
}

/// What a step teaches for the guesses of the next.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct PredictorErrors {
    /// The length of the step; `None`: nothing is known.
    dt: Option<f64>,
    /// What each result in j parts and the states on the way to it miss, of φ: errors[j − 1][i − 1] after the part
    /// i. That is, nearly, Σ w_j T_j, and what that and the states before the step are interpolated to, less
    /// the result.
    errors: Vec<Vec<Vec<f64>>>,
    /// The change of d.
    turn: Option<[Vec<f64>; 2]>,
}

impl PredictorErrors {
    fn new(state: &State, chains: usize) -> Self {
        let zeros = || vec![0.0; state.phi.len()];
        Self {
            dt: None,
            errors: (1..=chains)
                .map(|parts| (0..parts).map(|_| zeros()).collect())
                .collect(),
            turn: state.director.is_some().then(|| [zeros(), zeros()]),
        }
    }

    /// Takes over another. Allocates only where there is no room yet.
    fn copy(&mut self, other: &Self) {
        self.dt = other.dt;
        self.errors.clone_from(&other.errors);
        self.turn.clone_from(&other.turn);
    }

    /// Whether it can be of a scheme whose state is this.
    pub(super) fn fits(&self, state: &State) -> bool {
        let nodes = state.phi.len();
        let turn = self.turn.iter().flatten();
        let errors = self.errors.iter().flatten();
        let parts = self.errors.iter().map(Vec::len);
        self.dt.is_none_or(|dt| dt.is_finite() && dt > 0.0)
            && (2..=MOST_CHAINS).contains(&self.errors.len())
            && parts.eq(1..=self.errors.len())
            && self.turn.is_some() == state.director.is_some()
            && errors.chain(turn).all(|it| it.len() == nodes)
    }
}

/// A step longer than the last by more than this ratio: what the states within it will have missed, which is not
/// Δt² alone, cannot be told from those within the last one.
const LIKE_THE_LAST: f64 = 1.2;

/// Results that are combined at most.
const MOST_CHAINS: usize = 3;

impl ExtrapolatedStep {
    fn new(state: &State, chains: usize) -> Self {
        Self {
            start: state.clone(),
            start_report: StepReport::default(),
            results: vec![state.clone(); chains],
            finest: StepReport::default(),
            combined: state.clone(),
            combined_report: StepReport::default(),
            last: PredictorErrors::new(state, chains),
            now: PredictorErrors::new(state, chains),
            waiting: None,
        }
    }

    /// Forgets what guesses are made from.
    pub(super) fn forget(&mut self) {
        self.last.dt = None;
        self.waiting = None;
    }
}

/// The estimated error of a step before it is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorEstimate {
    /// Of φ, in L2.
    pub phase: f64,
    /// Of d, where I(φ) counts it: (∫ I(φ)|·|²)^½; 0 without a director.
    pub director: f64,
}

/// w_j = Π_{i≠j} j/(j − i), i from `first` to `last`; 0 outside.
fn weight(j: usize, first: usize, last: usize) -> f64 {
    if j < first || j > last {
        return 0.0;
    }
    (first..=last)
        .filter(|i| *i != j)
        .map(|i| j as f64 / (j as f64 - i as f64))
        .product()
}

impl Scheme {
    /// Tries a step of length Δt in 1, 2, … `chains` parts (two or three). The state stays what it is
    /// until [`accept_extrapolated`](Self::accept_extrapolated); to refuse the step do nothing. With
    /// `combine` the new state is to be the combination, whose order is the number of chains; without it
    /// the result of most parts.
    ///
    /// # Errors
    /// [`StepError`]: one of the steps was not solved.
    pub fn try_extrapolated(
        &mut self,
        dt: f64,
        chains: usize,
        combine: bool,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<ErrorEstimate, StepError> {
        // For the whole step: a field that is switched on its way would not be the same for all parts.
        self.set_interval(dt);
        let mut extrapolated = match self.extrapolated.take() {
            Some(extrapolated) if extrapolated.results.len() == chains => extrapolated,
            _ => Box::new(ExtrapolatedStep::new(&self.state, chains)),
        };
        extrapolated.waiting = None;
        let outcome = self.all_chains(dt, combine, &mut extrapolated, watch);
        if outcome.is_err() {
            extrapolated.forget();
        }
        self.extrapolated = Some(extrapolated);
        if outcome.is_err() {
            self.forget();
        }
        outcome
    }

    /// Moves to the state of the step that was tried last; without one it does nothing.
    pub fn accept_extrapolated(&mut self) -> &StepReport {
        if let Some(mut extrapolated) = self.extrapolated.take() {
            if let Some(Waiting { dt, combine }) = extrapolated.waiting.take() {
                let finest = extrapolated.results.len() - 1;
                let (state, report) = if combine {
                    (
                        &mut extrapolated.combined,
                        &mut extrapolated.combined_report,
                    )
                } else {
                    (&mut extrapolated.results[finest], &mut extrapolated.finest)
                };
                std::mem::swap(&mut self.state, state);
                std::mem::swap(&mut self.report, report);
                std::mem::swap(&mut extrapolated.last, &mut extrapolated.now);
                self.report.switched = self.switched.take();
                self.t += dt;
                self.history.push(self.t, &self.state);
            }
            self.extrapolated = Some(extrapolated);
        }
        &self.report
    }

    /// Newton, Krylov and director iterations of the step that was tried last.
    pub fn tried_work(&self) -> [u32; 3] {
        self.extrapolated
            .as_ref()
            .map_or([0; 3], |extrapolated| Work::of(&extrapolated.finest).0)
    }

    /// Copies out what the guesses of the next step are made from.
    pub(super) fn save_predictor_errors(&self, checkpoint: &mut Option<PredictorErrors>) {
        let known = self.extrapolated.as_ref().filter(|it| it.last.dt.is_some());
        match known {
            Some(extrapolated) => checkpoint.get_or_insert_default().copy(&extrapolated.last),
            None => *checkpoint = None,
        }
    }

    /// Puts it back.
    pub(super) fn restore_predictor_errors(&mut self, checkpoint: Option<&PredictorErrors>) {
        let Some(predictor_errors) = checkpoint else {
            self.extrapolated = None;
            return;
        };
        let chains = predictor_errors.errors.len();
        let mut extrapolated = match self.extrapolated.take() {
            Some(extrapolated) if extrapolated.results.len() == chains => extrapolated,
            _ => Box::new(ExtrapolatedStep::new(&self.state, chains)),
        };
        extrapolated.waiting = None;
        extrapolated.last.copy(predictor_errors);
        self.extrapolated = Some(extrapolated);
    }

    fn all_chains(
        &mut self,
        dt: f64,
        combine: bool,
        extrapolated: &mut ExtrapolatedStep,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<ErrorEstimate, StepError> {
        (self.length, self.parts) = (dt, extrapolated.results.len());
        // One factor for all parts, of this step's state. Table 1's run so takes 55 of them and 2521 iterations; with one
        // for Δt and one for the rest in each step 105 and 2171, with two that lived on for steps 40 and 3497.
        self.membrane.forget();
        self.stopping = StoppingCriterion::ChangesToCome(None);
        extrapolated.start.clone_from(&self.state);
        extrapolated.start_report.clone_from(&self.report);
        let mut work = Work([0; 3]);
        let mut law_residual = 0.0;
        let (mut fallback, mut newton_took_over) = (None, None);
        let (mut refused_ways, mut damping) = (0, 1.0_f64);
        for parts in 1..=extrapolated.results.len() {
            let outcome = self.chain(dt, parts, extrapolated, watch, &mut |report| {
                work = work.plus(Work::of(report));
                larger(&mut law_residual, report.law_residual);
                fallback = fallback.take().or(report.fallback.take());
                newton_took_over = newton_took_over.take().or(report.newton_took_over.take());
                refused_ways += report.refused_ways;
                damping = damping.min(report.damping);
            });
            // The state of the last part is the result; the scheme goes back to the start.
            extrapolated.results[parts - 1].clone_from(&self.state);
            self.state.clone_from(&extrapolated.start);
            self.report.clone_from(&extrapolated.start_report);
            outcome?;
        }
        // One report for all.
        let report = &mut extrapolated.finest;
        report.law_residual = law_residual;
        report.fallback = fallback;
        report.newton_took_over = newton_took_over;
        (report.refused_ways, report.damping) = (refused_ways, damping);
        work.write_to(report);

        self.combine(extrapolated);
        self.learn(dt, extrapolated);
        let difference = self.difference(extrapolated);
        extrapolated.now.dt = Some(dt);
        watch(Phase::Ledger);
        // But for the work that is done on it from outside.
        let ledger = extrapolated.combined_report.ledger.iter();
        let works = ledger.filter(|term| term.is_work());
        let done: f64 = works.map(|term| term.value).sum();
        let falls = extrapolated.combined_report.total_energy + done <= self.report.total_energy;
        extrapolated.waiting = Some(Waiting {
            dt,
            combine: combine && falls,
        });
        Ok(difference)
    }

    /// Takes the step in so many parts, and leaves the scheme's state and report at its end; that of
    /// all parts together is `trial.finest`.
    fn chain(
        &mut self,
        dt: f64,
        parts: usize,
        extrapolated: &mut ExtrapolatedStep,
        watch: &mut dyn FnMut(Phase),
        note: &mut dyn FnMut(&mut StepReport),
    ) -> Result<(), StepError> {
        let piece = dt / parts as f64;
        for part in 1..=parts {
            self.guess(dt, (part, parts), extrapolated);
            if let Some(director) = &mut self.director {
                director.start_from_given(parts > 1 || extrapolated.last.dt.is_some());
            }
            let energy_scale = self.energy_scale(&self.report.energies);
            let mut report = std::mem::take(&mut self.next_report);
            let outcome = self.try_step(piece, energy_scale, &mut report, watch);
            self.next_report = report;
            outcome?;
            note(&mut self.next_report);
            std::mem::swap(&mut self.state, &mut self.next);
            std::mem::swap(&mut self.report, &mut self.next_report);
            // To be compared with the combination.
            extrapolated.now.errors[parts - 1][part - 1].copy_from_slice(&self.state.phi);
            if part == 1 {
                extrapolated.finest.clone_from(&self.report);
            } else {
                let ledger = std::mem::take(&mut extrapolated.finest.ledger);
                extrapolated.finest.clone_from(&self.report);
                for (sum, term) in extrapolated.finest.ledger.iter_mut().zip(&ledger) {
                    sum.value += term.value;
                }
            }
        }
        Ok(())
    }

    /// A guess for φ, ω, μ and d after `part` of `parts`, into `next`.
    ///
    /// What the results miss is expected to have grown since the last step as Δt². Freed of that,
    /// the extrapolated history or the result of the chain before is where the step leads; each state on the way of
    /// a chain departs from there, or from what is interpolated, by what it missed itself.
    fn guess(&mut self, dt: f64, (part, parts): (usize, usize), extrapolated: &ExtrapolatedStep) {
        let share = part as f64 / parts as f64;
        let ratio = extrapolated.last.dt.map(|last| dt / last);
        let growth = ratio.map_or(0.0, |ratio| ratio * ratio);
        let errors = &extrapolated.last.errors;
        let (here, end) = (self.t + share * dt, self.t + dt);
        let next = &mut self.next;
        if parts == 1 {
            self.history.extrapolate(end, next);
        } else {
            next.clone_from(&extrapolated.results[parts - 2]);
            vector::add_scaled(&mut next.phi, growth, &errors[parts - 2][parts - 2]);
            if part < parts {
                self.history.interpolate(here, end, next);
            }
        }
        let (error, share) = if ratio.is_some_and(|ratio| ratio <= LIKE_THE_LAST) {
            (&errors[parts - 1][part - 1], 1.0)
        } else {
            // What it missed at the end has grown on the way.
            (&errors[parts - 1][parts - 1], share)
        };
        vector::add_scaled(&mut next.phi, -growth * share, error);
        let (Some(to), Some(from)) = (&mut next.director, &extrapolated.start.director) else {
            return;
        };
        for axis in 0..2 {
            match (parts, &extrapolated.last.turn) {
                (1, Some(turn)) => {
                    to[axis].copy_from_slice(&from[axis]);
                    vector::add_scaled(&mut to[axis], ratio.unwrap_or(0.0), &turn[axis]);
                }
                _ => {
                    for (to, from) in to[axis].iter_mut().zip(&from[axis]) {
                        *to = from + share * (*to - from);
                    }
                }
            }
        }
    }

    /// What the results of the step and the states on the way to them miss, for the next guesses.
    fn learn(&self, dt: f64, extrapolated: &mut ExtrapolatedStep) {
        let ExtrapolatedStep {
            combined,
            start: here,
            now,
            ..
        } = extrapolated;
        let end = self.t + dt;
        let chains = now.errors.len();
        for (parts, errors) in (1..=chains).zip(&mut now.errors) {
            for (part, error) in (1..=parts).zip(errors) {
                here.clone_from(combined);
                if part < parts {
                    let share = part as f64 / parts as f64;
                    self.history.interpolate(self.t + share * dt, end, here);
                }
                for (error, best) in error.iter_mut().zip(&here.phi) {
                    *error = best - *error;
                }
            }
        }
    }

    /// The estimate; leaves the change of d in the trial.
    fn difference(&self, extrapolated: &mut ExtrapolatedStep) -> ErrorEstimate {
        let weights = self.space.nodal_weights();
        let ExtrapolatedStep {
            results,
            combined,
            now,
            ..
        } = extrapolated;
        // Σ w_j T_j without the first, of the order below: its distance is the sum of the errors with
        // its weights.
        let chains = results.len();
        let below = |j: usize| weight(j, 2, chains);
        let mut phase = 0.0;
        for (node, weight) in weights.iter().enumerate() {
            let sum: f64 = (2..=chains)
                .map(|j| below(j) * now.errors[j - 1][j - 1][node])
                .sum();
            phase += weight * sum * sum;
        }
        let mut director = 0.0;
        if let (Some(best), Some(old), Some(turn)) =
            (&combined.director, &self.state.director, &mut now.turn)
        {
            for axis in 0..2 {
                for (node, weight) in weights.iter().enumerate() {
                    let best = best[axis][node];
                    turn[axis][node] = best - old[axis][node];
                    let result = |j: usize| {
                        let director = results[j - 1].director.as_ref();
                        director.map_or(0.0, |director| director[axis][node])
                    };
                    let sum: f64 = (2..=chains).map(|j| below(j) * (best - result(j))).sum();
                    director +=
                        weight * potentials::phase_indicator(combined.phi[node]) * sum * sum;
                }
            }
        }
        ErrorEstimate {
            phase: phase.sqrt(),
            director: director.sqrt(),
        }
    }

    /// The combination with its ω, μ and energies, and the ledger that leads to it.
    fn combine(&mut self, extrapolated: &mut ExtrapolatedStep) {
        let ExtrapolatedStep {
            results,
            combined,
            combined_report: report,
            finest,
            ..
        } = extrapolated;
        // ω and μ of the finest result are the guesses from which those of the combination are solved for:
        // what earlier steps have left there must not be, for a run that is resumed has other.
        if let Some(finest) = results.last() {
            combined.clone_from(finest);
        }
        combine_field(&mut combined.phi, results, |state| &state.phi);
        for (axis, sum) in combined.director.iter_mut().flatten().enumerate() {
            combine_field(sum, results, |state| {
                state.director.as_ref().map_or(&[], |it| &it[axis])
            });
        }
        self.membrane
            .solve_at_rest(&self.space, &mut self.effects, &mut self.scratch, combined);
        report.clone_from(finest);
        let states = [&*combined, &*combined];
        evaluate_energies(
            (&self.space, self.membrane.interface_width()),
            &mut self.effects,
            &mut self.scratch,
            states,
            report,
            None,
        );
        report.phase_integral = self.space.integrate_nodal(&combined.phi);
        let change = report.total_energy - finest.total_energy;
        if let Some(total) = report.ledger.first_mut() {
            total.value += change;
        }
        report.ledger.push(NamedValue {
            name: "extrapolation",
            value: -change,
        });
    }
}

/// Σ w_j T_j of a field, as T_k + Σ w_j (T_j − T_k): the weights are as large as 4.5, and with them on the fields
/// themselves a state at rest would move by the same rounding in every step, and ∫φ with it.
fn combine_field(combined: &mut [f64], results: &[State], field: impl Fn(&State) -> &[f64]) {
    let Some((finest, others)) = results.split_last() else {
        return;
    };
    let finest = field(finest);
    combined.fill(0.0);
    for (index, result) in others.iter().enumerate() {
        let weight = weight(index + 1, 1, results.len());
        for ((sum, value), finest) in combined.iter_mut().zip(field(result)).zip(finest) {
            *sum += weight * (value - finest);
        }
    }
    for (sum, finest) in combined.iter_mut().zip(finest) {
        *sum += finest;
    }
}

/// Newton, Krylov and director iterations.
#[derive(Debug, Clone, Copy)]
struct Work([u32; 3]);

impl Work {
    fn of(report: &StepReport) -> Self {
        Self([report.newton, report.krylov, report.director_iterations])
    }

    fn plus(self, other: Self) -> Self {
        let mut sum = self.0;
        sum.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
        Self(sum)
    }

    fn write_to(self, report: &mut StepReport) {
        let Self([newton, krylov, director]) = self;
        (report.newton, report.krylov) = (newton, krylov);
        report.director_iterations = director;
    }
}

/// Keeps the one of larger magnitude.
fn larger(residual: &mut f64, other: f64) {
    if other.abs() > residual.abs() {
        *residual = other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Mesh;
    use crate::scene::Scene;
    use crate::scheme::initial_fields;

    /// From one step to the next that is as long, what the states within it miss is better known from those of the
    /// last one than as a share of what is missed at the end.
    #[test]
    fn what_the_states_within_a_step_missed_foretells_what_they_will() {
        let text = "
            mesh.cells = 16
            vesicle = { shape = 'ellipse', half_axes = [0.3, 0.2], angle = 70 }
            time = { tolerance = 1e-4, end = 1 }
            membrane.interface_width = 0.08
            area.target = 1.1
        ";
        let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        let scene = Scene::parse(text, "the test", &[], &mut no_files).expect("a scene");
        let mesh = Mesh::of(&scene).expect("a mesh");
        let initial = initial_fields(&scene, &mesh).expect("initial fields");
        let mut scheme = Scheme::new(&scene, mesh, initial.phi, None).expect("a scheme");
        let mut step = || {
            let outcome = scheme.try_extrapolated(1e-5, 3, true, &mut |_| ());
            outcome.expect("a step");
            scheme.accept_extrapolated();
            // The one that was accepted and the one before: they have changed places.
            let extrapolated = scheme.extrapolated.as_ref().expect("a extrapolated");
            [&extrapolated.now, &extrapolated.last]
                .map(|predictor_errors| predictor_errors.errors.clone())
        };
        // Once the outline from the scene has come to rest.
        for _ in 0..39 {
            step();
        }
        let [last, now] = step();
        for (parts, part) in [(2, 1), (3, 1), (3, 2)] {
            let missed = &now[parts - 1][part - 1];
            let distance = |share: f64, foretold: &[f64]| {
                let pairs = missed.iter().zip(foretold);
                pairs
                    .map(|(a, b)| (a - share * b).powi(2))
                    .sum::<f64>()
                    .sqrt()
            };
            let by_the_state = distance(1.0, &last[parts - 1][part - 1]);
            let by_the_end = distance(part as f64 / parts as f64, &last[parts - 1][parts - 1]);
            assert!(
                by_the_state < 0.7 * by_the_end,
                "{part} of {parts}: {by_the_state:e} {by_the_end:e}"
            );
        }
    }

    /// With the weights on the fields themselves 883 of these 999 values would move.
    #[test]
    fn the_combination_of_a_state_at_rest_is_that_state() {
        let values: Vec<f64> = (1..1000).map(|n| f64::from(n).sin()).collect();
        let state = State {
            phi: values.clone(),
            omega: Vec::new(),
            mu: Vec::new(),
            director: None,
        };
        for chains in [2, 3] {
            let results = vec![state.clone(); chains];
            let mut combined = vec![0.0; values.len()];
            combine_field(&mut combined, &results, |state| &state.phi);
            assert_eq!(combined, values, "{chains}");
        }
    }

    #[test]
    fn the_weights_are_those_of_aitken_and_neville() {
        let of = |first, last| {
            (first..=last)
                .map(|j| weight(j, first, last))
                .collect::<Vec<_>>()
        };
        assert_eq!(of(1, 2), [-1.0, 2.0]);
        assert_eq!(of(1, 3), [0.5, -4.0, 4.5]);
        assert_eq!(of(2, 3), [-2.0, 3.0]);
        assert_eq!(of(2, 2), [1.0]);
    }

    #[test]
    fn the_combinations_are_of_their_order_and_damp_what_is_stiff() {
        // One step of y' = −λ y by the implicit Euler method.
        let result = |parts: usize, z: f64| (1.0 + z / parts as f64).powi(parts as i32).recip();
        let combined = |chains: usize, z: f64| -> f64 {
            (1..=chains)
                .map(|j| weight(j, 1, chains) * result(j, z))
                .sum()
        };
        for chains in [2, 3] {
            let error = |z: f64| (combined(chains, z) - (-z).exp()).abs();
            let order = (error(0.02) / error(0.01)).log2();
            assert!((order - (chains + 1) as f64).abs() < 0.1, "{order}");
            assert!(combined(chains, 1e6).abs() < 1e-5);
            assert!((0..400).all(|n| combined(chains, 0.1 * f64::from(n)).abs() <= 1.0));
        }
    }
}
