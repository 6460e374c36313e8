//! Numbers as the screen shows them: few digits, steady widths.

use std::time::Duration;

pub use crate::scene::significant;

/// To `digits` significant digits, without the zeros at its end: for numbers that are round.
pub fn brief(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    let (digits, exponent) = match text.split_once('e') {
        Some((digits, exponent)) => (digits.to_owned(), format!("e{exponent}")),
        None => (text, String::new()),
    };
    let digits = if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        &digits
    };
    format!("{digits}{exponent}")
}

/// To `digits` significant digits, with its sign.
pub fn signed(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    if value > 0.0 {
        format!("+{text}")
    } else {
        text
    }
}

/// What is larger is related to what was all but zero.
const MOST_PERCENT: f64 = 99_999.5;

/// A relative change in percent, at most eight characters; nothing where there is nothing to relate to.
pub fn percent(change: f64, whole: f64) -> String {
    let percent = 100.0 * change / whole.abs();
    if percent == 0.0 {
        "0%".to_owned()
    } else if !percent.is_finite() || percent.abs() >= MOST_PERCENT {
        String::new()
    } else if percent.abs() < 0.005 {
        format!("{percent:+.0e}%")
    } else if percent.abs() < 9.995 {
        format!("{percent:+.2}%")
    } else if percent.abs() < 99.95 {
        format!("{percent:+.1}%")
    } else {
        format!("{percent:+.0}%")
    }
}

/// A time on the wall: seconds, minutes and seconds, hours and minutes.
pub fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs();
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        3600..86_400 => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
        _ => format!("{} d {:02} h", seconds / 86_400, seconds / 3600 % 24),
    }
}

/// Milliseconds with three digits.
pub fn milliseconds(duration: Duration) -> String {
    significant(1e3 * duration.as_secs_f64(), 3)
}

/// Of 1, 1.5, 2, 3, 5, 7 times a power of ten, the smallest that is not below: the end of a range
/// that does not move with every frame. 1 where there is no positive number to begin with.
pub fn round_up(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powi(value.log10().floor() as i32);
    let steps = [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0];
    let found = steps.iter().find(|step| **step * power >= value);
    let rounded = found.unwrap_or(&10.0) * power;
    if rounded > 0.0 && rounded.is_finite() {
        rounded
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_are_short() {
        let table = [
            (-1.0, "-1"),
            (0.0, "0"),
            (100.0, "100"),
            (1.01, "1.01"),
            (1e-7, "1e-7"),
            (-1.5e6, "-1.5e6"),
            (0.03, "0.03"),
        ];
        for (value, text) in table {
            assert_eq!(brief(value, 3), text);
        }
        assert_eq!(signed(0.25, 2), "+0.25");
        assert_eq!(signed(-0.25, 2), "-0.25");
        assert_eq!(signed(0.0, 2), "0");
    }

    #[test]
    fn percents_are_short() {
        let table = [
            (1.0, 8.0, "+12.5%"),
            (-1.0, 3000.0, "-0.03%"),
            (-1.0, -4.0, "-25.0%"),
            (0.0, 3.0, "0%"),
            (1e-9, 1.0, "+1e-7%"),
            (5.0, 1.0, "+500%"),
            (900.0, 1.0, "+90000%"),
            (5e9, 1.0, ""),
            (1.0, 0.0, ""),
            (0.0, 0.0, ""),
        ];
        for (change, whole, text) in table {
            assert_eq!(percent(change, whole), text);
            assert!(text.len() <= 8);
        }
    }

    #[test]
    fn durations() {
        let table = [
            (5, "5 s"),
            (65, "1 min 05 s"),
            (3700, "1 h 01 min"),
            (200_000, "2 d 07 h"),
        ];
        for (seconds, text) in table {
            assert_eq!(duration(Duration::from_secs(seconds)), text);
        }
        assert_eq!(milliseconds(Duration::from_micros(12_345)), "12.3");
    }

    #[test]
    fn ranges_end_at_round_numbers() {
        let table = [
            (0.9, 1.0),
            (1.0, 1.0),
            (1.2, 1.5),
            (0.021, 0.03),
            (6100.0, 7000.0),
            (0.0, 1.0),
            (-3.0, 1.0),
            (f64::NAN, 1.0),
            (f64::INFINITY, 1.0),
        ];
        for (value, end) in table {
            assert!((round_up(value) / end - 1.0).abs() < 1e-12, "{value}");
        }
        assert!(round_up(f64::MAX).is_finite() && round_up(5e-324) > 0.0);
    }
}
