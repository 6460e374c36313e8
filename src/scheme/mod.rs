//! One time step of the scheme (3.20)–(3.21): substep 1 (director), substep 2 (membrane), and the
//! ledger of the energy law (3.26).

mod active_region;
#[doc(hidden)]
pub mod bench_support;
mod checkpoint;
mod director;
mod energy_law;
mod error;
mod extrapolation;
mod fault_injection;
mod initial;
mod jacobian;
mod membrane;
mod predictor;
mod rounding;
mod solvers;
mod state;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::fem::{Mesh, QuadratureRule, Space};
use crate::linalg::LinalgError;
use crate::physics::{Effect, Effects, Interval, LedgerTerms};
use crate::scene::{self, Boundary, Iteration, LinearMethod, Quadrature, Scene, Solver};

use director::{DirectorStep, SolveOptions};
use extrapolation::ExtrapolatedStep;
use membrane::{MembraneStep, NewtonOptions, Scratch, StepContext, StoppingCriterion, Work};
use predictor::Predictor;
use solvers::selection::{Selection, Verdict};

pub use checkpoint::{RestoreError, SchemeCheckpoint};
pub use error::StepError;
pub use extrapolation::ErrorEstimate;
pub use initial::{InitialError, initial_fields};
pub use state::{Phase, State, StepReport};

/// Degree of the polynomials by which the guess of a step is extrapolated. At Table 1 with lumped
/// quadrature the 50th step takes 31 Krylov iterations with degree 1, 21 with 2, 7 with 3 and 9 with 4, where
/// what the tolerance leaves of earlier steps is amplified.
const EXTRAPOLATION: usize = 3;

/// A step whose energy rises by more than this, over S, is solved more tightly: half of what "the energy
/// never rises" allows.
const RISE: f64 = 5e-13;

/// The scheme on a mesh with the effects of a scene, and the state that it has reached.
#[derive(Debug)]
pub struct Scheme {
    space: Space,
    effects: Effects,
    /// The anchoring among the effects.
    anchoring: Option<scene::Anchoring>,
    solver: Solver,
    state: State,
    next: State,
    scratch: Scratch,
    terms: LedgerTerms,
    director: Option<DirectorStep>,
    membrane: MembraneStep,
    history: Predictor,
    /// Which linear solver and which iteration run.
    selection: Selection,
    /// The Δt by which the way to solve is chosen: that of the whole step, where parts of it are taken too.
    length: f64,
    /// In how many parts it is taken at most.
    parts: usize,
    stopping: StoppingCriterion,
    /// The clock of the history: only differences matter.
    t: f64,
    report: StepReport,
    next_report: StepReport,
    /// By how much the energy has jumped since the last step that was accepted.
    switched: Option<f64>,
    /// The time of the last step, as it was given to the effects.
    interval: Option<Interval>,
    /// Made with the first step that is taken in several ways.
    extrapolated: Option<Box<ExtrapolatedStep>>,
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
        let rule = match scene.solver.quadrature {
            Quadrature::Consistent => QuadratureRule::Consistent,
            Quadrature::Lumped => QuadratureRule::Lumped,
        };
        let space = Space::new(mesh, rule);
        let effects = Effects::from_scene(scene, &space, &phi);
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
        let mut scheme = Self {
            next: state.clone(),
            scratch: Scratch::new(state.director.is_some()),
            terms: LedgerTerms::default(),
            space,
            effects,
            anchoring: scene.anchoring,
            solver: scene.solver,
            state,
            director: director_step,
            membrane,
            history: Predictor::new(EXTRAPOLATION),
            selection,
            length: 0.0,
            parts: 1,
            stopping: StoppingCriterion::LastChange,
            t: 0.0,
            report: StepReport::default(),
            next_report: StepReport::default(),
            switched: None,
            interval: None,
            extrapolated: None,
        };
        if scene.time.tolerance.is_some() && scene.solver.linear == LinearMethod::Automatic {
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
            &mut self.scratch,
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

    /// Whether the cosine transform is in use.
    pub fn uses_transform(&self) -> bool {
        self.linear_method() == "transform"
    }

    /// Whether the sparse factor of all fields is in use.
    pub fn uses_factor(&self) -> bool {
        !self.membrane.is_fast()
    }

    /// Another anchoring for the state as it is (`None`: none at all). The energies are measured
    /// again, so that the law of the next step starts from those that it ends with; the report has
    /// no ledger, for no step was taken.
    pub fn set_anchoring(&mut self, anchoring: Option<&scene::Anchoring>) {
        self.effects.set_anchoring(anchoring, &self.space);
        self.anchoring = anchoring.copied();
        self.evaluate_present_energies();
        self.report.ledger.clear();
        self.report.law_residual = 0.0;
        self.forget();
    }

    /// The anchoring that is in use.
    pub fn anchoring(&self) -> Option<scene::Anchoring> {
        self.anchoring
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
        self.step_watched(dt, &mut |_| ())
    }

    /// [`step`](Self::step), telling `watch` of every phase that ends: the scheme knows no clock.
    ///
    /// # Errors
    /// [`StepError`]: the step was not solved.
    pub fn step_watched(
        &mut self,
        dt: f64,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<&StepReport, StepError> {
        self.set_interval(dt);
        let energy_scale = self.energy_scale(&self.report.energies);
        (self.length, self.parts) = (dt, 1);
        self.stopping = StoppingCriterion::LastChange;
        self.history.extrapolate(self.t + dt, &mut self.next);
        let mut report = std::mem::take(&mut self.next_report);
        let outcome = self.try_step(dt, energy_scale, &mut report, watch);
        self.next_report = report;
        match outcome {
            Ok(()) => {
                self.next_report.switched = self.switched.take();
                std::mem::swap(&mut self.report, &mut self.next_report);
                std::mem::swap(&mut self.state, &mut self.next);
                self.t += dt;
                self.history.push(self.t, &self.state);
                if let Some(director) = &mut self.director {
                    director.accept();
                }
                Ok(&self.report)
            }
            Err(error) => {
                self.forget();
                Err(error)
            }
        }
    }

    /// The estimated error of φ, in L2, that the last step of the scheme (of first order) has made:
    /// Δt²/2 ‖φ_tt‖, from the last three states; `None` where there are fewer.
    pub fn first_order_error(&self, dt: f64) -> Option<f64> {
        self.history
            .half_second_derivative(self.space.nodal_weights())
            .map(|size| dt * dt * size)
    }

    /// Forgets what the guess of the next step is made from: to be called when the equations or the
    /// state change from outside.
    pub fn forget(&mut self) {
        self.history.forget();
        self.history.push(self.t, &self.state);
        self.membrane.forget();
        if let Some(director) = &mut self.director {
            director.forget();
        }
        if let Some(extrapolated) = &mut self.extrapolated {
            extrapolated.forget();
        }
    }

    /// Tells the effects the time of the coming step. Where that makes the energy another one, what the
    /// law starts from is measured again, as when the anchoring is switched.
    fn set_interval(&mut self, dt: f64) {
        let interval = Interval {
            begin: self.t,
            length: dt,
        };
        self.interval = Some(interval);
        if !self.effects.set_interval(interval) {
            return;
        }
        let before = self.report.total_energy;
        self.evaluate_present_energies();
        self.forget();
        *self.switched.get_or_insert(0.0) += self.report.total_energy - before;
    }

    /// One step from the state, from the guess of φ, ω and μ that stands in `next`, to there.
    fn try_step(
        &mut self,
        dt: f64,
        energy_scale: f64,
        report: &mut StepReport,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<(), StepError> {
        let space = &self.space;
        report.director_iterations = 0;
        if let (Some(step), Some(from), Some(to)) = (
            &mut self.director,
            &self.state.director,
            &mut self.next.director,
        ) {
            let options = SolveOptions {
                dt,
                length: self.length,
                tolerance: director_tolerance(&self.solver),
                law_tolerance: self.solver.law_tolerance,
                is_faint: energy_scale <= self.membrane.least_energy(),
                energy_scale,
            };
            report.director_iterations = step.solve(
                space,
                &mut self.effects,
                &mut self.scratch.old,
                options,
                (&self.state.phi, from),
                to,
            )?;
            watch(Phase::Director);
        }
        let work = self.work_from_outside();
        let scale = energy_scale + work.abs();
        self.membrane.begin(
            &self.space,
            &mut self.effects,
            &mut self.scratch,
            &self.state.phi,
            self.next.director.as_ref(),
        );
        let mut effort = self.solve_with_fallbacks(dt, scale, report, watch)?;
        let mut closed = self.check_energy_law(dt, work, report);
        let rise = report.total_energy - self.report.total_energy - work;
        if closed.is_ok() && rise > RISE * scale {
            // Near a state of rest even a residual within the tolerance is more than what dissipates.
            let options = self.options(Iteration::Newton);
            let factor_dt = self.factor_dt();
            let mut context = StepContext {
                space: &self.space,
                effects: &mut self.effects,
                scratch: &mut self.scratch,
                from: &self.state,
                to: &mut self.next,
                dt,
                factor_dt,
                energy_scale: scale,
                is_faint: false,
                watch,
            };
            self.membrane.refine(&mut context, options, &mut effort)?;
            closed = self.check_energy_law(dt, work, report);
        }
        if let StoppingCriterion::ChangesToCome(known) = &mut self.stopping {
            *known = effort.contraction;
        }
        report.newton = effort.newton;
        report.krylov = effort.krylov;
        report.damping = effort.damping;
        report.algebraic_error = effort.error;
        watch(Phase::Ledger);
        closed
    }

    /// Whether the membrane of the state hardly bends, as one that is at rest in φ = ±1: by no more than what the
    /// energy law can be told of.
    fn bends_faintly(&self) -> bool {
        // Bending comes first.
        let bending = self.report.energies.first();
        bending.is_some_and(|energy| energy.value <= self.membrane.least_energy())
    }

    /// The Δt in the middle between that of the whole step and that of the shortest parts.
    fn factor_dt(&self) -> f64 {
        self.length / (self.parts as f64).sqrt()
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
    /// lagged one; the factor in place of the cosine transform. A way that failed is left alone for a
    /// while.
    fn solve_with_fallbacks(
        &mut self,
        dt: f64,
        energy_scale: f64,
        report: &mut StepReport,
        watch: &mut dyn FnMut(Phase),
    ) -> Result<Work, StepError> {
        let length = self.length;
        if self.selection.retries_fast(length) {
            self.membrane.return_to_fast();
        }
        let iteration = self.selection.iteration(self.solver.iteration, length);
        let (options, newton) = (self.options(iteration), self.options(Iteration::Newton));
        let factor_dt = self.factor_dt();
        let is_faint = self.bends_faintly();
        let mut context = StepContext {
            space: &self.space,
            effects: &mut self.effects,
            scratch: &mut self.scratch,
            from: &self.state,
            to: &mut self.next,
            dt,
            factor_dt,
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
            self.selection.lagged_failed(length);
            context.restart();
            outcome = self.membrane.solve(&mut context, newton);
        }
        if self.membrane.is_fast()
            && self.solver.linear == LinearMethod::Automatic
            && let Err(reason) = outcome
        {
            report.refused_ways += 1;
            report.fallback = Some(reason);
            self.selection.fast_failed(length);
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
                        self.selection.fast_was_slow(length);
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

/// The relative residual to which substep 1 is solved, at least. It is relative to the force, whose work is in
/// general a small part of the energy, so the energy law misses by far less than its tolerance.
fn director_tolerance(solver: &Solver) -> f64 {
    solver.law_tolerance.clamp(1e-14, 1e-8)
}
