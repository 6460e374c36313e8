//! The accepted states of the last steps, and the guess for the next one by extrapolation in time.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::State;
use crate::linalg::vector;

/// The sum of the weights' magnitudes is 15 for equal steps and four states, 49 if the next step is twice
/// as long as the last ones. With 64 here case 3 with a tolerance of 1e-3 takes thirty corrections of Newton's method
/// more.
const MOST_MAGNIFIED: f64 = 32.0;

/// The same where the state ahead is known, whose own weight is not counted: 1.9 in the middle of a step as long as
/// the last ones, 3.3 if it is half as long again. What relaxes fast is no polynomial, and one that is to lead far from
/// states close to each other overshoots: without a limit case 3 with a tolerance of 1e-3 took 35 steps, 5 refusals,
/// some for the guess alone, and 523 corrections; with this one it takes 29, 2 and 464.
const MOST_MAGNIFIED_WITHIN: f64 = 3.0;

/// Accepted φ, ω, μ at the last times.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Predictor {
    /// Newest last; the times count from an arbitrary origin. Those before the last `known` are only
    /// room for the next ones.
    entries: VecDeque<Entry>,
    known: usize,
    capacity: usize,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Entry {
    t: f64,
    fields: [Vec<f64>; 3],
}

impl Predictor {
    /// Extrapolation by polynomials of at most the degree `order`.
    pub(super) fn new(order: usize) -> Self {
        Self {
            entries: VecDeque::with_capacity(order + 1),
            known: 0,
            capacity: order + 1,
        }
    }

    /// Forgets everything: the right-hand side has jumped.
    pub(super) fn forget(&mut self) {
        self.known = 0;
    }

    /// Takes an accepted state. Allocates only until the history has been full once.
    pub(super) fn push(&mut self, t: f64, state: &State) {
        let room = if self.entries.len() < self.capacity {
            None
        } else {
            self.entries.pop_front()
        };
        let mut entry = room.unwrap_or_default();
        entry.t = t;
        let sources = [&state.phi, &state.omega, &state.mu];
        for (target, source) in entry.fields.iter_mut().zip(sources) {
            target.clone_from(source);
        }
        self.entries.push_back(entry);
        self.known = (self.known + 1).min(self.capacity);
    }

    /// What is known, oldest first.
    fn known(&self) -> impl Iterator<Item = &Entry> {
        self.entries.range(self.entries.len() - self.known..)
    }

    /// Takes over what another history knows. Allocates only where there is no room yet.
    pub(super) fn copy(&mut self, other: &Self) {
        self.capacity = other.capacity;
        self.known = other.known;
        self.entries.truncate(self.capacity);
        while self.entries.len() < other.known {
            self.entries.push_back(Entry::default());
        }
        let unknown = self.entries.len() - self.known;
        for (target, source) in self.entries.range_mut(unknown..).zip(other.known()) {
            target.t = source.t;
            target.fields.clone_from(&source.fields);
        }
    }

    /// ‖φ_tt‖/2 in L2 with these nodal weights: the divided difference of the last three states.
    pub(super) fn half_second_derivative(&self, weights: &[f64]) -> Option<f64> {
        if self.known < 3 {
            return None;
        }
        let mut newest = self.entries.iter().rev();
        let (c, b, a) = (newest.next()?, newest.next()?, newest.next()?);
        let factors = [
            ((a.t - b.t) * (a.t - c.t)).recip(),
            ((b.t - a.t) * (b.t - c.t)).recip(),
            ((c.t - a.t) * (c.t - b.t)).recip(),
        ];
        let fields = a.fields[0].iter().zip(&b.fields[0]).zip(&c.fields[0]);
        let squares = fields.zip(weights).map(|(((a, b), c), weight)| {
            let difference = factors[0] * a + factors[1] * b + factors[2] * c;
            weight * difference * difference
        });
        Some(squares.sum::<f64>().sqrt())
    }

    /// Interpolation to the time t between as many of the last states as that can bear and the one that `state`
    /// holds, of the time `ahead`; the result takes its place.
    pub(super) fn interpolate(&self, t: f64, ahead: f64, state: &mut State) {
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        let skipped = self.too_many(t, Some(ahead));
        let others = self.known().skip(skipped).map(|entry| entry.t);
        let own = others.map(|other| (t - other) / (ahead - other)).product();
        for (field, target) in targets.into_iter().enumerate() {
            vector::scale(target, own);
            for (index, entry) in self.known().enumerate().skip(skipped) {
                let weight = self.weight(index, skipped, t, Some(ahead));
                vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
    }

    /// Whether this may stand in the place of a history of the same scheme: of as many entries, of
    /// fields at so many nodes.
    pub(super) fn fits(&self, other: &Self, nodes: usize) -> bool {
        let full = |entry: &Entry| entry.fields.iter().all(|field| field.len() == nodes);
        self.capacity == other.capacity
            && self.known <= self.entries.len()
            && self.entries.len() <= self.capacity
            && self.known().all(full)
    }

    /// Lagrange's extrapolation of all three fields to the time t, from as many of the last states as
    /// that can bear; does nothing without a history.
    pub(super) fn extrapolate(&self, t: f64, state: &mut State) {
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        let skipped = self.too_many(t, None);
        for (field, target) in targets.into_iter().enumerate() {
            for (index, entry) in self.known().enumerate().skip(skipped) {
                if index == skipped {
                    target.fill(0.0);
                }
                let weight = self.weight(index, skipped, t, None);
                vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
    }

    /// How many of the oldest states must be left out: as few as keep rounding and what is no
    /// polynomial from being magnified by more than [`MOST_MAGNIFIED`], or [`MOST_MAGNIFIED_WITHIN`]; all but the last
    /// one where Δt has become much longer.
    fn too_many(&self, t: f64, ahead: Option<f64>) -> usize {
        let count = self.known;
        let limit = match ahead {
            None => MOST_MAGNIFIED,
            Some(_) => MOST_MAGNIFIED_WITHIN,
        };
        let magnified = |skipped: &usize| {
            let weights = (*skipped..count).map(|index| self.weight(index, *skipped, t, ahead));
            weights.map(f64::abs).sum::<f64>() > limit
        };
        (0..count).take_while(magnified).count()
    }

    /// The weight of a state where the first `skipped` are left out, and there may be one ahead.
    fn weight(&self, index: usize, skipped: usize, t: f64, ahead: Option<f64>) -> f64 {
        let own = self.entries[self.entries.len() - self.known + index].t;
        let others = self.known().skip(skipped).map(|entry| entry.t);
        others
            .chain(ahead)
            .filter(|other| *other != own)
            .map(|other| (t - other) / (own - other))
            .product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(value: f64) -> State {
        State {
            phi: vec![value; 2],
            omega: vec![-value; 2],
            mu: vec![2.0 * value; 2],
            director: None,
        }
    }

    #[test]
    fn polynomials_up_to_the_order_are_continued_exactly() {
        let parabola = |t: f64| 1.0 - t + 3.0 * t * t;
        let mut history = Predictor::new(2);
        let mut guess = state(7.0);
        history.extrapolate(0.5, &mut guess);
        assert_eq!(guess.phi[0], 7.0);
        for t in [0.0, 1.0, 2.0, 2.5] {
            history.push(t, &state(parabola(t)));
        }
        history.extrapolate(4.0, &mut guess);
        assert!((guess.phi[1] - parabola(4.0)).abs() < 1e-12);
        assert!((guess.mu[0] - 2.0 * parabola(4.0)).abs() < 1e-12);
        // 3 t² has the second derivative 6.
        assert_eq!(history.half_second_derivative(&[0.5, 0.5]), Some(3.0));
        history.forget();
        assert_eq!(history.half_second_derivative(&[0.5, 0.5]), None);
        history.push(9.0, &state(1.5));
        history.extrapolate(10.0, &mut guess);
        assert_eq!(guess.phi[0], 1.5);
    }

    #[test]
    fn a_much_longer_step_is_not_guessed_from_short_ones() {
        let mut history = Predictor::new(3);
        let mut guess = state(7.0);
        for n in 0..4 {
            history.push(f64::from(n) * 1e-8, &state(f64::from(n * n)));
        }
        history.extrapolate(3e-8 + 1e-4, &mut guess);
        assert_eq!(guess.phi[0], 9.0);
        history.extrapolate(4e-8, &mut guess);
        assert!((guess.phi[0] - 16.0).abs() < 1e-6);
    }

    #[test]
    fn the_way_into_a_much_longer_step_is_straight() {
        let mut history = Predictor::new(3);
        for n in 0..4 {
            history.push(f64::from(n), &state(f64::from(n * n)));
        }
        let halfway = |length: f64, end: f64| {
            let mut guess = state(end);
            history.interpolate(3.0 + 0.5 * length, 3.0 + length, &mut guess);
            guess.phi[0]
        };
        // The parabola, where the step is as long as the last ones.
        assert!((halfway(1.0, 16.0) - 12.25).abs() < 1e-12);
        // t = 3 alone is left of the last ones.
        assert!((halfway(100.0, 10.0) - 9.5).abs() < 1e-12);
    }
}
