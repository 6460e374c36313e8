//! The state on another mesh in mid-run.
//!
//! φ is P1, so its second derivatives are in the kinks at the edges of its mesh: brought to another mesh as a function, those
//! kinks become bending energy, up to a hundred times what there was. ω is −Δφ + G(φ)/ε² as a function, so it is by ω that φ
//! is brought over: the new φ solves
//!
//!   (∇φ, ∇v) = (ω_old − G(φ_old)/ε², v) for all new v,   ∫φ = ∫φ_old,
//!
//! by the quadrature of the run on the new mesh. On the old mesh itself that is the equation of ω: nothing changes there. d
//! is interpolated by quadratics, for linear interpolation smooths it each time (E_nem falls by 0.4 % a transfer, and after
//! fifty of them the vesicle is another one), and never becomes longer than at the corners of a triangle. ω and μ follow from the new φ. The energy law is one of steps: what the energy did
//! here the caller reports.

use std::sync::Arc;

use thiserror::Error;

use super::checkpoint::{RestoreError, SchemeCheckpoint};
use super::initial::keep_to_axis;
use super::{Scheme, space_on};
use crate::fem::{
    FemError, GradientRecovery, Locator, Mesh, Place, QuadratureRule, Space, solve_poisson,
};
use crate::geometry::{Point, Vector};
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
    /// `TransferError`: this scheme is then what it was.
    pub fn on_mesh(&self, mesh: Arc<Mesh>) -> Result<Self, TransferError> {
        let scene = &self.parameters;
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
        let director = director.map(|director| {
            let mut director = interpolated(self.space.mesh(), director, &at_nodes);
            keep_to_axis(space.mesh(), &mut director[0]);
            director
        });
        let parameters = (self.timetable.clone(), scene.clone());
        let fields = (phi, director);
        let mut scheme = Self::on_space(parameters, space, self.initial_area, fields)?;
        scheme.interval = self.interval;
        scheme
            .effects
            .set_interval(self.interval.unwrap_or_default());
        scheme.t = self.t;
        scheme.change_work = self.change_work;
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
        if space.rule() == QuadratureRule::Lumped {
            // The equation of ω holds node by node, and G between nodes is none of its business.
            let source = self.nodal_source(scene);
            let sources = at_points.iter().map(|place| place.value(&source));
            let weights = space.nodal_weights().iter();
            return weights
                .zip(sources)
                .map(|(weight, source)| weight * source)
                .collect();
        }
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

    /// ω − G(φ)/ε² at the nodes of this space, with the lumped rule.
    fn nodal_source(&self, scene: &Scene) -> Vec<f64> {
        let bending = Bending::new(&scene.membrane, &self.space);
        let whole = self.space.whole();
        let mut fields = PatchFields::new(false);
        fields.set_phi(&whole, &self.state.phi);
        let mut source = Vec::new();
        bending.omega_density(&whole, &fields, &mut source);
        let pairs = source.iter_mut().zip(&self.state.omega);
        pairs.for_each(|(source, omega)| *source = omega - *source);
        source
    }

    /// The scheme of the same scene on another mesh, at a checkpoint from there.
    ///
    /// # Errors
    /// `RestoreError`: the checkpoint does not belong to that mesh or this scene.
    pub fn restored_on(
        &self,
        mesh: Arc<Mesh>,
        checkpoint: &SchemeCheckpoint,
    ) -> Result<Self, RestoreError> {
        let fields = checkpoint.fields(mesh.nodes().len())?;
        let space = space_on(mesh, self.parameters.solver.quadrature);
        let parameters = (self.timetable.clone(), self.parameters.clone());
        let mut scheme = Self::on_space(parameters, space, self.initial_area, fields)?;
        scheme.restore(checkpoint)?;
        Ok(scheme)
    }
}

/// A director at places of a mesh.
fn interpolated(mesh: &Mesh, director: &[Vec<f64>; 2], places: &[Place]) -> [Vec<f64>; 2] {
    let mut recovery = GradientRecovery::default();
    let mut components = director.each_ref().map(|component| {
        let gradients = recovery.gradients(mesh, component);
        let value = |place: &Place| place.quadratic_value(mesh, component, gradients);
        places.iter().map(value).collect::<Vec<f64>>()
    });
    let nodes = director[0].iter().zip(&director[1]);
    let lengths: Vec<f64> = nodes.map(|(x, y)| x.hypot(*y)).collect();
    let [x, y] = &mut components;
    for ((x, y), place) in x.iter_mut().zip(y).zip(places) {
        let (length, longest) = (x.hypot(*y), place.greatest(&lengths));
        if length > longest {
            (*x, *y) = (*x * longest / length, *y * longest / length);
        }
    }
    components
}

fn find(locator: &Locator<'_>, place: Point) -> Result<Place, TransferError> {
    let [x, y] = place.into();
    locator.find(place).ok_or(TransferError::Outside { x, y })
}

#[cfg(test)]
mod tests {
    use super::super::{State, initial_fields};
    use super::*;

    /// A circle, with a mesh as fine for it as that of the paper.
    const CIRCLE: &str = r#"
        mesh = { kind = "delaunay", size = 0.024 }
        vesicle = { shape = "circle", radius = 0.25 }
        membrane.interface_width = 0.0288
        nematic.initial = [0.6, 0.8]
        anchoring.kind = "parallel"
        area.target = 1.1
    "#;

    /// The same as a sphere.
    const ROTATED: [&str; 2] = ["domain.geometry=axisymmetric", "vesicle.center=[0.0, 0.5]"];

    fn scheme(settings: &[&str]) -> (Scene, Scheme) {
        let scene = Scene::of_text(CIRCLE, settings);
        let mesh = Mesh::of(&scene).expect("a mesh");
        let initial = initial_fields(&scene, &mesh).expect("initial fields");
        let mut scheme =
            Scheme::new(&scene, mesh, initial.phi, initial.director).expect("a scheme");
        for _ in 0..3 {
            scheme.step(1e-6).expect("a step");
        }
        (scene, scheme)
    }

    fn other_mesh(settings: &[&str]) -> Arc<Mesh> {
        let scene = Scene::of_text(CIRCLE, &[settings, &["mesh.seed=2"]].concat());
        Mesh::of(&scene).expect("a mesh")
    }

    #[test]
    fn on_the_same_mesh_nothing_changes() {
        for settings in [
            &[][..],
            &["solver.quadrature=lumped"],
            &["domain.boundary=clamped"],
            &["membrane.spontaneous_curvature='1.5 + x'"],
            &ROTATED,
        ] {
            let (_, scheme) = scheme(settings);
            let same = scheme.on_mesh(scheme.space().mesh().clone());
            let same = same.expect("a scheme");
            let fields = |scheme: &Scheme| {
                let State { phi, director, .. } = scheme.state();
                let director = director.iter().flatten().flatten();
                phi.iter().chain(director).copied().collect::<Vec<f64>>()
            };
            let pairs = fields(&same).into_iter().zip(fields(&scheme));
            let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-10, "{settings:?}: {worst:.1e}");
            let energies = same.report().energies.iter().zip(&scheme.report().energies);
            for (now, before) in energies {
                let change = (now.value / before.value - 1.0).abs();
                assert!(change < 1e-6, "{settings:?}: {now:?} {before:?}");
            }
        }
    }

    /// ∫φ to rounding and the bending energy to a third, on another mesh of the same size; interpolation raises it many times.
    #[test]
    fn by_omega_the_energy_is_kept_and_by_interpolation_it_is_not() {
        // A sphere has twice the bending energy of the circle, so that what interpolation adds is a smaller part of it.
        for (settings, least) in [
            (&[][..], 2.0),
            (&["domain.boundary=clamped"], 2.0),
            (&ROTATED, 1.5),
        ] {
            let (scene, scheme) = scheme(settings);
            let mesh = other_mesh(settings);
            let there = scheme.on_mesh(mesh.clone()).expect("a scheme");
            let bending = |scheme: &Scheme| scheme.report().energies[0].value;
            let ratio = bending(&there) / bending(&scheme);
            assert!((0.7..1.34).contains(&ratio), "{settings:?}: {ratio}");
            let drift = there.report().phase_integral - scheme.report().phase_integral;
            let integral = scheme.report().phase_integral.abs().max(1.0);
            assert!(drift.abs() < 1e-14 * integral, "{settings:?}: {drift:.1e}");
            let longest = there
                .state()
                .director
                .iter()
                .flat_map(|[x, y]| x.iter().zip(y));
            let longest = longest.map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
            let before = scheme
                .state()
                .director
                .iter()
                .flat_map(|[x, y]| x.iter().zip(y));
            let before = before.map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
            assert!(longest <= before * (1.0 + 1e-14), "{longest} {before}");

            let locator = Locator::new(scheme.space().mesh());
            let places = mesh
                .nodes()
                .iter()
                .map(|node| locator.find(*node).expect("inside"));
            let phi = places
                .map(|place| place.value(&scheme.state().phi))
                .collect();
            let director = there.state().director.clone();
            let interpolated = Scheme::new(&scene, mesh, phi, director).expect("a scheme");
            let ratio = bending(&interpolated) / bending(&scheme);
            assert!(ratio > least, "{settings:?}: {ratio}");
        }
    }
}
