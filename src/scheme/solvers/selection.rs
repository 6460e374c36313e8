//! Which linear solver and which iteration a step begins with, when one is replaced by another, and when it is
//! tried again: small state machines without numerics.
//!
//! The fast solver (a transform of the grid or shifted Laplacians) is left where it fails, for [`RETRY_AFTER`] steps, or
//! where it was slow ten times in a row, for [`RETRY_AFTER_SLOW`]; twice as long each time that happens again. The
//! lagged iteration is replaced by Newton's method in the same way.

use serde::{Deserialize, Serialize};

use crate::scene::Iteration;

/// Steps with the factor before the fast path is tried again; doubled each time that it fails again.
const RETRY_AFTER: u32 = 16;

/// The same where it was only slow: a slow solve takes as long as some ten with the factor.
const RETRY_AFTER_SLOW: u32 = 64;

/// So many slow solves one after the other, and the factor takes over. The first solves of a run, whose
/// guesses are poor, are slow in any case: with Table 1's step the fast path is the better one from the eighth
/// on.
const SLOW_SOLVES: u32 = 10;

/// Iterations of a linear system from which on the sparse factor, made once in a few systems, is clearly faster
/// than the transform of the grid. They take the same time at 13 to 14, on 60, 120 and 240 cells (`vesica run case3
/// --steps 12 --set time.step=2e-6 --set solver.linear=…`: `milliseconds` over `newton` and `krylov` in
/// `run.json`).
const BREAK_EVEN: u32 = 18;

/// The same with the shifted Laplacians, whose iterations take about twice as long.
const BREAK_EVEN_SHIFTED: u32 = BREAK_EVEN / 2;

/// Which linear solver and which iteration run at present.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(in crate::scheme) struct Selection {
    /// The period with the sparse factor that is under way, or the last one.
    fallback: Option<FallbackPeriod>,
    /// The period with Newton's method in place of the lagged iteration that is under way, or the last one.
    newton_fallback: Option<FallbackPeriod>,
    slow_solves: SlowSolveDetector,
}

/// What follows from the work of a step with the fast solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scheme) enum Verdict {
    /// It is slower than the factor, which is to take over.
    TooSlow,
    /// It is fast enough: a factor that was kept ready is not needed.
    Fast,
    /// Another slow solve will decide.
    Undecided,
}

impl Selection {
    /// At the start of a run, with the fast solver of this name.
    pub(in crate::scheme) fn new(method: &str) -> Self {
        Self {
            slow_solves: SlowSolveDetector::new(method),
            ..Self::default()
        }
    }

    /// The run begins with the factor: the fast solver is expected to be slow at any Δt.
    pub(in crate::scheme) fn begin_with_factor(&mut self) {
        self.fallback = Some(FallbackPeriod::from_slowness(0.0, None));
        self.slow_solves = self.slow_solves.suspected();
    }

    /// Whether a fast solver that was left is to be tried again at this Δt.
    pub(in crate::scheme) fn retries_fast(&self, dt: f64) -> bool {
        self.fallback.is_some_and(|fallback| fallback.is_over(dt))
    }

    /// The iteration to begin with, where the scene asks for `wanted`.
    pub(in crate::scheme) fn iteration(&self, wanted: Iteration, dt: f64) -> Iteration {
        match self.newton_fallback {
            Some(fallback) if !fallback.is_over(dt) => Iteration::Newton,
            _ => wanted,
        }
    }

    /// The lagged iteration failed at this Δt.
    pub(in crate::scheme) fn lagged_failed(&mut self, dt: f64) {
        self.newton_fallback = Some(FallbackPeriod::new(dt, self.newton_fallback));
    }

    /// The fast solver failed at this Δt.
    pub(in crate::scheme) fn fast_failed(&mut self, dt: f64) {
        self.fallback = Some(FallbackPeriod::new(dt, self.fallback));
    }

    /// The fast solver was slow at this Δt, and the factor has taken over.
    pub(in crate::scheme) fn fast_was_slow(&mut self, dt: f64) {
        self.fallback = Some(FallbackPeriod::from_slowness(dt, self.fallback));
    }

    /// A step was solved.
    pub(in crate::scheme) fn solved(&mut self, with_factor: bool) {
        let fallback = self.fallback.as_mut().filter(|_| with_factor);
        let periods = [fallback, self.newton_fallback.as_mut()];
        periods
            .into_iter()
            .flatten()
            .for_each(FallbackPeriod::advance);
    }

    /// Judges the fast solver by a step that it has solved: so many corrections of Newton's method, and for them, in
    /// all, so many Krylov iterations.
    pub(in crate::scheme) fn judge(&mut self, corrections: u32, iterations: u32) -> Verdict {
        if self.slow_solves.is_proved_by(corrections, iterations) {
            Verdict::TooSlow
        } else if self.slow_solves.is_refuted() {
            Verdict::Fast
        } else {
            Verdict::Undecided
        }
    }
}

/// Whether the fast solver is slower than the factor. It takes more iterations the longer the step is, the sparse
/// factor about the same time at any Δt.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct SlowSolveDetector {
    break_even: u32,
    /// Slow solves since the last that was not.
    slow: u32,
}

impl SlowSolveDetector {
    /// With the fast path of this name.
    fn new(method: &str) -> Self {
        Self {
            break_even: match method {
                "shifted" => BREAK_EVEN_SHIFTED,
                _ => BREAK_EVEN,
            },
            slow: 0,
        }
    }

    /// Where the factor was begun with: a single slow solve is enough then.
    fn suspected(self) -> Self {
        Self {
            slow: SLOW_SOLVES - 1,
            ..self
        }
    }

    /// A step took so many corrections and for them, in all, so many iterations; returns whether the
    /// factor is to take over.
    fn is_proved_by(&mut self, corrections: u32, iterations: u32) -> bool {
        self.slow = if iterations > self.break_even * corrections {
            self.slow.saturating_add(1)
        } else {
            0
        };
        let proved = self.slow >= SLOW_SOLVES;
        if proved {
            // One more is enough where the fast path is tried again.
            self.slow = SLOW_SOLVES - 1;
        }
        proved
    }

    /// Whether the last solve was fast enough.
    fn is_refuted(self) -> bool {
        self.slow == 0
    }
}

/// A period in which a step begins with the slower but safer way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct FallbackPeriod {
    /// The Δt at which the fast path failed, or was slow.
    failed_at: f64,
    /// Steps solved with the factor since.
    solved: u32,
    /// Of those, how many are wanted before the fast path is tried again.
    wait: u32,
}

impl FallbackPeriod {
    /// Begins because the faster way failed at this Δt; `last` is the period before, if there was one.
    fn new(dt: f64, last: Option<Self>) -> Self {
        Self::lasting(RETRY_AFTER, dt, last)
    }

    /// Begins because the fast path was slow.
    fn from_slowness(dt: f64, last: Option<Self>) -> Self {
        Self::lasting(RETRY_AFTER_SLOW, dt, last)
    }

    fn lasting(least: u32, dt: f64, last: Option<Self>) -> Self {
        let wait = last.map_or(least, |last| last.wait.saturating_mul(2).max(least));
        Self {
            failed_at: dt,
            solved: 0,
            wait,
        }
    }

    /// A step was solved with the factor.
    fn advance(&mut self) {
        self.solved = self.solved.saturating_add(1);
    }

    /// Whether the fast path is worth another try: at half the Δt that was too much for it, or when
    /// the state has moved on for a while.
    fn is_over(&self, dt: f64) -> bool {
        dt <= 0.5 * self.failed_at || self.solved >= self.wait
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_solves_in_a_row_prove_it() {
        let mut slow_solves = SlowSolveDetector::new("transform");
        let mut hear = |iterations| slow_solves.is_proved_by(3, iterations);
        for _ in 1..SLOW_SOLVES {
            assert!(!hear(3 * BREAK_EVEN + 1));
        }
        assert!(!hear(3 * BREAK_EVEN), "as fast as the factor");
        for _ in 1..SLOW_SOLVES {
            assert!(!hear(3 * BREAK_EVEN + 1));
        }
        assert!(hear(3 * BREAK_EVEN + 1));
        assert!(hear(3 * BREAK_EVEN + 1), "still slow when tried again");
        assert!(!slow_solves.is_refuted());
        assert!(!slow_solves.is_proved_by(3, 3 * BREAK_EVEN), "no longer");
        assert!(slow_solves.is_refuted());
        assert!(
            !slow_solves.is_proved_by(3, 3 * BREAK_EVEN + 1),
            "counts anew"
        );
        assert!(slow_solves.suspected().is_proved_by(3, 3 * BREAK_EVEN + 1));
    }

    #[test]
    fn a_period_ends_with_a_smaller_step_or_after_a_while_and_then_lasts_longer() {
        let mut period = FallbackPeriod::new(1e-3, None);
        assert!(!period.is_over(1e-3) && period.is_over(5e-4));
        for _ in 0..RETRY_AFTER {
            assert!(!period.is_over(1e-3));
            period.advance();
        }
        assert!(period.is_over(1e-3));
        let mut again = FallbackPeriod::new(1e-3, Some(period));
        for _ in 0..2 * RETRY_AFTER {
            assert!(!again.is_over(1e-3));
            again.advance();
        }
        assert!(again.is_over(1e-3));
        assert!(!FallbackPeriod::from_slowness(0.0, None).is_over(f64::MIN_POSITIVE));
        let slow = FallbackPeriod::from_slowness(1e-3, None);
        assert!(slow.wait > RETRY_AFTER);
        assert_eq!(
            FallbackPeriod::from_slowness(1e-3, Some(slow)).wait,
            2 * slow.wait
        );
    }
}
