//! When the fast path is left, and when it is tried again: small state machines without numerics.

use serde::{Deserialize, Serialize};

/// Steps with the factor before the fast path is tried again; doubled each time it fails once more.
const RETRY_AFTER: u32 = 16;

/// The same where it was only slow: a slow solve takes as long as some ten with the factor.
const RETRY_AFTER_SLOW: u32 = 64;

/// So many slow solves one after the other, and the factor takes over. The first solves of a run, whose
/// guesses are poor, are slow in any case: with Table 1's step the fast path is the better one from the eighth
/// on.
const SLOW_SOLVES: u32 = 10;

/// Iterations of a linear system from which on the sparse factor, made once in a few systems, is clearly faster
/// than the cosine transform. They take the same time at 13 to 14, on 60, 120 and 240 cells (`vesica run case3
/// --steps 12 --set time.step=2e-6 --set solver.linear=…`: `milliseconds` over `newton` and `krylov` in
/// `run.json`).
const BREAK_EVEN: u32 = 18;

/// The same with the shifted Laplacians, whose iterations take about twice as long.
const BREAK_EVEN_SHIFTED: u32 = BREAK_EVEN / 2;

/// Whether the fast path is worth its time. It takes more iterations the longer the step is, the
/// sparse factor about the same time at any Δt.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(in crate::scheme) struct SlowSolveDetector {
    break_even: u32,
    /// Slow solves since the last that was not.
    slow: u32,
}

impl SlowSolveDetector {
    /// With the fast path of this name.
    pub(in crate::scheme) fn new(method: &str) -> Self {
        Self {
            break_even: match method {
                "shifted" => BREAK_EVEN_SHIFTED,
                _ => BREAK_EVEN,
            },
            slow: 0,
        }
    }

    /// Where the factor was begun with: a single slow solve is enough then.
    pub(in crate::scheme) fn suspected(self) -> Self {
        Self {
            slow: SLOW_SOLVES - 1,
            ..self
        }
    }

    /// A step took so many corrections and for them, in all, so many iterations; returns whether the
    /// factor is to take over.
    pub(in crate::scheme) fn is_proved_by(&mut self, corrections: u32, iterations: u32) -> bool {
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
    pub(in crate::scheme) fn is_refuted(self) -> bool {
        self.slow == 0
    }
}

/// A detour over the sparse factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(in crate::scheme) struct FallbackPeriod {
    /// The Δt at which the fast path failed, or was slow.
    failed_at: f64,
    /// Steps solved with the factor since.
    solved: u32,
    /// Of those, how many are wanted before the fast path is tried again.
    patience: u32,
}

impl FallbackPeriod {
    /// Begins because the fast path failed at this Δt; `last` is the detour before, if there was one.
    pub(in crate::scheme) fn new(dt: f64, last: Option<Self>) -> Self {
        Self::with_patience(RETRY_AFTER, dt, last)
    }

    /// Begins because the fast path was slow.
    pub(in crate::scheme) fn from_slowness(dt: f64, last: Option<Self>) -> Self {
        Self::with_patience(RETRY_AFTER_SLOW, dt, last)
    }

    /// Begins with the run: the fast path is expected to be slow at any Δt.
    pub(in crate::scheme) fn from_the_start() -> Self {
        Self::from_slowness(0.0, None)
    }

    fn with_patience(least: u32, dt: f64, last: Option<Self>) -> Self {
        let patience = last.map_or(least, |last| last.patience.saturating_mul(2).max(least));
        Self {
            failed_at: dt,
            solved: 0,
            patience,
        }
    }

    /// A step was solved with the factor.
    pub(in crate::scheme) fn advance(&mut self) {
        self.solved = self.solved.saturating_add(1);
    }

    /// Whether the fast path is worth another try: at half the Δt that was too much for it, or when
    /// the state has moved on for a while.
    pub(in crate::scheme) fn is_over(&self, dt: f64) -> bool {
        dt <= 0.5 * self.failed_at || self.solved >= self.patience
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
    fn a_detour_ends_with_a_smaller_step_or_after_a_while_and_then_lasts_longer() {
        let mut fallback = FallbackPeriod::new(1e-3, None);
        assert!(!fallback.is_over(1e-3) && fallback.is_over(5e-4));
        for _ in 0..RETRY_AFTER {
            assert!(!fallback.is_over(1e-3));
            fallback.advance();
        }
        assert!(fallback.is_over(1e-3));
        let mut again = FallbackPeriod::new(1e-3, Some(fallback));
        for _ in 0..2 * RETRY_AFTER {
            assert!(!again.is_over(1e-3));
            again.advance();
        }
        assert!(again.is_over(1e-3));
        assert!(!FallbackPeriod::from_the_start().is_over(f64::MIN_POSITIVE));
        let slow = FallbackPeriod::from_slowness(1e-3, None);
        assert!(slow.patience > RETRY_AFTER);
        assert_eq!(
            FallbackPeriod::from_slowness(1e-3, Some(slow)).patience,
            2 * slow.patience
        );
    }
}
