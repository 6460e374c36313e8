//! All keys, declared once: what a key does, the footer, the help, and the README's table are read
//! from [`BINDINGS`].

use std::fmt::Write as _;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::state::{App, Overlay, Screen, Status};

/// What a key does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Pause or resume the run, in the gallery all runs.
    PauseOrResume,
    /// One step.
    Step,
    /// Begin the run anew.
    Restart,
    /// Look at a slot.
    Show(usize),
    /// Switch the anchoring.
    NextAnchoring,
    /// Into the gallery or out of it.
    Gallery,
    /// So many stored pictures back.
    Older(usize),
    /// So many stored pictures on.
    Newer(usize),
    /// The oldest picture.
    Oldest,
    /// Back to the present.
    Live,
    /// Save what is looked at.
    SaveView,
    /// Save the report's set.
    SaveSet,
    /// The director's next style.
    Director,
    /// The next colour map.
    ColourMap,
    /// Logarithmic curves or not.
    Logarithmic,
    /// The next field.
    NextField,
    /// The next panel, in the gallery the next run.
    Next,
    /// The one before.
    Previous,
    /// More frames a second.
    Faster,
    /// Fewer frames a second.
    Slower,
    /// Edit the scene and load it anew.
    Edit,
    /// Open another scene.
    Open,
    /// Show all keys.
    Help,
    /// Leave what lies over the screen.
    Close,
    /// Stop the process, to be continued.
    Suspend,
    /// Leave the app.
    Quit,
    /// Do what is asked.
    Yes,
    /// Do not.
    No,
    /// Scroll by lines.
    Scroll(i32),
    /// Another line of the list of scenes.
    Choose(i32),
    /// Complete the name that is typed.
    Complete,
    /// Load the scene that is typed or chosen.
    Load,
    /// Delete the last character.
    Erase,
    /// Delete all characters.
    Clear,
}

/// Where a key means something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// With nothing over the screen.
    Main,
    /// The list of all keys.
    Help,
    /// A question.
    Confirm,
    /// Where a scene's name is typed; characters that mean nothing else are typed.
    Open,
    /// A long text.
    Message,
}

impl Place {
    /// Where the app takes its keys at present.
    pub fn of(app: &App) -> Self {
        match &app.overlay {
            None => Self::Main,
            Some(Overlay::Help { .. }) => Self::Help,
            Some(Overlay::Confirm(_)) => Self::Confirm,
            Some(Overlay::Open { .. }) => Self::Open,
            Some(Overlay::Message { .. }) => Self::Message,
        }
    }
}

/// A key of the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    code: KeyCode,
    control: bool,
}

impl Key {
    const fn character(character: char) -> Self {
        Self::named(KeyCode::Char(character))
    }

    const fn named(code: KeyCode) -> Self {
        let control = false;
        Self { code, control }
    }

    const fn control(character: char) -> Self {
        Self {
            code: KeyCode::Char(character),
            control: true,
        }
    }

    /// Whether it is this key that was pressed. Shift is in the character already.
    fn is_pressed(self, event: &KeyEvent) -> bool {
        let modifiers = event.modifiers - KeyModifiers::SHIFT;
        let expected = if self.control {
            KeyModifiers::CONTROL
        } else {
            KeyModifiers::NONE
        };
        self.code == event.code && modifiers == expected
    }
}

/// Some keys that belong together, and what they do.
#[derive(Debug, Clone, Copy)]
pub struct Binding {
    /// Where.
    pub place: Place,
    /// Each key with its action.
    pub keys: &'static [(Key, Action)],
    /// The keys, in words.
    pub label: &'static str,
    /// The same in ASCII.
    pub plain_label: &'static str,
    /// What they do at present, in a word or two, in ASCII; for the footer.
    pub brief: fn(&App) -> &'static str,
    /// What they do, for the help and the README, in ASCII.
    pub words: &'static str,
    /// Whether they do anything at present, or why not.
    pub when: fn(&App) -> Result<(), &'static str>,
}

/// The bindings of a place, in the order of their weight: where there is no room for all in a
/// footer the last ones are left out.
pub fn bindings(place: Place) -> impl Iterator<Item = &'static Binding> {
    BINDINGS
        .iter()
        .filter(move |binding| binding.place == place)
}

/// What the footer names: the bindings that do something at present.
pub fn footer(app: &App) -> impl Iterator<Item = &'static Binding> {
    bindings(Place::of(app)).filter(|binding| (binding.when)(app).is_ok())
}

/// What a key does where the app is at present: an action, or why it does nothing now. `None`: it
/// means nothing here.
pub fn action(app: &App, event: &KeyEvent) -> Option<Result<Action, &'static str>> {
    bindings(Place::of(app)).find_map(|binding| {
        let (_, action) = binding.keys.iter().find(|(key, _)| key.is_pressed(event))?;
        Some((binding.when)(app).map(|()| *action))
    })
}

/// The README's table of the keys.
pub fn markdown() -> String {
    let mut table = "| key | what it does |\n| --- | --- |\n".to_owned();
    for binding in bindings(Place::Main) {
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| `{}` | {} |", binding.label, binding.words);
    }
    table
}

const fn key(character: char, action: Action) -> (Key, Action) {
    (Key::character(character), action)
}

const fn named(code: KeyCode, action: Action) -> (Key, Action) {
    (Key::named(code), action)
}

const fn control(character: char, action: Action) -> (Key, Action) {
    (Key::control(character), action)
}

fn always(_: &App) -> Result<(), &'static str> {
    Ok(())
}

fn on_one_run(app: &App) -> Result<(), &'static str> {
    match app.screen {
        Screen::Run => Ok(()),
        Screen::Gallery => Err("not in the gallery: g leaves it"),
    }
}

fn when_not_over(app: &App) -> Result<(), &'static str> {
    match app.active_run().map(|run| &run.status) {
        Some(Status::Done) if app.screen == Screen::Run => Err("the run is done: r begins it anew"),
        Some(Status::Failed(_)) if app.screen == Screen::Run => {
            Err("the run has failed: r begins it anew, e edits its scene")
        }
        _ => Ok(()),
    }
}

fn when_a_step_is_left(app: &App) -> Result<(), &'static str> {
    on_one_run(app).and_then(|()| when_not_over(app))
}

fn with_a_past(app: &App) -> Result<(), &'static str> {
    on_one_run(app)?;
    match app.active_run() {
        Some(run) if run.past.len() > 1 => Ok(()),
        _ => Err("nothing older is stored yet"),
    }
}

fn with_director(app: &App) -> Result<(), &'static str> {
    match app.active_slot() {
        Some(slot) if slot.scene.nematic.is_none() => {
            Err("this scene has no director: give it a table [nematic]")
        }
        _ => Ok(()),
    }
}

fn with_picture(app: &App) -> Result<(), &'static str> {
    match app.picture() {
        Some(_) => Ok(()),
        None => Err("there is nothing to save yet"),
    }
}

fn with_opened_scenes(app: &App) -> Result<(), &'static str> {
    if app.slots.len() > App::CASES {
        Ok(())
    } else {
        Err("no other scene is open: o opens one")
    }
}

fn pause_or_resume(app: &App) -> &'static str {
    if app.is_going() { "pause" } else { "resume" }
}

fn gallery(app: &App) -> &'static str {
    match app.screen {
        Screen::Run => "gallery",
        Screen::Gallery => "one run",
    }
}

fn next_panel(app: &App) -> &'static str {
    match app.screen {
        Screen::Run => "panel",
        Screen::Gallery => "next run",
    }
}

/// All keys.
pub static BINDINGS: &[Binding] = &[
    Binding {
        place: Place::Main,
        keys: &[key(' ', Action::PauseOrResume)],
        label: "space",
        plain_label: "space",
        brief: pause_or_resume,
        words: "pause or resume; in the gallery all runs",
        when: when_not_over,
    },
    Binding {
        place: Place::Main,
        keys: &[key('q', Action::Quit), control('c', Action::Quit)],
        label: "q Ctrl-C",
        plain_label: "q Ctrl-C",
        brief: |_| "quit",
        words: "quit; asks if something was computed that is saved nowhere",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('?', Action::Help), named(KeyCode::F(1), Action::Help)],
        label: "?",
        plain_label: "?",
        brief: |_| "help",
        words: "show all keys",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[
            key('1', Action::Show(0)),
            key('2', Action::Show(1)),
            key('3', Action::Show(2)),
            key('4', Action::Show(3)),
        ],
        label: "1 2 3 4",
        plain_label: "1 2 3 4",
        brief: |_| "case",
        words: "one of the paper's four cases; the run that is left waits where it is",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('a', Action::NextAnchoring)],
        label: "a",
        plain_label: "a",
        brief: |_| "anchoring",
        words: "next anchoring (homeotropic, parallel, none), for the state as it is",
        when: with_director,
    },
    Binding {
        place: Place::Main,
        keys: &[key('g', Action::Gallery)],
        label: "g",
        plain_label: "g",
        brief: gallery,
        words: "gallery: the four cases side by side with a common clock; again: back to one run",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('n', Action::Step)],
        label: "n",
        plain_label: "n",
        brief: |_| "step",
        words: "one step, then pause",
        when: when_a_step_is_left,
    },
    Binding {
        place: Place::Main,
        keys: &[
            named(KeyCode::Left, Action::Older(1)),
            named(KeyCode::Right, Action::Newer(1)),
        ],
        label: "← →",
        plain_label: "Left Right",
        brief: |_| "past",
        words: "go through the stored past; the run goes on meanwhile",
        when: with_a_past,
    },
    Binding {
        place: Place::Main,
        keys: &[
            named(KeyCode::PageUp, Action::Older(LEAP)),
            named(KeyCode::PageDown, Action::Newer(LEAP)),
        ],
        label: "PgUp PgDn",
        plain_label: "PgUp PgDn",
        brief: |_| "leap",
        words: "the same in leaps of ten",
        when: with_a_past,
    },
    Binding {
        place: Place::Main,
        keys: &[
            named(KeyCode::Home, Action::Oldest),
            named(KeyCode::End, Action::Live),
        ],
        label: "Home End",
        plain_label: "Home End",
        brief: |_| "first/live",
        words: "the start of the run; back to the present",
        when: with_a_past,
    },
    Binding {
        place: Place::Main,
        keys: &[key('s', Action::SaveView)],
        label: "s",
        plain_label: "s",
        brief: |_| "save view",
        words: "save what is looked at: PNG, SVG, and the numbers",
        when: with_picture,
    },
    Binding {
        place: Place::Main,
        keys: &[key('S', Action::SaveSet)],
        label: "S",
        plain_label: "S",
        brief: |_| "save all",
        words: "save the report's whole set of this run, up to now",
        when: with_picture,
    },
    Binding {
        place: Place::Main,
        keys: &[key('v', Action::NextField)],
        label: "v",
        plain_label: "v",
        brief: |_| "field",
        words: "next field: phase, length of the director, omega, mu, energy density",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('d', Action::Director)],
        label: "d",
        plain_label: "d",
        brief: |_| "director",
        words: "director as arrows, as strokes, or not at all",
        when: with_director,
    },
    Binding {
        place: Place::Main,
        keys: &[key('c', Action::ColourMap)],
        label: "c",
        plain_label: "c",
        brief: |_| "colours",
        words: "next colour map",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('l', Action::Logarithmic)],
        label: "l",
        plain_label: "l",
        brief: |_| "log",
        words: "logarithmic curves or linear ones",
        when: on_one_run,
    },
    Binding {
        place: Place::Main,
        keys: &[
            named(KeyCode::Tab, Action::Next),
            named(KeyCode::BackTab, Action::Previous),
        ],
        label: "Tab Shift-Tab",
        plain_label: "Tab Shift-Tab",
        brief: next_panel,
        words: "next panel or the one before, in the gallery the next run",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[key('r', Action::Restart)],
        label: "r",
        plain_label: "r",
        brief: |_| "restart",
        words: "begin the run anew; asks if it is saved nowhere",
        when: on_one_run,
    },
    Binding {
        place: Place::Main,
        keys: &[key('o', Action::Open)],
        label: "o",
        plain_label: "o",
        brief: |_| "open",
        words: "open another scene: a preset or a TOML file",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[
            key('5', Action::Show(4)),
            key('6', Action::Show(5)),
            key('7', Action::Show(6)),
            key('8', Action::Show(7)),
            key('9', Action::Show(8)),
        ],
        label: "5 ... 9",
        plain_label: "5 ... 9",
        brief: |_| "opened",
        words: "the scenes that were opened",
        when: with_opened_scenes,
    },
    Binding {
        place: Place::Main,
        keys: &[key('e', Action::Edit)],
        label: "e",
        plain_label: "e",
        brief: |_| "edit",
        words: "edit the scene in $EDITOR and load it anew",
        when: on_one_run,
    },
    Binding {
        place: Place::Main,
        keys: &[
            key('+', Action::Faster),
            key('=', Action::Faster),
            key('-', Action::Slower),
        ],
        label: "+ -",
        plain_label: "+ -",
        brief: |_| "frame rate",
        words: "more or fewer frames a second, 1 to 30",
        when: always,
    },
    Binding {
        place: Place::Main,
        keys: &[
            named(KeyCode::Enter, Action::Gallery),
            named(KeyCode::Esc, Action::Gallery),
        ],
        label: "Enter Esc",
        plain_label: "Enter Esc",
        brief: |_| "look at it",
        words: "in the gallery: look at the chosen run alone",
        when: in_gallery,
    },
    Binding {
        place: Place::Main,
        keys: &[control('z', Action::Suspend)],
        label: "Ctrl-Z",
        plain_label: "Ctrl-Z",
        brief: |_| "suspend",
        words: "stop the program; fg in the shell continues it",
        when: always,
    },
    Binding {
        place: Place::Confirm,
        keys: &[key('y', Action::Yes), key('Y', Action::Yes)],
        label: "y",
        plain_label: "y",
        brief: |_| "yes",
        words: "do it",
        when: always,
    },
    Binding {
        place: Place::Confirm,
        keys: &[
            key('n', Action::No),
            key('N', Action::No),
            named(KeyCode::Esc, Action::No),
        ],
        label: "n Esc",
        plain_label: "n Esc",
        brief: |_| "no",
        words: "leave everything as it is",
        when: always,
    },
    Binding {
        place: Place::Confirm,
        keys: &[control('c', Action::Quit)],
        label: "Ctrl-C",
        plain_label: "Ctrl-C",
        brief: |_| "quit",
        words: "quit; when that is the question: do",
        when: always,
    },
    Binding {
        place: Place::Help,
        keys: &[
            named(KeyCode::Up, Action::Scroll(-1)),
            named(KeyCode::Down, Action::Scroll(1)),
            key('k', Action::Scroll(-1)),
            key('j', Action::Scroll(1)),
            named(KeyCode::PageUp, Action::Scroll(-PAGE)),
            named(KeyCode::PageDown, Action::Scroll(PAGE)),
            key(' ', Action::Scroll(PAGE)),
            named(KeyCode::Home, Action::Scroll(i32::MIN)),
            named(KeyCode::End, Action::Scroll(i32::MAX)),
        ],
        label: "↑ ↓",
        plain_label: "Up Down",
        brief: |_| "scroll",
        words: "scroll",
        when: always,
    },
    Binding {
        place: Place::Help,
        keys: &[
            named(KeyCode::Esc, Action::Close),
            named(KeyCode::Enter, Action::Close),
            named(KeyCode::F(1), Action::Close),
            key('?', Action::Close),
            key('q', Action::Close),
        ],
        label: "Esc",
        plain_label: "Esc",
        brief: |_| "close",
        words: "close the help",
        when: always,
    },
    Binding {
        place: Place::Help,
        keys: &[control('c', Action::Quit)],
        label: "Ctrl-C",
        plain_label: "Ctrl-C",
        brief: |_| "quit",
        words: "quit",
        when: always,
    },
    Binding {
        place: Place::Message,
        keys: &[
            named(KeyCode::Esc, Action::Close),
            named(KeyCode::Enter, Action::Close),
            key(' ', Action::Close),
            key('q', Action::Close),
        ],
        label: "Esc",
        plain_label: "Esc",
        brief: |_| "close",
        words: "close the message",
        when: always,
    },
    Binding {
        place: Place::Message,
        keys: &[control('c', Action::Quit)],
        label: "Ctrl-C",
        plain_label: "Ctrl-C",
        brief: |_| "quit",
        words: "quit",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[named(KeyCode::Enter, Action::Load)],
        label: "Enter",
        plain_label: "Enter",
        brief: |_| "open",
        words: "open the scene",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[named(KeyCode::Esc, Action::Close)],
        label: "Esc",
        plain_label: "Esc",
        brief: |_| "cancel",
        words: "open nothing",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[
            named(KeyCode::Up, Action::Choose(-1)),
            named(KeyCode::Down, Action::Choose(1)),
        ],
        label: "↑ ↓",
        plain_label: "Up Down",
        brief: |_| "choose",
        words: "choose a preset",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[named(KeyCode::Tab, Action::Complete)],
        label: "Tab",
        plain_label: "Tab",
        brief: |_| "complete",
        words: "complete the preset's name",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[
            named(KeyCode::Backspace, Action::Erase),
            control('h', Action::Erase),
            control('u', Action::Clear),
            control('w', Action::Clear),
        ],
        label: "Backspace",
        plain_label: "Backspace",
        brief: |_| "erase",
        words: "erase; Ctrl-U erases all",
        when: always,
    },
    Binding {
        place: Place::Open,
        keys: &[control('c', Action::Quit)],
        label: "Ctrl-C",
        plain_label: "Ctrl-C",
        brief: |_| "quit",
        words: "quit",
        when: always,
    },
];

/// Stored pictures in a leap.
const LEAP: usize = 10;
/// Lines of a page of the help.
const PAGE: i32 = 10;

fn in_gallery(app: &App) -> Result<(), &'static str> {
    match app.screen {
        Screen::Gallery => Ok(()),
        Screen::Run => Err("only in the gallery: g opens it"),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    const PLACES: [Place; 5] = [
        Place::Main,
        Place::Help,
        Place::Confirm,
        Place::Open,
        Place::Message,
    ];

    #[test]
    fn no_key_means_two_things_in_one_place() {
        for place in PLACES {
            let mut seen = HashSet::new();
            for binding in bindings(place) {
                assert!(!binding.keys.is_empty(), "{}", binding.label);
                for (key, _) in binding.keys {
                    let code = format!("{key:?}");
                    assert!(seen.insert(code), "{key:?} twice in {place:?}");
                }
            }
            assert!(!seen.is_empty(), "{place:?}");
        }
    }

    #[test]
    fn words_and_plain_labels_show_on_any_terminal() {
        for binding in BINDINGS {
            for text in [binding.plain_label, binding.words] {
                assert!(!text.is_empty() && text.is_ascii(), "{text}");
            }
            assert!(
                !binding.words.contains('|'),
                "a column of the README's table"
            );
        }
    }

    #[test]
    fn every_place_can_be_left_with_control_c() {
        for place in PLACES {
            let leaves = bindings(place)
                .flat_map(|binding| binding.keys)
                .any(|pair| *pair == control('c', Action::Quit));
            assert!(leaves, "{place:?}");
        }
    }

    #[test]
    fn shift_is_in_the_character_but_control_is_not() {
        let big = Key::character('S');
        assert!(big.is_pressed(&KeyEvent::new(KeyCode::Char('S'), KeyModifiers::SHIFT)));
        assert!(big.is_pressed(&KeyEvent::new(KeyCode::Char('S'), KeyModifiers::NONE)));
        assert!(!big.is_pressed(&KeyEvent::new(KeyCode::Char('s'), KeyModifiers::NONE)));
        let quit = Key::control('c');
        assert!(quit.is_pressed(&KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)));
        assert!(!quit.is_pressed(&KeyEvent::new(KeyCode::Char('c'), KeyModifiers::NONE)));
        let colours = Key::character('c');
        assert!(!colours.is_pressed(&KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)));
        assert!(!colours.is_pressed(&KeyEvent::new(KeyCode::Char('c'), KeyModifiers::ALT)));
    }

    #[test]
    #[ignore = "until the README has its section on the app"]
    fn the_readme_has_this_table() {
        let readme = include_str!("../../README.md");
        assert!(
            readme.contains(&markdown()),
            "put this there:\n{}",
            markdown()
        );
    }
}
