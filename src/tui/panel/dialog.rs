//! Dialogs over the screen: questions, the name of a scene, long texts.

use std::path::{Path, PathBuf};

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;
use ratatui::text::{Line, Span};

use super::text;
use crate::record::ShortNumber;
use crate::scene::preset_description;
use crate::tui::glyphs::spelt;
use crate::tui::layout::centred;
use crate::tui::state::{App, Beyond, Keeping, Question, Run};
use crate::tui::theme::{Role, Theme};
use crate::tui::update::{expectation_wanted, offered};

/// Other kept runs of a scene that are named beside the first.
const NAMED_OTHERS: usize = 4;

/// Draws a question.
pub fn confirm(app: &App, question: Question, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let slot = app.slots.get(app.active);
    let name = slot.map_or("the run", |slot| slot.name.as_str());
    let run = slot.and_then(|slot| slot.run.as_ref());
    let place = run.map_or("at step 0".to_owned(), place);
    let saved = run.map_or(String::new(), saved_words);
    let title = question.title();
    let words = match question {
        Question::Restart => {
            format!(
                "Restart {name}? It is {place}{saved}. What is kept of it is removed; n, then S saves figures and \
                 tables first."
            )
        }
        Question::Reload => format!(
            "Restart {name} with the scene as it is in its file now? \
             It is {place}{saved}."
        ),
        Question::Quit => quit_words(app),
        Question::GoOn => kept_words(app),
        Question::GoBeyond(beyond) => beyond_words(app, beyond),
    };
    let width = 56.min(screen.width.saturating_sub(4));
    let words = text::wrap(&theme.spelt(&words), usize::from(width).saturating_sub(4));
    let area = centred(screen, width, words.len() as u16 + 4);
    let inside = text::frame(buffer, area, theme, title, theme.style(Role::Warning));
    let count = words.len() as u16;
    for (row, words) in words.into_iter().enumerate() {
        text::line(buffer, inside, row as u16, words);
    }
    let mut answers = vec![
        Span::styled(" y ", theme.pill(Role::Warning)),
        Span::raw(" yes    "),
        Span::styled(" n ", theme.pill(Role::Accent)),
    ];
    if question == Question::GoOn {
        answers.extend([
            Span::raw(" restart    "),
            Span::styled(" Esc ", theme.pill(Role::Accent)),
            Span::raw(" not now"),
        ]);
    } else {
        answers.push(Span::raw(" no"));
    }
    text::line(buffer, inside, count + 1, Line::from(answers));
}

/// Where a run is.
fn place(run: &Run) -> String {
    match &run.underway {
        None => format!("at step {}", run.report.step),
        Some(underway) => format!(
            "within step {}, t = {}",
            underway.step,
            ShortNumber(underway.t)
        ),
    }
}

/// Whether a run is kept, and up to where its figures are saved.
fn saved_words(run: &Run) -> String {
    let kept = match &run.keeping {
        Keeping::Kept(kept) => format!(", kept in {}", kept.folder.display()),
        Keeping::Pending => String::new(),
        Keeping::Failed(_) => ", not kept".to_owned(),
    };
    match run.saved {
        Some(step) => format!("{kept}; figures are saved up to step {step}"),
        None => format!("{kept}; no figures are saved"),
    }
}

/// To what end a run would continue, and with what.
fn beyond_words(app: &App, beyond: Beyond) -> String {
    let Some(slot) = app.active_slot() else {
        return String::new();
    };
    let run = slot.run.as_ref();
    let Some((run, end)) = run.and_then(|run| Some((run, run.later_end()?))) else {
        return String::new();
    };
    let (name, t, end) = (&slot.name, ShortNumber(run.report.t), ShortNumber(end));
    let first = match beyond {
        Beyond::Run => String::new(),
        Beyond::Step => ", and pause after one step".to_owned(),
        Beyond::Anchor(kind) => format!(", with the anchoring {kind}"),
    };
    format!("{name} has reached its end, t = {t}. Go on to t = {end}{first}?")
}

/// Which runs can be resumed.
pub(in crate::tui) fn kept_words(app: &App) -> String {
    let kept: Vec<String> = app
        .slots
        .iter()
        .filter_map(|slot| {
            let kept = slot.offered()?;
            Some(format!("{} {}", slot.name, kept.place()))
        })
        .collect();
    let mut words = format!(
        "Go on where you were: {}? With n the runs restart and these are put aside; with Esc they stay, to be \
         asked about the next time.",
        kept.join(", ")
    );
    let others = app.slots.iter().filter_map(|slot| {
        let kept = slot.offered()?;
        others_words(&slot.name, &kept.others)
    });
    others.for_each(|others| words = format!("{words} {others}"));
    words
}

/// Where more runs of a scene are kept: the first by its path, the others by the ends of their names.
fn others_words(name: &str, others: &[PathBuf]) -> Option<String> {
    let (first, rest) = others.split_first()?;
    let mut folders = first.display().to_string();
    for other in rest.iter().take(NAMED_OTHERS) {
        let name = other.file_name().unwrap_or_default().to_string_lossy();
        let end = name.rsplit('-').next().unwrap_or_default();
        folders += &format!(", -{end}");
    }
    if rest.len() > NAMED_OTHERS {
        folders += &format!(" and {} more", rest.len() - NAMED_OTHERS);
    }
    let (runs, are) = match others.len() {
        1 => ("another run".to_owned(), "is"),
        count => (format!("{count} more runs"), "are"),
    };
    Some(format!(
        "Of {name} {runs} {are} kept in {folders}: o opens a run by its folder."
    ))
}

/// Of which runs there are no figures, and whether their states are kept.
pub(in crate::tui) fn quit_words(app: &App) -> String {
    let named = app.slots.iter().filter_map(|slot| {
        let run = slot.run.as_ref().filter(|run| run.unsaved)?;
        Some((&slot.name, run))
    });
    let mut words = vec!["Leave vesica?".to_owned()];
    let (mut pictured, mut bare, mut pending) = (Vec::new(), Vec::new(), false);
    let mut saving = Vec::new();
    let mut lost = Vec::new();
    for (name, run) in named {
        let step = run.report.step;
        if let Some(step) = app.is_saving(run.id) {
            saving.push(format!("{name} up to step {step}"));
        }
        match run.saved {
            _ if app.is_saving(run.id) == Some(step) => {}
            Some(saved) => pictured.push(format!("{name} are saved up to step {saved} of {step}")),
            None => bare.push(format!("{name} ({})", place(run).trim_start_matches("at "))),
        }
        match &run.keeping {
            Keeping::Pending => pending = true,
            Keeping::Kept(_) => {}
            Keeping::Failed(why) => {
                lost.push(format!(
                    "The state of {name} cannot be kept, and is lost: {why}."
                ));
            }
        }
    }
    let is_asked = !pictured.is_empty() || !bare.is_empty() || !saving.is_empty();
    if !saving.is_empty() {
        words.push(format!(
            "Figures of {} are being saved: the end waits for them.",
            saving.join(", ")
        ));
    }
    if !pictured.is_empty() {
        words.push(format!("Figures of {}.", pictured.join(", of ")));
    }
    if !bare.is_empty() {
        words.push(format!("No figures are saved of {}.", bare.join(", ")));
    }
    if !lost.is_empty() {
        words.splice(1..1, lost);
    } else if pending {
        words.insert(1, "The runs are being kept ..".to_owned());
    } else if is_asked {
        let folders = app.slots.iter().filter_map(|slot| {
            let run = slot.run.as_ref().filter(|run| run.unsaved)?;
            match &run.keeping {
                Keeping::Kept(kept) => kept.folder.parent(),
                Keeping::Pending | Keeping::Failed(_) => None,
            }
        });
        let mut folders = folders.filter(|folder| !folder.as_os_str().is_empty());
        let folder = folders.next().map(Path::display);
        let place = folder.map_or(String::new(), |folder| format!(" in {folder}"));
        let kept =
            format!("The runs are kept{place}: the app offers to go on with them the next time.");
        words.insert(1, kept);
    }
    words.join(" ")
}

/// Draws the dialog in which a scene's name is typed.
pub fn open(
    app: &App,
    (typed, chosen, error): (&str, Option<usize>, Option<&str>),
    theme: &Theme,
    screen: Rect,
    buffer: &mut Buffer,
) {
    let width = 76.min(screen.width.saturating_sub(4));
    let inner = usize::from(width).saturating_sub(4);
    let errors = error.map_or_else(Vec::new, |error| text::wrap(&theme.spelt(error), inner));
    let names = offered(typed);
    let height = names.len().max(1) + errors.len() + 7;
    let area = centred(screen, width, height.min(usize::from(u16::MAX)) as u16);
    let inside = text::frame(
        buffer,
        area,
        theme,
        "Open a scene",
        theme.style(Role::Accent),
    );
    // Of a long path the end is what one types at.
    let room = inner.saturating_sub(4);
    let skipped = typed.chars().count().saturating_sub(room);
    let tail: String = typed.chars().skip(skipped).collect();
    let prompt = Line::from(vec![
        Span::styled("> ", theme.style(Role::Accent)),
        Span::raw(tail),
        Span::styled(" ", theme.strong().add_modifier(Modifier::REVERSED)),
    ]);
    text::line(buffer, inside, 0, prompt);
    let hint = "a preset, a TOML file, or a run's folder";
    text::line(buffer, inside, 1, Span::styled(hint, theme.muted()));
    let mut row = 3;
    for (index, name) in names.iter().enumerate() {
        let description = preset_description(name).unwrap_or_default();
        let mut style = theme.strong();
        if chosen == Some(index) {
            style = theme.pill(Role::Accent);
        }
        let line = Line::from(vec![
            Span::styled(format!(" {name:<12}"), style),
            Span::raw(" "),
            Span::styled(
                text::shorten(&theme.spelt(description), inner.saturating_sub(15)),
                theme.muted(),
            ),
        ]);
        text::line(buffer, inside, row, line);
        row += 1;
    }
    for error in errors {
        text::line(
            buffer,
            inside,
            row,
            Span::styled(error, theme.style(Role::Bad)),
        );
        row += 1;
    }
    // An error says why nothing can be measured.
    if error.is_none()
        && let Some(name) = expectation_wanted(app)
    {
        let words = match app.expectation.words(&name) {
            Some(Ok(words)) => format!("{name}: {words}"),
            // It names what is wrong itself.
            Some(Err(why)) => why.to_owned(),
            None => format!("{name}: what it takes is being measured"),
        };
        let last = inside.height.saturating_sub(1);
        let words = text::shorten(&words, inner);
        text::line(buffer, inside, last, Span::raw(words));
    }
}

/// Draws what effects cost: lines unchanged, because they are a table.
pub fn table(title: &str, words: &str, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let lines: Vec<&str> = words.lines().collect();
    let longest = lines.iter().map(|line| line.chars().count()).max();
    let width = (longest.unwrap_or(0).max(40) as u16 + 4).min(screen.width);
    let height = (lines.len() as u16 + 2).min(screen.height.saturating_sub(2));
    let area = centred(screen, width, height);
    let inside = text::frame(buffer, area, theme, title, theme.style(Role::Accent));
    for (row, line) in lines.into_iter().enumerate() {
        if row < usize::from(inside.height) {
            text::line(buffer, inside, row as u16, Span::raw(line.to_owned()));
        }
    }
}

/// The lines of a long text, broken where they are too long for a screen of this size, and how many rows of them it shows.
fn message_lines(words: &str, (columns, rows): (u16, u16)) -> (Vec<String>, usize) {
    let width = message_width(columns);
    let lines = text::wrap(words, usize::from(width).saturating_sub(4));
    (lines, usize::from(rows.saturating_sub(4)))
}

fn message_width(columns: u16) -> u16 {
    columns.saturating_sub(4).min(100)
}

/// How many lines of a long text a screen of this size has no room for, with its signs or spelt out.
pub(in crate::tui) fn message_overflow(words: &str, size: (u16, u16)) -> usize {
    let overflow = |words: &str| {
        let (lines, room) = message_lines(words, size);
        lines.len().saturating_sub(room)
    };
    overflow(words).max(overflow(&spelt(words)))
}

/// Draws a long text from its line `scroll` on. Its lines are broken where they are too long; below it says which are shown,
/// where those are not all.
pub fn message(
    (title, words, scroll): (&str, &str, u16),
    theme: &Theme,
    screen: Rect,
    buffer: &mut Buffer,
) {
    let (lines, room) = message_lines(&theme.spelt(words), (screen.width, screen.height));
    let height = (lines.len().min(room) as u16).saturating_add(2);
    let area = centred(screen, message_width(screen.width), height);
    let inside = text::frame(buffer, area, theme, title, theme.style(Role::Bad));
    let rows = usize::from(inside.height);
    text::scrolled(
        buffer,
        (area, inside),
        theme,
        lines.len(),
        scroll,
        |first| {
            lines
                .into_iter()
                .skip(first)
                .take(rows)
                .map(Line::from)
                .collect()
        },
    );
}
