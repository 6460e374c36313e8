//! One time step of the scheme (3.20)–(3.21): substep 1 (director), substep 2 (membrane), and the
//! ledger of the energy law (3.26).

mod active_region;
#[doc(hidden)]
pub mod bench_support;
mod changes;
mod checkpoint;
mod director;
mod energy_law;
mod error;
mod fault_injection;
mod initial;
mod jacobian;
mod membrane;
mod predictor;
mod rounding;
mod solvers;
mod state;
mod strips;
#[cfg(test)]
mod tests;
mod transfer;

use std::sync::Arc;

use crate::fem::{Mesh, QuadratureRule, Space};
use crate::linalg::LinalgError;
use crate::physics::{Effect, Effects, Interval, LedgerTerms, surface_area};
use crate::scene::{
    Boundary, Iteration, LinearMethod, Quadrature, Scene, Solver, TimeScheme, Timetable,
};

use director::{DirectorStep, SolveOptions};
use energy_law::Half;
use membrane::{MembraneStep, NewtonOptions, StepContext, StoppingCriterion, Work};
use predictor::Predictor;
use solvers::selection::{Selection, Verdict};
use strips::Strips;

pub use checkpoint::{RestoreError, SchemeCheckpoint};
pub use error::StepError;
pub use initial::{InitialError, initial_fields};
pub use state::{Phase, State, StepReport};
pub use transfer::TransferError;

/// Degree of the polynomials by which the guess of a step is extrapolated. At Table 1 with lumped
/// quadrature the 50th step takes 31 Krylov iterations with degree 1, 21 with 2, 7 with 3 and 9 with 4, where
/// what the tolerance leaves of earlier steps is amplified.
const EXTRAPOLATION: usize = 3;

/// A step whose energy rises by more than this, over S, is solved more tightly: half of what "the energy
/// never rises" allows.
const RISE: f64 = 5e-13;

/// Steps of first order at the start and after an event.
const STARTING_STEPS: u32 = 2;

/// What the iterations may leave of φ, over the bound of a step's error.
const SHARE_OF_BOUND: f64 = 0.05;

/// The error of a step of the secant scheme over Δt³ times the third divided difference of φ.
const LOCAL_ERROR: f64 = 0.5;

/// The scheme on a mesh with the effects of a scene, and the state that it has reached.
#[derive(Debug)]
pub struct Scheme {
    space: Space,
    effects: Effects,
    /// B(φ⁰), of which β is a fraction.
    initial_area: f64,
    /// What changes, and the parameters of the last step; without the scene's mesh and shape.
    timetable: Timetable,
    parameters: Scene,
    solver: Solver,
    state: State,
    next: State,
    strips: Strips,
    terms: LedgerTerms,
    director: Option<DirectorStep>,
    membrane: MembraneStep,
    history: Predictor,
    /// Which linear solver and which iteration run.
    selection: Selection,
    stopping: StoppingCriterion,
    /// The clock of the history: only differences matter.
    t: f64,
    report: StepReport,
    next_report: StepReport,
    /// The work that changes of parameters have done since the last step that was accepted: by how much the energy of the
    /// same state is another one.
    change_work: Option<f64>,
    /// Of a scene.
    scheme: TimeScheme,
    /// Steps of first order that are still to be taken before those of the secant scheme: it does not damp what is stiff.
    starting: u32,
    /// By which scheme each solve of substep 1 was done in the present step.
    director_schemes: [TimeScheme; 2],
    /// The director in the middle of a step of the secant scheme.
    middle: Option<[Vec<f64>; 2]>,
    /// Δt of the step that waits to be accepted, and the iterations that the last one took.
    tried: Option<f64>,
    tried_work: [u32; 3],
    /// Where a step began that is taken in halves.
    start: Option<Box<Start>>,
    /// The time of the last step, as it was given to the effects.
    interval: Option<Interval>,
}

/// The state that a step begins with.
#[derive(Debug)]
struct Start {
    state: State,
    report: StepReport,
    t: f64,
    change_work: Option<f64>,
    parameters: Scene,
}

impl Scheme {
    /// The scheme of a scene from given nodal values of φ⁰ and d⁰.
    ///
    /// # Errors
    /// What the analysis of the sparse factor may run into.
    pub fn new(
        scene: &Scene,
        mesh: Arc<Mesh>,
        phi: Vec<f64>,
        director: Option<[Vec<f64>; 2]>,
    ) -> Result<Self, LinalgError> {
        let space = space_on(mesh, scene.solver.quadrature);
        let initial_area = surface_area(&space, &phi, scene.membrane.interface_width);
        let timetable = Timetable::of(scene);
        // Changes at the time 0 come after the initial state.
        let parameters = timetable.start().clone();
        Self::on_space(
            (timetable, parameters),
            space,
            initial_area,
            (phi, director),
        )
    }

    /// The scheme on a space, from any φ and d, given B(φ⁰), with the parameters of a scene that follow a timetable.
    fn on_space(
        (timetable, parameters): (Timetable, Scene),
        space: Space,
        initial_area: f64,
        (phi, director): (Vec<f64>, Option<[Vec<f64>; 2]>),
    ) -> Result<Self, LinalgError> {
        let scene = &parameters;
        let effects = Effects::from_scene(scene, &space, initial_area);
        let clamped = scene.boundary == Boundary::Clamped;
        let membrane = MembraneStep::new(
            &space,
            &scene.membrane,
            scene.solver.law_tolerance,
            clamped,
            scene.solver.linear,
        )?;
        let director_step = scene
            .nematic
            .as_ref()
            .map(|nematic| DirectorStep::new(&space, nematic.mobility));
        let selection = Selection::new(membrane.linear_method());
        let zeros = vec![0.0; space.nodes()];
        let state = State {
            phi,
            omega: zeros.clone(),
            mu: zeros,
            director,
        };
        let middle = state.director.clone();
        let mut solver = scene.solver;
        if let Some((bound, _)) = scene.time.error_bound() {
            // What the iterations leave is magnified in the divided difference that the error is estimated by.
            solver.tolerance = solver.tolerance.min(SHARE_OF_BOUND * bound);
        }
        let (scheme, linear) = (scene.time.scheme, scene.solver.linear);
        let is_chosen = scene.time.tolerance.is_some();
        let mut scheme = Self {
            next: state.clone(),
            strips: Strips::new(&space, state.director.is_some()),
            terms: LedgerTerms::default(),
            space,
            effects,
            initial_area,
            timetable,
            parameters,
            solver,
            state,
            director: director_step,
            membrane,
            history: Predictor::new(EXTRAPOLATION),
            selection,
            stopping: StoppingCriterion::LastChange,
            t: 0.0,
            report: StepReport::default(),
            next_report: StepReport::default(),
            change_work: None,
            scheme,
            starting: STARTING_STEPS,
            director_schemes: [scheme; 2],
            middle,
            tried: None,
            tried_work: [0; 3],
            start: None,
            interval: None,
        };
        if is_chosen && linear == LinearMethod::Automatic {
            scheme.begin_with_factor()?;
        }
        scheme.start();
        Ok(scheme)
    }

    /// Chosen steps are soon so long that the factor is faster: Table 1's run took 5 % longer where that was
    /// found out by ten slow solves.
    fn begin_with_factor(&mut self) -> Result<(), LinalgError> {
        if self.membrane.is_fast() {
            self.membrane.fall_back(&self.space)?;
            self.selection.begin_with_factor();
        }
        Ok(())
    }

    /// ω⁰ and μ⁰ of φ⁰, and the report of the initial state.
    fn start(&mut self) {
        self.membrane.solve_at_rest(
            &self.space,
            &mut self.effects,
            &mut self.strips,
            &mut self.state,
        );
        self.evaluate_present_energies();
        self.report.phase_integral = self.space.integrate_nodal(&self.state.phi);
        self.history.push(self.t, &self.state);
    }

    /// The space.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// The state that was reached.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The report of the last step, or of the initial state.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// How the linear systems of substep 2 are solved at present: "transform" or "shifted", the fast
    /// paths, or "factor".
    pub fn linear_method(&self) -> &'static str {
        self.membrane.linear_method()
    }

    /// What the fast path is called in messages, in use or not; `None` where there is none.
    pub fn fast_method(&self) -> Option<&'static str> {
        self.membrane.fast_method()
    }

    /// Whether the transform of the grid is in use.
    pub fn uses_transform(&self) -> bool {
        self.linear_method() == "transform"
    }

    /// Whether the sparse factor of all fields is in use.
    pub fn uses_factor(&self) -> bool {
        !self.membrane.is_fast()
    }

    /// Adds an effect for the state as it is. The energies are evaluated again, so that the law of the next step starts
    /// from those that it ends with.
    pub fn add_effect(&mut self, effect: impl Effect + 'static) {
        self.effects.add(effect);
        self.evaluate_present_energies();
        self.report.ledger.clear();
        self.forget();
    }

    /// The effects.
    pub fn effects_mut(&mut self) -> &mut Effects {
        &mut self.effects
    }

    /// Takes one step of length Δt. On an error the state is what it was.
    ///
    /// # Errors
    /// [`StepError`]: the step was not solved.
    pub fn step(&mut self, dt: f64) -> Result<&StepReport, StepError> {
        self.try_step(dt, &mut |_| ())?;
        Ok(self.accept())
    }

    /// Tries a step of length Δt. The state changes only with [`accept`](Self::accept). `watch` is called at the end of every
    /// phase, for the scheme has no clock. Returns the estimated error of φ in this step, in L2, from the last states:
    /// Δt²/2 ‖φ_tt‖ for a step of first order, Δt³/12 ‖φ_ttt‖ for one of second order; `None` where there are too few states.
    ///
    /// # Errors
    /// [`StepError`]: the step was not solved.
    pub fn try_step(
        &mut self,
        dt: f64,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<Option<f64>, StepError> {
        self.tried = None;
        self.set_interval(dt);
        let energy_scale = self.energy_scale(&self.report.energies);
        let scheme = self.next_scheme();
        // By the scheme of the run: its first steps are no more accurate than those that follow.
        self.stopping = match self.scheme {
            TimeScheme::FirstOrder => StoppingCriterion::LastChange,
            TimeScheme::Secant => StoppingCriterion::ChangesToCome,
        };
        self.history
            .extrapolate(self.t + dt, self.scheme, &mut self.next);
        let mut report = std::mem::take(&mut self.next_report);
        let outcome = self.solve_step((dt, scheme), energy_scale, &mut report, watch);
        self.tried_work = [report.newton, report.krylov, report.director_iterations];
        self.next_report = report;
        if let Err(error) = outcome {
            self.membrane.forget();
            return Err(error);
        }
        self.tried = Some(dt);
        let weights = self.space.nodal_weights();
        let (order, factor) = match scheme {
            TimeScheme::FirstOrder => (2, dt * dt),
            TimeScheme::Secant => (3, LOCAL_ERROR * dt * dt * dt),
        };
        let size = self
            .history
            .divided_difference(order, self.t + dt, &self.next.phi, weights);
        Ok(size.map(|size| factor * size))
    }

    /// Moves to the state of the step that was tried last; without one it does nothing.
    pub fn accept(&mut self) -> &StepReport {
        self.start = None;
        self.accept_tried()
    }

    fn accept_tried(&mut self) -> &mut StepReport {
        if let Some(dt) = self.tried.take() {
            self.next_report.change_work = self.change_work.take();
            std::mem::swap(&mut self.report, &mut self.next_report);
            std::mem::swap(&mut self.state, &mut self.next);
            self.t += dt;
            if self.is_at_start() {
                // What was stiff before it says nothing of what follows.
                self.history.forget();
            }
            self.history.push(self.t, &self.state);
            self.starting = self.starting.saturating_sub(1);
            if let Some(director) = &mut self.director {
                director.accept();
            }
        }
        &mut self.report
    }

    /// Iterations of Newton's method, of Krylov's and of the director in the step that was tried last.
    pub fn tried_work(&self) -> [u32; 3] {
        self.tried_work
    }

    /// Whether no step was taken since the start or an event: nothing is known of the error of the next one.
    pub fn is_at_start(&self) -> bool {
        self.starting == STARTING_STEPS
    }

    /// Tries the first step after the start or an event, of length Δt: once whole and once in two halves, all of first order.
    /// Returns the distance of the two φ in L2, which estimates the error where no earlier states can. The scheme then
    /// stands at the end of the halves, until [`accept`](Self::accept) or [`refuse`](Self::refuse).
    ///
    /// # Errors
    /// [`StepError`]: the step was not solved; the state is what it was.
    pub fn try_in_halves(
        &mut self,
        dt: f64,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<f64, StepError> {
        self.set_interval(dt);
        let start = Start {
            state: self.state.clone(),
            report: self.report.clone(),
            t: self.t,
            change_work: self.change_work,
            parameters: self.parameters.clone(),
        };
        self.try_step(dt, watch)?;
        let whole = self.next.phi.clone();
        let mut work = self.tried_work;
        self.start = Some(Box::new(start));
        let mut sum: Option<StepReport> = None;
        for _ in 0..2 {
            let outcome = self.try_step(0.5 * dt, watch);
            work.iter_mut()
                .zip(self.tried_work)
                .for_each(|(sum, part)| *sum += part);
            self.tried_work = work;
            if let Err(error) = outcome {
                self.refuse();
                return Err(error);
            }
            let report = self.accept_tried();
            if let Some(first) = sum.take() {
                report.add(first);
            }
            sum = Some(report.clone());
        }
        let weights = self.space.nodal_weights();
        let nodes = whole.iter().zip(&self.state.phi).zip(weights);
        let squares = nodes.map(|((whole, halves), weight)| weight * (whole - halves).powi(2));
        Ok(squares.sum::<f64>().sqrt())
    }

    /// Goes back to the state before the step that was tried last.
    pub fn refuse(&mut self) {
        self.tried = None;
        if let Some(start) = self.start.take() {
            let Start {
                state,
                report,
                t,
                change_work,
                parameters,
            } = *start;
            if parameters != self.parameters {
                self.set_parameters(parameters);
            }
            (self.state, self.report, self.t) = (state, report, t);
            self.change_work = change_work;
            self.forget();
        }
    }

    /// The scheme of the next step.
    fn next_scheme(&self) -> TimeScheme {
        match self.starting {
            0 => self.scheme,
            _ => TimeScheme::FirstOrder,
        }
    }

    /// Forgets what the guess of the next step is made from: to be called when the equations or the
    /// state change from outside.
    pub fn forget(&mut self) {
        self.history.forget();
        self.history.push(self.t, &self.state);
        self.starting = STARTING_STEPS;
        self.tried = None;
        self.membrane.forget();
        if let Some(director) = &mut self.director {
            director.forget();
        }
    }

    /// One step from the state, from the guess of φ, ω and μ that stands in `next`, to there.
    ///
    /// A step of the secant scheme has three parts: the director over half of it, the membrane over the whole, the director
    /// over the other half.
    fn solve_step(
        &mut self,
        (dt, scheme): (f64, TimeScheme),
        energy_scale: f64,
        report: &mut StepReport,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<(), StepError> {
        report.director_iterations = 0;
        let part = (scheme.weight() * dt, scheme, Half::First);
        let dissipated = self.director_substep(part, energy_scale, report, watch)?;
        self.terms.reset();
        let scale = energy_scale + self.add_terms(Half::First).abs();
        self.membrane.begin(
            &self.space,
            &self.effects,
            &mut self.strips,
            (&self.state.phi, self.next.director.as_ref()),
            scheme,
        );
        let mut effort = self.solve_with_fallbacks((dt, scheme), scale, report, watch)?;
        let (work, mut closed) =
            self.finish((dt, scheme), energy_scale, dissipated, report, watch)?;
        let rise = report.total_energy - self.report.total_energy - work;
        if closed.is_ok() && rise > RISE * scale {
            // Near a state of rest even a residual within the tolerance is more than what dissipates.
            let options = self.options(Iteration::Newton);
            if scheme == TimeScheme::Secant {
                std::mem::swap(&mut self.middle, &mut self.next.director);
            }
            let mut context = StepContext {
                space: &self.space,
                effects: &mut self.effects,
                strips: &mut self.strips,
                from: &self.state,
                to: &mut self.next,
                dt,
                scheme,
                energy_scale: scale,
                is_faint: false,
                watch,
            };
            self.membrane.refine(&mut context, options, &mut effort)?;
            (_, closed) = self.finish((dt, scheme), energy_scale, dissipated, report, watch)?;
        }
        report.newton = effort.newton;
        report.krylov = effort.krylov;
        report.damping = effort.damping;
        report.algebraic_error = effort.error;
        watch(Phase::Ledger);
        closed
    }

    /// What follows substep 2: in the secant scheme the second half of substep 1, and then the energy law. Returns the work from
    /// outside, and whether the law holds.
    fn finish(
        &mut self,
        (dt, scheme): (f64, TimeScheme),
        energy_scale: f64,
        mut dissipated: f64,
        report: &mut StepReport,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<(f64, Result<(), StepError>), StepError> {
        self.terms.reset();
        let mut work = self.add_terms(Half::First);
        if scheme == TimeScheme::Secant {
            let part = (0.5 * dt, scheme, Half::Second);
            dissipated += self.director_substep(part, energy_scale, report, watch)?;
            work += self.add_terms(Half::Second);
        }
        let closed = self.check_energy_law((dt, scheme), [work, dissipated], report);
        Ok((work, closed))
    }

    /// Substep 1, over a time of this length: with φⁿ from dⁿ, or the second time in a step with the new φ from the director
    /// that the first one led to. Returns what the director's mobility dissipates, Δt γ_nem ‖z‖².
    fn director_substep(
        &mut self,
        (dt, scheme, half): (f64, TimeScheme, Half),
        energy_scale: f64,
        report: &mut StepReport,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<f64, StepError> {
        let mut options = SolveOptions {
            dt,
            scheme,
            is_second: half == Half::Second,
            tolerance: director_tolerance(&self.solver, scheme),
            law_tolerance: self.solver.law_tolerance,
            is_faint: energy_scale <= self.membrane.least_energy(),
            energy_scale,
        };
        if half == Half::Second {
            std::mem::swap(&mut self.middle, &mut self.next.director);
        }
        let next = &mut self.next;
        let (phi, from) = match half {
            Half::First => (&self.state.phi, &self.state.director),
            Half::Second => (&next.phi, &self.middle),
        };
        let (Some(step), Some(from), Some(to)) = (&mut self.director, from, &mut next.director)
        else {
            return Ok(0.0);
        };
        let (space, effects) = (&self.space, &self.effects);
        let mut outcome = step.solve(space, effects, options, (phi, from), to);
        if scheme == TimeScheme::Secant && outcome.is_err() {
            // A director that is far faster than the step is long follows at once, and must be damped.
            options.scheme = TimeScheme::FirstOrder;
            options.tolerance = director_tolerance(&self.solver, options.scheme);
            outcome = step.solve(space, effects, options, (phi, from), to);
        }
        report.director_iterations += outcome?;
        self.director_schemes[half as usize] = options.scheme;
        watch(Phase::Director);
        Ok(step.dissipation(space, dt))
    }

    /// Whether the membrane of the state hardly bends, as one that is at rest in φ = ±1: by no more than what the
    /// energy law can be told of.
    fn bends_faintly(&self) -> bool {
        // Bending comes first.
        let bending = self.report.energies.first();
        bending.is_some_and(|energy| energy.value <= self.membrane.least_energy())
    }

    fn options(&self, iteration: Iteration) -> NewtonOptions {
        NewtonOptions {
            iteration,
            stopping: self.stopping,
            tolerance: self.solver.tolerance,
            law_tolerance: self.solver.law_tolerance,
        }
    }

    /// Substep 2, by the first way that succeeds: the scene's iteration; Newton's method in place of the
    /// lagged one; the factor in place of the transform of the grid. A way that failed is left alone for a
    /// while.
    fn solve_with_fallbacks(
        &mut self,
        (dt, scheme): (f64, TimeScheme),
        energy_scale: f64,
        report: &mut StepReport,
        watch: &mut (dyn FnMut(Phase) + Send),
    ) -> Result<Work, StepError> {
        if self.selection.retries_fast(dt) {
            self.membrane.return_to_fast();
        }
        let iteration = self.selection.iteration(self.solver.iteration, dt);
        let (options, newton) = (self.options(iteration), self.options(Iteration::Newton));
        let is_faint = self.bends_faintly();
        let mut context = StepContext {
            space: &self.space,
            effects: &mut self.effects,
            strips: &mut self.strips,
            from: &self.state,
            to: &mut self.next,
            dt,
            scheme,
            energy_scale,
            is_faint,
            watch,
        };
        report.fallback = None;
        report.newton_took_over = None;
        report.refused_ways = 0;
        let mut outcome = self.membrane.solve(&mut context, options);
        if iteration == Iteration::Lagged
            && let Err(reason) = outcome
        {
            report.refused_ways += 1;
            report.newton_took_over = Some(reason);
            self.selection.lagged_failed(dt);
            context.restart();
            outcome = self.membrane.solve(&mut context, newton);
        }
        if self.membrane.is_fast()
            && self.solver.linear == LinearMethod::Automatic
            && let Err(reason) = outcome
        {
            report.refused_ways += 1;
            report.fallback = Some(reason);
            self.selection.fast_failed(dt);
            self.membrane
                .fall_back(context.space)
                .map_err(|source| StepError::Membrane {
                    iteration: 0,
                    source,
                })?;
            context.restart();
            outcome = self.membrane.solve(&mut context, newton);
        }
        let Ok(work) = &outcome else {
            return outcome;
        };
        self.selection.solved(!self.membrane.is_fast());
        if self.solver.linear == LinearMethod::Automatic && self.membrane.is_fast() {
            match self.selection.judge(work.newton, work.krylov) {
                // The step is solved; without memory for the factor the fast solver goes on.
                Verdict::TooSlow => {
                    if self.membrane.fall_back(&self.space).is_ok() {
                        self.selection.fast_was_slow(dt);
                    }
                }
                // The factor takes more memory than all the rest.
                Verdict::Fast => self.membrane.drop_factor(),
                Verdict::Undecided => {}
            }
        }
        outcome
    }
}

/// The space on a mesh with the rule of a scene.
fn space_on(mesh: Arc<Mesh>, quadrature: Quadrature) -> Space {
    let rule = match quadrature {
        Quadrature::Consistent => QuadratureRule::Consistent,
        Quadrature::Lumped => QuadratureRule::Lumped,
    };
    Space::new(mesh, rule)
}

/// The relative residual to which substep 1 is solved, at least. It is relative to the force, whose work is in
/// general a small part of the energy, so the energy law misses by far less than its tolerance. In the secant scheme the law
/// is looked at too.
fn director_tolerance(solver: &Solver, scheme: TimeScheme) -> f64 {
    match scheme {
        TimeScheme::FirstOrder => solver.law_tolerance.clamp(1e-14, 1e-8),
        TimeScheme::Secant => solver.tolerance,
    }
}
