//! A piece of a P1 space: consecutive triangles with their quadrature points, few enough for what is
//! computed on them to stay in the cache.
//!
//! Everything that an integral over the domain needs is done piece by piece: nodal fields are taken
//! to the points and gradients to the triangles, effects work on both, and densities are brought back
//! into loads, matrices and numbers.

use std::ops::Range;

use super::space::{GROUP, LANES, Lane};
use super::{MassForm, QuadratureRule, Space};
use crate::geometry::{SymmetricTensor, Vector};
use crate::linalg::{op_counts, vector};

/// The six different entries aa, ab, ac, bb, bc, cc of the element matrices of a group of triangles.
type Entries = [Lane; 6];

/// A piece of a space.
#[derive(Debug, Clone, Copy)]
pub struct Patch<'a> {
    space: &'a Space,
    elements: [usize; 2],
    points: [usize; 2],
}

impl<'a> Patch<'a> {
    /// The triangles and the points of the given ranges, which belong together.
    pub(super) fn new(space: &'a Space, elements: Range<usize>, points: Range<usize>) -> Self {
        Self {
            space,
            elements: [elements.start, elements.end],
            points: [points.start, points.end],
        }
    }

    /// The space.
    pub fn space(&self) -> &'a Space {
        self.space
    }

    /// Which of the space's triangles.
    pub fn element_range(&self) -> Range<usize> {
        self.elements[0]..self.elements[1]
    }

    /// Which of the space's quadrature points.
    pub fn point_range(&self) -> Range<usize> {
        self.points[0]..self.points[1]
    }

    /// Triangles.
    pub fn elements(&self) -> usize {
        self.elements[1] - self.elements[0]
    }

    /// Quadrature points.
    pub fn points(&self) -> usize {
        self.points[1] - self.points[0]
    }

    /// The number of each of its points in the whole space, of which this space may be a part.
    pub fn point_numbers(&self, numbers: &mut Vec<u32>) {
        numbers.clear();
        match &self.space.numbers {
            Some(of_part) => numbers.extend_from_slice(&of_part[self.point_range()]),
            None => numbers.extend(self.point_range().map(|point| point as u32)),
        }
    }

    /// Whether it is the first one of its space.
    pub fn is_first(&self) -> bool {
        self.elements[0] == 0
    }

    fn triangles(&self) -> &'a [[u32; 3]] {
        &self.space.mesh().triangles()[self.element_range()]
    }

    fn areas(&self) -> &'a [f64] {
        &self.space.mesh().areas()[self.element_range()]
    }

    /// The weights of its quadrature points.
    pub fn weights(&self) -> &'a [f64] {
        &self.space.weights[self.point_range()]
    }

    /// The triangles in groups: their corners, their areas, the gradients of their first two basis
    /// functions (the third one's is minus the sum).
    #[inline(always)]
    fn groups(&self) -> impl Iterator<Item = (&'a [[u32; 3]], &'a [f64], &'a [Lane; 4])> {
        let first = self.elements[0] / LANES;
        self.triangles()
            .chunks(LANES)
            .zip(self.areas().chunks(LANES))
            .zip(&self.space.slopes[first..])
            .map(|((triangles, areas), slopes)| (triangles, areas, slopes))
    }

    /// A P1 function at the points and its gradient on the triangles.
    pub fn sample(&self, nodal: &[f64], points: &mut [f64], gradients: &mut [Vector]) {
        let groups = self.groups().zip(gradients.chunks_mut(LANES));
        if self.space.rule() == QuadratureRule::Lumped {
            points.copy_from_slice(nodal);
            for ((triangles, _, slopes), gradients) in groups {
                store_gradients(&corners(nodal, triangles), slopes, gradients);
            }
            return;
        }
        let points = points.as_chunks_mut::<GROUP>().0;
        for (((triangles, _, slopes), gradients), points) in groups.zip(points) {
            let corners = corners(nodal, triangles);
            store_gradients(&corners, slopes, gradients);
            self.store_points(&corners, points);
        }
    }

    /// The values of a P1 function at the points.
    pub fn interpolate(&self, nodal: &[f64], points: &mut [f64]) {
        if self.space.rule() == QuadratureRule::Lumped {
            points.copy_from_slice(nodal);
            return;
        }
        let points = points.as_chunks_mut::<GROUP>().0;
        for ((triangles, ..), points) in self.groups().zip(points) {
            self.store_points(&corners(nodal, triangles), points);
        }
    }

    /// The values at the points of a group from those at the corners.
    #[inline(always)]
    fn store_points(&self, [a, b, c]: &[Lane; 3], points: &mut [f64; GROUP]) {
        let rows = points.as_chunks_mut::<LANES>().0.iter_mut();
        for (row, [la, lb, lc]) in rows.zip(&self.space.coordinates) {
            for lane in 0..LANES {
                row[lane] = la * a[lane] + lb * b[lane] + lc * c[lane];
            }
        }
    }

    /// ∫ f over the patch for a density at the points.
    pub fn integrate(&self, density: &[f64]) -> f64 {
        vector::dot(self.weights(), density)
    }

    /// ∫ f(u) for a function u at the points.
    pub fn integrate_of(&self, u: &[f64], f: impl Fn(f64) -> f64) -> f64 {
        vector::weighted_sum(self.weights(), u, f)
    }

    /// ∫ f for a density on the triangles.
    pub fn integrate_elements(&self, density: &[f64]) -> f64 {
        vector::dot(self.areas(), density)
    }

    /// ∫ f for a density that is worked out triangle by triangle.
    pub fn integrate_elements_of(&self, densities: impl IntoIterator<Item = f64>) -> f64 {
        let elements = self.areas().iter().zip(densities);
        elements.map(|(area, density)| area * density).sum()
    }

    /// load_i ← load_i + ∫ f ψ_i + ∫ q·∇ψ_i for a density f at the points and a flux q on the
    /// triangles.
    pub fn add_load(&self, density: &[f64], fluxes: &[Vector], load: &mut [f64]) {
        if self.space.rule() == QuadratureRule::Lumped {
            for ((load, weight), f) in load.iter_mut().zip(self.weights()).zip(density) {
                *load += weight * f;
            }
            for ((triangles, areas, slopes), fluxes) in self.groups().zip(fluxes.chunks(LANES)) {
                let entries = flux_entries(areas, slopes, fluxes);
                scatter(triangles, &entries, load);
            }
            return;
        }
        let density = density.as_chunks::<GROUP>().0;
        let groups = self.groups().zip(fluxes.chunks(LANES)).zip(density);
        for (((triangles, areas, slopes), fluxes), density) in groups {
            let mut entries = [[0.0; LANES]; 3];
            for (point, row) in density.as_chunks::<LANES>().0.iter().enumerate() {
                let weight = self.space.relative_weights[point];
                for (entry, coordinate) in entries.iter_mut().zip(&self.space.coordinates[point]) {
                    for lane in 0..LANES {
                        entry[lane] += weight * coordinate * row[lane];
                    }
                }
            }
            let of_flux = flux_entries(areas, slopes, fluxes);
            let areas = lanes(areas);
            for (entry, of_flux) in entries.iter_mut().zip(&of_flux) {
                for lane in 0..LANES {
                    entry[lane] = areas[lane] * entry[lane] + of_flux[lane];
                }
            }
            scatter(triangles, &entries, load);
        }
    }

    /// matrix ← matrix + ∫ c ψ_j ψ_i for a coefficient at the points; `values` are stored in the
    /// pattern of the mesh.
    pub fn add_mass(&self, coefficient: &[f64], values: &mut [f64]) {
        op_counts::assembly();
        match self.space.rule() {
            QuadratureRule::Lumped => self.add_diagonal(coefficient, values),
            QuadratureRule::Consistent => {
                self.add_elements(coefficient, |_, _| [[0.0; LANES]; 6], values)
            }
        }
    }

    /// matrix ← matrix + ∫ c ψ_j ψ_i + ∫ (T ∇ψ_j)·∇ψ_i for a coefficient c at the points and a
    /// tensor T on the triangles.
    pub fn add_mass_and_stiffness(
        &self,
        coefficient: &[f64],
        tensors: &[SymmetricTensor],
        values: &mut [f64],
    ) {
        op_counts::assembly();
        if self.space.rule() == QuadratureRule::Lumped {
            self.add_diagonal(coefficient, values);
        }
        self.add_elements(
            coefficient,
            |group, (areas, slopes)| {
                let first = group * LANES;
                let mut tensor = [[0.0; LANES]; 3];
                let end = (first + LANES).min(tensors.len());
                for (lane, entries) in tensors[first..end].iter().enumerate() {
                    for (row, entry) in tensor.iter_mut().zip(entries.entries()) {
                        row[lane] = entry;
                    }
                }
                stiffness_entries(areas, slopes, &tensor)
            },
            values,
        );
    }

    /// matrix ← matrix + ∫ c ψ_j ψ_i with the lumped rule.
    fn add_diagonal(&self, coefficient: &[f64], values: &mut [f64]) {
        let nodes = self.space.assembly().diagonal.iter().zip(self.weights());
        for ((&position, weight), c) in nodes.zip(coefficient) {
            values[position as usize] += weight * c;
        }
    }

    /// Adds element matrices: what `of_group(group, (areas, slopes))` gives, and with the consistent
    /// rule ∫ c ψ_j ψ_i.
    #[inline(always)]
    fn add_elements(
        &self,
        coefficient: &[f64],
        of_group: impl Fn(usize, (&Lane, &[Lane; 4])) -> Entries,
        values: &mut [f64],
    ) {
        let assembly = self.space.assembly();
        let lumped = self.space.rule() == QuadratureRule::Lumped;
        for (group, (triangles, areas, slopes)) in self.groups().enumerate() {
            let areas = lanes(areas);
            let mut entries = of_group(group, (&areas, slopes));
            if !lumped {
                self.add_mass_entries(coefficient, group, &areas, &mut entries);
            }
            let first = self.elements[0] + group * LANES;
            for lane in 0..triangles.len() {
                assembly.add_element(values, first + lane, &entries.map(|entry| entry[lane]));
            }
        }
    }

    /// entries ← entries + ∫ c ψ_j ψ_i for a group of triangles.
    #[inline(always)]
    fn add_mass_entries(
        &self,
        coefficient: &[f64],
        group: usize,
        areas: &Lane,
        entries: &mut Entries,
    ) {
        let mut sums = [[0.0; LANES]; 6];
        let rows = coefficient[group * GROUP..].as_chunks::<LANES>().0.iter();
        for (row, products) in rows.zip(&self.space.products) {
            for (sum, product) in sums.iter_mut().zip(products) {
                for lane in 0..LANES {
                    sum[lane] += row[lane] * product;
                }
            }
        }
        for (entry, sum) in entries.iter_mut().zip(&sums) {
            for lane in 0..LANES {
                entry[lane] += areas[lane] * sum[lane];
            }
        }
    }

    /// The matrices of two fields x and y on the same mesh, x and y blocks and what couples them:
    ///
    /// x, y blocks ← blocks + ∫ w ∇ψ_j·∇ψ_i + ∫ c ψ_j ψ_i, and with a tensor R on the triangles also
    /// ∫ R_xx ψ_j ψ_i, ∫ R_yy ψ_j ψ_i;
    /// coupling ← coupling + ∫ R_xy ψ_j ψ_i.
    pub fn add_coupled(
        &self,
        (weight, coefficient): (&[f64], &[f64]),
        tensors: Option<&[SymmetricTensor]>,
        [x_block, y_block]: [&mut [f64]; 2],
        coupling: &mut MassForm,
    ) {
        op_counts::assembly();
        let assembly = self.space.assembly();
        let lumped = self.space.rule() == QuadratureRule::Lumped;
        if lumped {
            self.add_diagonal(coefficient, x_block);
            self.add_diagonal(coefficient, y_block);
        }
        for (group, (triangles, areas, slopes)) in self.groups().enumerate() {
            let areas = lanes(areas);
            let local = group * LANES..group * LANES + triangles.len();
            let weight = lanes(&weight[local.clone()]);
            let mut entries = stiffness_entries(&areas, slopes, &[weight, [0.0; LANES], weight]);
            if !lumped {
                self.add_mass_entries(coefficient, group, &areas, &mut entries);
            }
            for lane in 0..triangles.len() {
                let triangle = self.elements[0] + local.start + lane;
                let [mut x, mut y] = [entries.map(|entry| entry[lane]); 2];
                if let Some(tensors) = tensors {
                    let tensor = areas[lane] * tensors[local.start + lane];
                    let [xx, xy, yy] = tensor.entries();
                    match coupling {
                        MassForm::Sparse(matrix) => {
                            let [of_xx, of_xy, of_yy] = [xx, xy, yy].map(element_mass);
                            x.iter_mut().zip(of_xx).for_each(|(x, entry)| *x += entry);
                            y.iter_mut().zip(of_yy).for_each(|(y, entry)| *y += entry);
                            assembly.add_element(&mut matrix.values, triangle, &of_xy);
                        }
                        MassForm::Nodal(diagonal) => {
                            for corner in [0, 3, 5] {
                                x[corner] += xx / 3.0;
                                y[corner] += yy / 3.0;
                            }
                            for &node in &triangles[lane] {
                                diagonal[node as usize] += xy / 3.0;
                            }
                        }
                    }
                }
                assembly.add_element(x_block, triangle, &x);
                assembly.add_element(y_block, triangle, &y);
            }
        }
    }

    /// The mean over each triangle, by the rule, of a function at the points.
    pub fn element_means(&self, points: &[f64], means: &mut [f64]) {
        if self.space.rule() == QuadratureRule::Lumped {
            for (mean, triangle) in means.iter_mut().zip(self.triangles()) {
                let [a, b, c] = triangle.map(|node| points[node as usize]);
                *mean = (a + b + c) / 3.0;
            }
            return;
        }
        let groups = points.as_chunks::<GROUP>().0.iter();
        for (means, group) in means.chunks_mut(LANES).zip(groups) {
            let mut sums = [0.0; LANES];
            let rows = group.as_chunks::<LANES>().0.iter();
            for (row, weight) in rows.zip(&self.space.relative_weights) {
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
        if self.space.rule() == QuadratureRule::Consistent {
            let groups = points.as_chunks_mut::<GROUP>().0.iter_mut();
            for (group, elements) in groups.zip(elements.chunks(LANES)) {
                let values = lanes(elements);
                group.as_chunks_mut::<LANES>().0.fill(values);
            }
            return;
        }
        points.fill(0.0);
        let weighted = elements.iter().zip(self.areas());
        for (triangle, (value, area)) in self.triangles().iter().zip(weighted) {
            let share = value * area / 3.0;
            for &node in triangle {
                points[node as usize] += share;
            }
        }
        for (point, weight) in points.iter_mut().zip(self.weights()) {
            *point /= weight;
        }
    }

    /// The mean over each triangle, by the rule, of v⊗v for a P1 vector field v given at the nodes.
    /// The consistent rule is exact for it and the lumped one takes the mean of the corners, so no
    /// points are needed.
    pub fn mean_squares(&self, [x, y]: [&[f64]; 2], means: &mut [SymmetricTensor]) {
        let rule = self.space.rule();
        let mean = |u: [f64; 3], v: [f64; 3]| {
            let corners = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
            match rule {
                QuadratureRule::Lumped => corners / 3.0,
                QuadratureRule::Consistent => {
                    ((u[0] + u[1] + u[2]) * (v[0] + v[1] + v[2]) + corners) / 12.0
                }
            }
        };
        for (means, triangle) in means.iter_mut().zip(self.triangles()) {
            let x = triangle.map(|node| x[node as usize]);
            let y = triangle.map(|node| y[node as usize]);
            *means = SymmetricTensor::new(mean(x, x), mean(x, y), mean(y, y));
        }
    }

    /// load_i ← load_i + ∫ c u ψ_i for a coefficient on the triangles and a P1 function u given at
    /// the nodes.
    pub fn add_element_product(
        &self,
        coefficient: impl IntoIterator<Item = f64>,
        u: &[f64],
        load: &mut [f64],
    ) {
        let elements = self.triangles().iter().zip(self.areas());
        for (c, (triangle, area)) in coefficient.into_iter().zip(elements) {
            let values = triangle.map(|node| u[node as usize]);
            let sum = values[0] + values[1] + values[2];
            for (&node, value) in triangle.iter().zip(values) {
                load[node as usize] += match self.space.rule() {
                    QuadratureRule::Lumped => c * area / 3.0 * value,
                    QuadratureRule::Consistent => c * area / 12.0 * (sum + value),
                };
            }
        }
    }

    /// ½ ∫ (T g)·g for a tensor and a gradient on each triangle.
    pub fn tensor_energy(
        &self,
        tensors: &[SymmetricTensor],
        gradients: impl IntoIterator<Item = Vector>,
    ) -> f64 {
        let elements = tensors.iter().zip(gradients);
        0.5 * self.integrate_elements_of(elements.map(|(tensor, g)| tensor.quadratic_form(g)))
    }
}

/// The entries of the mass matrix of a triangle whose area, times a coefficient, is given.
#[inline(always)]
fn element_mass(weighted_area: f64) -> [f64; 6] {
    let (same, other) = (weighted_area / 6.0, weighted_area / 12.0);
    [same, other, other, same, other, same]
}

/// As many as there are, the rest zero.
#[inline(always)]
fn lanes(values: &[f64]) -> Lane {
    match values.first_chunk() {
        Some(full) => *full,
        None => {
            let mut lanes = [0.0; LANES];
            lanes[..values.len()].copy_from_slice(values);
            lanes
        }
    }
}

/// The nodal values at the corners of a group's triangles: corner by corner.
#[inline(always)]
fn corners(nodal: &[f64], triangles: &[[u32; 3]]) -> [Lane; 3] {
    let mut corners = [[0.0; LANES]; 3];
    for (lane, triangle) in triangles.iter().enumerate() {
        for (corner, &node) in corners.iter_mut().zip(triangle) {
            corner[lane] = nodal[node as usize];
        }
    }
    corners
}

/// The gradients on the triangles of a group: (a − c)∇ψ_a + (b − c)∇ψ_b.
#[inline(always)]
fn store_gradients([a, b, c]: &[Lane; 3], [ax, ay, bx, by]: &[Lane; 4], gradients: &mut [Vector]) {
    let mut all = [Vector::zeros(); LANES];
    for lane in 0..LANES {
        let (first, second) = (a[lane] - c[lane], b[lane] - c[lane]);
        all[lane].x = first * ax[lane] + second * bx[lane];
        all[lane].y = first * ay[lane] + second * by[lane];
    }
    match gradients.first_chunk_mut() {
        Some(full) => *full = all,
        None => gradients.copy_from_slice(&all[..gradients.len()]),
    }
}

/// ∫ q·∇ψ for the three corners of a group's triangles.
#[inline(always)]
fn flux_entries(areas: &[f64], [ax, ay, bx, by]: &[Lane; 4], fluxes: &[Vector]) -> [Lane; 3] {
    let mut entries = [[0.0; LANES]; 3];
    let mut all = [Vector::zeros(); LANES];
    match fluxes.first_chunk() {
        Some(full) => all = *full,
        None => all[..fluxes.len()].copy_from_slice(fluxes),
    }
    let areas = lanes(areas);
    for lane in 0..LANES {
        let (x, y) = (areas[lane] * all[lane].x, areas[lane] * all[lane].y);
        let (first, second) = (x * ax[lane] + y * ay[lane], x * bx[lane] + y * by[lane]);
        entries[0][lane] = first;
        entries[1][lane] = second;
        entries[2][lane] = -(first + second);
    }
    entries
}

/// ∫ (T ∇ψ_j)·∇ψ_i for the triangles of a group; T by its entries xx, xy, yy.
#[inline(always)]
fn stiffness_entries(
    areas: &Lane,
    [ax, ay, bx, by]: &[Lane; 4],
    [xx, xy, yy]: &[Lane; 3],
) -> Entries {
    let mut entries = [[0.0; LANES]; 6];
    for lane in 0..LANES {
        let (a_x, a_y, b_x, b_y) = (ax[lane], ay[lane], bx[lane], by[lane]);
        let flux_a = [
            areas[lane] * (xx[lane] * a_x + xy[lane] * a_y),
            areas[lane] * (xy[lane] * a_x + yy[lane] * a_y),
        ];
        let flux_b = [
            areas[lane] * (xx[lane] * b_x + xy[lane] * b_y),
            areas[lane] * (xy[lane] * b_x + yy[lane] * b_y),
        ];
        let aa = flux_a[0] * a_x + flux_a[1] * a_y;
        let ab = flux_a[0] * b_x + flux_a[1] * b_y;
        let bb = flux_b[0] * b_x + flux_b[1] * b_y;
        // The rows of an element's matrix have the sum zero.
        entries[0][lane] = aa;
        entries[1][lane] = ab;
        entries[2][lane] = -(aa + ab);
        entries[3][lane] = bb;
        entries[4][lane] = -(ab + bb);
        entries[5][lane] = aa + 2.0 * ab + bb;
    }
    entries
}

/// load ← load + the entries of a group's triangles.
#[inline(always)]
fn scatter(triangles: &[[u32; 3]], entries: &[Lane; 3], load: &mut [f64]) {
    for (lane, triangle) in triangles.iter().enumerate() {
        for (&node, entry) in triangle.iter().zip(entries) {
            load[node as usize] += entry[lane];
        }
    }
}
