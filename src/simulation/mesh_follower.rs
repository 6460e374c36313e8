//! A mesh that follows the membrane: when it is made again, and what happens to the run then.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::event::{EnergyChange, MeshChange};
use super::warnings::NearWall;
use super::{Event, EventKind, Pacing, Simulation, SimulationError};
use crate::fem::{Contour, Mesh};
use crate::geometry::{Point, Segment, SegmentGrid};
use crate::scene::{self, MeshSize, Refinement, Scene};
use crate::scheme::{RestoreError, Scheme, SchemeCheckpoint, TransferError};

/// The inner part of the band: the mesh is made again when the membrane has left it.
const INNER: f64 = 0.5;

/// The mesh is made again, coarser, when the membrane has become shorter by this factor: pieces of it have gone.
const SHRUNK: f64 = 0.7;

/// For which membrane the present mesh was made.
#[derive(Debug)]
pub(super) struct MeshFollower {
    refine: Refinement,
    membrane: SegmentGrid,
    length: f64,
    /// How often the mesh was made again.
    transfers: u64,
    /// The present membrane.
    contour: Contour,
}

impl MeshFollower {
    /// That of a run whose mesh follows the membrane, at its start.
    pub(super) fn of(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> Option<Self> {
        let scene::Mesh::Adaptive { refine, .. } = scene.mesh else {
            return None;
        };
        let contour = Contour::new(mesh, phi);
        Some(Self::new(refine, contour.segments, 0))
    }

    fn new(refine: Refinement, membrane: Vec<Segment>, transfers: u64) -> Self {
        let lengths = membrane.iter().map(|[a, b]| crate::geometry::length(b - a));
        Self {
            refine,
            length: lengths.sum(),
            membrane: SegmentGrid::new(membrane, INNER * refine.band),
            transfers,
            contour: Contour::default(),
        }
    }

    /// Whether the membrane of φ is no longer where the mesh was made for it.
    fn has_left(&mut self, mesh: &Mesh, phi: &[f64]) -> bool {
        self.contour.trace(mesh, phi);
        let segments = &self.contour.segments;
        // Where there is none left there is nothing to follow.
        !segments.is_empty()
            && (self.contour.length() < SHRUNK * self.length
                || segments
                    .iter()
                    .flatten()
                    .any(|place| !self.membrane.is_near(*place)))
    }

    /// For the checkpoint of a run on this mesh.
    pub(super) fn save(&self, mesh: &Arc<Mesh>) -> FollowerCheckpoint {
        FollowerCheckpoint {
            mesh: mesh.clone(),
            membrane: self.membrane.segments().to_vec(),
            transfers: self.transfers,
        }
    }
}

/// The present mesh of a run, and for which membrane it was made.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Plain", into = "Plain")]
pub(super) struct FollowerCheckpoint {
    mesh: Arc<Mesh>,
    membrane: Vec<Segment>,
    transfers: u64,
}

/// What is stored of it.
#[derive(Serialize, Deserialize)]
struct Plain {
    nodes: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
    membrane: Vec<[[f64; 2]; 2]>,
    transfers: u64,
}

impl From<FollowerCheckpoint> for Plain {
    fn from(checkpoint: FollowerCheckpoint) -> Self {
        let FollowerCheckpoint {
            mesh,
            membrane,
            transfers,
        } = checkpoint;
        Self {
            nodes: mesh.nodes().iter().map(|node| (*node).into()).collect(),
            triangles: mesh.triangles().to_vec(),
            membrane: membrane.iter().map(|ends| ends.map(Into::into)).collect(),
            transfers,
        }
    }
}

impl TryFrom<Plain> for FollowerCheckpoint {
    type Error = String;

    /// Bytes of a damaged file may be anything: a triangulation of the unit square is wanted.
    fn try_from(plain: Plain) -> Result<Self, String> {
        let count = plain.nodes.len();
        let mut is_used = vec![false; count];
        for node in plain.triangles.iter().flatten() {
            let used = is_used.get_mut(*node as usize);
            *used.ok_or_else(|| format!("its mesh has no node {node}"))? = true;
        }
        let is_in_square = |place: &[f64; 2]| place.iter().all(|x| (0.0..=1.0).contains(x));
        if is_used.contains(&false)
            || !plain.nodes.iter().all(is_in_square)
            || !plain.membrane.iter().flatten().all(is_in_square)
        {
            return Err("its mesh is not one of the unit square".to_owned());
        }
        let nodes = plain.nodes.into_iter().map(Point::from).collect();
        let mesh = Mesh::new(nodes, plain.triangles).map_err(|error| error.to_string())?;
        let area: f64 = mesh.areas().iter().sum();
        if (area - 1.0).abs() > 1e-9 {
            return Err(format!("its mesh has the area {area}, not 1"));
        }
        let membrane = plain.membrane.into_iter();
        Ok(Self {
            mesh: Arc::new(mesh),
            membrane: membrane.map(|ends| ends.map(Point::from)).collect(),
            transfers: plain.transfers,
        })
    }
}

impl Simulation {
    /// Makes the mesh again if it is to follow the membrane and that has moved too far.
    ///
    /// # Errors
    /// `Transfer`: the mesh cannot be made, or the state not be brought there; the run is where it was.
    pub(super) fn follow_membrane(&mut self) -> Result<(), SimulationError> {
        let phi = &self.scheme.state().phi;
        let follower = self.follower.as_mut();
        if follower.is_some_and(|follower| follower.has_left(&self.mesh, phi)) {
            self.renew_mesh()?;
        }
        Ok(())
    }

    /// Makes the mesh again for the membrane as it is, and brings the state there: between two steps, wherever the
    /// membrane is. The report then has the energies after that. Without a mesh that follows the membrane, or a
    /// membrane, or within a step that was interrupted, nothing happens; returns whether it did.
    ///
    /// # Errors
    /// `Transfer`: the mesh cannot be made, or the state not be brought there; the run is where it was.
    pub fn renew_mesh(&mut self) -> Result<bool, SimulationError> {
        let scene::Mesh::Adaptive { size, seed, refine } = self.scene.mesh else {
            return Ok(false);
        };
        let transfers = self.follower.as_ref().map_or(0, |it| it.transfers) + 1;
        let membrane = Contour::new(&self.mesh, &self.scheme.state().phi).segments;
        if membrane.is_empty() || self.left.is_some() || self.last_whole.is_some() {
            return Ok(false);
        }
        let size = MeshSize::about(size, refine, &membrane);
        let made = self
            .mesh
            .adapted(&size, seed.wrapping_add(transfers))
            .map_err(TransferError::Phase)
            .and_then(|mesh| Ok((self.scheme.on_mesh(&self.scene, mesh.clone())?, mesh)));
        let (step, t) = (self.report.step, self.report.t);
        let (scheme, mesh) =
            made.map_err(|source| SimulationError::Transfer { step, t, source })?;
        let change = MeshChange {
            nodes: [&self.mesh, &mesh].map(|mesh| mesh.nodes().len()),
            energies: EnergyChange::all(self.scheme.report(), scheme.report()),
            total: [&self.scheme, &scheme].map(|scheme| scheme.report().total_energy),
        };
        self.adopt(mesh, scheme);
        let phi = &self.scheme.state().phi;
        let membrane = Contour::new(&self.mesh, phi).segments;
        self.follower = Some(MeshFollower::new(refine, membrane, transfers));
        if let Pacing::Chosen(controller) = &mut self.pacing {
            controller.expect_kick();
        }
        self.report.take(self.scheme.report());
        let kind = EventKind::MeshChanged(Box::new(change));
        self.events.push(Event { step, t, kind });
        Ok(true)
    }

    /// Goes on with another scheme, on another mesh.
    fn adopt(&mut self, mesh: Arc<Mesh>, scheme: Scheme) {
        let was_reached = self.near_wall.reached();
        self.near_wall = NearWall::new(&mesh, self.scene.membrane.interface_width);
        self.near_wall.set_reached(was_reached);
        (self.mesh, self.scheme) = (mesh, scheme);
    }

    /// Restores a scheme on the mesh that it was on.
    ///
    /// # Errors
    /// [`RestoreError`]: the checkpoint is of another scene. Nothing is changed.
    pub(super) fn restore_on(
        &mut self,
        checkpoint: &SchemeCheckpoint,
        follower: Option<&FollowerCheckpoint>,
    ) -> Result<(), RestoreError> {
        let (Some(stored), Some(own)) = (follower, &self.follower) else {
            return match (follower, &self.follower) {
                (None, None) => self.scheme.restore(checkpoint),
                _ => Err(RestoreError::Foreign("its mesh is of another kind")),
            };
        };
        let (refine, mesh) = (own.refine, stored.mesh.clone());
        let is_same = |(one, other): (&Mesh, &Mesh)| {
            one.nodes() == other.nodes() && one.triangles() == other.triangles()
        };
        if is_same((&mesh, &self.mesh)) {
            self.scheme.restore(checkpoint)?;
        } else {
            let scheme = self
                .scheme
                .restored_on(&self.scene, mesh.clone(), checkpoint)?;
            self.adopt(mesh, scheme);
        }
        let membrane = stored.membrane.clone();
        self.follower = Some(MeshFollower::new(refine, membrane, stored.transfers));
        Ok(())
    }
}
