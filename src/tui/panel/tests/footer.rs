//! The keys that the footer names in each state of a run.

use std::sync::Arc;

use ratatui::layout::Rect;

use super::made_up::{self, notice};
use super::{characters, drawn};
use crate::tui::keys::Footer;
use crate::tui::state::{App, Overlay, Question, Screen, Severity, Status};
use crate::tui::theme::{ColorTier, Theme};

/// A state, how the app gets there, and what the footer begins with at 80 columns.
type State = (&'static str, fn(&mut App), &'static str);

const STATES: &[State] = &[
    (
        "not started",
        |app| app.active = 3,
        "space pause  1 2 3 4 case  g four cases  o open  e edit",
    ),
    (
        "set up",
        |app| {
            let run = made_up::run(app);
            (run.status, run.setting) = (Status::Starting, None);
        },
        "space pause  1 2 3 4 case  g four cases  o open  e edit",
    ),
    (
        "running",
        |_| {},
        "space pause  a anchoring  1 2 3 4 case  g four cases  k knobs",
    ),
    (
        "waiting",
        |app| made_up::run(app).status = Status::Waiting,
        "space pause  a anchoring  1 2 3 4 case  g four cases  k knobs",
    ),
    (
        "paused",
        |app| {
            let run = made_up::run(app);
            (run.status, run.control.wanted) = (Status::Paused, false);
        },
        "space resume  n step  ← → past  s save view  a anchoring",
    ),
    (
        "in the past",
        |app| app.looking_back = Some(1),
        "← → past  Home End first/live  P play again  s save view",
    ),
    (
        "over",
        |app| made_up::run(app).status = Status::Done,
        "space go on to 2T  P play again  s save view  S save set",
    ),
    (
        "failed",
        |app| {
            let run = made_up::run(app);
            run.status = Status::Failed("the step was not solved".to_owned());
            run.notices.push_back(notice(Severity::Error, "it failed"));
        },
        "w warnings  r restart  e edit  1 2 3 4 case  s save view",
    ),
    (
        "a warning",
        |app| {
            let warning = notice(Severity::Warning, "the shape is not to be trusted");
            made_up::run(app).notices.push_back(warning);
        },
        "w warnings  space pause  a anchoring  1 2 3 4 case",
    ),
    (
        "a note",
        |app| {
            let note = notice(Severity::Note, "two vesicles have become one");
            made_up::run(app).notices.push_back(note);
        },
        "space pause  a anchoring  1 2 3 4 case  g four cases",
    ),
    (
        "gallery",
        |app| app.screen = Screen::Gallery,
        "Tab Shift-Tab next run  Enter Esc look at it  space pause",
    ),
    (
        "a question",
        |app| app.overlay = Some(Overlay::Confirm(Question::Quit)),
        "y yes  n no  Esc not now",
    ),
];

fn theme() -> Theme {
    Theme::new(ColorTier::Palette, true)
}

fn footer(app: &App, theme: &Theme, columns: u16) -> String {
    let rows = 30;
    let screen = drawn(app, theme, columns, rows);
    characters(&screen, Rect::new(0, rows - 1, columns, 1))
}

fn in_state(change: fn(&mut App)) -> App {
    let mut app = made_up::app();
    change(&mut app);
    app
}

#[test]
fn the_footer_begins_with_what_matters() {
    for (state, change, expected) in STATES {
        let footer = footer(&in_state(*change), &theme(), 80);
        assert!(
            footer.trim_start().starts_with(expected),
            "{state}: {footer}"
        );
        assert!(footer.chars().count() <= 80);
    }
}

#[test]
fn keys_are_named_whole_or_not_at_all_and_help_always() {
    for ascii in [false, true] {
        let theme = Theme::new(ColorTier::None, !ascii);
        for (state, change, _) in STATES {
            let app = in_state(*change);
            let Footer { first, always } = Footer::of(&app);
            let named = |binding: &crate::tui::keys::Binding| {
                let label = theme.word(binding.label, binding.plain_label);
                format!("{label} {}", (binding.brief)(&app))
            };
            let whole: Vec<String> = first.iter().chain(&always).map(|it| named(it)).collect();
            for columns in (80..200).step_by(9) {
                let footer = footer(&app, &theme, columns);
                let keys: Vec<&str> = footer.trim().split("  ").collect();
                for key in &keys {
                    let is_whole = whole.iter().any(|it| it == key);
                    assert!(
                        is_whole,
                        "{state}, {columns} columns: {key:?} of {footer:?}"
                    );
                }
                let ends = keys.ends_with(&["q quit", "? help"]);
                assert!(ends || app.overlay.is_some(), "{state}: {footer}");
            }
        }
    }
}

#[test]
fn a_key_that_does_nothing_is_not_named() {
    let mut app = made_up::app();
    let scene = Arc::make_mut(&mut app.slots[2].scene);
    (scene.nematic, scene.anchoring) = (None, None);
    assert!(!footer(&app, &theme(), 200).contains("a anchoring"));
}
