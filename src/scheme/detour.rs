//! When the fast path is left, and when it is tried again: small state machines without numerics.

use serde::{Deserialize, Serialize};

/// Steps with the factor before the fast path is tried again; doubled each time it fails once more.
const PATIENCE: u32 = 16;

/// So many slow solves one after the other, and the factor takes over. The first solves of a run, whose
/// guesses are poor, are half as many: with Table 1's step the fast path is the better one from the seventh on, and
/// a factor, which is kept, would double the memory for nothing.
const SLOW_SOLVES: u32 = 12;

/// On small meshes both are so fast that a change is not worth telling.
const LEAST_BREAK_EVEN: f64 = 40.0;

/// Whether the fast path is worth its time. It takes more iterations the longer the step is, the
/// sparse factor about the same time at any Δt: at 120 cells as much as some 40 iterations. That number grows as
/// the factor does against a product, as the square root of the number of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Slowness {
    /// Iterations of a solve at which both take the same time.
    break_even: u32,
    /// Slow solves since the last that was not.
    slow: u32,
}

impl Slowness {
    /// On a mesh of so many nodes, with the fast path of this name.
    pub(super) fn new(nodes: usize, method: &str) -> Self {
        // An iteration with the shifted Laplacians takes about twice as long.
        let share = if method == "shifted" { 0.5 } else { 1.0 };
        let break_even = share * 0.35 * (nodes as f64).sqrt();
        Self {
            break_even: break_even.max(LEAST_BREAK_EVEN) as u32,
            slow: 0,
        }
    }

    /// A solve took so many iterations; returns whether the factor is to take over.
    pub(super) fn is_proved_by(&mut self, iterations: u32) -> bool {
        self.slow = if iterations > self.break_even {
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
}

/// A detour over the sparse factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Detour {
    /// The Δt at which the fast path failed, or was slow.
    failed_at: f64,
    /// Steps solved with the factor since.
    solved: u32,
    /// Of those, how many are wanted before the fast path is tried again.
    patience: u32,
}

impl Detour {
    /// Begins because the fast path failed or was slow at this Δt; `last` is the detour before, if there was one.
    pub(super) fn new(dt: f64, last: Option<Self>) -> Self {
        let patience = last.map_or(PATIENCE, |last| last.patience.saturating_mul(2));
        Self {
            failed_at: dt,
            solved: 0,
            patience,
        }
    }

    /// A step was solved with the factor.
    pub(super) fn advance(&mut self) {
        self.solved = self.solved.saturating_add(1);
    }

    /// Whether the fast path is worth another try: at half the Δt that was too much for it, or when
    /// the state has moved on for a while.
    pub(super) fn is_over(&self, dt: f64) -> bool {
        dt <= 0.5 * self.failed_at || self.solved >= self.patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_solves_in_a_row_prove_it() {
        let mut slowness = Slowness::new(121 * 121, "transform");
        let mut hear = |iterations| slowness.is_proved_by(iterations);
        for _ in 1..SLOW_SOLVES {
            assert!(!hear(43));
        }
        assert!(!hear(42), "as fast as the factor");
        for _ in 1..SLOW_SOLVES {
            assert!(!hear(43));
        }
        assert!(hear(43));
        assert!(hear(43), "still slow when tried again");
        assert!(!hear(42), "no longer");
        assert!(!hear(43), "counts anew");
    }

    #[test]
    fn a_detour_ends_with_a_smaller_step_or_after_a_while_and_then_lasts_longer() {
        let mut detour = Detour::new(1e-3, None);
        assert!(!detour.is_over(1e-3) && detour.is_over(5e-4));
        for _ in 0..PATIENCE {
            assert!(!detour.is_over(1e-3));
            detour.advance();
        }
        assert!(detour.is_over(1e-3));
        let mut again = Detour::new(1e-3, Some(detour));
        for _ in 0..2 * PATIENCE {
            assert!(!again.is_over(1e-3));
            again.advance();
        }
        assert!(again.is_over(1e-3));
    }
}
