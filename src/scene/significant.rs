//! Numbers in messages and on the screen: few digits, of a number of any size.

/// A number to so many significant digits: plain where that is short, with an exponent where not.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let digits = digits.max(1);
    // The exponent after rounding: 9.9996 to four digits is 10.00.
    let scientific = format!("{value:.*e}", digits - 1);
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0);
        format!("{value:.*}", decimals as usize)
    } else {
        scientific
    }
}

/// Digits of a number that are read at a glance, about.
const BRIEF: usize = 20;

/// A number with all its digits, as `{}` writes it, but with an exponent where that would be hundreds of zeros.
pub(crate) fn brief(value: f64) -> String {
    let plain = value.to_string();
    match plain.len() <= BRIEF {
        true => plain,
        false => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{brief, significant};

    #[test]
    fn a_number_is_not_hundreds_of_zeros() {
        let table = [
            (200.0, "200"),
            (-0.25, "-0.25"),
            (1e-4, "0.0001"),
            (1e300, "1e300"),
            (2.5e-300, "2.5e-300"),
            (f64::INFINITY, "inf"),
        ];
        for (value, text) in table {
            assert_eq!(brief(value), text);
        }
    }

    #[test]
    fn significant_digits() {
        let table = [
            (0.0, "0"),
            (1.0, "1.000"),
            (1234.56, "1235"),
            (12.3456, "12.35"),
            (0.012_345_6, "0.01235"),
            (-0.5, "-0.5000"),
            (9.9996, "10.00"),
            (999_999.9, "1.000e6"),
            (123_456.0, "123456"),
            (1.5e-7, "1.500e-7"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (value, text) in table {
            assert_eq!(significant(value, 4), text);
        }
    }
}
