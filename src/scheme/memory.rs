//! Everything that later steps depend on, copied out of a scheme and put back: a step can be taken
//! back, and a run go on from a file, bit for bit as if nothing had happened.
//!
//! What depends on the scene and the mesh alone is not in it: β, the matrices, the transform.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::detour::{Detour, Slowness};
use super::director::Increments;
use super::extrapolated::Learnt;
use super::history::History;
use super::membrane::LinearMemory;
use super::{Scheme, State};
use crate::linalg::LinalgError;
use crate::physics::{Interval, NamedValue};
use crate::scene::{Anchoring, AnchoringKind};

/// What [`Scheme::remember`] has copied. It keeps its buffers: remembering again allocates nothing.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Memory {
    phi: Vec<f64>,
    omega: Vec<f64>,
    mu: Vec<f64>,
    director: Option<[Vec<f64>; 2]>,
    /// The anchoring may be another than the scene's.
    anchoring: Option<Anchoring>,
    /// The time of the last step, as the effects were told it.
    interval: Option<Interval>,
    /// Of the effects that have one, in their order. The energy law of the next step starts from them.
    energies: Vec<f64>,
    total_energy: f64,
    phase_integral: f64,
    surface_area: f64,
    /// The clock of the history.
    t: f64,
    /// Where the guesses of the next step come from.
    history: History,
    increments: Option<Increments>,
    linear: LinearMemory,
    detour: Option<Detour>,
    newton_detour: Option<Detour>,
    slowness: Slowness,
    /// Of steps that are taken in several ways.
    learnt: Option<Learnt>,
}

/// Why a memory cannot be put into a scheme.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RecallError {
    /// It is of another scene.
    #[error("it is of another scene: {0}")]
    Foreign(&'static str),
    /// The sparse factor cannot be made again.
    #[error("the sparse factor cannot be made again: {0}")]
    Factor(#[from] LinalgError),
}

impl Memory {
    /// The anchoring that was in use.
    pub fn anchoring(&self) -> Option<Anchoring> {
        self.anchoring
    }

    /// Whether a scheme can take it over.
    fn check(&self, scheme: &Scheme) -> Result<(), RecallError> {
        let nodes = scheme.space.nodes();
        let fields = [&self.phi, &self.omega, &self.mu];
        if fields.iter().any(|field| field.len() != nodes) {
            return Err(RecallError::Foreign("its mesh has another number of nodes"));
        }
        match (&self.director, &self.increments, &scheme.director) {
            (None, None, None) => {}
            (Some(director), Some(increments), Some(_))
                if director.iter().all(|field| field.len() == nodes)
                    && increments.fits(2 * nodes) => {}
            _ => return Err(RecallError::Foreign("its director does not fit")),
        }
        let anchors = |anchoring: &Option<Anchoring>| {
            usize::from(anchoring.is_some_and(|anchoring| anchoring.kind != AnchoringKind::None))
        };
        let with_energy = scheme.effects.iter().filter(|effect| effect.has_energy());
        let others = with_energy.count() - anchors(&scheme.anchoring);
        if self.energies.len() != others + anchors(&self.anchoring) {
            return Err(RecallError::Foreign("it has other effects"));
        }
        if let Some(learnt) = &self.learnt
            && !learnt.fits(&scheme.state)
        {
            return Err(RecallError::Foreign("its extrapolation does not fit"));
        }
        if !self.history.fits(&scheme.history, nodes) {
            return Err(RecallError::Foreign("its history does not fit"));
        }
        if !scheme.membrane.can_recall(&self.linear) {
            return Err(RecallError::Foreign(
                "its linear systems were solved by the fast path, which cannot be used here",
            ));
        }
        Ok(())
    }
}

impl Scheme {
    /// Copies out everything that later steps depend on.
    pub fn remember(&self, memory: &mut Memory) {
        memory.phi.clone_from(&self.state.phi);
        memory.omega.clone_from(&self.state.omega);
        memory.mu.clone_from(&self.state.mu);
        copy_director(&mut memory.director, &self.state);
        memory.anchoring = self.anchoring;
        memory.interval = self.interval;
        let energies = self.report.energies.iter().map(|energy| energy.value);
        memory.energies.clear();
        memory.energies.extend(energies);
        memory.total_energy = self.report.total_energy;
        memory.phase_integral = self.report.phase_integral;
        memory.surface_area = self.report.surface_area;
        memory.t = self.t;
        memory.history.copy(&self.history);
        match &self.director {
            Some(director) => director.remember(memory.increments.get_or_insert_default()),
            None => memory.increments = None,
        }
        self.membrane.remember(&mut memory.linear);
        memory.detour = self.detour;
        memory.newton_detour = self.newton_detour;
        memory.slowness = self.slowness;
        self.remember_trial(&mut memory.learnt);
    }

    /// Puts it back, also into another scheme of the same scene: what follows is bit for bit what it
    /// was. The report has the energies and no ledger, for no step was taken.
    ///
    /// # Errors
    /// [`RecallError`]: the memory is of another scene. The state is then what it was.
    pub fn recall(&mut self, memory: &Memory) -> Result<(), RecallError> {
        memory.check(self)?;
        self.membrane.recall(&self.space, &memory.linear)?;
        self.state.phi.copy_from_slice(&memory.phi);
        self.state.omega.copy_from_slice(&memory.omega);
        self.state.mu.copy_from_slice(&memory.mu);
        if let (Some(to), Some(from)) = (&mut self.state.director, &memory.director) {
            for (to, from) in to.iter_mut().zip(from) {
                to.copy_from_slice(from);
            }
        }
        if self.anchoring != memory.anchoring {
            self.anchoring = memory.anchoring;
            self.effects
                .set_anchoring(memory.anchoring.as_ref(), &self.space);
        }
        self.interval = memory.interval;
        // The energies that belong to it are in the memory. Before the first step: the moment 0.
        self.effects
            .set_interval(memory.interval.unwrap_or_default());
        let report = &mut self.report;
        report.energies.clear();
        let with_energy = self.effects.iter().filter(|effect| effect.has_energy());
        let energies = with_energy.zip(&memory.energies);
        report
            .energies
            .extend(energies.map(|(effect, &value)| NamedValue {
                name: effect.name(),
                value,
            }));
        report.total_energy = memory.total_energy;
        report.phase_integral = memory.phase_integral;
        report.surface_area = memory.surface_area;
        report.ledger.clear();
        report.law_residual = 0.0;
        (report.newton, report.krylov, report.director_iterations) = (0, 0, 0);
        report.fallback = None;
        report.newton_took_over = None;
        (report.refused_ways, report.damping) = (0, 1.0);
        report.switched = None;
        report.algebraic_error = 0.0;
        self.t = memory.t;
        self.switched = None;
        self.history.copy(&memory.history);
        if let (Some(director), Some(increments)) = (&mut self.director, &memory.increments) {
            director.recall(increments);
        }
        self.detour = memory.detour;
        self.newton_detour = memory.newton_detour;
        self.slowness = memory.slowness;
        self.recall_trial(memory.learnt.as_ref());
        Ok(())
    }
}

fn copy_director(target: &mut Option<[Vec<f64>; 2]>, state: &State) {
    match &state.director {
        Some(source) => {
            let target = target.get_or_insert_default();
            for (target, source) in target.iter_mut().zip(source) {
                target.clone_from(source);
            }
        }
        None => *target = None,
    }
}

#[cfg(test)]
mod tests;
