//! Where a picture comes from: what stands in its file beside the pixels.

use super::data::RunLabel;
use crate::record::Number;
use crate::scene::Scene;

/// Keywords with texts: in the text chunks of a PNG, in the metadata of an SVG.
///
/// | keyword | text |
/// |---|---|
/// | `Title` | what the picture shows |
/// | `Software` | vesica and its version |
/// | `Command` | the command that makes it again |
/// | `Scene` | the complete scene as TOML; of several, `Scene 1`, `Scene 2`, … |
/// | `Step` | the steps that are shown, with spaces between |
/// | `Time` | their times |
/// | `Plan` | of a sweep, its plan as TOML; `Scene` is then the scene that it varies |
///
/// There is no date: the same picture is the same file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Provenance {
    title: String,
    entries: Vec<(String, String)>,
}

/// A run's part in a picture.
pub(super) struct Shown<'a> {
    pub label: &'a RunLabel,
    pub scene: &'a Scene,
    /// Step and t of each state that is shown.
    pub times: Vec<(u64, f64)>,
}

impl Provenance {
    pub fn new(what: &str, command: &str, shown: &[Shown]) -> Provenance {
        let titles: Vec<&str> = shown.iter().map(|run| run.label.title.as_str()).collect();
        let title = format!("{what}: {}", titles.join("; "));
        let mut entries = Vec::new();
        let mut entry = |keyword: &str, text: String| {
            // A chunk of a PNG ends at this character.
            entries.push((keyword.to_owned(), text.replace('\0', "\u{fffd}")));
        };
        entry("Title", title.clone());
        entry("Software", format!("vesica {}", env!("CARGO_PKG_VERSION")));
        entry("Command", command.to_owned());
        for (index, run) in shown.iter().enumerate() {
            let key = |name: &str| match shown.len() {
                1 => name.to_owned(),
                _ => format!("{name} {}", index + 1),
            };
            entry(&key("Scene"), run.scene.to_toml());
            let steps: Vec<String> = run.times.iter().map(|(n, _)| n.to_string()).collect();
            entry(&key("Step"), steps.join(" "));
            let times: Vec<String> = run
                .times
                .iter()
                .map(|(_, t)| Number(*t).to_string())
                .collect();
            entry(&key("Time"), times.join(" "));
        }
        Provenance { title, entries }
    }

    /// Of a picture that shows no state.
    pub fn plain(title: &str, command: &str) -> Provenance {
        let mut provenance = Provenance::new(title, command, &[]);
        title.clone_into(&mut provenance.title);
        if let Some((_, text)) = provenance.entries.first_mut() {
            title.clone_into(text);
        }
        provenance
    }

    /// With another keyword.
    pub fn with(mut self, keyword: &str, text: &str) -> Provenance {
        let text = text.replace('\0', "\u{fffd}");
        self.entries.push((keyword.to_owned(), text));
        self
    }

    /// What the picture shows.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Keywords with texts.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries
            .iter()
            .map(|(keyword, text)| (keyword.as_str(), text.as_str()))
    }
}
