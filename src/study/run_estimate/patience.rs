//! How long a calibration goes on.

use super::Unsolved;
use crate::simulation::{Simulation, SimulationError, StepProgress};
use std::time::{Duration, Instant};

/// A limit on the clock, and somebody who may not want to wait so long.
pub(super) struct Patience<'a> {
    begun: Instant,
    limit: Duration,
    go_on: &'a mut dyn FnMut() -> bool,
    is_ended: bool,
    /// Where the step that was left stood.
    left: Option<StepProgress>,
}

impl<'a> Patience<'a> {
    pub(super) fn new(limit: Duration, go_on: &'a mut dyn FnMut() -> bool) -> Self {
        Self {
            begun: Instant::now(),
            limit,
            go_on,
            is_ended: false,
            left: None,
        }
    }

    /// Whether it is at its end.
    pub(super) fn is_out(&mut self) -> bool {
        self.is_ended = self.is_ended || !(self.go_on)();
        self.is_ended || self.begun.elapsed() >= self.limit
    }

    /// Whether somebody did not want to wait.
    pub(super) fn is_ended(&self) -> bool {
        self.is_ended
    }

    /// Takes a step, unless it is at its end before that is solved: whether the step was taken.
    ///
    /// # Errors
    /// Those of [`Simulation::advance`].
    pub(super) fn step(&mut self, simulation: &mut Simulation) -> Result<bool, SimulationError> {
        // It is also left for events, which nobody reads here.
        while !self.is_out() {
            let is_whole = simulation.advance_unless(&mut |underway| {
                self.left = Some(*underway);
                self.is_out()
            })?;
            if is_whole {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What is to be said of a first step that was not solved.
    pub(super) fn unsolved(&self) -> Unsolved {
        Unsolved {
            seconds: self.begun.elapsed().as_secs_f64(),
            underway: self.left,
        }
    }
}
