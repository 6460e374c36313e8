//! What is reported of a step.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{ErrorEstimates, OutlineMeasure, StepEffort, Vesicle};
use crate::physics::NamedValue;
use crate::scheme::{Phase, StepReport};

/// The scalars of one step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// n, counting accepted steps; 0 is the initial state.
    pub step: u64,
    /// t_n.
    pub t: f64,
    /// The smallest Δt that was used.
    pub dt: f64,
    /// Attempts at this step that were refused because their error was too large or they could not be
    /// solved; only where Δt is chosen.
    pub refused: u32,
    /// Nothing moves any more, by `[rest]` of the scene: the run is over.
    pub is_at_rest: bool,
    /// The estimated error of φ in this step, in L2.
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
    pub budget: ErrorEstimates,
    /// What the parts of the step took.
    pub costs: Costs,
    /// Every term of (3.26), times Δt.
    pub ledger: Vec<NamedValue>,
    /// What it took to solve the step.
    pub effort: StepEffort,
    /// The vesicles, pieces of the region φ > 0, from left to right.
    pub vesicles: Vec<Vesicle>,
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

    /// Part by part: the mean over `count`; zero if `count` is 0.
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
    /// The vesicle, if there is exactly one: sizes of several together have no meaning.
    pub fn only_vesicle(&self) -> Option<&Vesicle> {
        match &self.vesicles[..] {
            [vesicle] => Some(vesicle),
            _ => None,
        }
    }

    /// The size of the vesicle, if there is exactly one.
    pub fn outline(&self) -> Option<OutlineMeasure> {
        self.only_vesicle()?.outline
    }

    /// By how much the energy rose in the step beyond the work that was done on it from outside, which
    /// the energy law forbids; `None` without a ledger. A switched energy is another one, and no rise.
    pub fn unexplained_rise(&self) -> Option<f64> {
        let counts = |term: &&NamedValue| term.name == "dE" || term.is_work();
        let terms = self.ledger.iter().filter(counts);
        (!self.ledger.is_empty()).then(|| terms.map(|term| term.value).sum())
    }

    /// The work that changes of parameters have done before the step: by how much E_total rose by them alone.
    pub fn change_work(&self) -> f64 {
        let term = self.ledger.iter().find(|term| term.name == "change_work");
        term.map_or(0.0, |term| -term.value)
    }

    /// S, the scale of the energy law: the sum of the absolute energies, and the absolute work that was done
    /// from outside.
    pub fn law_scale(&self) -> f64 {
        let energies: f64 = self.energies.iter().map(|it| it.value.abs()).sum();
        let works = self.ledger.iter().filter(|term| term.is_work());
        energies + works.map(|term| term.value).sum::<f64>().abs()
    }

    pub(super) fn take(&mut self, step: &StepReport) {
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

    /// Adds iterations: of substep 2, Krylov's, of substep 1.
    pub(super) fn add_work(&mut self, work: [u32; 3]) {
        let sums = [
            &mut self.newton,
            &mut self.krylov,
            &mut self.director_iterations,
        ];
        for (sum, more) in sums.into_iter().zip(work) {
            *sum = sum.saturating_add(more);
        }
    }

    /// Takes a further part of the same step.
    pub(super) fn add(&mut self, part: &StepReport) {
        let work = [self.newton, self.krylov, self.director_iterations];
        let law_residual = self.law_residual;
        let ledger = std::mem::take(&mut self.ledger);
        self.take(part);
        self.add_work(work);
        if law_residual.abs() > self.law_residual.abs() {
            self.law_residual = law_residual;
        }
        NamedValue::add_all(&mut self.ledger, ledger);
    }
}
