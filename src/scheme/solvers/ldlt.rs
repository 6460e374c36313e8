//! The path for any mesh and both boundaries: all three fields, a sparse LDLᵀ factor.
//!
//! GMRES on the exact linearised system, preconditioned by the factor of its symmetrised part
//! (signs changed, the third equation times θ, A and θεT replaced by their mean, the rank-one terms left out),
//!
//!   [ C    S    −M      ] [δφ]
//!   [ S  −θεM    0      ] [δω]     S = (A + θεT)/2.
//!   [−M    0   −ΔtγK    ] [δμ]
//!
//! The factor is kept until the iterations that it needs say that a new one would pay.

use serde::{Deserialize, Serialize};

use crate::fem::{MassForm, Space};
use crate::linalg::{Block, Ldlt, LinalgError, LinearOperator, Pattern, minimum_degree, vector};

use super::super::fault_injection::{self, Place};
use super::super::jacobian::Jacobian;

/// Above this many GMRES iterations in one solve the factor is rebuilt: a factorisation costs about as much
/// as twenty solves (`cargo bench --bench step -- factor`).
const STALE_AFTER: usize = 8;

/// A factor serves for a Δt this many times longer or shorter than its own, with an iteration or two more in each solve. The
/// quick presets took 6 % longer with 1.8 (and Newton's `FALLS_FAST` of 0.01), as long with 3 or 4.
const RANGE: f64 = 2.5;

/// The entries (row field, column field) of the 3 × 3 blocks that are stored; fields in the order
/// φ, ω, μ. The first three follow the stiffness pattern, the others the mass pattern.
const BLOCKS: [(usize, usize); 7] = [(0, 0), (0, 1), (1, 0), (2, 2), (0, 2), (2, 0), (1, 1)];

/// Of them, how many follow the stiffness pattern.
const STIFF_BLOCKS: usize = 4;

/// The order in which the fields of a node are eliminated. The blocks of ω and μ are negative definite in any
/// state, and what their elimination adds to that of φ is positive definite; that block itself may have no
/// inverse, and then small pivots spoil the factor: with φ among the first some steps were refused.
const ORDER: [u32; 3] = [1, 2, 0];

/// The factor and what decides about its age.
#[derive(Debug)]
pub(in crate::scheme) struct FactoredPreconditioner {
    factor: Ldlt,
    values: Vec<f64>,
    /// Where each stored entry of a node pair goes; `u32::MAX` where the lumped mass has none.
    positions: Vec<[u32; BLOCKS.len()]>,
    /// Nodes whose φ is given.
    fixed: Vec<bool>,
    age: RefactorPolicy,
    interleaved: Vec<f64>,
    row_scales: [f64; 3],
    root_weights: Vec<f64>,
}

/// Which matrix was factored, and what decides whether the factor is used again. A factor lives on
/// over many steps, so that the present state alone does not tell it; the matrix takes much less
/// memory than the factor.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(in crate::scheme) struct FactorCheckpoint {
    age: RefactorPolicy,
    /// Empty where there is no factor.
    values: Vec<f64>,
}

impl FactorCheckpoint {
    /// There is no factor.
    pub(in crate::scheme) fn clear(&mut self) {
        self.age = RefactorPolicy::default();
        self.values.clear();
    }

    /// Whether there is none.
    pub(in crate::scheme) fn is_empty(&self) -> bool {
        self.age.made_for.is_none()
    }
}

/// Whether the factor can be used again: a small state machine of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct RefactorPolicy {
    /// Δtγ_ben and θ of the factored matrix; `None`: there is no factor.
    made_for: Option<[f64; 2]>,
    /// Iterations that the last solve took.
    last_iterations: usize,
}

impl RefactorPolicy {
    fn must_refresh(&self, step_mobility: f64, weight: f64) -> bool {
        let fits = |[made_for, of]: [f64; 2]| {
            of == weight && (made_for / step_mobility).max(step_mobility / made_for) <= RANGE
        };
        !self.made_for.is_some_and(fits) || self.last_iterations > STALE_AFTER
    }
}

impl FactoredPreconditioner {
    /// Analyses the system on a space, with φ given at the nodes `fixed`.
    pub(in crate::scheme) fn new(space: &Space, fixed: Vec<bool>) -> Result<Self, LinalgError> {
        let nodes = space.assembly().pattern.clone();
        let lumped = matches!(space.mass(), MassForm::Nodal(_));
        let stored = |block: usize, row: usize, column: usize| {
            block < STIFF_BLOCKS || !lumped || row == column
        };
        let mut rows = vec![Vec::new(); 3 * nodes.size()];
        for row in 0..nodes.size() {
            for (_, column) in nodes.row(row) {
                for (block, (i, j)) in BLOCKS.into_iter().enumerate() {
                    if stored(block, row, column as usize) {
                        rows[3 * row + i].push(3 * column + j as u32);
                    }
                }
            }
        }
        let pattern = Pattern::from_rows(rows);
        let mut positions = vec![[u32::MAX; BLOCKS.len()]; nodes.stored()];
        for row in 0..nodes.size() {
            for (entry, column) in nodes.row(row) {
                positions[entry] = BLOCKS.map(|(i, j)| {
                    let position = pattern.position(3 * row + i, 3 * column as usize + j);
                    position.map_or(u32::MAX, |position| position as u32)
                });
            }
        }
        let order = minimum_degree(&nodes)?.into_iter();
        let order = order
            .flat_map(|node| ORDER.map(|field| 3 * node + field))
            .collect();
        Ok(Self {
            factor: Ldlt::analyse(&pattern, order)?,
            values: vec![0.0; pattern.stored()],
            positions,
            fixed,
            age: RefactorPolicy::default(),
            interleaved: vec![0.0; 3 * nodes.size()],
            row_scales: [1.0; 3],
            root_weights: space
                .nodal_weights()
                .iter()
                .map(|weight| weight.sqrt())
                .collect(),
        })
    }

    /// Makes the factor again if it is too old for this system; returns whether it did.
    pub(in crate::scheme) fn prepare(
        &mut self,
        space: &Space,
        jacobian: &Jacobian,
        step_mobility: f64,
        width: f64,
        row_scales: [f64; 3],
    ) -> Result<bool, LinalgError> {
        self.row_scales = row_scales;
        if !self.age.must_refresh(step_mobility, jacobian.weight) {
            return Ok(false);
        }
        self.fill(space, jacobian, step_mobility, width);
        self.age.made_for = None;
        self.factor.refactor(&self.values)?;
        self.age = RefactorPolicy {
            made_for: Some([step_mobility, jacobian.weight]),
            last_iterations: 0,
        };
        Ok(true)
    }

    /// Tells how many iterations a solve with this factor took.
    pub(in crate::scheme) fn used(&mut self, iterations: usize) {
        self.age.last_iterations = iterations;
    }

    /// Which matrix is factored.
    pub(in crate::scheme) fn save(&self, checkpoint: &mut FactorCheckpoint) {
        checkpoint.clear();
        checkpoint.age = self.age;
        if !checkpoint.is_empty() {
            checkpoint.values.extend_from_slice(&self.values);
        }
    }

    /// Factors that matrix again, if it is another one.
    ///
    /// # Errors
    /// `Factorisation` where the matrix cannot be factored or has another size; there is no factor
    /// then.
    pub(in crate::scheme) fn restore(
        &mut self,
        checkpoint: &FactorCheckpoint,
    ) -> Result<(), LinalgError> {
        let have = self.age.made_for.is_some();
        self.age.made_for = None;
        if !checkpoint.is_empty() {
            if checkpoint.values.len() != self.values.len() {
                return Err(LinalgError::Factorisation {
                    size: self.interleaved.len(),
                    reason: format!(
                        "{} entries are given of {}",
                        checkpoint.values.len(),
                        self.values.len()
                    ),
                });
            }
            let mut pairs = self.values.iter().zip(&checkpoint.values);
            let same = pairs.all(|(have, wanted)| have.to_bits() == wanted.to_bits());
            if !(have && same) {
                self.values.copy_from_slice(&checkpoint.values);
                self.factor.refactor(&self.values)?;
            }
        }
        self.age = checkpoint.age;
        Ok(())
    }

    /// Has the next solve make a new factor.
    pub(in crate::scheme) fn expire(&mut self) {
        self.age.made_for = None;
    }

    fn fill(&mut self, space: &Space, jacobian: &Jacobian, step_mobility: f64, width: f64) {
        let nodes = &space.assembly().pattern;
        let stiffness = &space.stiffness().values;
        let weight = jacobian.weight;
        let mass = |entry: usize, row: usize, column: usize| match space.mass() {
            MassForm::Sparse(matrix) => matrix.values[entry],
            MassForm::Nodal(diagonal) if row == column => diagonal[row],
            MassForm::Nodal(_) => 0.0,
        };
        for row in 0..nodes.size() {
            for (entry, column) in nodes.row(row) {
                let column = column as usize;
                let mass = mass(entry, row, column);
                let mean = 0.5
                    * (jacobian.secant.values[entry]
                        + weight * width * jacobian.tangent.values[entry]);
                // A given φ: its row and its column are those of the identity.
                let (row_free, column_free) = (!self.fixed[row], !self.fixed[column]);
                let both = row_free && column_free;
                let local = match (both, row == column) {
                    (true, _) => jacobian.local.values[entry],
                    (false, same) => f64::from(u8::from(same)),
                };
                let masked = |free: bool, value: f64| if free { value } else { 0.0 };
                let values = [
                    local,
                    masked(row_free, mean),
                    masked(column_free, mean),
                    -step_mobility * stiffness[entry],
                    masked(row_free, -mass),
                    masked(column_free, -mass),
                    -weight * width * mass,
                ];
                for (&position, value) in self.positions[entry].iter().zip(values) {
                    if position != u32::MAX {
                        self.values[position as usize] = value;
                    }
                }
            }
        }
    }
}

impl LinearOperator for FactoredPreconditioner {
    /// From the scaled residuals (r₁, r₂, r₃) to (δφ, δω, δμ).
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let size = self.root_weights.len();
        let (r1, rest) = x.split_at(size);
        let (r2, r3) = rest.split_at(size);
        let [s1, s2, s3] = self.row_scales;
        // It is only used where there is a factor.
        let [_, weight] = self.age.made_for.unwrap_or([0.0, 1.0]);
        for node in 0..size {
            let root = self.root_weights[node];
            let target = &mut self.interleaved[3 * node..][..3];
            target[0] = if self.fixed[node] {
                0.0
            } else {
                root * r2[node] / s2
            };
            target[1] = -weight * root * r3[node] / s3;
            target[2] = -root * r1[node] / s1;
        }
        self.factor.solve_in_place(&mut self.interleaved);
        for node in 0..size {
            for field in 0..3 {
                y[field * size + node] = self.interleaved[3 * node + field];
            }
        }
        fault_injection::tap(Place::Preconditioner, y);
    }
}

/// The linearised system of all three fields, its rows scaled.
pub(in crate::scheme) struct ThreeFieldOperator<'a> {
    pub(in crate::scheme) space: &'a Space,
    pub(in crate::scheme) jacobian: &'a Jacobian,
    pub(in crate::scheme) step_mobility: f64,
    pub(in crate::scheme) width: f64,
    pub(in crate::scheme) fixed: &'a [bool],
    pub(in crate::scheme) row_scales: [f64; 3],
    pub(in crate::scheme) root_weights: &'a [f64],
}

impl LinearOperator for ThreeFieldOperator<'_> {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let size = self.space.nodes();
        let (phi, rest) = x.split_at(size);
        let (omega, mu) = rest.split_at(size);
        let (y1, rest) = y.split_at_mut(size);
        let (y2, y3) = rest.split_at_mut(size);
        let jacobian = self.jacobian;
        y2.fill(0.0);
        for term in &jacobian.rank_one {
            let along = term.scale * vector::dot(&term.row, phi);
            vector::add_scaled(y2, along, &term.column);
        }
        let [s1, s2, s3] = self.row_scales.map(Block::splat);
        let [width, step_mobility] = [self.width, self.step_mobility].map(Block::splat);
        let three = |[k_mu, c_phi, a_omega, t_phi]: [Block; 4],
                     [mass_phi, mass_omega, mass_mu]: [Block; 3],
                     root: Block,
                     extra: Block| {
            let scale = Block::ONE / root;
            [
                s1 * scale * (mass_phi + step_mobility * k_mu),
                s2 * scale * (extra + c_phi + a_omega - mass_mu),
                s3 * scale * width * (mass_omega - t_phi),
            ]
        };
        let k = &self.space.stiffness().values[..];
        let [c, a, t] =
            [&jacobian.local, &jacobian.secant, &jacobian.tangent].map(|it| &it.values[..]);
        let pattern = &self.space.assembly().pattern;
        let outputs = [y1, &mut *y2, y3];
        // The matrices are too large for a near cache: all in one sweep.
        match self.space.mass() {
            MassForm::Sparse(mass) => {
                let m = &mass.values[..];
                let vectors = [mu, phi, omega, phi, phi, omega, mu];
                let products = ([k, c, a, t, m, m, m], vectors);
                let roots = [self.root_weights];
                pattern.sweep(products, roots, outputs, |of, [root], [_, extra, _]| {
                    let [k_mu, c_phi, a_omega, t_phi, mass @ ..] = of;
                    three([k_mu, c_phi, a_omega, t_phi], mass, root, extra)
                });
            }
            MassForm::Nodal(weights) => {
                let products = ([k, c, a, t], [mu, phi, omega, phi]);
                let inputs = [self.root_weights, weights, phi, omega, mu];
                pattern.sweep(products, inputs, outputs, |of, inputs, [_, extra, _]| {
                    let [root, weights, fields @ ..] = inputs;
                    let mass = fields.map(|field| weights * field);
                    three(of, mass, root, extra)
                });
            }
        }
        let fixed = self.fixed.iter().zip(y2);
        fixed
            .filter(|(fixed, _)| **fixed)
            .for_each(|(_, y)| *y = 0.0);
        fault_injection::tap(Place::Product, y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::fem::{Mesh, QuadratureRule};
    use crate::linalg::{Gmres, SparseMatrix};
    use crate::physics::RankOne;

    #[test]
    fn the_three_equations_in_one_sweep_are_those_of_the_matrices() {
        for rule in [QuadratureRule::Consistent, QuadratureRule::Lumped] {
            let mesh = Mesh::structured(5, 0.3, 7).expect("a fair mesh");
            let space = Space::new(Arc::new(mesh), rule);
            let size = space.nodes();
            let wave = |frequency: f64| -> Vec<f64> {
                (0..size)
                    .map(|node| (frequency * node as f64).sin())
                    .collect()
            };
            let mut jacobian = Jacobian::new(&space);
            let fill = |matrix: &mut SparseMatrix, frequency: f64| {
                for row in 0..size {
                    let pattern = matrix.pattern.clone();
                    for (position, column) in pattern.row(row) {
                        matrix.values[position] =
                            (frequency * f64::from(column)).cos() + row as f64;
                    }
                }
            };
            fill(&mut jacobian.local, 1.0);
            fill(&mut jacobian.secant, 2.0);
            fill(&mut jacobian.tangent, 3.0);
            jacobian.rank_one.push(RankOne {
                effect: 1,
                scale: 0.5,
                column: wave(4.0),
                row: wave(5.0),
            });
            let mut fixed = vec![false; size];
            fixed[1] = true;
            let root_weights: Vec<f64> = space.nodal_weights().iter().map(|w| w.sqrt()).collect();
            let (step_mobility, width, row_scales) = (0.3, 0.2, [1.0, 0.7, 0.9]);
            let mut operator = ThreeFieldOperator {
                space: &space,
                jacobian: &jacobian,
                step_mobility,
                width,
                fixed: &fixed,
                row_scales,
                root_weights: &root_weights,
            };
            let [phi, omega, mu] = [0.7, 1.1, 1.3].map(wave);
            let mut y = vec![0.0; 3 * size];
            operator.apply(&[&phi[..], &omega, &mu].concat(), &mut y);

            let mut expected = [vec![0.0; size], vec![0.0; size], vec![0.0; size]];
            space.mass().multiply(&phi, &mut expected[0]);
            space
                .stiffness()
                .multiply_add(step_mobility, &mu, &mut expected[0]);
            jacobian.local.multiply(&phi, &mut expected[1]);
            jacobian.secant.multiply_add(1.0, &omega, &mut expected[1]);
            space.mass().multiply_add(-1.0, &mu, &mut expected[1]);
            let along = 0.5 * vector::dot(&wave(5.0), &phi);
            vector::add_scaled(&mut expected[1], along, &wave(4.0));
            expected[1][1] = 0.0;
            jacobian.tangent.multiply(&phi, &mut expected[2]);
            expected[2].iter_mut().for_each(|entry| *entry *= -width);
            space.mass().multiply_add(width, &omega, &mut expected[2]);
            for (row, y) in y.iter().enumerate() {
                let (field, node) = (row / size, row % size);
                let expected = row_scales[field] * expected[field][node] / root_weights[node];
                assert!(
                    (y - expected).abs() <= 1e-11,
                    "{rule:?} {field} {node}: {y} {expected}"
                );
            }
        }
    }

    /// Where φ's own block is zero the factor is as good as half precision lets it be.
    #[test]
    fn no_pivot_is_taken_where_there_is_none() {
        let mesh = Mesh::structured(16, 0.3, 7).expect("a fair mesh");
        let space = Space::new(Arc::new(mesh), QuadratureRule::Consistent);
        let size = space.nodes();
        let (step_mobility, width) = (1e-8, 0.1);
        // S = (A + εT)/2 is exact.
        let mut jacobian = Jacobian::new(&space);
        let stiffness = &space.stiffness().values;
        jacobian.secant.values.copy_from_slice(stiffness);
        let tangent = jacobian.tangent.values.iter_mut().zip(stiffness);
        tangent.for_each(|(tangent, stiffness)| *tangent = stiffness / width);
        let fixed = vec![false; size];
        let root_weights: Vec<f64> = space.nodal_weights().iter().map(|w| w.sqrt()).collect();
        let row_scales = [1.0; 3];
        let mut preconditioner =
            FactoredPreconditioner::new(&space, fixed.clone()).expect("a small pattern");
        preconditioner
            .prepare(&space, &jacobian, step_mobility, width, row_scales)
            .expect("a factor");
        let mut operator = ThreeFieldOperator {
            space: &space,
            jacobian: &jacobian,
            step_mobility,
            width,
            fixed: &fixed,
            row_scales,
            root_weights: &root_weights,
        };
        let x: Vec<f64> = (0..3 * size).map(|row| (0.1 * row as f64).sin()).collect();
        let outcome = Gmres::new(3 * size, 60)
            .solve(
                &mut operator,
                &mut preconditioner,
                &x,
                &mut vec![0.0; 3 * size],
                1e-6 * vector::norm(&x),
                200,
            )
            .expect("finite");
        assert!(outcome.converged && outcome.iterations <= 12, "{outcome:?}");
    }

    #[test]
    fn a_factor_is_kept_while_it_serves() {
        let age = RefactorPolicy {
            made_for: Some([1e-9, 0.5]),
            last_iterations: STALE_AFTER,
        };
        assert!(!age.must_refresh(1e-9, 0.5) && !age.must_refresh(2.4e-9, 0.5));
        assert!(age.must_refresh(2.6e-9, 0.5) && age.must_refresh(3.9e-10, 0.5));
        assert!(age.must_refresh(1e-9, 1.0), "of the other scheme");
        assert!(
            RefactorPolicy {
                last_iterations: STALE_AFTER + 1,
                ..age
            }
            .must_refresh(1e-9, 0.5)
        );
        assert!(
            RefactorPolicy {
                made_for: None,
                last_iterations: 0
            }
            .must_refresh(1e-9, 0.5)
        );
    }
}
