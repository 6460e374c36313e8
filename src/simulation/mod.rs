//! A run in time: the fixed grid t_n = n Δt, what is reported of each step, and what happens on the way.

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

use crate::fem::{Contour, FemError, Mesh};
use crate::scene::{self, AnchoringKind, Iteration, Scene, Shape, Warning};
use crate::scheme::{Scheme, StepReport, initial_fields};

pub use crate::fem::OutlineMeasure;
pub use crate::physics::NamedValue;
pub use crate::scheme::{Phase, RecallError, State};
pub use error::SimulationError;
pub use event::{Event, EventKind};
pub use ladder::{Ladder, Tried};
pub use memory::Memory;
pub use needs::{check_memory, memory_available, memory_needed};
pub use schedule::{Schedule, step_count};
pub use warnings::warnings;
pub use worker::{
    Command, Continuity, Mailbox, Message, News, Orders, Picture, RunId, Setting, Worker,
};

use division::Division;
use warnings::NearWall;

/// What is allowed in a scene but probably not meant, told from its initial state, without the
/// scheme that would run it.
///
/// # Errors
/// `Mesh` and `Initial`: the state could not be made.
pub fn examine(scene: &Scene) -> Result<Vec<Warning>, SimulationError> {
    let mesh = mesh(scene)?;
    let initial = initial_fields(scene, &mesh)?;
    Ok(warnings(scene, &mesh, &initial.phi))
}

fn mesh(scene: &Scene) -> Result<Arc<Mesh>, FemError> {
    let scene::Mesh::Structured {
        cells,
        jitter,
        seed,
    } = scene.mesh;
    Mesh::structured(cells, jitter, seed).map(Arc::new)
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
    /// The long axis of the vesicle, in degrees to the x axis.
    axis: f64,
    near_wall: NearWall,
    division: Division,
}

/// The scalars of one step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// n; 0 is the initial state.
    pub step: u64,
    /// t_n.
    pub t: f64,
    /// The smallest Δt that was used.
    pub dt: f64,
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
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Costs([Duration; Phase::ALL.len()]);

impl Costs {
    /// What a part took.
    pub fn of(&self, phase: Phase) -> Duration {
        self.0[phase as usize]
    }

    /// Adds to what a part took.
    pub fn add(&mut self, phase: Phase, time: Duration) {
        self.0[phase as usize] += time;
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
        let mesh = mesh(scene)?;
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
            division: Division::default(),
        };
        simulation.report.take(simulation.scheme.report());
        simulation.look();
        Ok(simulation)
    }

    /// Takes one step of the fixed grid; in smaller ones that end at the same time, where it cannot be
    /// solved whole. What the report says of a step is then said of all of them: the sum of their
    /// ledgers and iterations, the largest law residual, the smallest Δt. On an error the state is the
    /// last good one, and the report's t says when that was.
    ///
    /// # Errors
    /// `Step`: not even the smallest step was solved.
    pub fn advance(&mut self) -> Result<&Report, SimulationError> {
        let step = self.report.step + 1;
        let dt = self.scene.time.step;
        let (begin, end) = (grid_time(step - 1, dt), grid_time(step, dt));
        let mut costs = Costs::default();
        let mut begun = Instant::now();
        let mut watch = |phase: Phase| {
            let now = Instant::now();
            costs.add(phase, now - begun);
            begun = now;
        };
        let was_fast = self.scheme.uses_transform();
        let mut fallback = None;
        let mut took_over = None;
        let mut divided = None;
        let mut switched = None;
        let mut ladder = Ladder::default();
        self.division.begin();
        let mut first = true;
        loop {
            let piece = dt * self.division.piece();
            match self.scheme.step_watched(piece, &mut watch) {
                Ok(solved) => {
                    if let Some(reason) = &solved.fallback {
                        fallback.get_or_insert_with(|| reason.clone());
                    }
                    if let Some(jump) = solved.switched {
                        switched = Some(switched.unwrap_or(0.0) + jump);
                    }
                    if let Some(reason) = &solved.newton_took_over {
                        took_over.get_or_insert_with(|| reason.clone());
                    }
                    let solved = self.scheme.report();
                    ladder.accept(solved, !self.scheme.uses_transform());
                    if std::mem::take(&mut first) {
                        self.report.take(solved);
                    } else {
                        self.report.add(solved);
                    }
                    self.report.dt = dt * self.division.smallest();
                    if self.division.accept() {
                        break;
                    }
                    self.report.t = begin + dt * self.division.done();
                }
                Err(reason) => {
                    ladder.refuse();
                    if !self.division.refuse() {
                        return Err(SimulationError::Step {
                            step,
                            t: end,
                            tried: Box::new(Tried {
                                refused: ladder.refused,
                                transform: was_fast || self.scheme.uses_transform(),
                                factor: !self.scheme.uses_transform(),
                                lagged: self.scene.solver.iteration == Iteration::Lagged,
                                steps: [dt, dt * self.division.smallest()],
                            }),
                            source: reason,
                        });
                    }
                    divided = Some(reason);
                }
            }
        }
        self.report.step = step;
        self.report.t = end;
        if let Some(jump) = switched {
            let kind = EventKind::FieldSwitched { jump };
            let (step, t) = (step - 1, begin);
            self.events.push(Event { step, t, kind });
        }
        self.report.ladder = ladder;
        let event = |kind| Event { step, t: end, kind };
        if let Some(reason) = divided {
            let smallest = self.report.dt;
            self.events
                .push(event(EventKind::StepDivided { smallest, reason }));
        }
        if let Some(reason) = took_over {
            self.events
                .push(event(EventKind::NewtonTookOver { reason }));
        }
        match (was_fast, self.scheme.uses_transform(), fallback) {
            (true, false, Some(reason)) => self
                .events
                .push(event(EventKind::FellBackToFactor { reason })),
            (false, true, _) => self.events.push(event(EventKind::ReturnedToTransform)),
            _ => {}
        }
        self.look();
        watch(Phase::Ledger);
        self.report.costs = costs;
        Ok(&self.report)
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
        self.report.take(self.scheme.report());
        let (step, t) = (self.report.step, self.report.t);
        let kind = EventKind::AnchoringSwitched { kind };
        self.events.push(Event { step, t, kind });
        Ok(&self.report)
    }

    /// Measures the vesicle and notices when it reaches the wall.
    fn look(&mut self) {
        self.measure();
        if self.near_wall.is_reached(&self.scheme.state().phi) {
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

    /// How the linear systems of substep 2 are solved at present: "transform" or "factor".
    pub fn linear_method(&self) -> &'static str {
        if self.scheme.uses_transform() {
            "transform"
        } else {
            "factor"
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
