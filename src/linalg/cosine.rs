//! The two-dimensional cosine transform (type I) of a square grid, as products with small dense
//! matrices.
//!
//! With n intervals a side and the vectors c_k(j) = cos(π j k / n), j, k = 0 … n, a grid function x
//! is transformed to x̂_kl = Σ_ij c_k(i) c_l(j) x_ij. The vectors with even k are even about the
//! middle of the grid and those with odd k are odd, so each direction is folded in two first: four
//! products with matrices of half the size instead of one, half the flops. At n = 120 this beats a
//! fast Fourier transform.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::parallel;

/// The sizes of the dense matrices are multiples of this: two registers of eight f64.
const PADDING: usize = 16;

/// A folded part of the grid, and room for a product with it.
#[derive(Debug)]
struct Part {
    values: Mat<f64>,
    product: Mat<f64>,
}

/// The transform of a grid of (n + 1)² values, row after row.
#[derive(Debug)]
pub struct CosineTransform {
    intervals: usize,
    /// cos(π j k / n) for the even, then for the odd k: a row for each k, a column for each j of the
    /// first half of the grid.
    waves: [Mat<f64>; 2],
    /// The four folded parts, by the parities in the row number and in the column number of the
    /// grid; a column of a part is a row of the grid.
    parts: [[Part; 2]; 2],
    /// One row of the grid plus and minus its mirror image.
    folded: [Vec<f64>; 2],
}

impl CosineTransform {
    /// For a grid of `intervals` + 1 values a side.
    pub fn new(intervals: usize) -> Self {
        let n = intervals;
        // Even vectors live on j = 0 ..= n/2, odd ones vanish in the middle of an even grid.
        let halves = [n / 2 + 1, n.div_ceil(2)];
        // Padded with zeros: at sizes that do not fill the registers a product takes up to twenty
        // times as long (measured at 61 against 64).
        let padded = halves.map(|half| half.next_multiple_of(PADDING));
        let wave = |parity: usize| {
            Mat::from_fn(padded[parity], padded[parity], |row, j| {
                if row >= halves[parity] || j >= halves[parity] {
                    return 0.0;
                }
                let k = 2 * row + parity;
                // The angle is reduced in integers, so that no digit is lost for large k j.
                (std::f64::consts::PI * ((j * k) % (2 * n)) as f64 / n as f64).cos()
            })
        };
        let part = |rows: usize, columns: usize| Part {
            values: Mat::zeros(padded[columns], padded[rows]),
            product: Mat::zeros(padded[columns], padded[rows]),
        };
        Self {
            intervals,
            waves: [wave(0), wave(1)],
            parts: [0, 1].map(|rows| [0, 1].map(|columns| part(rows, columns))),
            folded: [vec![0.0; n + 1], vec![0.0; n + 1]],
        }
    }

    /// Σ_j c_k(j)² w_j with the weights w = ½ at the ends and 1 between: n for k = 0 and n, else n/2.
    pub fn squared_norm(&self, k: usize) -> f64 {
        let n = self.intervals as f64;
        if k == 0 || k == self.intervals {
            n
        } else {
            n / 2.0
        }
    }

    /// A multiplier for [`filter`](Self::filter): `factor(k, l)` for every pair of wave numbers.
    pub fn multiplier(&self, factor: impl Fn(usize, usize) -> f64) -> Multiplier {
        let part = |rows: usize, columns: usize| {
            Mat::zeros(self.waves[columns].nrows(), self.waves[rows].nrows())
        };
        let mut multiplier =
            Multiplier([0, 1].map(|rows| [0, 1].map(|columns| part(rows, columns))));
        self.set_multiplier(&mut multiplier, factor);
        multiplier
    }

    /// Other factors for a multiplier of this transform, without allocation.
    pub fn set_multiplier(
        &self,
        multiplier: &mut Multiplier,
        factor: impl Fn(usize, usize) -> f64,
    ) {
        for (rows, parts) in multiplier.0.iter_mut().enumerate() {
            for (columns, part) in parts.iter_mut().enumerate() {
                for column in 0..part.ncols() {
                    let k = 2 * column + rows;
                    for (row, value) in part.col_as_slice_mut(column).iter_mut().enumerate() {
                        let l = 2 * row + columns;
                        let padding = k > self.intervals || l > self.intervals;
                        *value = if padding { 0.0 } else { factor(k, l) };
                    }
                }
            }
        }
    }

    /// y ← C (D · (Cᵀ x)): the transform of x, a multiplication of each coefficient by the
    /// multiplier, and the transform back, unscaled.
    pub fn filter(&mut self, multiplier: &Multiplier, x: &[f64], y: &mut [f64]) {
        self.fold(x);
        let waves = &self.waves;
        let parts = self.parts.as_flattened_mut();
        parallel::over_items(parts, ((), 0), |number, part, ()| {
            let (rows, columns) = (number / 2, number % 2);
            let (along, across) = (waves[columns].as_ref(), waves[rows].as_ref());
            part.multiply(along, across.transpose());
            let factors = &multiplier.0[rows][columns];
            for column in 0..factors.ncols() {
                let values = part.values.col_as_slice_mut(column);
                for (value, factor) in values.iter_mut().zip(factors.col_as_slice(column)) {
                    *value *= factor;
                }
            }
            part.multiply(along.transpose(), across);
        });
        self.unfold(y);
        // Every value of y depends on every value of x. The padding, too, is no longer zero then, and
        // would spoil whatever is transformed next.
        if !y.first().is_none_or(|value| value.is_finite()) {
            for part in self.parts.iter_mut().flatten() {
                part.values.fill(0.0);
            }
        }
    }

    /// Splits x into parts that are even and odd about the middle, along both directions.
    fn fold(&mut self, x: &[f64]) {
        let n = self.intervals;
        let side = n + 1;
        for i in 0..=n / 2 {
            let (near, far) = (&x[i * side..][..side], &x[(n - i) * side..][..side]);
            let [even, odd] = &mut self.folded;
            // The middle row of an even grid has no odd part.
            let parities = if i == n - i { 1 } else { 2 };
            if parities == 1 {
                even.copy_from_slice(near);
            } else {
                for (((e, o), a), b) in even.iter_mut().zip(odd.iter_mut()).zip(near).zip(far) {
                    *e = a + b;
                    *o = a - b;
                }
            }
            for rows in 0..parities {
                let [even, odd] = &mut self.parts[rows];
                let (even, odd) = (
                    &mut even.values.col_as_slice_mut(i)[..=n / 2],
                    odd.values.col_as_slice_mut(i),
                );
                let values = &self.folded[rows];
                let mirrored = values.iter().rev();
                for (((e, o), a), b) in even.iter_mut().zip(odd).zip(values).zip(mirrored) {
                    *e = a + b;
                    *o = a - b;
                }
                if n.is_multiple_of(2) {
                    even[n / 2] = values[n / 2];
                }
            }
        }
    }

    /// Puts the four parts together again.
    fn unfold(&mut self, y: &mut [f64]) {
        let n = self.intervals;
        let side = n + 1;
        for i in 0..=n / 2 {
            let parities = if i == n - i { 1 } else { 2 };
            for rows in 0..parities {
                let [even, odd] = &self.parts[rows];
                let (even, odd) = (
                    &even.values.col_as_slice(i)[..=n / 2],
                    odd.values.col_as_slice(i),
                );
                let values = &mut self.folded[rows];
                for (j, (e, o)) in even.iter().zip(odd).enumerate() {
                    values[j] = e + o;
                    values[n - j] = e - o;
                }
                if n.is_multiple_of(2) {
                    values[n / 2] = even[n / 2];
                }
            }
            let [even, odd] = &self.folded;
            if parities == 1 {
                y[i * side..][..side].copy_from_slice(even);
            } else {
                let (near, far) = y.split_at_mut((n - i) * side);
                let near = &mut near[i * side..][..side];
                for (((a, b), e), o) in near.iter_mut().zip(far).zip(even).zip(odd) {
                    *a = e + o;
                    *b = e - o;
                }
            }
        }
    }
}

/// A factor for each coefficient of a transform.
#[derive(Debug)]
pub struct Multiplier([[Mat<f64>; 2]; 2]);

impl Part {
    /// values ← left · values · right.
    fn multiply(&mut self, left: MatRef<'_, f64>, right: MatRef<'_, f64>) {
        let Self { values, product } = self;
        matmul(&mut *product, Accum::Replace, left, &*values, 1.0, Par::Seq);
        matmul(
            &mut *values,
            Accum::Replace,
            &*product,
            right,
            1.0,
            Par::Seq,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn what_is_not_finite_leaves_nothing_behind() {
        for n in [8, 9, 20] {
            let mut transform = CosineTransform::new(n);
            let multiplier = transform.multiplier(|k, l| 1.0 / (1 + k + l) as f64);
            let size = (n + 1) * (n + 1);
            let good: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
            let mut expected = vec![0.0; size];
            transform.filter(&multiplier, &good, &mut expected);
            for bad in [f64::NAN, f64::INFINITY] {
                let mut y = good.clone();
                y[size / 3] = bad;
                let x = y.clone();
                transform.filter(&multiplier, &x, &mut y);
                assert!(!y[0].is_finite());
                transform.filter(&multiplier, &good, &mut y);
                assert_eq!(y, expected, "n = {n}");
            }
        }
    }

    fn wave(n: usize, k: usize, j: usize) -> f64 {
        (PI * (k * j) as f64 / n as f64).cos()
    }

    /// C (D · (Cᵀ x)) by its definition.
    fn filter_by_definition(n: usize, factor: impl Fn(usize, usize) -> f64, x: &[f64]) -> Vec<f64> {
        let side = n + 1;
        let mut y = vec![0.0; side * side];
        for k in 0..side {
            for l in 0..side {
                let mut coefficient = 0.0;
                for i in 0..side {
                    for j in 0..side {
                        coefficient += wave(n, k, i) * wave(n, l, j) * x[i * side + j];
                    }
                }
                coefficient *= factor(k, l);
                for i in 0..side {
                    for j in 0..side {
                        y[i * side + j] += wave(n, k, i) * wave(n, l, j) * coefficient;
                    }
                }
            }
        }
        y
    }

    #[test]
    fn agrees_with_the_definition_on_even_and_odd_grids() {
        for n in [4, 5, 8, 9, 32] {
            let side = n + 1;
            let x: Vec<f64> = (0..side * side)
                .map(|i| ((i * i) as f64 * 0.7).sin())
                .collect();
            let factor = |k: usize, l: usize| 1.0 / (1.0 + k as f64 + 3.0 * (l * l) as f64);
            let mut transform = CosineTransform::new(n);
            let multiplier = transform.multiplier(factor);
            let mut y = vec![0.0; side * side];
            transform.filter(&multiplier, &x, &mut y);
            for (y, exact) in y.iter().zip(filter_by_definition(n, factor, &x)) {
                assert!((y - exact).abs() < 1e-11, "{y} {exact}");
            }
        }
    }

    #[test]
    fn the_squared_norms_make_the_transform_its_own_inverse() {
        let n = 10;
        let side = n + 1;
        let weight = |i: usize| if i == 0 || i == n { 0.5 } else { 1.0 };
        let mut transform = CosineTransform::new(n);
        let norm = |k| transform.squared_norm(k);
        let multiplier = transform.multiplier(|k, l| 1.0 / (norm(k) * norm(l)));
        let x: Vec<f64> = (0..side * side).map(|i| (i as f64).cos()).collect();
        let weighted: Vec<f64> = (0..side * side)
            .map(|i| x[i] * weight(i / side) * weight(i % side))
            .collect();
        let mut y = vec![0.0; side * side];
        transform.filter(&multiplier, &weighted, &mut y);
        assert!(y.iter().zip(&x).all(|(y, x)| (y - x).abs() < 1e-13));
    }
}
