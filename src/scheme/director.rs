//! Substep 1: the linear, symmetric positive definite system for dⁿ⁺¹,
//!   (δ, e)/(γ_nem Δt) + Σ_effects ⟨f_d(dⁿ + δ), e⟩ = 0,   δ = dⁿ⁺¹ − dⁿ
//! (z = −δ_t d/γ_nem eliminated), by conjugate gradients: at the paper's Δt it is nearly a mass matrix.

use super::StepError;
use crate::fem::{MassForm, Space};
use crate::linalg::{ConjugateGradients, LinearOperator, SparseMatrix};
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
    /// δ of this step; on entry the guess, which is that of the last step.
    increment: Vec<f64>,
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
            method: ConjugateGradients::new(size),
        }
    }

    /// Forgets the increment of the last step, the guess for the next.
    pub(super) fn forget(&mut self) {
        self.increment.fill(0.0);
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
        let nodes = space.nodes();
        let (load_x, load_y) = self.load.split_at_mut(nodes);
        for (axis, load) in [load_x, load_y].into_iter().enumerate() {
            load.fill(0.0);
            space.add_flux(&self.form.flux[axis], load);
            space.add_load(&self.form.load[axis], load);
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
        y_block.values.copy_from_slice(&x_block.values);
        let [xx, xy, yy] = &self.form.reaction;
        space.assemble_mass(xx, &mut self.reaction);
        self.reaction
            .add_to(1.0, &assembly.diagonal, &mut x_block.values);
        space.assemble_mass(yy, &mut self.reaction);
        self.reaction
            .add_to(1.0, &assembly.diagonal, &mut y_block.values);
        self.system.coupled = xy.iter().any(|entry| *entry != 0.0);
        if self.system.coupled {
            space.assemble_mass(xy, &mut self.system.coupling);
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
