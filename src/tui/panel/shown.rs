//! What is shown: a run as it is now, or as it was.

use crate::record::{MarkKind, RunMark};
use std::time::Duration;

use crate::scene::{AnchoringKind, Scene};
use crate::simulation::{Report, RunSnapshot, Schedule, SetUp, Setting};
use crate::tui::curve;
use crate::tui::keys;
use crate::tui::numbers::brief;
use crate::tui::state::{App, Run, Slot, Status};
use crate::tui::theme::Role;

/// A run as it is shown: with the figures of the time that is shown.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// The scene and its run.
    pub slot: &'a Slot,
    /// The run, once there is one.
    pub run: Option<&'a Run>,
    /// Mesh and steps, once they are known.
    pub setting: Option<&'a Setting>,
    /// The fields.
    pub picture: Option<&'a RunSnapshot>,
    /// The scalars of the time that is shown.
    pub report: Option<&'a Report>,
    /// The anchoring of that time.
    pub anchoring: Option<AnchoringKind>,
    /// Which of the stored pictures is shown, and how many there are; `None`: live.
    pub back: Option<(usize, usize)>,
    /// The slot of the same case in its other form, and a word for that.
    pub other_form: Option<(&'a Slot, &'static str)>,
    /// What the brake leaves of the run to be watched, while it is on.
    pub braked: Option<Duration>,
}

impl<'a> Shown<'a> {
    /// A slot's run as it is.
    pub fn live(slot: &'a Slot) -> Self {
        let run = slot.run.as_ref();
        let setting = run.and_then(|run| run.setting.as_deref());
        Self {
            slot,
            run,
            setting,
            picture: run.and_then(|run| run.picture.as_deref()),
            // Before a run is set up its report says nothing.
            report: run.filter(|_| setting.is_some()).map(|run| &run.report),
            anchoring: slot.anchoring(),
            back: None,
            other_form: None,
            braked: None,
        }
    }

    /// A slot's run at a time that it shares with others: as it was then, where it is further and that is
    /// stored.
    pub fn at(slot: &'a Slot, t: Option<f64>) -> Self {
        let live = Self::live(slot);
        let stored = live.run.zip(t).and_then(|(run, t)| {
            let latest = run.picture.as_ref()?.report.t;
            let nearest = run.past.nearest(t)?;
            let is_nearer = (nearest.report.t - t).abs() < (latest - t).abs();
            is_nearer.then_some(nearest.as_ref())
        });
        match stored {
            None => live,
            Some(picture) => Self {
                picture: Some(picture),
                report: Some(&picture.report),
                anchoring: picture.anchoring,
                ..live
            },
        }
    }

    /// The active run, at the time that is shown.
    pub fn active(app: &'a App) -> Option<Self> {
        let slot = app.slots.get(app.active)?;
        let other_form = app.other_form().and_then(|index| app.slots.get(index));
        let live = Self {
            other_form: other_form.map(|other| (other, keys::other_form(app))),
            braked: app
                .brake
                .on
                .then(|| app.brake.left(slot.scene.time.end, slot.loaded.time.end)),
            ..Self::live(slot)
        };
        let stored = app.looking_back.zip(live.run).and_then(|(index, run)| {
            let picture = run.past.get(index)?;
            Some((index, run.past.len(), picture.as_ref()))
        });
        Some(match stored {
            None => live,
            Some((index, count, picture)) => Self {
                picture: Some(picture),
                report: Some(&picture.report),
                anchoring: picture.anchoring,
                back: Some((index, count)),
                ..live
            },
        })
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        &self.slot.scene
    }

    /// The first value of B, from which β is measured.
    pub fn initial_surface_area(&self) -> Option<f64> {
        self.run?.history.surface_area.at_start()
    }

    /// What the change of E_total is counted from: the start, and the work of changes since.
    pub fn energy_at_start(&self) -> Option<f64> {
        self.run?.history.energy_at_start(self.report?.step)
    }

    /// What the percentages of the energies and the curves are about, in words.
    pub fn notes(&self, logarithmic: bool, room: u16) -> String {
        let end = brief(self.end_of_curves(), 3);
        let scale = if logarithmic { "log curves" } else { "curves" };
        let since = match self.is_changed() {
            true => "% since t = 0, total: less the work of changes",
            false => "% since t = 0",
        };
        let words = [
            format!("{since}, {scale} to t = {end}"),
            since.to_owned(),
            "% since t = 0".to_owned(),
        ];
        let fits = |words: &String| words.chars().count() <= usize::from(room);
        words.into_iter().find(fits).unwrap_or_default()
    }

    /// Whether parameters had changed before what is shown.
    fn is_changed(&self) -> bool {
        let step = self.report.map_or(0, |report| report.step);
        let is_change = |mark: &RunMark| matches!(mark.kind, MarkKind::Change { .. });
        let mut marks = self.marks().iter();
        marks.any(|mark| is_change(mark) && mark.step < step)
    }

    /// The target β of the surface area, if the scene has one.
    pub fn target(&self) -> Option<f64> {
        let target = self.scene().parameter_at(self.report?.t, "area.target")?;
        Some(target.number()? * self.initial_surface_area()?)
    }

    /// How many vesicles there are, where there is not one.
    pub fn vesicles(&self) -> Option<String> {
        match self.report?.vesicles.len() {
            0 => Some("no vesicle".to_owned()),
            1 => None,
            count => Some(format!("{count} vesicles")),
        }
    }

    /// How much of the run is done at what is shown, from 0 to 1.
    pub fn share(&self) -> f64 {
        let (Some(setting), Some(report)) = (self.setting, self.report) else {
            return 0.0;
        };
        Schedule::new(&setting.scene.time, 1, 0).share(report.step, report.t)
    }

    /// What happened, and when, in the order of time.
    fn marks(&self) -> &'a [RunMark] {
        self.run.map_or(&[], |run| &run.history.marks)
    }

    /// The time at the right end of the curves.
    fn end_of_curves(&self) -> f64 {
        let t = self.run.map_or(0.0, |run| run.report.t);
        let end = self.setting.map_or(0.0, |setting| setting.scene.time.end);
        curve::horizon(t, end)
    }

    /// What the curves of this run have in common.
    pub fn curves(&self, logarithmic: bool) -> curve::Frame<'a> {
        curve::Frame {
            end: self.end_of_curves(),
            marks: self.marks(),
            cursor: self.back.and(self.report).map(|report| report.t),
            logarithmic,
        }
    }

    /// The word for what the run is doing, and its style.
    pub fn status(&self) -> (&'static str, Role) {
        let setting_up = self.run.and_then(|run| run.setting_up);
        match self.run.map(|run| &run.status) {
            None => ("not started", Role::Warning),
            Some(Status::Starting) => (setting_up.map_or("starting", SetUp::words), Role::Accent),
            Some(Status::Running) => ("running", Role::Good),
            Some(Status::Pausing) => ("pausing", Role::Warning),
            Some(Status::Paused) => ("paused", Role::Warning),
            Some(Status::Waiting) => ("waiting", Role::Accent),
            Some(Status::Done) => ("done", Role::Accent),
            Some(Status::Failed(_)) => ("failed", Role::Bad),
        }
    }
}
