//! Which runs compute: those that are shown and wanted. Every other one is paused.

use std::sync::Arc;
use std::time::Duration;

use super::super::message::Effect;
use super::super::run_control::WorkerState;
use super::super::state::{App, Overlay, Question, Run, Screen, Slot};
use super::pacing;
use crate::simulation::{RunId, WorkerConfig};

/// Reports are gathered for this long: shorter than the 50 ms in which a key must be answered.
const GATHERING: Duration = Duration::from_millis(40);
/// The report's set shows φ at t = 0, T/4, T/2, 3T/4 and T.
pub(in crate::tui) const SNAPSHOTS: u64 = 5;
/// No run of the gallery is ahead of another by more than this part of T (and a step).
const CLOCK_PARTS: f64 = 500.0;
/// While a run is set up, or catches up, the clock is ahead of it by no more than this part of T.
const AHEAD: f64 = 0.1;
/// A time that misses the clock's tick by rounding is on it; in ticks.
const ROUNDING: f64 = 1e-6;

/// Starts, resumes and pauses runs so that those compute that should.
pub(super) fn direct(app: &mut App, effects: &mut Vec<Effect>) {
    if app.overlay == Some(Overlay::Confirm(Question::GoOn)) {
        return;
    }
    pacing::follow_run(app);
    match app.screen {
        Screen::Run => {
            app.clock = None;
            for index in 0..app.slots.len() {
                let slot = &app.slots[index];
                let going = index == app.active && wants(slot);
                let horizon = pacing::horizon(app, slot).filter(|_| going);
                guide(app, index, going, horizon, effects);
            }
        }
        Screen::Gallery => {
            let cases = app.gallery();
            for index in (0..app.slots.len()).filter(|index| !cases.contains(index)) {
                guide(app, index, false, None, effects);
            }
            direct_gallery(app, effects);
        }
    }
    tell_statuses(app);
}

/// As many of the cases compute as there are cores: those that are furthest behind the clock, each
/// until it has come up to it. When all have, the clock moves on.
fn direct_gallery(app: &mut App, effects: &mut Vec<Effect>) {
    let cases = app.gallery();
    let clock = clock(app, &app.slots[cases.clone()], app.clock);
    app.clock = Some(clock);
    let behind = |slot: &Slot| wants(slot) && is_behind(slot, clock);
    let mut turns: Vec<usize> = cases
        .clone()
        .filter(|index| behind(&app.slots[*index]))
        .collect();
    // A run that computes keeps its turn: to change places at every step would cost pauses.
    turns.sort_by(|first, second| {
        let [first, second] = [first, second].map(|index| {
            let run = app.slots[*index].run.as_ref();
            let computes = run.is_some_and(|run| run.control.going && run.control.is_busy());
            // All are to be seen before any of them goes on.
            ((is_set_up(&app.slots[*index]), !computes), time(run))
        });
        let times = first.1.total_cmp(&second.1);
        first.0.cmp(&second.0).then(times)
    });
    let others = app
        .slots
        .iter()
        .enumerate()
        .filter(|(index, slot)| {
            let run = slot.run.as_ref();
            !turns.contains(index) && run.is_some_and(|run| run.control.is_busy())
        })
        .count();
    let mut free = app.cores.max(1).saturating_sub(others);
    let mut turn = vec![false; cases.end];
    for index in turns {
        // A run that is about to pause has its core until it is paused.
        let run = app.slots[index].run.as_ref();
        let leaving = run.is_some_and(|run| !run.control.going && run.control.is_busy());
        turn[index] = free > 0 && !leaving;
        free = free.saturating_sub(usize::from(turn[index] || leaving));
    }
    for index in cases {
        let slot = &app.slots[index];
        let holds_on = slot
            .run
            .as_ref()
            .is_some_and(|run| run.control.going && run.control.wanted && !is_behind(slot, clock));
        guide(app, index, turn[index] || holds_on, Some(clock), effects);
    }
}

/// The common clock: unchanged until every run that is in step has reached it, then its next tick after the last of
/// them. While runs are still set up, or catch up, it moves tick by tick over what the others have computed.
fn clock(app: &App, slots: &[Slot], present: Option<f64>) -> f64 {
    let wanted = || slots.iter().filter(|slot| wants(slot));
    // At first all come up to where the last one is.
    let present = present.unwrap_or_else(|| {
        let times = wanted().map(|slot| time(slot.run.as_ref()));
        times.reduce(f64::min).unwrap_or(0.0)
    });
    let tick = tick(slots);
    let Some(last) = last_in_step(slots, present) else {
        return present;
    };
    let (in_step, late): (Vec<&Slot>, Vec<&Slot>) =
        wanted().partition(|slot| is_in_step(slot, present, tick));
    let is_to_stay = in_step.iter().any(|slot| is_behind(slot, present));
    if is_to_stay || !pacing::lets_clock_pass(app, last) {
        return present;
    }
    let next = ((last / tick + ROUNDING).floor() + 1.0) * tick;
    // The cores are for those that are late: until they have come, only the stored past is shown.
    let computed = in_step.iter().map(|slot| time(slot.run.as_ref()));
    let left_behind = late
        .iter()
        .map(|slot| time(slot.run.as_ref()) + AHEAD * CLOCK_PARTS * tick);
    match late.is_empty() {
        true => next,
        false => computed
            .chain(left_behind)
            .fold(next, f64::min)
            .max(present),
    }
}

/// How far the common clock moves at least.
fn tick(slots: &[Slot]) -> f64 {
    let ends = slots.iter().map(|slot| slot.scene.time.end);
    ends.fold(0.0, f64::max) / CLOCK_PARTS
}

/// Whether a run is set up and where the others are: not further behind the clock than that moves at once.
fn is_in_step(slot: &Slot, clock: f64, tick: f64) -> bool {
    is_set_up(slot) && time(slot.run.as_ref()) >= clock - (1.0 + ROUNDING) * tick
}

fn is_set_up(slot: &Slot) -> bool {
    let run = slot.run.as_ref();
    run.is_some_and(|run| run.control.stand != WorkerState::SettingUp && run.setting.is_some())
}

/// The time that all runs have reached that compute and are in step: not beyond the clock while there are others.
fn last_in_step(slots: &[Slot], clock: f64) -> Option<f64> {
    let tick = tick(slots);
    let (in_step, late): (Vec<&Slot>, Vec<&Slot>) =
        (slots.iter().filter(|slot| wants(slot))).partition(|slot| is_in_step(slot, clock, tick));
    let times = in_step.into_iter().map(|slot| time(slot.run.as_ref()));
    let last = times.reduce(f64::min)?;
    Some(match late.is_empty() {
        true => last,
        false => last.min(clock),
    })
}

/// The time that the runs of the gallery are shown at: those that catch up are shown where they are.
pub fn common_time(app: &App) -> Option<f64> {
    let slots = &app.slots[app.gallery()];
    last_in_step(slots, app.clock.unwrap_or(0.0)).or_else(|| {
        // None of them computes.
        let runs = slots.iter().filter_map(|slot| slot.run.as_ref());
        runs.map(|run| run.report.t).reduce(f64::min)
    })
}

/// Whether a run has not come up to the clock, or is not even set up.
fn is_behind(slot: &Slot, clock: f64) -> bool {
    let run = slot.run.as_ref();
    run.is_none_or(|run| run.control.stand == WorkerState::SettingUp || run.report.t < clock)
}

/// The time that a run has reached.
fn time(run: Option<&Run>) -> f64 {
    run.map_or(0.0, |run| run.report.t)
}

/// Whether the user wants this run to compute when it is shown, and it can.
fn wants(slot: &Slot) -> bool {
    let run = slot.run.as_ref();
    run.is_none_or(|run| run.control.wanted && run.control.stand != WorkerState::Over)
}

/// Sends the worker of a slot the commands for a change; starts one if there is none and it should run.
fn guide(
    app: &mut App,
    index: usize,
    going: bool,
    horizon: Option<f64>,
    effects: &mut Vec<Effect>,
) {
    let threads = match app.screen {
        Screen::Run => app.cores,
        // They share the cores.
        Screen::Gallery => app.cores / app.gallery().len().max(1),
    };
    let slot = &mut app.slots[index];
    if let Some(run) = &mut slot.run {
        let commands = run.control.guide(going, horizon);
        effects.extend(
            commands
                .into_iter()
                .map(|command| Effect::Tell(run.id, command)),
        );
    } else if going {
        let run = app.next_run;
        app.next_run = RunId(run.0 + 1);
        let kept = slot.kept.take();
        if let Some(kept) = &kept {
            Arc::make_mut(&mut slot.scene).changes = kept.run.checkpoint().changes().to_vec();
        }
        slot.run = Some(Run {
            before: kept,
            ..Run::new(run, horizon)
        });
        let orders = WorkerConfig {
            run,
            paused: false,
            horizon,
            gathering: GATHERING,
            snapshots: SNAPSHOTS,
            threads,
        };
        effects.push(Effect::Start(orders, slot.scene.clone()));
        app.stale = true;
    }
}

/// Updates the statuses to what the workers have reported.
fn tell_statuses(app: &mut App) {
    let cases = match app.screen {
        Screen::Run => 0..0,
        Screen::Gallery => app.gallery(),
    };
    let braked = app.brake.on;
    for (index, slot) in app.slots.iter_mut().enumerate() {
        let Some(run) = &mut slot.run else { continue };
        let waits = cases.contains(&index) && run.control.wanted;
        if let Some(status) = run.control.status(waits, braked)
            && run.status != status
        {
            run.status = status;
            app.stale = true;
        }
    }
}
