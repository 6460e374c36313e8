//! What the keys do when nothing lies over the screen.

use std::sync::Arc;

use super::super::keys::Action;
use super::super::message::Effect;
use super::super::state::{
    App, Beyond, Director, Ending, Field, Keeping, Notice, Overlay, Panel, Question, Run, Save,
    Screen, Severity, Slot, Status, Zoom,
};
use super::{accuracy, knobs, leave, measuring, pacing, remark, saving, theory};
use crate::record::ShortNumber;
use crate::scene::{AnchoringKind, Change};
use crate::simulation::{Command, RunId, step_count};

/// The frame rates that the keys go through.
const FRAME_RATES: [u32; 7] = [1, 2, 5, 10, 15, 20, 30];

pub(super) fn act(app: &mut App, action: Action, effects: &mut Vec<Effect>) {
    match action {
        Action::PauseOrResume => pause_or_resume(app, effects),
        Action::Step => step(app, effects),
        Action::Restart => ask(app, Question::Restart, effects),
        Action::Show(number) => look_at(app, app.slot_of_key(number)),
        Action::OtherForm => show_other_form(app),
        Action::Brake => pacing::turn_brake(app),
        Action::Play => pacing::play_or_stop(app),
        Action::NextAnchoring => next_anchoring(app, effects),
        Action::Knobs => knobs::open(app),
        Action::TakeBack => knobs::take_back(app, effects),
        Action::Gallery => gallery(app, false),
        Action::GalleryOfOpened => gallery(app, true),
        Action::LookAt => look_at(app, app.active),
        Action::Older(pictures) => scrub(app, |index, _| index.saturating_sub(pictures)),
        Action::Newer(pictures) => scrub(app, |index, _| index.saturating_add(pictures)),
        Action::Oldest => scrub(app, |_, _| 0),
        Action::Live => look_back(app, None),
        Action::SaveView => save_view(app, effects),
        Action::SaveSet => save_set(app, effects),
        Action::Director => app.view.director = next_style(app.view.director),
        Action::Zoom => app.view.zoom = next_zoom(app.view.zoom),
        Action::ColourMap => app.view.colour_map = app.view.colour_map.wrapping_add(1),
        Action::Logarithmic => app.view.logarithmic = !app.view.logarithmic,
        Action::Theory => theory::turn(app),
        Action::NextField => next_field(app),
        Action::Next => next(app, 1),
        Action::Previous => next(app, -1),
        Action::Faster => change_frame_rate(app, true),
        Action::Slower => change_frame_rate(app, false),
        Action::Edit => {
            app.editing = Some(app.active);
            effects.push(Effect::Edit(app.active));
        }
        Action::Open => {
            app.overlay = Some(Overlay::Open {
                text: String::new(),
                chosen: None,
                error: None,
            });
        }
        Action::Prices => {
            if let Some(slot) = app.active_slot() {
                effects.push(Effect::Price(Arc::clone(&slot.scene)));
                let text = "getting ready to measure".to_owned();
                app.overlay = Some(Overlay::Prices { text });
            }
        }
        Action::Accuracy => accuracy::open(app),
        Action::Measure => measuring::press(app, effects),
        Action::Notices => show_notices(app),
        Action::Help => app.overlay = Some(Overlay::Help { scroll: 0 }),
        Action::Suspend => effects.push(Effect::Suspend),
        Action::Quit => ask(app, Question::Quit, effects),
        // Keys of overlays.
        Action::Close
        | Action::Yes
        | Action::No
        | Action::Scroll(_)
        | Action::Choose(_)
        | Action::Complete
        | Action::Load
        | Action::Erase
        | Action::Clear
        | Action::Turn(_)
        | Action::Duration
        | Action::Apply => {}
    }
}

/// All that the run has to say, the gravest first and of these the newest; at last what the solver did.
fn show_notices(app: &mut App) {
    let Some(run) = app.active_run() else {
        return;
    };
    let mut notices: Vec<&Notice> = run.notices.iter().rev().collect();
    notices.sort_by_key(|notice| std::cmp::Reverse(notice.severity));
    let logged = notices.partition_point(|notice| notice.severity > Severity::Log);
    let (grave, logged) = notices.split_at(logged);
    let mut said: Vec<String> = grave.iter().map(ToString::to_string).collect();
    if !logged.is_empty() {
        said.push("What was done on the way:".to_owned());
        said.extend(logged.iter().map(ToString::to_string));
    }
    app.overlay = Some(Overlay::Message {
        title: "Warnings and notes".to_owned(),
        text: said.join("\n\n"),
        scroll: 0,
    });
}

/// Asks before something is lost, and does at once what loses nothing.
pub(super) fn ask(app: &mut App, question: Question, effects: &mut Vec<Effect>) {
    let loses = match question {
        Question::Quit => app.has_unsaved(),
        Question::Restart => app.active_run().is_some_and(|run| run.unsaved),
        Question::GoOn | Question::GoBeyond(_) => true,
        Question::Reload => app.reloaded.as_ref().is_some_and(|(index, _)| {
            let run = app.slots.get(*index).and_then(|slot| slot.run.as_ref());
            run.is_some_and(|run| run.unsaved)
        }),
    };
    if loses {
        if question == Question::Quit {
            keep(app, effects);
        }
        app.overlay = Some(Overlay::Confirm(question));
    } else {
        consent(app, question, effects);
    }
}

/// Has the states kept that would be lost, so that it is known how that went before anybody leaves. The
/// thread of a run that has failed has ended, and kept its own.
fn keep(app: &mut App, effects: &mut Vec<Effect>) {
    for run in app.slots.iter_mut().filter_map(|slot| slot.run.as_mut()) {
        if run.unsaved && !matches!(run.status, Status::Failed(_)) {
            run.keeping = Keeping::Pending;
            effects.push(Effect::Tell(run.id, Command::Keep));
        }
    }
}

/// Does what was asked.
pub(super) fn consent(app: &mut App, question: Question, effects: &mut Vec<Effect>) {
    match question {
        Question::Quit => leave(app, Ending::Quit, effects),
        Question::Restart => {
            if let Some(run) = begin_anew(app, app.active) {
                effects.push(Effect::Discard(run));
            }
        }
        // They are where the next runs begin.
        Question::GoOn => {}
        Question::GoBeyond(beyond) => go_beyond(app, beyond, effects),
        Question::Reload => {
            if let Some((index, slot)) = app.reloaded.take() {
                if let Some(run) = begin_anew(app, index) {
                    effects.push(Effect::Drop(run));
                }
                if let Some(place) = app.slots.get_mut(index) {
                    *place = *slot;
                }
                app.screen = Screen::Run;
                look_at(app, index);
                app.offer_to_go_on();
            }
        }
    }
}

/// Takes the run of a slot away. Another begins when the slot is shown: at once, if it is now.
fn begin_anew(app: &mut App, index: usize) -> Option<RunId> {
    if index == app.active {
        look_back(app, None);
    }
    let slot = app.slots.get_mut(index)?;
    slot.kept = None;
    // It may have gone beyond its end.
    let scene = Arc::make_mut(&mut slot.scene);
    scene.time.end = slot.loaded.time.end;
    // What was changed by hand holds from the start.
    scene.begin_with_changes(&slot.loaded.changes);
    let run = slot.run.take()?;
    // The next run begins with the anchoring that was asked for, confirmed or not.
    if let Some(kind) = run.control.anchoring {
        slot.set_anchoring(kind);
    }
    Some(run.id)
}

/// Shows the run of a slot alone.
pub(super) fn look_at(app: &mut App, index: usize) {
    if index >= app.slots.len() {
        let opened = app.slots.len().saturating_sub(app.opened());
        let last = app.cases().len() + opened;
        remark(app, format!("there are {last} scenes; o opens another"));
        return;
    }
    app.screen = Screen::Run;
    choose(app, index);
}

/// Makes a slot the active one.
fn choose(app: &mut App, index: usize) {
    if index != app.active {
        look_back(app, None);
        app.active = index;
        app.follow_form();
        if let Some(words) = app.slots[index].remark.take() {
            remark(app, words);
        }
    }
    if !fields(&app.slots[index]).contains(&app.view.field) {
        app.view.field = Field::Phase;
    }
}

/// Shows several runs side by side: the quick ones of the four cases, or the scenes that were opened; once more: the
/// active one alone.
fn gallery(app: &mut App, of_opened: bool) {
    if app.screen == Screen::Gallery && app.gallery_of_opened == of_opened {
        return look_at(app, app.active);
    }
    look_back(app, None);
    app.screen = Screen::Gallery;
    app.gallery_of_opened = of_opened;
    app.clock = None;
    app.shown_time = None;
    let is_case = app.active < app.opened();
    if is_case && !of_opened {
        choose(app, app.active % App::CASES);
    }
    let there = app.gallery();
    if !there.contains(&app.active) && !there.is_empty() {
        choose(app, there.start);
    }
}

/// Shows the active case in its other form: quick, or as printed; in the gallery all cases.
fn show_other_form(app: &mut App) {
    if let Some(index) = app.other_form() {
        choose(app, index);
    }
}

/// Continues the active run, which has reached its end, to a later one.
fn go_beyond(app: &mut App, beyond: Beyond, effects: &mut Vec<Effect>) {
    look_back(app, None);
    let Some(slot) = app.slots.get_mut(app.active) else {
        return;
    };
    let Some(run) = slot.run.as_mut().filter(|run| run.is_done()) else {
        return;
    };
    let Some((end, setting)) = run.later_end().zip(run.setting.as_deref()) else {
        return;
    };
    let mut setting = setting.clone();
    setting.scene.time.end = end;
    setting.steps = step_count(&setting.scene.time);
    run.setting = Some(Arc::new(setting));
    Arc::make_mut(&mut slot.scene).time.end = end;
    if let Beyond::Anchor(kind) = beyond {
        run.control.anchoring = Some(kind);
        effects.push(Effect::Tell(run.id, anchor(kind)));
    }
    effects.push(Effect::Tell(run.id, Command::Until(end)));
    run.control.reopen();
    run.control.wanted = true;
    if beyond == Beyond::Step {
        let command = run.control.step();
        effects.push(Effect::Tell(run.id, command));
    }
    remark(
        app,
        format!("the run continues to t = {}", ShortNumber(end)),
    );
}

/// Whether the run that a key is for has reached its end.
fn is_done(app: &App) -> bool {
    app.active_run().is_some_and(Run::is_done)
}

fn pause_or_resume(app: &mut App, effects: &mut Vec<Effect>) {
    // What is shown is what is to stand still.
    if app.replay.take().is_some() {
        return;
    }
    if app.screen == Screen::Run && is_done(app) {
        ask(app, Question::GoBeyond(Beyond::Run), effects);
        return;
    }
    let wanted = !app.is_going();
    let slots = match app.screen {
        Screen::Run => app.active..app.active + 1,
        Screen::Gallery => app.gallery(),
    };
    for slot in app.slots.get_mut(slots).unwrap_or_default() {
        if let Some(run) = &mut slot.run {
            run.control.wanted = wanted;
        }
    }
}

fn step(app: &mut App, effects: &mut Vec<Effect>) {
    if is_done(app) {
        ask(app, Question::GoBeyond(Beyond::Step), effects);
        return;
    }
    // A step is taken from the present, and looked at.
    look_back(app, None);
    if let Some(run) = app.active_run_mut() {
        let command = run.control.step();
        effects.push(Effect::Tell(run.id, command));
    }
}

/// Asks for the next anchoring, for the run of the active slot as it is and for those to come.
fn next_anchoring(app: &mut App, effects: &mut Vec<Effect>) {
    let is_done = is_done(app);
    let Some(slot) = app.slots.get_mut(app.active) else {
        return;
    };
    let Some(present) = slot.anchoring() else {
        return;
    };
    let asked = slot.run.as_ref().and_then(|run| run.control.anchoring);
    let kind = asked.unwrap_or(present).next();
    if is_done {
        ask(app, Question::GoBeyond(Beyond::Anchor(kind)), effects);
        return;
    }
    let mut text = format!("the anchoring is {kind} from here on");
    match &mut slot.run {
        None => slot.set_anchoring(kind),
        Some(run) => {
            run.control.anchoring = Some(kind);
            if matches!(run.status, Status::Failed(_)) {
                text = format!("the anchoring is {kind} when the run is restarted: r");
            } else {
                effects.push(Effect::Tell(run.id, anchor(kind)));
            }
        }
    }
    remark(app, text);
}

/// The command to change the anchoring.
fn anchor(kind: AnchoringKind) -> Command {
    Command::Change {
        set: Change::of_anchoring(kind),
        over: 0.0,
    }
}

/// Moves to another stored picture; past the newest is the present.
fn scrub(app: &mut App, target: impl FnOnce(usize, usize) -> usize) {
    let Some(run) = app.active_run() else { return };
    let Some(last) = run.past.len().checked_sub(1) else {
        return;
    };
    let index = target(app.looking_back.unwrap_or(last), last);
    look_back(app, (index < last).then_some(index));
}

/// Shows a stored picture of the active run, or the present; nothing is played any more.
pub(super) fn look_back(app: &mut App, index: Option<usize>) {
    app.replay = None;
    app.looking_back = index;
    if let Some(run) = app.active_run_mut() {
        let picture = index.and_then(|index| run.past.get(index));
        let step = picture.map(|picture| picture.report.step);
        run.past.pin(step);
    }
}

fn save_view(app: &mut App, effects: &mut Vec<Effect>) {
    if let Some(picture) = app.picture().cloned() {
        saving::save(app, Save::View(picture, app.active), effects);
    }
}

fn save_set(app: &mut App, effects: &mut Vec<Effect>) {
    if let Some(run) = app.active_run() {
        let save = Save::Set {
            slot: app.active,
            run: run.id,
            step: run.report.step,
        };
        saving::save(app, save, effects);
    }
}

fn next_style(style: Director) -> Director {
    match style {
        Director::Strokes => Director::Arrows,
        Director::Arrows => Director::Off,
        Director::Off => Director::Strokes,
    }
}

fn next_zoom(zoom: Zoom) -> Zoom {
    match zoom {
        Zoom::Fit => Zoom::Domain,
        Zoom::Domain => Zoom::Double,
        Zoom::Double => Zoom::Fit,
    }
}

/// The fields that a slot has, in the order of the key.
fn fields(slot: &Slot) -> Vec<Field> {
    let all = [
        Field::Phase,
        Field::DirectorLength,
        Field::Omega,
        Field::Mu,
        Field::EnergyDensity,
    ];
    let has = |field: &Field| *field != Field::DirectorLength || slot.scene.nematic.is_some();
    all.into_iter().filter(has).collect()
}

fn next_field(app: &mut App) {
    let Some(slot) = app.active_slot() else {
        return;
    };
    let fields = fields(slot);
    let present = fields.iter().position(|field| *field == app.view.field);
    app.view.field = fields[present.map_or(0, |index| (index + 1) % fields.len())];
}

/// The next panel, or in the gallery the next run.
fn next(app: &mut App, by: isize) {
    let move_by = |index: usize, count: usize| {
        let count = count.max(1) as isize;
        (index as isize + by).rem_euclid(count) as usize
    };
    match app.screen {
        Screen::Run => {
            let panels = [Panel::Field, Panel::Energy, Panel::Area, Panel::Cost];
            let present = panels.iter().position(|panel| *panel == app.focus);
            app.focus = panels[move_by(present.unwrap_or(0), panels.len())];
        }
        Screen::Gallery => {
            let there = app.gallery();
            let index = move_by(app.active.saturating_sub(there.start), there.len());
            choose(app, there.start + index);
        }
    }
}

fn change_frame_rate(app: &mut App, faster: bool) {
    if pacing::change_speed(app, faster) {
        return;
    }
    let present = app.frames_per_second;
    let mut rates = FRAME_RATES.into_iter();
    let rate = if faster {
        rates.find(|rate| *rate > present)
    } else {
        rates.rev().find(|rate| *rate < present)
    };
    app.frames_per_second = rate.unwrap_or(present);
    let text = match app.frames_per_second {
        1 => "at most 1 frame a second".to_owned(),
        rate => format!("at most {rate} frames a second"),
    };
    remark(app, text);
}
