//! The measured error of a run: when it is asked for, and what comes in of it.

use std::sync::Arc;

use super::super::measuring::MeasuringJob;
use super::super::message::Effect;
use super::super::state::{App, Measurement, MeasuringNews, Notice, Overlay, Run, Severity, Slot};
use super::scheduling::SNAPSHOTS;
use super::{remark, worker_events};
use crate::simulation::{RunId, Schedule};

/// The key: begins a measurement, ends it, or shows what was measured.
pub(super) fn press(app: &mut App, effects: &mut Vec<Effect>) {
    let elsewhere = app.slots.iter().enumerate().find(|(index, slot)| {
        let run = slot.run.as_ref();
        *index != app.active && run.is_some_and(Run::is_measured)
    });
    let elsewhere = elsewhere.map(|(_, slot)| slot.name.clone());
    let Some(slot) = app.slots.get(app.active) else {
        return;
    };
    let Some(run) = &slot.run else { return };
    let is_measured = run.is_measured();
    let is_of_this = |it: &Measurement| it.is_of(run) && !it.rows.is_empty();
    if run.measurement.as_ref().is_some_and(is_of_this) {
        app.overlay = Some(Overlay::Measured);
        return;
    }
    if is_measured {
        call_off(app);
        return remark(app, "the error is not measured any more; m begins again");
    }
    if let Some(name) = elsewhere {
        return remark(
            app,
            format!("the error of {name} is being measured: one at a time"),
        );
    }
    match job(slot, run) {
        Ok(job) => {
            effects.push(Effect::Measure(run.id, Box::new(job)));
            if let Some(run) = app.active_run_mut() {
                run.measurement = Some(Measurement::of(run));
            }
        }
        Err(reason) => remark(app, reason),
    }
}

/// What is to be measured of a run, or why it cannot be.
fn job(slot: &Slot, run: &Run) -> Result<MeasuringJob, &'static str> {
    if run.setting.is_none() {
        return Err("the run is still set up");
    }
    let schedule = Schedule::new(&slot.scene.time, 1, SNAPSHOTS);
    let mut states = run.snapshots.clone();
    states.extend(run.picture.clone());
    Ok(MeasuringJob {
        times: schedule.snapshot_times(slot.scene.time.step),
        scene: Arc::clone(&slot.scene),
        states,
        reached: run.report.t,
    })
}

/// Takes what comes in.
pub(super) fn measured(app: &mut App, run: RunId, news: MeasuringNews) {
    let Some((index, run)) = worker_events::run_of(app, run) else {
        return;
    };
    let Some(measurement) = &mut run.measurement else {
        return;
    };
    match news {
        MeasuringNews::Share(share) => measurement.share = share,
        MeasuringNews::Row(row) => {
            measurement.rows.push(row);
            measurement
                .rows
                .sort_by(|one, other| one.t.total_cmp(&other.t));
        }
        MeasuringNews::Done => measurement.is_going = false,
        MeasuringNews::Failed(words) => {
            run.measurement = None;
            run.notify(Notice {
                severity: Severity::Warning,
                step: run.report.step,
                text: format!("the error cannot be measured: {words}"),
            });
        }
    }
    app.stale |= app.shows(index);
}

/// Ends the measurement of the active run; what was measured stays.
fn call_off(app: &mut App) {
    if let Some(measurement) = app
        .active_run_mut()
        .and_then(|run| run.measurement.as_mut())
    {
        measurement.is_going = false;
    }
}
