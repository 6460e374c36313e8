//! When the screen is drawn: not before something has changed, soon after a key, at a limited number of
//! times a second for events of the solvers, and once for a storm of sizes.

use std::time::{Duration, Instant};

/// Between two frames that keys ask for: a key that is held down is not to draw more often.
const KEY_INTERVAL: Duration = Duration::from_millis(20);
/// A size is drawn when no other one has followed for this long …
const CALM: Duration = Duration::from_millis(60);
/// … or when the first of a storm is so old.
const STORM: Duration = Duration::from_millis(300);

/// When to draw next.
#[derive(Debug, Default)]
pub(super) struct RedrawScheduler {
    last: Option<Instant>,
    due: Option<Instant>,
    /// When the first size of a storm came, and when the latest.
    storm: Option<[Instant; 2]>,
}

/// Who asks for a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Occasion {
    /// A key, or what else a person waits for.
    Key,
    /// An event of a solver, or time that has passed.
    WorkerEvent,
    /// The terminal has another size.
    Size,
}

impl RedrawScheduler {
    /// Asks for a frame. `interval` is the time between two frames for events.
    pub fn ask(&mut self, now: Instant, occasion: Occasion, interval: Duration) {
        let wait = match occasion {
            Occasion::Key => KEY_INTERVAL.min(interval),
            Occasion::WorkerEvent => interval,
            Occasion::Size => {
                let first = self.storm.map_or(now, |[first, _]| first);
                self.storm = Some([first, now]);
                return;
            }
        };
        let at = self.last.map_or(now, |last| now.max(last + wait));
        self.due = Some(self.due.map_or(at, |due| due.min(at)));
    }

    /// When to draw; `None`: nothing has changed. While sizes follow each other all waits for the
    /// last one: a frame of another size than the terminal's is a broken one.
    pub fn due(&self) -> Option<Instant> {
        match self.storm {
            Some([first, latest]) => Some((latest + CALM).min(first + STORM)),
            None => self.due,
        }
    }

    /// The frame is drawn.
    pub fn drawn(&mut self, now: Instant) {
        *self = Self {
            last: Some(now),
            ..Self::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL: Duration = Duration::from_millis(100);

    fn after(begin: Instant, milliseconds: u64) -> Instant {
        begin + Duration::from_millis(milliseconds)
    }

    /// The moments of the frames, in milliseconds, when each of `asked` happens at its time.
    fn frames(asked: &[(u64, Occasion)]) -> Vec<u64> {
        let begin = Instant::now();
        let mut pacing = RedrawScheduler::default();
        let mut frames = Vec::new();
        let end = asked.last().map_or(0, |(at, _)| at + 1000);
        for millisecond in 0..end {
            let now = after(begin, millisecond);
            for (_, occasion) in asked.iter().filter(|(at, _)| *at == millisecond) {
                pacing.ask(now, *occasion, INTERVAL);
            }
            if pacing.due().is_some_and(|due| due <= now) {
                pacing.drawn(now);
                frames.push(millisecond);
            }
        }
        frames
    }

    #[test]
    fn nothing_is_drawn_unasked() {
        assert_eq!(RedrawScheduler::default().due(), None);
        assert_eq!(frames(&[(5, Occasion::WorkerEvent)]), [5]);
    }

    #[test]
    fn news_are_drawn_at_most_so_many_times_a_second() {
        let event: Vec<_> = (0..1000).map(|at| (at, Occasion::WorkerEvent)).collect();
        assert_eq!(frames(&event).len(), 11);
    }

    #[test]
    fn a_key_does_not_wait_for_the_news() {
        let asked = [
            (0, Occasion::WorkerEvent),
            (10, Occasion::WorkerEvent),
            (30, Occasion::Key),
        ];
        assert_eq!(frames(&asked), [0, 30]);
        // Held down, it draws fifty frames a second and not more.
        let keys: Vec<_> = (0..1000).map(|at| (at, Occasion::Key)).collect();
        assert_eq!(frames(&keys).len(), 51);
    }

    #[test]
    fn a_storm_of_sizes_is_one_frame_and_an_endless_one_is_not_awaited() {
        let storm: Vec<_> = (0..30).map(|n| (8 * n, Occasion::Size)).collect();
        assert_eq!(frames(&storm), [8 * 29 + 60]);
        let endless: Vec<_> = (0..90).map(|n| (10 * n, Occasion::Size)).collect();
        assert_eq!(frames(&endless).len(), 3);
        // WorkerEvent and keys within a storm are drawn with it.
        let mixed = [
            (0, Occasion::Size),
            (10, Occasion::Key),
            (20, Occasion::WorkerEvent),
        ];
        assert_eq!(frames(&mixed), [60]);
    }
}
