//! The measure of a body of rotation: by it every integral over the half-plane (r, z) is one of 2πr dr dz.
//!
//! On a triangle with the area |T|, the corners r_k and their mean r̄, and with ρ_k = r_k/r̄:
//!
//!   ∫ 2πr = 2π r̄ |T|,   ∫ 2πr λ_k = 2π r̄ |T| (3 + ρ_k)/12,
//!   ∫ 2πr λ_k² = 2π r̄ |T| (3 + 2ρ_k)/30,   ∫ 2πr λ_k λ_l = 2π r̄ |T| (3 + ρ_k + ρ_l)/60,
//!
//! exactly. (In the plane ρ_k = 1, and these are the known 1/3, 1/6 and 1/12.) The seven points have the weight
//! 2πr of their place, which is exact for r times a polynomial of degree 4.
//!
//! The gradient of a vector field d_r e_r + d_z e_z has one component more than in the plane: d_r/r along the circle. As the
//! others it is constant on a triangle, the mean of d_r over r̄. It is finite up to the axis, where d_r = 0, and off by an
//! order h² as they are. (At the nodes, the points of the lumped rule, d_r/r would be unknown on the axis.)

use super::Mesh;
use super::quadrature::POINTS;
use super::space::{LANES, Lane};

/// The measure on the triangles of a mesh, and what becomes of a gradient.
#[derive(Debug)]
pub(super) struct Rotation {
    /// ρ_k of the three corners, by groups of triangles; 1 where there is no triangle.
    ratios: Vec<[Lane; 3]>,
    /// 1/r̄ of each triangle.
    pub(super) inverse_radii: Vec<f64>,
}

impl Rotation {
    /// On a mesh.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut ratios = vec![[[1.0; LANES]; 3]; mesh.triangles().len().div_ceil(LANES)];
        let mut inverse_radii = Vec::with_capacity(mesh.triangles().len());
        for (number, triangle) in mesh.triangles().iter().enumerate() {
            let radii = triangle.map(|node| mesh.nodes()[node as usize].x);
            let mean = (radii[0] + radii[1] + radii[2]) / 3.0;
            inverse_radii.push(mean.recip());
            for (ratios, radius) in ratios[number / LANES].iter_mut().zip(radii) {
                ratios[number % LANES] = radius / mean;
            }
        }
        Self {
            ratios,
            inverse_radii,
        }
    }

    /// ρ_k of a triangle.
    pub(super) fn ratios(&self, triangle: usize) -> [f64; 3] {
        self.ratios[triangle / LANES].map(|ratios| ratios[triangle % LANES])
    }

    /// r/r̄ at each of the seven points, for a group of triangles.
    pub(super) fn point_ratios(&self, group: usize, points: &[[f64; 3]; POINTS]) -> [Lane; POINTS] {
        let [a, b, c] = &self.ratios[group];
        points.map(|[la, lb, lc]| {
            std::array::from_fn(|lane| la * a[lane] + lb * b[lane] + lc * c[lane])
        })
    }
}

/// ∫ c λ_k for the corners of a triangle, given ∫ c, with c constant on it; without ratios, in the plane.
#[inline(always)]
pub(super) fn shares(integral: f64, ratios: Option<[f64; 3]>) -> [f64; 3] {
    match ratios {
        None => [integral / 3.0; 3],
        Some(ratios) => ratios.map(|ratio| integral * (3.0 + ratio) / 12.0),
    }
}

/// ∫ c λ_k λ_l for the six different pairs of corners, given ∫ c, with c constant on the triangle.
#[inline(always)]
pub(super) fn element_mass(integral: f64, ratios: Option<[f64; 3]>) -> [f64; 6] {
    match ratios {
        None => {
            let (same, other) = (integral / 6.0, integral / 12.0);
            [same, other, other, same, other, same]
        }
        Some([a, b, c]) => {
            let same = |ratio: f64| integral * (3.0 + 2.0 * ratio) / 30.0;
            let other = |one: f64, other: f64| integral * (3.0 + one + other) / 60.0;
            [
                same(a),
                other(a, b),
                other(a, c),
                same(b),
                other(b, c),
                same(c),
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};
    use std::sync::Arc;

    use super::super::{MassForm, MassInverse, QuadratureRule, Space};
    use super::*;
    use crate::geometry::{Point, SymmetricTensor, Vector};
    use crate::scene::Geometry;

    const RULES: [QuadratureRule; 2] = [QuadratureRule::Consistent, QuadratureRule::Lumped];

    fn mesh() -> Arc<Mesh> {
        let mesh = Mesh::structured(7, 0.3, 3).expect("a fair mesh");
        Arc::new(mesh.in_geometry(Geometry::Axisymmetric))
    }

    fn nodal(mesh: &Mesh, f: impl Fn(Point) -> f64) -> Vec<f64> {
        mesh.nodes().iter().map(|node| f(*node)).collect()
    }

    #[track_caller]
    fn assert_near(found: f64, wanted: f64) {
        assert!(
            (found - wanted).abs() <= 1e-13 * wanted.abs(),
            "{found} is not {wanted}"
        );
    }

    /// ∫ 2πr f over the cylinder of radius and height 1.
    #[test]
    fn linear_functions_are_integrated_exactly_by_both_rules() {
        let mesh = mesh();
        for rule in RULES {
            let space = Space::new(mesh.clone(), rule);
            let linear = |at: Point| 2.0 + 3.0 * at.x - 5.0 * at.y;
            let exact = 2.0 * PI + 3.0 * TAU / 3.0 - 2.5 * PI;
            let values = nodal(&mesh, linear);
            assert_near(space.integrate_nodal(&values), exact);
            let patches = || space.patches();
            let mut points = vec![0.0; space.points()];
            space.whole().interpolate(&values, &mut points);
            assert_near(space.whole().integrate(&points), exact);
            let weights = patches().map(|patch| patch.weights().iter().sum::<f64>());
            assert_near(weights.sum(), PI);
            // As means over the triangles, and from them back at the points.
            let mut means = vec![0.0; space.elements()];
            space.whole().element_means(&points, &mut means);
            assert_near(space.whole().integrate_elements(&means), exact);
            space.whole().from_elements(&means, &mut points);
            assert_near(space.whole().integrate(&points), exact);
            // Tested with 1, from a density at the points.
            let mut load = vec![0.0; space.nodes()];
            let no_flux = vec![Vector::zeros(); space.elements()];
            space.add_load(&points, &no_flux, &mut load);
            assert_near(load.iter().sum(), exact);
            // ∫ r²: a product of two linear functions.
            let radius = nodal(&mesh, |at| at.x);
            if let MassForm::Sparse(mass) = space.mass() {
                assert_near(mass.quadratic_form(&radius), TAU / 4.0);
            }
            // ∫ |∇(r + 2z)|².
            let slope = nodal(&mesh, |at| at.x + 2.0 * at.y);
            assert_near(space.stiffness().quadratic_form(&slope), 5.0 * PI);
        }
    }

    /// Products by the entries of the elements are those by the matrices.
    #[test]
    fn a_coefficient_on_the_triangles_is_the_same_by_every_way() {
        let mesh = mesh();
        for rule in RULES {
            let space = Space::new(mesh.clone(), rule);
            let u = nodal(&mesh, |at| 1.0 + (3.0 * at.x).sin() * at.y);
            let elements = space.elements();
            let coefficient: Vec<f64> = (0..elements).map(|it| 1.0 + (it % 5) as f64).collect();
            let mut entries = vec![Default::default(); space.groups()];
            let whole = space.whole();
            whole.add_product_entries(coefficient.iter().copied(), &u, &mut entries);
            let nothing = vec![0.0; space.points()];
            let mut load = vec![0.0; space.nodes()];
            space.collect_load(&entries, &nothing, &mut load);
            let mut points = vec![0.0; space.points()];
            whole.from_elements(&coefficient, &mut points);
            let mut matrix = space.stiffness().clone();
            matrix.values.fill(0.0);
            let no_tensors = vec![SymmetricTensor::default(); elements];
            space.add_mass_and_stiffness(&points, &no_tensors, &mut matrix.values);
            let mut product = vec![0.0; space.nodes()];
            matrix.multiply(&u, &mut product);
            let off = load.iter().zip(&product).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-14, "{rule:?}");
        }
    }

    /// The bound is sharp for a triangle with an edge on the axis, or a corner.
    #[test]
    fn the_mass_matrix_is_at_least_a_fifth_of_the_lumped_one() {
        let mut least = f64::INFINITY;
        for ratios in [[0.0, 0.0, 3.0], [0.0, 1.5, 1.5], [0.5, 0.7, 1.8], [1.0; 3]] {
            let [aa, ab, ac, bb, bc, cc] = element_mass(1.0, Some(ratios));
            let lumped = shares(1.0, Some(ratios));
            let sums = [aa + ab + ac, ab + bb + bc, ac + bc + cc];
            for (sum, share) in sums.iter().zip(lumped) {
                assert!((sum - share).abs() < 1e-15);
            }
            let root = lumped.map(f64::sqrt);
            let matrix = nalgebra::Matrix3::new(aa, ab, ac, ab, bb, bc, ac, bc, cc);
            let scaled = matrix.map_with_location(|i, j, entry| entry / (root[i] * root[j]));
            let values = scaled.symmetric_eigenvalues();
            assert!(
                values
                    .iter()
                    .all(|value| (0.2 - 1e-14..1.0 + 1e-14).contains(value))
            );
            least = least.min(values.min());
        }
        assert!((least - 0.2).abs() < 1e-14);
        let space = Space::new(mesh(), QuadratureRule::Consistent);
        let exact: Vec<f64> = (0..64).map(|i| f64::from(i * i).sin()).collect();
        let mut b = vec![0.0; 64];
        space.mass().multiply(&exact, &mut b);
        let mut x = vec![0.0; 64];
        MassInverse::new(&space).solve(&space, &b, &mut x, 1e-14);
        let off = x.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12);
    }

    /// Only the two ends of the axis belong to the wall.
    #[test]
    fn the_axis_is_no_wall() {
        let mesh = mesh();
        let on_axis: Vec<bool> = mesh.on_axis().collect();
        assert_eq!(on_axis.iter().filter(|on| **on).count(), 8);
        let both = on_axis.iter().zip(mesh.on_boundary());
        let corners = both.filter(|(on_axis, on_wall)| **on_axis && **on_wall);
        assert_eq!(corners.count(), 2);
        assert_eq!(mesh.on_boundary().iter().filter(|on| **on).count(), 22);
        assert_eq!(mesh.boundary_edges().len(), 21);
    }
}
