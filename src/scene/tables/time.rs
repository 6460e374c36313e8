//! `[time]`.

use std::ops::RangeInclusive;

use super::{Rules, Scene};
use crate::scene::error::{Problem, SceneError};
use crate::scene::parameter::plain;
use crate::scene::reader::{Field, POSITIVE, Reader};
use crate::scene::warning::Warning;

table! {
    /// The time axis. `step` and `tolerance` exclude each other.
    #[derive(Copy)]
    pub struct Time {
        /// Δt; where `tolerance` is given, the Δt that is tried first.
        step: f64 = 1e-7, POSITIVE;
        /// Bound of the estimated error of φ in one step, in L2, by which Δt is chosen; without it Δt is `step`
        /// throughout.
        tolerance: Option<f64> = None, POSITIVE;
        /// The order of the method in time; 3 by default where `tolerance` is given.
        order: Order = Order::First;
        /// T, the end.
        end: f64 = 1e-3, POSITIVE;
    }
}

impl Time {
    /// The number of steps: T/Δt, rounded. `None` where Δt is chosen on the way.
    pub fn steps(&self) -> Option<u64> {
        // A cast from f64 saturates; Δt and T are positive and finite.
        let is_fixed = self.tolerance.is_none();
        is_fixed.then(|| (self.end / self.step).round() as u64)
    }
}

impl Rules for Time {
    /// An override of the one takes the place of the other and of the order that belongs to it.
    fn prepare(table: &mut Reader<'_>) -> Result<(), SceneError> {
        let replaces = table.choose(["tolerance", "step"], Problem::StepAndTolerance)?;
        if replaces && table.get("order").is_some_and(|order| !order.is_override()) {
            table.pass_over("order");
        }
        Ok(())
    }

    fn complete(&mut self, table: &Reader<'_>) -> Result<(), SceneError> {
        if self.tolerance.is_some() && table.get("order").is_none() {
            self.order = Order::Third;
        }
        Ok(())
    }

    fn leaves_out(&self, key: &str) -> bool {
        key == "step" && self.tolerance.is_some()
    }

    /// Of an end that no step of the grid meets.
    fn warnings(&self, _: &Scene) -> Vec<Warning> {
        let Some(steps) = self.steps() else {
            return Vec::new();
        };
        let (end, step) = (self.end, self.step);
        let parts = end / step;
        // What a quotient of decimal fractions is off by is far less.
        let is_met = (parts - steps as f64).abs() <= 1e-9 * parts.max(1.0);
        Vec::from_iter((!is_met).then_some(Warning::EndBetweenSteps { end, step, steps }))
    }
}

/// The order of the method in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The scheme as it is, (3.20)–(3.21).
    First,
    /// Each step is taken whole and in halves, and the two are combined so that the error of first
    /// order falls out.
    Second,
    /// In thirds as well, so that the error of second order falls out too.
    Third,
}

impl Order {
    /// As a number.
    pub fn number(self) -> u8 {
        match self {
            Self::First => 1,
            Self::Second => 2,
            Self::Third => 3,
        }
    }

    /// In how many ways an extrapolated step is taken: at least two, for the estimate of its error.
    pub fn chains(self) -> usize {
        usize::from(self.number()).max(2)
    }
}

const ORDERS: RangeInclusive<u64> = 1..=3;

plain! {
    Order, (),
    |field: &Field<'_>, (): &()| Ok(match field.integer(&ORDERS)? {
        1 => Order::First,
        2 => Order::Second,
        _ => Order::Third,
    }),
    |order: &Order| Some(order.number().to_string()),
    |(): &()| u64::words(&ORDERS)
}
