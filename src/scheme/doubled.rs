//! Second order in time: a step of Δt taken once whole and once in two halves.
//!
//! One step of the scheme, S(Δt), has an error of first order: from the same state
//! S(Δt) y = Y + C Δt² + O(Δt³) and S(Δt/2)² y = Y + C Δt²/2 + O(Δt³), where Y is the exact solution
//! and y = (φ, d); ω and μ are no part of the state, for the scheme makes them anew from φ and d. So
//!
//!   2 S(Δt/2)² y − S(Δt) y = Y + O(Δt³),      S(Δt/2)² y − S(Δt) y = −C Δt²/2 + O(Δt³):
//!
//! the first is the new state, second order over a run, and the norm of the second is the error, in
//! one step, of the first-order solution that it improves. Three solves a step. What S takes at the new
//! time (ω, and so the bending) is damped by the combination as by S, however long the step: for
//! y' = −λy its factor 2/(1 + λΔt/2)² − 1/(1 + λΔt) tends to 0 with Δt → ∞. The force of the area is
//! taken in the middle, for which there is no such bound; a step that is too long for it shows in the
//! difference.
//!
//! **The energy law.** (3.26) is an identity of each step of the scheme, and is checked on all three.
//! The ledger of the accepted step is the sum of those of the two halves, which lead from the old
//! state to S(Δt/2)² y, with the term
//!
//!   extrapolation = E(S(Δt/2)² y) − E(yⁿ⁺¹),
//!
//! so that dE + Σ terms = 0 holds to the solver's tolerance with dE = E(yⁿ⁺¹) − E(yⁿ). The term may have
//! either sign. E(yⁿ⁺¹) is that of an ω that solves its equation at φⁿ⁺¹. No theorem says that it is at
//! most E(yⁿ); where it is not, S(Δt/2)² y itself is the new state, whose energy (3.26) bounds. ∫φ is the same
//! for all three and so for the combination, whose weights have the sum 1; at a clamped wall φ is −1
//! for the same reason.

use super::{Phase, Scheme, State, StepError, StepReport, energy_scale, sweep};
use crate::linalg::vector;
use crate::physics::{NamedValue, potentials};

/// A step that was taken whole and in halves and waits to be accepted, and what the guesses of the
/// next one are made from.
#[derive(Debug)]
pub(super) struct Trial {
    /// The state before the step, while the scheme stands in the middle of it.
    start: State,
    start_report: StepReport,
    /// The step taken whole, then the combination.
    combined: State,
    combined_report: StepReport,
    /// The ledger of the first half.
    first_report: StepReport,
    /// S(Δt/2)² y − S(Δt) y of the accepted step before, its length, and the change of d in it.
    last: Last,
    /// The same of this step.
    now: Last,
    waiting: Option<Waiting>,
}

#[derive(Debug, Clone, Copy)]
struct Waiting {
    dt: f64,
    combine: bool,
}

#[derive(Debug)]
struct Last {
    dt: Option<f64>,
    difference: Vec<f64>,
    turn: Option<[Vec<f64>; 2]>,
}

impl Last {
    fn new(state: &State) -> Self {
        let zeros = || vec![0.0; state.phi.len()];
        Self {
            dt: None,
            difference: zeros(),
            turn: state.director.is_some().then(|| [zeros(), zeros()]),
        }
    }
}

impl Trial {
    pub(super) fn new(state: &State) -> Self {
        Self {
            start: state.clone(),
            start_report: StepReport::default(),
            combined: state.clone(),
            combined_report: StepReport::default(),
            first_report: StepReport::default(),
            last: Last::new(state),
            now: Last::new(state),
            waiting: None,
        }
    }

    /// Forgets what guesses are made from.
    pub(super) fn forget(&mut self) {
        self.last.dt = None;
        self.waiting = None;
    }
}

/// What is known of a step before it is accepted: how far the step taken whole and the one taken in
/// halves are apart.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Difference {
    /// ‖S(Δt/2)² φ − S(Δt) φ‖, in L2.
    pub phase: f64,
    /// The same of d, where I(φ) counts it: (∫ I(φ)|·|²)^½; 0 without a director.
    pub director: f64,
}

impl Scheme {
    /// Tries a step of length Δt, once whole and once in halves. The state stays what it is until
    /// [`accept_doubled`](Self::accept_doubled); to refuse the step do nothing. With `combine` the
    /// new state is to be the combination of second order.
    ///
    /// # Errors
    /// [`StepError`]: one of the three steps was not solved.
    pub fn try_doubled(
        &mut self,
        dt: f64,
        combine: bool,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<Difference, StepError> {
        let mut trial = match self.trial.take() {
            Some(trial) => trial,
            None => Box::new(Trial::new(&self.state)),
        };
        trial.waiting = None;
        let outcome = self.three_steps(dt, combine, &mut trial, watch);
        if outcome.is_err() {
            trial.forget();
        }
        self.trial = Some(trial);
        if outcome.is_err() {
            self.forget();
        }
        outcome
    }

    /// Moves to the state of the step that was tried last; without one it does nothing.
    pub fn accept_doubled(&mut self) -> &StepReport {
        if let Some(mut trial) = self.trial.take() {
            if let Some(Waiting { dt, combine }) = trial.waiting.take() {
                if combine {
                    std::mem::swap(&mut self.state, &mut trial.combined);
                    std::mem::swap(&mut self.report, &mut trial.combined_report);
                } else {
                    std::mem::swap(&mut self.state, &mut self.next);
                    std::mem::swap(&mut self.report, &mut self.next_report);
                }
                std::mem::swap(&mut trial.last, &mut trial.now);
                self.t += dt;
                self.history.push(self.t, &self.state);
            }
            self.trial = Some(trial);
        }
        &self.report
    }

    /// Newton, Krylov and director iterations of the step that was tried last.
    pub fn tried_work(&self) -> [u32; 3] {
        Work::of(&self.next_report).0
    }

    fn three_steps(
        &mut self,
        dt: f64,
        combine: bool,
        trial: &mut Trial,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<Difference, StepError> {
        let half = 0.5 * dt;
        self.length = dt;
        // How the difference is expected to have grown since the last step.
        let growth = trial.last.dt.map(|last| (dt / last, (dt / last).powi(2)));

        self.history.extrapolate(self.t + dt, &mut self.next);
        if let Some((turn, square)) = growth {
            vector::add_scaled(&mut self.next.phi, -2.0 * square, &trial.last.difference);
            guess_director(&mut self.next, &self.state, turn, &trial.last.turn);
        }
        self.attempt(dt, growth.is_some(), watch)?;
        copy(&mut trial.combined, &self.next);
        let mut law_residual = self.next_report.law_residual;
        let whole = Work::of(&self.next_report);

        // Between the old state and the whole step, freed of its error as far as that is known.
        if let Some((_, square)) = growth {
            vector::add_scaled(&mut self.next.phi, 2.0 * square, &trial.last.difference);
        }
        self.history
            .interpolate(self.t + half, self.t + dt, &mut self.next);
        if let Some((_, square)) = growth {
            vector::add_scaled(&mut self.next.phi, -0.5 * square, &trial.last.difference);
        }
        middle_director(&mut self.next, &self.state);
        self.attempt(half, true, watch)?;
        larger(&mut law_residual, self.next_report.law_residual);
        trial.first_report.clone_from(&self.next_report);

        // The second half starts where the first one ended.
        copy(&mut trial.start, &self.state);
        trial.start_report.clone_from(&self.report);
        std::mem::swap(&mut self.state, &mut self.next);
        std::mem::swap(&mut self.report, &mut self.next_report);
        copy(&mut self.next, &trial.combined);
        if let Some((_, square)) = growth {
            vector::add_scaled(&mut self.next.phi, square, &trial.last.difference);
        }
        let solved = self.attempt(half, true, watch);
        std::mem::swap(&mut self.state, &mut trial.start);
        std::mem::swap(&mut self.report, &mut trial.start_report);
        solved?;
        larger(&mut law_residual, self.next_report.law_residual);

        // One report for all three.
        let report = &mut self.next_report;
        for (sum, term) in report.ledger.iter_mut().zip(&trial.first_report.ledger) {
            sum.value += term.value;
        }
        report.law_residual = law_residual;
        Work::of(&trial.first_report).plus(whole).add_to(report);
        if report.fallback.is_none() {
            report.fallback = trial.first_report.fallback.take();
        }

        let difference = self.difference(trial);
        trial.now.dt = Some(dt);
        self.combine(trial);
        watch(Phase::Ledger);
        let falls = trial.combined_report.total_energy <= self.report.total_energy;
        trial.waiting = Some(Waiting {
            dt,
            combine: combine && falls,
        });
        Ok(difference)
    }

    /// One step of the scheme from the state to `next`, from the guess that stands there; whether the
    /// director's is one is told.
    fn attempt(
        &mut self,
        dt: f64,
        director_is_guessed: bool,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<(), StepError> {
        if let Some(director) = &mut self.director {
            director.start_from_given(director_is_guessed);
        }
        let energy_scale = energy_scale(&self.report.energies);
        let mut report = std::mem::take(&mut self.next_report);
        let outcome = self.try_step(dt, energy_scale, &mut report, watch);
        self.next_report = report;
        outcome
    }

    /// How far the two solutions are apart; leaves the difference of φ and the turn of d in the trial.
    fn difference(&self, trial: &mut Trial) -> Difference {
        let weights = self.space.nodal_weights();
        let Trial {
            combined: whole,
            now,
            ..
        } = trial;
        let fields = self.next.phi.iter().zip(&whole.phi);
        for (difference, (halves, whole)) in now.difference.iter_mut().zip(fields) {
            *difference = halves - whole;
        }
        let phase = vector::weighted_square(&now.difference, weights).sqrt();
        let mut director = 0.0;
        if let (Some(halves), Some(whole), Some(old), Some(turn)) = (
            &self.next.director,
            &whole.director,
            &self.state.director,
            &mut now.turn,
        ) {
            for axis in 0..2 {
                let nodes = halves[axis].iter().zip(&whole[axis]).zip(&old[axis]);
                let places = self.next.phi.iter().zip(weights);
                for ((turn, ((halves, whole), old)), (phi, weight)) in
                    turn[axis].iter_mut().zip(nodes).zip(places)
                {
                    *turn = 2.0 * halves - whole - old;
                    director += weight * potentials::inside(*phi) * (halves - whole).powi(2);
                }
            }
        }
        Difference {
            phase,
            director: director.sqrt(),
        }
    }

    /// The combination, in place of the whole step, with its ω, μ and energies, and the ledger that
    /// leads to it.
    fn combine(&mut self, trial: &mut Trial) {
        let Trial {
            combined,
            combined_report: report,
            ..
        } = trial;
        let twice_less = |whole: &mut [f64], halves: &[f64]| {
            for (whole, halves) in whole.iter_mut().zip(halves) {
                *whole = 2.0 * halves - *whole;
            }
        };
        twice_less(&mut combined.phi, &self.next.phi);
        if let (Some(whole), Some(halves)) = (&mut combined.director, &self.next.director) {
            for (whole, halves) in whole.iter_mut().zip(halves) {
                twice_less(whole, halves);
            }
        }
        self.membrane
            .solve_at_rest(&self.space, &mut self.effects, &mut self.samples, combined);
        report.clone_from(&self.next_report);
        let states = [&*combined, &*combined];
        sweep(
            &self.space,
            &mut self.effects,
            &mut self.samples,
            states,
            report,
            None,
        );
        report.phase_integral = self.space.integrate_nodal(&combined.phi);
        let change = report.total_energy - self.next_report.total_energy;
        if let Some(total) = report.ledger.first_mut() {
            total.value += change;
        }
        report.ledger.push(NamedValue {
            name: "extrapolation",
            value: -change,
        });
    }
}

/// Iterations.
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

    fn add_to(self, report: &mut StepReport) {
        let Self([newton, krylov, director]) = self.plus(Self::of(report));
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

/// Without allocation.
fn copy(to: &mut State, from: &State) {
    to.phi.copy_from_slice(&from.phi);
    to.omega.copy_from_slice(&from.omega);
    to.mu.copy_from_slice(&from.mu);
    if let (Some(to), Some(from)) = (&mut to.director, &from.director) {
        for (to, from) in to.iter_mut().zip(from) {
            to.copy_from_slice(from);
        }
    }
}

/// d + `scale`·turn.
fn guess_director(to: &mut State, from: &State, scale: f64, turn: &Option<[Vec<f64>; 2]>) {
    if let (Some(to), Some(from), Some(turn)) = (&mut to.director, &from.director, turn) {
        for axis in 0..2 {
            to[axis].copy_from_slice(&from[axis]);
            vector::add_scaled(&mut to[axis], scale, &turn[axis]);
        }
    }
}

/// In the middle between what stands there and the old d.
fn middle_director(to: &mut State, from: &State) {
    if let (Some(to), Some(from)) = (&mut to.director, &from.director) {
        for (to, from) in to.iter_mut().zip(from) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = 0.5 * (*to + from);
            }
        }
    }
}
