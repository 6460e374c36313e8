//! Substep 1: the linear, symmetric positive definite system for dⁿ⁺¹,
//!   (δ, e)/(γ_nem Δt) + Σ_effects ⟨f_d(dⁿ + δ), e⟩ = 0,   δ = dⁿ⁺¹ − dⁿ
//! (z = −δ_t d/γ_nem eliminated), by conjugate gradients: at the paper's Δt it is nearly a mass matrix.

use super::StepError;
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
    reaction: MassForm,
    load: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    /// δ of this step.
    increment: Vec<f64>,
    /// Of the last steps, to extrapolate the guess from.
    last_increments: [Vec<f64>; 3],
    steps_known: usize,
    method: ConjugateGradients,
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
    }
}

impl DirectorStep {
    pub(super) fn new(space: &Space, mobility: f64) -> Self {
        let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
        let size = 2 * space.nodes();
        Self {
            mobility,
            form: DirectorForm::new(space),
            system: System {
                blocks: [matrix(), matrix()],
                coupling: space.new_form(),
                coupled: false,
            },
            reaction: space.new_form(),
            load: vec![0.0; size],
            inverse_diagonal: vec![0.0; size],
            increment: vec![0.0; size],
            last_increments: [vec![0.0; size], vec![0.0; size], vec![0.0; size]],
            steps_known: 0,
            method: ConjugateGradients::new(size),
        }
    }

    /// Forgets the increments of the last steps, from which the guess for the next one is made.
    pub(super) fn forget(&mut self) {
        self.steps_known = 0;
    }

    /// Takes the increment of an accepted step.
    pub(super) fn accept(&mut self) {
        self.last_increments.rotate_right(1);
        self.last_increments[0].copy_from_slice(&self.increment);
        self.steps_known = (self.steps_known + 1).min(self.last_increments.len());
    }

    /// The increment that the last ones lead to expect, by a polynomial through them.
    fn guess(&mut self) {
        // Of degree 0, 1 and 2; steps of unequal length make it a worse guess, no more.
        let weights: &[f64] = match self.steps_known {
            0 => &[],
            1 => &[1.0],
            2 => &[2.0, -1.0],
            _ => &[3.0, -3.0, 1.0],
        };
        self.increment.fill(0.0);
        for (weight, last) in weights.iter().zip(&self.last_increments) {
            vector::add_scaled(&mut self.increment, *weight, last);
        }
    }

    /// Solves for the new director; returns the iterations.
    pub(super) fn solve(
        &mut self,
        space: &Space,
        effects: &mut Effects,
        old: &Sample,
        (dt, tolerance): (f64, f64),
        from: &[Vec<f64>; 2],
        to: &mut [Vec<f64>; 2],
    ) -> Result<u32, StepError> {
        self.form.clear();
        for effect in effects.iter_mut() {
            effect.add_director_force(space, old, &mut self.form);
        }
        self.assemble(space, dt);
        self.guess();
        let nodes = space.nodes();
        let (load_x, load_y) = self.load.split_at_mut(nodes);
        for (axis, load) in [load_x, load_y].into_iter().enumerate() {
            load.fill(0.0);
            space.add_flux(&self.form.flux[axis], load);
            space.add_load(&self.form.load[axis], load);
            if self.form.has_tensor {
                for (other, component) in from.iter().enumerate() {
                    space.add_element_product(&self.form.tensor[axis + other], component, load);
                }
            }
            load.iter_mut().for_each(|entry| *entry = -*entry);
        }
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
        for axis in 0..2 {
            let increment = &self.increment[axis * nodes..][..nodes];
            for ((to, from), step) in to[axis].iter_mut().zip(&from[axis]).zip(increment) {
                *to = from + step;
            }
        }
        Ok(solution.iterations as u32)
    }

    fn assemble(&mut self, space: &Space, dt: f64) {
        let assembly = space.assembly();
        let [x_block, y_block] = &mut self.system.blocks;
        x_block.values.fill(0.0);
        assembly.add_weighted_stiffness(space.mesh(), &self.form.stiffness, &mut x_block.values);
        let inertia = (self.mobility * dt).recip();
        space
            .mass()
            .add_to(inertia, &assembly.diagonal, &mut x_block.values);
        space.assemble_mass(&self.form.reaction, &mut self.reaction);
        self.reaction
            .add_to(1.0, &assembly.diagonal, &mut x_block.values);
        y_block.values.copy_from_slice(&x_block.values);
        let [xx, xy, yy] = &self.form.tensor;
        if self.form.has_tensor {
            for (block, tensor) in [(x_block, xx), (y_block, yy)] {
                self.reaction.clear();
                space.add_element_mass(tensor, &mut self.reaction);
                self.reaction
                    .add_to(1.0, &assembly.diagonal, &mut block.values);
            }
        }
        self.system.coupled = self.form.has_tensor;
        if self.system.coupled {
            self.system.coupling.clear();
            space.add_element_mass(xy, &mut self.system.coupling);
        }
        let nodes = space.nodes();
        for (axis, block) in self.system.blocks.iter().enumerate() {
            let inverse = &mut self.inverse_diagonal[axis * nodes..][..nodes];
            for (inverse, &position) in inverse.iter_mut().zip(&assembly.diagonal) {
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
