//! Weighted mass forms ∫ c ψ_i ψ_j: diagonal with the lumped rule, sparse with the consistent one.

use std::sync::Arc;

use crate::linalg::{Pattern, SparseMatrix};

/// The matrix of ∫ c ψ_i ψ_j.
#[derive(Debug, Clone)]
pub enum MassForm {
    /// Its diagonal (lumped rule).
    Nodal(Vec<f64>),
    /// Its entries on the pattern of the mesh (consistent rule).
    Sparse(SparseMatrix),
}

impl MassForm {
    pub(super) fn nodal(size: usize) -> Self {
        Self::Nodal(vec![0.0; size])
    }

    pub(super) fn sparse(pattern: Arc<Pattern>) -> Self {
        Self::Sparse(SparseMatrix::zeros(pattern))
    }

    /// Makes it zero.
    pub fn clear(&mut self) {
        match self {
            Self::Nodal(diagonal) => diagonal.fill(0.0),
            Self::Sparse(matrix) => matrix.values.fill(0.0),
        }
    }

    /// y ← A x.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Nodal(diagonal) => {
                for ((y, d), x) in y.iter_mut().zip(diagonal).zip(x) {
                    *y = d * x;
                }
            }
            Self::Sparse(matrix) => matrix.multiply(x, y),
        }
    }

    /// y ← y + s A x.
    pub fn multiply_add(&self, s: f64, x: &[f64], y: &mut [f64]) {
        match self {
            Self::Nodal(diagonal) => {
                for ((y, d), x) in y.iter_mut().zip(diagonal).zip(x) {
                    *y += s * d * x;
                }
            }
            Self::Sparse(matrix) => matrix.multiply_add(s, x, y),
        }
    }

    /// xᵀ A x.
    pub fn quadratic_form(&self, x: &[f64]) -> f64 {
        match self {
            Self::Nodal(diagonal) => diagonal.iter().zip(x).map(|(d, x)| d * x * x).sum(),
            Self::Sparse(matrix) => matrix.quadratic_form(x),
        }
    }

    /// The diagonal of the matrix.
    pub fn diagonal(&self) -> Vec<f64> {
        match self {
            Self::Nodal(diagonal) => diagonal.clone(),
            Self::Sparse(matrix) => matrix.diagonal(),
        }
    }

    /// B ← B + s A for a matrix B on the pattern of the mesh, where `diagonal` says where the
    /// diagonal entries of the pattern are stored.
    pub fn add_to(&self, s: f64, diagonal: &[u32], values: &mut [f64]) {
        match self {
            Self::Nodal(entries) => {
                for (&position, entry) in diagonal.iter().zip(entries) {
                    values[position as usize] += s * entry;
                }
            }
            Self::Sparse(matrix) => {
                for (value, entry) in values.iter_mut().zip(&matrix.values) {
                    *value += s * entry;
                }
            }
        }
    }
}
