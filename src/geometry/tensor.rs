//! Symmetric tensors of second order.

use std::ops::{Add, AddAssign, Index, Mul};

use nalgebra::Vector3;

use super::Vector;

/// A symmetric 2 × 2 tensor: its entries xx, xy and yy, in this order in memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(transparent)]
pub struct SymmetricTensor(Vector3<f64>);

impl SymmetricTensor {
    /// The tensor with these entries.
    #[inline]
    pub const fn new(xx: f64, xy: f64, yy: f64) -> Self {
        Self(Vector3::new(xx, xy, yy))
    }

    /// The unit tensor, times a factor.
    #[inline]
    pub const fn isotropic(scale: f64) -> Self {
        Self::new(scale, 0.0, scale)
    }

    /// scale · v⊗v.
    #[inline]
    pub fn outer(scale: f64, v: Vector) -> Self {
        let scaled = scale * v;
        Self::new(scaled.x * v.x, scaled.x * v.y, scaled.y * v.y)
    }

    /// Its entries xx, xy and yy.
    #[inline]
    pub fn entries(&self) -> [f64; 3] {
        self.0.into()
    }

    /// The sum of its eigenvalues.
    #[inline]
    pub fn trace(&self) -> f64 {
        self.0.x + self.0.z
    }

    /// (T v)·v.
    #[inline]
    pub fn quadratic_form(&self, v: Vector) -> f64 {
        let [xx, xy, yy] = self.entries();
        xx * v.x * v.x + 2.0 * xy * v.x * v.y + yy * v.y * v.y
    }
}

impl Index<(usize, usize)> for SymmetricTensor {
    type Output = f64;

    /// The entry of a row and a column.
    #[inline]
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.0[row + column]
    }
}

impl Add for SymmetricTensor {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for SymmetricTensor {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Mul<SymmetricTensor> for f64 {
    type Output = SymmetricTensor;

    #[inline]
    fn mul(self, tensor: SymmetricTensor) -> SymmetricTensor {
        SymmetricTensor(self * tensor.0)
    }
}

impl Mul<Vector> for SymmetricTensor {
    type Output = Vector;

    #[inline]
    fn mul(self, v: Vector) -> Vector {
        let [xx, xy, yy] = self.entries();
        Vector::new(xx * v.x + xy * v.y, xy * v.x + yy * v.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    fn matrix(tensor: SymmetricTensor) -> Matrix2<f64> {
        Matrix2::from_fn(|row, column| tensor[(row, column)])
    }

    #[test]
    fn the_algebra_is_that_of_matrices() {
        let (u, v) = (Vector::new(2.0, -3.0), Vector::new(0.5, 4.0));
        let tensor = SymmetricTensor::new(1.0, -2.0, 5.0);
        assert_eq!(matrix(tensor), Matrix2::new(1.0, -2.0, -2.0, 5.0));
        assert_eq!(tensor.entries(), [1.0, -2.0, 5.0]);
        let outer = SymmetricTensor::outer(0.25, u);
        assert_eq!(matrix(outer), 0.25 * u * u.transpose());
        assert_eq!(matrix(tensor + outer), matrix(tensor) + matrix(outer));
        assert_eq!(matrix(-3.0 * tensor), -3.0 * matrix(tensor));
        assert_eq!(tensor * v, matrix(tensor) * v);
        assert_eq!(tensor.quadratic_form(v), (tensor * v).dot(&v));
        assert_eq!(tensor.trace(), matrix(tensor).trace());
        assert_eq!(SymmetricTensor::isotropic(7.0) * u, 7.0 * u);
        let mut sum = tensor;
        sum += outer;
        assert_eq!(sum, tensor + outer);
    }
}
