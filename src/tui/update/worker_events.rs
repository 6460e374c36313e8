//! What the workers report.

use std::sync::Arc;

use super::super::frame_history;
use super::super::run_control::WorkerState;
use super::super::state::{App, Notice, Run, Screen, Severity, Status};
use crate::record::RunMark;
use crate::scene::{Assignment, Change, Scene, Warning};
use crate::simulation::{
    EventKind, Message as WorkerMessage, Report, RunId, RunSnapshot, WorkerEvent,
};

/// The slot and the run of this number; `None`: it was ended, and its event came late.
pub(super) fn run_of(app: &mut App, id: RunId) -> Option<(usize, &mut Run)> {
    app.slots
        .iter_mut()
        .enumerate()
        .filter_map(|(index, slot)| slot.run.as_mut().map(|run| (index, run)))
        .find(|(_, run)| run.id == id)
}

impl App {
    /// Whether the run of a slot can be seen at present.
    pub(super) fn shows(&self, index: usize) -> bool {
        match self.screen {
            Screen::Run => index == self.active,
            Screen::Gallery => self.gallery().contains(&index),
        }
    }
}

/// Takes the latest fields of a run.
pub(super) fn show(app: &mut App, picture: Arc<RunSnapshot>) {
    let Some((index, run)) = run_of(app, picture.run) else {
        return;
    };
    run.picture = Some(picture.clone());
    run.past.put(picture);
    app.stale |= app.shows(index);
    share_memory(app);
    follow(app);
}

/// Lets older fields have a part of the memory that there is: the rest is for further runs, and for drawing.
pub(super) fn find_room(app: &mut App, free: u64) {
    let runs = app.slots.iter().filter_map(|slot| slot.run.as_ref());
    let stored: usize = runs.map(|run| run.past.bytes()).sum();
    app.memory = frame_history::budget(free, stored);
    share_memory(app);
    follow(app);
}

/// All runs have the same share of the memory for older fields.
fn share_memory(app: &mut App) {
    let runs = app.slots.iter().filter(|slot| slot.run.is_some()).count();
    let share = app.memory / runs.max(1);
    for run in app.slots.iter_mut().filter_map(|slot| slot.run.as_mut()) {
        run.past.set_budget(share);
    }
}

/// Keeps looking at the same picture when thinning has moved it.
fn follow(app: &mut App) {
    if app.looking_back.is_some()
        && let Some(run) = app.active_run()
    {
        app.looking_back = run.past.pinned_position();
    }
}

/// Takes what a worker reports.
pub(super) fn hear(app: &mut App, message: WorkerMessage) {
    let Some((index, _)) = run_of(app, message.run) else {
        return;
    };
    let slot = &mut app.slots[index];
    let law_tolerance = slot.scene.solver.law_tolerance;
    let Some(run) = &mut slot.run else { return };
    match message.event {
        WorkerEvent::SettingUp(part) => run.setting_up = Some(part),
        WorkerEvent::Ready(setting) => {
            for warning in &setting.warnings {
                warn(run, warning);
            }
            run.setting = Some(setting);
            run.control.hear(WorkerState::Computing);
        }
        WorkerEvent::Reports(reports) => {
            for report in reports {
                take(run, report, law_tolerance);
            }
        }
        WorkerEvent::StepProgress(underway) => {
            run.underway = Some(underway);
            run.unsaved = true;
        }
        WorkerEvent::Event(event) => {
            run.history.marks.extend(RunMark::of(&event));
            let severity = match event.kind {
                // The second: what a step that is about to take long needs to be solved.
                EventKind::ReachedWall | EventKind::ShortSteps { .. } => Severity::Warning,
                EventKind::VesiclesChanged { .. } | EventKind::AtRest { .. } => Severity::Note,
                // What was asked for, and what the solver did.
                EventKind::MeshChanged(_)
                | EventKind::ParametersChanged { .. }
                | EventKind::FellBackToFactor { .. }
                | EventKind::FactorIsFaster
                | EventKind::ReturnedToTransform
                | EventKind::NewtonTookOver { .. }
                | EventKind::StepDivided { .. }
                | EventKind::Damped { .. } => Severity::Log,
            };
            run.notify(Notice {
                severity,
                step: event.step,
                text: event.kind.to_string(),
            });
        }
        WorkerEvent::Changed(change) => {
            changed(run, &slot.scene, &change);
            // The run has it, so it is one that the scene can have.
            let _ = Arc::make_mut(&mut slot.scene).add_change(&change);
        }
        WorkerEvent::ChangeRefused(reason) => {
            run.undoing = false;
            run.notify(Notice {
                severity: Severity::Warning,
                step: run.report.step,
                text: format!("this cannot be changed: {reason}"),
            });
        }
        WorkerEvent::Snapshot(picture) => run.snapshots.push(picture),
        // It was written down on the way.
        WorkerEvent::State(_) => {}
        WorkerEvent::Paused => run.control.hear(WorkerState::Paused),
        WorkerEvent::Resumed => run.control.hear(WorkerState::Computing),
        WorkerEvent::AtHorizon => run.control.hear(WorkerState::AtHorizon),
        WorkerEvent::Done => {
            run.control.hear(WorkerState::Over);
            run.status = Status::Done;
        }
        WorkerEvent::Failed(failure) => {
            let reason = failure.words;
            run.control.hear(WorkerState::Over);
            run.underway = None;
            run.status = Status::Failed(reason.clone());
            run.notify(Notice {
                severity: Severity::Error,
                step: run.report.step,
                text: reason,
            });
        }
    }
    app.stale |= app.shows(index);
}

fn warn(run: &mut Run, warning: &Warning) {
    run.notify(Notice {
        severity: Severity::Warning,
        step: 0,
        text: warning.to_string(),
    });
}

/// Takes the scalars of a step.
fn take(run: &mut Run, report: Report, law_tolerance: f64) {
    // With chosen steps, as many as there would be if all took as long as this one.
    let steps = run.steps().unwrap_or_else(|| {
        let end = run.setting.as_ref().map_or(0.0, |it| it.scene.time.end);
        let left = ((end - report.t) / report.dt).max(0.0).ceil() as u64;
        report.step.saturating_add(left)
    });
    let before = run.before.take();
    if let Some(before) = &before {
        run.history = before.curves.clone();
        // Of the energy that it rises from.
        run.report = report.clone();
    }
    run.underway = None;
    run.pace.take(&report, steps);
    run.history.take(&report);
    let finite = [
        report.total_energy,
        report.surface_area,
        report.phase_integral,
    ]
    .iter()
    .all(|value| value.is_finite());
    if !finite {
        if run.report.total_energy.is_finite() || report.step == 0 {
            run.notify(Notice {
                severity: Severity::Error,
                step: report.step,
                text: "an energy is not a finite number; the run is paused".to_owned(),
            });
        }
        run.control.wanted = false;
    }
    if report.step > 0 {
        // The state that a run is resumed from was there before.
        run.unsaved |= before.is_none();
        let change = report.total_energy - run.report.total_energy;
        let rise = report.unexplained_rise().unwrap_or(change);
        let rising = rise > law_tolerance * run.report.law_scale().max(report.law_scale());
        if rising && !run.rising {
            run.notify(Notice {
                severity: Severity::Warning,
                step: report.step,
                text: format!("the energy rises, by {rise:.2e} in this step"),
            });
        }
        run.rising = rising;
    }
    run.report = report;
}

/// Takes a change that was made by hand: what is measured from then on would be of another run.
fn changed(run: &mut Run, scene: &Scene, change: &Change) {
    run.changes += 1;
    if run.undoing {
        run.undoing = false;
    } else {
        let before = change.set.iter().filter_map(|assignment| {
            let key = assignment.key.clone();
            let value = scene.parameter_at(change.at, &key)?;
            Some(Assignment { key, value })
        });
        run.undo.push(before.collect());
    }
    run.unsaved |= run.report.step > 0;
    if let Some(measurement) = &mut run.measurement {
        measurement.is_going = false;
    }
}
