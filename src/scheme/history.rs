//! The accepted states of the last steps, and the guess for the next one by extrapolation in time.

use std::collections::VecDeque;

use super::State;

/// The sum of the weights' magnitudes is 15 for equal steps and four states, 49 if the next step is twice
/// as long as the last ones.
const MOST_MAGNIFIED: f64 = 64.0;

/// Accepted φ, ω, μ at the last times.
#[derive(Debug)]
pub(super) struct History {
    /// Newest last; the times count from an arbitrary origin.
    entries: VecDeque<Entry>,
    capacity: usize,
}

#[derive(Debug)]
struct Entry {
    t: f64,
    fields: [Vec<f64>; 3],
}

impl History {
    /// Extrapolation by polynomials of at most the degree `order`.
    pub(super) fn new(order: usize) -> Self {
        Self {
            entries: VecDeque::with_capacity(order + 2),
            capacity: order + 1,
        }
    }

    /// Forgets everything: the right-hand side has jumped.
    pub(super) fn forget(&mut self) {
        self.entries.clear();
    }

    /// Takes an accepted state. Allocates only until the history is full.
    pub(super) fn push(&mut self, t: f64, state: &State) {
        let sources = [&state.phi, &state.omega, &state.mu];
        if self.entries.len() < self.capacity {
            self.entries.push_back(Entry {
                t,
                fields: sources.map(Vec::clone),
            });
            return;
        }
        if let Some(mut entry) = self.entries.pop_front() {
            entry.t = t;
            for (target, source) in entry.fields.iter_mut().zip(sources) {
                target.copy_from_slice(source);
            }
            self.entries.push_back(entry);
        }
    }

    /// Lagrange's extrapolation of all three fields to the time t, from as many of the last states as
    /// that can bear; does nothing without a history.
    pub(super) fn extrapolate(&self, t: f64, state: &mut State) {
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        let skipped = self.too_many(t);
        for (field, target) in targets.into_iter().enumerate() {
            for (index, entry) in self.entries.iter().enumerate().skip(skipped) {
                if index == skipped {
                    target.fill(0.0);
                }
                let weight = self.weight(index, skipped, t);
                crate::linalg::vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
    }

    /// How many of the oldest states must be left out: as few as keep rounding and what is no
    /// polynomial from being magnified by more than [`MOST_MAGNIFIED`], all but the last one where Δt has
    /// become much longer.
    fn too_many(&self, t: f64) -> usize {
        let count = self.entries.len();
        let magnified = |skipped: &usize| {
            let weights = (*skipped..count).map(|index| self.weight(index, *skipped, t).abs());
            weights.sum::<f64>() > MOST_MAGNIFIED
        };
        (0..count).take_while(magnified).count()
    }

    /// The weight of a state where the first `skipped` are left out.
    fn weight(&self, index: usize, skipped: usize, t: f64) -> f64 {
        let own = self.entries[index].t;
        let others = self.entries.iter().skip(skipped).map(|entry| entry.t);
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
        let mut history = History::new(2);
        let mut guess = state(7.0);
        history.extrapolate(0.5, &mut guess);
        assert_eq!(guess.phi[0], 7.0);
        for t in [0.0, 1.0, 2.0, 2.5] {
            history.push(t, &state(parabola(t)));
        }
        history.extrapolate(4.0, &mut guess);
        assert!((guess.phi[1] - parabola(4.0)).abs() < 1e-12);
        assert!((guess.mu[0] - 2.0 * parabola(4.0)).abs() < 1e-12);
        history.forget();
        history.push(9.0, &state(1.5));
        history.extrapolate(10.0, &mut guess);
        assert_eq!(guess.phi[0], 1.5);
    }

    #[test]
    fn a_much_longer_step_is_not_guessed_from_short_ones() {
        let mut history = History::new(3);
        let mut guess = state(7.0);
        for n in 0..4 {
            history.push(f64::from(n) * 1e-8, &state(f64::from(n * n)));
        }
        history.extrapolate(3e-8 + 1e-4, &mut guess);
        assert_eq!(guess.phi[0], 9.0);
        history.extrapolate(4e-8, &mut guess);
        assert!((guess.phi[0] - 16.0).abs() < 1e-6);
    }
}
