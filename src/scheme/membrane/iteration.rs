//! The nonlinear iteration of substep 2 and what keeps it from diverging.
//!
//! Newton's correction δ at an iterate x is taken whole if the residual falls. Where it does not, the
//! residual may be the wrong judge: a stiff penalty (η = 1e-8) magnifies by many powers of ten what a
//! further correction undoes at once. Then Deuflhard's natural monotonicity test decides, which does
//! not see how the equations are scaled: the *simplified* correction δ̄, by the same linearisation but
//! the residual at the trial x + λδ, must be shorter than δ. Where it is not, λ is made smaller by
//! what the two corrections say about the curvature between them.
//!
//! **When the equations are not linearised again.** With the derivative that it has, Newton's method makes the
//! residual smaller by about the same factor as the last time. Where that factor is small enough for the energy
//! law to hold after one more iteration, that one is taken with the linearised equations of the last.
//!
//! **When it ends.** A field has converged when its relative L2 change in the last iteration is at most
//! the tolerance. The steps of the secant scheme are long, and what follows from one is φ alone, for ω is made of it. There it
//! is enough that the changes of φ still to come are within the tolerance: where a change is θ
//! times the one before, all that follow are together at most θ/(1 − θ) times the last, for θ itself falls
//! as Newton's method converges (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8). That saves the
//! last iteration, whose only use is to show that it was not needed. The energy law must hold in any case.

use crate::linalg::vector;
use crate::scene::Iteration;

use super::super::energy_law;
use super::{MembraneStep, Phase, State, StepContext, StepError, rounding};

/// Which change must be within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scheme) enum StoppingCriterion {
    /// That of each field in the last iteration.
    LastChange,
    /// That of φ in all iterations to come, where Newton's method lets it be foreseen.
    ChangesToCome,
}

/// A change of φ in one iteration, and θ: how large the next was in comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ConvergenceRate {
    change: f64,
    theta: f64,
}

impl ConvergenceRate {
    /// A bound of all the changes that follow this one: θ/(1 − θ) times it. Newton's θ is proportional to the
    /// change; that a smaller one has a smaller θ is not made use of.
    fn changes_after(&self, change: f64) -> f64 {
        let theta = self.theta * (change / self.change).max(1.0);
        if theta < LARGEST_THETA {
            theta / (1.0 - theta) * change
        } else {
            change
        }
    }
}

/// What the iteration may do.
#[derive(Debug, Clone, Copy)]
pub(in crate::scheme) struct NewtonOptions {
    pub(in crate::scheme) iteration: Iteration,
    pub(in crate::scheme) stopping: StoppingCriterion,
    /// solver.tolerance.
    pub(in crate::scheme) tolerance: f64,
    /// solver.law_tolerance.
    pub(in crate::scheme) law_tolerance: f64,
}

impl NewtonOptions {
    /// Iterations before giving up: Newton's method needs fewer than ten where it converges at once,
    /// (4.35) up to twenty at moderate Δt.
    fn iterations(&self) -> u32 {
        match self.iteration {
            Iteration::Newton => 60,
            Iteration::Lagged => 200,
        }
    }
}

/// Krylov iterations for each iteration that may be made, on average: Newton's method needs about ten with a new factor. Where
/// every solve ends at its limit an attempt would take hundreds of times as long as a step, in which no signal is answered.
const KRYLOV_ON_AVERAGE: u32 = 50;

/// The smallest damping factor that is tried: a smaller Δt is the better way from there on.
const LEAST_DAMPING: f64 = 1.0 / 64.0;

/// So many iterations without a better one before: it leads nowhere, and a smaller Δt is cheaper.
const STALLED_AFTER: u32 = 12;

/// Above this θ Newton's method has not yet come to where θ falls.
const LARGEST_THETA: f64 = 0.1;

/// Above this ratio of a residual to the one before the next iteration has a derivative of its own.
const FALLS_FAST: f64 = 5e-2;

/// After a correction within the tolerance the residual is smaller than this part of the one before, or what is left is of the linear
/// system: the next one is solved so much more strictly. Without that one in three steps of the preset `prolate` was refused once
/// its vesicle was at rest, and the run took 896 steps in place of 55; with 0.1 it took half as many more.
const FALLS_SLOWLY: f64 = 0.03;
const STRICTER: f64 = 30.0;

/// In all at most so much more strictly: an iteration that falls slowly for another reason would go on to infinity.
const STRICTEST: f64 = 1e5;

/// The part of the law's tolerance that substep 2 may use up. The rest is for what else misses: substep 1
/// and the solves with the mass matrix. Without it a step that ends just within the tolerance is refused
/// when its books are closed.
const SHARE_OF_LAW: f64 = 0.8;

/// The accuracy of the energy law that [`MembraneStep::refine`] aims at.
const REFINED_LAW: f64 = 1e-14;

/// Iterations of [`MembraneStep::refine`].
const REFINEMENTS: u32 = 3;

/// Whether the linearised equations will do for one more iteration where they made the residual so many times as
/// large and left this defect of the energy law.
fn serves_again(fell: f64, law: f64, options: NewtonOptions) -> bool {
    fell <= FALLS_FAST && fell * law.abs() <= SHARE_OF_LAW * options.law_tolerance
}

/// What a solved substep 2 took.
#[derive(Debug, Clone, Copy)]
pub(in crate::scheme) struct Work {
    pub(in crate::scheme) newton: u32,
    pub(in crate::scheme) krylov: u32,
    /// The smallest damping factor λ; 1: none was needed.
    pub(in crate::scheme) damping: f64,
    /// The estimated relative error of φ: its change in the last iteration, or those to come.
    pub(in crate::scheme) error: f64,
}

/// Where a new iterate is, and what it took to find.
#[derive(Debug, Clone, Copy)]
struct DampedStep {
    /// Of the residual.
    norm: f64,
    damping: f64,
    /// Krylov iterations of the simplified corrections.
    krylov: u32,
}

/// Notices when an iteration leads nowhere.
#[derive(Debug, Clone, Copy)]
struct Progress {
    /// The smallest residual and the shortest correction so far.
    best: [f64; 2],
    since: u32,
}

impl Progress {
    fn new(norm: f64) -> Self {
        Self {
            best: [norm, f64::INFINITY],
            since: 0,
        }
    }

    /// Takes note of an iterate; returns whether hope is lost.
    fn is_stalled(&mut self, measures: [f64; 2]) -> bool {
        self.since += 1;
        for (best, measure) in self.best.iter_mut().zip(measures) {
            if measure < 0.9 * *best {
                *best = measure;
                self.since = 0;
            }
        }
        self.since >= STALLED_AFTER
    }
}

impl MembraneStep {
    /// Solves substep 2 from the guess in `to`, where φ, ω and μ of the solution are left.
    pub(in crate::scheme) fn solve(
        &mut self,
        context: &mut StepContext<'_>,
        options: NewtonOptions,
    ) -> Result<Work, StepError> {
        let mut work = Work {
            newton: 0,
            krylov: 0,
            damping: 1.0,
            error: 0.0,
        };
        if self.clamped {
            // The guess may come from anywhere; the wall does not move.
            let nodes = context
                .to
                .phi
                .iter_mut()
                .zip(&context.from.phi)
                .zip(&self.fixed);
            nodes
                .filter(|(_, fixed)| **fixed)
                .for_each(|((to, from), _)| *to = *from);
        }
        if context.is_faint
            && let Some(krylov) = self.stays(context, options)
        {
            work.krylov = krylov;
            return Ok(work);
        }
        self.conserve_guess(context);
        for effect in context.effects.iter_mut() {
            effect.accept_correction(0.0);
        }
        let mut norm = self.evaluate(context, 0)?;
        let mut progress = Progress::new(norm);
        let mut before = None;
        // How Newton's method converged in the last two undamped iterations.
        let mut contraction = None;
        let mut keep_jacobian = false;
        self.linear.strictness = 1.0;
        (context.watch)(Phase::Residual);
        loop {
            work.newton += 1;
            if !keep_jacobian {
                self.assemble_jacobian(context, options.iteration);
                (context.watch)(Phase::Linearisation);
            }
            let advance = self.iterate(context, options, norm, work.newton)?;
            let fell = advance.norm / norm;
            norm = advance.norm;
            work.krylov += advance.krylov;
            work.damping = work.damping.min(advance.damping);
            let changes = self.changes(context);
            if fell > FALLS_SLOWLY && changes[0] <= options.tolerance {
                self.linear.strictness = (STRICTER * self.linear.strictness).min(STRICTEST);
            }
            // The lagged iteration does not speed up, and a damped correction says nothing about the next.
            let undamped = options.iteration == Iteration::Newton && advance.damping == 1.0;
            if let Some(before) = before.filter(|_| undamped) {
                contraction = Some(ConvergenceRate {
                    change: before,
                    theta: changes[0] / before,
                });
            }
            before = undamped.then_some(changes[0]);
            let to_come = match (options.stopping, contraction) {
                (StoppingCriterion::ChangesToCome, Some(contraction)) if undamped => {
                    contraction.changes_after(changes[0])
                }
                _ => changes[0],
            };
            work.error = to_come;
            let judged = match options.stopping {
                StoppingCriterion::LastChange => changes,
                StoppingCriterion::ChangesToCome => [to_come; 3],
            };
            let settled = self.is_settled(context, judged, options);
            let law = self.law_defect(context);
            (context.watch)(Phase::Residual);
            if settled && law.abs() <= SHARE_OF_LAW * options.law_tolerance {
                return Ok(work);
            }
            keep_jacobian = undamped && serves_again(fell, law, options);
            let is_too_long = work.newton >= options.iterations()
                || work.krylov >= KRYLOV_ON_AVERAGE * options.iterations();
            if progress.is_stalled([norm, changes[0]]) || is_too_long {
                return Err(self.not_converged(context, options, work.newton, norm));
            }
        }
    }

    /// Brings the energy law of a solved substep 2 closer to rounding by a few more iterations of
    /// Newton's method. Where one fails, the solution stays what it was.
    pub(in crate::scheme) fn refine(
        &mut self,
        context: &mut StepContext<'_>,
        options: NewtonOptions,
        work: &mut Work,
    ) -> Result<(), StepError> {
        let options = NewtonOptions {
            iteration: Iteration::Newton,
            law_tolerance: REFINED_LAW,
            ..options
        };
        let mass_tolerance = std::mem::replace(&mut self.mass_tolerance, f64::EPSILON);
        let mut outcome = self.evaluate(context, work.newton);
        for _ in 0..REFINEMENTS {
            let Ok(norm) = outcome else { break };
            if self.law_defect(context).abs() <= REFINED_LAW {
                break;
            }
            work.newton += 1;
            self.assemble_jacobian(context, options.iteration);
            (context.watch)(Phase::Linearisation);
            outcome = match self.iterate(context, options, norm, work.newton) {
                Ok(advance) => {
                    work.krylov += advance.krylov;
                    Ok(advance.norm)
                }
                Err(_) => {
                    let [phi, _, mu] = &self.last;
                    context.to.phi.copy_from_slice(phi);
                    context.to.mu.copy_from_slice(mu);
                    let back = self.evaluate(context, work.newton).map(|_| ());
                    self.mass_tolerance = mass_tolerance;
                    return back;
                }
            };
        }
        self.mass_tolerance = mass_tolerance;
        outcome.map(|_| ())
    }

    /// One iteration from the iterate in `to`, whose residual has this norm, with the equations as they were
    /// linearised last.
    fn iterate(
        &mut self,
        context: &mut StepContext<'_>,
        options: NewtonOptions,
        norm: f64,
        iteration: u32,
    ) -> Result<DampedStep, StepError> {
        let goal = self.linear_goal(context, options, norm);
        let krylov = self
            .solve_newton_system(context, goal)
            .map_err(|source| StepError::Membrane { iteration, source })?;
        let sources = [&context.to.phi, &context.to.omega, &context.to.mu];
        for (last, now) in self.last.iter_mut().zip(sources) {
            last.copy_from_slice(now);
        }
        (context.watch)(Phase::Krylov);
        self.tell_correction(context);
        let mut advance = self.advance(context, options, norm, iteration)?;
        advance.krylov += krylov;
        for effect in context.effects.iter_mut() {
            effect.accept_correction(advance.damping);
        }
        Ok(advance)
    }

    /// Tells every effect with a rank-one term what the correction makes of it.
    fn tell_correction(&self, context: &mut StepContext<'_>) {
        let increment = &self.linear.increment[..context.space.nodes()];
        for term in &self.jacobian.rank_one {
            if let Some(effect) = context.effects.iter_mut().nth(term.effect) {
                effect.newton_correction(vector::dot(&term.row, increment));
            }
        }
    }

    /// Moves to the new iterate, with Newton's method damped as the head of this file says.
    fn advance(
        &mut self,
        context: &mut StepContext<'_>,
        options: NewtonOptions,
        norm: f64,
        iteration: u32,
    ) -> Result<DampedStep, StepError> {
        let floor = self.rounding_floor(context);
        let length = self.length_of_correction(context, 0.0);
        let mut damping = 1.0;
        let mut krylov = 0;
        loop {
            self.move_by(context, damping);
            let outcome = self.evaluate(context, iteration);
            let advance = |norm| DampedStep {
                norm,
                damping,
                krylov,
            };
            if options.iteration == Iteration::Lagged {
                return outcome.map(advance);
            }
            let enough = (1.0 - 1e-4 * damping) * norm;
            let mut smaller = 0.5 * damping;
            match outcome {
                Ok(new) if new <= enough.max(floor) => return Ok(advance(new)),
                Ok(new) if damping == 1.0 && self.is_solved(context, options) => {
                    return Ok(advance(new));
                }
                Ok(new) => {
                    self.correction.clone_from(&self.linear.increment);
                    let extrapolated = self.solve_newton_system(context, 0.1 * new);
                    let simplified = self.length_of_correction(context, 0.0);
                    let curvature = self.length_of_correction(context, 1.0 - damping);
                    std::mem::swap(&mut self.correction, &mut self.linear.increment);
                    if let Ok(iterations) = extrapolated {
                        krylov += iterations;
                        if simplified <= (1.0 - 0.25 * damping) * length {
                            return Ok(DampedStep {
                                norm: new,
                                damping,
                                krylov,
                            });
                        }
                        let best = 0.5 * damping * damping * length / curvature;
                        if best.is_finite() {
                            smaller = best.clamp(0.125 * damping, 0.5 * damping);
                        }
                    }
                    if damping <= LEAST_DAMPING {
                        return Err(self.not_converged(context, options, iteration, new));
                    }
                }
                Err(error) if damping <= LEAST_DAMPING => return Err(error),
                Err(_) => {}
            }
            damping = smaller;
        }
    }

    /// To the last iterate and by a part of the correction further.
    fn move_by(&self, context: &mut StepContext<'_>, damping: f64) {
        let size = context.space.nodes();
        let along = |field: &mut [f64], last: &[f64], steps: &[f64]| {
            for ((value, last), step) in field.iter_mut().zip(last).zip(steps) {
                *value = last + damping * step;
            }
        };
        let increment = &self.linear.increment;
        along(&mut context.to.phi, &self.last[0], &increment[..size]);
        if self.clamped {
            along(&mut context.to.mu, &self.last[2], &increment[2 * size..]);
        }
    }

    /// The L2 norm of φ's increment, less this part of the correction that is kept.
    fn length_of_correction(&mut self, context: &StepContext<'_>, part: f64) -> f64 {
        let size = context.space.nodes();
        self.scratch.copy_from_slice(&self.linear.increment[..size]);
        if part != 0.0 {
            vector::add_scaled(&mut self.scratch, -part, &self.correction[..size]);
        }
        vector::weighted_square(&self.scratch, context.space.nodal_weights()).sqrt()
    }

    /// The relative L2 changes of φ, ω, μ between the last two iterates.
    fn changes(&mut self, context: &StepContext<'_>) -> [f64; 3] {
        let weights = context.space.nodal_weights();
        let fields = [&context.to.phi, &context.to.omega, &context.to.mu];
        let mut changes = [0.0; 3];
        for ((change, last), now) in changes.iter_mut().zip(&self.last).zip(fields) {
            for ((difference, now), last) in self.scratch.iter_mut().zip(now).zip(last) {
                *difference = now - last;
            }
            let size = vector::weighted_square(now, weights).max(f64::MIN_POSITIVE);
            *change = (vector::weighted_square(&self.scratch, weights) / size).sqrt();
        }
        changes
    }

    /// Whether the iterate is a solution to the tolerances, though its residual is not smaller than that of the last
    /// one: rounding does not let it be.
    fn is_solved(&mut self, context: &StepContext<'_>, options: NewtonOptions) -> bool {
        let changes = self.changes(context);
        self.is_settled(context, changes, options)
            && self.law_defect(context).abs() <= SHARE_OF_LAW * options.law_tolerance
    }

    /// Whether every field has changed by no more than the tolerance, or φ by no more than rounding: ω and μ follow
    /// from φ, and where they are zero but for rounding their relative changes never end.
    fn is_settled(
        &mut self,
        context: &StepContext<'_>,
        changes: [f64; 3],
        options: NewtonOptions,
    ) -> bool {
        if changes
            .into_iter()
            .all(|change| change <= options.tolerance)
        {
            return true;
        }
        let pairs = context.to.phi.iter().zip(&self.last[0]);
        let step = self.scratch.iter_mut().zip(pairs);
        step.for_each(|(difference, (now, last))| *difference = now - last);
        let weights = context.space.nodal_weights();
        vector::weighted_square(&self.scratch, weights).sqrt() <= self.rounding_of_phase(context)
    }

    /// The L2 norm of a change of φ that is no more than rounding.
    fn rounding_of_phase(&self, context: &StepContext<'_>) -> f64 {
        let weights = context.space.nodal_weights();
        // φ is 1 or −1 where nothing is.
        let size = vector::weighted_square(&context.from.phi, weights).max(vector::sum(weights));
        rounding::CHANGE * size.sqrt()
    }

    /// Whether φⁿ is at rest: whether Newton's correction there is no more than rounding. Then φ and ω are left in
    /// `to` as they were, and the μ without a force, which is constant; returns the Krylov iterations.
    ///
    /// The energy law could not be told of such a step: all its terms are rounding, and with a long Δt its
    /// dissipation is more than the energy.
    fn stays(&mut self, context: &mut StepContext<'_>, options: NewtonOptions) -> Option<u32> {
        for effect in context.effects.iter_mut() {
            effect.accept_correction(0.0);
        }
        context.restart();
        let norm = self.evaluate(context, 0).ok()?;
        (context.watch)(Phase::Residual);
        let rounding = self.rounding_of_phase(context);
        // Where even an explicit step is no more than that, the correction is none either.
        let krylov = if norm <= rounding {
            0
        } else {
            self.assemble_jacobian(context, Iteration::Newton);
            (context.watch)(Phase::Linearisation);
            let goal = self.linear_goal(context, options, norm);
            let krylov = self.solve_newton_system(context, goal).ok()?;
            (context.watch)(Phase::Krylov);
            if self.length_of_correction(context, 0.0) > rounding {
                return None;
            }
            krylov
        };
        let State { omega, mu, .. } = &mut *context.to;
        omega.copy_from_slice(&context.from.omega);
        if self.clamped {
            // What its equation makes of it where there is one.
            self.scratch.fill(0.0);
            self.mass_inverse.solve(
                context.space,
                &self.residual[1],
                &mut self.scratch,
                self.mass_tolerance,
            );
            vector::add_scaled(mu, 1.0, &self.scratch);
        }
        let free = context.space.nodal_weights().iter().zip(&self.fixed);
        let free = free.map(|(weight, fixed)| if *fixed { 0.0 } else { *weight });
        let (mut sum, mut size) = (0.0, 0.0);
        for (weight, mu) in free.zip(&*mu) {
            sum += weight * mu;
            size += weight;
        }
        let mean = sum / size;
        mu.fill(mean);
        Some(krylov)
    }

    /// By how much the energy law will miss: see [`energy_law::expected_residual`].
    fn law_defect(&self, context: &StepContext<'_>) -> f64 {
        energy_law::expected_residual(
            &self.residual,
            [context.from, context.to],
            self.clamped,
            context.energy_scale,
        )
    }

    fn not_converged(
        &mut self,
        context: &StepContext<'_>,
        options: NewtonOptions,
        iterations: u32,
        residual: f64,
    ) -> StepError {
        StepError::NotConverged {
            iterations,
            changes: self.changes(context),
            tolerance: options.tolerance,
            law: self.law_defect(context),
            law_tolerance: options.law_tolerance,
            residual,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_changes_to_come_are_bounded_where_they_fall_fast() {
        let after = |change: f64, theta: f64| {
            let last = ConvergenceRate {
                change: 1e-2,
                theta,
            };
            last.changes_after(change)
        };
        assert!((after(1e-4, 1e-2) - 1e-6 / 0.99).abs() < 1e-18);
        assert!(
            (after(5e-2, 1e-2) - 2.5e-3 / 0.95).abs() < 1e-15,
            "a longer one"
        );
        assert_eq!(after(1e-4, 0.5), 1e-4, "too slow");
        assert_eq!(after(1.0, 1e-2), 1.0, "too long");
    }

    #[test]
    fn a_jacobian_serves_again_where_it_leads_to_the_end() {
        let options = NewtonOptions {
            iteration: Iteration::Newton,
            stopping: StoppingCriterion::LastChange,
            tolerance: 1e-6,
            law_tolerance: 1e-8,
        };
        assert!(serves_again(1e-3, -7e-6, options));
        assert!(!serves_again(1e-3, 9e-6, options), "not far enough");
        assert!(!serves_again(6e-2, 1e-9, options), "too slow");
        assert!(!serves_again(f64::NAN, 1e-9, options));
    }

    #[test]
    fn an_iteration_without_progress_is_given_up() {
        let mut progress = Progress::new(1.0);
        for _ in 1..STALLED_AFTER {
            assert!(!progress.is_stalled([1.0, f64::INFINITY]));
        }
        assert!(!progress.is_stalled([2.0, 0.1]), "a shorter correction");
        for _ in 1..STALLED_AFTER {
            assert!(!progress.is_stalled([0.95, 0.1]));
        }
        assert!(progress.is_stalled([0.95, 0.1]));
    }
}
