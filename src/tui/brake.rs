//! A run that is over in a second is still watched: the brake on runs that are computed faster than they can be
//! looked at, and the stored past that is played again.
//!
//! The brake is a horizon of the worker that moves with the time of a clock on the wall. So what is shown is the
//! present of the run: it can be paused, saved, and given another anchoring where it is looked at. A run that is computed more slowly
//! than the brake would let it never waits for it.

use std::time::Duration;

/// Seconds that a run to T is watched for, unless the user says otherwise.
pub const DEFAULT_SECONDS: f64 = 8.0;

/// A clock that runs ahead of its run waits for it: by this many seconds, no more is owed to the run.
const CREDIT: f64 = 0.5;

/// The brake on the runs that are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brake {
    /// Seconds from t = 0 to T, at least.
    pub seconds: f64,
    /// Whether it is on.
    pub on: bool,
    /// The time t up to which the run that is shown may be computed at present.
    pub released: f64,
}

impl Brake {
    /// A brake for this many seconds; it is off where they are 0.
    pub fn new(seconds: f64) -> Self {
        let on = seconds > 0.0;
        Self {
            seconds: if on { seconds } else { DEFAULT_SECONDS },
            on,
            released: 0.0,
        }
    }

    /// Lets a run of this end go on for the time that has passed.
    pub fn release(&mut self, passed: Duration, end: f64) {
        self.released += passed.as_secs_f64() / self.seconds * end;
    }

    /// Keeps what is released near the run: its state at t was reached by a step of dt, and is looked at for as long
    /// as that step takes.
    pub fn keep_to(&mut self, t: f64, dt: f64, end: f64) {
        let credit = self.credit(end);
        self.released = self.released.max(t - dt).min(t + credit);
    }

    /// Whether time that passes releases nothing more at present, because the run is behind.
    pub fn is_ahead(&self, t: f64, end: f64) -> bool {
        self.released >= t + self.credit(end)
    }

    /// The horizon of a run at t that has this one: the same while the run is far from it, so that a run that
    /// is slower than the brake gets few commands and none that holds it up.
    pub fn horizon(&self, t: f64, end: f64, present: Option<f64>) -> Option<f64> {
        if !self.on {
            return None;
        }
        match present {
            // It waits there, or is far from it.
            Some(present) if self.released <= t || t + 0.5 * self.credit(end) < present => {
                Some(present)
            }
            _ => Some(self.released),
        }
    }

    /// How long a run to `end` will still be watched, where the brake is for one to `usual`.
    pub fn left(&self, end: f64, usual: f64) -> Duration {
        let seconds = self.seconds * (end - self.released) / usual;
        Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or_default()
    }

    fn credit(&self, end: f64) -> f64 {
        CREDIT / self.seconds * end
    }
}

impl Default for Brake {
    /// None.
    fn default() -> Self {
        Self::new(0.0)
    }
}

/// Where the stored past is played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Replay {
    /// The time t that is played.
    pub t: f64,
    /// How many times faster than the pace of the brake.
    pub speed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plays a run whose steps take `cost` seconds each, with a message every 50 ms; returns the seconds to the end
    /// and the number of horizons that were sent.
    fn play(brake: &mut Brake, times: &[f64], cost: f64) -> (f64, usize) {
        const TICK: f64 = 0.05;
        let end = *times.last().expect("a time");
        let (mut now, mut sent) = (0.0, 0);
        let (mut t, mut dt) = (0.0, 0.0);
        let mut horizon = brake.horizon(t, end, Some(0.0));
        let mut computed = 0.0;
        let mut left = times.iter();
        let mut next = left.next();
        while let Some(reached) = next {
            now += TICK;
            brake.release(Duration::from_secs_f64(TICK), end);
            // What the worker does in the meantime.
            computed += TICK;
            while let Some(reached) = next.filter(|_| horizon.is_none_or(|it| t < it)) {
                if computed < cost {
                    break;
                }
                computed -= cost;
                (t, dt) = (*reached, reached - t);
                next = left.next();
            }
            if horizon.is_some_and(|it| t >= it) {
                computed = 0.0;
            }
            brake.keep_to(t, dt, end);
            let moved = brake.horizon(t, end, horizon);
            sent += usize::from(moved != horizon);
            horizon = moved;
            assert!(now < 1e4, "{reached} is never reached");
        }
        (now, sent)
    }

    #[test]
    fn a_quick_run_takes_as_long_as_the_brake_says() {
        // Steps that grow by a third.
        let mut times = vec![1e-7];
        while times.last().is_some_and(|last| *last < 0.9) {
            let last = times[times.len() - 1];
            times.push(last * 4.0 / 3.0);
        }
        times.push(1.0);
        for cost in [1e-3, 0.03] {
            let (seconds, _) = play(&mut Brake::new(8.0), &times, cost);
            // Up to the last step, which then is looked at.
            let expected = 8.0 * times[times.len() - 2];
            assert!((seconds - expected).abs() < 1.2, "{seconds} {expected}");
        }
        let (seconds, sent) = play(&mut Brake::new(0.0), &times, 1e-3);
        assert!(seconds < 0.2 && sent <= 1, "{seconds} {sent}");
    }

    #[test]
    fn a_slow_run_is_not_held_up_and_gets_few_commands() {
        let times: Vec<f64> = (1..=2000).map(|n| f64::from(n) / 2000.0).collect();
        let (seconds, sent) = play(&mut Brake::new(8.0), &times, 0.02);
        assert!((seconds - 40.0).abs() < 0.5, "{seconds}");
        assert!(sent < 60, "{sent}");
    }

    #[test]
    fn another_run_begins_where_it_is() {
        let mut brake = Brake::new(8.0);
        brake.released = 0.9;
        brake.keep_to(0.1, 0.02, 1.0);
        assert!(brake.released > 0.1 && brake.released < 0.2);
        brake.released = 0.0;
        // Steps that were taken one by one are not waited for.
        brake.keep_to(0.5, 0.02, 1.0);
        assert_eq!(brake.released, 0.48);
    }
}
