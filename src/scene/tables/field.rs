//! `[field]`.

use super::{Geometry, Rules, Scene};
use crate::geometry::{Vector, direction};
use crate::scene::change::{Assignment, Change};
use crate::scene::error::{Problem, SceneError};
use crate::scene::parameter::ParameterValue;
use crate::scene::reader::{FINITE, NOT_NEGATIVE, Reader};
use crate::scene::significant::brief;
use crate::scene::warning::Warning;

// The paper has no field: the default is as strong as the elastic forces of a vesicle of Table 1.
table! {
    /// A magnetic or electric field H on the director,
    /// E = −½ χ Σ_T T ⟨I(φ)⟩ ⟨(d·H)²⟩ with the areas T of the triangles and means over them: but for the
    /// order h² it is −½ χ ∫ I(φ)(d·H)².
    #[derive(Copy)]
    pub struct Field {
        /// χ: the director turns along the field where it is positive, across it where it is negative.
        @tunable weight: f64 = 1000.0, FINITE;
        /// The length of H.
        @tunable strength: f64 = 1.0, NOT_NEGATIVE;
        /// The angle of H to the x axis, in degrees.
        @tunable angle: f64 = 0.0, FINITE;
        /// Whether it is on.
        @tunable on: bool = true;
        /// When it is switched on, rounded to the nearest end of a step.
        from: f64 = 0.0, NOT_NEGATIVE;
        /// When it is switched off, later than `from` and rounded likewise; never by default.
        until: Option<f64> = None, FINITE;
    }
}

impl Field {
    /// H.
    pub fn vector(&self) -> Vector {
        self.strength * direction(self.angle)
    }

    /// Whether it is switched on, and not zero.
    pub fn is_on(&self) -> bool {
        self.on && self.strength > 0.0
    }
}

impl Rules for Field {
    fn needs_director() -> bool {
        true
    }

    fn complete(&mut self, table: &Reader<'_>) -> Result<(), SceneError> {
        let from = self.from;
        match (self.until, table.get("until")) {
            (Some(until), Some(field)) if until <= from => {
                Err(field.out_of_range(format!("a number > field.from = {}", brief(from))))
            }
            _ => Ok(()),
        }
    }

    /// What is the same all about the axis is along it.
    fn check_scene(&self, scene: &Scene, table: &Reader<'_>) -> Result<(), SceneError> {
        let angle = self.angle;
        if scene.geometry == Geometry::Planar || (angle.abs() - 90.0).abs() < 1e-9 {
            return Ok(());
        }
        let problem = Problem::FieldAcrossAxis { angle };
        Err(match table.get("angle") {
            Some(field) => field.error(problem),
            None => table.error(problem),
        })
    }

    /// `from` and `until`.
    fn changes(&self) -> Vec<Change> {
        let switch = |at: f64, is_on: bool| Change {
            at,
            over: 0.0,
            set: vec![Assignment {
                key: "field.on".to_owned(),
                value: ParameterValue::Switch(is_on),
            }],
        };
        let on = (self.on && self.from > 0.0).then(|| switch(self.from, true));
        let off = self.until.map(|until| switch(until, false));
        on.into_iter().chain(off).collect()
    }

    fn undo_changes(&mut self) {
        self.on &= self.from <= 0.0;
    }

    fn warnings(&self, scene: &Scene) -> Vec<Warning> {
        let Some(nematic) = &scene.nematic else {
            return Vec::new();
        };
        let pull = self.weight * self.strength * self.strength;
        let bound = 2.0 * nematic.weight / (nematic.penalty * nematic.penalty);
        Vec::from_iter((pull >= bound).then_some(Warning::FieldTooStrong { pull, bound }))
    }
}
