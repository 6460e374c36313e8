//! All keys, declared once: what a key does, the footer, the help, and the guide's table are read
//! from [`BINDINGS`].

mod conditions;
mod footer;
mod table;

use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::state::{App, Overlay};

pub use conditions::other_form;
pub use footer::Footer;
pub use table::BINDINGS;

/// What a key does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Pause or resume the run, in the gallery all runs.
    PauseOrResume,
    /// One step.
    Step,
    /// Restart the run.
    Restart,
    /// Show a case or an opened scene, by the number of its key less 1.
    Show(usize),
    /// The active case quick, or as printed.
    OtherForm,
    /// Take the brake off, or put it on.
    Brake,
    /// Play the stored past, or stop that.
    Play,
    /// Switch the anchoring.
    NextAnchoring,
    /// Show the parameters that can change while the run goes.
    Knobs,
    /// Take the last change back.
    TakeBack,
    /// A smaller or a larger value.
    Turn(i32),
    /// The duration of the change.
    Duration,
    /// Make the change.
    Apply,
    /// Into the gallery of the four cases or out of it.
    Gallery,
    /// The same with the scenes that were opened.
    GalleryOfOpened,
    /// Look at the chosen run of the gallery alone.
    LookAt,
    /// This many stored pictures back.
    Older(usize),
    /// This many stored pictures on.
    Newer(usize),
    /// The oldest picture.
    Oldest,
    /// Back to the present.
    Live,
    /// Save what is shown.
    SaveView,
    /// Save the report's set.
    SaveSet,
    /// The director's next style.
    Director,
    /// The shape that theory foresees, over the field or not.
    Theory,
    /// More of the domain, or less.
    Zoom,
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
    /// Edit the scene and load it again.
    Edit,
    /// Show what other accuracies cost.
    Accuracy,
    /// Measure the error of the run, or show it.
    Measure,
    /// Show what each effect costs.
    Prices,
    /// Open another scene.
    Open,
    /// Show all that the run has to say, whole.
    Notices,
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
    /// The price list of accuracy.
    Accuracy,
    /// A long text.
    Message,
    /// The parameters that can change; figures that mean nothing else are typed.
    Knobs,
    /// Everywhere.
    Anywhere,
}

impl Place {
    /// Where the app takes its keys at present.
    pub fn of(app: &App) -> Self {
        match &app.overlay {
            None => Self::Main,
            Some(Overlay::Help { .. }) => Self::Help,
            Some(Overlay::Confirm(_)) => Self::Confirm,
            Some(Overlay::Open { .. }) => Self::Open,
            Some(Overlay::Knobs(_)) => Self::Knobs,
            Some(Overlay::Accuracy(_)) => Self::Accuracy,
            Some(Overlay::Message { .. } | Overlay::Prices { .. } | Overlay::Measured) => {
                Self::Message
            }
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
    /// What they do, for the help and the guide, in ASCII.
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

/// What the help and the guide name: all that keys do when nothing lies over the screen.
pub fn help() -> impl Iterator<Item = &'static Binding> {
    bindings(Place::Main).chain(bindings(Place::Anywhere))
}

/// The label of the first key that does something; "" where none does.
pub fn label(action: Action) -> &'static str {
    let does = |binding: &&Binding| binding.keys.iter().any(|(_, does)| *does == action);
    BINDINGS
        .iter()
        .find(does)
        .map_or("", |binding| binding.label)
}

/// What a key does where the app is at present: an action, or why it does nothing now. `None`: it
/// means nothing here.
pub fn action(app: &App, event: &KeyEvent) -> Option<Result<Action, &'static str>> {
    let here = bindings(Place::of(app));
    here.chain(bindings(Place::Anywhere)).find_map(|binding| {
        let (_, action) = binding.keys.iter().find(|(key, _)| key.is_pressed(event))?;
        Some((binding.when)(app).map(|()| *action))
    })
}

/// The guide's table of the keys, which a test compares with it.
#[cfg(test)]
pub fn markdown() -> String {
    use std::fmt::Write as _;

    let mut table = "| key | what it does |\n| --- | --- |\n".to_owned();
    for binding in help() {
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| `{}` | {} |", binding.label, binding.words);
    }
    table
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    const PLACES: [Place; 7] = [
        Place::Knobs,
        Place::Main,
        Place::Help,
        Place::Confirm,
        Place::Open,
        Place::Accuracy,
        Place::Message,
    ];

    #[test]
    fn no_key_means_two_things_in_one_place() {
        for place in PLACES {
            let mut seen = HashSet::new();
            for binding in bindings(place).chain(bindings(Place::Anywhere)) {
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
                "a column of the guide's table"
            );
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
    fn the_guide_has_this_table() {
        let guide = include_str!("../../../docs/guide/app.md");
        assert!(
            guide.contains(&markdown()),
            "put this there:\n{}",
            markdown()
        );
    }
}
