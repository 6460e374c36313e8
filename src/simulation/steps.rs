//! The steps of a run: those of a fixed grid, divided where they cannot be solved whole, and those whose length is chosen.

use super::controller::Controller;
use super::last_whole_step::LastWholeStep;
use super::partial_step::{PartialStep, StepDetails, StepOutcome};

use super::{Event, EventKind, Pacing, Simulation, SimulationError, StepProgress, grid_time};
use crate::scheme::{Phase, StepError};

impl Simulation {
    /// The next step of the fixed grid, or what is left of it.
    pub(super) fn grid_step(
        &mut self,
        left: Option<PartialStep>,
        watch: &mut (dyn FnMut(Phase) + Send),
        leave: &mut dyn FnMut(&StepProgress) -> bool,
    ) -> Result<StepOutcome, SimulationError> {
        let step = self.report.step + 1;
        let dt = self.scene.time.step;
        let (begin, end) = (grid_time(step - 1, dt), grid_time(step, dt));
        let mut taken = StepDetails::begin(left.as_ref(), !self.scheme.uses_factor());
        let Pacing::Fixed(subdivision) = &mut self.pacing else {
            return Ok(StepOutcome::Whole(taken));
        };
        if left.is_none() {
            subdivision.begin();
        }
        // Of the parts that were solved before the step was interrupted.
        let mut earlier = left.filter(|left| left.details.effort.parts > 0);
        let mut is_begun = false;
        let mut has_news = false;
        loop {
            let piece = dt * subdivision.piece();
            let underway = StepProgress {
                step,
                t: self.report.t,
                end,
                dt: piece,
                parts: taken.effort.parts,
                refused: taken.effort.refused,
            };
            if has_news || is_begun && leave(&underway) {
                let sums = earlier.unwrap_or_else(|| PartialStep::of(&self.report));
                return Ok(taken.interrupt(underway, sums));
            }
            is_begun = true;
            // What is solved next is a part of the step.
            if piece < dt && self.last_whole.is_none() {
                self.last_whole = Some(Box::new(LastWholeStep {
                    report: self.report.clone(),
                    state: self.scheme.state().clone(),
                }));
            }
            let mut error = None;
            let (threads, scheme) = (&self.threads, &mut self.scheme);
            let outcome = threads.run(|| {
                scheme.try_step(piece, watch).map(|estimate| {
                    error = estimate;
                    scheme.accept()
                })
            });
            match outcome {
                Ok(solved) => {
                    taken.note(solved);
                    let first = taken.effort.parts == 0 || earlier.is_some();
                    let with_factor = self.scheme.uses_factor();
                    let solved = self.scheme.report();
                    taken.effort.accept(solved, with_factor);
                    if first {
                        self.report.take(solved);
                        self.report.time_error = error;
                        if let Some(earlier) = earlier.take() {
                            earlier.add_to(&mut self.report);
                        }
                    } else {
                        self.report.add(solved);
                        let sum = self.report.time_error.zip(error);
                        self.report.time_error = sum.map(|(sum, error)| sum + error);
                    }
                    self.report.dt = dt * subdivision.smallest();
                    if subdivision.accept() {
                        break;
                    }
                    self.report.t = begin + dt * subdivision.done();
                }
                Err(reason) => {
                    taken.effort.refuse();
                    let shortest = dt * subdivision.smallest();
                    if !subdivision.refuse() {
                        let steps = [dt, dt * subdivision.smallest()];
                        return Err(SimulationError::Step {
                            step,
                            t: end,
                            tried: Box::new(self.tried(&taken, steps)),
                            source: reason,
                        });
                    }
                    let lengths = [shortest, dt * subdivision.smallest()];
                    if let Some(kind) = EventKind::of_short_steps(lengths, dt, &reason) {
                        let t = self.report.t;
                        self.events.push(Event { step, t, kind });
                        has_news = true;
                    }
                    taken.divided = Some(reason.to_string());
                }
            }
        }
        self.report.step = step;
        self.report.t = end;
        Ok(StepOutcome::Whole(taken))
    }

    /// A step whose length is chosen.
    pub(super) fn chosen_step(
        &mut self,
        mut controller: Controller,
        left: Option<PartialStep>,
        watch: &mut (dyn FnMut(Phase) + Send),
        leave: &mut dyn FnMut(&StepProgress) -> bool,
    ) -> Result<StepOutcome, SimulationError> {
        let (step, t) = (self.report.step + 1, self.report.t);
        let landing = self.landing_after(t);
        let mut taken = StepDetails::begin(left.as_ref(), !self.scheme.uses_factor());
        let mut work = left.map_or([0; 3], |left| left.work);
        let (mut is_begun, mut has_news) = (false, false);
        let longest = controller.attempt(t, landing).dt;
        loop {
            let attempt = controller.attempt(t, landing);
            let underway = StepProgress {
                step,
                t,
                end: attempt.end,
                dt: attempt.dt,
                parts: 0,
                refused: taken.effort.refused,
            };
            if has_news || is_begun && leave(&underway) {
                self.pacing = Pacing::Chosen(controller);
                let sums = PartialStep {
                    work,
                    ..PartialStep::default()
                };
                return Ok(taken.interrupt(underway, sums));
            }
            is_begun = true;
            let is_first = self.scheme.is_at_start();
            let (threads, scheme) = (&self.threads, &mut self.scheme);
            let outcome = threads.run(|| match is_first {
                true => scheme.try_in_halves(attempt.dt, watch).map(Some),
                false => scheme.try_step(attempt.dt, watch),
            });
            let (again, reason) = match outcome {
                // The few after the first, of which nothing is known either, are as long as that one.
                Ok(estimate)
                    if estimate.is_none_or(|error| controller.judge(attempt.dt, error)) =>
                {
                    let solved = self.scheme.accept();
                    taken.note(solved);
                    self.report.refused = taken.effort.refused.try_into().unwrap_or(u32::MAX);
                    let with_factor = self.scheme.uses_factor();
                    let solved = self.scheme.report();
                    taken.effort.accept(solved, with_factor);
                    self.report.take(solved);
                    self.report.add_work(work);
                    self.report.time_error = estimate;
                    self.report.dt = attempt.dt;
                    self.report.t = attempt.end;
                    self.report.step = step;
                    if is_first {
                        controller.stay(attempt.dt);
                    }
                    if self.is_jump(attempt.end) {
                        controller.forget();
                        self.scheme.forget();
                    }
                    self.pacing = Pacing::Chosen(controller);
                    return Ok(StepOutcome::Whole(taken));
                }
                Ok(estimate) => {
                    self.scheme.refuse();
                    let error = estimate.unwrap_or_default();
                    let tried = self.scheme.tried_work();
                    work.iter_mut()
                        .zip(tried)
                        .for_each(|(sum, one)| *sum = u32::saturating_add(*sum, one));
                    let tolerance = self.scene.time.tolerance.unwrap_or_default();
                    let reason = StepError::Inaccurate { error, tolerance };
                    (controller.may_go_on(), reason)
                }
                Err(reason) => (controller.fail(attempt.dt), reason),
            };
            taken.effort.refuse();
            let lengths = [attempt.dt, controller.attempt(t, landing).dt];
            let first = self.scene.time.step;
            if let Some(kind) = EventKind::of_short_steps(lengths, first, &reason) {
                self.events.push(Event { step, t, kind });
                has_news = true;
            }
            if !again {
                return Err(SimulationError::Step {
                    step,
                    t: attempt.end,
                    tried: Box::new(self.tried(&taken, [longest, attempt.dt])),
                    source: reason,
                });
            }
        }
    }
}
