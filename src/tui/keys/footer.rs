//! What the footer names: what the keys do at present, what matters most in the state of the run first.

use super::super::state::{App, Screen, Severity, Status};
use super::{Action, Binding, Place, bindings};

/// The keys of the footer.
#[derive(Debug)]
pub struct Footer {
    /// What matters most first: the last ones are left out where there is no room.
    pub first: Vec<&'static Binding>,
    /// What stands at the end in any case: the way to all other keys, and out.
    pub always: Vec<&'static Binding>,
}

impl Footer {
    /// At present.
    pub fn of(app: &App) -> Self {
        let place = Place::of(app);
        let mut here: Vec<&Binding> = bindings(place)
            .filter(|binding| (binding.when)(app).is_ok())
            .collect();
        if place != Place::Main {
            let always = Vec::new();
            return Self {
                first: here,
                always,
            };
        }
        let does = |binding: &Binding, action| binding.keys.iter().any(|(_, it)| *it == action);
        let (always, rest): (Vec<_>, Vec<_>) =
            (here.into_iter()).partition(|it| does(it, Action::Help) || does(it, Action::Quit));
        here = rest;
        let matters = matters(app);
        let rank = |binding: &&Binding| {
            let place = matters.iter().position(|action| does(binding, *action));
            place.unwrap_or(matters.len())
        };
        // Of the others the order of the table is kept.
        here.sort_by_key(rank);
        Self {
            first: here,
            always,
        }
    }
}

/// What matters in the state of the run.
fn matters(app: &App) -> Vec<Action> {
    let run = app.active_run();
    let mut actions = Vec::new();
    let warns = run.is_some_and(|run| {
        let mut notices = run.notices.iter();
        notices.any(|notice| notice.severity >= Severity::Warning)
    });
    if warns && app.screen == Screen::Run {
        actions.push(Action::Notices);
    }
    let status = run
        .filter(|run| run.setting.is_some() || run.is_over())
        .map(|run| &run.status);
    actions.extend_from_slice(match status {
        _ if app.screen == Screen::Gallery => &[
            Action::Next,
            Action::LookAt,
            Action::PauseOrResume,
            Action::NextAnchoring,
            Action::Brake,
        ],
        _ if app.looking_back.is_some() => &[
            Action::Older(1),
            Action::Live,
            Action::Play,
            Action::SaveView,
            Action::PauseOrResume,
        ],
        None | Some(Status::Starting) => &[
            Action::PauseOrResume,
            Action::Show(0),
            Action::OtherForm,
            Action::Gallery,
            Action::Open,
            Action::Edit,
        ],
        Some(Status::Running | Status::Waiting) => &[
            Action::PauseOrResume,
            Action::NextAnchoring,
            Action::Show(0),
            Action::Gallery,
            Action::Knobs,
        ],
        Some(Status::Pausing | Status::Paused) => &[
            Action::PauseOrResume,
            Action::Step,
            Action::Older(1),
            Action::SaveView,
            Action::NextAnchoring,
            Action::Knobs,
        ],
        Some(Status::Done) => &[
            Action::PauseOrResume,
            Action::Play,
            Action::SaveView,
            Action::SaveSet,
            Action::Show(0),
            Action::Gallery,
        ],
        Some(Status::Failed(_)) => &[
            Action::Restart,
            Action::Edit,
            Action::Show(0),
            Action::SaveView,
        ],
    });
    actions
}
