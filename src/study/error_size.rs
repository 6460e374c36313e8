//! The size of an error.

use serde::Serialize;
use std::fmt;

/// The size of an error: finite and greater than zero, so that it has a logarithm and can be divided
/// by. Where there is no such number, there is no error to speak of.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize)]
#[serde(transparent)]
pub struct ErrorSize(f64);

impl ErrorSize {
    /// `None` for what is not finite, and for zero: two results without any difference are results
    /// of the same computation, and say nothing of an error.
    pub fn new(size: f64) -> Option<Self> {
        (size.is_finite() && size > 0.0).then_some(Self(size))
    }

    /// The number.
    pub fn get(self) -> f64 {
        self.0
    }
}

impl fmt::LowerExp for ErrorSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::LowerExp::fmt(&self.0, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_logarithm_is_no_error() {
        for size in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0] {
            assert_eq!(ErrorSize::new(size), None);
        }
        let least = f64::from_bits(1);
        assert_eq!(ErrorSize::new(least).map(ErrorSize::get), Some(least));
        assert_eq!(format!("{:.1e}", ErrorSize(2.5e-3)), "2.5e-3");
    }
}
