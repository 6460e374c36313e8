//! Everything that the rest of a run depends on, copied out and put back: a run continues from it as if
//! nothing had happened.

use serde::{Deserialize, Serialize};

use super::last_whole_step::LastWholeCheckpoint;
use super::mesh_follower::{FollowerCheckpoint, MeshFollower};
use super::partial_step::{PartialStep, StepProgress};
use super::{ErrorEstimates, Pacing, Simulation, StepEffort};
use crate::scene::{Change, Timetable};
use crate::scheme::{self, RestoreError};

/// What [`Simulation::save`] has copied. It keeps its buffers.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SimulationCheckpoint {
    scheme: scheme::SchemeCheckpoint,
    /// Those of the scene: more than it had at the start, where some were made while the run went.
    changes: Vec<Change>,
    /// Where the mesh follows the membrane: the present one.
    follower: Option<FollowerCheckpoint>,
    step: u64,
    t: f64,
    /// The smallest Δt of the last step.
    dt: f64,
    law_residual: f64,
    /// Iterations of the last step: of substep 2, Krylov's, of substep 1.
    work: [u32; 3],
    pacing: Pacing,
    /// Attempts at the last step that were refused, and its estimated error.
    refused: u32,
    time_error: Option<f64>,
    budget: ErrorEstimates,
    reached_wall: bool,
    /// How many changes had begun in the last whole step.
    begun: usize,
    is_at_rest: bool,
    effort: StepEffort,
    /// What was done of a step that was interrupted.
    left: Option<PartialStep>,
    /// The last whole step, where the state is within the next one.
    last_whole: Option<LastWholeCheckpoint>,
}

impl SimulationCheckpoint {
    /// The step that was reached.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The changes of its scene, with those that were made while the run went.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// The time that was reached.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Whether nothing moved any more, so that the run was over.
    pub fn is_at_rest(&self) -> bool {
        self.is_at_rest
    }

    /// How far the step after that was, if it had been begun.
    pub fn underway(&self) -> Option<StepProgress> {
        self.left.as_ref()?.underway
    }

    /// Whether anything of the run was computed: a step, or a part of the first one.
    pub fn is_begun(&self) -> bool {
        self.step > 0 || self.left.is_some() || self.last_whole.is_some()
    }
}

impl Simulation {
    /// Copies out everything that the rest of the run depends on; not the events, which must be
    /// drained before.
    pub fn save(&self, checkpoint: &mut SimulationCheckpoint) {
        let report = &self.report;
        self.scheme.save(&mut checkpoint.scheme);
        let save = |follower: &MeshFollower| follower.save(&self.mesh);
        checkpoint.follower = self.follower.as_ref().map(save);
        checkpoint.changes.clone_from(&self.scene.changes);
        checkpoint.step = report.step;
        checkpoint.t = report.t;
        checkpoint.dt = report.dt;
        checkpoint.law_residual = report.law_residual;
        checkpoint.work = [report.newton, report.krylov, report.director_iterations];
        checkpoint.pacing.clone_from(&self.pacing);
        checkpoint.refused = report.refused;
        checkpoint.time_error = report.time_error;
        checkpoint.budget = report.budget;
        checkpoint.is_at_rest = report.is_at_rest;
        checkpoint.reached_wall = self.near_wall.reached();
        checkpoint.begun = self.begun;
        checkpoint.effort = report.effort;
        checkpoint.left.clone_from(&self.left);
        checkpoint.last_whole = self.last_whole.as_ref().map(|whole| whole.save());
    }

    /// Puts it back, also into a new run of the same scene: what follows is bit for bit what it was.
    /// The scene's changes become those of the checkpoint. The report has no ledger.
    ///
    /// # Errors
    /// `RestoreError`: the checkpoint is of another scene. The state is then unchanged.
    pub fn restore(&mut self, checkpoint: &SimulationCheckpoint) -> Result<(), RestoreError> {
        match (&checkpoint.pacing, &self.pacing) {
            (Pacing::Fixed(subdivision), Pacing::Fixed(_)) if subdivision.is_possible() => {}
            (Pacing::Chosen(theirs), Pacing::Chosen(own)) if theirs.fits(own) => {}
            (Pacing::Fixed(_), Pacing::Fixed(_)) => {
                return Err(RestoreError::Foreign("its step is divided as none can be"));
            }
            _ => return Err(RestoreError::Foreign("its steps are chosen otherwise")),
        }
        let whole = checkpoint.last_whole.as_ref();
        if whole.is_some_and(|whole| !whole.fits(checkpoint.scheme.state())) {
            return Err(RestoreError::Foreign("its last whole step does not fit"));
        }
        let changes = std::mem::replace(&mut self.scene.changes, checkpoint.changes.clone());
        self.scheme.set_timetable(Timetable::of(&self.scene));
        let restored = self.restore_on(&checkpoint.scheme, checkpoint.follower.as_ref());
        if let Err(error) = restored {
            self.scene.changes = changes;
            self.scheme.set_timetable(Timetable::of(&self.scene));
            return Err(error);
        }
        self.begun = checkpoint.begun;
        let report = &mut self.report;
        report.take(self.scheme.report());
        report.step = checkpoint.step;
        report.t = checkpoint.t;
        report.dt = checkpoint.dt;
        report.law_residual = checkpoint.law_residual;
        [report.newton, report.krylov, report.director_iterations] = checkpoint.work;
        report.refused = checkpoint.refused;
        report.time_error = checkpoint.time_error;
        report.budget = checkpoint.budget;
        report.is_at_rest = checkpoint.is_at_rest;
        report.costs = super::Costs::default();
        report.effort = checkpoint.effort;
        self.pacing.clone_from(&checkpoint.pacing);
        self.left.clone_from(&checkpoint.left);
        self.near_wall.set_reached(checkpoint.reached_wall);
        self.events.clear();
        self.last_whole = None;
        if let Some(whole) = whole {
            let mut whole = whole.restore(&self.report);
            let (wall, found) = (self.near_wall.nodes(), &mut whole.report.vesicles);
            let phi = &whole.state.phi;
            (self.vesicles).measure(&self.mesh, phi, self.axis, wall, found);
            // What the vesicles of the next whole step are compared with.
            self.vesicles.forget();
            self.vesicles.changes();
            self.last_whole = Some(Box::new(whole));
        }
        self.measure();
        if self.last_whole.is_none() {
            self.vesicles.forget();
            self.vesicles.changes();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AnchoringKind, Scene};
    use crate::simulation::{EventKind, Report};

    const TEXT: &str = r#"
        mesh.cells = 12
        vesicle = { shape = "ellipse", half_axes = [0.3, 0.2], angle = 70 }
        time = { step = 1e-6, end = 1 }
        membrane.interface_width = 0.08
        nematic.initial = [0.6, 0.8]
        anchoring.kind = "parallel"
    "#;

    fn simulation(settings: &[&str]) -> Simulation {
        Simulation::new(&Scene::of_text(TEXT, settings)).expect("a run")
    }

    /// What a report says, but for the clock.
    fn run(simulation: &mut Simulation, steps: usize) -> Vec<Report> {
        let step = |_| {
            let mut report = simulation.advance().expect("a step").clone();
            report.costs = Default::default();
            report
        };
        (0..steps).map(step).collect()
    }

    fn over_bytes(simulation: &Simulation) -> SimulationCheckpoint {
        let mut checkpoint = SimulationCheckpoint::default();
        simulation.save(&mut checkpoint);
        let bytes = postcard::to_stdvec(&checkpoint).expect("bytes");
        postcard::from_bytes(&bytes).expect("a checkpoint")
    }

    #[test]
    fn a_new_run_goes_on_where_another_was() {
        // A step so long that it is divided, too, and steps that are chosen.
        for settings in [
            &[][..],
            &["time.step=3e-2"],
            &["time.scheme=secant"],
            &["time.tolerance=1e-4"],
            &["time.tolerance=1e-4", "time.scheme=first-order"],
        ] {
            let mut first = simulation(settings);
            run(&mut first, 3);
            first
                .change(Change::of_anchoring(AnchoringKind::Homeotropic), 0.0)
                .expect("a director");
            run(&mut first, 2);
            first.drain_events();
            let checkpoint = over_bytes(&first);
            assert_eq!(checkpoint.step(), 5);
            let mut second = simulation(settings);
            second.restore(&checkpoint).expect("the same scene");
            assert_eq!(second.scene(), first.scene());
            assert_eq!(second.report().t, first.report().t);
            assert_eq!(second.report().vesicles, first.report().vesicles);
            assert_eq!(second.drain_events(), []);
            let (wanted, found) = (run(&mut first, 4), run(&mut second, 4));
            assert_eq!(wanted, found);
            assert!(first.state() == second.state());
            assert_eq!(first.drain_events(), second.drain_events());
        }
    }

    #[test]
    fn a_memory_of_steps_that_are_chosen_otherwise_is_refused() {
        let chosen = ["time.tolerance=1e-4"];
        let first = simulation(&chosen);
        let checkpoint = over_bytes(&first);
        assert_eq!(simulation(&chosen).restore(&checkpoint), Ok(()));
        for other in [
            &[][..],
            &["time.tolerance=1e-5"],
            &["time.tolerance=1e-4", "time.scheme=first-order"],
        ] {
            let outcome = simulation(other).restore(&checkpoint);
            assert!(
                matches!(outcome, Err(RestoreError::Foreign(_))),
                "{other:?}"
            );
        }
    }

    #[test]
    fn the_wall_is_reached_only_once() {
        let settings = [
            "mesh.cells=16",
            "vesicle={ shape = \"circle\", radius = 0.47 }",
        ];
        let mut first = simulation(&settings);
        let reached = |simulation: &mut Simulation| {
            let events = simulation.drain_events();
            events
                .iter()
                .any(|event| event.kind == EventKind::ReachedWall)
        };
        assert!(reached(&mut first));
        let mut second = simulation(&settings);
        second.restore(&over_bytes(&first)).expect("the same scene");
        run(&mut second, 1);
        assert!(!reached(&mut second));
    }
}
