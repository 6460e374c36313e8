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

/// The inner part of the band: the mesh is made again when the membrane has left it. Case 3 with edges of 0.0095, a band of 0.03
/// and two seeds has the errors 8.3e-3 and 6.5e-3 with a third, and 1.2e-2 and 1.1e-2 with two fifths.
const INNER: f64 = 1.0 / 3.0;

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
            .and_then(|mesh| Ok((self.scheme.on_mesh(mesh.clone())?, mesh)));
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
        self.measure();
        self.vesicles.forget();
        self.vesicles.changes();
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
        let (refine, mesh) = (own.refine, Mesh::clone(&stored.mesh));
        let mesh = Arc::new(mesh.in_geometry(self.scene.geometry));
        let is_same = |(one, other): (&Mesh, &Mesh)| {
            one.nodes() == other.nodes() && one.triangles() == other.triangles()
        };
        if is_same((&mesh, &self.mesh)) {
            self.scheme.restore(checkpoint)?;
        } else {
            let scheme = self.scheme.restored_on(mesh.clone(), checkpoint)?;
            self.adopt(mesh, scheme);
        }
        let membrane = stored.membrane.clone();
        self.follower = Some(MeshFollower::new(refine, membrane, stored.transfers));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Report, SimulationCheckpoint};

    /// Drawn to the right, on a mesh that is coarse for it.
    const PULLED: &str = r#"
        mesh = { kind = "adaptive", size = 0.2, interface = 0.035, band = 0.1 }
        vesicle = { shape = "ellipse", half_axes = [0.2, 0.15], center = [0.35, 0.5], angle = 70 }
        membrane.interface_width = 0.05
        area.target = 1.0
        nematic.initial = [0.6, 0.8]
        anchoring.kind = "parallel"
        pull.potential = "3000*x"
        time = { step = 4e-5, end = 1 }
    "#;

    fn simulation(settings: &[&str]) -> Simulation {
        Simulation::new(&Scene::of_text(PULLED, settings)).expect("a run")
    }

    fn transfers(simulation: &mut Simulation) -> Vec<Event> {
        let mut events = simulation.drain_events();
        events.retain(|event| matches!(event.kind, EventKind::MeshChanged(_)));
        events
    }

    /// Takes steps; what the reports say, but for the clock.
    fn run(simulation: &mut Simulation, steps: usize) -> Vec<Report> {
        let step = |_| {
            let mut report = simulation.advance().expect("a step").clone();
            report.costs = Default::default();
            report
        };
        (0..steps).map(step).collect()
    }

    /// The edges at the membrane, over the wanted length.
    fn edges_at_membrane(simulation: &Simulation) -> [f64; 2] {
        let (mesh, phi) = (simulation.mesh(), &simulation.state().phi);
        let mut edges = Vec::new();
        for corners in mesh.triangles() {
            let inside = corners.map(|node| phi[node as usize] > 0.0);
            if inside.contains(&true) && inside.contains(&false) {
                let [a, b, c] = corners.map(|node| mesh.nodes()[node as usize]);
                edges.extend([b - a, c - b, a - c].map(crate::geometry::length));
            }
        }
        let mean = edges.iter().sum::<f64>() / edges.len() as f64;
        [mean, edges.iter().copied().fold(0.0, f64::max)].map(|edge| edge / 0.035)
    }

    /// The law closes in every step, from the energies that the event has, and from no others; ∫φ is kept to rounding.
    #[test]
    fn the_mesh_follows_and_the_law_closes() {
        for settings in [
            &["time.tolerance=3e-2"][..],
            &[],
            &["solver.quadrature=lumped"],
        ] {
            let mut simulation = simulation(settings);
            let (start, integral) = (simulation.axis_center(), simulation.report().phase_integral);
            let mut before = simulation.report().clone();
            let mut count = 0;
            for _ in 0..60 {
                simulation.advance().expect("a step");
                let report = simulation.report().clone();
                let mut from = before.total_energy;
                if let [event] = &transfers(&mut simulation)[..] {
                    let EventKind::MeshChanged(change) = &event.kind else {
                        unreachable!("only those are kept");
                    };
                    count += 1;
                    assert_eq!((event.step, event.t), (before.step, before.t));
                    assert_eq!(change.total[0], from);
                    assert_eq!(change.nodes[1], simulation.mesh().nodes().len());
                    let jump: f64 = change
                        .energies
                        .iter()
                        .map(|it| it.values[1] - it.values[0])
                        .sum();
                    let total = change.total[1] - change.total[0];
                    assert!((jump - total).abs() < 1e-9 * from.abs(), "{change}");
                    // Started from before the transfer it would not close.
                    assert!(total.abs() > 1e-8 * report.law_scale(), "{change}");
                    from = change.total[1];
                }
                let ledger = &report.ledger;
                let change = ledger
                    .iter()
                    .find(|term| term.name == "dE")
                    .map(|term| term.value);
                let change = change.expect("the change of the energy");
                let error = (change - (report.total_energy - from)).abs();
                assert!(error < 1e-10 * report.law_scale(), "{error:.1e}");
                assert!(report.law_residual.abs() < 1e-8);
                assert!((report.phase_integral - integral).abs() < 1e-13);
                before = report;
            }
            assert!(count >= 1, "{settings:?}: {count} transfers");
            assert!(simulation.axis_center() - start > 0.03);
            let [mean, longest] = edges_at_membrane(&simulation);
            assert!(
                mean < 1.2 && longest < 2.0,
                "{settings:?}: {mean} {longest}"
            );
        }
    }

    impl Simulation {
        /// The middle of the vesicle along x.
        fn axis_center(&self) -> f64 {
            let contour = Contour::new(&self.mesh, &self.scheme.state().phi);
            let ends = contour.segments.iter().flatten().map(|end| end.x);
            let [low, high] = ends.fold([1.0_f64, 0.0_f64], |[low, high], x| {
                [low.min(x), high.max(x)]
            });
            0.5 * (low + high)
        }
    }

    #[test]
    fn a_run_goes_on_bit_for_bit_from_a_mesh_of_its_own() {
        for settings in [&["time.tolerance=3e-2"][..], &[]] {
            let mut first = simulation(settings);
            let at_start = over_bytes(&first);
            run(&mut first, 2);
            assert_eq!(first.renew_mesh(), Ok(true));
            run(&mut first, 3);
            assert_eq!(transfers(&mut first).len(), 1);
            let checkpoint = over_bytes(&first);
            let mut second = simulation(settings);
            assert_ne!(second.mesh().nodes(), first.mesh().nodes());
            second.restore(&checkpoint).expect("the same scene");
            assert_eq!(second.mesh().nodes(), first.mesh().nodes());
            assert_eq!(second.report().vesicles, first.report().vesicles);
            for simulation in [&mut first, &mut second] {
                run(simulation, 2);
                assert_eq!(simulation.renew_mesh(), Ok(true));
            }
            assert_eq!(run(&mut first, 3), run(&mut second, 3));
            assert!(first.state() == second.state());
            assert_eq!(first.mesh().triangles(), second.mesh().triangles());
            assert_eq!(transfers(&mut first), transfers(&mut second));
            // Back to the first mesh, from the second.
            second.restore(&at_start).expect("the same scene");
            let mut third = simulation(settings);
            assert_eq!(run(&mut second, 2), run(&mut third, 2));
            assert!(second.state() == third.state());
        }
        let other = simulation(&["mesh={ kind = 'delaunay', size = 0.1 }"]);
        let mut own = simulation(&[]);
        let outcome = own.restore(&over_bytes(&other));
        assert!(
            matches!(outcome, Err(RestoreError::Foreign(_))),
            "{outcome:?}"
        );
    }

    fn over_bytes(simulation: &Simulation) -> SimulationCheckpoint {
        let mut checkpoint = SimulationCheckpoint::default();
        simulation.save(&mut checkpoint);
        let bytes = postcard::to_stdvec(&checkpoint).expect("bytes");
        postcard::from_bytes(&bytes).expect("a checkpoint")
    }

    #[test]
    fn a_damaged_mesh_is_refused() {
        let simulation = simulation(&[]);
        let follower = simulation.follower.as_ref().expect("it follows");
        let plain = || Plain::from(follower.save(simulation.mesh()));
        assert!(FollowerCheckpoint::try_from(plain()).is_ok());
        let damages: [fn(&mut Plain); 6] = [
            |plain| plain.triangles[3][1] = u32::MAX,
            |plain| plain.triangles[3].swap(0, 1),
            |plain| plain.nodes[5] = [f64::NAN, 0.5],
            |plain| plain.nodes.push([0.5, 0.5]),
            |plain| plain.membrane[0][1] = [1e300, 0.0],
            |plain| plain.triangles.truncate(20),
        ];
        for (number, damage) in damages.into_iter().enumerate() {
            let mut damaged = plain();
            damage(&mut damaged);
            assert!(FollowerCheckpoint::try_from(damaged).is_err(), "{number}");
        }
    }

    /// Membranes everywhere at first: the mesh becomes coarser as they go.
    #[test]
    fn a_random_phase_has_a_fine_mesh_that_becomes_coarser() {
        let random = "vesicle={ shape = \"random\", amplitude = 0.3, seed = 3 }";
        let settings = [
            random,
            "time.tolerance=1e-1",
            "mesh.interface=0.05",
            "area=false",
            "pull=false",
        ];
        let mut simulation = simulation(&settings);
        let nodes = simulation.mesh().nodes().len();
        run(&mut simulation, 40);
        assert!(!transfers(&mut simulation).is_empty());
        assert!(simulation.mesh().nodes().len() < nodes);
    }
}
