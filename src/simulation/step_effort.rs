//! What it took to solve a step: the rungs of a effort, each taken only where the one below fails. They
//! are the fast linear solver, the sparse factor, Newton's method damped (or in place of the lagged
//! iteration), and a smaller Δt.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::scheme::StepReport;

/// The rungs that a step of the fixed grid needed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepEffort {
    /// Whether the sparse factor solved any part of it.
    pub factor: bool,
    /// Whether Newton's method took over from the lagged iteration.
    pub newton_took_over: bool,
    /// The smallest damping factor of Newton's method; 1: it was not damped.
    pub damping: f64,
    /// In how many parts it was solved.
    pub parts: u64,
    /// How many attempts failed.
    pub refused: u64,
}

impl Default for StepEffort {
    fn default() -> Self {
        Self {
            factor: false,
            newton_took_over: false,
            damping: 1.0,
            parts: 0,
            refused: 0,
        }
    }
}

impl StepEffort {
    /// A part of the step was solved.
    pub(super) fn accept(&mut self, part: &StepReport, with_factor: bool) {
        self.factor |= with_factor;
        self.newton_took_over |= part.newton_took_over.is_some();
        self.damping = self.damping.min(part.damping);
        // One that comes from a file may hold any numbers.
        self.parts = self.parts.saturating_add(1);
        self.refused = self.refused.saturating_add(u64::from(part.refused_ways));
    }

    /// A part was not solved.
    pub(super) fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
    }

    /// The highest rung: 1 the fast linear solver, 2 the sparse factor, 3 Newton's method damped or in
    /// place of the lagged iteration, 4 a smaller Δt. 0: no step was taken.
    pub fn rung(&self) -> u8 {
        match self {
            Self { parts: 0, .. } => 0,
            Self { parts: 2.., .. } => 4,
            _ if self.damping < 1.0 || self.newton_took_over => 3,
            Self { factor: true, .. } => 2,
            _ => 1,
        }
    }

    /// Whether the step needed more than its first attempt, undamped and whole.
    pub fn needed_more(&self) -> bool {
        self.refused > 0 || self.parts > 1 || self.damping < 1.0 || self.newton_took_over
    }

    /// As columns of `ledger.csv`.
    pub fn columns(&self) -> [(&'static str, f64); 4] {
        [
            ("rung", f64::from(self.rung())),
            ("damping", self.damping),
            ("parts", self.parts as f64),
            ("refused", self.refused as f64),
        ]
    }
}

/// What was tried before a run gave up.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// Attempts that failed in this step.
    pub refused: u64,
    /// The fast linear solver that was among the ways.
    pub fast: Option<&'static str>,
    /// Whether the sparse factor was.
    pub factor: bool,
    /// Whether the lagged iteration was, before Newton's method.
    pub lagged: bool,
    /// The longest and the smallest Δt.
    pub steps: [f64; 2],
}

impl fmt::Display for Tried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factor = self.factor.then_some("the sparse factor");
        let ways: Vec<&str> = self.fast.into_iter().chain(factor).collect();
        let ways = ways.join(" and ");
        let iteration = if self.lagged {
            "the lagged iteration and Newton's method damped"
        } else {
            "Newton's method damped"
        };
        let [longest, smallest] = self.steps;
        write!(
            f,
            "{ways}, {iteration}, \u{394}t from {longest:.1e} down to {smallest:.1e}: {} attempts",
            self.refused
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_rung_counts() {
        let mut effort = StepEffort::default();
        assert_eq!(effort.rung(), 0);
        let plain = StepReport {
            damping: 1.0,
            ..StepReport::default()
        };
        effort.accept(&plain, false);
        assert_eq!(effort.rung(), 1);
        effort.factor = true;
        assert_eq!(effort.rung(), 2);
        effort.damping = 0.5;
        assert_eq!(effort.rung(), 3);
        effort.refuse();
        effort.accept(&plain, false);
        assert_eq!(effort.rung(), 4);
        let columns = [
            ("rung", 4.0),
            ("damping", 0.5),
            ("parts", 2.0),
            ("refused", 1.0),
        ];
        assert_eq!(effort.columns(), columns);
    }

    #[test]
    fn what_was_tried_is_told() {
        let tried = Tried {
            refused: 41,
            fast: Some("GMRES with the shifted Laplacians"),
            factor: true,
            lagged: false,
            steps: [1e-2, 9.1e-15],
        };
        assert_eq!(
            tried.to_string(),
            "GMRES with the shifted Laplacians and the sparse factor, Newton's method damped, \
             Δt from 1.0e-2 down to 9.1e-15: 41 attempts"
        );
    }
}
