//! The last whole step of a run whose state is within the next one: what the files of a run that ends
//! there agree about.

use serde::{Deserialize, Serialize};

use super::Report;
use crate::scheme::State;

/// The last whole step: the scalars and the fields at its end.
#[derive(Debug, Clone)]
pub(super) struct LastWholeStep {
    pub(super) report: Report,
    pub(super) state: State,
}

/// The part of it that does not follow from the rest of a checkpoint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct LastWholeCheckpoint {
    state: State,
    t: f64,
    dt: f64,
    /// In the order of the effects that have an energy.
    energies: Vec<f64>,
    total_energy: f64,
    phase_integral: f64,
    surface_area: f64,
    law_residual: f64,
    work: [u32; 3],
    time_error: Option<f64>,
}

impl LastWholeStep {
    /// Copies it out.
    pub(super) fn save(&self) -> LastWholeCheckpoint {
        let report = &self.report;
        LastWholeCheckpoint {
            state: self.state.clone(),
            t: report.t,
            dt: report.dt,
            energies: report.energies.iter().map(|energy| energy.value).collect(),
            total_energy: report.total_energy,
            phase_integral: report.phase_integral,
            surface_area: report.surface_area,
            law_residual: report.law_residual,
            work: [report.newton, report.krylov, report.director_iterations],
            time_error: report.time_error,
        }
    }
}

impl LastWholeCheckpoint {
    /// Whether its fields are as long as these.
    pub(super) fn fits(&self, state: &State) -> bool {
        self.state.fits(state)
    }

    /// Puts it back: `within` is the report of the state within the step, which has everything else in
    /// common with it but the vesicle's sizes, which the caller measures.
    pub(super) fn restore(&self, within: &Report) -> LastWholeStep {
        let mut report = Report {
            t: self.t,
            dt: self.dt,
            total_energy: self.total_energy,
            phase_integral: self.phase_integral,
            surface_area: self.surface_area,
            law_residual: self.law_residual,
            time_error: self.time_error,
            ..within.clone()
        };
        [report.newton, report.krylov, report.director_iterations] = self.work;
        for (energy, value) in report.energies.iter_mut().zip(&self.energies) {
            energy.value = *value;
        }
        let state = self.state.clone();
        LastWholeStep { report, state }
    }
}
