//! Everything that later steps depend on, copied out of a scheme and put back: a step can be taken
//! back, and a run resumed from a file, bit for bit as if nothing had happened.
//!
//! What depends on the scene and the mesh alone is not in it: β, the matrices, the transform.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::director::Increments;
use super::membrane::LinearCheckpoint;
use super::predictor::Predictor;
use super::solvers::selection::Selection;
use super::{Scheme, State, StepReport};
use crate::linalg::LinalgError;
use crate::physics::{Interval, NamedValue};

/// What [`Scheme::save`] has copied. It keeps its buffers: saving again allocates nothing.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SchemeCheckpoint {
    state: State,
    /// The time of the last step, as the effects know it.
    interval: Option<Interval>,
    /// Of the effects that have one, in their order. The energy law of the next step starts from them.
    energies: Vec<f64>,
    total_energy: f64,
    /// The work of changes that belongs to the next step.
    change_work: Option<f64>,
    phase_integral: f64,
    surface_area: f64,
    /// The clock of the history.
    t: f64,
    /// Where the guesses of the next step come from.
    history: Predictor,
    increments: Option<Increments>,
    linear: LinearCheckpoint,
    selection: Selection,
    /// Steps of first order that are still to be taken.
    starting: u32,
}

/// φ and, with a director, d.
type Fields = (Vec<f64>, Option<[Vec<f64>; 2]>);

/// Why a checkpoint cannot be restored.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RestoreError {
    /// It is of another scene.
    #[error("it is of another scene: {0}")]
    Foreign(&'static str),
    /// The sparse factor cannot be computed again.
    #[error("the sparse factor cannot be made again: {0}")]
    Factor(#[from] LinalgError),
}

impl SchemeCheckpoint {
    /// The state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// φ and d, if they have a value at each of `nodes` nodes.
    pub(super) fn fields(&self, nodes: usize) -> Result<Fields, RestoreError> {
        let State { phi, director, .. } = &self.state;
        let fields = std::iter::once(phi).chain(director.iter().flatten());
        if fields.into_iter().any(|field| field.len() != nodes) {
            return Err(RestoreError::Foreign(
                "its mesh has another number of nodes",
            ));
        }
        Ok((phi.clone(), director.clone()))
    }

    /// Whether a scheme can take it over.
    fn check(&self, scheme: &Scheme) -> Result<(), RestoreError> {
        let nodes = scheme.space.nodes();
        let State { phi, omega, mu, .. } = &self.state;
        if [phi, omega, mu].iter().any(|field| field.len() != nodes) {
            return Err(RestoreError::Foreign(
                "its mesh has another number of nodes",
            ));
        }
        let increments = self.increments.as_ref();
        if !self.state.fits(&scheme.state)
            || increments.is_some() != scheme.director.is_some()
            || increments.is_some_and(|increments| !increments.fits(2 * nodes))
        {
            return Err(RestoreError::Foreign("its director does not fit"));
        }
        if !self.history.fits(&scheme.history, nodes) {
            return Err(RestoreError::Foreign("its history does not fit"));
        }
        if !scheme.membrane.can_restore(&self.linear) {
            return Err(RestoreError::Foreign(
                "its linear systems were solved by the fast path, which cannot be used here",
            ));
        }
        Ok(())
    }
}

impl Scheme {
    /// Copies out everything that later steps depend on.
    pub fn save(&self, checkpoint: &mut SchemeCheckpoint) {
        checkpoint.state.clone_from(&self.state);
        checkpoint.change_work = self.change_work;
        checkpoint.interval = self.interval;
        let energies = self.report.energies.iter().map(|energy| energy.value);
        checkpoint.energies.clear();
        checkpoint.energies.extend(energies);
        checkpoint.total_energy = self.report.total_energy;
        checkpoint.phase_integral = self.report.phase_integral;
        checkpoint.surface_area = self.report.surface_area;
        checkpoint.t = self.t;
        checkpoint.history.copy(&self.history);
        match &self.director {
            Some(director) => director.save(checkpoint.increments.get_or_insert_default()),
            None => checkpoint.increments = None,
        }
        self.membrane.save(&mut checkpoint.linear);
        checkpoint.selection = self.selection;
        checkpoint.starting = self.starting;
    }

    /// Puts it back, also into another scheme of the same scene: what follows is bit for bit what it
    /// was. The report has the energies and no ledger, for no step was taken.
    ///
    /// # Errors
    /// `RestoreError`: the checkpoint is of another scene. The state is then unchanged.
    pub fn restore(&mut self, checkpoint: &SchemeCheckpoint) -> Result<(), RestoreError> {
        checkpoint.check(self)?;
        // Without changes the parameters are what they are at any time.
        let before = (!self.timetable.is_empty()).then(|| {
            let parameters = match &checkpoint.interval {
                Some(interval) => self.timetable.at(interval.middle()),
                None => self.timetable.start().clone(),
            };
            self.change_effects(parameters)
        });
        let with_energy = self.effects.iter().filter(|effect| effect.has_energy());
        if checkpoint.energies.len() != with_energy.count() {
            if let Some(before) = before {
                self.change_effects(before);
            }
            return Err(RestoreError::Foreign("it has other effects"));
        }
        self.membrane.restore(&self.space, &checkpoint.linear)?;
        self.state.clone_from(&checkpoint.state);
        self.interval = checkpoint.interval;
        // The energies that belong to it are in the checkpoint. Before the first step: the moment 0.
        self.effects
            .set_interval(checkpoint.interval.unwrap_or_default());
        // For the names of the law's terms; the energies come below.
        self.evaluate_present_energies();
        let StepReport {
            mut energies,
            mut ledger,
            ..
        } = std::mem::take(&mut self.report);
        ledger.clear();
        energies.clear();
        let with_energy = self.effects.iter().filter(|effect| effect.has_energy());
        let values = with_energy.zip(&checkpoint.energies);
        energies.extend(values.map(|(effect, &value)| NamedValue {
            name: effect.name(),
            value,
        }));
        self.report = StepReport {
            energies,
            total_energy: checkpoint.total_energy,
            phase_integral: checkpoint.phase_integral,
            surface_area: checkpoint.surface_area,
            ledger,
            damping: 1.0,
            ..StepReport::default()
        };
        self.t = checkpoint.t;
        self.change_work = checkpoint.change_work;
        self.history.copy(&checkpoint.history);
        if let (Some(director), Some(increments)) = (&mut self.director, &checkpoint.increments) {
            director.restore(increments);
        }
        self.selection = checkpoint.selection;
        self.starting = checkpoint.starting;
        self.tried = None;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
