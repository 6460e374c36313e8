//! Parameters that change between two steps.
//!
//! In each step the parameters have the values of its middle ([`Timetable`]). Where these are others than in the step before,
//! the energy of the state becomes another one by W, the work of the change, and the law of the step starts from there:
//! Eⁿ⁺¹ − Eⁿ − W is what (3.26) dissipates.

use super::{Scheme, State};
use crate::physics::{EffectContext, Interval};
use crate::scene::{Scene, Timetable};

impl Scheme {
    /// Has the parameters follow another timetable from the next step on.
    pub fn set_timetable(&mut self, timetable: Timetable) {
        self.timetable = timetable;
    }

    /// What changes.
    pub fn timetable(&self) -> &Timetable {
        &self.timetable
    }

    /// The parameters of the last step, without the scene's mesh and shape.
    pub fn parameters(&self) -> &Scene {
        &self.parameters
    }

    /// How many of the changes had begun in the last step.
    pub fn changes_begun(&self) -> usize {
        let middle = self.interval.as_ref().map(Interval::middle);
        middle.map_or(0, |middle| self.timetable.begun(middle))
    }

    /// Tells the effects the time of the coming step, and gives the parameters the values that they have in its middle.
    /// Where these are others, what the law starts from is measured again: the difference is the work of the change.
    pub(super) fn set_interval(&mut self, dt: f64) {
        let interval = Interval {
            begin: self.t,
            length: dt,
        };
        let begun = self.changes_begun();
        self.interval = Some(interval);
        if !self.timetable.is_empty() {
            let parameters = self.timetable.at(interval.middle());
            if parameters != self.parameters {
                let before = self.report.total_energy;
                self.set_parameters(parameters);
                self.evaluate_present_energies();
                let work = self.report.total_energy - before;
                *self.change_work.get_or_insert(0.0) += work;
                let numbers = begun.min(self.changes_begun())..begun.max(self.changes_begun());
                // In a ramp the parameters are continuous, and so is all that the next step is guessed from.
                if numbers
                    .filter_map(|number| self.timetable.change(number))
                    .any(|change| !change.is_ramp())
                {
                    self.forget();
                }
            }
        }
        self.effects.set_interval(interval);
    }

    /// Gives the effects other parameters; returns those before.
    pub(super) fn change_effects(&mut self, parameters: Scene) -> Scene {
        let before = std::mem::replace(&mut self.parameters, parameters);
        let scene = &self.parameters;
        let context = EffectContext {
            scene,
            space: &self.space,
            initial_area: self.initial_area,
        };
        self.effects.change(&before, &context);
        self.membrane.set_mobility(scene.membrane.mobility);
        if let (Some(director), Some(nematic)) = (&mut self.director, &scene.nematic) {
            director.set_mobility(nematic.mobility);
        }
        before
    }

    /// Other parameters for the state as it is.
    pub(super) fn set_parameters(&mut self, parameters: Scene) {
        let before = self.change_effects(parameters);
        let scene = &self.parameters;
        let curvature = |scene: &Scene| scene.membrane.spontaneous_curvature.clone();
        if curvature(&before) != curvature(scene) {
            // ω depends on k.
            let State { phi, omega, .. } = &mut self.state;
            self.membrane
                .solve_omega(&self.space, &mut self.effects, &mut self.strips, phi, omega);
        }
    }
}
