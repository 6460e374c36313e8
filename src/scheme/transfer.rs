//! The state on another mesh in mid-run.
//!
//! φ is P1, so its second derivatives are in the kinks at the edges of its mesh: brought to another mesh as a function, those
//! kinks become bending energy, up to a hundred times what there was. ω is −Δφ + G(φ)/ε² as a function, so it is by ω that φ
//! is brought over: the new φ solves
//!
//!   (∇φ, ∇v) = (ω_old − G(φ_old)/ε², v) for all new v,   ∫φ = ∫φ_old,
//!
//! by the quadrature of the run on the new mesh. On the old mesh itself that is the equation of ω: nothing changes there. d
//! is interpolated, which keeps |d| ≤ 1. ω and μ follow from the new φ. The energy law is one of steps: what the energy did
//! here the caller reports.

use std::sync::Arc;

use thiserror::Error;

use super::checkpoint::{RestoreError, SchemeCheckpoint};
use super::{Scheme, space_on};
use crate::fem::{FemError, Locator, Mesh, Place, Space, solve_poisson};
use crate::geometry::Vector;
use crate::linalg::{LinalgError, vector};
use crate::physics::{Bending, PatchFields};
use crate::scene::{Boundary, Scene};

/// A state that could not be brought to another mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TransferError {
    /// The new φ could not be solved for.
    #[error(transparent)]
    Phase(#[from] FemError),
    /// A node or a quadrature point of the new mesh is not in the old one.
    #[error("the new mesh has a place at ({x:.6}, {y:.6}) where the old one has no triangle")]
    Outside {
        /// Where.
        x: f64,
        /// Where.
        y: f64,
    },
    /// The linear solver could not be set up on the new mesh.
    #[error("the linear solver: {0}")]
    Factor(#[from] LinalgError),
}

impl Scheme {
    /// The scheme of the same scene on another mesh of the domain, with the present state. Its report has the energies after
    /// the transfer and no ledger. It knows no past, and takes first what steps are to be taken after an event.
    ///
    /// # Errors
    /// [`TransferError`]: this scheme is then what it was.
    pub fn on_mesh(&self, scene: &Scene, mesh: Arc<Mesh>) -> Result<Self, TransferError> {
        let space = space_on(mesh, scene.solver.quadrature);
        let locator = Locator::new(self.space.mesh());
        let find = |place: &_| find(&locator, *place);
        let at_nodes: Vec<Place> = space
            .mesh()
            .nodes()
            .iter()
            .map(find)
            .collect::<Result<_, _>>()?;
        let interpolate = |field: &[f64]| -> Vec<f64> {
            at_nodes.iter().map(|place| place.value(field)).collect()
        };
        let at_points: Vec<Place> = space
            .point_positions()
            .iter()
            .map(find)
            .collect::<Result<_, _>>()?;
        let state = &self.state;
        let phi = solve_poisson(
            &space,
            self.load_of_omega(scene, &space, &at_points),
            self.space.integrate_nodal(&state.phi),
            (scene.boundary == Boundary::Clamped).then_some(-1.0),
            &interpolate(&state.phi),
        )?;
        let director = state.director.as_ref();
        let director = director.map(|d| d.each_ref().map(|component| interpolate(component)));
        let mut scheme = Self::on_space(scene, space, self.initial_area, (phi, director))?;
        scheme.interval = self.interval;
        scheme
            .effects
            .set_interval(self.interval.unwrap_or_default());
        scheme.t = self.t;
        scheme.switched = self.switched;
        scheme.evaluate_present_energies();
        scheme.report.ledger.clear();
        scheme.report.law_residual = 0.0;
        scheme.forget();
        match (self.uses_factor(), scheme.uses_factor()) {
            (true, false) => scheme.membrane.fall_back(&scheme.space)?,
            (false, true) => scheme.membrane.return_to_fast(),
            _ => {}
        }
        scheme.selection = self.selection;
        Ok(scheme)
    }

    /// (ω − G(φ)/ε², v) for all v of another space, whose points are at these places of this one.
    fn load_of_omega(&self, scene: &Scene, space: &Space, at_points: &[Place]) -> Vec<f64> {
        let bending = Bending::new(&scene.membrane, space);
        let whole = space.whole();
        let mut fields = PatchFields::new(false);
        let values = |nodal: &[f64]| at_points.iter().map(|place| place.value(nodal)).collect();
        fields.phi = values(&self.state.phi);
        let mut density: Vec<f64> = values(&self.state.omega);
        let mut nonlinear = Vec::new();
        bending.omega_density(&whole, &fields, &mut nonlinear);
        vector::add_scaled(&mut density, -1.0, &nonlinear);
        let mut load = vec![0.0; space.nodes()];
        space.add_load(
            &density,
            &vec![Vector::zeros(); space.elements()],
            &mut load,
        );
        load
    }

    /// The scheme of the same scene on another mesh, at a checkpoint from there.
    ///
    /// # Errors
    /// [`RestoreError`]: the checkpoint does not belong to that mesh or this scene.
    pub fn restored_on(
        &self,
        scene: &Scene,
        mesh: Arc<Mesh>,
        checkpoint: &SchemeCheckpoint,
    ) -> Result<Self, RestoreError> {
        let fields = checkpoint.fields(mesh.nodes().len())?;
        let space = space_on(mesh, scene.solver.quadrature);
        let mut scheme = Self::on_space(scene, space, self.initial_area, fields)?;
        scheme.restore(checkpoint)?;
        Ok(scheme)
    }
}

fn find(locator: &Locator<'_>, place: crate::geometry::Point) -> Result<Place, TransferError> {
    let [x, y] = place.into();
    locator.find(place).ok_or(TransferError::Outside { x, y })
}
