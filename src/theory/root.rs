//! The zero of a function of one variable between two places.

/// The search ends where an end moves by less than this, or after so many values.
const CLOSE: f64 = 1e-12;
const MOST_ATTEMPTS: usize = 100;

/// Calls f at places that come near to its zero between two places where it has different signs, each given with its value: by regula
/// falsi, with the value at an end halved that has stayed twice (Illinois). The last place is the zero.
pub(super) fn root<E>(
    [mut one, mut other]: [(f64, f64); 2],
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(), E> {
    let mut stayed = 0_i32;
    for _ in 0..MOST_ATTEMPTS {
        let between = one.0 + (other.0 - one.0) * one.1 / (one.1 - other.1);
        let value = f(between)?;
        let replaces_other = (value > 0.0) == (other.1 > 0.0);
        let replaced = if replaces_other { &mut other } else { &mut one };
        let moved = (replaced.0 - between).abs();
        *replaced = (between, value);
        if moved < CLOSE || value == 0.0 {
            break;
        }
        stayed = match replaces_other {
            true => stayed.max(0) + 1,
            false => stayed.min(0) - 1,
        };
        match stayed {
            2.. => one.1 *= 0.5,
            ..=-2 => other.1 *= 0.5,
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn the_last_place_is_the_zero() {
        // cos x = x³ at 0.865474.
        let f = |x: f64| x.cos() - x.powi(3);
        for ends in [[0.0, 1.0], [1.0, 0.0], [0.5, 3.0]] {
            let mut last = f64::NAN;
            let mut calls = 0;
            let found = root::<Infallible>(ends.map(|x| (x, f(x))), |x| {
                (last, calls) = (x, calls + 1);
                Ok(f(x))
            });
            assert!(found.is_ok() && calls < 20, "{ends:?}: {calls}");
            assert!(
                (last - 0.865_474_033_101_614).abs() < 1e-11,
                "{ends:?}: {last}"
            );
        }
    }

    #[test]
    fn an_error_ends_the_search() {
        let found = root([(0.0, -1.0), (1.0, 1.0)], |_| Err("no value"));
        assert_eq!(found, Err("no value"));
    }
}
