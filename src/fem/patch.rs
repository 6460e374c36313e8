//! A piece of a P1 space: consecutive triangles with their quadrature points, few enough for what is
//! computed on them to stay in the cache.
//!
//! Everything that an integral over the domain needs is done piece by piece: nodal fields are taken
//! to the points and gradients to the triangles, effects work on both, and densities are brought back
//! into entries of loads and matrices, which the space adds up, and into numbers.

use std::ops::Range;

use wide::f64x8;

use super::assembly::{LoadEntries, MatrixEntries};
use super::quadrature::POINTS;
use super::rotation::{element_mass, shares};
use super::space::{GROUP, LANES, Lane};
use super::{QuadratureRule, Space};
use crate::geometry::{SymmetricTensor, Vector};
use crate::linalg::vector;

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

    fn triangles(&self) -> &'a [[u32; 3]] {
        &self.space.mesh().triangles()[self.element_range()]
    }

    /// ∫ 1 over each triangle.
    fn measures(&self) -> &'a [f64] {
        &self.space.mesh().measures()[self.element_range()]
    }

    /// By rotation: r over its mean at the corners of a triangle of the patch.
    #[inline(always)]
    fn ratios(&self, triangle: usize) -> Option<[f64; 3]> {
        let rotation = self.space.rotation.as_ref()?;
        Some(rotation.ratios(self.elements[0] + triangle))
    }

    /// 1/r̄ of each triangle; `None` in the plane.
    fn inverse_radii(&self) -> Option<&'a [f64]> {
        let rotation = self.space.rotation.as_ref()?;
        Some(&rotation.inverse_radii[self.element_range()])
    }

    /// Calls f(point, values) for the seven points of a group of the patch, with the values there times r over its mean.
    #[inline(always)]
    fn each_point(&self, group: usize, values: &[f64; GROUP], mut f: impl FnMut(usize, f64x8)) {
        let rows = values.as_chunks::<LANES>().0.iter().enumerate();
        match self.point_ratios(group) {
            None => rows.for_each(|(point, row)| f(point, f64x8::new(*row))),
            Some(ratios) => rows.for_each(|(point, row)| {
                f(point, f64x8::new(*row) * f64x8::new(ratios[point]));
            }),
        }
    }

    /// By rotation: r over its mean at the seven points of the triangles of a group of the patch.
    #[inline(always)]
    fn point_ratios(&self, group: usize) -> Option<[Lane; POINTS]> {
        let rotation = self.space.rotation.as_ref()?;
        let group = self.elements[0] / LANES + group;
        Some(rotation.point_ratios(group, &self.space.coordinates))
    }

    /// The weights of its quadrature points.
    pub fn weights(&self) -> &'a [f64] {
        &self.space.weights[self.point_range()]
    }

    /// The triangles in groups: their corners, their measures, the gradients of their first two basis
    /// functions (the third one's is minus the sum).
    #[inline(always)]
    fn each_group(&self) -> impl Iterator<Item = (&'a [[u32; 3]], &'a [f64], &'a [Lane; 4])> {
        let first = self.elements[0] / LANES;
        self.triangles()
            .chunks(LANES)
            .zip(self.measures().chunks(LANES))
            .zip(&self.space.slopes[first..])
            .map(|((triangles, measures), slopes)| (triangles, measures, slopes))
    }

    /// A P1 function at the points and its gradient on the triangles.
    pub fn sample(&self, nodal: &[f64], points: &mut [f64], gradients: &mut [Vector]) {
        let groups = self.each_group().zip(gradients.chunks_mut(LANES));
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

    /// The component along the circle of the gradient of a vector field on the triangles, u/r for its component u along r; none
    /// in the plane.
    pub fn hoop_gradient(&self, radial: &[f64], hoops: &mut Vec<f64>) {
        hoops.clear();
        let triangles = self
            .triangles()
            .iter()
            .zip(self.inverse_radii().unwrap_or(&[]));
        hoops.extend(triangles.map(|(triangle, inverse)| {
            let [a, b, c] = triangle.map(|node| radial[node as usize]);
            (a + b + c) / 3.0 * inverse
        }));
    }

    /// entries ← entries + ∫ q ψ_i/r for a flux q along the circle on the triangles.
    pub fn add_hoop_entries(&self, fluxes: &[f64], entries: &mut [LoadEntries]) {
        let radii = self.inverse_radii().unwrap_or(&[]);
        let triangles = self.measures().iter().zip(radii).zip(fluxes).enumerate();
        for (triangle, ((measure, inverse), flux)) in triangles {
            for entry in &mut entries[triangle / LANES] {
                entry[triangle % LANES] += measure * inverse * flux / 3.0;
            }
        }
    }

    /// The values of a P1 function at the points.
    pub fn interpolate(&self, nodal: &[f64], points: &mut [f64]) {
        if self.space.rule() == QuadratureRule::Lumped {
            points.copy_from_slice(nodal);
            return;
        }
        let points = points.as_chunks_mut::<GROUP>().0;
        for ((triangles, ..), points) in self.each_group().zip(points) {
            self.store_points(&corners(nodal, triangles), points);
        }
    }

    /// The values at the points of a group from those at the corners.
    #[inline(always)]
    fn store_points(&self, [a, b, c]: &[f64x8; 3], points: &mut [f64; GROUP]) {
        let rows = points.as_chunks_mut::<LANES>().0.iter_mut();
        for (row, coordinates) in rows.zip(&self.space.coordinates) {
            let [la, lb, lc] = coordinates.map(f64x8::splat);
            *row = (la * *a + lb * *b + lc * *c).to_array();
        }
    }

    /// ∫ f over the patch for a density at the points.
    pub fn integrate(&self, density: &[f64]) -> f64 {
        vector::dot(self.weights(), density)
    }

    /// ∫ f(u) for a function u at the points, eight of which are worked on at once.
    pub fn integrate_of(&self, u: &[f64], f: impl Fn(f64x8) -> f64x8) -> f64 {
        vector::weighted_sum(self.weights(), u, f)
    }

    /// ∫ f for a density on the triangles.
    pub fn integrate_elements(&self, density: &[f64]) -> f64 {
        vector::dot(self.measures(), density)
    }

    /// ∫ f for a density that is worked out triangle by triangle.
    pub fn integrate_elements_of(&self, densities: impl IntoIterator<Item = f64>) -> f64 {
        let elements = self.measures().iter().zip(densities);
        elements.map(|(measure, density)| measure * density).sum()
    }

    /// ∫ f ψ_i + ∫ q·∇ψ_i for a density f at the points and a flux q on the triangles. With the lumped rule the part of f
    /// is none of the triangles', but the nodes' ([`Space::add_load`]).
    pub fn load_entries(&self, density: &[f64], fluxes: &[Vector], entries: &mut [LoadEntries]) {
        let groups = self.each_group().zip(fluxes.chunks(LANES)).zip(entries);
        if self.space.rule() == QuadratureRule::Lumped {
            for (((_, areas, slopes), fluxes), entries) in groups {
                *entries = flux_entries(&lanes(areas), slopes, fluxes);
            }
            return;
        }
        let density = density.as_chunks::<GROUP>().0;
        for (group, ((((_, areas, slopes), fluxes), entries), density)) in
            groups.zip(density).enumerate()
        {
            let mut sums = [f64x8::ZERO; 3];
            self.each_point(group, density, |point, row| {
                let weight = self.space.relative_weights[point];
                for (sum, coordinate) in sums.iter_mut().zip(&self.space.coordinates[point]) {
                    *sum += f64x8::splat(weight * coordinate) * row;
                }
            });
            let areas = lanes(areas);
            *entries = flux_entries(&areas, slopes, fluxes);
            add_times(entries, &areas, &sums);
        }
    }

    /// entries ← entries + ∫ c u ψ_i for a coefficient on the triangles and a P1 function u given at the nodes.
    pub fn add_product_entries(
        &self,
        coefficient: impl IntoIterator<Item = f64>,
        u: &[f64],
        entries: &mut [LoadEntries],
    ) {
        let mut coefficient = coefficient.into_iter();
        for (group, ((triangles, measures, _), entries)) in
            self.each_group().zip(entries).enumerate()
        {
            let measures = lanes(measures);
            for ((lane, triangle), c) in triangles.iter().enumerate().zip(&mut coefficient) {
                let values = triangle.map(|node| u[node as usize]);
                let products = match (self.space.rule(), self.ratios(group * LANES + lane)) {
                    (QuadratureRule::Lumped, ratios) => {
                        let shares = shares(c * measures[lane], ratios);
                        [0, 1, 2].map(|corner| shares[corner] * values[corner])
                    }
                    (QuadratureRule::Consistent, None) => {
                        let sum = values[0] + values[1] + values[2];
                        values.map(|value| c * measures[lane] / 12.0 * (sum + value))
                    }
                    (QuadratureRule::Consistent, ratios) => {
                        let [aa, ab, ac, bb, bc, cc] = element_mass(c * measures[lane], ratios);
                        [[aa, ab, ac], [ab, bb, bc], [ac, bc, cc]]
                            .map(|row| (0..3).map(|corner| row[corner] * values[corner]).sum())
                    }
                };
                for (entry, product) in entries.iter_mut().zip(products) {
                    entry[lane] += product;
                }
            }
        }
    }

    /// ∫ c ψ_j ψ_i for a coefficient at the points. With the lumped rule it is none of the triangles', but the nodes'.
    pub fn mass_entries(&self, coefficient: &[f64], entries: &mut [MatrixEntries]) {
        for ((group, (_, measures, _)), entries) in self.each_group().enumerate().zip(entries) {
            *entries = [[0.0; LANES]; 6];
            self.add_mass_entries(coefficient, group, &lanes(measures), entries);
        }
    }

    /// ∫ c ψ_j ψ_i + ∫ (T ∇ψ_j)·∇ψ_i for a coefficient c at the points and a tensor T on the triangles; with the lumped
    /// rule without the part of c.
    pub fn mass_and_stiffness_entries(
        &self,
        coefficient: &[f64],
        tensors: &[SymmetricTensor],
        entries: &mut [MatrixEntries],
    ) {
        let groups = self.each_group().zip(tensors.chunks(LANES)).zip(entries);
        for (group, (((_, areas, slopes), tensors), entries)) in groups.enumerate() {
            let areas = lanes(areas);
            let mut tensor = [[0.0; LANES]; 3];
            for (lane, numbers) in tensors.iter().enumerate() {
                for (row, number) in tensor.iter_mut().zip(numbers.entries()) {
                    row[lane] = number;
                }
            }
            *entries = stiffness_entries(&areas, slopes, &tensor);
            self.add_mass_entries(coefficient, group, &areas, entries);
        }
    }

    /// entries ← entries + ∫ c ψ_j ψ_i for a group of triangles, where the rule is consistent.
    #[inline(always)]
    fn add_mass_entries(
        &self,
        coefficient: &[f64],
        group: usize,
        areas: &Lane,
        entries: &mut MatrixEntries,
    ) {
        if self.space.rule() == QuadratureRule::Lumped {
            return;
        }
        let mut sums = [f64x8::ZERO; 6];
        self.each_point(group, &coefficient.as_chunks().0[group], |point, row| {
            for (sum, product) in sums.iter_mut().zip(&self.space.products[point]) {
                *sum += row * f64x8::splat(*product);
            }
        });
        add_times(entries, areas, &sums);
    }

    /// The matrices of two fields x and y on the same mesh, their two blocks and what couples them:
    ///
    /// x, y blocks: ∫ w ∇ψ_j·∇ψ_i + ∫ c ψ_j ψ_i, and with a tensor R on the triangles also ∫ R_xx ψ_j ψ_i, ∫ R_yy ψ_j ψ_i; by
    /// rotation the x block has ∫ w ψ_j ψ_i/r² too;
    /// coupling: ∫ R_xy ψ_j ψ_i, with the lumped rule only the three entries of the corners, which come first.
    pub fn coupled_entries(
        &self,
        (weight, coefficient): (&[f64], &[f64]),
        tensors: Option<&[SymmetricTensor]>,
        [x, y, coupling]: [&mut [MatrixEntries]; 3],
    ) {
        let lumped = self.space.rule() == QuadratureRule::Lumped;
        let entries = x.iter_mut().zip(y).zip(coupling);
        let groups = self.each_group().zip(weight.chunks(LANES)).zip(entries);
        for (group, (((_, areas, slopes), weight), ((x, y), coupling))) in groups.enumerate() {
            let (areas, weight) = (lanes(areas), lanes(weight));
            *x = stiffness_entries(&areas, slopes, &[weight, [0.0; LANES], weight]);
            self.add_mass_entries(coefficient, group, &areas, x);
            *y = *x;
            if let Some(radii) = self.inverse_radii() {
                let radii = lanes(&radii[group * LANES..]);
                for lane in 0..LANES {
                    let hoop = radii[lane] / 3.0;
                    let entry = areas[lane] * weight[lane] * hoop * hoop;
                    x.iter_mut().for_each(|sum| sum[lane] += entry);
                }
            }
            *coupling = [[0.0; LANES]; 6];
            let Some(tensors) = tensors else { continue };
            for (lane, tensor) in tensors[group * LANES..].iter().take(LANES).enumerate() {
                let [xx, xy, yy] = (areas[lane] * *tensor).entries();
                let ratios = self.ratios(group * LANES + lane);
                if lumped {
                    let [xx, xy, yy] = [xx, xy, yy].map(|entry| shares(entry, ratios));
                    for (number, corner) in [0, 3, 5].into_iter().enumerate() {
                        x[corner][lane] += xx[number];
                        y[corner][lane] += yy[number];
                        coupling[number][lane] = xy[number];
                    }
                } else {
                    for (block, entry) in [(&mut *x, xx), (&mut *y, yy), (&mut *coupling, xy)] {
                        for (sum, entry) in block.iter_mut().zip(element_mass(entry, ratios)) {
                            sum[lane] += entry;
                        }
                    }
                }
            }
        }
    }

    /// The mean over each triangle, by the rule, of a function at the points.
    pub fn element_means(&self, points: &[f64], means: &mut [f64]) {
        if self.space.rule() == QuadratureRule::Lumped {
            let triangles = means.iter_mut().zip(self.triangles());
            for (number, (mean, triangle)) in triangles.enumerate() {
                let values = triangle.map(|node| points[node as usize]);
                *mean = lumped_mean(values, self.ratios(number));
            }
            return;
        }
        let groups = points.as_chunks::<GROUP>().0.iter();
        for (group, (means, values)) in means.chunks_mut(LANES).zip(groups).enumerate() {
            let mut sums = f64x8::ZERO;
            self.each_point(group, values, |point, row| {
                sums += f64x8::splat(self.space.relative_weights[point]) * row;
            });
            means.copy_from_slice(&sums.to_array()[..means.len()]);
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
        let weighted = elements.iter().zip(self.measures());
        let triangles = self.triangles().iter().zip(weighted);
        for (number, (triangle, (value, measure))) in triangles.enumerate() {
            let shares = shares(value * measure, self.ratios(number));
            for (&node, share) in triangle.iter().zip(shares) {
                points[node as usize] += share;
            }
        }
        for (point, weight) in points.iter_mut().zip(self.weights()) {
            *point /= weight;
        }
    }

    /// The mean over each triangle, by the rule, of v⊗v for a vector field v at the points.
    pub fn mean_squares(&self, [x, y]: [&[f64]; 2], means: &mut [SymmetricTensor]) {
        if self.space.rule() == QuadratureRule::Lumped {
            let triangles = means.iter_mut().zip(self.triangles());
            for (number, (mean, triangle)) in triangles.enumerate() {
                let [x, y] = [x, y].map(|values| triangle.map(|node| values[node as usize]));
                let ratios = self.ratios(number);
                let of = |u: [f64; 3], v: [f64; 3]| {
                    lumped_mean([u[0] * v[0], u[1] * v[1], u[2] * v[2]], ratios)
                };
                *mean = SymmetricTensor::new(of(x, x), of(x, y), of(y, y));
            }
            return;
        }
        let groups = x
            .as_chunks::<GROUP>()
            .0
            .iter()
            .zip(y.as_chunks::<GROUP>().0);
        for (group, (means, (x, y))) in means.chunks_mut(LANES).zip(groups).enumerate() {
            let [mut xx, mut xy, mut yy] = [[0.0; LANES]; 3];
            let rows = x
                .as_chunks::<LANES>()
                .0
                .iter()
                .zip(y.as_chunks::<LANES>().0);
            let ratios = self.point_ratios(group);
            for (point, (x, y)) in rows.enumerate() {
                let weight = self.space.relative_weights[point];
                let weights = ratios.map(|ratios| ratios[point].map(|ratio| weight * ratio));
                let weights = weights.unwrap_or([weight; LANES]);
                for lane in 0..LANES {
                    let weight = weights[lane];
                    xx[lane] += weight * x[lane] * x[lane];
                    xy[lane] += weight * x[lane] * y[lane];
                    yy[lane] += weight * y[lane] * y[lane];
                }
            }
            for (lane, mean) in means.iter_mut().enumerate() {
                *mean = SymmetricTensor::new(xx[lane], xy[lane], yy[lane]);
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

/// The mean over a triangle, by its corners.
#[inline(always)]
fn lumped_mean([a, b, c]: [f64; 3], ratios: Option<[f64; 3]>) -> f64 {
    match ratios {
        None => (a + b + c) / 3.0,
        Some(_) => {
            let [of_a, of_b, of_c] = shares(1.0, ratios);
            of_a * a + of_b * b + of_c * c
        }
    }
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
fn corners(nodal: &[f64], triangles: &[[u32; 3]]) -> [f64x8; 3] {
    let mut corners = [[0.0; LANES]; 3];
    for (lane, triangle) in triangles.iter().enumerate() {
        for (corner, &node) in corners.iter_mut().zip(triangle) {
            corner[lane] = nodal[node as usize];
        }
    }
    corners.map(f64x8::new)
}

/// entries ← entries + factor · sums, entry by entry.
#[inline(always)]
fn add_times<const N: usize>(entries: &mut [Lane; N], factor: &Lane, sums: &[f64x8; N]) {
    let factor = f64x8::new(*factor);
    for (entry, sum) in entries.iter_mut().zip(sums) {
        *entry = (f64x8::new(*entry) + factor * *sum).to_array();
    }
}

/// The gradients on the triangles of a group: (a − c)∇ψ_a + (b − c)∇ψ_b.
#[inline(always)]
fn store_gradients([a, b, c]: &[f64x8; 3], slopes: &[Lane; 4], gradients: &mut [Vector]) {
    let [ax, ay, bx, by] = slopes.map(f64x8::new);
    let (first, second) = (*a - *c, *b - *c);
    let x = (first * ax + second * bx).to_array();
    let y = (first * ay + second * by).to_array();
    match gradients.first_chunk_mut::<LANES>() {
        Some(full) => {
            for lane in 0..LANES {
                full[lane] = Vector::new(x[lane], y[lane]);
            }
        }
        None => {
            for (lane, gradient) in gradients.iter_mut().enumerate() {
                *gradient = Vector::new(x[lane], y[lane]);
            }
        }
    }
}

/// ∫ q·∇ψ for the three corners of a group's triangles.
#[inline(always)]
fn flux_entries(areas: &Lane, slopes: &[Lane; 4], fluxes: &[Vector]) -> LoadEntries {
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    match fluxes.first_chunk::<LANES>() {
        Some(full) => {
            for lane in 0..LANES {
                (x[lane], y[lane]) = (full[lane].x, full[lane].y);
            }
        }
        None => {
            for (lane, flux) in fluxes.iter().enumerate() {
                (x[lane], y[lane]) = (flux.x, flux.y);
            }
        }
    }
    let [ax, ay, bx, by] = slopes.map(f64x8::new);
    let areas = f64x8::new(*areas);
    let (x, y) = (areas * f64x8::new(x), areas * f64x8::new(y));
    let (first, second) = (x * ax + y * ay, x * bx + y * by);
    [first, second, -(first + second)].map(|entry| entry.to_array())
}

/// ∫ (T ∇ψ_j)·∇ψ_i for the triangles of a group; T by its entries xx, xy, yy.
#[inline(always)]
fn stiffness_entries(areas: &Lane, slopes: &[Lane; 4], tensor: &[Lane; 3]) -> MatrixEntries {
    let [a_x, a_y, b_x, b_y] = slopes.map(f64x8::new);
    let [xx, xy, yy] = tensor.map(f64x8::new);
    let areas = f64x8::new(*areas);
    let flux = |x, y| [areas * (xx * x + xy * y), areas * (xy * x + yy * y)];
    let (flux_a, flux_b) = (flux(a_x, a_y), flux(b_x, b_y));
    let aa = flux_a[0] * a_x + flux_a[1] * a_y;
    let ab = flux_a[0] * b_x + flux_a[1] * b_y;
    let bb = flux_b[0] * b_x + flux_b[1] * b_y;
    // The rows of an element's matrix have the sum zero.
    let cc = aa + f64x8::splat(2.0) * ab + bb;
    [aa, ab, -(aa + ab), bb, -(ab + bb), cc].map(|entry| entry.to_array())
}
