//! How a step of the fixed grid is divided where it cannot be solved whole: a small state machine
//! without numerics. Pieces are Δt/2^level long and meet the grid's times again; the level falls when
//! pieces go well for a while.

use serde::{Deserialize, Serialize};

/// The smallest piece is Δt/2⁵⁰: from Δt = 1e-3 down to 1e-18, which random phases far from ±1 with a
/// strict area need.
const DEEPEST: u32 = 50;

/// After this many successful pieces they become longer.
const STREAK: u32 = 4;

/// A grid step's length in the smallest pieces.
const WHOLE: u64 = 1 << DEEPEST;

/// Where a run stands in the division of its grid steps.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct StepSubdivision {
    level: u32,
    /// Pieces since the last that failed.
    streak: u32,
    /// Pieces that failed in a row.
    refusals: u32,
    /// How much of the grid step is done.
    done: u64,
    /// The deepest level of the grid step.
    deepest: u32,
}

impl StepSubdivision {
    /// Whether it can be: one that comes from a file may hold any numbers.
    pub(super) fn is_possible(&self) -> bool {
        let length = WHOLE.checked_shr(self.level).unwrap_or(0);
        self.level <= DEEPEST && self.done < WHOLE && self.done.is_multiple_of(length)
    }

    /// The next piece, as a fraction of the grid step.
    pub(super) fn piece(&self) -> f64 {
        (f64::from(self.level)).exp2().recip()
    }

    /// How much of the grid step is done, as a fraction.
    pub(super) fn done(&self) -> f64 {
        self.done as f64 / WHOLE as f64
    }

    /// The smallest piece of the grid step so far, as a fraction.
    pub(super) fn smallest(&self) -> f64 {
        (f64::from(self.deepest)).exp2().recip()
    }

    /// The piece was solved; returns whether the grid step is done, and begins the next one if so.
    pub(super) fn accept(&mut self) -> bool {
        let length = WHOLE >> self.level;
        self.done += length;
        self.streak = self.streak.saturating_add(1);
        self.refusals = 0;
        let whole = self.done == WHOLE;
        // Only where a longer piece would end on its own grid.
        if self.level > 0 && self.streak >= STREAK && self.done.is_multiple_of(2 * length) {
            self.level -= 1;
            self.streak = 0;
        }
        if whole {
            self.done = 0;
        }
        whole
    }

    /// To be called before the first piece of a grid step.
    pub(super) fn begin(&mut self) {
        self.deepest = self.level;
    }

    /// The piece was not solved; returns whether a smaller one may be tried.
    pub(super) fn refuse(&mut self) -> bool {
        self.streak = 0;
        if self.level == DEEPEST {
            return false;
        }
        // Where the right Δt is far, it is reached by longer and longer leaps.
        let leap = self.refusals.saturating_sub(1).max(1);
        self.refusals = self.refusals.saturating_add(1);
        self.level = self.level.saturating_add(leap).min(DEEPEST);
        self.deepest = self.deepest.max(self.level);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes a grid step in which pieces longer than `limit` fail; returns the pieces.
    fn grid_step(subdivision: &mut StepSubdivision, limit: f64) -> Vec<f64> {
        let mut pieces = Vec::new();
        subdivision.begin();
        loop {
            let piece = subdivision.piece();
            if piece > limit {
                assert!(subdivision.refuse());
                continue;
            }
            pieces.push(piece);
            if subdivision.accept() {
                return pieces;
            }
        }
    }

    #[test]
    fn pieces_meet_the_grid_and_grow_back() {
        let mut subdivision = StepSubdivision::default();
        assert_eq!(grid_step(&mut subdivision, 1.0), [1.0]);
        let pieces = grid_step(&mut subdivision, 0.13);
        assert_eq!(pieces.iter().sum::<f64>(), 1.0);
        assert_eq!(subdivision.smallest(), 0.125);
        assert_eq!(pieces.iter().cloned().fold(1.0, f64::min), 0.125);
        let mut steps = 0;
        while grid_step(&mut subdivision, 1.0) != [1.0] {
            steps += 1;
        }
        assert!(steps <= 4, "{steps}");
        grid_step(&mut subdivision, 1.0);
        assert_eq!(subdivision.smallest(), 1.0);
    }

    #[test]
    fn there_is_a_last_rung() {
        let mut subdivision = StepSubdivision::default();
        subdivision.begin();
        while subdivision.piece() > f64::from(DEEPEST).exp2().recip() {
            assert!(subdivision.refuse());
        }
        assert!(!subdivision.refuse());
        assert_eq!(subdivision.smallest(), 0.5_f64.powi(50));
    }
}
