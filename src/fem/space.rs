//! The P1 space on a mesh with one quadrature rule for every integral.
//!
//! Effects work *pointwise*: on arrays with a value at each quadrature point, and on arrays with a
//! value on each triangle (gradients of P1 functions). The space takes nodal fields to the points
//! and brings densities back into loads, forms and numbers. With the consistent rule there are
//! seven points a triangle; with the lumped rule the points *are* the nodes, since all the vertices
//! that meet in a node have the same nodal values: 14 times fewer points, the same code.
//!
//! The points of the consistent rule are stored in groups of eight triangles: the first points of
//! all eight, then the second ones, and so on, so that a loop over a group works on whole vector
//! registers. A last group that is not full has points of weight zero.

use std::sync::Arc;

use super::rule::{POINTS, seven_points};
use super::{Assembly, MassForm, Mesh, Rule, SymmetricTensor};
use crate::linalg::SparseMatrix;
use crate::linalg::vector;

/// Triangles of a group of points: one 512-bit register of f64.
const LANES: usize = 8;

/// Points of a group.
const GROUP: usize = POINTS * LANES;

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
            Rule::Consistent => {
                let mut weights = vec![0.0; mesh.areas().len().div_ceil(LANES) * GROUP];
                for (triangle, area) in mesh.areas().iter().enumerate() {
                    for (point, weight) in relative_weights.iter().enumerate() {
                        weights[Self::index(triangle, point)] = weight * area;
                    }
                }
                weights
            }
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

    /// Where the consistent rule's point of a triangle is stored.
    fn index(triangle: usize, point: usize) -> usize {
        triangle / LANES * GROUP + point * LANES + triangle % LANES
    }

    /// The nodal values at the corners of a group's triangles: corner by corner.
    #[inline(always)]
    fn corners(nodal: &[f64], triangles: &[[u32; 3]]) -> [[f64; LANES]; 3] {
        let mut corners = [[0.0; LANES]; 3];
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, &node) in corners.iter_mut().zip(triangle) {
                corner[lane] = nodal[node as usize];
            }
        }
        corners
    }

    /// The triangles and their areas, in groups.
    #[inline(always)]
    fn groups(&self) -> impl Iterator<Item = (&[[u32; 3]], &[f64])> {
        self.mesh
            .triangles()
            .chunks(LANES)
            .zip(self.mesh.areas().chunks(LANES))
    }

    /// Where the quadrature points are (those of weight zero that fill the last group: at the place of
    /// the last triangle's).
    pub fn point_positions(&self) -> Vec<[f64; 2]> {
        let (nodes, triangles) = (self.mesh.nodes(), self.mesh.triangles());
        if self.rule == Rule::Lumped {
            return nodes.to_vec();
        }
        let place = |index: usize| {
            let triangle = index / GROUP * LANES + index % LANES;
            let corners = triangles[triangle.min(triangles.len() - 1)];
            let weights = self.coordinates[index % GROUP / LANES];
            [0, 1].map(|axis| {
                let corners = corners.iter().zip(weights);
                corners
                    .map(|(&node, weight)| weight * nodes[node as usize][axis])
                    .sum()
            })
        };
        (0..self.points()).map(place).collect()
    }

    /// The values at the points of a function of the place.
    pub fn sample(&self, f: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        self.point_positions().into_iter().map(f).collect()
    }

    /// The values of a P1 function at the points.
    pub fn interpolate(&self, nodal: &[f64], points: &mut [f64]) {
        if self.rule == Rule::Lumped {
            points.copy_from_slice(nodal);
            return;
        }
        let groups = points
            .as_chunks_mut::<GROUP>()
            .0
            .iter_mut()
            .zip(self.groups());
        for (group, (triangles, _)) in groups {
            let [a, b, c] = Self::corners(nodal, triangles);
            let rows = group
                .as_chunks_mut::<LANES>()
                .0
                .iter_mut()
                .zip(&self.coordinates);
            for (row, [la, lb, lc]) in rows {
                for lane in 0..LANES {
                    row[lane] = la * a[lane] + lb * b[lane] + lc * c[lane];
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

    /// ∫ f(u) for a function u at the points.
    pub fn integrate_of(&self, u: &[f64], f: impl Fn(f64) -> f64) -> f64 {
        vector::weighted_sum(&self.weights, u, f)
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
        if self.rule == Rule::Lumped {
            for ((load, weight), f) in load.iter_mut().zip(&self.weights).zip(density) {
                *load += weight * f;
            }
            return;
        }
        let groups = density.as_chunks::<GROUP>().0.iter().zip(self.groups());
        for (group, (triangles, areas)) in groups {
            let mut entries = [[0.0; LANES]; 3];
            for (point, row) in group.as_chunks::<LANES>().0.iter().enumerate() {
                let weight = self.relative_weights[point];
                for (entry, coordinate) in entries.iter_mut().zip(&self.coordinates[point]) {
                    for lane in 0..LANES {
                        entry[lane] += weight * coordinate * row[lane];
                    }
                }
            }
            for (lane, (triangle, area)) in triangles.iter().zip(areas).enumerate() {
                for (&node, entry) in triangle.iter().zip(&entries) {
                    load[node as usize] += area * entry[lane];
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
        let matrix = match form {
            MassForm::Nodal(diagonal) => {
                for ((d, weight), c) in diagonal.iter_mut().zip(&self.weights).zip(coefficient) {
                    *d = weight * c;
                }
                return;
            }
            MassForm::Sparse(matrix) => matrix,
        };
        // λ_a λ_b w of each point, for the six different entries of an element matrix.
        let mut products = [[0.0; 6]; POINTS];
        for (point, product) in products.iter_mut().enumerate() {
            let ([a, b, c], w) = (self.coordinates[point], self.relative_weights[point]);
            *product = [a * a, a * b, a * c, b * b, b * c, c * c].map(|entry| w * entry);
        }
        matrix.values.fill(0.0);
        let groups = coefficient.as_chunks::<GROUP>().0.iter().zip(self.groups());
        for (number, (group, (_, areas))) in groups.enumerate() {
            let mut entries = [[0.0; LANES]; 6];
            for (row, product) in group.as_chunks::<LANES>().0.iter().zip(&products) {
                for (entry, product) in entries.iter_mut().zip(product) {
                    for lane in 0..LANES {
                        entry[lane] += row[lane] * product;
                    }
                }
            }
            for (lane, area) in areas.iter().enumerate() {
                let [aa, ab, ac, bb, bc, cc] = entries.map(|entry| entry[lane] * area);
                let element = [[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]];
                let triangle = number * LANES + lane;
                self.assembly
                    .add_element(&mut matrix.values, triangle, &element);
            }
        }
    }

    /// The mean over each triangle, by the rule, of a function at the points.
    pub fn element_means(&self, points: &[f64], means: &mut [f64]) {
        if self.rule == Rule::Lumped {
            for (mean, triangle) in means.iter_mut().zip(self.mesh.triangles()) {
                let [a, b, c] = triangle.map(|node| points[node as usize]);
                *mean = (a + b + c) / 3.0;
            }
            return;
        }
        let groups = points.as_chunks::<GROUP>().0.iter();
        for (means, group) in means.chunks_mut(LANES).zip(groups) {
            let mut sums = [0.0; LANES];
            let rows = group
                .as_chunks::<LANES>()
                .0
                .iter()
                .zip(&self.relative_weights);
            for (row, weight) in rows {
                for lane in 0..LANES {
                    sums[lane] += weight * row[lane];
                }
            }
            means.copy_from_slice(&sums[..means.len()]);
        }
    }

    /// A function on the triangles, brought to the points so that its product with any function at
    /// the points has the same integral as triangle by triangle: a copy with the consistent rule; a
    /// mean over the triangles that meet in a node, weighted by their areas, with the lumped one.
    pub fn from_elements(&self, elements: &[f64], points: &mut [f64]) {
        if self.rule == Rule::Consistent {
            let groups = points.as_chunks_mut::<GROUP>().0.iter_mut();
            for (group, elements) in groups.zip(elements.chunks(LANES)) {
                for row in group.as_chunks_mut::<LANES>().0 {
                    row[..elements.len()].copy_from_slice(elements);
                }
            }
            return;
        }
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

    /// The mean over each triangle, by the rule, of v⊗v for a P1 vector field v. The consistent rule
    /// is exact for it and the lumped one takes the mean of the corners, so no points are needed.
    pub fn mean_squares(&self, [x, y]: [&[f64]; 2], means: &mut [SymmetricTensor]) {
        let mean = |u: [f64; 3], v: [f64; 3]| {
            let corners = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
            match self.rule {
                Rule::Lumped => corners / 3.0,
                Rule::Consistent => ((u[0] + u[1] + u[2]) * (v[0] + v[1] + v[2]) + corners) / 12.0,
            }
        };
        for (means, triangle) in means.iter_mut().zip(self.mesh.triangles()) {
            let x = triangle.map(|node| x[node as usize]);
            let y = triangle.map(|node| y[node as usize]);
            *means = [mean(x, x), mean(x, y), mean(y, y)];
        }
    }

    /// load_i ← load_i + ∫ c u ψ_i for a coefficient on the triangles and a P1 function u.
    pub fn add_element_product(&self, coefficient: &[f64], u: &[f64], load: &mut [f64]) {
        let elements = self.mesh.triangles().iter().zip(self.mesh.areas());
        for (c, (triangle, area)) in coefficient.iter().zip(elements) {
            let values = triangle.map(|node| u[node as usize]);
            let sum = values[0] + values[1] + values[2];
            for (&node, value) in triangle.iter().zip(values) {
                load[node as usize] += match self.rule {
                    Rule::Lumped => c * area / 3.0 * value,
                    Rule::Consistent => c * area / 12.0 * (sum + value),
                };
            }
        }
    }

    /// form ← form + ∫ c ψ_j ψ_i for a coefficient on the triangles.
    pub fn add_element_mass(&self, coefficient: &[f64], form: &mut MassForm) {
        let weighted = coefficient
            .iter()
            .zip(self.mesh.areas())
            .map(|(c, area)| c * area);
        match form {
            MassForm::Nodal(diagonal) => {
                for (triangle, weight) in self.mesh.triangles().iter().zip(weighted) {
                    for &node in triangle {
                        diagonal[node as usize] += weight / 3.0;
                    }
                }
            }
            MassForm::Sparse(matrix) => {
                for (triangle, weight) in weighted.enumerate() {
                    let (same, other) = (weight / 6.0, weight / 12.0);
                    let element = [
                        [same, other, other],
                        [other, same, other],
                        [other, other, same],
                    ];
                    self.assembly
                        .add_element(&mut matrix.values, triangle, &element);
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
