//! Substep 1: the linear, symmetric positive definite system for dⁿ⁺¹,
//!   (δ, e)/(γ_nem Δt) + Σ_effects ⟨f_d(dⁿ + δ), e⟩ = 0,   δ = dⁿ⁺¹ − dⁿ
//! (z = −δ_t d/γ_nem eliminated), by conjugate gradients: at the paper's Δt it is nearly a mass matrix.
//! It is solved where anything acts on the director ([`ActiveRegion`]); elsewhere δ = 0.

use serde::{Deserialize, Serialize};

use super::StepError;
use super::active_region::{ActiveRegion, Criterion};
use super::fault_injection::{self, Place};
use super::rounding;
use crate::fem::{MassForm, Space};
use crate::linalg::{ConjugateGradients, LinalgError, LinearOperator, SparseMatrix, vector};
use crate::physics::{DirectorForm, Effects, PatchFields};

/// Limit of the conjugate gradients' iterations.
const LIMIT: usize = 2000;

/// The part of the law's tolerance that substep 1 may use up.
const SHARE_OF_LAW: f64 = 0.1;

/// By how much the residual is made smaller where the energy law misses by more than that.
const TIGHTER: f64 = 0.1;

/// The smallest relative residual that is aimed at.
const TIGHTEST: f64 = 1e-15;

/// Substep 1 with its matrices and vectors.
#[derive(Debug)]
pub(super) struct DirectorStep {
    /// γ_nem.
    mobility: f64,
    form: DirectorForm,
    /// A bound of the eigenvalues of M_L⁻¹ K.
    largest_eigenvalue: f64,
    region: ActiveRegion,
    /// On the region; made when it is.
    work: Option<Workspace>,
    /// δ of this step, on the whole mesh.
    increment: Vec<f64>,
    past: Increments,
    /// Whether the next guess is what stands in the place of the new director.
    given: bool,
    #[cfg(test)]
    everywhere: bool,
}

/// The increments of the last steps, to extrapolate the guess from; newest first.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Increments {
    last: [Vec<f64>; 3],
    known: usize,
}

impl Increments {
    fn new(size: usize) -> Self {
        Self {
            last: [vec![0.0; size], vec![0.0; size], vec![0.0; size]],
            known: 0,
        }
    }

    /// Takes over others. Allocates only where there is no room yet.
    fn copy(&mut self, other: &Self) {
        self.known = other.known;
        self.last.clone_from(&other.last);
    }

    #[cfg(test)]
    pub(super) fn forget(&mut self) {
        self.known = 0;
    }

    /// Whether they are of a director with so many components in all.
    pub(super) fn fits(&self, size: usize) -> bool {
        self.known <= self.last.len() && self.last.iter().all(|last| last.len() == size)
    }
}

/// The matrix and the vectors of substep 1 on its region.
#[derive(Debug)]
struct Workspace {
    system: DirectorMatrix,
    load: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    solution: Vec<f64>,
    /// φⁿ and dⁿ.
    phi: Vec<f64>,
    director: [Vec<f64>; 2],
    method: ConjugateGradients,
}

impl Workspace {
    fn new(space: &Space, kept: &[u32]) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        let vector = || vec![0.0; space.nodes()];
        let both = || vec![0.0; 2 * space.nodes()];
        Self {
            system: DirectorMatrix {
                blocks: [matrix(), matrix()],
                coupling: space.new_form(),
                coupled: false,
                kept: kept.to_vec(),
            },
            load: both(),
            inverse_diagonal: both(),
            solution: both(),
            phi: vector(),
            director: [vector(), vector()],
            method: ConjugateGradients::new(2 * space.nodes()),
        }
    }
}

/// The matrix: two diagonal blocks and what couples the components.
#[derive(Debug)]
struct DirectorMatrix {
    blocks: [SparseMatrix; 2],
    coupling: MassForm,
    coupled: bool,
    /// Nodes where δ = 0.
    kept: Vec<u32>,
}

impl DirectorMatrix {
    /// Makes a vector zero where δ is.
    fn keep(&self, vector: &mut [f64]) {
        let (x, y) = vector.split_at_mut(vector.len() / 2);
        for &node in &self.kept {
            x[node as usize] = 0.0;
            y[node as usize] = 0.0;
        }
    }
}

impl LinearOperator for DirectorMatrix {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let (x0, x1) = x.split_at(x.len() / 2);
        let (y0, y1) = y.split_at_mut(x0.len());
        self.blocks[0].multiply(x0, y0);
        self.blocks[1].multiply(x1, y1);
        if self.coupled {
            self.coupling.multiply_add(1.0, x1, y0);
            self.coupling.multiply_add(1.0, x0, y1);
        }
        self.keep(y);
        fault_injection::tap(Place::DirectorProduct, y);
    }
}

impl DirectorStep {
    pub(super) fn new(space: &Space, mobility: f64) -> Self {
        let size = 2 * space.nodes();
        Self {
            mobility,
            form: DirectorForm::default(),
            largest_eigenvalue: space.stiffness().eigenvalue_bound(space.nodal_weights()),
            region: ActiveRegion::default(),
            work: None,
            increment: vec![0.0; size],
            past: Increments::new(size),
            given: false,
            #[cfg(test)]
            everywhere: false,
        }
    }

    /// Forgets the increments of the last steps, from which the guess for the next one is made.
    pub(super) fn forget(&mut self) {
        self.past.known = 0;
    }

    /// Has the next steps be solved on the whole mesh: for tests of the region.
    #[cfg(test)]
    pub(super) fn solve_everywhere(&mut self) {
        self.everywhere = true;
    }

    /// Where the last step was solved.
    #[cfg(test)]
    pub(super) fn region(&self) -> &ActiveRegion {
        &self.region
    }

    /// Whether the next solve starts from what stands in the place of the new director, not from the
    /// last increments.
    pub(super) fn start_from_given(&mut self, given: bool) {
        self.given = given;
    }

    /// Takes the increment of an accepted step.
    pub(super) fn accept(&mut self) {
        let Increments { last, known } = &mut self.past;
        last.rotate_right(1);
        last[0].copy_from_slice(&self.increment);
        *known = (*known + 1).min(last.len());
    }

    /// What the guess for the next step is made from.
    pub(super) fn save(&self, past: &mut Increments) {
        past.copy(&self.past);
    }

    /// Puts that back.
    pub(super) fn restore(&mut self, past: &Increments) {
        self.past.copy(past);
    }

    /// The increment that the last ones lead to expect, by a polynomial through them.
    fn guess(&mut self) {
        // Of degree 0, 1 and 2; steps of unequal length make it a worse guess, no more.
        let weights: &[f64] = match self.past.known {
            0 => &[],
            1 => &[1.0],
            2 => &[2.0, -1.0],
            _ => &[3.0, -3.0, 1.0],
        };
        self.increment.fill(0.0);
        for (weight, last) in weights.iter().zip(&self.past.last) {
            vector::add_scaled(&mut self.increment, *weight, last);
        }
    }

    /// Solves for the new director; returns the iterations.
    pub(super) fn solve(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        old: &mut PatchFields,
        options: SolveOptions,
        (phi, from): (&[f64], &[Vec<f64>; 2]),
        to: &mut [Vec<f64>; 2],
    ) -> Result<u32, StepError> {
        if std::mem::take(&mut self.given) {
            let (x, y) = self.increment.split_at_mut(space.nodes());
            for ((increment, to), from) in [x, y].into_iter().zip(&*to).zip(from) {
                for ((increment, to), from) in increment.iter_mut().zip(to).zip(from) {
                    *increment = to - from;
                }
            }
        } else {
            self.guess();
        }
        let criterion = self.criterion(space, effects, options, from);
        let moved = self
            .region
            .follow(space, phi, &criterion)
            .map_err(StepError::ActiveRegion)?;
        let region = &self.region;
        for (to, from) in to.iter_mut().zip(from) {
            to.copy_from_slice(from);
        }
        if region.is_empty() {
            self.work = None;
            self.increment.fill(0.0);
            return Ok(0);
        }
        let part = region.space(space);
        let work = match &mut self.work {
            Some(work) if !moved => work,
            work => work.insert(Workspace::new(part, &region.kept)),
        };
        gather(&region.nodes, phi, &mut work.phi);
        for (part, whole) in work.director.iter_mut().zip(from) {
            gather(&region.nodes, whole, part);
        }
        let inertia = (self.mobility * options.dt).recip();
        work.assemble(part, effects, old, inertia, &mut self.form);
        fault_injection::tap(Place::DirectorLoad, &mut work.load);

        let nodes = region.nodes.len();
        for axis in 0..2 {
            let whole = &self.increment[axis * space.nodes()..][..space.nodes()];
            gather(
                &region.nodes,
                whole,
                &mut work.solution[axis * nodes..][..nodes],
            );
        }
        work.system.keep(&mut work.solution);
        let iterations = work.solve(options).map_err(StepError::Director)?;
        self.increment.fill(0.0);
        if options.is_faint && work.is_at_rest() {
            return Ok(iterations);
        }
        for axis in 0..2 {
            let steps = &work.solution[axis * nodes..][..nodes];
            let increment = &mut self.increment[axis * space.nodes()..][..space.nodes()];
            for (&node, step) in region.nodes.iter().zip(steps) {
                increment[node as usize] = *step;
                to[axis][node as usize] = from[axis][node as usize] + step;
            }
            fault_injection::tap(Place::Director(axis), &mut to[axis]);
        }
        Ok(iterations)
    }

    /// Where substep 1 is to be solved.
    fn criterion(
        &self,
        space: &Space,
        effects: &Effects,
        options: SolveOptions,
        from: &[Vec<f64>; 2],
    ) -> Criterion {
        let [x, y] = from;
        let squares = x.iter().zip(y).map(|(x, y)| x * x + y * y);
        let reach = effects.director_coupling();
        #[cfg(test)]
        let reach = reach.filter(|_| !self.everywhere);
        Criterion {
            reach,
            largest_eigenvalue: self.largest_eigenvalue,
            length: squares.fold(0.0, f64::max).sqrt(),
            energy_scale: options.energy_scale,
            inertia: self.mobility * options.length,
            coupled: matches!(space.mass(), MassForm::Sparse(_)),
        }
    }

    /// Δt γ_nem ‖z‖² = ‖dⁿ⁺¹ − dⁿ‖²/(γ_nem Δt).
    pub(super) fn dissipation(&self, space: &Space, dt: f64) -> f64 {
        let (x, y) = self.increment.split_at(space.nodes());
        let squares = space.mass().quadratic_form(x) + space.mass().quadratic_form(y);
        squares / (self.mobility * dt)
    }
}

/// What a step asks of substep 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct SolveOptions {
    /// Δt.
    pub(super) dt: f64,
    /// The Δt of the whole step where this is a part of it: the region is that of the whole step, or it
    /// would be rebuilt with every part.
    pub(super) length: f64,
    /// Relative residual of the solution.
    pub(super) tolerance: f64,
    /// solver.law_tolerance.
    pub(super) law_tolerance: f64,
    /// Whether the energies are no more than what the energy law can resolve: the director may be at rest.
    pub(super) is_faint: bool,
    /// The sum of the absolute energies.
    pub(super) energy_scale: f64,
}

/// The values of some nodes.
fn gather(nodes: &[u32], whole: &[f64], part: &mut [f64]) {
    for (value, &node) in part.iter_mut().zip(nodes) {
        *value = whole[node as usize];
    }
}

impl Workspace {
    /// Solves for δ to the tolerance, and as much further as the energy law asks for; returns the
    /// iterations.
    ///
    /// With the residual r the law misses by rᵀδ. The scale of the law is at least half of the energies and bᵀδ, the
    /// work of all forces b at dⁿ: what part of it does not come from outside is a change of the energies.
    fn solve(&mut self, options: SolveOptions) -> Result<u32, LinalgError> {
        let mut tolerance = options.tolerance;
        let mut iterations = 0;
        loop {
            let solved = self.method.solve(
                &mut self.system,
                &self.inverse_diagonal,
                &self.load,
                &mut self.solution,
                tolerance,
                LIMIT,
            )?;
            iterations += solved.iterations as u32;
            let misses = vector::dot(self.method.residual(), &self.solution).abs();
            let scale = options.energy_scale + vector::dot(&self.load, &self.solution).abs();
            let is_closed = misses <= SHARE_OF_LAW * options.law_tolerance * scale;
            if is_closed || tolerance <= TIGHTEST {
                return Ok(iterations);
            }
            tolerance = (TIGHTER * tolerance).max(TIGHTEST);
        }
    }

    /// Whether δ is no more than what rounding makes of a director at rest.
    fn is_at_rest(&self) -> bool {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        let [x, y] = &self.director;
        largest(&self.solution) <= rounding::CHANGE * largest(x).max(largest(y)).max(1.0)
    }

    /// The matrix, and minus the force at dⁿ.
    fn assemble(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        old: &mut PatchFields,
        inertia: f64,
        form: &mut DirectorForm,
    ) {
        let nodes = space.nodes();
        let [x_block, y_block] = &mut self.system.blocks;
        let blocks = [&mut x_block.values[..], &mut y_block.values[..]];
        let coupling = &mut self.system.coupling;
        for block in blocks {
            block.fill(0.0);
            space
                .mass()
                .add_to(inertia, &space.assembly().diagonal, block);
        }
        coupling.clear();
        self.system.coupled = false;
        self.load.fill(0.0);
        let (load_x, load_y) = self.load.split_at_mut(nodes);
        for patch in space.patches() {
            old.begin();
            old.set_phi(&patch, &self.phi);
            old.set_director(&patch, &self.director);
            form.clear(&patch);
            for effect in effects.iter_mut() {
                effect.add_director_force(&patch, old, form);
            }
            let tensors = form.has_tensor.then_some(&*form.tensor);
            for (axis, load) in [&mut *load_x, &mut *load_y].into_iter().enumerate() {
                patch.add_load(&form.load[axis], &form.flux[axis], load);
                if let Some(tensors) = tensors {
                    for (other, component) in self.director.iter().enumerate() {
                        let row = tensors.iter().map(|tensor| tensor[(axis, other)]);
                        patch.add_element_product(row, component, load);
                    }
                }
            }
            patch.add_coupled(
                (&form.stiffness, &form.reaction),
                tensors,
                [&mut x_block.values, &mut y_block.values],
                coupling,
            );
            self.system.coupled |= form.has_tensor;
        }
        self.load.iter_mut().for_each(|entry| *entry = -*entry);
        self.system.keep(&mut self.load);
        for (axis, block) in self.system.blocks.iter().enumerate() {
            let inverse = &mut self.inverse_diagonal[axis * nodes..][..nodes];
            for (inverse, &position) in inverse.iter_mut().zip(&space.assembly().diagonal) {
                *inverse = block.values[position as usize].recip();
            }
        }
    }
}
