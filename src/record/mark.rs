//! What the curves of a run are marked with.

use serde::{Deserialize, Serialize};

use super::summary::EventRecord;
use crate::scene::Change;
use crate::simulation::{Event, EventKind, VesicleChange};

/// Something that happened between two steps, and is marked in curves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunMark {
    /// The step after which it happened.
    pub step: u64,
    /// The time at its end.
    pub t: f64,
    /// What happened.
    pub kind: MarkKind,
}

/// What is marked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum MarkKind {
    /// The mesh has followed the membrane.
    Mesh,
    /// Parameters became others.
    Change {
        /// Which, and what they are now.
        label: String,
        /// By how much E_total changed by that; `None` where it goes on to, in a ramp, and where that is not known.
        work: Option<f64>,
    },
    /// Vesicles have merged, split, ….
    Vesicles(VesicleChange),
    /// The wall was reached.
    Wall,
}

impl RunMark {
    /// What it is called below a curve; nothing for a new mesh, of which there are many.
    pub fn name(&self) -> Option<&str> {
        match &self.kind {
            MarkKind::Mesh => None,
            MarkKind::Change { label, .. } => Some(label),
            MarkKind::Vesicles(change) => Some(change.name()),
            MarkKind::Wall => Some("wall"),
        }
    }

    /// That of an event, if it is marked.
    pub fn of(event: &Event) -> Option<Self> {
        let kind = match &event.kind {
            EventKind::MeshChanged(_) => MarkKind::Mesh,
            EventKind::ParametersChanged { changes, work } => {
                let labels: Vec<String> = changes.iter().map(Change::label).collect();
                MarkKind::Change {
                    label: labels.join(", "),
                    work: (!changes.iter().any(Change::is_ramp)).then_some(*work),
                }
            }
            EventKind::VesiclesChanged { change, .. } => MarkKind::Vesicles(*change),
            EventKind::ReachedWall => MarkKind::Wall,
            _ => return None,
        };
        let Event { step, t, .. } = *event;
        Some(Self { step, t, kind })
    }

    /// That of an event as it is written down.
    pub(super) fn of_record(event: &EventRecord) -> Option<Self> {
        let kind = match &*event.kind {
            "mesh-changed" => MarkKind::Mesh,
            "parameters-changed" => MarkKind::Change {
                label: event.text.split(" from here on").next()?.to_owned(),
                work: None,
            },
            "reached-wall" => MarkKind::Wall,
            name => MarkKind::Vesicles(VesicleChange::of_event(name)?),
        };
        let EventRecord { step, t, .. } = *event;
        Some(Self { step, t, kind })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_marks_of_a_kept_run_are_those_that_it_had() {
        use VesicleChange::{Appeared, Merged, Split, Vanished};
        let changed = [Merged, Split, Appeared, Vanished].map(|change| {
            let counts = [2, 1];
            EventKind::VesiclesChanged { change, counts }
        });
        let names = ["merged", "split", "appeared", "vanished", "wall"];
        let kinds = changed.into_iter().chain([EventKind::ReachedWall]);
        for (kind, name) in kinds.zip(names) {
            let (step, t) = (3, 0.5);
            let event = Event { step, t, kind };
            let mark = RunMark::of(&event).expect(name);
            assert_eq!(mark.name(), Some(name));
            assert_eq!(RunMark::of_record(&EventRecord::from(&event)), Some(mark));
        }
        let damped = Event {
            step: 3,
            t: 0.5,
            kind: EventKind::Damped { factor: 0.5 },
        };
        assert_eq!(RunMark::of(&damped), None);
        assert_eq!(RunMark::of_record(&EventRecord::from(&damped)), None);
    }
}
