//! Which steps of a run are recorded, and at which the fields are kept.

use super::Report;
use crate::scene::Time;

/// The number of steps of a run: T/Δt, rounded. t_n = n·Δt. `None` where Δt is chosen on the way.
pub fn step_count(time: &Time) -> Option<u64> {
    time.steps()
}

/// Which steps of a run leave a row in the tables, and which a snapshot of the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// The last step; `None` where Δt is chosen: then the last is the one that ends at T.
    pub steps: Option<u64>,
    /// T.
    pub end: f64,
    /// A row at every multiple of this (and at the last step).
    pub every: u64,
    /// How many snapshots, evenly from t = 0 to T; 1 is the one at T.
    pub snapshots: u64,
}

impl Schedule {
    /// Of a run over this time.
    pub fn new(time: &Time, every: u64, snapshots: u64) -> Self {
        Self {
            steps: step_count(time),
            end: time.end,
            every,
            snapshots,
        }
    }

    /// Whether a run that stands at this step and this time is at its end.
    pub fn is_over(&self, step: u64, t: f64) -> bool {
        match self.steps {
            Some(steps) => step >= steps,
            None => t >= self.end,
        }
    }

    /// Whether a run with this last step is at its end, or at rest before.
    pub fn is_done(&self, report: &Report) -> bool {
        report.is_at_rest || self.is_over(report.step, report.t)
    }

    /// Whether the fields are written after this step: also at rest, if there are any snapshots.
    pub fn is_snapshot_due(&self, report: &Report) -> bool {
        report.is_at_rest && self.snapshots > 0 || self.snapshot_due(report.step, report.t)
    }

    /// How much of the run is done, from 0 to 1.
    pub fn share(&self, step: u64, t: f64) -> f64 {
        match self.steps {
            Some(0) => 1.0,
            Some(steps) => (step as f64 / steps as f64).min(1.0),
            None => (t / self.end).clamp(0.0, 1.0),
        }
    }

    /// Whether the tables get a row at this step.
    pub fn row_due(&self, step: u64, t: f64) -> bool {
        self.row_in_turn(step) || self.is_over(step, t)
    }

    /// Whether they get it whenever the run ends.
    pub fn row_in_turn(&self, step: u64) -> bool {
        step.is_multiple_of(self.every.max(1))
    }

    /// Whether the fields are written at this step.
    ///
    /// Snapshot k of n is at the time k·T/(n − 1), which a run with chosen steps meets exactly. On a
    /// fixed grid it is at the step nearest to that, the later one of two; where there
    /// are more snapshots than steps, several fall together and are one.
    pub fn snapshot_due(&self, step: u64, t: f64) -> bool {
        if self.snapshots < 2 || self.steps == Some(0) {
            return self.snapshots > 0 && self.is_over(step, t);
        }
        let Some(steps) = self.steps else {
            return self.landing(self.interval_of(t)) == t || t >= self.end;
        };
        let steps = u128::from(steps);
        let intervals = u128::from(self.snapshots) - 1;
        let step = u128::from(step);
        // step = ⌊k·steps/intervals + ½⌋ for some k: if for any, then for the least k that
        // is not before the step's lower end, (step − ½)·intervals/steps.
        let twice_lower_end = (2 * step).saturating_sub(1) * intervals;
        let k = twice_lower_end.div_ceil(2 * steps);
        k <= intervals && (2 * k * steps + intervals) / (2 * intervals) == step
    }

    /// The times of the snapshots of a run whose fixed grid, if it has one, has this step.
    pub fn snapshot_times(&self, step: f64) -> Vec<f64> {
        if self.snapshots == 0 {
            return Vec::new();
        }
        let intervals = self.snapshots.max(2) - 1;
        let first = if self.snapshots == 1 { intervals } else { 0 };
        let mut times: Vec<f64> = match self.steps {
            None => (first..=intervals).map(|k| self.landing(k)).collect(),
            Some(steps) => {
                // With more snapshots than steps there is one at every step.
                let intervals = intervals.min(steps.max(1));
                let [steps, intervals] = [steps, intervals].map(u128::from);
                let due = |k: u128| (2 * k * steps + intervals) / (2 * intervals);
                (u128::from(first).min(intervals)..=intervals)
                    .map(|k| due(k) as f64 * step)
                    .collect()
            }
        };
        times.dedup();
        times
    }

    /// The next time after t at which a run with chosen steps must be: that of the next snapshot, or T;
    /// infinite from T on.
    pub fn landing_after(&self, t: f64) -> f64 {
        if t >= self.end {
            return f64::INFINITY;
        }
        let next = self.interval_of(t);
        // t may be that of a snapshot, from below or from above by rounding.
        (next..=next + 2)
            .map(|k| self.landing(k))
            .find(|landing| *landing > t)
            .unwrap_or(self.end)
    }

    /// Between which snapshots t is, by the number of the nearest.
    fn interval_of(&self, t: f64) -> u64 {
        let intervals = self.snapshots.max(2) - 1;
        (t / self.end * intervals as f64).round() as u64
    }

    /// The time of snapshot k.
    fn landing(&self, k: u64) -> f64 {
        let intervals = self.snapshots.max(2) - 1;
        if k >= intervals {
            self.end
        } else {
            k as f64 * self.end / intervals as f64
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Δt = 1.
    fn fixed(steps: u64, every: u64, snapshots: u64) -> Schedule {
        Schedule {
            steps: Some(steps),
            end: steps as f64,
            every,
            snapshots,
        }
    }

    fn chosen(end: f64, snapshots: u64) -> Schedule {
        Schedule {
            steps: None,
            end,
            every: 3,
            snapshots,
        }
    }

    fn due(steps: u64, snapshots: u64) -> Vec<u64> {
        let schedule = fixed(steps, 1, snapshots);
        (0..=steps)
            .filter(|&n| schedule.snapshot_due(n, n as f64))
            .collect()
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
    fn the_times_are_those_of_the_snapshots_that_are_due() {
        for (steps, snapshots) in [
            (10_000, 5),
            (10, 5),
            (3, 5),
            (7, 1),
            (7, 2),
            (7, 0),
            (350, 5),
        ] {
            let times = fixed(steps, 1, snapshots).snapshot_times(0.5);
            let due: Vec<f64> = due(steps, snapshots)
                .iter()
                .map(|n| 0.5 * *n as f64)
                .collect();
            assert_eq!(times, due, "{steps} {snapshots}");
        }
        let quarters = [0.0, 2.5e-4, 5e-4, 7.5e-4, 1e-3];
        assert_eq!(chosen(1e-3, 5).snapshot_times(0.0), quarters);
        assert_eq!(chosen(1e-3, 1).snapshot_times(0.0), [1e-3]);
    }

    #[test]
    fn a_row_every_so_many_steps_and_at_the_end() {
        let schedule = fixed(10, 4, 5);
        let rows: Vec<u64> = (0..=10)
            .filter(|&n| schedule.row_due(n, n as f64))
            .collect();
        assert_eq!(rows, [0, 4, 8, 10]);
        let schedule = chosen(1.0, 5);
        assert!(schedule.row_due(3, 0.3) && !schedule.row_due(4, 0.3) && schedule.row_due(4, 1.0));
    }

    #[test]
    fn the_number_of_steps_is_rounded() {
        let time = |step, end| Time {
            step,
            end,
            ..Time::default()
        };
        assert_eq!(step_count(&time(1e-7, 1e-3)), Some(10_000));
        assert_eq!(step_count(&time(5e-7, 5e-5)), Some(100));
        assert_eq!(step_count(&time(0.1, 0.3)), Some(3));
        assert_eq!(step_count(&time(1.0, 0.4)), Some(0));
        let tolerance = Some(1e-4);
        let chosen = Time {
            tolerance,
            ..Time::default()
        };
        assert_eq!(step_count(&chosen), None);
    }

    #[test]
    fn chosen_steps_land_on_the_snapshots_and_on_the_end() {
        let schedule = chosen(1e-3, 5);
        let mut landings = vec![0.0];
        while landings.last() < Some(&1e-3) {
            landings.push(schedule.landing_after(landings[landings.len() - 1]));
        }
        assert_eq!(landings, [0.0, 2.5e-4, 5e-4, 7.5e-4, 1e-3]);
        assert!(landings.iter().all(|&t| schedule.snapshot_due(9, t)));
        assert!(!schedule.snapshot_due(0, 2.4e-4) && !schedule.snapshot_due(9, 2.6e-4));
        assert_eq!(schedule.landing_after(2.4e-4), 2.5e-4);
        assert_eq!(schedule.landing_after(2.6e-4), 5e-4);
        assert_eq!(schedule.landing_after(1e-3), f64::INFINITY);
        assert_eq!(chosen(1e-3, 0).landing_after(0.0), 1e-3);
        assert!(!chosen(1e-3, 0).snapshot_due(7, 1e-3));
        assert!(chosen(1e-3, 1).snapshot_due(7, 1e-3) && !chosen(1e-3, 1).snapshot_due(0, 0.0));
    }

    proptest! {
        #[test]
        fn every_snapshot_is_landed_on_once(end in 1e-6..1e3, snapshots in 2u64..200) {
            let schedule = chosen(end, snapshots);
            let (mut t, mut seen) = (0.0, 1);
            while t < end {
                t = schedule.landing_after(t);
                prop_assert!(schedule.snapshot_due(1, t));
                seen += 1;
            }
            prop_assert_eq!((t, seen), (end, snapshots));
        }

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
