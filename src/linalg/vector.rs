//! Operations on vectors. Sums run in a fixed number of lanes, in a fixed order, so that they are
//! fast, lose little to rounding, and give the same bits on every machine and every run.

use wide::f64x8;

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

/// Σ w_i f(x_i), where f is given eight numbers at once.
pub fn weighted_sum(weights: &[f64], x: &[f64], f: impl Fn(f64x8) -> f64x8) -> f64 {
    assert_eq!(x.len(), weights.len());
    let (mut even, mut odd) = (f64x8::ZERO, f64x8::ZERO);
    let (x_chunks, x_rest) = x.as_chunks();
    let (w_chunks, w_rest) = weights.as_chunks();
    for ([w_even, w_odd], [x_even, x_odd]) in pairs(w_chunks).zip(pairs(x_chunks)) {
        even += f64x8::new(*w_even) * f(f64x8::new(*x_even));
        odd += f64x8::new(*w_odd) * f(f64x8::new(*x_odd));
    }
    if let (Some(w), Some(x)) = (unpaired(w_chunks), unpaired(x_chunks)) {
        even += f64x8::new(*w) * f(f64x8::new(*x));
    }
    let of_rest = |(w, x): (&f64, &f64)| w * f(f64x8::splat(*x)).to_array()[0];
    let rest: f64 = w_rest.iter().zip(x_rest).map(of_rest).sum();
    (even + odd).reduce_add() + rest
}

type Eight = [f64; 8];

/// Chunks two by two.
fn pairs(chunks: &[Eight]) -> impl Iterator<Item = &[Eight; 2]> {
    chunks.as_chunks().0.iter()
}

/// The last one of an odd number.
fn unpaired(chunks: &[Eight]) -> Option<&Eight> {
    chunks.as_chunks::<2>().1.first()
}

/// y ← y + a x.
pub fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    assert_eq!(x.len(), y.len());
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// y ← y + a x, and then Σ y_i z_i.
pub fn add_scaled_and_dot(y: &mut [f64], a: f64, x: &[f64], z: &[f64]) -> f64 {
    add_scaled_and_sum(y, a, x, z, |y, z| y * z)
}

/// y ← y + a x, and then sqrt(Σ y_i²).
pub fn add_scaled_and_norm(y: &mut [f64], a: f64, x: &[f64]) -> f64 {
    add_scaled_and_sum(y, a, x, x, |y, _| y * y).sqrt()
}

/// y ← y + a x, and then Σ f(y_i, z_i), in one sweep.
#[inline(always)]
fn add_scaled_and_sum(
    y: &mut [f64],
    a: f64,
    x: &[f64],
    z: &[f64],
    f: impl Fn(f64, f64) -> f64,
) -> f64 {
    assert!(x.len() == y.len() && z.len() == y.len());
    let mut lanes = [0.0; LANES];
    let (y_chunks, y_rest) = y.as_chunks_mut::<LANES>();
    let (x_chunks, x_rest) = x.as_chunks::<LANES>();
    let (z_chunks, z_rest) = z.as_chunks::<LANES>();
    for ((y, x), z) in y_chunks.iter_mut().zip(x_chunks).zip(z_chunks) {
        for lane in 0..LANES {
            y[lane] += a * x[lane];
            lanes[lane] += f(y[lane], z[lane]);
        }
    }
    let mut rest = 0.0;
    for ((y, x), z) in y_rest.iter_mut().zip(x_rest).zip(z_rest) {
        *y += a * x;
        rest += f(*y, *z);
    }
    fold(lanes) + rest
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
            let squares = weighted_sum(&x, &x, |x| x * x);
            assert_eq!(squares, (n * (n + 1.0) / 2.0).powi(2));
            assert_eq!(dot(&x, &x), n * (n + 1.0) * (2.0 * n + 1.0) / 6.0);
            let mut y = x.clone();
            add_scaled(&mut y, 2.0, &x);
            assert!(y.iter().zip(&x).all(|(y, x)| *y == 3.0 * x));
            let z: Vec<f64> = (0..length).map(|i| f64::from(i % 3)).collect();
            let mut other = y.clone();
            add_scaled(&mut other, -2.5, &x);
            assert_eq!(add_scaled_and_dot(&mut y, -2.5, &x, &z), dot(&other, &z));
            assert_eq!(y, other);
            add_scaled(&mut other, 0.7, &z);
            assert_eq!(add_scaled_and_norm(&mut y, 0.7, &z), norm(&other));
        }
    }
}
