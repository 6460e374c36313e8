//! The P1 space on a mesh with one quadrature rule for every integral.
//!
//! Effects work *pointwise*: on arrays with a value at each quadrature point, and on arrays with a
//! value on each triangle (gradients of P1 functions), one [`Patch`] of the space at a time. With the
//! consistent rule there are
//! seven points a triangle; with the lumped rule the points *are* the nodes, since all the vertices
//! that meet in a node have the same nodal values: 14 times fewer points, the same code.
//!
//! The points of the consistent rule are stored in groups of eight triangles: the first points of
//! all eight, then the second ones, and so on, so that a loop over a group works on whole vector
//! registers. A last group that is not full has points of weight zero.
//!
//! What an integral weighs is the space's alone: dx dy, or 2πr dr dz on a mesh of that geometry ([`Rotation`]). Effects and
//! schemes do not know which.

use std::sync::Arc;

use super::assembly::{LoadEntries, MatrixEntries};
use super::quadrature::{POINTS, seven_points};
use super::rotation::{Rotation, shares};
use super::{Assembly, FemError, MassForm, Mesh, Patch, QuadratureRule};
use crate::geometry::{Point, SymmetricTensor, Vector};
use crate::linalg::{SparseMatrix, op_counts, vector};
use crate::scene::Geometry;

/// Triangles of a group of points: one 512-bit register of f64.
pub(super) const LANES: usize = 8;

/// Points of a group.
pub(super) const GROUP: usize = POINTS * LANES;

/// A value for each triangle of a group.
pub(super) type Lane = [f64; LANES];

/// Groups of a patch: an array with a value at each point is 14 kB then, and the two dozen that a
/// step works with stay in a cache of half a megabyte.
const PATCH: usize = 32;

/// A P1 space with its quadrature.
#[derive(Debug)]
pub struct Space {
    mesh: Arc<Mesh>,
    assembly: Assembly,
    rule: QuadratureRule,
    pub(super) coordinates: [[f64; 3]; POINTS],
    pub(super) relative_weights: [f64; POINTS],
    /// λ_a λ_b w of each of the seven points, for the six different entries of an element matrix.
    pub(super) products: [[f64; 6]; POINTS],
    /// The weight of each quadrature point.
    pub(super) weights: Vec<f64>,
    /// For each group of triangles, the x and y components of ∇ψ of the first corners and of the
    /// second ones (the third is minus their sum).
    pub(super) slopes: Vec<[Lane; 4]>,
    stiffness: SparseMatrix,
    mass: MassForm,
    /// ∫ ψ_i: the diagonal of the lumped mass matrix.
    nodal_weights: Vec<f64>,
    /// Of a part: the number of each point in the whole.
    pub(super) numbers: Option<Vec<u32>>,
    /// The measure by rotation; `None` in the plane.
    pub(super) rotation: Option<Rotation>,
}

impl Space {
    /// The space on a mesh.
    pub fn new(mesh: Arc<Mesh>, rule: QuadratureRule) -> Self {
        let assembly = Assembly::new(&mesh);
        let (coordinates, relative_weights) = seven_points();
        let rotation = match mesh.geometry() {
            Geometry::Planar => None,
            Geometry::Axisymmetric => Some(Rotation::new(&mesh)),
        };
        let ratios = |triangle: usize| rotation.as_ref().map(|it| it.ratios(triangle));
        let mut nodal_weights = vec![0.0; mesh.nodes().len()];
        let elements = mesh.triangles().iter().zip(mesh.measures());
        for (number, (triangle, measure)) in elements.enumerate() {
            for (&node, share) in triangle.iter().zip(shares(*measure, ratios(number))) {
                nodal_weights[node as usize] += share;
            }
        }
        let weights = match rule {
            QuadratureRule::Lumped => nodal_weights.clone(),
            QuadratureRule::Consistent => {
                let mut weights = vec![0.0; mesh.areas().len().div_ceil(LANES) * GROUP];
                for (triangle, measure) in mesh.measures().iter().enumerate() {
                    let group = triangle / LANES;
                    let of_points = rotation.as_ref();
                    let of_points = of_points.map(|it| it.point_ratios(group, &coordinates));
                    for (point, weight) in relative_weights.iter().enumerate() {
                        let ratio = of_points.map_or(1.0, |it| it[point][triangle % LANES]);
                        weights[Self::index(triangle, point)] = weight * measure * ratio;
                    }
                }
                weights
            }
        };
        let mut products = [[0.0; 6]; POINTS];
        for (point, product) in products.iter_mut().enumerate() {
            let ([a, b, c], w) = (coordinates[point], relative_weights[point]);
            *product = [a * a, a * b, a * c, b * b, b * c, c * c].map(|entry| w * entry);
        }
        let mut slopes = vec![[[0.0; LANES]; 4]; mesh.triangles().len().div_ceil(LANES)];
        for (triangle, [a, b, _]) in mesh.gradients().iter().enumerate() {
            let group = &mut slopes[triangle / LANES];
            for (slope, entry) in group.iter_mut().zip([a.x, a.y, b.x, b.y]) {
                slope[triangle % LANES] = entry;
            }
        }
        let stiffness = SparseMatrix::zeros(assembly.pattern.clone());
        let mass = match rule {
            QuadratureRule::Lumped => MassForm::Nodal(nodal_weights.clone()),
            QuadratureRule::Consistent => MassForm::sparse(assembly.pattern.clone()),
        };
        let mut space = Self {
            mesh,
            assembly,
            rule,
            coordinates,
            relative_weights,
            products,
            weights,
            slopes,
            stiffness,
            mass,
            nodal_weights,
            numbers: None,
            rotation,
        };
        let (nothing, one) = (vec![0.0; space.points()], vec![1.0; space.points()]);
        let identity = vec![SymmetricTensor::isotropic(1.0); space.elements()];
        let mut stiffness = space.stiffness.clone();
        space.add_mass_and_stiffness(&nothing, &identity, &mut stiffness.values);
        space.stiffness = stiffness;
        if let MassForm::Sparse(mass) = &space.mass {
            let mut mass = mass.clone();
            let nothing = vec![SymmetricTensor::default(); space.elements()];
            space.add_mass_and_stiffness(&one, &nothing, &mut mass.values);
            space.mass = MassForm::Sparse(mass);
        }
        space
    }

    /// The space on a part of the mesh, the given triangles in the order of their numbers; with the
    /// number of each of its nodes in the whole.
    ///
    /// # Errors
    /// None where the mesh itself could be made.
    pub fn part(&self, triangles: &[u32]) -> Result<(Self, Vec<u32>), FemError> {
        let (mesh, nodes) = self.mesh.part(triangles)?;
        let mut part = Self::new(Arc::new(mesh), self.rule);
        part.numbers = Some(match self.rule {
            QuadratureRule::Lumped => nodes.clone(),
            QuadratureRule::Consistent => {
                let mut numbers = vec![0; part.points()];
                for (local, &triangle) in triangles.iter().enumerate() {
                    for point in 0..POINTS {
                        let number = Self::index(triangle as usize, point);
                        numbers[Self::index(local, point)] = number as u32;
                    }
                }
                numbers
            }
        });
        Ok((part, nodes))
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
    pub fn rule(&self) -> QuadratureRule {
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

    /// Where (M u, u) lies between this times (M_L u, u) and (M_L u, u), with M by the consistent rule and M_L the lumped
    /// matrix: 1/4 in the plane, for the element matrices have the eigenvalues 1, 1/4 and 1/4, and 1/5 by rotation, for with
    /// the weight λ_k, of which r is made, they are 1, 1/5 and 1/5 (as those of a tetrahedron).
    pub fn least_mass_eigenvalue(&self) -> f64 {
        match self.rotation {
            None => 0.25,
            Some(_) => 0.2,
        }
    }

    /// A bound of the eigenvalues of M_L⁻¹ K, where K has the form of ∫ ∇d:∇e for the component d_r: by rotation with the part
    /// along the circle. On a triangle that is at most 4/(3r̄²) times the lumped mass.
    pub fn largest_eigenvalue(&self) -> f64 {
        let in_plane = self.stiffness.eigenvalue_bound(&self.nodal_weights);
        let Some(rotation) = &self.rotation else {
            return in_plane;
        };
        let inverse = rotation.inverse_radii.iter().copied().fold(0.0, f64::max);
        in_plane + 4.0 / 3.0 * inverse * inverse
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
            QuadratureRule::Lumped => MassForm::nodal(self.nodes()),
            QuadratureRule::Consistent => MassForm::sparse(self.assembly.pattern.clone()),
        }
    }

    /// Where the consistent rule's point of a triangle is stored.
    fn index(triangle: usize, point: usize) -> usize {
        triangle / LANES * GROUP + point * LANES + triangle % LANES
    }

    /// Triangles of a piece. With the lumped rule there is one, for its points are the nodes and each has triangles
    /// everywhere about it.
    fn piece(&self) -> usize {
        let all = self.elements().max(1);
        match self.rule {
            QuadratureRule::Lumped => all,
            QuadratureRule::Consistent => all.min(PATCH * LANES),
        }
    }

    /// How many pieces there are.
    pub fn pieces(&self) -> usize {
        self.elements().div_ceil(self.piece())
    }

    /// Groups of triangles of a piece, but for the last one, which may have fewer.
    pub fn groups_of_piece(&self) -> usize {
        self.piece().div_ceil(LANES)
    }

    /// Groups of triangles in all.
    pub fn groups(&self) -> usize {
        self.slopes.len()
    }

    /// One of the pieces, in their order.
    pub fn nth_patch(&self, number: usize) -> Patch<'_> {
        self.patch(number * self.piece(), self.piece())
    }

    /// The pieces of the space, in order.
    pub fn patches(&self) -> impl Iterator<Item = Patch<'_>> {
        (0..self.pieces()).map(|number| self.nth_patch(number))
    }

    /// The whole space as one piece.
    pub fn whole(&self) -> Patch<'_> {
        self.patch(0, self.elements())
    }

    fn patch(&self, first: usize, elements: usize) -> Patch<'_> {
        let end = (first + elements).min(self.elements());
        let points = match self.rule {
            QuadratureRule::Lumped => 0..self.points(),
            QuadratureRule::Consistent => first / LANES * GROUP..end.div_ceil(LANES) * GROUP,
        };
        Patch::new(self, first..end, points)
    }

    /// Where the quadrature points are (those of weight zero that fill the last group: at the place of
    /// the last triangle's).
    pub fn point_positions(&self) -> Vec<Point> {
        let (nodes, triangles) = (self.mesh.nodes(), self.mesh.triangles());
        if self.rule == QuadratureRule::Lumped {
            return nodes.to_vec();
        }
        let place = |index: usize| {
            let triangle = index / GROUP * LANES + index % LANES;
            let corners = triangles[triangle.min(triangles.len() - 1)];
            let weights = self.coordinates[index % GROUP / LANES];
            let corners = corners.iter().zip(weights);
            let parts = corners.map(|(&node, weight)| weight * nodes[node as usize].coords);
            Point::from(parts.sum::<Vector>())
        };
        (0..self.points()).map(place).collect()
    }

    /// The values at the points of a function of the place.
    pub fn sample(&self, f: impl Fn(Point) -> f64) -> Vec<f64> {
        self.point_positions().into_iter().map(f).collect()
    }

    /// load ← load + the entries of all triangles, and with the lumped rule ∫ f ψ_i for a density f at the nodes.
    pub fn collect_load(&self, entries: &[LoadEntries], density: &[f64], load: &mut [f64]) {
        if self.rule == QuadratureRule::Lumped {
            for ((load, weight), f) in load.iter_mut().zip(&self.weights).zip(density) {
                *load += weight * f;
            }
        }
        self.assembly.collect_load(entries, load);
    }

    /// values ← values + ∫ c ψ_j ψ_i for a coefficient c at the nodes, with the lumped rule; with the consistent one nothing,
    /// for there it is in the entries of the triangles.
    pub fn add_diagonal(&self, coefficient: &[f64], values: &mut [f64]) {
        if self.rule == QuadratureRule::Lumped {
            let nodes = self.assembly.diagonal.iter().zip(&self.weights);
            for ((&position, weight), c) in nodes.zip(coefficient) {
                values[position as usize] += weight * c;
            }
        }
    }

    /// load_i ← load_i + ∫ f ψ_i + ∫ q·∇ψ_i for a density f at the points and a flux q on the triangles. Allocates: for what is
    /// computed once.
    pub fn add_load(&self, density: &[f64], fluxes: &[Vector], load: &mut [f64]) {
        let mut entries = vec![LoadEntries::default(); self.groups()];
        self.whole().load_entries(density, fluxes, &mut entries);
        self.collect_load(&entries, density, load);
    }

    /// matrix ← matrix + ∫ c ψ_j ψ_i + ∫ (T ∇ψ_j)·∇ψ_i for a coefficient c at the points and a tensor T on the triangles;
    /// `values` are stored in the pattern of the mesh. Allocates: for what is computed once.
    pub fn add_mass_and_stiffness(
        &self,
        coefficient: &[f64],
        tensors: &[SymmetricTensor],
        values: &mut [f64],
    ) {
        let mut entries = vec![MatrixEntries::default(); self.groups()];
        let whole = self.whole();
        whole.mass_and_stiffness_entries(coefficient, tensors, &mut entries);
        op_counts::assemblies(1);
        self.add_diagonal(coefficient, values);
        self.assembly.collect_matrices([&entries], [values]);
    }

    /// ∫ u for a P1 function.
    pub fn integrate_nodal(&self, nodal: &[f64]) -> f64 {
        vector::dot(&self.nodal_weights, nodal)
    }
}
