//! Where substep 1 is solved: the part of the mesh on which anything acts on the director that is worth
//! the work.
//!
//! The effects say how strongly they act, place by place ([`DirectorCoupling`]). A node takes part unless
//! the force is below a limit F on all triangles around it; elsewhere d keeps its last value, which
//! is substep 1 in a smaller space of test functions. Tested with δ, which belongs to that space, its
//! equation gives the same share of the energy law as before, so **the law closes as it did**, to
//! rounding. What is lost is what the director would have gained where it is left alone. Substep 1
//! minimises a quadratic function of δ with a matrix that is at least M/(γ_nem Δt) and M ≥ ¼ M_L (P1,
//! two dimensions), so with the residuals r of the nodes left out that is at most
//!   2 γ_nem Δt Σ r_i²/m_i ≤ 2 γ_nem Δt F² |Ω|,
//! and F is chosen to make it [`LEFT_OUT`]·S. With the consistent rule the mass matrix adds to r_i what
//! the neighbours of a node do, and their force may be larger than F by what the width of a triangle
//! makes of it: some 30 at 1.2 cells an interface. There [`LEFT_OUT_COUPLED`] takes its place, a tenth
//! in F; that this is enough is measured, not proved (`substep_1_leaves_out_what_does_not_matter`).
//!
//! A region has a space and matrices of its own, so that what it costs follows its size. They are made
//! when it changes: **a step in which the vesicle has moved into other blocks of triangles allocates**, and
//! no other does (`only_a_step_with_a_new_region_allocates` counts them).
//!
//! It halves substep 1, and saves a tenth of a run with chosen steps: `vesica run case3 --set time.tolerance=1e-3 --until
//! 1e-4` took 6.1 and 6.3 s of processor with it, 6.8 and 6.9 without, in turn (2026-11-26). And where there is no vesicle
//! the director costs nothing.
//!
//! The region is a function of the present state and Δt alone, not of the regions before: a run that is
//! resumed has the same one.

use crate::fem::{FemError, Mesh, Space};
use crate::physics::{DirectorCoupling, potentials::phase_indicator};

/// What leaving out may change in the energy law of a step, over S.
const LEFT_OUT: f64 = 1e-13;

/// The same where the mass matrix couples neighbours.
const LEFT_OUT_COUPLED: f64 = 1e-15;

/// Triangles that are in or out together.
const BLOCK: usize = 8;

/// The largest share of the mesh for which a part of it is worth having.
const LARGEST_SHARE: f64 = 0.75;

/// When a triangle matters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Criterion {
    /// Of the effects together; `None`: nobody knows, so everything matters.
    pub(super) reach: Option<DirectorCoupling>,
    /// A bound of the eigenvalues of M_L⁻¹ K.
    pub(super) largest_eigenvalue: f64,
    /// A bound of |d|.
    pub(super) length: f64,
    /// The sum of the absolute energies.
    pub(super) energy_scale: f64,
    /// γ_nem Δt.
    pub(super) inertia: f64,
    /// Whether the mass matrix couples neighbours.
    pub(super) coupled: bool,
}

impl Criterion {
    /// (of I(φ), of |∇φ|², limit): a triangle matters where their sum is above the limit.
    fn weights(&self) -> Option<(f64, f64, f64)> {
        let reach = self.reach?;
        // Rounded to a power of two: what changes little from step to step leaves the region alone.
        let length = self.length.max(1.0).log2().ceil().exp2();
        let left_out = if self.coupled {
            LEFT_OUT_COUPLED
        } else {
            LEFT_OUT
        };
        let limit = (0.5 * left_out * self.energy_scale / self.inertia).sqrt();
        let limit = limit.log2().floor().exp2();
        let of_inside = length * (self.largest_eigenvalue * reach.stiffness + reach.inside);
        Some((of_inside, length * reach.at_membrane, limit))
    }
}

/// A part of a space, or the whole of it.
#[derive(Debug, Default)]
pub(super) struct ActiveRegion {
    /// Which blocks of triangles matter; empty before the first step.
    blocks: Vec<bool>,
    /// Those of the present state.
    now: Vec<bool>,
    /// Nodes on which a triangle that matters has a corner, and all triangles of these nodes.
    free: Vec<bool>,
    triangles: Vec<u32>,
    /// Its space; `None`: the whole.
    part: Option<Space>,
    /// The number of each of its nodes in the whole.
    pub(super) nodes: Vec<u32>,
    /// Nodes of the part on its edge, where d keeps its value.
    pub(super) kept: Vec<u32>,
    /// How often a part was made.
    #[cfg(test)]
    pub(super) parts_made: u64,
}

impl ActiveRegion {
    /// Its space.
    pub(super) fn space<'a>(&'a self, whole: &'a Space) -> &'a Space {
        self.part.as_ref().unwrap_or(whole)
    }

    /// Whether nothing acts on the director anywhere.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Brings the region to the present state; whether it is another one now.
    ///
    /// # Errors
    /// None where the mesh itself could be made.
    pub(super) fn follow(
        &mut self,
        whole: &Space,
        phi: &[f64],
        criterion: &Criterion,
    ) -> Result<bool, FemError> {
        let mesh = whole.mesh();
        self.now.clear();
        match criterion.weights() {
            Some(weights) => mark(mesh, phi, weights, &mut self.now),
            None => self
                .now
                .resize(mesh.triangles().len().div_ceil(BLOCK), true),
        }
        if self.now == self.blocks {
            return Ok(false);
        }
        std::mem::swap(&mut self.now, &mut self.blocks);
        let Self {
            free, triangles, ..
        } = self;
        free.clear();
        free.resize(mesh.nodes().len(), false);
        let blocks = mesh.triangles().chunks(BLOCK).zip(&self.blocks);
        for triangle in blocks.filter(|(_, on)| **on).flat_map(|(block, _)| block) {
            for &node in triangle {
                free[node as usize] = true;
            }
        }
        // Every triangle that a free node has.
        triangles.clear();
        triangles.extend(
            (0..)
                .zip(mesh.triangles())
                .filter(|(_, corners)| corners.iter().any(|&node| free[node as usize]))
                .map(|(triangle, _)| triangle),
        );
        if triangles.is_empty() {
            self.part = None;
            self.nodes.clear();
            self.kept.clear();
            return Ok(true);
        }
        if triangles.len() as f64 > LARGEST_SHARE * mesh.triangles().len() as f64 {
            let was_whole = self.part.is_none() && !self.nodes.is_empty();
            if !was_whole {
                self.part = None;
                self.nodes = (0..mesh.nodes().len() as u32).collect();
                self.kept.clear();
            }
            return Ok(!was_whole);
        }
        let (part, nodes) = whole.part(triangles)?;
        self.kept = (0..)
            .zip(&nodes)
            .filter(|(_, node)| !free[**node as usize])
            .map(|(local, _)| local)
            .collect();
        self.part = Some(part);
        #[cfg(test)]
        {
            self.parts_made += 1;
        }
        self.nodes = nodes;
        Ok(true)
    }
}

/// Marks the blocks in which a triangle matters.
fn mark(
    mesh: &Mesh,
    phi: &[f64],
    (of_inside, of_slope, limit): (f64, f64, f64),
    blocks: &mut Vec<bool>,
) {
    let triangles = mesh.triangles().chunks(BLOCK);
    let gradients = mesh.gradients().chunks(BLOCK);
    blocks.extend(triangles.zip(gradients).map(|(triangles, gradients)| {
        triangles.iter().zip(gradients).any(|(corners, gradients)| {
            let [a, b, c] = corners.map(|node| phi[node as usize]);
            let slope = (a - c) * gradients[0] + (b - c) * gradients[1];
            let force =
                of_inside * phase_indicator(a.max(b).max(c)) + of_slope * slope.norm_squared();
            // A NaN is somebody else's to find; it matters.
            force > limit || force.is_nan()
        })
    }));
}
