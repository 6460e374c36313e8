//! When the fast path, having failed, is tried again: a small state machine without numerics.

use serde::{Deserialize, Serialize};

/// Steps with the factor before the fast path is tried again; doubled each time it fails once more.
const PATIENCE: u32 = 16;

/// A detour over the sparse factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Detour {
    /// The Δt at which the fast path failed.
    failed_at: f64,
    /// Steps solved with the factor since.
    solved: u32,
    /// Of those, how many are wanted before the fast path is tried again.
    patience: u32,
}

impl Detour {
    /// Begins because the fast path failed at this Δt; `last` is the detour before, if there was one.
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
