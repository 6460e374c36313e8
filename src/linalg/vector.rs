//! Operations on vectors. Sums run in a fixed number of lanes, in a fixed order, so that they are
//! fast, lose little to rounding, and give the same bits on every machine and every run.

/// Lanes of a sum: one 512-bit register of f64, twice, to hide the latency of an addition.
const LANES: usize = 16;

/// Σ f(x_i, y_i): the loop that all sums share.
#[inline(always)]
fn sum_pairs(x: &[f64], y: &[f64], f: impl Fn(f64, f64) -> f64) -> f64 {
    assert_eq!(x.len(), y.len());
    let mut lanes = [0.0; LANES];
    let (x_chunks, x_rest) = x.as_chunks::<LANES>();
    let (y_chunks, y_rest) = y.as_chunks::<LANES>();
    for (a, b) in x_chunks.iter().zip(y_chunks) {
        for lane in 0..LANES {
            lanes[lane] += f(a[lane], b[lane]);
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| f(*a, *b)).sum();
    fold(lanes) + rest
}

/// Σ x_i y_i.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    sum_pairs(x, y, |x, y| x * y)
}

/// Σ x_i.
pub fn sum(x: &[f64]) -> f64 {
    sum_pairs(x, x, |x, _| x)
}

/// Σ w_i x_i².
pub fn weighted_square(x: &[f64], weights: &[f64]) -> f64 {
    sum_pairs(x, weights, |x, weight| weight * x * x)
}

/// Σ w_i f(x_i).
pub fn weighted_sum(weights: &[f64], x: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    sum_pairs(weights, x, |weight, x| weight * f(x))
}

/// y ← y + a x.
pub fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    assert_eq!(x.len(), y.len());
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// y ← a y.
pub fn scale(y: &mut [f64], a: f64) {
    for y in y {
        *y *= a;
    }
}

/// sqrt(Σ x_i²).
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The sum of the lanes by halves.
fn fold(mut lanes: [f64; LANES]) -> f64 {
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            lanes[lane] += lanes[lane + width];
        }
        width /= 2;
    }
    lanes[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_cover_every_entry_whatever_the_length() {
        for length in 0..70 {
            let x: Vec<f64> = (0..length).map(|i| f64::from(i) + 1.0).collect();
            let n = f64::from(length);
            assert_eq!(sum(&x), n * (n + 1.0) / 2.0);
            assert_eq!(dot(&x, &x), n * (n + 1.0) * (2.0 * n + 1.0) / 6.0);
            let mut y = x.clone();
            add_scaled(&mut y, 2.0, &x);
            assert!(y.iter().zip(&x).all(|(y, x)| *y == 3.0 * x));
        }
    }
}
