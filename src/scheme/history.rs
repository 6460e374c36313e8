//! The accepted states of the last steps, and the guess for the next one by extrapolation in time.

use std::collections::VecDeque;

use super::State;

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

    /// ‖φ_tt‖/2 in L2 with these nodal weights: the divided difference of the last three states.
    pub(super) fn half_second_derivative(&self, weights: &[f64]) -> Option<f64> {
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

    /// Interpolation to the time t between the last states and the one that `state` holds, of the time
    /// `ahead`; the result takes its place.
    pub(super) fn interpolate(&self, t: f64, ahead: f64, state: &mut State) {
        let times = || self.entries.iter().map(|entry| entry.t);
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        let own: f64 = times().map(|other| (t - other) / (ahead - other)).product();
        for (field, target) in targets.into_iter().enumerate() {
            crate::linalg::vector::scale(target, own);
            for entry in &self.entries {
                let among: f64 = times()
                    .filter(|other| *other != entry.t)
                    .map(|other| (t - other) / (entry.t - other))
                    .product();
                let weight = among * (t - ahead) / (entry.t - ahead);
                crate::linalg::vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
    }

    /// Lagrange's extrapolation of all three fields to the time t; does nothing without a history.
    pub(super) fn extrapolate(&self, t: f64, state: &mut State) {
        let targets = [&mut state.phi, &mut state.omega, &mut state.mu];
        for (field, target) in targets.into_iter().enumerate() {
            for (index, entry) in self.entries.iter().enumerate() {
                let weight: f64 = self
                    .entries
                    .iter()
                    .filter(|other| other.t != entry.t)
                    .map(|other| (t - other.t) / (entry.t - other.t))
                    .product();
                if index == 0 {
                    target.fill(0.0);
                }
                crate::linalg::vector::add_scaled(target, weight, &entry.fields[field]);
            }
        }
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
        // 3 t² has the second derivative 6.
        assert_eq!(history.half_second_derivative(&[0.5, 0.5]), Some(3.0));
        history.forget();
        assert_eq!(history.half_second_derivative(&[0.5, 0.5]), None);
        history.push(9.0, &state(1.5));
        history.extrapolate(10.0, &mut guess);
        assert_eq!(guess.phi[0], 1.5);
    }
}
