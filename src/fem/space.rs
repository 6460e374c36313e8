//! The P1 space on a mesh with one quadrature rule for every integral.
//!
//! Effects work *pointwise*: on arrays with a value at each quadrature point, and on arrays with a
//! value on each triangle (gradients of P1 functions). The space takes nodal fields to the points
//! and brings densities back into loads, forms and numbers. With the consistent rule there are
//! seven points a triangle; with the lumped rule the points *are* the nodes, since all the vertices
//! that meet in a node have the same nodal values: 14 times fewer points, the same code.

use std::sync::Arc;

use super::rule::{POINTS, seven_points};
use super::{Assembly, MassForm, Mesh, Rule, SymmetricTensor};
use crate::linalg::{SparseMatrix, vector};

/// A P1 space with its quadrature.
#[derive(Debug)]
pub struct Space {
    mesh: Arc<Mesh>,
    assembly: Assembly,
    rule: Rule,
    coordinates: [[f64; 3]; POINTS],
    relative_weights: [f64; POINTS],
    /// The weight of each quadrature point.
    weights: Vec<f64>,
    stiffness: SparseMatrix,
    mass: MassForm,
    /// ∫ ψ_i: the diagonal of the lumped mass matrix.
    nodal_weights: Vec<f64>,
}

impl Space {
    /// The space on a mesh.
    pub fn new(mesh: Arc<Mesh>, rule: Rule) -> Self {
        let assembly = Assembly::new(&mesh);
        let (coordinates, relative_weights) = seven_points();
        let mut nodal_weights = vec![0.0; mesh.nodes().len()];
        for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
            for &node in triangle {
                nodal_weights[node as usize] += area / 3.0;
            }
        }
        let weights = match rule {
            Rule::Lumped => nodal_weights.clone(),
            Rule::Consistent => (mesh.areas().iter())
                .flat_map(|area| relative_weights.map(|weight| weight * area))
                .collect(),
        };
        let mut stiffness = SparseMatrix::zeros(assembly.pattern.clone());
        let ones = vec![1.0; mesh.triangles().len()];
        assembly.add_weighted_stiffness(&mesh, &ones, &mut stiffness.values);
        let mass = match rule {
            Rule::Lumped => MassForm::Nodal(nodal_weights.clone()),
            Rule::Consistent => MassForm::sparse(assembly.pattern.clone()),
        };
        let mut space = Self {
            mesh,
            assembly,
            rule,
            coordinates,
            relative_weights,
            weights,
            stiffness,
            mass,
            nodal_weights,
        };
        if rule == Rule::Consistent {
            let mut mass = space.new_form();
            space.assemble_mass(&vec![1.0; space.points()], &mut mass);
            space.mass = mass;
        }
        space
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The sparse pattern of the mesh.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The quadrature rule.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// Nodes of the mesh: the dimension of the space.
    pub fn nodes(&self) -> usize {
        self.mesh.nodes().len()
    }

    /// Triangles of the mesh.
    pub fn elements(&self) -> usize {
        self.mesh.triangles().len()
    }

    /// Quadrature points.
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// K: ∫ ∇ψ_j·∇ψ_i.
    pub fn stiffness(&self) -> &SparseMatrix {
        &self.stiffness
    }

    /// M: ∫ ψ_j ψ_i by the space's rule.
    pub fn mass(&self) -> &MassForm {
        &self.mass
    }

    /// ∫ ψ_i, the diagonal of the lumped mass matrix whatever the rule.
    pub fn nodal_weights(&self) -> &[f64] {
        &self.nodal_weights
    }

    /// A mass form of the space's kind, zero.
    pub fn new_form(&self) -> MassForm {
        match self.rule {
            Rule::Lumped => MassForm::nodal(self.nodes()),
            Rule::Consistent => MassForm::sparse(self.assembly.pattern.clone()),
        }
    }

    /// Where the quadrature points are.
    pub fn point_positions(&self) -> Vec<[f64; 2]> {
        let component = |axis: usize| {
            let nodal: Vec<f64> = self.mesh.nodes().iter().map(|node| node[axis]).collect();
            let mut points = vec![0.0; self.points()];
            self.interpolate(&nodal, &mut points);
            points
        };
        component(0)
            .into_iter()
            .zip(component(1))
            .map(|(x, y)| [x, y])
            .collect()
    }

    /// The values of a P1 function at the points.
    pub fn interpolate(&self, nodal: &[f64], points: &mut [f64]) {
        match self.rule {
            Rule::Lumped => points.copy_from_slice(nodal),
            Rule::Consistent => {
                let (chunks, _) = points.as_chunks_mut::<POINTS>();
                for (values, triangle) in chunks.iter_mut().zip(self.mesh.triangles()) {
                    let [a, b, c] = triangle.map(|node| nodal[node as usize]);
                    for (value, [la, lb, lc]) in values.iter_mut().zip(&self.coordinates) {
                        *value = la * a + lb * b + lc * c;
                    }
                }
            }
        }
    }

    /// The gradient of a P1 function on each triangle.
    pub fn gradient(&self, nodal: &[f64], gradients: &mut [[f64; 2]]) {
        let elements = self.mesh.triangles().iter().zip(self.mesh.gradients());
        for (gradient, (triangle, basis)) in gradients.iter_mut().zip(elements) {
            let [a, b, c] = triangle.map(|node| nodal[node as usize]);
            *gradient = [
                a * basis[0][0] + b * basis[1][0] + c * basis[2][0],
                a * basis[0][1] + b * basis[1][1] + c * basis[2][1],
            ];
        }
    }

    /// ∫ f for a density at the points.
    pub fn integrate(&self, density: &[f64]) -> f64 {
        vector::dot(&self.weights, density)
    }

    /// ∫ f for a density on the triangles.
    pub fn integrate_elements(&self, density: &[f64]) -> f64 {
        vector::dot(self.mesh.areas(), density)
    }

    /// ∫ u for a P1 function.
    pub fn integrate_nodal(&self, nodal: &[f64]) -> f64 {
        vector::dot(&self.nodal_weights, nodal)
    }

    /// load_i ← load_i + ∫ f ψ_i for a density at the points.
    pub fn add_load(&self, density: &[f64], load: &mut [f64]) {
        match self.rule {
            Rule::Lumped => {
                for ((load, weight), f) in load.iter_mut().zip(&self.weights).zip(density) {
                    *load += weight * f;
                }
            }
            Rule::Consistent => {
                let (chunks, _) = density.as_chunks::<POINTS>();
                let elements = self.mesh.triangles().iter().zip(self.mesh.areas());
                for (values, (triangle, area)) in chunks.iter().zip(elements) {
                    let mut entries = [0.0; 3];
                    for (point, value) in values.iter().enumerate() {
                        let weighted = self.relative_weights[point] * value;
                        for (entry, coordinate) in entries.iter_mut().zip(&self.coordinates[point])
                        {
                            *entry += weighted * coordinate;
                        }
                    }
                    for (&node, entry) in triangle.iter().zip(entries) {
                        load[node as usize] += area * entry;
                    }
                }
            }
        }
    }

    /// load_i ← load_i + ∫ q·∇ψ_i for a flux q on the triangles.
    pub fn add_flux(&self, fluxes: &[[f64; 2]], load: &mut [f64]) {
        let mesh = &self.mesh;
        let elements = mesh
            .triangles()
            .iter()
            .zip(mesh.gradients())
            .zip(mesh.areas());
        for ([x, y], ((triangle, basis), area)) in fluxes.iter().zip(elements) {
            let flux = [area * x, area * y];
            for (&node, gradient) in triangle.iter().zip(basis) {
                load[node as usize] += flux[0] * gradient[0] + flux[1] * gradient[1];
            }
        }
    }

    /// form ← ∫ c ψ_j ψ_i for a coefficient at the points.
    pub fn assemble_mass(&self, coefficient: &[f64], form: &mut MassForm) {
        match form {
            MassForm::Nodal(diagonal) => {
                for ((d, weight), c) in diagonal.iter_mut().zip(&self.weights).zip(coefficient) {
                    *d = weight * c;
                }
            }
            MassForm::Sparse(matrix) => {
                let (chunks, _) = coefficient.as_chunks::<POINTS>();
                let areas = self.mesh.areas();
                // λ_a λ_b w of each point, for the six different entries of an element matrix.
                let mut products = [[0.0; 6]; POINTS];
                for (point, product) in products.iter_mut().enumerate() {
                    let ([a, b, c], w) = (self.coordinates[point], self.relative_weights[point]);
                    *product = [a * a, a * b, a * c, b * b, b * c, c * c].map(|entry| w * entry);
                }
                matrix.values.fill(0.0);
                self.assembly.add(&mut matrix.values, |triangle| {
                    let mut entries = [0.0; 6];
                    for (value, product) in chunks[triangle].iter().zip(&products) {
                        for (entry, product) in entries.iter_mut().zip(product) {
                            *entry += value * product;
                        }
                    }
                    let [aa, ab, ac, bb, bc, cc] = entries.map(|entry| entry * areas[triangle]);
                    [[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]]
                });
            }
        }
    }

    /// The mean over each triangle, by the rule, of a function at the points.
    pub fn element_means(&self, points: &[f64], means: &mut [f64]) {
        match self.rule {
            Rule::Lumped => {
                for (mean, triangle) in means.iter_mut().zip(self.mesh.triangles()) {
                    let [a, b, c] = triangle.map(|node| points[node as usize]);
                    *mean = (a + b + c) / 3.0;
                }
            }
            Rule::Consistent => {
                let (chunks, _) = points.as_chunks::<POINTS>();
                for (mean, values) in means.iter_mut().zip(chunks) {
                    *mean = values
                        .iter()
                        .zip(&self.relative_weights)
                        .map(|(v, w)| v * w)
                        .sum();
                }
            }
        }
    }

    /// A function on the triangles, brought to the points so that its product with any function at
    /// the points has the same integral as triangle by triangle: a copy with the consistent rule; a
    /// mean over the triangles that meet in a node, weighted by their areas, with the lumped one.
    pub fn from_elements(&self, elements: &[f64], points: &mut [f64]) {
        match self.rule {
            Rule::Lumped => {
                points.fill(0.0);
                let weighted = elements.iter().zip(self.mesh.areas());
                for (triangle, (value, area)) in self.mesh.triangles().iter().zip(weighted) {
                    let share = value * area / 3.0;
                    for &node in triangle {
                        points[node as usize] += share;
                    }
                }
                for (point, weight) in points.iter_mut().zip(&self.nodal_weights) {
                    *point /= weight;
                }
            }
            Rule::Consistent => {
                let (chunks, _) = points.as_chunks_mut::<POINTS>();
                for (values, element) in chunks.iter_mut().zip(elements) {
                    values.fill(*element);
                }
            }
        }
    }

    /// ½ ∫ (T g)·g for a tensor and a gradient on each triangle.
    pub fn tensor_energy(&self, tensors: &[SymmetricTensor], gradients: &[[f64; 2]]) -> f64 {
        let elements = tensors.iter().zip(gradients).zip(self.mesh.areas());
        let total: f64 = elements
            .map(|(([xx, xy, yy], [x, y]), area)| {
                area * (xx * x * x + 2.0 * xy * x * y + yy * y * y)
            })
            .sum();
        0.5 * total
    }
}
