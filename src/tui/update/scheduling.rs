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
            let cases = app.cases();
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
    let cases = app.cases();
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
            (!computes, time(run))
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

/// The common clock: unchanged until every run that computes has reached it, then its next tick
/// after the last of them.
fn clock(app: &App, cases: &[Slot], present: Option<f64>) -> f64 {
    let times = || cases.iter().filter(|slot| wants(slot));
    let last = times()
        .map(|slot| time(slot.run.as_ref()))
        .fold(f64::INFINITY, f64::min);
    // At first all come up to where the last one is: those that have no run are set up.
    let present = present.unwrap_or(if last.is_finite() { last } else { 0.0 });
    let is_to_stay = !last.is_finite() || times().any(|slot| is_behind(slot, present));
    if is_to_stay || !pacing::lets_clock_pass(app, last) {
        return present;
    }
    let end = cases
        .iter()
        .map(|slot| slot.scene.time.end)
        .fold(0.0, f64::max);
    let tick = end / CLOCK_PARTS;
    ((last / tick + ROUNDING).floor() + 1.0) * tick
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
        Screen::Gallery => app.cores / app.cases().len().max(1),
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
        Screen::Gallery => app.cases(),
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
