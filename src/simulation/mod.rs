//! A run in time: the fixed grid t_n = n Δt or steps that are chosen, what is reported of each step,
//! and what happens on the way.

mod budget;
mod controller;
mod division;
mod error;
mod event;
mod ladder;
mod memory;
mod needs;
mod schedule;
#[cfg(test)]
mod tests;
mod warnings;
mod worker;

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::fem::{Contour, Mesh, Quality, Recovery};
use crate::scene::{AnchoringKind, Iteration, Order, Scene, Shape, Time, Warning};
use crate::scheme::{Scheme, StepError, StepReport, initial_fields};

pub use crate::fem::OutlineMeasure;
pub use crate::physics::NamedValue;
pub use crate::scheme::{Phase, RecallError, State};
pub use budget::{ErrorBudget, ErrorPart};
pub use error::SimulationError;
pub use event::{Event, EventKind};
pub use ladder::{Ladder, Tried};
pub use memory::Memory;
pub use needs::{check_memory, memory_available, memory_held, memory_needed, node_count};
pub use schedule::{Schedule, step_count};
pub use warnings::warnings;
pub use worker::{
    Command, Continuity, Mailbox, Message, News, Orders, Picture, RunId, Setting, Worker,
};

use controller::Controller;
use division::Division;
use warnings::NearWall;

/// The error of the mesh is estimated at every so many steps: it changes slowly.
const SPACE_ERROR_EVERY: u64 = 8;

/// What can be told of a scene from its initial state, without the scheme that would run it.
#[derive(Debug, Clone, PartialEq)]
pub struct Examination {
    /// What is allowed but probably not meant.
    pub warnings: Vec<Warning>,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Angles and sizes of its triangles.
    pub quality: Quality,
}

/// Makes a scene's mesh and initial state, and tells what they are like.
///
/// # Errors
/// `Mesh` and `Initial`: the state could not be made.
pub fn examine(scene: &Scene) -> Result<Examination, SimulationError> {
    let mesh = Mesh::of(scene)?;
    let initial = initial_fields(scene, &mesh)?;
    Ok(Examination {
        warnings: warnings(scene, &mesh, &initial.phi),
        nodes: mesh.nodes().len(),
        quality: Quality::of(&mesh),
    })
}

/// A run: a scene, and how far it has come.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    mesh: Arc<Mesh>,
    scheme: Scheme,
    report: Report,
    warnings: Vec<Warning>,
    events: Vec<Event>,
    contour: Contour,
    recovery: Recovery,
    /// The long axis of the vesicle, in degrees to the x axis.
    axis: f64,
    near_wall: NearWall,
    pacing: Pacing,
    /// When snapshots are due: chosen steps end there.
    schedule: Schedule,
}

/// How long steps are, and where a run stands in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Pacing {
    /// Those of the fixed grid, divided where they cannot be solved whole.
    Fixed(Division),
    /// Chosen by their estimated error.
    Chosen(Controller),
}

impl Pacing {
    fn of(time: &Time) -> Self {
        match time.tolerance {
            None => Self::default(),
            Some(tolerance) => {
                let order = time.order.chains() as u32;
                Self::Chosen(Controller::new(tolerance, order, time.step))
            }
        }
    }
}

impl Default for Pacing {
    fn default() -> Self {
        Self::Fixed(Division::default())
    }
}

/// The scalars of one step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// n, counting accepted steps; 0 is the initial state.
    pub step: u64,
    /// t_n.
    pub t: f64,
    /// The smallest Δt that was used.
    pub dt: f64,
    /// Attempts at this step that were refused, for their error was too large or they could not be
    /// solved; only where Δt is chosen.
    pub refused: u32,
    /// The estimated error of φ in this step, in L2. Where steps are extrapolated it is that of the
    /// solution of the order below, which is improved on.
    pub time_error: Option<f64>,
    /// The energy of each effect, weighted as in E_tot.
    pub energies: Vec<NamedValue>,
    /// E_tot.
    pub total_energy: f64,
    /// A = ∫φ.
    pub phase_integral: f64,
    /// B.
    pub surface_area: f64,
    /// Δt·(left side of (3.26))/S.
    pub law_residual: f64,
    /// Iterations of substep 2.
    pub newton: u32,
    /// Krylov iterations of substep 2.
    pub krylov: u32,
    /// Iterations of substep 1.
    pub director_iterations: u32,
    /// The estimated errors up to here, by where they come from.
    pub budget: ErrorBudget,
    /// What the parts of the step took.
    pub costs: Costs,
    /// Every term of (3.26), times Δt.
    pub ledger: Vec<NamedValue>,
    /// What it took to solve the step.
    pub ladder: Ladder,
    /// The size of the vesicle.
    pub outline: Option<OutlineMeasure>,
    /// 4π·area/length² of the zero set of φ: 1 for a circle.
    pub isoperimetric_quotient: Option<f64>,
}

/// What the parts of a step took, on the clock; measuring the vesicle counts with the ledger.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Costs([Duration; Phase::ALL.len()]);

impl Costs {
    /// What a part took.
    pub fn of(&self, phase: Phase) -> Duration {
        self.0[phase as usize]
    }

    /// Adds to what a part took.
    pub fn add(&mut self, phase: Phase, time: Duration) {
        let sum = &mut self.0[phase as usize];
        *sum = sum.saturating_add(time);
    }

    /// Part by part: what it took here and there together.
    pub fn plus(&self, other: &Self) -> Self {
        self.with(other, Duration::saturating_add)
    }

    /// Part by part: what it took here less what it took there.
    pub fn minus(&self, other: &Self) -> Self {
        self.with(other, Duration::saturating_sub)
    }

    fn with(&self, other: &Self, both: impl Fn(Duration, Duration) -> Duration) -> Self {
        let mut result = *self;
        for (one, other) in result.0.iter_mut().zip(other.0) {
            *one = both(*one, other);
        }
        result
    }

    /// Part by part: a share of so many. Nothing of none.
    pub fn divided(&self, count: u32) -> Self {
        Self(
            self.0
                .map(|part| part.checked_div(count).unwrap_or_default()),
        )
    }

    /// What all parts took together.
    pub fn total(&self) -> Duration {
        self.0.iter().sum()
    }
}

impl Report {
    /// By how much the energy rose in the step beyond the work that was done on it from outside, which
    /// the energy law forbids; `None` without a ledger. A switched energy is another one, and no rise.
    pub fn unexplained_rise(&self) -> Option<f64> {
        let counts = |name: &str| name == "dE" || name.ends_with("_work");
        let terms = self.ledger.iter().filter(|term| counts(term.name));
        (!self.ledger.is_empty()).then(|| terms.map(|term| term.value).sum())
    }

    fn take(&mut self, step: &StepReport) {
        self.energies.clone_from(&step.energies);
        self.total_energy = step.total_energy;
        self.phase_integral = step.phase_integral;
        self.surface_area = step.surface_area;
        self.law_residual = step.law_residual;
        self.newton = step.newton;
        self.krylov = step.krylov;
        self.director_iterations = step.director_iterations;
        self.ledger.clone_from(&step.ledger);
    }

    /// Takes a further part of the same step.
    fn add(&mut self, part: &StepReport) {
        let (newton, krylov, director) = (self.newton, self.krylov, self.director_iterations);
        let law_residual = self.law_residual;
        let ledger = std::mem::take(&mut self.ledger);
        self.take(part);
        self.newton += newton;
        self.krylov += krylov;
        self.director_iterations += director;
        if law_residual.abs() > self.law_residual.abs() {
            self.law_residual = law_residual;
        }
        for (sum, term) in self.ledger.iter_mut().zip(ledger) {
            sum.value += term.value;
        }
    }
}

impl Simulation {
    /// Builds the mesh, the initial fields and the scheme of a scene.
    ///
    /// # Errors
    /// [`SimulationError`]: what could not be built.
    pub fn new(scene: &Scene) -> Result<Self, SimulationError> {
        check_memory(scene)?;
        let mesh = Mesh::of(scene)?;
        let initial = initial_fields(scene, &mesh)?;
        let warnings = warnings(scene, &mesh, &initial.phi);
        let scheme = Scheme::new(scene, mesh.clone(), initial.phi, initial.director)
            .map_err(SimulationError::Factor)?;
        let axis = match &scene.vesicle.shape {
            Shape::Outlines(outlines) => outlines.first().map_or(90.0, |outline| outline.angle),
            _ => 90.0,
        };
        let mut simulation = Self {
            near_wall: NearWall::new(&mesh, scene.membrane.interface_width),
            contour: Contour::default(),
            recovery: Recovery::default(),
            report: Report {
                dt: scene.time.step,
                ..Report::default()
            },
            scene: scene.clone(),
            mesh,
            scheme,
            warnings,
            events: Vec::new(),
            axis,
            pacing: Pacing::of(&scene.time),
            schedule: Schedule::new(&scene.time, 1, 1),
        };
        simulation.report.take(simulation.scheme.report());
        simulation.look();
        Ok(simulation)
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
        let mut costs = Costs::default();
        let mut begun = Instant::now();
        let mut watch = |phase: Phase| {
            let now = Instant::now();
            costs.add(phase, now - begun);
            begun = now;
        };
        let was_fast = !self.scheme.uses_factor();
        let before = (self.report.step, self.report.t);
        let taken = match self.pacing {
            Pacing::Fixed(_) => self.grid_step(&mut watch)?,
            Pacing::Chosen(controller) => self.chosen_step(controller, &mut watch)?,
        };
        self.report.ladder = taken.ladder;
        if let Some(jump) = taken.switched {
            let kind = EventKind::FieldSwitched { jump };
            let (step, t) = before;
            self.events.push(Event { step, t, kind });
        }
        let (step, t) = (self.report.step, self.report.t);
        let mut tell = |kind| self.events.push(Event { step, t, kind });
        if let Some(reason) = taken.divided {
            let smallest = self.report.dt;
            tell(EventKind::StepDivided { smallest, reason });
        }
        if let Some(reason) = taken.newton_took_over {
            tell(EventKind::NewtonTookOver { reason });
        }
        match (was_fast, !self.scheme.uses_factor(), taken.fallback) {
            (true, false, Some(reason)) => tell(EventKind::FellBackToFactor { reason }),
            (true, false, None) => tell(EventKind::FactorIsFaster),
            (false, true, _) => tell(EventKind::ReturnedToTransform),
            _ => {}
        }
        let (time, algebra) = (self.report.time_error, self.scheme.report().last_change);
        self.report.budget.add_step(time, algebra);
        self.look();
        watch(Phase::Ledger);
        self.report.costs = costs;
        Ok(&self.report)
    }

    /// The next step of the fixed grid.
    fn grid_step(&mut self, watch: &mut dyn FnMut(Phase)) -> Result<Taken, SimulationError> {
        let step = self.report.step + 1;
        let dt = self.scene.time.step;
        let (begin, end) = (grid_time(step - 1, dt), grid_time(step, dt));
        let was_fast = !self.scheme.uses_factor();
        let mut taken = Taken::default();
        let mut first = true;
        let Pacing::Fixed(division) = &mut self.pacing else {
            return Ok(taken);
        };
        division.begin();
        loop {
            let piece = dt * division.piece();
            let mut error = None;
            let outcome = match self.scene.time.order {
                Order::First => match self.scheme.step_watched(piece, watch) {
                    Ok(_) => {
                        error = self.scheme.first_order_error(piece);
                        Ok(self.scheme.report())
                    }
                    Err(reason) => Err(reason),
                },
                order => {
                    let tried = self
                        .scheme
                        .try_extrapolated(piece, order.chains(), true, watch);
                    tried.map(|difference| {
                        error = Some(difference.phase);
                        self.scheme.accept_extrapolated()
                    })
                }
            };
            match outcome {
                Ok(solved) => {
                    taken.note(solved);
                    let with_factor = self.scheme.uses_factor();
                    let solved = self.scheme.report();
                    taken.ladder.accept(solved, with_factor);
                    if std::mem::take(&mut first) {
                        self.report.take(solved);
                        self.report.time_error = error;
                    } else {
                        self.report.add(solved);
                        let sum = self.report.time_error.zip(error);
                        self.report.time_error = sum.map(|(sum, error)| sum + error);
                    }
                    self.report.dt = dt * division.smallest();
                    if division.accept() {
                        break;
                    }
                    self.report.t = begin + dt * division.done();
                }
                Err(reason) => {
                    taken.ladder.refuse();
                    if !division.refuse() {
                        let steps = [dt, dt * division.smallest()];
                        return Err(SimulationError::Step {
                            step,
                            t: end,
                            tried: Box::new(self.tried(was_fast, &taken, steps)),
                            source: reason,
                        });
                    }
                    taken.divided = Some(reason);
                }
            }
        }
        self.report.step = step;
        self.report.t = end;
        Ok(taken)
    }

    /// A step whose length is chosen.
    fn chosen_step(
        &mut self,
        mut controller: Controller,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<Taken, SimulationError> {
        let (step, t) = (self.report.step + 1, self.report.t);
        let landing = self.landing_after(t);
        let order = self.scene.time.order;
        let (chains, combine) = (order.chains(), order != Order::First);
        let mut taken = Taken::default();
        let (mut refused, mut work) = (0, [0; 3]);
        let was_fast = !self.scheme.uses_factor();
        let longest = controller.attempt(t, landing).dt;
        loop {
            let attempt = controller.attempt(t, landing);
            let outcome = self
                .scheme
                .try_extrapolated(attempt.dt, chains, combine, watch);
            let (again, reason) = match outcome {
                Ok(difference) if controller.judge(attempt.dt, difference.phase) => {
                    let solved = self.scheme.accept_extrapolated();
                    taken.note(solved);
                    let with_factor = self.scheme.uses_factor();
                    let solved = self.scheme.report();
                    taken.ladder.accept(solved, with_factor);
                    self.report.take(solved);
                    self.report.newton += work[0];
                    self.report.krylov += work[1];
                    self.report.director_iterations += work[2];
                    self.report.time_error = Some(difference.phase);
                    self.report.refused = refused;
                    self.report.dt = attempt.dt;
                    self.report.t = attempt.end;
                    self.report.step = step;
                    self.pacing = Pacing::Chosen(controller);
                    return Ok(taken);
                }
                Ok(difference) => {
                    let tried = self.scheme.tried_work();
                    work.iter_mut()
                        .zip(tried)
                        .for_each(|(sum, one)| *sum += one);
                    let error = difference.phase;
                    let tolerance = self.scene.time.tolerance.unwrap_or_default();
                    let reason = StepError::Inaccurate { error, tolerance };
                    (controller.may_go_on(), reason)
                }
                Err(reason) => (controller.fail(attempt.dt), reason),
            };
            refused += 1;
            taken.ladder.refuse();
            if !again {
                return Err(SimulationError::Step {
                    step,
                    t: attempt.end,
                    tried: Box::new(self.tried(was_fast, &taken, [longest, attempt.dt])),
                    source: reason,
                });
            }
        }
    }

    /// The next time after t at which a run with chosen steps must be: that of a snapshot, T, or when a
    /// field is switched.
    fn landing_after(&self, t: f64) -> f64 {
        let landing = self.schedule.landing_after(t);
        let field = self.scene.field.as_ref();
        let switches = field.map(|field| [Some(field.from), field.until]);
        // Nearer to another landing than this they are the same time, but for rounding.
        let close = 1e-9 * self.schedule.end;
        switches
            .into_iter()
            .flatten()
            .flatten()
            .filter(|switch| *switch > t + close && *switch < landing - close)
            .fold(landing, f64::min)
    }

    /// What was tried in a step that was not solved.
    fn tried(&self, was_fast: bool, taken: &Taken, steps: [f64; 2]) -> Tried {
        Tried {
            refused: taken.ladder.refused,
            transform: was_fast || !self.scheme.uses_factor(),
            factor: self.scheme.uses_factor(),
            lagged: self.scene.solver.iteration == Iteration::Lagged,
            steps,
        }
    }

    /// Another anchoring for the state as it is, with the scene's weight, or the scene's own default
    /// where it has none. The report has the energies measured anew; the step stays what it is.
    ///
    /// # Errors
    /// `NoDirector`: there is nothing to anchor.
    pub fn set_anchoring(&mut self, kind: AnchoringKind) -> Result<&Report, SimulationError> {
        if self.scene.nematic.is_none() {
            return Err(SimulationError::NoDirector);
        }
        let anchoring = self.scene.anchoring.get_or_insert_default();
        anchoring.kind = kind;
        self.scheme.set_anchoring(Some(anchoring));
        if let Pacing::Chosen(controller) = &mut self.pacing {
            controller.forget();
        }
        self.report.take(self.scheme.report());
        let (step, t) = (self.report.step, self.report.t);
        let kind = EventKind::AnchoringSwitched { kind };
        self.events.push(Event { step, t, kind });
        Ok(&self.report)
    }

    /// Measures the vesicle and notices when it reaches the wall.
    fn look(&mut self) {
        self.measure();
        let phi = &self.scheme.state().phi;
        if self.report.step.is_multiple_of(SPACE_ERROR_EVERY) {
            let error = self.recovery.interpolation_error(&self.mesh, phi);
            self.report.budget.space = Some(error);
        }
        if self.near_wall.is_reached(phi) {
            let (step, t) = (self.report.step, self.report.t);
            self.events.push(Event {
                step,
                t,
                kind: EventKind::ReachedWall,
            });
        }
    }

    /// Measures the vesicle.
    fn measure(&mut self) {
        self.contour.trace(&self.mesh, &self.scheme.state().phi);
        self.report.outline = self.contour.measure(self.axis);
        self.report.isoperimetric_quotient = self.contour.isoperimetric_quotient();
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
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

    /// What is allowed in the scene but probably not meant.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
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

/// What is to be told of a step beyond its report.
#[derive(Debug, Default)]
struct Taken {
    /// Why the transform gave way to the factor.
    fallback: Option<StepError>,
    /// Why Newton's method took over from the lagged iteration.
    newton_took_over: Option<StepError>,
    /// Why the step was taken in parts.
    divided: Option<StepError>,
    /// By how much the energy jumped before the step.
    switched: Option<f64>,
    ladder: Ladder,
}

impl Taken {
    /// Takes note of a step of the scheme.
    fn note(&mut self, solved: &StepReport) {
        if self.fallback.is_none() {
            self.fallback.clone_from(&solved.fallback);
        }
        if self.newton_took_over.is_none() {
            self.newton_took_over.clone_from(&solved.newton_took_over);
        }
        if let Some(jump) = solved.switched {
            *self.switched.get_or_insert(0.0) += jump;
        }
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
