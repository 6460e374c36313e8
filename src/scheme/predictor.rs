//! The accepted states of the last steps, and the guess for the next one by extrapolation in time.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::State;
use crate::linalg::vector;
use crate::scene::TimeScheme;

/// A bound of the sum of the weights' magnitudes. It is 15 for equal steps and four states, 7 for three; 49 and 17 if the
/// next step is twice as long as the last ones. The steps of the secant scheme are mostly as long as their error allows, where
/// more states do not tell more: with 32 the quick presets took a fifth more corrections, with 16 a twentieth.
fn most_magnified(scheme: TimeScheme) -> f64 {
    match scheme {
        TimeScheme::FirstOrder => 32.0,
        TimeScheme::Secant => 8.0,
    }
}

/// States of the past in a divided difference at most.
const MOST_DIFFERENCED: usize = 4;

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

    /// The L2 norm of the divided difference of φ, from the last `states` states and the given φ at time t: ‖φ_tt‖/2 with
    /// two states, ‖φ_ttt‖/6 with three. `weights` are the nodal weights. `None` where fewer states are known.
    pub(super) fn divided_difference(
        &self,
        states: usize,
        t: f64,
        phi: &[f64],
        weights: &[f64],
    ) -> Option<f64> {
        let skipped = self.known.checked_sub(states)?;
        let times = || self.known().skip(skipped).map(|entry| entry.t);
        let factor = |own: f64| -> f64 {
            let all = times().chain([t]).filter(|other| *other != own);
            all.map(|other| (own - other).recip()).product()
        };
        // Nothing is allocated in a step.
        let mut parts = [(0.0, phi); MOST_DIFFERENCED];
        for (part, entry) in parts.iter_mut().zip(self.known().skip(skipped)) {
            *part = (factor(entry.t), &entry.fields[0]);
        }
        let (parts, own) = (&parts[..states], factor(t));
        let mut sum = 0.0;
        for (node, weight) in weights.iter().enumerate() {
            let others = parts.iter().map(|(factor, phi)| factor * phi[node]);
            let difference = own * phi[node] + others.sum::<f64>();
            sum += weight * difference * difference;
        }
        Some(sum.sqrt())
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
    /// the steps of a scheme can bear; does nothing without a history.
    pub(super) fn extrapolate(&self, t: f64, scheme: TimeScheme, state: &mut State) {
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        let skipped = self.too_many(t, scheme);
        for (field, target) in targets.into_iter().enumerate() {
            for (index, entry) in self.known().enumerate().skip(skipped) {
                if index == skipped {
                    target.fill(0.0);
                }
                let weight = self.weight(index, skipped, t);
                vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
    }

    /// How many of the oldest states must be left out: as few as keep rounding and what is no
    /// polynomial from being magnified by more than [`most_magnified`]; all but the last one where Δt has become much longer.
    fn too_many(&self, t: f64, scheme: TimeScheme) -> usize {
        let count = self.known;
        let magnified = |skipped: &usize| {
            let weights = (*skipped..count).map(|index| self.weight(index, *skipped, t));
            weights.map(f64::abs).sum::<f64>() > most_magnified(scheme)
        };
        (0..count).take_while(magnified).count()
    }

    /// The weight of a state where the first `skipped` are left out.
    fn weight(&self, index: usize, skipped: usize, t: f64) -> f64 {
        let own = self.entries[self.entries.len() - self.known + index].t;
        let others = self.known().skip(skipped).map(|entry| entry.t);
        others
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
        history.extrapolate(0.5, TimeScheme::FirstOrder, &mut guess);
        assert_eq!(guess.phi[0], 7.0);
        for t in [0.0, 1.0, 2.0, 2.5] {
            history.push(t, &state(parabola(t)));
        }
        history.extrapolate(4.0, TimeScheme::FirstOrder, &mut guess);
        assert!((guess.phi[1] - parabola(4.0)).abs() < 1e-12);
        assert!((guess.mu[0] - 2.0 * parabola(4.0)).abs() < 1e-12);
        // 3 t² has the second derivative 6.
        let next = [parabola(4.0); 2];
        let difference = |states| history.divided_difference(states, 4.0, &next, &[0.5, 0.5]);
        assert!((difference(2).expect("two") - 3.0).abs() < 1e-12);
        assert!(difference(3).expect("three") < 1e-12);
        assert_eq!(difference(4), None);
        history.forget();
        history.push(9.0, &state(1.5));
        history.extrapolate(10.0, TimeScheme::FirstOrder, &mut guess);
        assert_eq!(guess.phi[0], 1.5);
    }

    #[test]
    fn a_much_longer_step_is_not_guessed_from_short_ones() {
        let mut history = Predictor::new(3);
        let mut guess = state(7.0);
        for n in 0..4 {
            history.push(f64::from(n) * 1e-8, &state(f64::from(n * n)));
        }
        history.extrapolate(3e-8 + 1e-4, TimeScheme::FirstOrder, &mut guess);
        assert_eq!(guess.phi[0], 9.0);
        history.extrapolate(4e-8, TimeScheme::FirstOrder, &mut guess);
        assert!((guess.phi[0] - 16.0).abs() < 1e-6);
    }

    /// Of a cubic, equal steps show all four states to the first-order scheme and the last three to the secant scheme.
    #[test]
    fn the_long_steps_of_the_secant_scheme_are_guessed_from_fewer_states() {
        let mut history = Predictor::new(3);
        for n in 0..4 {
            history.push(f64::from(n), &state(f64::from(n * n * n)));
        }
        for (scheme, expected) in [(TimeScheme::FirstOrder, 64.0), (TimeScheme::Secant, 58.0)] {
            let mut guess = state(0.0);
            history.extrapolate(4.0, scheme, &mut guess);
            assert!((guess.phi[0] - expected).abs() < 1e-9, "{}", guess.phi[0]);
        }
    }
}
