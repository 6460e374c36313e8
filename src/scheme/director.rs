//! Substep 1: the linear, symmetric positive definite system for dⁿ⁺¹,
//!   (δ, e)/(γ_nem Δt) + Σ_effects ⟨f_d(dⁿ + δ), e⟩ = 0,   δ = dⁿ⁺¹ − dⁿ
//! (z = −δ_t d/γ_nem eliminated), by conjugate gradients: at the paper's Δt it is nearly a mass matrix.

use serde::{Deserialize, Serialize};

use super::StepError;
use super::faults::{self, Place};
use crate::fem::{MassForm, Space};
use crate::linalg::{ConjugateGradients, LinearOperator, SparseMatrix, vector};
use crate::physics::{DirectorForm, Effects, Sample};

/// Limit of the conjugate gradients' iterations.
const LIMIT: usize = 2000;

/// Substep 1 with its matrices and vectors.
#[derive(Debug)]
pub(super) struct DirectorStep {
    /// γ_nem.
    mobility: f64,
    form: DirectorForm,
    system: System,
    load: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    /// δ of this step.
    increment: Vec<f64>,
    past: Increments,
    method: ConjugateGradients,
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
        for (target, source) in self.last.iter_mut().zip(&other.last) {
            target.clone_from(source);
        }
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

/// The matrix: two diagonal blocks and what couples the components.
#[derive(Debug)]
struct System {
    blocks: [SparseMatrix; 2],
    coupling: MassForm,
    coupled: bool,
}

impl LinearOperator for System {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let (x0, x1) = x.split_at(x.len() / 2);
        let (y0, y1) = y.split_at_mut(x0.len());
        self.blocks[0].multiply(x0, y0);
        self.blocks[1].multiply(x1, y1);
        if self.coupled {
            self.coupling.multiply_add(1.0, x1, y0);
            self.coupling.multiply_add(1.0, x0, y1);
        }
        faults::tap(Place::DirectorProduct, y);
    }
}

impl DirectorStep {
    pub(super) fn new(space: &Space, mobility: f64) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        let size = 2 * space.nodes();
        Self {
            mobility,
            form: DirectorForm::default(),
            system: System {
                blocks: [matrix(), matrix()],
                coupling: space.new_form(),
                coupled: false,
            },
            load: vec![0.0; size],
            inverse_diagonal: vec![0.0; size],
            increment: vec![0.0; size],
            past: Increments::new(size),
            method: ConjugateGradients::new(size),
        }
    }

    /// Forgets the increments of the last steps, from which the guess for the next one is made.
    pub(super) fn forget(&mut self) {
        self.past.known = 0;
    }

    /// Takes the increment of an accepted step.
    pub(super) fn accept(&mut self) {
        let Increments { last, known } = &mut self.past;
        last.rotate_right(1);
        last[0].copy_from_slice(&self.increment);
        *known = (*known + 1).min(last.len());
    }

    /// What the guess for the next step is made from.
    pub(super) fn remember(&self, past: &mut Increments) {
        past.copy(&self.past);
    }

    /// Puts that back.
    pub(super) fn recall(&mut self, past: &Increments) {
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
        old: &mut Sample,
        (dt, tolerance): (f64, f64),
        (phi, from): (&[f64], &[Vec<f64>; 2]),
        to: &mut [Vec<f64>; 2],
    ) -> Result<u32, StepError> {
        self.assemble(space, effects, old, dt, (phi, from));
        faults::tap(Place::DirectorLoad, &mut self.load);
        self.guess();
        let solution = self
            .method
            .solve(
                &mut self.system,
                &self.inverse_diagonal,
                &self.load,
                &mut self.increment,
                tolerance,
                LIMIT,
            )
            .map_err(StepError::Director)?;
        let nodes = space.nodes();
        for axis in 0..2 {
            let increment = &self.increment[axis * nodes..][..nodes];
            for ((to, from), step) in to[axis].iter_mut().zip(&from[axis]).zip(increment) {
                *to = from + step;
            }
            faults::tap(Place::Director(axis), &mut to[axis]);
        }
        Ok(solution.iterations as u32)
    }

    /// The matrix, and minus the force at dⁿ.
    fn assemble(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        old: &mut Sample,
        dt: f64,
        (phi, director): (&[f64], &[Vec<f64>; 2]),
    ) {
        let nodes = space.nodes();
        let inertia = (self.mobility * dt).recip();
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
        let form = &mut self.form;
        for patch in space.patches() {
            old.begin();
            old.set_phi(&patch, phi);
            old.set_director(&patch, director);
            form.clear(&patch);
            for effect in effects.iter_mut() {
                effect.add_director_force(&patch, old, form);
            }
            let tensor = form
                .has_tensor
                .then(|| form.tensor.each_ref().map(|entries| &entries[..]));
            for (axis, load) in [&mut *load_x, &mut *load_y].into_iter().enumerate() {
                patch.add_load(&form.load[axis], &form.flux[axis], load);
                if let Some(tensor) = tensor {
                    for (other, component) in director.iter().enumerate() {
                        patch.add_element_product(tensor[axis + other], component, load);
                    }
                }
            }
            patch.add_coupled(
                (&form.stiffness, &form.reaction),
                tensor,
                [&mut x_block.values, &mut y_block.values],
                coupling,
            );
            self.system.coupled |= form.has_tensor;
        }
        self.load.iter_mut().for_each(|entry| *entry = -*entry);
        for (axis, block) in self.system.blocks.iter().enumerate() {
            let inverse = &mut self.inverse_diagonal[axis * nodes..][..nodes];
            for (inverse, &position) in inverse.iter_mut().zip(&space.assembly().diagonal) {
                *inverse = block.values[position as usize].recip();
            }
        }
    }

    /// Δt γ_nem ‖z‖² = ‖dⁿ⁺¹ − dⁿ‖²/(γ_nem Δt).
    pub(super) fn dissipation(&self, space: &Space, dt: f64) -> f64 {
        let (x, y) = self.increment.split_at(space.nodes());
        let squares = space.mass().quadratic_form(x) + space.mass().quadratic_form(y);
        squares / (self.mobility * dt)
    }
}
