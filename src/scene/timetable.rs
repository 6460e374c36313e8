//! Which values the parameters have when.

use super::change::{Assignment, Change};
use super::parameter::ParameterValue;
use super::tables::Scene;

/// The parameters of a run as functions of the time. (See `change.rs` for the rules.)
#[derive(Debug, Clone)]
pub struct Timetable {
    /// The scene before all changes, without its mesh and shape.
    base: Scene,
    /// In the order of time.
    changes: Vec<Timed>,
}

/// A change, and the numbers that it begins from.
#[derive(Debug, Clone)]
struct Timed {
    change: Change,
    from: Vec<Option<f64>>,
}

impl Timed {
    fn new(change: Change, before: &Scene) -> Self {
        let number = |key: &str| before.parameter(key)?.number();
        let keys = change.set.iter().map(|assignment| &assignment.key);
        Self {
            from: keys.map(|key| number(key)).collect(),
            change,
        }
    }

    /// Gives the parameters of a scene the values that they have at a time from its beginning on.
    fn apply(&self, t: f64, scene: &mut Scene) {
        let Change { at, over, set } = &self.change;
        for (assignment, from) in set.iter().zip(&self.from) {
            let Assignment { value, .. } = assignment;
            let between = match (from, value) {
                (Some(from), ParameterValue::Number(to)) if t < at + over => {
                    Some(ParameterValue::Number(from + (t - at) / over * (to - from)))
                }
                _ => None,
            };
            scene.set_parameter(assignment.path(), between.as_ref().unwrap_or(value));
        }
    }
}

impl Timetable {
    /// That of a scene.
    pub fn of(scene: &Scene) -> Self {
        let mut base = scene.without_geometry();
        base.undo_table_changes();
        let mut timetable = Self {
            base,
            changes: Vec::new(),
        };
        for change in scene.all_changes() {
            timetable.insert(change);
        }
        timetable
    }

    /// The scene before all changes, without its mesh and shape.
    pub fn start(&self) -> &Scene {
        &self.base
    }

    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// Adds a change, after those that begin at its time or before.
    pub fn insert(&mut self, change: Change) {
        let place = self.begun(change.at);
        let later = self.changes.split_off(place);
        let later = later.into_iter().map(|timed| timed.change);
        // What follows may begin from other numbers now.
        for change in std::iter::once(change).chain(later) {
            let before = self.at(change.at);
            self.changes.push(Timed::new(change, &before));
        }
    }

    /// The scene with the values that its parameters have at this time; without mesh and shape.
    pub fn at(&self, t: f64) -> Scene {
        let mut scene = self.base.clone();
        for timed in &self.changes[..self.begun(t)] {
            timed.apply(t, &mut scene);
        }
        scene
    }

    /// How many changes have begun at this time.
    pub fn begun(&self, t: f64) -> usize {
        self.changes.partition_point(|timed| timed.change.at <= t)
    }

    /// The change of this number, in the order of time.
    pub fn change(&self, number: usize) -> Option<&Change> {
        Some(&self.changes.get(number)?.change)
    }

    /// The next time after t at which a change begins or a ramp ends.
    pub fn next_event(&self, t: f64) -> Option<f64> {
        let events = self.changes.iter();
        let events = events.flat_map(|timed| [timed.change.at, timed.change.end()]);
        events.filter(|event| *event > t).min_by(f64::total_cmp)
    }

    /// Whether a change that takes no time is at one of these times.
    pub fn has_jump(&self, is_then: impl Fn(f64) -> bool) -> bool {
        let mut jumps = self.changes.iter().filter(|timed| !timed.change.is_ramp());
        jumps.any(|timed| is_then(timed.change.at))
    }
}
