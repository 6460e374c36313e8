//! The fast path for structured meshes with the natural boundary: one field, a transform of the grid.
//!
//! With ω and μ eliminated the linearised substep 2 is J δφ = −r₁,
//!   J = M + Δtγ_ben K M⁻¹ (A M⁻¹ T + C + rank one),
//! applied without being formed; with the consistent mass matrix M⁻¹ is a fixed Chebyshev
//! polynomial, so that J stays a linear map (Newton's method forgives its small error).
//!
//! Both wells have the same stiffness F''(±1) = 2, so away from the membrane J is a function of the
//! stiffness matrix alone. On the grid K is a five-point stencil, and with N the lumped mass
//!   K = T ⊗ W + D ⊗ S,   N = h² D ⊗ W,
//! where S has the stencil (−1, 2, −1) along a column and W is ½ at its ends and 1 between; so have T and D along a
//! row in the plane. By rotation, with 2πr, an edge along a row between r_j and r_{j+1} has the coefficient
//! 2πr_{j+½} in T, and D_j = 2πr_j, but 2πh/6 on the axis and π(R − h/3) at the wall: of both matrices exactly that,
//! but for the first and the last row, where r is off by h/6. The cosines of a column are eigenvectors of S against
//! W, and along a row those of T against D are taken, which are cosines in the plane.
//!
//! With κ = (4 − 2a − 2b)/h² the eigenvalue of K over N, where 2 − 2a and 2 − 2b are those of T and S, and m that of
//! the consistent mass over the lumped one, J has the eigenvalue m + Δtγ_ben ε κ (κ + 2m/ε²)²/m³. Its inverse
//! preconditions GMRES from the right. With the lumped rule m is 1, with the other one ½ + (a + b + ab)/6: the
//! mass of an edge along a column is D_j/12, of one along a row r_{j+½} in place of D_j (2D − T but on the axis and at the
//! wall), and that of a diagonal, which goes one way only, is divided among both.
//!
//! (A preconditioner may ignore that the first and the last row differ, but for the constants: there it is made exact,
//! 1ᵀM P⁻¹r = 1ᵀr. As 1ᵀK = 0, every residual that GMRES leaves then has the sum 0 that r₁ starts with, and ∫φ is
//! conserved to rounding however loosely the system is solved.)

use crate::fem::{Grid, MassForm, MassInverse, QuadratureRule, Space};
use crate::linalg::{Basis, GridTransform, LinalgError, LinearOperator, Multiplier, vector};
use crate::scene::Geometry;

use super::super::fault_injection::{self, Place};
use super::super::jacobian::Jacobian;
use super::BulkInverse;

/// Products of the Chebyshev polynomial that stands for M⁻¹ in J: an error of at most 2/3⁴ = 2.5 %,
/// less than what an iteration of Newton's method leaves in a step that starts from a good guess.
const MASS_PRODUCTS: usize = 4;

/// J, in the scaled unknowns of GMRES: D^(−1/2) J with D the lumped mass.
pub(in crate::scheme) struct ReducedOperator<'a> {
    pub(in crate::scheme) space: &'a Space,
    pub(in crate::scheme) jacobian: &'a Jacobian,
    pub(in crate::scheme) mass_inverse: &'a mut MassInverse,
    /// Δt γ_ben.
    pub(in crate::scheme) step_mobility: f64,
    pub(in crate::scheme) root_weights: &'a [f64],
    pub(in crate::scheme) scratch: &'a mut [Vec<f64>; 4],
}

impl LinearOperator for ReducedOperator<'_> {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let [first, second, omega, mu] = self.scratch;
        let (space, jacobian) = (self.space, self.jacobian);
        let matrices = [&jacobian.tangent.values[..], &jacobian.local.values[..]];
        space
            .assembly()
            .pattern
            .multiply_both(matrices, x, first, second);
        self.mass_inverse.apply(space, first, omega, MASS_PRODUCTS);
        jacobian.secant.multiply_add(1.0, omega, second);
        for term in &jacobian.rank_one {
            let along = term.scale * vector::dot(&term.row, x);
            vector::add_scaled(second, along, &term.column);
        }
        self.mass_inverse.apply(space, second, mu, MASS_PRODUCTS);
        let stiffness = space.stiffness();
        match space.mass() {
            MassForm::Nodal(diagonal) => {
                stiffness.multiply(mu, y);
                let rows = y.iter_mut().zip(diagonal).zip(x).zip(self.root_weights);
                for (((y, m), x), root) in rows {
                    *y = (m * x + self.step_mobility * *y) / root;
                }
            }
            MassForm::Sparse(mass) => {
                space.assembly().pattern.multiply_sum(
                    &mass.values,
                    x,
                    self.step_mobility,
                    &stiffness.values,
                    mu,
                    y,
                );
                y.iter_mut()
                    .zip(self.root_weights)
                    .for_each(|(y, root)| *y /= root);
            }
        }
        fault_injection::tap(Place::Product, y);
    }
}

/// The inverse of the bulk operator.
#[derive(Debug)]
pub(in crate::scheme) struct GridInverse {
    transform: GridTransform,
    multiplier: Multiplier,
    grid: Grid,
    rule: QuadratureRule,
    /// Δtγ_ben and ε of the multiplier.
    made_for: [f64; 2],
    scaled: Vec<f64>,
    root_weights: Vec<f64>,
    nodal_weights: Vec<f64>,
}

impl GridInverse {
    /// On the mesh of a space, which is this grid.
    ///
    /// # Errors
    /// By rotation [`LinalgError::Eigenvectors`].
    pub(in crate::scheme) fn new(space: &Space, grid: Grid) -> Result<Self, LinalgError> {
        let along = match space.mesh().geometry() {
            Geometry::Planar => Basis::cosines(grid.cells),
            Geometry::Axisymmetric => radial_basis(space, grid)?,
        };
        Ok(Self::with(space, grid, along))
    }

    /// With this basis in every row.
    fn with(space: &Space, grid: Grid, along: Basis) -> Self {
        let transform = GridTransform::new(grid.cells, along);
        let multiplier = transform.multiplier(|_, _| 1.0);
        let nodal_weights = space.nodal_weights().to_vec();
        Self {
            transform,
            multiplier,
            grid,
            rule: space.rule(),
            made_for: [f64::NAN; 2],
            scaled: vec![0.0; space.nodes()],
            root_weights: nodal_weights.iter().map(|weight| weight.sqrt()).collect(),
            nodal_weights,
        }
    }
}

/// The eigenvectors of T against D, both read from the row of the space's matrices in the middle.
fn radial_basis(space: &Space, grid: Grid) -> Result<Basis, LinalgError> {
    let (n, side) = (grid.cells as f64, grid.cells + 1);
    let first = grid.cells / 2 * side;
    let weights = &space.nodal_weights()[first..][..side];
    let weights: Vec<f64> = weights.iter().map(|weight| n * n * weight).collect();
    let stiffness = space.stiffness();
    let entry = |node| stiffness.pattern.position(node, node + 1);
    let springs = (first..first + grid.cells).map(|node| match entry(node) {
        Some(position) => -stiffness.values[position],
        None => 0.0,
    });
    Basis::eigenvectors(&springs.collect::<Vec<_>>(), &weights)
}

impl BulkInverse for GridInverse {
    fn prepare(&mut self, _: &Space, step_mobility: f64, width: f64) -> Result<(), LinalgError> {
        if self.made_for == [step_mobility, width] {
            return Ok(());
        }
        self.made_for = [step_mobility, width];
        let n = self.grid.cells as f64;
        let (transform, rule) = (&self.transform, self.rule);
        let multiplier = &mut self.multiplier;
        transform.set_multiplier(multiplier, |k, l| {
            let (across, along) = (transform.across(), transform.along());
            let [a, b] = [across.neighbour_mean(k), along.neighbour_mean(l)];
            let kappa = 2.0 * n * n * (2.0 - a - b);
            let mass = match rule {
                QuadratureRule::Lumped => 1.0,
                QuadratureRule::Consistent => 0.5 + (a + b + a * b) / 6.0,
            };
            let bulk = kappa / mass + 2.0 / (width * width);
            let eigenvalue = mass + step_mobility * width * kappa / mass * bulk * bulk;
            (eigenvalue * across.squared_norm(k) * along.squared_norm(l) / (n * n)).recip()
        });
        Ok(())
    }

    fn name(&self) -> &'static str {
        "transform"
    }

    fn method(&self) -> &'static str {
        "GMRES with the transform of the grid"
    }
}

impl LinearOperator for GridInverse {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        for ((scaled, x), root) in self.scaled.iter_mut().zip(x).zip(&self.root_weights) {
            *scaled = x * root;
        }
        self.transform.filter(&self.multiplier, &self.scaled, y);
        let missing = vector::sum(&self.scaled) - vector::dot(&self.nodal_weights, y);
        let shift = missing / vector::sum(&self.nodal_weights);
        y.iter_mut().for_each(|y| *y += shift);
        fault_injection::tap(Place::Preconditioner, y);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fem::Mesh;
    use crate::linalg::Gmres;

    const CELLS: usize = 24;
    const STEP_MOBILITY: f64 = 1e-9;
    const WIDTH: f64 = 0.05;

    fn space(geometry: Geometry, rule: QuadratureRule) -> Space {
        let mesh = Mesh::structured(CELLS, 0.0, 0).expect("a grid");
        Space::new(Arc::new(mesh.in_geometry(geometry)), rule)
    }

    /// The bulk operator M + c K M⁻¹ (K + bM) M⁻¹ (K + bM) of the space's own matrices, divided by the root of the lumped mass.
    struct Bulk<'a> {
        space: &'a Space,
        mass_inverse: MassInverse,
        scratch: [Vec<f64>; 2],
    }

    impl LinearOperator for Bulk<'_> {
        fn apply(&mut self, x: &[f64], y: &mut [f64]) {
            let (space, [first, second]) = (self.space, &mut self.scratch);
            second.copy_from_slice(x);
            for _ in 0..2 {
                space.stiffness().multiply(second, first);
                let shift = 2.0 / (WIDTH * WIDTH);
                space.mass().multiply_add(shift, second, first);
                self.mass_inverse.solve(space, first, second, 1e-13);
            }
            space.stiffness().multiply(second, y);
            vector::scale(y, STEP_MOBILITY * WIDTH);
            space.mass().multiply_add(1.0, x, y);
            let rows = y.iter_mut().zip(space.nodal_weights());
            rows.for_each(|(y, weight)| *y /= weight.sqrt());
        }
    }

    /// Iterations by which GMRES solves with the bulk operator to 1e-8.
    fn iterations(space: &Space, mut preconditioner: GridInverse) -> usize {
        let size = space.nodes();
        preconditioner
            .prepare(space, STEP_MOBILITY, WIDTH)
            .expect("a multiplier");
        let mut operator = Bulk {
            space,
            mass_inverse: MassInverse::new(space),
            scratch: [vec![0.0; size], vec![0.0; size]],
        };
        let b: Vec<f64> = (0..size).map(|i| ((i * i) as f64).sin()).collect();
        let mut x = vec![0.0; size];
        let goal = 1e-8 * vector::norm(&b);
        let outcome = Gmres::new(size, 100)
            .solve(&mut operator, &mut preconditioner, &b, &mut x, goal, 100)
            .expect("finite");
        outcome.iterations
    }

    /// By rotation the eigenvectors with the weight r do what cosines do in the plane; without the weight they do not.
    #[test]
    fn the_bulk_operator_is_inverted_by_rotation_as_it_is_in_the_plane() {
        for rule in [QuadratureRule::Lumped, QuadratureRule::Consistent] {
            let grid = Grid { cells: CELLS };
            let of = |space: &Space| GridInverse::new(space, grid).expect("eigenvectors");
            let [planar, rotated] =
                [Geometry::Planar, Geometry::Axisymmetric].map(|geometry| space(geometry, rule));
            let in_plane = iterations(&planar, of(&planar));
            let by_rotation = iterations(&rotated, of(&rotated));
            let cosines = GridInverse::with(&rotated, grid, Basis::cosines(CELLS));
            let without_weight = iterations(&rotated, cosines);
            println!("{rule:?}: {in_plane}, {by_rotation}, {without_weight}");
            assert!(by_rotation <= in_plane + 6, "{rule:?}: {by_rotation}");
            assert!(
                without_weight >= 3 * by_rotation,
                "{rule:?}: {without_weight}"
            );
        }
    }

    /// 1ᵀM P⁻¹r = 1ᵀr.
    #[test]
    fn the_sum_is_kept() {
        for geometry in [Geometry::Planar, Geometry::Axisymmetric] {
            for rule in [QuadratureRule::Lumped, QuadratureRule::Consistent] {
                let space = space(geometry, rule);
                let grid = Grid { cells: CELLS };
                let mut inverse = GridInverse::new(&space, grid).expect("eigenvectors");
                inverse
                    .prepare(&space, STEP_MOBILITY, WIDTH)
                    .expect("a multiplier");
                let r: Vec<f64> = (0..space.nodes()).map(|i| (i as f64).sin()).collect();
                let roots = space.nodal_weights().iter().map(|weight| weight.sqrt());
                let scaled: Vec<f64> = r.iter().zip(roots).map(|(r, root)| r / root).collect();
                let mut y = vec![0.0; r.len()];
                inverse.apply(&scaled, &mut y);
                let kept = vector::dot(space.nodal_weights(), &y);
                let sum = vector::sum(&r);
                assert!(
                    (kept - sum).abs() < 1e-12 * sum.abs().max(1.0),
                    "{kept} {sum}"
                );
            }
        }
    }
}
