//! The transform of the values on a rectangular grid to coefficients of products of functions of one
//! direction each, as products with small dense matrices.
//!
//! With the functions u_l(j) of a column number and c_k(i) = cos(π i k / n) of a row number i = 0 … n a grid
//! function x is transformed to x̂_kl = Σ_ij c_k(i) u_l(j) x_ij. In a row, too, u may be the cosines (type I), or
//! the eigenvectors of a chain of springs and masses ([`Basis::eigenvectors`]).
//!
//! The cosines with even k are even about the middle of the grid and those with odd k are odd, so a direction that
//! has them is folded in two first: with cosines in both, four products with matrices of half the size instead of
//! one, half the flops. At n = 120 this beats a fast Fourier transform. Eigenvectors have no such symmetry. A
//! transform to and fro takes 4n³ multiplications and additions, each counted, with cosines in both directions and
//! 6n³ with eigenvectors in one.

use std::f64::consts::PI;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};

use super::{LinalgError, parallel};

/// The sizes of the dense matrices are multiples of this: two registers of eight f64.
const PADDING: usize = 16;

/// Functions of one direction of the grid, orthogonal with weights w.
#[derive(Debug)]
pub struct Basis {
    /// Values of each function along the direction, and how many functions there are.
    values: usize,
    /// A row for each function, a column for each value. Cosines: the even, then the odd ones, with a column for each value
    /// of the first half.
    functions: Vec<Mat<f64>>,
    neighbour_means: Vec<f64>,
    squared_norms: Vec<f64>,
}

impl Basis {
    /// cos(π j k / n), j, k = 0 … n, with the weights w = ½ at the ends and 1 between.
    pub fn cosines(intervals: usize) -> Self {
        let n = intervals;
        // The angle is reduced in integers, so that no digit is lost for large k j.
        let cosine = |k: usize, j: usize| (PI * ((j * k) % (2 * n)) as f64 / n as f64).cos();
        // Even functions live on j = 0 ..= n/2, odd ones vanish in the middle of an even grid.
        let halves = [n / 2 + 1, n.div_ceil(2)];
        let functions = [0, 1].map(|parity| {
            let half = halves[parity];
            padded(half, |row, j| cosine(2 * row + parity, j))
        });
        let squared_norm = |k| match k {
            0 => n as f64,
            k if k == n => n as f64,
            _ => n as f64 / 2.0,
        };
        Self {
            values: n + 1,
            functions: functions.into(),
            neighbour_means: (0..=n).map(|k| cosine(k, 1)).collect(),
            squared_norms: (0..=n).map(squared_norm).collect(),
        }
    }

    /// The eigenvectors of T u = λ W u, where uᵀT u = Σ_j s_j (u_{j+1} − u_j)² for the given s_j and W is diagonal with the
    /// given weights, one more: from the least λ, 0, for which u is constant, to the largest one. They are normalised,
    /// uᵀW u = 1.
    ///
    /// # Errors
    /// [`LinalgError::Eigenvectors`] where they could not be computed, as with a weight that is not positive.
    pub fn eigenvectors(springs: &[f64], weights: &[f64]) -> Result<Self, LinalgError> {
        let size = weights.len();
        let roots: Vec<f64> = weights.iter().map(|weight| weight.sqrt()).collect();
        let mut scaled: Mat<f64> = Mat::zeros(size, size);
        for (j, spring) in springs.iter().enumerate() {
            scaled[(j, j)] += spring / weights[j];
            scaled[(j + 1, j + 1)] += spring / weights[j + 1];
            scaled[(j + 1, j)] -= spring / (roots[j] * roots[j + 1]);
        }
        let failed = |reason: String| LinalgError::Eigenvectors { size, reason };
        let eigen = scaled.self_adjoint_eigen(Side::Lower);
        let eigen = eigen.map_err(|error| failed(format!("{error:?}")))?;
        let vectors = eigen.U();
        let eigenvalues: Vec<f64> = eigen.S().column_vector().iter().copied().collect();
        let functions = padded(size, |k, j| vectors[(j, k)] / roots[j]);
        if !eigenvalues.iter().all(|value| value.is_finite()) {
            return Err(failed("an eigenvalue is not finite".to_owned()));
        }
        Ok(Self {
            values: size,
            functions: vec![functions],
            neighbour_means: eigenvalues.iter().map(|value| 1.0 - value / 2.0).collect(),
            squared_norms: vec![1.0; size],
        })
    }

    /// 1 − λ_k/2, where T u = λ W u: of a cosine cos(π k / n), the mean of a value's two neighbours over the value.
    pub fn neighbour_mean(&self, k: usize) -> f64 {
        self.neighbour_means[k]
    }

    /// Σ_j w_j u_k(j)².
    pub fn squared_norm(&self, k: usize) -> f64 {
        self.squared_norms[k]
    }

    /// The number of a function in one of the matrices; `None` where that is padding.
    fn number(&self, part: usize, row: usize) -> Option<usize> {
        let number = self.functions.len() * row + part;
        (number < self.values).then_some(number)
    }
}

/// A square matrix of this size with these entries, padded with zeros: at sizes that do not fill the registers a product
/// takes up to twenty times as long (measured at 61 against 64).
fn padded(size: usize, entry: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    let length = size.next_multiple_of(PADDING);
    Mat::from_fn(length, length, |row, column| {
        if row < size && column < size {
            entry(row, column)
        } else {
            0.0
        }
    })
}

/// A folded part of the grid, and room for a product with it.
#[derive(Debug)]
struct Part {
    values: Mat<f64>,
    product: Mat<f64>,
}

/// The transform of a grid of values, row after row.
#[derive(Debug)]
pub struct GridTransform {
    /// Of a column's values: cosines.
    across: Basis,
    /// Of a row's values.
    along: Basis,
    /// The folded parts: first those that are even across the rows, then those that are odd; of each, in the order of the
    /// matrices of `along`. A column of a part is a row of the grid.
    parts: Vec<Part>,
    /// One row of the grid plus and minus its mirror image.
    folded: [Vec<f64>; 2],
}

impl GridTransform {
    /// For a grid of `intervals` + 1 rows, by cosines, with this basis in each.
    pub fn new(intervals: usize, along: Basis) -> Self {
        let across = Basis::cosines(intervals);
        let part = |rows: &Mat<f64>, columns: &Mat<f64>| Part {
            values: Mat::zeros(columns.nrows(), rows.nrows()),
            product: Mat::zeros(columns.nrows(), rows.nrows()),
        };
        let parts = across.functions.iter();
        let parts = parts.flat_map(|rows| along.functions.iter().map(move |it| part(rows, it)));
        let folded = [0, 1].map(|_| vec![0.0; along.values]);
        Self {
            parts: parts.collect(),
            across,
            along,
            folded,
        }
    }

    /// The cosines of a column's values.
    pub fn across(&self) -> &Basis {
        &self.across
    }

    /// The basis in each row.
    pub fn along(&self) -> &Basis {
        &self.along
    }

    /// A multiplier for [`filter`](Self::filter): `factor(k, l)` for c_k across the rows and u_l in them.
    pub fn multiplier(&self, factor: impl Fn(usize, usize) -> f64) -> Multiplier {
        let part = |part: &Part| Mat::zeros(part.values.nrows(), part.values.ncols());
        let mut multiplier = Multiplier(self.parts.iter().map(part).collect());
        self.set_multiplier(&mut multiplier, factor);
        multiplier
    }

    /// Other factors for a multiplier of this transform, without allocation.
    pub fn set_multiplier(
        &self,
        multiplier: &mut Multiplier,
        factor: impl Fn(usize, usize) -> f64,
    ) {
        let parts = self.along.functions.len();
        for (number, factors) in multiplier.0.iter_mut().enumerate() {
            for column in 0..factors.ncols() {
                let k = self.across.number(number / parts, column);
                for (row, value) in factors.col_as_slice_mut(column).iter_mut().enumerate() {
                    let l = self.along.number(number % parts, row);
                    *value = k.zip(l).map_or(0.0, |(k, l)| factor(k, l));
                }
            }
        }
    }

    /// y ← C (D · (Cᵀ x)): the transform of x, a multiplication of each coefficient by the
    /// multiplier, and the transform back, unscaled.
    pub fn filter(&mut self, multiplier: &Multiplier, x: &[f64], y: &mut [f64]) {
        self.fold(x);
        let (across, along) = (&self.across.functions, &self.along.functions);
        parallel::over_items(&mut self.parts, ((), 0), |number, part, ()| {
            let rows = across[number / along.len()].as_ref();
            let columns = along[number % along.len()].as_ref();
            part.multiply(columns, rows.transpose());
            let factors = &multiplier.0[number];
            for column in 0..factors.ncols() {
                let values = part.values.col_as_slice_mut(column);
                for (value, factor) in values.iter_mut().zip(factors.col_as_slice(column)) {
                    *value *= factor;
                }
            }
            part.multiply(columns.transpose(), rows);
        });
        self.unfold(y);
        // Every value of y depends on every value of x. The padding, too, is no longer zero then, and
        // would spoil whatever is transformed next.
        if !y.first().is_none_or(|value| value.is_finite()) {
            for part in &mut self.parts {
                part.values.fill(0.0);
            }
        }
    }

    /// Splits x into parts that are even and odd about the middle, across the rows and, where it has cosines, along
    /// them.
    fn fold(&mut self, x: &[f64]) {
        let (n, side) = (self.across.values - 1, self.along.values);
        let each = self.along.functions.len();
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
            let parts = self.parts.chunks_exact_mut(each).zip(&self.folded);
            for (parts, values) in parts.take(parities) {
                match parts {
                    [even, odd] => {
                        let (even, odd) = (
                            &mut even.values.col_as_slice_mut(i)[..=(side - 1) / 2],
                            odd.values.col_as_slice_mut(i),
                        );
                        let mirrored = values.iter().rev();
                        for (((e, o), a), b) in even.iter_mut().zip(odd).zip(values).zip(mirrored) {
                            *e = a + b;
                            *o = a - b;
                        }
                        if !side.is_multiple_of(2) {
                            even[side / 2] = values[side / 2];
                        }
                    }
                    whole => {
                        for part in whole {
                            part.values.col_as_slice_mut(i)[..side].copy_from_slice(values);
                        }
                    }
                }
            }
        }
    }

    /// Puts the parts together again.
    fn unfold(&mut self, y: &mut [f64]) {
        let (n, side) = (self.across.values - 1, self.along.values);
        let each = self.along.functions.len();
        for i in 0..=n / 2 {
            let parities = if i == n - i { 1 } else { 2 };
            let parts = self.parts.chunks_exact(each).zip(&mut self.folded);
            for (parts, values) in parts.take(parities) {
                match parts {
                    [even, odd] => {
                        let (even, odd) = (
                            &even.values.col_as_slice(i)[..=(side - 1) / 2],
                            odd.values.col_as_slice(i),
                        );
                        for (j, (e, o)) in even.iter().zip(odd).enumerate() {
                            values[j] = e + o;
                            values[side - 1 - j] = e - o;
                        }
                        if !side.is_multiple_of(2) {
                            values[side / 2] = even[side / 2];
                        }
                    }
                    whole => {
                        for part in whole {
                            values.copy_from_slice(&part.values.col_as_slice(i)[..side]);
                        }
                    }
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
pub struct Multiplier(Vec<Mat<f64>>);

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

    /// A square grid with cosines in both directions.
    fn cosines(n: usize) -> GridTransform {
        GridTransform::new(n, Basis::cosines(n))
    }

    /// A chain as it is by rotation, with the ends that an axis and a wall have.
    fn chain(n: usize) -> [Vec<f64>; 2] {
        let springs = (0..n).map(|j| j as f64 + 0.5).collect();
        let mut weights: Vec<f64> = (0..=n).map(|j| j as f64).collect();
        (weights[0], weights[n]) = (1.0 / 6.0, (n as f64 - 1.0 / 3.0) / 2.0);
        [springs, weights]
    }

    fn eigenvectors(n: usize) -> Basis {
        let [springs, weights] = chain(n);
        Basis::eigenvectors(&springs, &weights).expect("positive weights")
    }

    #[test]
    fn what_is_not_finite_leaves_nothing_behind() {
        for n in [8, 9, 20] {
            for mut transform in [cosines(n), GridTransform::new(n, eigenvectors(n))] {
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
    }

    fn wave(n: usize, k: usize, j: usize) -> f64 {
        (PI * (k * j) as f64 / n as f64).cos()
    }

    /// C (D · (Cᵀ x)) by its definition, on a grid of m + 1 columns.
    fn filter_by_definition(
        [n, m]: [usize; 2],
        along: impl Fn(usize, usize) -> f64,
        factor: impl Fn(usize, usize) -> f64,
        x: &[f64],
    ) -> Vec<f64> {
        let side = m + 1;
        let mut y = vec![0.0; x.len()];
        for k in 0..=n {
            for l in 0..=m {
                let product = |i: usize, j: usize| wave(n, k, i) * along(l, j);
                let terms = x.iter().enumerate();
                let terms = terms.map(|(node, x)| product(node / side, node % side) * x);
                let coefficient = factor(k, l) * terms.sum::<f64>();
                for (node, y) in y.iter_mut().enumerate() {
                    *y += product(node / side, node % side) * coefficient;
                }
            }
        }
        y
    }

    fn samples(size: usize) -> Vec<f64> {
        (0..size).map(|i| ((i * i) as f64 * 0.7).sin()).collect()
    }

    #[test]
    fn agrees_with_the_definition_on_even_and_odd_grids() {
        for [n, m] in [[4, 4], [5, 5], [8, 5], [9, 32], [32, 8]] {
            let x = samples((n + 1) * (m + 1));
            let factor = |k: usize, l: usize| 1.0 / (1.0 + k as f64 + 3.0 * (l * l) as f64);
            let vectors = eigenvectors(m);
            let cosine = |l: usize, j: usize| wave(m, l, j);
            let vector = |l: usize, j: usize| vectors.functions[0][(l, j)];
            for (basis, exact) in [
                (
                    Basis::cosines(m),
                    filter_by_definition([n, m], cosine, factor, &x),
                ),
                (
                    eigenvectors(m),
                    filter_by_definition([n, m], vector, factor, &x),
                ),
            ] {
                let mut transform = GridTransform::new(n, basis);
                let multiplier = transform.multiplier(factor);
                let mut y = vec![0.0; x.len()];
                transform.filter(&multiplier, &x, &mut y);
                for (y, exact) in y.iter().zip(exact) {
                    assert!((y - exact).abs() < 1e-11, "{y} {exact}");
                }
            }
        }
    }

    /// With the weights before and the squared norms between, on any grid.
    #[test]
    fn the_squared_norms_make_the_transform_its_own_inverse() {
        let half = |n: usize| {
            let ends = move |i: usize| if i == 0 || i == n { 0.5 } else { 1.0 };
            (0..=n).map(ends).collect::<Vec<f64>>()
        };
        for [n, m] in [[10, 10], [10, 7], [24, 130]] {
            let [_, weights] = chain(m);
            for (basis, weights) in [(Basis::cosines(m), half(m)), (eigenvectors(m), weights)] {
                let mut transform = GridTransform::new(n, basis);
                let [across, along] = [transform.across(), transform.along()];
                let norm = |k, l| across.squared_norm(k) * along.squared_norm(l);
                let multiplier = transform.multiplier(|k, l| 1.0 / norm(k, l));
                let x = samples((n + 1) * (m + 1));
                let rows = x.chunks(m + 1).zip(half(n));
                let weighted: Vec<f64> = rows
                    .flat_map(|(row, w)| row.iter().zip(&weights).map(move |(x, v)| x * w * v))
                    .collect();
                let mut y = vec![0.0; x.len()];
                transform.filter(&multiplier, &weighted, &mut y);
                let errors = y.iter().zip(&x).map(|(y, x)| (y - x).abs());
                let error = errors.fold(0.0, f64::max);
                assert!(error < 1e-12, "{n} {m}: {error:e}");
            }
        }
    }

    /// T u = λ W u, at sizes of a run too; and the constants have λ = 0.
    #[test]
    fn eigenvectors_are_those_of_the_chain() {
        for n in [4, 60, 240] {
            let ([springs, weights], basis) = (chain(n), eigenvectors(n));
            for k in 0..=n {
                let u = |j: usize| basis.functions[0][(k, j)];
                let eigenvalue = 2.0 * (1.0 - basis.neighbour_mean(k));
                for (j, weight) in weights.iter().enumerate() {
                    let before = j.checked_sub(1).map_or(0.0, |i| springs[i] * (u(j) - u(i)));
                    let behind = springs.get(j).map_or(0.0, |s| s * (u(j) - u(j + 1)));
                    let excess = before + behind - eigenvalue * weight * u(j);
                    assert!(excess.abs() < 1e-12 * n as f64, "{n} {k} {j}: {excess:e}");
                }
            }
            let constant = weights.iter().sum::<f64>().sqrt().recip();
            let values = (0..=n).map(|j| basis.functions[0][(0, j)].abs());
            assert!(values.into_iter().all(|u| (u - constant).abs() < 1e-12));
            assert!((basis.neighbour_mean(0) - 1.0).abs() < 1e-12);
        }
    }

    /// Of equal springs with half a mass at the ends they are the cosines.
    #[test]
    fn eigenvectors_of_an_even_chain_are_cosines() {
        let n = 12;
        let mut weights = vec![1.0; n + 1];
        (weights[0], weights[n]) = (0.5, 0.5);
        let found = Basis::eigenvectors(&vec![1.0; n], &weights).expect("positive weights");
        let cosines = Basis::cosines(n);
        for k in 0..=n {
            let difference = found.neighbour_mean(k) - cosines.neighbour_mean(k);
            assert!(difference.abs() < 1e-14, "{k}: {difference:e}");
            let scale = found.functions[0][(k, 0)];
            let norm = cosines.squared_norm(k) * scale * scale;
            assert!((norm - 1.0).abs() < 1e-13, "{k}: {norm}");
            for j in 0..=n {
                let error = found.functions[0][(k, j)] - scale * wave(n, k, j);
                assert!(error.abs() < 1e-13, "{k} {j}: {error:e}");
            }
        }
    }

    #[test]
    fn a_weight_that_is_not_positive_has_no_eigenvectors() {
        for weight in [0.0, -1.0, f64::NAN] {
            let found = Basis::eigenvectors(&[1.0; 3], &[1.0, weight, 1.0, 1.0]);
            let error = found.expect_err("no weight").to_string();
            assert!(error.contains("4 values"), "{error}");
        }
    }
}
