//! The app and its runs at their beginning, and what is often looked up in them.

use std::collections::VecDeque;
use std::sync::Arc;

use super::autosave::Kept;
use super::brake::Brake;
use super::frame_history::{self, FrameHistory};
use super::history::History;
use super::run_control::RunControl;
use super::state::{
    App, Director, Expectation, Field, Keeping, Notice, Overlay, Panel, Question, Run, Save,
    Saving, Screen, Slot, Status, Theory, View, Zoom,
};
use super::throughput::Throughput;
use super::update::SNAPSHOTS;
use crate::scene::{AnchoringKind, Scene};
use crate::simulation::{Report, RunId, RunSnapshot, cores};
use crate::study::PresetFigures;

impl App {
    /// Asks whether to resume the runs of an earlier session, if there are any; no run starts before
    /// that is answered.
    pub(super) fn offer_to_go_on(&mut self) {
        if let Some(slot) = self.slots.get_mut(self.active) {
            self.remark = slot.remark.take().or(self.remark.take());
        }
        if self.slots.iter().any(|slot| slot.offered().is_some()) {
            self.overlay = Some(Overlay::Confirm(Question::GoOn));
        }
    }

    /// The slots of the four cases come first, in each of their forms; those of opened scenes are behind them.
    pub const CASES: usize = 4;
    /// The least and the greatest number of redraws a second.
    pub const FRAME_RATES: [u32; 2] = [1, 30];

    /// The app with the slots of the four cases, and perhaps more behind them, one of which is
    /// looked at. Its run is started by the first [`update`](super::update::update), whatever the
    /// message.
    pub fn new(slots: Vec<Slot>, active: usize, size: (u16, u16), frames_per_second: u32) -> Self {
        let [least, most] = Self::FRAME_RATES;
        Self {
            active: active.min(slots.len().saturating_sub(1)),
            slots,
            forms: 1,
            form: 0,
            screen: Screen::Run,
            overlay: None,
            view: View {
                field: Field::Phase,
                director: Director::Strokes,
                zoom: Zoom::Fit,
                colour_map: 0,
                logarithmic: false,
                theory: false,
            },
            focus: Panel::Field,
            looking_back: None,
            size,
            frames_per_second: frames_per_second.clamp(least, most),
            saving: Saving::Idle,
            saving_now: None,
            saving_next: None,
            remark: None,
            stale: true,
            next_run: RunId(1),
            brake: Brake::default(),
            replay: None,
            cores: cores(),
            clock: None,
            shown_time: None,
            gallery_of_opened: false,
            memory: frame_history::BUDGET,
            editing: None,
            reloaded: None,
            expectation: Expectation::default(),
            ending: None,
        }
    }

    /// The same, where each case has this number of forms.
    pub fn with_forms(mut self, forms: usize) -> Self {
        self.forms = forms;
        self.follow_form();
        self
    }

    /// The keys and the gallery show the cases of the form that is looked at.
    pub(super) fn follow_form(&mut self) {
        if self.active < self.opened() {
            self.form = self.active / Self::CASES;
        }
    }

    /// The slot of the first scene that was opened, or would be.
    pub fn opened(&self) -> usize {
        Self::CASES * self.forms
    }

    /// The slot of a key's number, counted from 0: the cases of the form that is looked at, then what was opened.
    pub fn slot_of_key(&self, number: usize) -> usize {
        match number.checked_sub(Self::CASES) {
            None => self.cases().start + number,
            Some(number) => self.opened() + number,
        }
    }

    /// The slot of the active case in its other form.
    pub fn other_form(&self) -> Option<usize> {
        if self.forms < 2 || self.active >= self.opened() {
            return None;
        }
        Some((self.active + Self::CASES) % self.opened())
    }

    /// The slot that is shown.
    pub fn active_slot(&self) -> Option<&Slot> {
        self.slots.get(self.active)
    }

    /// Its run.
    pub fn active_run(&self) -> Option<&Run> {
        self.active_slot()?.run.as_ref()
    }

    pub(super) fn active_run_mut(&mut self) -> Option<&mut Run> {
        self.slots.get_mut(self.active)?.run.as_mut()
    }

    /// The fields that are shown: the latest of the active run, or older ones.
    pub fn picture(&self) -> Option<&Arc<RunSnapshot>> {
        let run = self.active_run()?;
        let older = self.looking_back.and_then(|index| run.past.get(index));
        older.or(run.picture.as_ref())
    }

    /// The scalars that belong to what is shown: those of the last step, or of the older
    /// picture.
    pub fn report(&self) -> Option<&Report> {
        let run = self.active_run()?;
        let older = self.looking_back.and_then(|index| run.past.get(index));
        Some(older.map_or(&run.report, |picture| &picture.report))
    }

    /// The slots of the gallery.
    pub fn gallery(&self) -> std::ops::Range<usize> {
        match self.gallery_of_opened {
            true => self.opened().min(self.slots.len())..self.slots.len(),
            false => self.cases(),
        }
    }

    /// The slots of the four cases, in the form that is looked at.
    pub fn cases(&self) -> std::ops::Range<usize> {
        let first = Self::CASES * self.form;
        first.min(self.slots.len())..(first + Self::CASES).min(self.slots.len())
    }

    /// Whether the space key pauses: the shown run should run, or any of the gallery's.
    pub fn is_going(&self) -> bool {
        let goes = |slot: &Slot| {
            let run = slot.run.as_ref();
            run.is_none_or(|run| run.control.wanted && !run.is_over())
        };
        match self.screen {
            Screen::Run => self.active_slot().is_some_and(goes),
            Screen::Gallery => self.slots[self.gallery()].iter().any(goes),
        }
    }

    /// Up to which step figures of a run are being saved, or wait for that.
    pub fn is_saving(&self, wanted: RunId) -> Option<u64> {
        let saves = [&self.saving_now, &self.saving_next];
        let steps = saves.into_iter().flatten().filter_map(|save| match save {
            Save::Set { run, step, .. } => (*run == wanted).then_some(*step),
            Save::View(..) => None,
        });
        steps.max()
    }

    /// Whether anything would be lost if the app ended now.
    pub fn has_unsaved(&self) -> bool {
        let mut runs = self.slots.iter().filter_map(|slot| slot.run.as_ref());
        runs.any(|run| run.unsaved)
    }
}

impl Slot {
    /// A slot without a run.
    pub fn new(name: impl Into<String>, file: Option<std::path::PathBuf>, scene: Scene) -> Self {
        let scene = Arc::new(scene);
        Self {
            name: name.into(),
            file,
            folder: None,
            preset: None,
            remark: None,
            loaded: scene.clone(),
            scene,
            kept: None,
            run: None,
        }
    }

    /// The run of an earlier session that is resumed only if that is agreed to. One that is over, in a folder that was
    /// opened, is there to be looked at.
    pub fn offered(&self) -> Option<&Kept> {
        let is_looked_at = |kept: &Kept| self.folder.is_some() && kept.is_over(&self.scene);
        self.kept.as_deref().filter(|kept| !is_looked_at(kept))
    }

    /// The anchoring in force; `None` where there is no director to anchor.
    pub fn anchoring(&self) -> Option<AnchoringKind> {
        self.scene.nematic.as_ref()?;
        let t = self.run.as_ref().map_or(0.0, |run| run.report.t);
        Some(self.scene.anchoring_at(t))
    }

    pub(super) fn set_anchoring(&mut self, kind: AnchoringKind) {
        set_anchoring(Arc::make_mut(&mut self.scene), kind);
    }

    /// The error and the time of its preset; `None` where they were not measured, or are not those of this run any
    /// more.
    pub fn figures(&self) -> Option<PresetFigures> {
        let run = self.run.as_ref();
        let is_as_built_in =
            self.scene.time.end == self.loaded.time.end && run.is_none_or(|run| run.changes == 0);
        PresetFigures::of(self.preset?, self.anchoring()?).filter(|_| is_as_built_in)
    }
}

/// Gives a scene another anchoring. A scene without a table needs none for the kind "none".
pub(super) fn set_anchoring(scene: &mut Scene, kind: AnchoringKind) {
    if scene.anchoring.is_some() || kind != AnchoringKind::None {
        scene.anchoring.get_or_insert_default().kind = kind;
    }
}

impl Run {
    /// Older notices are forgotten when there are more than this.
    const NOTICES: usize = 50;

    /// A run that is about to be set up.
    pub fn new(id: RunId, horizon: Option<f64>) -> Self {
        Self {
            id,
            status: Status::Starting,
            control: RunControl::new(horizon),
            setting_up: None,
            setting: None,
            report: Report::default(),
            underway: None,
            before: None,
            history: History::default(),
            picture: None,
            past: FrameHistory::default(),
            changes: 0,
            undo: Vec::new(),
            undoing: false,
            measurement: None,
            snapshots: Vec::new(),
            pace: Throughput::default(),
            notices: VecDeque::new(),
            unsaved: false,
            saved: None,
            keeping: Keeping::default(),
            rising: false,
            theory: Theory::default(),
        }
    }

    /// The pictures of its report, in the order of time: those at the report's times and the latest; while
    /// they are few, such from the past that divide the time up to now as the report's divide T.
    pub fn pictures_of_set(&self) -> Vec<Arc<RunSnapshot>> {
        let mut pictures = self.snapshots.clone();
        let last = pictures.last().map(|picture| picture.report.step);
        let is_later = |now: &&Arc<RunSnapshot>| last.is_none_or(|last| last < now.report.step);
        pictures.extend(self.picture.iter().filter(is_later).cloned());
        let now = pictures.last().map_or(0.0, |picture| picture.report.t);
        let parts = SNAPSHOTS - 1;
        for part in 1..parts {
            let t = now * part as f64 / parts as f64;
            let is_there = |picture: &Arc<RunSnapshot>| {
                (picture.report.t - t).abs() <= now / (2 * parts) as f64
            };
            if !pictures.iter().any(is_there) {
                pictures.extend(self.past.nearest(t).filter(|it| is_there(it)).cloned());
            }
        }
        pictures.sort_by_key(|picture| picture.report.step);
        pictures.dedup_by_key(|picture| picture.report.step);
        pictures
    }

    /// Whether its error is being measured.
    pub fn is_measured(&self) -> bool {
        self.measurement.as_ref().is_some_and(|it| it.is_going)
    }

    /// T; `None` until the run is set up.
    pub fn end(&self) -> Option<f64> {
        Some(self.setting.as_ref()?.scene.time.end)
    }

    /// Whether T is reached.
    pub fn is_done(&self) -> bool {
        self.status == Status::Done
    }

    /// The end of a run that continues beyond its own: twice as late, or later still if that is past.
    pub fn later_end(&self) -> Option<f64> {
        let mut end = 2.0 * self.setting.as_ref()?.scene.time.end;
        while end <= self.report.t {
            end *= 2.0;
        }
        Some(end)
    }

    /// Whether no more steps will be taken.
    pub fn is_over(&self) -> bool {
        matches!(self.status, Status::Done | Status::Failed(_))
    }

    /// Steps to T; `None` until the run is set up, and where Δt is chosen.
    pub fn steps(&self) -> Option<u64> {
        self.setting.as_ref()?.steps
    }

    pub(super) fn notify(&mut self, notice: Notice) {
        self.notices.push_back(notice);
        if self.notices.len() > Self::NOTICES {
            self.notices.pop_front();
        }
    }
}
