//! What happens because time passes: the brake lets runs go on, and the stored past is played.

use std::time::Duration;

use super::super::brake::Replay;
use super::super::state::{App, Run, Screen, Slot};
use super::actions;
use super::scheduling::time_in_step;

/// Whether anything happens when time passes: else no message is needed, and the app sleeps.
pub fn time_counts(app: &App) -> bool {
    app.replay.is_some()
        || (app.brake.on && watched(app).is_some_and(|run| run.is_kept_up_with(app)))
}

/// The run that the brake is for: where it is, its last step, and T.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watched {
    t: f64,
    dt: f64,
    end: f64,
}

impl Watched {
    fn of(slot: &Slot) -> Option<Self> {
        let run = slot.run.as_ref()?;
        let is_going = run.control.wanted && !run.is_over() && run.setting.is_some();
        is_going.then_some(Self {
            t: run.report.t,
            dt: run.report.dt,
            end: slot.loaded.time.end,
        })
    }

    fn is_kept_up_with(self, app: &App) -> bool {
        !app.brake.is_ahead(self.t, self.end)
    }
}

/// The active run, in the gallery the one that is furthest behind of those in step: if it is to go on.
fn watched(app: &App) -> Option<Watched> {
    match app.screen {
        Screen::Run => Watched::of(app.active_slot()?),
        Screen::Gallery => {
            let t = time_in_step(app)?;
            let runs = app.slots[app.gallery()].iter().filter_map(Watched::of);
            let ahead = runs.filter(|run| run.t >= t);
            let next = ahead.min_by(|one, other| one.t.total_cmp(&other.t))?;
            Some(Watched { t, ..next })
        }
    }
}

/// Time has passed.
pub(super) fn passed(app: &mut App, passed: Duration) {
    if app.brake.on
        && let Some(run) = watched(app)
    {
        app.brake.release(passed, run.end);
    }
    play_on(app, passed);
}

/// Keeps the brake near the run that it is for: another one may be shown now, or it has taken steps.
pub(super) fn follow_run(app: &mut App) {
    if let Some(Watched { t, dt, end }) = watched(app) {
        app.brake.keep_to(t, dt, end);
    }
}

/// The horizon that the brake gives a run that is shown alone.
pub(super) fn horizon(app: &App, slot: &Slot) -> Option<f64> {
    match &slot.run {
        None => app.brake.on.then_some(0.0),
        Some(run) => app
            .brake
            .horizon(run.report.t, slot.loaded.time.end, run.control.horizon),
    }
}

/// Takes the brake off, or puts it on.
pub(super) fn turn_brake(app: &mut App) {
    app.brake.on = !app.brake.on;
    let seconds = app.brake.seconds;
    let text = match app.brake.on {
        true => format!(
            "the brake is on: a run takes {seconds} s to its end, or as long as it is computed"
        ),
        false => "the brake is off: runs are shown as fast as they are computed".to_owned(),
    };
    super::remark(app, text);
}

/// By how much the past is played faster or slower at most.
const FASTEST: f64 = 16.0;

/// Plays the past twice as fast, or half as fast, if it is played.
pub(super) fn change_speed(app: &mut App, faster: bool) -> bool {
    let Some(replay) = &mut app.replay else {
        return false;
    };
    let factor = if faster { 2.0 } else { 0.5 };
    replay.speed = (factor * replay.speed).clamp(FASTEST.recip(), FASTEST);
    let text = format!("the past is played at {} times the pace", replay.speed);
    super::remark(app, text);
    true
}

/// Plays the stored past from the picture that is shown, from the first one where the present is shown; stops at the
/// picture that is shown where it is played already.
pub(super) fn play_or_stop(app: &mut App) {
    if app.replay.take().is_some() {
        return;
    }
    let index = app.looking_back.unwrap_or(0);
    let Some(picture) = app.active_run().and_then(|run| run.past.get(index)) else {
        return;
    };
    let t = picture.report.t;
    actions::look_back(app, Some(index));
    app.replay = Some(Replay { t, speed: 1.0 });
}

/// Each picture is shown for as long as the brake shows its step, times the speed. After the last one follows the present, or
/// where the run is over the first one again.
fn play_on(app: &mut App, passed: Duration) {
    let Some(replay) = app.replay else { return };
    let Some((run, end)) = app.active_slot().and_then(|slot| {
        let run: &Run = slot.run.as_ref()?;
        Some((run, slot.loaded.time.end))
    }) else {
        return;
    };
    let past = &run.past;
    let speed = replay.speed;
    let mut t = replay.t + speed * passed.as_secs_f64() / app.brake.seconds * end;
    let mut index = past.first_from(t);
    if index + 1 >= past.len() && past.len() > 1 && run.is_over() {
        (t, index) = (0.0, 0);
    }
    let is_over = index + 1 >= past.len();
    let shown = (!is_over).then_some(index);
    if shown != app.looking_back {
        actions::look_back(app, shown);
        app.stale = true;
    }
    app.replay = (!is_over).then_some(Replay { t, speed });
}

/// Whether the brake lets the common clock of the gallery go beyond this time.
pub(super) fn lets_clock_pass(app: &App, last: f64) -> bool {
    !app.brake.on || app.brake.released > last
}
