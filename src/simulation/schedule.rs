//! Which steps of a run are recorded, and at which the fields are kept.

use crate::scene::Time;

/// The number of steps of a run: T/Δt, rounded. t_n = n·Δt.
pub fn step_count(time: &Time) -> u64 {
    // A cast from f64 saturates; a scene's Δt and T are positive and finite.
    (time.end / time.step).round() as u64
}

/// Which steps of a run leave a row in the tables, and which a snapshot of the fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    /// The last step.
    pub steps: u64,
    /// A row at every multiple of this (and at the last step).
    pub every: u64,
    /// How many snapshots, evenly from t = 0 to T; 1 is the one at T.
    pub snapshots: u64,
}

impl Schedule {
    /// Whether the tables get a row at this step.
    pub fn row_due(&self, step: u64) -> bool {
        self.row_in_turn(step) || step == self.steps
    }

    /// Whether they get it whenever the run ends.
    pub fn row_in_turn(&self, step: u64) -> bool {
        step.is_multiple_of(self.every.max(1))
    }

    /// Whether the fields are written at this step.
    ///
    /// Snapshot k of n is at the step nearest to k·T/(n − 1), the later one of two; where there
    /// are more snapshots than steps, several fall together and are one.
    pub fn snapshot_due(&self, step: u64) -> bool {
        if self.snapshots < 2 || self.steps == 0 {
            return self.snapshots > 0 && step == self.steps;
        }
        let steps = u128::from(self.steps);
        let intervals = u128::from(self.snapshots) - 1;
        let step = u128::from(step);
        // step = ⌊k·steps/intervals + ½⌋ for some k: if for any, then for the least k that
        // is not before the step's lower end, (step − ½)·intervals/steps.
        let twice_lower_end = (2 * step).saturating_sub(1) * intervals;
        let k = twice_lower_end.div_ceil(2 * steps);
        k <= intervals && (2 * k * steps + intervals) / (2 * intervals) == step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn due(steps: u64, snapshots: u64) -> Vec<u64> {
        let schedule = Schedule {
            steps,
            every: 1,
            snapshots,
        };
        (0..=steps).filter(|&n| schedule.snapshot_due(n)).collect()
    }

    #[test]
    fn five_snapshots_are_at_the_quarters() {
        assert_eq!(due(10_000, 5), [0, 2500, 5000, 7500, 10_000]);
        assert_eq!(due(10, 5), [0, 3, 5, 8, 10]);
        assert_eq!(due(3, 5), [0, 1, 2, 3]);
        assert_eq!(due(7, 1), [7]);
        assert_eq!(due(7, 2), [0, 7]);
        assert!(due(7, 0).is_empty());
        assert_eq!(due(0, 5), [0]);
    }

    #[test]
    fn a_row_every_so_many_steps_and_at_the_end() {
        let schedule = Schedule {
            steps: 10,
            every: 4,
            snapshots: 5,
        };
        let rows: Vec<u64> = (0..=10).filter(|&n| schedule.row_due(n)).collect();
        assert_eq!(rows, [0, 4, 8, 10]);
    }

    #[test]
    fn the_number_of_steps_is_rounded() {
        let time = |step, end| Time { step, end };
        assert_eq!(step_count(&time(1e-7, 1e-3)), 10_000);
        assert_eq!(step_count(&time(5e-7, 5e-5)), 100);
        assert_eq!(step_count(&time(0.1, 0.3)), 3);
        assert_eq!(step_count(&time(1.0, 0.4)), 0);
    }

    proptest! {
        #[test]
        fn is_the_plain_definition(steps in 1u64..60, snapshots in 2u64..90) {
            let mut plain: Vec<u64> = (0..snapshots)
                .map(|k| (2 * k * steps + snapshots - 1) / (2 * (snapshots - 1)))
                .collect();
            plain.dedup();
            prop_assert_eq!(due(steps, snapshots), plain);
        }
    }
}
