//! What happens in a run that its user should know.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::fem::PieceChanges;
use crate::physics::NamedValue;
use crate::scene::{Change, significant};
use crate::scheme::{StepError, StepReport};

/// Something that happened at a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The step.
    pub step: u64,
    /// The time at its end.
    pub t: f64,
    /// What happened.
    pub kind: EventKind,
}

/// A Δt below this part of the first is reported at once.
const SHORT: f64 = 1e-6;

/// What happened.
#[derive(Debug, Clone, PartialEq)]
pub enum EventKind {
    /// The iteration of the fast linear solver failed, and the sparse factor took over; the fast one is
    /// tried again later.
    FellBackToFactor {
        /// How it failed.
        reason: StepError,
    },
    /// The sparse factor took over, because the fast linear solver needs so many iterations at this Δt that
    /// the factor is faster.
    FactorIsFaster,
    /// The fast linear solver is in use again.
    ReturnedToTransform,
    /// The lagged iteration failed, and Newton's method took over; the lagged one is tried again later.
    NewtonTookOver {
        /// How it failed.
        reason: StepError,
    },
    /// The step could not be solved whole and was divided.
    StepDivided {
        /// The smallest Δt that was used.
        smallest: f64,
        /// Why the last of the longer ones failed.
        reason: String,
    },
    /// Within the step Δt has fallen below a millionth of that with which the run began: reported at once, because the
    /// step may take hours.
    ShortSteps {
        /// The Δt that is tried next.
        dt: f64,
        /// time.step, or the Δt that is tried first where it is chosen.
        first: f64,
        /// Why the last of the longer ones failed.
        reason: String,
    },
    /// Newton's method had to be damped in this step, after one in which it had not; how it went on is in
    /// the column `damping` of the ledger.
    Damped {
        /// The smallest factor λ of the step.
        factor: f64,
    },
    /// φ became positive within ε of the wall.
    ReachedWall,
    /// Vesicles have merged, split, appeared or vanished.
    VesiclesChanged {
        /// What happened.
        change: VesicleChange,
        /// How many there were before the step, and are after it.
        counts: [usize; 2],
    },
    /// Parameters became others after this step, or began to: the energy changed, not the state.
    ParametersChanged {
        /// The changes.
        changes: Vec<Change>,
        /// Their work before the next step: by how much E_total changed.
        work: f64,
    },
    /// The mesh was made again about the membrane, and the state brought there.
    MeshChanged(Box<MeshChange>),
    /// Nothing moves any more, and the run ends.
    AtRest {
        /// The energy that would be lost in a relaxation time, as a part of the energy.
        unrest: f64,
        /// rest.tolerance.
        tolerance: f64,
    },
}

/// What may become of vesicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum VesicleChange {
    /// Several have become one.
    Merged,
    /// One has become several.
    Split,
    /// There is one where there was none.
    Appeared,
    /// There is nothing left of one.
    Vanished,
}

impl VesicleChange {
    const ALL: [Self; 4] = [Self::Merged, Self::Split, Self::Appeared, Self::Vanished];

    /// It in a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Merged => "merged",
            Self::Split => "split",
            Self::Appeared => "appeared",
            Self::Vanished => "vanished",
        }
    }

    /// The name of its event, for programs.
    fn event_name(self) -> &'static str {
        match self {
            Self::Merged => "vesicles-merged",
            Self::Split => "vesicle-split",
            Self::Appeared => "vesicle-appeared",
            Self::Vanished => "vesicle-vanished",
        }
    }

    /// That whose event has a name.
    pub fn of_event(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|change| change.event_name() == name)
    }

    /// Which of them have happened.
    pub(super) fn all(changes: PieceChanges) -> impl Iterator<Item = Self> {
        let counts = [
            (changes.merged, Self::Merged),
            (changes.split, Self::Split),
            (changes.appeared, Self::Appeared),
            (changes.vanished, Self::Vanished),
        ];
        let counts = counts.into_iter().filter(|(count, _)| *count > 0);
        counts.map(|(_, change)| change)
    }
}

/// What a new mesh has changed.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshChange {
    /// Nodes before and after.
    pub nodes: [usize; 2],
    /// The energy of each effect.
    pub energies: Vec<EnergyChange>,
    /// E_total before and after.
    pub total: [f64; 2],
}

/// The energy of an effect before and after a change of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyChange {
    /// The effect.
    pub name: &'static str,
    /// Its energy before and after.
    pub values: [f64; 2],
}

impl EnergyChange {
    /// Those of all effects, from the reports before and after.
    pub(super) fn all(before: &StepReport, after: &StepReport) -> Vec<Self> {
        let pairs = before.energies.iter().zip(&after.energies);
        let change = |(before, after): (&NamedValue, &NamedValue)| Self {
            name: after.name,
            values: [before.value, after.value],
        };
        pairs.map(change).collect()
    }
}

impl EventKind {
    /// That the steps have become short, if they have just become so: where the least Δt of the step was `before`
    /// and is `dt` now.
    pub(super) fn of_short_steps(
        [before, dt]: [f64; 2],
        first: f64,
        reason: &StepError,
    ) -> Option<Self> {
        let limit = SHORT * first;
        (before >= limit && dt < limit).then(|| Self::ShortSteps {
            dt,
            first,
            reason: reason.to_string(),
        })
    }

    /// A fixed name, for programs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::FellBackToFactor { .. } => "fell-back-to-factor",
            Self::FactorIsFaster => "factor-is-faster",
            Self::ReturnedToTransform => "returned-to-transform",
            Self::NewtonTookOver { .. } => "newton-took-over",
            Self::StepDivided { .. } => "step-divided",
            Self::ShortSteps { .. } => "short-steps",
            Self::Damped { .. } => "newton-damped",
            Self::ReachedWall => "reached-wall",
            Self::VesiclesChanged { change, .. } => change.event_name(),
            Self::ParametersChanged { .. } => "parameters-changed",
            Self::MeshChanged(_) => "mesh-changed",
            Self::AtRest { .. } => "at-rest",
        }
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EventKind::FellBackToFactor { reason } => write!(
                f,
                "the sparse factor took over from the fast linear solver for a while, which had failed: {reason}"
            ),
            EventKind::FactorIsFaster => f.write_str(
                "the sparse factor took over from the fast linear solver, which takes longer at this \u{394}t",
            ),
            EventKind::ReturnedToTransform => f.write_str("the fast linear solver is in use again"),
            EventKind::NewtonTookOver { reason } => write!(
                f,
                "Newton's method took over from the lagged iteration for a while, which had failed: {reason}"
            ),
            EventKind::StepDivided { smallest, reason } => write!(
                f,
                "the step was divided, down to \u{394}t = {smallest:.1e}, since a longer one failed: {reason}"
            ),
            EventKind::ShortSteps { dt, first, reason } => write!(
                f,
                "\u{394}t has fallen to {dt:.1e} within this step, less than a millionth of the {first:.1e} of the \
                 first attempt: the step may take very long. Better conditions are more cells at the membrane \
                 (mesh.cells, membrane.interface_width), softer parameters (a larger area.penalty, smaller weights, \
                 a spontaneous curvature without jumps), or a smoother initial state. The longer steps failed: {reason}"
            ),
            EventKind::Damped { factor } => write!(
                f,
                "Newton's method is damped from here on for a while, by {} at most in this step",
                significant(*factor, 2)
            ),
            EventKind::ReachedWall => f.write_str(
                "the vesicle has reached the wall, which now takes part in what happens",
            ),
            EventKind::VesiclesChanged { change, counts } => {
                let [before, after] = counts;
                let words = match change {
                    VesicleChange::Merged => "vesicles have merged",
                    VesicleChange::Split => "a vesicle has split",
                    VesicleChange::Appeared => "a vesicle has appeared",
                    VesicleChange::Vanished => "a vesicle has vanished",
                };
                write!(f, "{words}: {after} now, {before} before")
            }
            EventKind::AtRest { unrest, tolerance } => write!(
                f,
                "the run ends at rest: in a relaxation time {unrest:.1e} of the energy would be lost, at most \
                 rest.tolerance = {tolerance:e}"
            ),
            EventKind::ParametersChanged { changes, work } => {
                for (index, change) in changes.iter().enumerate() {
                    write!(f, "{}{change}", if index > 0 { "; " } else { "" })?;
                }
                write!(
                    f,
                    " from here on: E_total changes by {work:.6e} before the next step, the work of the change"
                )
            }
            EventKind::MeshChanged(change) => change.fmt(f),
        }
    }
}

impl fmt::Display for MeshChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([nodes, new], [before, after]) = (self.nodes, self.total);
        write!(
            f,
            "the mesh has followed the membrane: {new} nodes after {nodes}; E_total changed by {:+.3e} to \
             {after:.6e}, which no step has done",
            after - before
        )?;
        for EnergyChange { name, values } in &self.energies {
            write!(f, ", {name} by {:+.3e}", values[1] - values[0])?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn short(lengths: [f64; 2], first: f64) -> Option<EventKind> {
        let reason = StepError::LawBroken {
            residual: 2e-3,
            tolerance: 1e-8,
        };
        EventKind::of_short_steps(lengths, first, &reason)
    }

    /// Once: by the attempt that falls below a millionth of the first, and by none before or after it.
    #[test]
    fn steps_are_short_from_a_millionth_of_the_first_on() {
        for first in [1.0, 1e-2, 3e-9] {
            for (lengths, is_told) in [
                ([1.0, 1.01e-6], false),
                ([1.01e-6, 0.99e-6], true),
                ([1.0, 1e-15], true),
                ([0.99e-6, 0.5e-6], false),
                ([0.5e-6, 1.0], false),
            ] {
                let told = short(lengths.map(|length| length * first), first);
                assert_eq!(told.is_some(), is_told, "{first} {lengths:?}");
            }
        }
        let words = short([1e-2, 2.5e-9], 1e-2).map(|kind| kind.to_string());
        let words = words.expect("less than a millionth");
        for part in [
            "has fallen to 2.5e-9 within this step",
            "a millionth of the 1.0e-2 of the first attempt",
            "mesh.cells",
            "The longer steps failed: the energy law misses by 2.00e-3",
        ] {
            assert!(words.contains(part), "{words}");
        }
    }
}
