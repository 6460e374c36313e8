//! Numbers among the arguments, with errors that say what is allowed.

use crate::study::{Budget, FinerRuns};
use crate::tui::state::App;
use std::time::Duration;

/// A whole number, such as how many snapshots.
pub(super) fn count(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| "it must be a whole number from 0".to_owned())
}

/// A whole number from 1, such as how many steps.
pub(super) fn count_from_one(text: &str) -> Result<u64, String> {
    text.parse()
        .ok()
        .filter(|number| *number > 0)
        .ok_or_else(|| "it must be a whole number from 1".to_owned())
}

/// An error of φ.
pub(super) fn accuracy(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|error: &f64| error.is_finite() && *error > 0.0)
        .ok_or_else(|| "it must be a finite number > 0, such as 1e-2".to_owned())
}

/// A number of threads.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    const MOST: usize = 256;
    text.parse()
        .ok()
        .filter(|number| (1..=MOST).contains(number))
        .ok_or_else(|| format!("it must be a whole number from 1 to {MOST}"))
}

/// A budget of time, in seconds.
pub(super) fn budget(text: &str) -> Result<u64, String> {
    const MOST: u64 = Budget::MOST;
    text.parse()
        .ok()
        .filter(|seconds| (1..=MOST).contains(seconds))
        .ok_or_else(|| format!("it must be a whole number of seconds from 1 to {MOST}"))
}

/// A time on the clock.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds: f64| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "it must be a number of seconds from 0, such as 30".to_owned())
}

/// Seconds for which a run is shown; 0: as it comes.
pub(super) fn pace(text: &str) -> Result<f64, String> {
    let seconds = seconds(text).map(|seconds| seconds.as_secs_f64());
    seconds
        .ok()
        .filter(|seconds| *seconds <= 1e6)
        .ok_or_else(|| "it must be a number of seconds from 0 to 1000000, such as 8".to_owned())
}

/// How many times finer a run is that the error is measured against.
pub(super) fn factor(text: &str) -> Result<f64, String> {
    let [least, most] = FinerRuns::FACTORS;
    text.parse()
        .ok()
        .filter(|factor| (least..=most).contains(factor))
        .ok_or_else(|| format!("it must be a number from {least} to {most}, such as 2"))
}

/// Frames a second.
pub(super) fn frames(text: &str) -> Result<u32, String> {
    let [least, most] = App::FRAME_RATES;
    text.parse()
        .ok()
        .filter(|number| (least..=most).contains(number))
        .ok_or_else(|| format!("it must be a whole number from {least} to {most}"))
}

/// A time after the start.
pub(super) fn time(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|time: &f64| time.is_finite() && *time > 0.0)
        .ok_or_else(|| "it must be a finite number > 0, such as 1e-4".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_of_the_kind_is_refused() {
        assert_eq!(count("0"), Ok(0));
        assert_eq!(count_from_one("18446744073709551615"), Ok(u64::MAX));
        assert_eq!([frames("1"), frames("30")], [Ok(1), Ok(30)]);
        assert_eq!(time("2.5e-7"), Ok(2.5e-7));
        for text in ["", "-1", "1.5", "1e3", "99999999999999999999", "ten"] {
            assert!(count(text).is_err(), "{text}");
            assert!(count_from_one(text).is_err(), "{text}");
            assert!(frames(text).is_err(), "{text}");
        }
        for text in ["-1", "0", "1000001", "1.5", "ten"] {
            let words = budget(text).expect_err(text);
            assert!(words.contains("from 1 to 1000000"), "{words}");
        }
        assert_eq!((budget("1"), budget("1000000")), (Ok(1), Ok(1_000_000)));
        assert!(count_from_one("0").is_err());
        assert!(frames("0").is_err() && frames("31").is_err());
        for text in ["", "0", "-1e-3", "nan", "inf", "1e999", "soon"] {
            assert!(time(text).is_err(), "{text}");
            assert!(text == "0" || seconds(text).is_err(), "{text}");
        }
        for text in ["", "-1", "nan", "inf", "1e7", "slow"] {
            assert!(pace(text).is_err(), "{text}");
        }
        for text in ["", "1", "9", "nan", "two"] {
            assert!(factor(text).is_err(), "{text}");
        }
        assert_eq!([factor("1.5"), factor("3")], [Ok(1.5), Ok(3.0)]);
        assert_eq!([pace("0"), pace("2.5")], [Ok(0.0), Ok(2.5)]);
        assert_eq!(seconds("0"), Ok(Duration::ZERO));
        assert_eq!(seconds("0.05"), Ok(Duration::from_millis(50)));
    }
}
