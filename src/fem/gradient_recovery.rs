//! How well a P1 function resolves what it stands for, from the function itself.
//!
//! The same gradients serve to interpolate with the quadratics that they make of the function.
//!
//! The gradient is recovered at the nodes, as the mean over the triangles around, weighted by their
//! areas; on a regular mesh it is of one order better than that of the triangles (Zienkiewicz and Zhu).
//! Along an edge from a to b a cubic with these slopes differs in the middle from the straight line by
//! (g_a − g_b)·(b − a)/8: the coefficient of the edge's quadratic bubble. The L2 norm of all bubbles, by
//! the midpoints of the edges, estimates the error of interpolation, which is of order h².

use super::Mesh;
use crate::geometry::Vector;

/// Room for the recovered gradients of a mesh.
#[derive(Debug, Clone, Default)]
pub struct GradientRecovery {
    gradients: Vec<Vector>,
    weights: Vec<f64>,
}

impl GradientRecovery {
    /// The estimated L2 norm of u − u_h, u_h the P1 function with these nodal values. Allocates only
    /// the first time.
    pub fn interpolation_error(&mut self, mesh: &Mesh, values: &[f64]) -> f64 {
        self.recover(mesh, values);
        let mut sum = 0.0;
        for (triangle, area) in mesh.triangles().iter().zip(mesh.measures()) {
            for edge in 0..3 {
                let [a, b] = [triangle[edge] as usize, triangle[(edge + 1) % 3] as usize];
                let along = mesh.nodes()[b] - mesh.nodes()[a];
                let bubble = (self.gradients[a] - self.gradients[b]).dot(&along) / 8.0;
                sum += area / 3.0 * bubble * bubble;
            }
        }
        sum.sqrt()
    }

    /// The recovered gradients at the nodes.
    pub fn gradients(&mut self, mesh: &Mesh, values: &[f64]) -> &[Vector] {
        self.recover(mesh, values);
        &self.gradients
    }

    fn recover(&mut self, mesh: &Mesh, values: &[f64]) {
        let nodes = mesh.nodes().len();
        self.gradients.clear();
        self.gradients.resize(nodes, Vector::zeros());
        self.weights.clear();
        self.weights.resize(nodes, 0.0);
        let triangles = mesh.triangles().iter().zip(mesh.areas());
        for ((triangle, area), basis) in triangles.zip(mesh.gradients()) {
            let mut gradient = Vector::zeros();
            for (node, slope) in triangle.iter().zip(basis) {
                gradient += values[*node as usize] * slope;
            }
            for node in triangle.map(|node| node as usize) {
                self.weights[node] += area;
                self.gradients[node] += *area * gradient;
            }
        }
        for (gradient, weight) in self.gradients.iter_mut().zip(&self.weights) {
            *gradient /= *weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The estimate for a function, and the true error of its interpolation.
    fn both(cells: usize, u: impl Fn(f64, f64) -> f64) -> [f64; 2] {
        let mesh = Mesh::structured(cells, 0.0, 1).expect("a mesh");
        let values: Vec<f64> = mesh.nodes().iter().map(|at| u(at.x, at.y)).collect();
        let estimate = GradientRecovery::default().interpolation_error(&mesh, &values);
        // By twelve points a triangle, the midpoints of the edges of its four parts.
        let mut sum = 0.0;
        for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
            let corners = triangle.map(|node| mesh.nodes()[node as usize]);
            let nodal = triangle.map(|node| values[node as usize]);
            for i in 0..4 {
                for j in 0..4 - i {
                    let weights = [(i as f64 + 1.0 / 3.0) / 4.0, (j as f64 + 1.0 / 3.0) / 4.0];
                    let weights = [weights[0], weights[1], 1.0 - weights[0] - weights[1]];
                    let at = |axis: usize| (0..3).map(|k| weights[k] * corners[k][axis]).sum();
                    let linear: f64 = (0..3).map(|k| weights[k] * nodal[k]).sum();
                    sum += area / 10.0 * (u(at(0), at(1)) - linear).powi(2);
                }
            }
        }
        [estimate, sum.sqrt()]
    }

    #[test]
    fn a_linear_function_has_no_error() {
        assert!(both(8, |x, y| 1.0 + 2.0 * x - y)[0] < 1e-14);
    }

    #[test]
    fn a_resolved_membrane_is_estimated_to_a_third() {
        let circle = |x: f64, y: f64| ((0.3 - (x - 0.5).hypot(y - 0.5)) / 0.08).tanh();
        for cells in [32, 64, 128] {
            let [estimate, truth] = both(cells, circle);
            let effectivity = estimate / truth;
            assert!((0.67..1.5).contains(&effectivity), "{cells}: {effectivity}");
        }
        let [coarse, fine] = [32, 64].map(|cells| both(cells, circle)[0]);
        let order = (coarse / fine).log2();
        assert!((1.7..2.2).contains(&order), "{order}");
    }
}
