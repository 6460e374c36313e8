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
            app.shown_time = None;
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
            app.shown_time = common_time(app);
        }
    }
    tell_statuses(app);
}

/// As many of the cases compute as there are cores: those that are furthest behind the clock, each
/// until it has come up to it. When all have, the clock moves on.
///
/// A run that is set up cannot be paused. If there are two cores, one is left to what is there already, so that it moves
/// while the others are set up.
fn direct_gallery(app: &mut App, effects: &mut Vec<Effect>) {
    let cases = app.gallery();
    let clock = clock(app, &app.slots[cases.clone()], app.clock);
    app.clock = Some(clock);
    let slots = &app.slots[cases.clone()];
    let least = least_in_step(slots, clock);
    let are_all_under_way = slots.iter().filter(|slot| wants(slot)).all(is_under_way);
    let some_in_step = slots
        .iter()
        .any(|slot| wants(slot) && is_in_step(slot, least));
    let cores = app.cores.max(1);
    // A run that computes keeps its turn: to change places at every step would cost pauses.
    let computes = |slot: &Slot| {
        let run = slot.run.as_ref();
        is_busy(slot) && run.is_some_and(|run| run.control.going)
    };
    let class = |slot: &Slot| match (is_under_way(slot), is_in_step(slot, least)) {
        (false, _) if computes(slot) => 0,
        (_, true) if !are_all_under_way && cores > 1 => 1,
        (false, _) => 2,
        // They catch up.
        (_, false) => 3,
        (_, true) => 4,
    };
    let behind = |slot: &Slot| wants(slot) && is_behind(slot, clock);
    let mut turns: Vec<usize> = cases
        .clone()
        .filter(|index| behind(&app.slots[*index]))
        .collect();
    turns.sort_by(|first, second| {
        let [first, second] = [first, second].map(|index| {
            let slot = &app.slots[*index];
            ((class(slot), !computes(slot)), time(slot.run.as_ref()))
        });
        let times = first.1.total_cmp(&second.1);
        first.0.cmp(&second.0).then(times)
    });
    let others = app
        .slots
        .iter()
        .enumerate()
        .filter(|(index, slot)| !turns.contains(index) && is_busy(slot))
        .count();
    let mut free = cores.saturating_sub(others);
    let mut free_for_set_up = match some_in_step {
        true => (cores - 1).max(1),
        false => cores,
    };
    // A run that is about to pause, or has lost its turn, has its core until it is paused.
    let mut held = app.slots.iter().filter(|slot| is_busy(slot)).count();
    let mut turn = vec![false; cases.end];
    for index in turns {
        let slot = &app.slots[index];
        let is_set_up = is_under_way(slot);
        let room = match is_set_up {
            true => free,
            false => free.min(free_for_set_up),
        };
        let leaving = is_busy(slot) && !computes(slot);
        turn[index] = room > 0 && !leaving && (computes(slot) || held < cores);
        held += usize::from(turn[index] && !computes(slot));
        let taken = usize::from(room > 0 || leaving);
        free = free.saturating_sub(taken);
        if !is_set_up {
            free_for_set_up = free_for_set_up.saturating_sub(taken);
        }
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
/// them; not far ahead of those that are set up, or catch up.
fn clock(app: &App, slots: &[Slot], present: Option<f64>) -> f64 {
    let wanted = || slots.iter().filter(|slot| wants(slot));
    // At first all come up to where the last one is.
    let present = present.unwrap_or_else(|| {
        let times = wanted().map(|slot| time(slot.run.as_ref()));
        times.reduce(f64::min).unwrap_or(0.0)
    });
    let tick = tick(slots);
    let Some(last) = last_in_step(slots, present) else {
        // Their first steps.
        return present.max(tick);
    };
    let least = least_in_step(slots, present);
    let (in_step, late): (Vec<&Slot>, Vec<&Slot>) =
        wanted().partition(|slot| is_in_step(slot, least));
    let is_to_stay = in_step.iter().any(|slot| is_behind(slot, present));
    if is_to_stay || !pacing::lets_clock_pass(app, last) {
        return present;
    }
    let next = ((last / tick + ROUNDING).floor() + 1.0) * tick;
    let left_behind = late
        .iter()
        .map(|slot| time(slot.run.as_ref()) + AHEAD * CLOCK_PARTS * tick);
    let next = left_behind.fold(next, f64::min);
    // Without a brake the cores are for those that catch up: until they have come, only the stored past is shown.
    let is_past_shown = !late.is_empty() && !app.brake.on && late.into_iter().all(is_under_way);
    let computed = in_step.iter().map(|slot| time(slot.run.as_ref()));
    let next = match is_past_shown {
        true => computed.fold(next, f64::min),
        false => next,
    };
    next.max(present)
}

/// How far the common clock moves at least.
fn tick(slots: &[Slot]) -> f64 {
    let ends = slots.iter().map(|slot| slot.scene.time.end);
    ends.fold(0.0, f64::max) / CLOCK_PARTS
}

/// The least time of a run in step: not further behind the clock than that moves at once. As long as some are not under
/// way, that of the run which is furthest: it does not wait for those that come one after the other.
fn least_in_step(slots: &[Slot], clock: f64) -> f64 {
    let wanted = || slots.iter().filter(|slot| wants(slot));
    if wanted().all(is_under_way) {
        return clock - (1.0 + ROUNDING) * tick(slots);
    }
    let under_way = wanted().filter(|slot| is_under_way(slot));
    let times = under_way.map(|slot| time(slot.run.as_ref()));
    times.fold(f64::NEG_INFINITY, f64::max)
}

/// Whether a run is under way and where the others are.
fn is_in_step(slot: &Slot, least: f64) -> bool {
    is_under_way(slot) && time(slot.run.as_ref()) >= least
}

/// Whether a run is set up and has taken its first step, which takes several times as long as the next ones.
fn is_under_way(slot: &Slot) -> bool {
    let run = slot.run.as_ref();
    run.is_some_and(|run| run.control.stand != WorkerState::SettingUp && run.report.step > 0)
}

/// The time that all runs have reached that compute and are in step: not beyond the clock while there are others.
fn last_in_step(slots: &[Slot], clock: f64) -> Option<f64> {
    let least = least_in_step(slots, clock);
    let (in_step, late): (Vec<&Slot>, Vec<&Slot>) =
        (slots.iter().filter(|slot| wants(slot))).partition(|slot| is_in_step(slot, least));
    let times = in_step.into_iter().map(|slot| time(slot.run.as_ref()));
    let last = times.reduce(f64::min)?;
    Some(match late.is_empty() {
        true => last,
        false => last.min(clock),
    })
}

/// The time that the runs of the gallery are shown at: those that catch up are shown where they are. It does not go back
/// when one of them has come up and is a little behind the others, but it is never beyond the run that is furthest.
pub fn common_time(app: &App) -> Option<f64> {
    let t = time_in_step(app)?;
    let runs = app.slots[app.gallery()].iter();
    let runs = runs.filter_map(|slot| slot.run.as_ref());
    let furthest = runs.map(|run| run.report.t).reduce(f64::max)?;
    let shown = app.shown_time.unwrap_or(t);
    Some(t.max(shown.min(furthest)))
}

/// The time that the runs of the gallery which are in step have reached.
pub(super) fn time_in_step(app: &App) -> Option<f64> {
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

/// Whether a run has a core.
fn is_busy(slot: &Slot) -> bool {
    let run = slot.run.as_ref();
    run.is_some_and(|run| run.control.is_busy())
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
