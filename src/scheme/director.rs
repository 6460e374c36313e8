//! Substep 1: the linear, symmetric positive definite system for dⁿ⁺¹,
//!   (δ, e)/(γ_nem Δt) + Σ_effects ⟨f_d(dⁿ + δ), e⟩ = 0,   δ = dⁿ⁺¹ − dⁿ
//! (z = −δ_t d/γ_nem eliminated), by conjugate gradients: at the paper's Δt it is nearly a mass matrix.
//! It is solved where anything acts on the director ([`ActiveRegion`]); elsewhere δ = 0.

use serde::{Deserialize, Serialize};

use super::StepError;
use super::active_region::{ActiveRegion, Criterion};
use super::fault_injection::{self, Place};
use super::rounding;
use super::strips::{Strip, Strips};
use crate::fem::{LoadEntries, MassForm, MatrixEntries, Space};
use crate::linalg::{
    ConjugateGradients, LinalgError, LinearOperator, SparseMatrix, op_counts, vector,
};
use crate::physics::{Effects, PatchStep};
use crate::scene::TimeScheme;

/// Limit of the conjugate gradients' iterations.
const LIMIT: usize = 2000;

/// The part of the law's tolerance that substep 1 may use up.
const SHARE_OF_LAW: f64 = 0.1;

/// By how much the residual is made smaller where the energy law misses by more than that.
const TIGHTER: f64 = 0.1;

/// Corrections of the secant scheme's director at most, and to what part of the residual each is solved.
const MOST_CORRECTIONS: usize = 15;
const CORRECTION: f64 = 1e-3;

/// The smallest relative residual that is aimed at.
const TIGHTEST: f64 = 1e-15;

/// Substep 1 with its matrices and vectors.
#[derive(Debug)]
pub(super) struct DirectorStep {
    /// γ_nem.
    mobility: f64,
    /// A bound of the eigenvalues of M_L⁻¹ K.
    largest_eigenvalue: f64,
    region: ActiveRegion,
    /// On the region; made when it is.
    work: Option<Workspace>,
    /// δ of this step, on the whole mesh.
    increment: Vec<f64>,
    /// Its Δt.
    length: f64,
    /// The same of the first half of a step of the secant scheme, once the second is solved.
    first: Vec<f64>,
    first_length: Option<f64>,
    past: Increments,
    #[cfg(test)]
    everywhere: bool,
}

/// The increments of the last solves and their Δt, to extrapolate the guess from; newest first.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Increments {
    last: [Vec<f64>; 3],
    lengths: [f64; 3],
    known: usize,
}

impl Increments {
    fn new(size: usize) -> Self {
        Self {
            last: [vec![0.0; size], vec![0.0; size], vec![0.0; size]],
            lengths: [0.0; 3],
            known: 0,
        }
    }

    /// Takes over others. Allocates only where there is no room yet.
    fn copy(&mut self, other: &Self) {
        self.known = other.known;
        self.lengths = other.lengths;
        self.last.clone_from(&other.last);
    }

    /// Takes the newest.
    fn push(&mut self, length: f64, increment: &[f64]) {
        self.last.rotate_right(1);
        self.lengths.rotate_right(1);
        self.last[0].copy_from_slice(increment);
        self.lengths[0] = length;
        self.known = (self.known + 1).min(self.last.len());
    }

    #[cfg(test)]
    pub(super) fn forget(&mut self) {
        self.known = 0;
    }

    /// Whether they are of a director with so many components in all.
    pub(super) fn fits(&self, size: usize) -> bool {
        self.known <= self.last.len()
            && self.last.iter().all(|last| last.len() == size)
            && self.lengths[..self.known].iter().all(|it| *it > 0.0)
    }

    /// With what weights the increments of these lengths, newest first, lead to that of the next solve: by a polynomial
    /// through their rates in the middle of each.
    fn weights(lengths: &[f64], next: f64) -> [f64; 3] {
        let mut weights = [0.0; 3];
        let mut middles = [0.0; 3];
        let mut end = -0.5 * next;
        for (middle, length) in middles.iter_mut().zip(lengths) {
            *middle = end - 0.5 * length;
            end -= length;
        }
        for (index, length) in lengths.iter().enumerate() {
            let own = middles[index];
            let others = (0..lengths.len()).filter(|other| *other != index);
            let factors = others.map(|other| middles[other] / (middles[other] - own));
            weights[index] = next / length * factors.product::<f64>();
        }
        weights
    }
}

/// Weights of a guess whose magnitudes have a larger sum make too much of rounding: that of equal steps is 7.
const MOST_MAGNIFIED: f64 = 16.0;

/// The matrix and the vectors of substep 1 on its region.
#[derive(Debug)]
struct Workspace {
    system: DirectorMatrix,
    load: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    solution: Vec<f64>,
    /// φ, dⁿ and, in the secant scheme, the iterate and the correction that leads to the next.
    phi: Vec<f64>,
    director: [Vec<f64>; 2],
    iterate: [Vec<f64>; 2],
    correction: Vec<f64>,
    /// d_θ.
    implicit: [Vec<f64>; 2],
    /// 1/(γ_nem Δt).
    inertia: f64,
    method: ConjugateGradients,
    strips: Strips,
    load_entries: [Vec<LoadEntries>; 2],
    matrix_entries: [Vec<MatrixEntries>; 3],
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
                axis: (0..)
                    .zip(space.mesh().on_axis())
                    .filter_map(|(node, on)| on.then_some(node))
                    .collect(),
            },
            load: both(),
            inverse_diagonal: both(),
            solution: both(),
            phi: vector(),
            director: [vector(), vector()],
            iterate: [vector(), vector()],
            correction: both(),
            implicit: [vector(), vector()],
            inertia: f64::NAN,
            method: ConjugateGradients::new(2 * space.nodes()),
            strips: Strips::new(space, true),
            load_entries: [(); 2].map(|()| vec![LoadEntries::default(); space.groups()]),
            matrix_entries: [(); 3].map(|()| vec![MatrixEntries::default(); space.groups()]),
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
    /// Nodes where δ_r = 0, for there d_r = 0: those on the axis of rotation.
    axis: Vec<u32>,
}

impl DirectorMatrix {
    /// Makes a vector zero where δ is.
    fn keep(&self, vector: &mut [f64]) {
        let (x, y) = vector.split_at_mut(vector.len() / 2);
        for &node in &self.kept {
            x[node as usize] = 0.0;
            y[node as usize] = 0.0;
        }
        for &node in &self.axis {
            x[node as usize] = 0.0;
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
            largest_eigenvalue: space.largest_eigenvalue(),
            region: ActiveRegion::default(),
            work: None,
            increment: vec![0.0; size],
            length: 0.0,
            first: vec![0.0; size],
            first_length: None,
            past: Increments::new(size),
            #[cfg(test)]
            everywhere: false,
        }
    }

    /// Another γ_nem.
    pub(super) fn set_mobility(&mut self, mobility: f64) {
        self.mobility = mobility;
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

    /// Takes the increments of an accepted step.
    pub(super) fn accept(&mut self) {
        if let Some(length) = self.first_length.take() {
            self.past.push(length, &self.first);
        }
        self.past.push(self.length, &self.increment);
    }

    /// What the guess for the next step is made from.
    pub(super) fn save(&self, past: &mut Increments) {
        past.copy(&self.past);
    }

    /// Puts that back.
    pub(super) fn restore(&mut self, past: &Increments) {
        self.past.copy(past);
    }

    /// The increment that the last ones lead to expect.
    fn guess(&mut self, length: f64) {
        let past = &self.past;
        let first = self.first_length.map(|length| (&self.first, length));
        let known = past.last.iter().zip(past.lengths).take(past.known);
        let known = first.into_iter().chain(known).take(3);
        let mut lengths = [0.0; 3];
        let mut count = 0;
        for (_, length) in known.clone() {
            lengths[count] = length;
            count += 1;
        }
        let mut weights = Increments::weights(&lengths[..count], length);
        while weights.iter().map(|it| it.abs()).sum::<f64>() > MOST_MAGNIFIED && count > 0 {
            count -= 1;
            weights = Increments::weights(&lengths[..count], length);
        }
        self.increment.fill(0.0);
        for (weight, (last, _)) in weights.iter().zip(known) {
            vector::add_scaled(&mut self.increment, *weight, last);
        }
    }

    /// Solves for the new director; returns the iterations.
    pub(super) fn solve(
        &mut self,
        space: &Space,
        effects: &Effects,
        options: SolveOptions,
        (phi, from): (&[f64], &[Vec<f64>; 2]),
        to: &mut [Vec<f64>; 2],
    ) -> Result<u32, StepError> {
        if options.is_second {
            // The guess is made from the first half too.
            self.first.copy_from_slice(&self.increment);
            self.first_length = Some(self.length);
        } else {
            self.first_length = None;
        }
        self.guess(options.dt);
        self.length = options.dt;
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
        work.inertia = (self.mobility * options.dt).recip();
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
        let iterations = match options.scheme {
            TimeScheme::FirstOrder => {
                work.assemble(part, effects, options.scheme, true);
                fault_injection::tap(Place::DirectorLoad, &mut work.load);
                work.solve(options)
            }
            TimeScheme::Secant => work.solve_secant(part, effects, options),
        };
        let iterations = iterations.map_err(StepError::Director)?;
        self.increment.fill(0.0);
        if options.is_faint && work.is_rounding(&work.solution) {
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
            inertia: self.mobility * options.dt,
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
    pub(super) scheme: TimeScheme,
    /// Whether it is the second solve of a step, after substep 2.
    pub(super) is_second: bool,
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

    /// Whether a change of the director is no more than what rounding makes of one at rest.
    fn is_rounding(&self, change: &[f64]) -> bool {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        let [x, y] = &self.director;
        largest(change) <= rounding::CHANGE * largest(x).max(largest(y)).max(1.0)
    }

    /// Solves the secant scheme's equation, which is not linear: each correction is that of the matrix of the first iterate,
    /// in which a bound stands for the derivative of p_sec, and leaves about Δtγ_nem λ_nem/η_d² of what is missing.
    fn solve_secant(
        &mut self,
        space: &Space,
        effects: &Effects,
        options: SolveOptions,
    ) -> Result<u32, LinalgError> {
        let mut iterations = 0;
        let mut is_rounding = false;
        for number in 0..=MOST_CORRECTIONS {
            self.assemble(space, effects, options.scheme, number == 0);
            fault_injection::tap(Place::DirectorLoad, &mut self.load);
            if number > 0 && self.is_solved(space, options, is_rounding) {
                return Ok(iterations);
            }
            self.correction.fill(0.0);
            let solved = self.method.solve(
                &mut self.system,
                &self.inverse_diagonal,
                &self.load,
                &mut self.correction,
                CORRECTION,
                LIMIT,
            )?;
            iterations += solved.iterations as u32;
            is_rounding = self.is_rounding(&self.correction);
            vector::add_scaled(&mut self.solution, 1.0, &self.correction);
        }
        Err(LinalgError::NotConverged {
            method: "the iteration of substep 1",
            iterations: MOST_CORRECTIONS,
            residual: vector::norm(&self.load) / self.inertial_force(space),
            tolerance: options.tolerance,
        })
    }

    /// Whether `load`, the residual at the iterate, is small beside the force, which is what the inertia balances at the
    /// solution, or the last correction was rounding; and the residual is as small as the energy law asks for.
    fn is_solved(&mut self, space: &Space, options: SolveOptions, is_rounding: bool) -> bool {
        let misses = vector::dot(&self.load, &self.solution).abs();
        misses <= SHARE_OF_LAW * options.law_tolerance * options.energy_scale
            && (is_rounding
                || vector::norm(&self.load) <= options.tolerance * self.inertial_force(space))
    }

    /// The norm of Mδ/(γ_nem Δt).
    fn inertial_force(&mut self, space: &Space) -> f64 {
        let nodes = space.nodes();
        for axis in 0..2 {
            let part = axis * nodes..(axis + 1) * nodes;
            space
                .mass()
                .multiply(&self.solution[part.clone()], &mut self.correction[part]);
        }
        self.inertia * vector::norm(&self.correction)
    }

    /// Minus the force at dⁿ, or in the secant scheme at the iterate dⁿ + `solution` and with the inertia; and the matrix,
    /// where it is asked for.
    fn assemble(
        &mut self,
        space: &Space,
        effects: &Effects,
        scheme: TimeScheme,
        with_matrix: bool,
    ) {
        let nodes = space.nodes();
        let is_iterate = scheme == TimeScheme::Secant;
        for axis in 0..2 {
            let steps = &self.solution[axis * nodes..][..nodes];
            let fields = self.iterate[axis].iter_mut().zip(&mut self.implicit[axis]);
            for (((iterate, implicit), old), step) in fields.zip(&self.director[axis]).zip(steps) {
                *iterate = if is_iterate { old + step } else { *old };
                *implicit = scheme.implicit(*old, *iterate);
            }
        }
        self.over_patches(space, effects, scheme, with_matrix);
        self.collect_load(space, is_iterate);
        if with_matrix {
            self.collect_matrix(space);
        }
    }

    /// The entries of all triangles: of the force, and of the matrix where it is asked for.
    fn over_patches(
        &mut self,
        space: &Space,
        effects: &Effects,
        scheme: TimeScheme,
        with_matrix: bool,
    ) {
        let Self {
            phi,
            director,
            iterate,
            implicit,
            load_entries,
            matrix_entries,
            strips,
            ..
        } = self;
        let is_iterate = scheme == TimeScheme::Secant;
        let entries = (
            load_entries.each_mut().map(|entries| &mut entries[..]),
            matrix_entries.each_mut().map(|entries| &mut entries[..]),
        );
        strips.over(space, entries, |patch, _, strip, (of_load, of_matrix)| {
            let Strip {
                old,
                new,
                form,
                room,
                ..
            } = strip;
            old.begin();
            old.set_phi(patch, phi);
            old.set_director(patch, director);
            if is_iterate {
                new.begin();
                new.set_director(patch, iterate);
            }
            form.clear(patch);
            form.with_derivative = with_matrix;
            let step = PatchStep {
                patch,
                old,
                new: if is_iterate { new } else { old },
                scheme,
            };
            for effect in effects.iter() {
                effect.add_director_force(&step, form, room);
            }
            form.add_flux_of_stiffness(&step);
            for (axis, entries) in of_load.into_iter().enumerate() {
                patch.load_entries(&form.load[axis], &form.flux[axis], entries);
                if axis == 0 {
                    patch.add_hoop_entries(&form.hoop, entries);
                }
                if form.has_tensor {
                    for (other, component) in implicit.iter().enumerate() {
                        let row = form.tensor.iter().map(|tensor| tensor[(axis, other)]);
                        patch.add_product_entries(row, component, entries);
                    }
                }
            }
            if with_matrix {
                form.differentiate(scheme);
                let tensors = form.has_tensor.then_some(&form.tensor[..]);
                let weights = (&form.stiffness[..], &form.reaction[..]);
                patch.coupled_entries(weights, tensors, of_matrix);
            }
        });
    }

    /// Minus the force, or minus the residual at an iterate.
    fn collect_load(&mut self, space: &Space, is_iterate: bool) {
        let nodes = space.nodes();
        self.load.fill(0.0);
        for (axis, load) in self.load.chunks_exact_mut(nodes).enumerate() {
            let density = &self.strips.first().form.load[axis];
            space.collect_load(&self.load_entries[axis], density, load);
            if is_iterate {
                let steps = &self.solution[axis * nodes..][..nodes];
                space.mass().multiply_add(self.inertia, steps, load);
            }
        }
        self.load.iter_mut().for_each(|entry| *entry = -*entry);
        self.system.keep(&mut self.load);
    }

    /// The matrix, and the inverse of its diagonal.
    fn collect_matrix(&mut self, space: &Space) {
        op_counts::assemblies(1);
        let (assembly, nodes) = (space.assembly(), space.nodes());
        let form = &self.strips.first().form;
        let [x_entries, y_entries, of_coupling] = &self.matrix_entries;
        let DirectorMatrix {
            blocks: [x, y],
            coupling,
            coupled,
            ..
        } = &mut self.system;
        for block in [&mut x.values[..], &mut y.values] {
            block.fill(0.0);
            let diagonal = &assembly.diagonal;
            space.mass().add_to(self.inertia, diagonal, block);
            space.add_diagonal(&form.reaction, block);
        }
        coupling.clear();
        *coupled = form.has_tensor;
        let blocks = [&x_entries[..], y_entries];
        match coupling {
            _ if !*coupled => assembly.collect_matrices(blocks, [&mut x.values, &mut y.values]),
            MassForm::Nodal(diagonal) => {
                assembly.collect_matrices(blocks, [&mut x.values, &mut y.values]);
                assembly.collect_corners(of_coupling, diagonal);
            }
            MassForm::Sparse(matrix) => {
                let values = [&mut x.values[..], &mut y.values, &mut matrix.values];
                assembly.collect_matrices([x_entries, y_entries, of_coupling], values);
            }
        }
        for (axis, block) in self.system.blocks.iter().enumerate() {
            let inverse = &mut self.inverse_diagonal[axis * nodes..][..nodes];
            for (inverse, &position) in inverse.iter_mut().zip(&assembly.diagonal) {
                *inverse = block.values[position as usize].recip();
            }
        }
    }
}
