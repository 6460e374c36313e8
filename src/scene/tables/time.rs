//! `[time]`.

use std::ops::{Add, Mul};

use super::{Rules, Scene};
use crate::scene::error::{Problem, SceneError};
use crate::scene::parameter::choice;
use crate::scene::reader::{POSITIVE, Reader};
use crate::scene::warning::Warning;

table! {
    /// The time axis. `step` and `tolerance` exclude each other.
    #[derive(Copy)]
    pub struct Time {
        /// Δt, the same for all steps.
        step: f64 = 1e-7, POSITIVE;
        /// About the error of φ that the steps make until the end at most, in L2: by it Δt is chosen, from 1e-7 on.
        tolerance: Option<f64> = None, POSITIVE;
        /// The scheme by which a step is taken; "secant" by default where `tolerance` is given.
        scheme: TimeScheme = TimeScheme::FirstOrder;
        /// T, the end.
        end: f64 = 1e-3, POSITIVE;
    }
}

/// The bound of a step's error in the secant scheme, over τ^(3/2): the sum of N such errors, with N as Δt^(-1) and each as Δt³,
/// is then in proportion to τ; with this number it is about τ where it is largest (docs/guide/accuracy.md).
const SECANT_BOUND: f64 = 5.0;

/// The greatest number of steps that a run may have. It fits into 64 bits, and no run is as long.
pub(in crate::scene) const MOST_STEPS: f64 = 1e18;

impl Time {
    /// The bound of the estimated error of φ in one step, in L2, and the power of Δt with which that error grows; `None` where
    /// Δt is not chosen.
    pub fn error_bound(&self) -> Option<(f64, u32)> {
        let tolerance = self.tolerance?;
        Some(match self.scheme {
            TimeScheme::FirstOrder => (tolerance, 2),
            TimeScheme::Secant => (SECANT_BOUND * tolerance.powf(1.5), 3),
        })
    }

    /// Whether a run of steps of one length would have more of them than can be counted.
    pub fn has_too_many_steps(&self) -> bool {
        // Infinite where even the quotient is too large.
        self.tolerance.is_none() && self.end / self.step > MOST_STEPS
    }

    /// The number of steps: T/Δt, rounded. `None` where Δt is chosen on the way.
    pub fn steps(&self) -> Option<u64> {
        // A cast from f64 saturates; Δt and T are positive and finite.
        let is_fixed = self.tolerance.is_none();
        is_fixed.then(|| (self.end / self.step).round() as u64)
    }
}

impl Rules for Time {
    /// An override of the one takes the place of the other and of the scheme that belongs to it.
    fn prepare(table: &mut Reader<'_>) -> Result<(), SceneError> {
        let replaces = table.choose(["tolerance", "step"], Problem::StepAndTolerance)?;
        if replaces
            && table
                .get("scheme")
                .is_some_and(|scheme| !scheme.is_override())
        {
            table.pass_over("scheme");
        }
        Ok(())
    }

    fn complete(&mut self, table: &Reader<'_>) -> Result<(), SceneError> {
        if self.tolerance.is_some() && table.get("scheme").is_none() {
            self.scheme = TimeScheme::Secant;
        }
        if !self.has_too_many_steps() {
            return Ok(());
        }
        let (step, end) = (self.step, self.end);
        let problem = Problem::TooManySteps { end, step };
        let given = ["step", "end"].map(|key| table.get(key));
        let of_override = given.iter().flatten().find(|field| field.is_override());
        Err(match of_override.or(given.iter().flatten().next()) {
            Some(field) => field.error(problem),
            None => table.error(problem),
        })
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

choice! {
    /// How a step is taken. The energy law of both is an identity.
    pub enum TimeScheme {
        /// The scheme (3.20)–(3.21): first order, with numerical dissipation.
        FirstOrder = "first-order",
        /// The secant midpoint scheme: second order, without numerical dissipation; the first two steps, and those after
        /// an event, are of first order.
        Secant = "secant",
    }
}

impl TimeScheme {
    /// θ: what is quadratic in u has its force at u_θ = uⁿ + θ(u − uⁿ), and loses (2θ − 1) times the energy of u − uⁿ.
    pub fn weight(self) -> f64 {
        match self {
            Self::FirstOrder => 1.0,
            Self::Secant => 0.5,
        }
    }

    /// u_θ: u itself, or the mean of uⁿ and u.
    pub fn implicit<T>(self, old: T, new: T) -> T
    where
        T: Add<Output = T> + Mul<f64, Output = T>,
    {
        match self {
            Self::FirstOrder => new,
            Self::Secant => (old + new) * 0.5,
        }
    }
}
