//! Steps that take more than one attempt, and may be left between two of them: to save the state, or
//! because the run ends. The step continues later as if nothing had happened.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Costs, Report, StepEffort};
use crate::scheme::{StepError, StepReport};

/// A hard step, between two attempts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepProgress {
    /// Its number.
    pub step: u64,
    /// How far the state is.
    pub t: f64,
    /// Where the step ends if all goes well.
    pub end: f64,
    /// The Δt that is tried next.
    pub dt: f64,
    /// In how many parts it was solved so far.
    pub parts: u64,
    /// How many attempts failed so far.
    pub refused: u64,
}

impl fmt::Display for StepProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            step,
            t,
            end,
            dt,
            parts,
            refused,
        } = self;
        write!(
            f,
            "step {step} takes long: it is at t = {t:.3e} of {end:.3e}, after {parts} parts and {refused} \
             attempts that failed, with \u{394}t = {dt:.1e} next"
        )
    }
}

/// What was done of a step that was interrupted, beyond what the state holds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct PartialStep {
    /// Where it was interrupted.
    pub(super) underway: Option<StepProgress>,
    pub(super) details: StepDetails,
    /// Iterations of its parts, or of the attempts that were refused: of substep 2, Krylov's, of
    /// substep 1.
    pub(super) work: [u32; 3],
    /// The sum of its parts' ledgers.
    pub(super) ledger: Vec<f64>,
    /// The largest of its parts.
    pub(super) law_residual: f64,
    /// The sum of its parts.
    pub(super) time_error: Option<f64>,
    /// What it has taken on the clock.
    pub(super) costs: Costs,
}

/// What is reported of a step beyond its report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct StepDetails {
    /// Whether the step began without the sparse factor.
    pub(super) was_fast: bool,
    /// How hard it was to solve.
    pub(super) effort: StepEffort,
    /// Why it was divided.
    pub(super) divided: Option<String>,
    /// Why the fast linear solver gave way to the factor.
    #[serde(serialize_with = "to_words", deserialize_with = "from_words")]
    pub(super) fallback: Option<StepError>,
    /// Why Newton's method took over from the lagged iteration.
    #[serde(serialize_with = "to_words", deserialize_with = "from_words")]
    pub(super) newton_took_over: Option<StepError>,
    /// The work of changes of parameters.
    pub(super) change_work: Option<f64>,
}

/// How an attempt at a step ends.
#[derive(Debug)]
pub(super) enum StepOutcome {
    /// The step was taken.
    Whole(StepDetails),
    /// It was interrupted before its end.
    Interrupted(PartialStep),
}

impl StepDetails {
    /// Those of a step that begins or continues. `is_fast`: without the sparse factor.
    pub(super) fn begin(left: Option<&PartialStep>, is_fast: bool) -> Self {
        let new = || Self {
            was_fast: is_fast,
            ..Self::default()
        };
        left.map_or_else(new, |left| left.details.clone())
    }

    /// Takes note of a step of the scheme.
    pub(super) fn note(&mut self, solved: &StepReport) {
        if self.fallback.is_none() {
            self.fallback.clone_from(&solved.fallback);
        }
        if self.newton_took_over.is_none() {
            self.newton_took_over.clone_from(&solved.newton_took_over);
        }
        if let Some(work) = solved.change_work {
            *self.change_work.get_or_insert(0.0) += work;
        }
    }

    /// What is left of the step, given the sums of its report.
    pub(super) fn interrupt(self, underway: StepProgress, sums: PartialStep) -> StepOutcome {
        StepOutcome::Interrupted(PartialStep {
            underway: Some(underway),
            details: self,
            ..sums
        })
    }
}

impl PartialStep {
    /// The sums that the report of its parts so far has.
    pub(super) fn of(report: &Report) -> Self {
        Self {
            work: [report.newton, report.krylov, report.director_iterations],
            ledger: report.ledger.iter().map(|term| term.value).collect(),
            law_residual: report.law_residual,
            time_error: report.time_error,
            ..Self::default()
        }
    }

    /// Adds them to the report of the next part, in the order in which they would have been added.
    pub(super) fn add_to(self, report: &mut Report) {
        report.add_work(self.work);
        if self.law_residual.abs() > report.law_residual.abs() {
            report.law_residual = self.law_residual;
        }
        for (sum, term) in report.ledger.iter_mut().zip(self.ledger) {
            sum.value += term;
        }
        let sum = self.time_error.zip(report.time_error);
        report.time_error = sum.map(|(sum, error)| sum + error);
    }
}

/// An error goes to a file in words.
fn to_words<S: Serializer>(error: &Option<StepError>, to: S) -> Result<S::Ok, S::Error> {
    error.as_ref().map(ToString::to_string).serialize(to)
}

fn from_words<'de, D: Deserializer<'de>>(from: D) -> Result<Option<StepError>, D::Error> {
    let words: Option<String> = Deserialize::deserialize(from)?;
    Ok(words.map(StepError::Earlier))
}
