//! How a number prints in every table.

use std::fmt::{self, Write};

/// A number, printed with the fewest digits that read back exactly.
///
/// From 1e-4 up to 1e15 it is printed plainly, else with a power of ten: `1e-7`, `0.001`, `120`.
/// Not-a-number and infinity print as `NaN`, `inf` and `-inf`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        // Both forms of the standard library give the fewest digits that read back exactly.
        if size == 0.0 || !size.is_finite() || (1e-4..1e15).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// A number for people: six digits, 1/3 as `0.333333`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShortNumber(pub f64);

impl fmt::Display for ShortNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = format!("{:.5e}", self.0).parse().unwrap_or(self.0);
        Number(rounded).fmt(f)
    }
}

/// Appends the cells of a row of a CSV table; `None` is an empty cell.
pub(crate) fn push_cells(row: &mut String, cells: impl IntoIterator<Item = Option<f64>>) {
    for (place, cell) in cells.into_iter().enumerate() {
        if place > 0 {
            row.push(',');
        }
        if let Some(value) = cell {
            // Writing to a String cannot fail.
            let _ = write!(row, "{}", Number(value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Number, ShortNumber};
    use proptest::prelude::*;

    #[test]
    fn prints_the_short_form() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (10000.0, "10000"),
            (1e-3, "0.001"),
            (1e-4, "0.0001"),
            (9.999e-5, "9.999e-5"),
            (-1e-7, "-1e-7"),
            (999999999999999.0, "999999999999999"),
            (1e15, "1e15"),
            (1.0 / 3.0, "0.3333333333333333"),
            (5e-324, "5e-324"),
            (f64::MAX, "1.7976931348623157e308"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Number(value).to_string(), text);
        }
    }

    #[test]
    fn numbers_for_people_are_brief() {
        assert_eq!(ShortNumber(9.999999999999999e-5).to_string(), "0.0001");
        assert_eq!(ShortNumber(1.0 / 3.0).to_string(), "0.333333");
        assert_eq!(ShortNumber(2.5e-7 - 1e-22).to_string(), "2.5e-7");
        assert_eq!(ShortNumber(0.0).to_string(), "0");
        assert_eq!(ShortNumber(f64::NAN).to_string(), "NaN");
    }

    proptest! {
        #[test]
        fn reads_back_bit_for_bit(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assume!(!value.is_nan());
            let text = Number(value).to_string();
            prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), bits, "{}", text);
            prop_assert!(text.len() <= 24, "{}", text);
        }
    }
}
