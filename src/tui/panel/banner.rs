//! What must be seen: a remark, what was saved, what is wrong.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::shown::Shown;
use super::text;
use crate::tui::keys::{self, Action};
use crate::tui::state::{App, Keeping, Notice, Saving, Severity, Status};
use crate::tui::theme::{Role, Theme};

/// What the banner says: a word for its kind, its style, and the text.
struct Words {
    kind: String,
    role: Option<Role>,
    text: String,
    /// Whether it must be readable in full here; else it may be cut, and a key shows all of it.
    whole: bool,
}

/// Rows of a text that must be readable in full, at most.
const ROWS: usize = 4;

/// The rows of the screen to one row of a text that may be cut.
const SHARE: usize = 20;

/// The rows that the banner needs in a given width: one at least, so that the screen does not jump
/// when there is something to say, and more for a text that must be read whole.
pub fn rows(app: &App, shown: Option<&Shown<'_>>, theme: &Theme, width: u16) -> u16 {
    words(app, shown).map_or(1, |words| {
        lines(app, &words, theme, width).len().max(1) as u16
    })
}

/// Draws the banner.
pub fn draw(app: &App, shown: Option<&Shown<'_>>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let Some(words) = words(app, shown) else {
        return;
    };
    let indent = words.kind.len() + 4;
    for (row, text) in lines(app, &words, theme, area.width)
        .into_iter()
        .enumerate()
    {
        let mut spans = vec![Span::raw(" ")];
        match (row, words.role) {
            (0, Some(role)) => {
                spans.push(Span::styled(format!(" {} ", words.kind), theme.pill(role)));
                spans.push(Span::raw(" "));
            }
            (0, None) => {
                spans.push(Span::styled(format!(" {} ", words.kind), theme.muted()));
                spans.push(Span::raw(" "));
            }
            _ => spans.push(Span::raw(" ".repeat(indent - 1))),
        }
        spans.push(Span::raw(text));
        text::line(buffer, area, row as u16, Line::from(spans));
    }
}

fn lines(app: &App, words: &Words, theme: &Theme, width: u16) -> Vec<String> {
    let width = usize::from(width).saturating_sub(words.kind.len() + 5);
    let mut lines = text::wrap(&theme.spelt(&words.text), width);
    let (room, more) = if words.whole {
        (ROWS, String::new())
    } else {
        (
            (usize::from(app.size.1) / SHARE).clamp(1, ROWS),
            format!(" ({}: all of it)", keys::label(Action::Notices)),
        )
    };
    if lines.len() > room {
        lines.truncate(room);
        if let Some(last) = lines.last_mut() {
            *last = cut_between_words(last, width.saturating_sub(more.len())) + &more;
        }
    }
    lines
}

/// The first words of a text that is longer than `width` columns, with two dots after them.
fn cut_between_words(text: &str, width: usize) -> String {
    const MORE: &str = " ..";
    let ends = text.match_indices(' ').map(|(end, _)| end);
    let mut words = ends.chain([text.len()]).map(|end| &text[..end]);
    let fits = |words: &&str| words.chars().count() + MORE.len() <= width;
    match words.rfind(fits) {
        Some(words) => format!("{words}{MORE}"),
        None => text::shorten(&format!("{text}{MORE}"), width),
    }
}

/// What is said first: what is wrong, then what the last key did, then what was saved, then what is
/// worth knowing.
fn words(app: &App, shown: Option<&Shown<'_>>) -> Option<Words> {
    let run = shown.and_then(|shown| shown.run);
    let worst = run.and_then(|run| {
        // What the solver did is only in the list.
        let notices = || (run.notices.iter()).filter(|notice| notice.severity > Severity::Log);
        let severest = notices().map(|notice| notice.severity).max()?;
        let with = |notice: &&Notice| notice.severity == severest;
        let count = notices().count();
        run.notices.iter().rfind(with).map(|notice| (notice, count))
    });
    let failed = match run.map(|run| &run.status) {
        Some(Status::Failed(why)) => Some(why.as_str()),
        _ => None,
    };
    let is_error = |(notice, _): &(&Notice, usize)| notice.severity == Severity::Error;
    let error = worst.filter(is_error);
    if let (Some(why), None) = (failed, error) {
        return Some(Words {
            kind: "failed".to_owned(),
            role: Some(Role::Bad),
            text: why.to_owned(),
            whole: true,
        });
    }
    if let Some(remark) = &app.remark {
        return Some(Words {
            kind: "note".to_owned(),
            role: None,
            text: remark.clone(),
            whole: true,
        });
    }
    if let Some((notice, count)) = error {
        return Some(said(notice, count));
    }
    if let Some(Keeping::Failed(why)) = run.map(|run| &run.keeping) {
        return Some(Words {
            kind: "not kept".to_owned(),
            role: Some(Role::Bad),
            text: why.clone(),
            whole: true,
        });
    }
    let underway = run.and_then(|run| run.underway);
    if let (Some(underway), false) = (underway, matches!(app.saving, Saving::Busy(_))) {
        return Some(Words {
            kind: "hard step".to_owned(),
            role: Some(Role::Warning),
            text: underway.to_string(),
            whole: true,
        });
    }
    let (kind, role, text) = match &app.saving {
        Saving::Busy(what) => ("saving", Some(Role::Accent), what.clone()),
        Saving::Saved(path) => ("saved", Some(Role::Good), path.display().to_string()),
        Saving::Failed(why) => ("not saved", Some(Role::Bad), why.clone()),
        Saving::Idle => return worst.map(|(notice, count)| said(notice, count)),
    };
    Some(Words {
        kind: kind.to_owned(),
        role,
        text,
        whole: true,
    })
}

/// A notice with its step, and how many there are besides.
fn said(notice: &Notice, count: usize) -> Words {
    let (kind, role) = match notice.severity {
        Severity::Log | Severity::Note => ("note", None),
        Severity::Warning => ("warning", Some(Role::Warning)),
        Severity::Error => ("error", Some(Role::Bad)),
    };
    let more = match count {
        0 | 1 => String::new(),
        count => format!(
            " (and {} more: {})",
            count - 1,
            keys::label(Action::Notices)
        ),
    };
    Words {
        kind: kind.to_owned(),
        role,
        text: format!("{notice}{more}"),
        whole: notice.severity == Severity::Error,
    }
}
