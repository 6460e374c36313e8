//! How Δt is chosen: a small state machine without numerics.
//!
//! A step comes with the estimate of its error, e(Δt) ≈ C Δtᵏ, and is accepted if e is at most a bound b. The next Δt is
//! the one at which the estimate is expected to be σᵏb, σ = 0.9: Δt·σ(b/e)^(1/k) if C stays what it is, and less, by
//! Gustafsson's predictive rule, if C has grown from step to step. The errors of all steps are so about equal, which for
//! their number is the least sum.
//!
//! The times at which a run must be, those of snapshots and T, are met exactly: a step that would
//! pass one ends there, and the one before is shortened so that the two are of equal length; what is left over
//! by a few per cent is taken along.

use serde::{Deserialize, Serialize};

/// σ: to stay below the tolerance rather than to find out.
const SAFETY: f64 = 0.9;

/// By how much Δt grows or shrinks from one step to the next.
const LARGEST_CHANGE: f64 = 5.0;

/// Growth by less than this is not worth another matrix and a worse guess.
const LEAST_GROWTH: f64 = 1.15;

/// By how much a step may be longer than planned in order to land: e then grows by 1.05ᵏ, to less than
/// σᵏ allows for.
const STRETCH: f64 = 1.05;

/// After a step that could not be solved.
const AFTER_FAILURE: f64 = 0.25;

/// The first step on another mesh, over the last one before it. With 0.1 the quick presets took a seventh more steps; with 0.6 an
/// error after fifty transfers was 1.4 times as large.
const AFTER_KICK: f64 = 0.3;

/// After this many consecutive failures and refusals the run gives up.
const MOST_ATTEMPTS: u32 = 60;

/// Where a run stands in the choice of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Controller {
    bound: f64,
    /// 1/k.
    exponent: f64,
    /// The Δt that is tried next.
    next: f64,
    /// Δt and the estimate of the last accepted step.
    last: Option<(f64, f64)>,
    /// The Δt that is tried first, and after an event.
    first: f64,
    /// Attempts since then.
    attempts: u32,
}

/// The step to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Attempt {
    /// Its Δt.
    pub dt: f64,
    /// The time at its end.
    pub end: f64,
}

impl Controller {
    /// With the bound of the estimate, its order k, and the Δt that is tried first.
    pub(super) fn new(bound: f64, order: u32, first: f64) -> Self {
        Self {
            bound,
            exponent: f64::from(order).recip(),
            next: first,
            first,
            last: None,
            attempts: 0,
        }
    }

    /// Whether a run that is paced as `own` can continue with it: one that comes from a file may hold
    /// any numbers.
    pub(super) fn fits(&self, own: &Self) -> bool {
        let is_length = |value: f64| value.is_finite() && value > 0.0;
        self.bound == own.bound
            && self.exponent == own.exponent
            && is_length(self.next)
            && self.attempts < MOST_ATTEMPTS
            && self
                .last
                .is_none_or(|(dt, error)| is_length(dt) && error.is_finite() && error >= 0.0)
    }

    /// The step to try from t, when the run must be at `landing` exactly.
    pub(super) fn attempt(&self, t: f64, landing: f64) -> Attempt {
        let rest = landing - t;
        if rest <= STRETCH * self.next {
            Attempt {
                dt: rest,
                end: landing,
            }
        } else if rest < 2.0 * STRETCH * self.next {
            let dt = 0.5 * rest;
            Attempt { dt, end: t + dt }
        } else {
            Attempt {
                dt: self.next,
                end: t + self.next,
            }
        }
    }

    /// Judges a step that was solved by its estimated error; returns whether it is accepted.
    pub(super) fn judge(&mut self, dt: f64, error: f64) -> bool {
        // A state that does not move has no error: the largest change then.
        let plain = SAFETY * (self.bound / error.max(f64::MIN_POSITIVE)).powf(self.exponent);
        if error <= self.bound {
            let predicted = match self.last {
                Some((last, before)) if error > 0.0 && self.attempts == 0 => {
                    plain * dt / last * (before / error).powf(self.exponent)
                }
                _ => plain,
            };
            let mut change = plain.min(predicted);
            change = change.clamp(LARGEST_CHANGE.recip(), LARGEST_CHANGE);
            if self.attempts > 0 {
                change = change.min(1.0);
            }
            if !(1.0..LEAST_GROWTH).contains(&change) {
                // A step that was shortened to land says nothing against the Δt that was planned.
                let shortened = dt < self.next && change >= 1.0;
                self.next = if shortened {
                    self.next.max(change * dt)
                } else {
                    change * dt
                };
            }
            self.last = Some((dt, error));
            self.attempts = 0;
            return true;
        }
        self.attempts += 1;
        // In the layer at the start of a run, where what is stiff dies away, the estimate hardly falls with
        // Δt: the second refusal is answered by more than the estimate asks for.
        let steeper = SAFETY * 0.5_f64.powi(self.attempts as i32 - 1);
        self.next = dt * plain.min(steeper).max(LARGEST_CHANGE.recip());
        false
    }

    /// The next step is to be no longer than this one.
    pub(super) fn stay(&mut self, dt: f64) {
        self.next = self.next.min(dt);
    }

    /// The step could not be solved; returns whether a smaller one may be tried.
    pub(super) fn fail(&mut self, dt: f64) -> bool {
        self.attempts += 1;
        self.next = AFTER_FAILURE * dt;
        self.may_go_on()
    }

    /// Whether another attempt makes sense.
    pub(super) fn may_go_on(&self) -> bool {
        self.attempts < MOST_ATTEMPTS
    }

    /// The state was brought to another mesh: what was learnt of the error is void, and what the mesh has left of stiff modes
    /// must die away.
    pub(super) fn expect_kick(&mut self) {
        self.last = None;
        self.next *= AFTER_KICK;
    }

    /// The equations or the state changed from outside: what was learnt of the error is void, and what is stiff is there again.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.next = self.next.min(self.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Goes from 0 to `landings` with the error c(t) Δt²; the accepted steps.
    fn run(tolerance: f64, landings: &[f64], constant: impl Fn(f64) -> f64) -> (Vec<Attempt>, u32) {
        let mut controller = Controller::new(tolerance, 2, 1e-7);
        let (mut t, mut steps, mut refused) = (0.0, Vec::new(), 0);
        for &landing in landings {
            while t < landing {
                let attempt = controller.attempt(t, landing);
                assert!(attempt.dt > 0.0 && attempt.end > t && attempt.end <= landing);
                if controller.judge(attempt.dt, constant(t) * attempt.dt * attempt.dt) {
                    t = attempt.end;
                    steps.push(attempt);
                } else {
                    refused += 1;
                    assert!(controller.may_go_on());
                }
            }
            assert_eq!(t, landing, "met exactly");
        }
        (steps, refused)
    }

    #[test]
    fn finds_the_step_whose_error_is_just_allowed() {
        let (steps, refused) = run(1e-4, &[1.0], |_| 1e2);
        // c Δt² = σ² τ
        let expected = 0.9 * (1e-4_f64 / 1e2).sqrt();
        let middle = steps[steps.len() / 2].dt;
        assert!(middle <= expected * (1.0 + 1e-12) && middle > expected / LEAST_GROWTH);
        assert_eq!(refused, 0);
        assert!(steps.len() < 20 + (1.0 / middle) as usize);
    }

    #[test]
    fn the_number_of_steps_is_that_of_the_square_root_of_the_tolerance() {
        let number = |tolerance| run(tolerance, &[1.0], |_| 1e2).0.len() as f64;
        let ratio = number(1e-8) / number(1e-6);
        assert!((ratio - 10.0).abs() < 1.5, "{ratio}");
    }

    #[test]
    fn a_sudden_event_is_met_by_few_refusals() {
        // A hundred times the error in a tenth of the time, as when the membrane snaps.
        let sudden = |t: f64| {
            if (0.5..0.6).contains(&t) { 1e4 } else { 1e2 }
        };
        let (steps, refused) = run(1e-4, &[1.0], sudden);
        assert!((1..=3).contains(&refused), "{refused}");
        let inside = steps.iter().filter(|step| (0.5..0.6).contains(&step.end));
        assert!(inside.clone().count() > 500);
        // A gradual one by none: the predictive rule.
        let (_, refused) = run(1e-4, &[1.0], |t| 1e2 * (4.0 * t).exp());
        assert_eq!(refused, 0);
    }

    #[test]
    fn what_is_left_over_before_a_landing_is_taken_along() {
        let controller = Controller::new(1e-4, 2, 1.0);
        let lengths = [0.5, 1.04, 1.06, 2.08, 2.2].map(|rest| controller.attempt(0.0, rest).dt);
        assert_eq!(lengths, [0.5, 1.04, 0.53, 1.04, 1.0]);
    }

    #[test]
    fn gives_up_in_the_end() {
        let mut controller = Controller::new(1e-4, 2, 1.0);
        let mut failures = 1;
        let mut dt = 1.0;
        while controller.fail(dt) {
            failures += 1;
            dt = controller.attempt(0.0, 1.0).dt;
        }
        assert_eq!(failures, MOST_ATTEMPTS);
        assert!(dt < 1e-30);
    }

    #[test]
    fn a_state_at_rest_is_followed_by_longer_steps() {
        let mut controller = Controller::new(1e-4, 2, 1e-3);
        assert!(controller.judge(1e-3, 0.0));
        assert_eq!(controller.attempt(0.0, 1.0).dt, 5e-3);
    }

    proptest! {
        #[test]
        fn every_landing_is_met(
            tolerance in 1e-6..1e-2,
            mut landings in prop::collection::vec(1e-3..1.0, 1..9),
            constant in 1.0..1e4,
        ) {
            landings.sort_by(f64::total_cmp);
            landings.dedup();
            let (steps, _) = run(tolerance, &landings, |t| constant * (1.0 + (9.0 * t).sin().abs()));
            for step in steps {
                prop_assert!(constant * step.dt * step.dt <= tolerance);
            }
        }

        #[test]
        fn judges_by_the_tolerance_alone(error in 0.0..2e-4, dt in 1e-9..1e-3) {
            let mut controller = Controller::new(1e-4, 2, dt);
            prop_assert_eq!(controller.judge(dt, error), error <= 1e-4);
            let next = controller.attempt(0.0, f64::INFINITY).dt;
            prop_assert!(next.is_finite() && next >= 0.19 * dt && next <= 5.01 * dt);
            prop_assert!(error <= 1e-4 || next < dt);
        }
    }
}
