//! A run in time: the fixed grid t_n = n Δt or steps that are chosen, what is reported of each step,
//! and what happens on the way.

mod checkpoint;
mod claim;
mod controller;
mod error;
mod error_estimates;
mod event;
mod extreme_values;
mod free_memory;
mod last_whole_step;
mod memory_estimate;
mod mesh_follower;
mod partial_step;
mod presence;
mod report;
mod rest;
mod schedule;
mod shape_at_rest;
mod step_effort;
mod step_subdivision;
mod steps;
#[cfg(test)]
mod tests;
mod threads;
mod warnings;
mod worker;

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::fem::{Contour, GradientRecovery, Mesh, MeshQuality, Vesicles, long_axis};
use crate::geometry::Vector;
use crate::scene::{
    Assignment, Change, Geometry, Iteration, Scene, Shape, Time, Timetable, Warning,
};
use crate::scheme::{Scheme, initial_fields};

pub use crate::fem::{OutlineMeasure, Vesicle};
pub use crate::physics::NamedValue;
pub use crate::scheme::{Phase, RestoreError, State};
pub use checkpoint::SimulationCheckpoint;
pub use claim::{Claim, Shortage, kept_free};
pub use error::SimulationError;
pub use error_estimates::{ErrorEstimates, ErrorPart};
pub use event::{Event, EventKind, VesicleChange};
pub use free_memory::free_memory;
pub use memory_estimate::{check_memory, memory_held, memory_needed, node_count};
pub use partial_step::StepProgress;
pub use presence::check_outlines;
pub use report::{Costs, Report};
pub use schedule::{Schedule, step_count};
pub use shape_at_rest::{NoShapeAtRest, enclosed_area, outline_beside, shape_at_rest};
pub use step_effort::{StepEffort, Tried};
pub use threads::{cores, threads_that_pay};
pub use warnings::warnings;
pub(crate) use worker::panic_words;
pub use worker::{
    Command, Continuity, Failure, Message, RunId, RunSnapshot, Setting, Worker, WorkerConfig,
    WorkerEvent,
};

use controller::Controller;
use extreme_values::extreme_values;
use last_whole_step::LastWholeStep;
use memory_estimate::claim_memory;
use mesh_follower::MeshFollower;
use partial_step::{PartialStep, StepDetails, StepOutcome};
use presence::check_vesicle;
use step_subdivision::StepSubdivision;
use threads::Threads;
use warnings::NearWall;

/// The error of the mesh is estimated every so many steps: it changes slowly.
const SPACE_ERROR_EVERY: u64 = 8;

/// A part of setting a run up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SetUp {
    /// The mesh.
    Mesh,
    /// The initial fields.
    InitialState,
    /// Matrices and factors.
    Solver,
}

impl SetUp {
    /// What is being done.
    pub fn words(self) -> &'static str {
        match self {
            Self::Mesh => "making the mesh",
            Self::InitialState => "making the initial state",
            Self::Solver => "setting up the solver",
        }
    }
}

/// What a scene's initial state shows, without the scheme that would run it.
#[derive(Debug, Clone, PartialEq)]
pub struct Examination {
    /// What is allowed but probably not meant.
    pub warnings: Vec<Warning>,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Angles and sizes of its triangles.
    pub quality: MeshQuality,
    /// The radius of the circle with the area of the region φ⁰ > 0, or by rotation of the sphere with its volume.
    pub radius: f64,
    /// The reduced area 4πA/L² of the region φ⁰ > 0, or by rotation its reduced volume; `None` where it is not one piece or
    /// touches the wall.
    pub reduced_size: Option<f64>,
}

/// Makes a scene's mesh and initial state, and describes them.
///
/// # Errors
/// `Mesh` and `Initial`: the state could not be made; `NoVesicle`: there is none in the domain.
pub fn examine(scene: &Scene) -> Result<Examination, SimulationError> {
    let mesh = Mesh::of(scene)?;
    let initial = initial_fields(scene, &mesh)?;
    check_vesicle(scene, &mesh, &initial.phi)?;
    let phi = &initial.phi;
    let contour = Contour::new(&mesh, phi);
    let wall = NearWall::new(&mesh, scene.membrane.interface_width);
    let mut vesicles = Vec::new();
    Vesicles::default().measure(&mesh, phi, Vector::x(), wall.nodes(), &mut vesicles);
    Ok(Examination {
        radius: match contour.volume {
            None => (contour.area / PI).sqrt(),
            Some(volume) => (0.75 * volume / PI).cbrt(),
        },
        reduced_size: match &vesicles[..] {
            [vesicle] => vesicle.reduced_size(),
            _ => None,
        },
        warnings: warnings(scene, &mesh, &initial.phi),
        nodes: mesh.nodes().len(),
        quality: MeshQuality::of(&mesh),
    })
}

/// A run: a scene, and how far it has come.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    mesh: Arc<Mesh>,
    /// Where the mesh follows the membrane.
    follower: Option<MeshFollower>,
    scheme: Scheme,
    report: Report,
    warnings: Vec<Warning>,
    events: Vec<Event>,
    vesicles: Vesicles,
    recovery: GradientRecovery,
    /// The long axis of the vesicle at the start, a unit vector.
    axis: Vector,
    near_wall: NearWall,
    pacing: Pacing,
    /// What was done of a step that was interrupted.
    left: Option<PartialStep>,
    /// The last whole step, while the state is within the next one.
    last_whole: Option<Box<LastWholeStep>>,
    /// When snapshots are due: chosen steps end there.
    schedule: Schedule,
    /// How many changes had begun in the last whole step.
    begun: usize,
    threads: Threads,
    /// Whether it goes on although nothing moves any more.
    goes_beyond_rest: bool,
}

/// How long steps are, and where a run stands in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Pacing {
    /// Those of the fixed grid, divided where they cannot be solved whole.
    Fixed(StepSubdivision),
    /// Chosen by their estimated error.
    Chosen(Controller),
}

impl Pacing {
    fn of(time: &Time) -> Self {
        match time.error_bound() {
            None => Self::default(),
            Some((bound, power)) => Self::Chosen(Controller::new(bound, power, time.step)),
        }
    }
}

impl Default for Pacing {
    fn default() -> Self {
        Self::Fixed(StepSubdivision::default())
    }
}

impl Simulation {
    /// Builds the mesh, the initial fields and the scheme of a scene.
    ///
    /// # Errors
    /// [`SimulationError`]: what could not be built.
    pub fn new(scene: &Scene) -> Result<Self, SimulationError> {
        Self::new_unless(scene, &mut |_| false)
    }

    /// [`new`](Self::new), but asks `leave` before each part, and now and
    /// then while it makes a mesh, whether to stop.
    ///
    /// # Errors
    /// [`SimulationError`]: what could not be built; `Ended` if `leave` asked for that.
    pub fn new_unless(
        scene: &Scene,
        leave: &mut dyn FnMut(SetUp) -> bool,
    ) -> Result<Self, SimulationError> {
        let mut go_on = |part| match leave(part) {
            true => Err(SimulationError::Ended),
            false => Ok(()),
        };
        // Until the set-up has allocated it: others that are set up meanwhile must count it.
        let _claim = claim_memory(scene, &mut || go_on(SetUp::Mesh).is_err())?;
        go_on(SetUp::Mesh)?;
        let mesh = Mesh::of_unless(scene, &mut || go_on(SetUp::Mesh).is_err())?;
        go_on(SetUp::InitialState)?;
        let initial = initial_fields(scene, &mesh)?;
        check_vesicle(scene, &mesh, &initial.phi)?;
        let warnings = warnings(scene, &mesh, &initial.phi);
        let axis = match &scene.vesicle.shape {
            Shape::Outlines(outlines) if outlines.len() == 1 => outlines[0].long_axis(),
            _ if scene.geometry == Geometry::Axisymmetric => Vector::y(),
            _ => long_axis(&mesh, &initial.phi),
        };
        go_on(SetUp::Solver)?;
        let follower = MeshFollower::of(scene, &mesh, &initial.phi);
        let scheme = Scheme::new(scene, mesh.clone(), initial.phi, initial.director)
            .map_err(SimulationError::Factor)?;
        let mut simulation = Self {
            near_wall: NearWall::new(&mesh, scene.membrane.interface_width),
            vesicles: Vesicles::default(),
            recovery: GradientRecovery::default(),
            report: Report {
                dt: scene.time.step,
                ..Report::default()
            },
            scene: scene.clone(),
            mesh,
            follower,
            scheme,
            warnings,
            events: Vec::new(),
            axis,
            pacing: Pacing::of(&scene.time),
            left: None,
            last_whole: None,
            schedule: Schedule::new(&scene.time, 1, 1),
            begun: 0,
            threads: Threads::default(),
            goes_beyond_rest: false,
        };
        simulation.report.take(simulation.scheme.report());
        if let Some(place) = simulation.first_not_finite() {
            let values = extreme_values(scene);
            return Err(SimulationError::NotFinite { place, values });
        }
        simulation.look();
        Ok(simulation)
    }

    /// The first field, energy or area that is not finite.
    fn first_not_finite(&self) -> Option<&'static str> {
        let measures = [
            ("total energy", self.report.total_energy),
            ("surface area", self.report.surface_area),
        ];
        let energies = self.report.energies.iter();
        let values = energies.map(|energy| (energy.name, energy.value));
        let mut values = values.chain(measures);
        let field = self.scheme.state().first_not_finite();
        field.or_else(|| Some(values.find(|(_, value)| !value.is_finite())?.0))
    }

    /// Sets the number of threads that compute the steps; at first it is 1. It changes no result.
    pub fn set_threads(&mut self, count: usize) {
        if count != self.threads.count() {
            self.threads = Threads::new(count);
        }
    }

    /// In how many threads the steps are computed.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// Has chosen steps end at the times of this schedule's snapshots. A fixed grid takes no notice.
    pub fn follow(&mut self, schedule: &Schedule) {
        self.schedule = *schedule;
    }

    /// Takes one step: the next one of the fixed grid, or one whose length is chosen.
    ///
    /// A step of the grid that cannot be solved whole is taken in smaller ones that end at the same
    /// time. What the report says of a step is then said of all of them: the sum of their ledgers and
    /// iterations, the largest law residual, the smallest Δt. Of a chosen step, iterations and costs
    /// are those of refused attempts too. On an error the state is the last good one, and the
    /// report's t says when that was.
    ///
    /// # Errors
    /// `Step`: not even the smallest step was solved, or accurate enough.
    pub fn advance(&mut self) -> Result<&Report, SimulationError> {
        while !self.advance_unless(&mut |_| false)? {}
        Ok(&self.report)
    }

    /// [`advance`](Self::advance), but asks `leave` before each further attempt at a step that takes more
    /// than one whether to interrupt it; returns whether the step was completed. It is also interrupted for
    /// an event that is reported at once. A step that was interrupted continues with the next call, also
    /// after [`save`](Self::save) and [`restore`](Self::restore), and its result is the same bit for bit.
    /// Until then the report's t is that of the state, its step is the last whole one.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn advance_unless(
        &mut self,
        leave: &mut dyn FnMut(&StepProgress) -> bool,
    ) -> Result<bool, SimulationError> {
        let mut begun = Instant::now();
        if self.left.is_none() && self.last_whole.is_none() {
            self.follow_membrane()?;
        }
        let left = self.left.take();
        let mut costs = left.as_ref().map_or(Costs::default(), |left| left.costs);
        let mut watch = |phase: Phase| {
            let now = Instant::now();
            costs.add(phase, now - begun);
            begun = now;
        };
        watch(Phase::Ledger);
        let before = self.last_whole().0;
        let before = (before.step, before.t);
        let was_damped = self.report.effort.damping < 1.0;
        let outcome = match self.pacing {
            Pacing::Fixed(_) => self.grid_step(left, &mut watch, leave)?,
            Pacing::Chosen(controller) => self.chosen_step(controller, left, &mut watch, leave)?,
        };
        let taken = match outcome {
            StepOutcome::Whole(taken) => taken,
            StepOutcome::Interrupted(left) => {
                watch(Phase::Ledger);
                self.left = Some(PartialStep { costs, ..left });
                self.measure();
                return Ok(false);
            }
        };
        self.last_whole = None;
        let begun = self.scheme.changes_begun();
        if begun > self.begun {
            let numbers = self.begun..begun;
            let changes = numbers.filter_map(|number| self.scheme.timetable().change(number));
            let kind = EventKind::ParametersChanged {
                changes: changes.cloned().collect(),
                work: taken.change_work.unwrap_or_default(),
            };
            let (step, t) = before;
            self.events.push(Event { step, t, kind });
        }
        self.begun = begun;
        let (step, t) = (before.0 + 1, self.report.t);
        let mut tell = |kind| self.events.push(Event { step, t, kind });
        if let Some(reason) = taken.divided {
            let smallest = self.report.dt;
            tell(EventKind::StepDivided { smallest, reason });
        }
        let factor = taken.effort.damping;
        if factor < 1.0 && !was_damped {
            tell(EventKind::Damped { factor });
        }
        if let Some(reason) = taken.newton_took_over {
            tell(EventKind::NewtonTookOver { reason });
        }
        match (taken.was_fast, !self.scheme.uses_factor(), taken.fallback) {
            (true, false, Some(reason)) => tell(EventKind::FellBackToFactor { reason }),
            (true, false, None) => tell(EventKind::FactorIsFaster),
            (false, true, _) => tell(EventKind::ReturnedToTransform),
            _ => {}
        }
        self.report.effort = taken.effort;
        let (time, algebra) = (self.report.time_error, self.scheme.report().algebraic_error);
        self.report.budget.add_step(time, algebra);
        self.look();
        self.notice_rest(t - before.1);
        watch(Phase::Ledger);
        self.report.costs = costs;
        Ok(true)
    }

    /// The next time after t at which a run with chosen steps must be: that of a snapshot, T, or where a change begins or
    /// ends.
    fn landing_after(&self, t: f64) -> f64 {
        let landing = self.schedule.landing_after(t);
        // Nearer to another landing than this they are the same time, but for rounding.
        let close = 1e-9 * self.schedule.end;
        let event = self.scheme.timetable().next_event(t + close);
        event
            .filter(|event| *event < landing - close)
            .unwrap_or(landing)
    }

    /// Whether there is a change that takes no time at the end of a step.
    fn is_jump(&self, end: f64) -> bool {
        let close = 1e-9 * self.schedule.end;
        let timetable = self.scheme.timetable();
        timetable.has_jump(|at| (at - end).abs() <= close)
    }

    /// What was tried in a step that was not solved.
    fn tried(&self, taken: &StepDetails, steps: [f64; 2]) -> Tried {
        Tried {
            refused: taken.effort.refused,
            fast: (taken.was_fast || !self.scheme.uses_factor())
                .then(|| self.scheme.fast_method())
                .flatten(),
            factor: self.scheme.uses_factor(),
            lagged: self.scene.solver.iteration == Iteration::Lagged,
            steps,
        }
    }

    /// Changes parameters of the scene from the next step on, on a straight line over a time `over` if that is not 0. The
    /// change is one of the scene from then on: it begins at the time that was reached.
    ///
    /// # Errors
    /// `Change`: it is not one that the scene could have.
    pub fn change(&mut self, set: Vec<Assignment>, over: f64) -> Result<&Change, SimulationError> {
        let at = self.report.t;
        let change = Change { at, over, set };
        self.scene
            .add_change(&change)
            .map_err(|error| SimulationError::Change(Box::new(error)))?;
        self.scheme.set_timetable(Timetable::of(&self.scene));
        self.report.is_at_rest = false;
        if !change.is_ramp() {
            self.expect_jump();
        }
        let place = self.scene.changes.partition_point(|it| it.at <= at);
        Ok(&self.scene.changes[place - 1])
    }

    /// A change that takes no time comes now: a chosen Δt begins anew.
    fn expect_jump(&mut self) {
        if let Pacing::Chosen(controller) = &mut self.pacing {
            controller.forget();
            self.scheme.forget();
        }
    }

    /// Measures the vesicles, and notices when they merge or split, and when one reaches the wall.
    fn look(&mut self) {
        self.measure();
        let (step, t) = (self.report.step, self.report.t);
        // Not the report's: within a step that was interrupted it is about a state on the way.
        let now = self.report.vesicles.len();
        let counts = [self.vesicles.count_before().unwrap_or(now), now];
        let changes = VesicleChange::all(self.vesicles.changes());
        let events = changes.map(|change| EventKind::VesiclesChanged { change, counts });
        self.events
            .extend(events.map(|kind| Event { step, t, kind }));
        let phi = &self.scheme.state().phi;
        if self.report.step.is_multiple_of(SPACE_ERROR_EVERY) {
            let error = self.recovery.interpolation_error(&self.mesh, phi);
            self.report.budget.space = Some(error);
        }
        // φ > 0 everywhere is not a vesicle.
        if presence::sign(phi).is_none() && self.near_wall.is_reached(phi) {
            let kind = EventKind::ReachedWall;
            self.events.push(Event { step, t, kind });
        }
    }

    /// Measures the vesicles of the state.
    fn measure(&mut self) {
        let phi = &self.scheme.state().phi;
        let (wall, found) = (self.near_wall.nodes(), &mut self.report.vesicles);
        (self.vesicles).measure(&self.mesh, phi, self.axis, wall, found);
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene with the parameters of the last step, without its mesh and shape.
    pub fn parameters(&self) -> &Scene {
        self.scheme.parameters()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The fields at present.
    pub fn state(&self) -> &State {
        self.scheme.state()
    }

    /// The report of the last step, or of the initial state.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The last whole step, or the initial state: its report, and the fields at its end. They differ from
    /// [`report`](Self::report) and [`state`](Self::state) where the next step was left, or failed, after
    /// some of its parts.
    pub fn last_whole(&self) -> (&Report, &State) {
        match &self.last_whole {
            Some(whole) => (&whole.report, &whole.state),
            None => (&self.report, self.scheme.state()),
        }
    }

    /// The progress of the step that was interrupted.
    pub fn underway(&self) -> Option<StepProgress> {
        self.left.as_ref()?.underway
    }

    /// What is allowed in the scene but probably not meant.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// What happened since events were last drained.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// What happened since the last call.
    pub fn drain_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// How the linear systems of substep 2 are solved at present: "transform", "shifted" or "factor".
    pub fn linear_method(&self) -> &'static str {
        self.scheme.linear_method()
    }
}

/// t_n = n Δt. Where 1/Δt is a whole number n is divided by it, so that t prints as one expects:
/// 1.5e-5, not 1.4999999999999999e-5.
fn grid_time(step: u64, dt: f64) -> f64 {
    let steps_a_unit = dt.recip().round();
    if (steps_a_unit * dt - 1.0).abs() < 1e-14 {
        step as f64 / steps_a_unit
    } else {
        step as f64 * dt
    }
}
