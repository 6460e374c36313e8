//! How fast a run is.

use std::collections::VecDeque;
use std::time::Duration;

use crate::simulation::{Costs, Report};

/// How fast a run is, pauses left out.
#[derive(Debug, Clone, Default)]
pub struct Throughput {
    /// Steps a second over the last seconds of computing; 0 before the first step.
    pub steps_per_second: f64,
    /// Computing so far.
    pub computing: Duration,
    /// Computing to T at this pace.
    pub left: Option<Duration>,
    /// What each of the last steps took.
    recent: VecDeque<Costs>,
    /// Their sum.
    sum: Costs,
}

/// The pace is that of the steps of this much computing,
const WINDOW: Duration = Duration::from_secs(3);
/// and of at most this many steps.
const STEPS: usize = 4096;

impl Throughput {
    /// Takes a step of a run of `steps` steps.
    pub fn take(&mut self, report: &Report, steps: u64) {
        if report.step == 0 || report.costs.total().is_zero() {
            return;
        }
        self.recent.push_back(report.costs);
        self.sum = self.sum.plus(&report.costs);
        while self.recent.len() > STEPS || self.recent.len() > 1 && self.sum.total() > WINDOW {
            let oldest = self.recent.pop_front().unwrap_or_default();
            self.sum = self.sum.minus(&oldest);
        }
        self.steps_per_second = self.recent.len() as f64 / self.sum.total().as_secs_f64();
        let seconds = steps.saturating_sub(report.step) as f64 / self.steps_per_second;
        self.left = Duration::try_from_secs_f64(seconds).ok();
    }

    /// What a step costs: the mean of the steps of the last seconds, for a single one may be held up by
    /// anything. Nothing before the first step.
    pub fn cost(&self) -> Costs {
        self.sum.divided(self.recent.len() as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Phase;

    fn step(step: u64, milliseconds: u64) -> Report {
        let mut costs = Costs::default();
        costs.add(Phase::Krylov, Duration::from_millis(milliseconds));
        Report {
            step,
            costs,
            ..Report::default()
        }
    }

    #[test]
    fn the_pace_is_that_of_the_last_seconds() {
        let mut pace = Throughput::default();
        pace.take(&step(0, 0), 1000);
        assert_eq!((pace.steps_per_second, pace.left), (0.0, None));
        for n in 1..=100 {
            pace.take(&step(n, 100), 1000);
        }
        assert_eq!(pace.steps_per_second, 10.0);
        assert_eq!(pace.cost().of(Phase::Krylov), Duration::from_millis(100));
        assert_eq!(pace.left, Some(Duration::from_secs(90)));
        for n in 101..=400 {
            pace.take(&step(n, 10), 1000);
        }
        assert!((pace.steps_per_second - 100.0).abs() < 1e-9);
        assert_eq!(pace.left, Some(Duration::from_secs(6)));
    }

    #[test]
    fn one_long_step_is_a_pace_already() {
        let mut pace = Throughput::default();
        pace.take(&step(1, 10_000), 2);
        assert_eq!(pace.steps_per_second, 0.1);
        assert_eq!(pace.left, Some(Duration::from_secs(10)));
    }

    #[test]
    fn many_quick_steps_take_bounded_memory() {
        let mut pace = Throughput::default();
        for n in 1..=100_000 {
            let mut report = step(n, 0);
            report.costs.add(Phase::Krylov, Duration::from_micros(1));
            pace.take(&report, 100_000);
        }
        assert_eq!(pace.recent.len(), STEPS);
        assert!((pace.steps_per_second - 1e6).abs() < 1.0);
        assert_eq!(pace.left, Some(Duration::ZERO));
    }
}
