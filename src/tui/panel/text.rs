//! Lines of text within an area: what does not fit is cut, but never a number, which would be another
//! one; nothing is drawn outside.

use std::borrow::Cow;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Widget};
use textwrap::{Options, WordSeparator, WordSplitter};

use crate::tui::theme::{Role, Theme};

/// Draws a line in a row of an area, counted from its top; outside of the area nothing.
pub fn line<'a>(buffer: &mut Buffer, area: Rect, row: u16, spans: impl Into<Line<'a>>) {
    if row < area.height {
        let row = Rect {
            y: area.y + row,
            height: 1,
            ..area
        };
        let row = row.intersection(buffer.area);
        let line = spans.into();
        let cut = cut_number(&line, usize::from(row.width));
        line.render(row, buffer);
        for x in row.x + cut as u16..row.right() {
            buffer[(x, row.y)].set_symbol(" ");
        }
    }
}

/// Where a line must end so that no number is cut: at `width`, or before the word that extends beyond
/// it, if a digit of it can be seen.
fn cut_number(line: &Line<'_>, width: usize) -> usize {
    let spans = line.spans.iter();
    let cells: Vec<char> = spans.flat_map(|span| span.content.chars()).collect();
    if cells.get(width).is_none_or(|next| next.is_whitespace()) {
        return width;
    }
    let seen = &cells[..width];
    let before = seen.iter().rposition(|cell| cell.is_whitespace());
    let begin = before.map_or(0, |space| space + 1);
    if seen[begin..].iter().any(char::is_ascii_digit) {
        begin
    } else {
        width
    }
}

/// Draws a line that ends at the right end of a row of an area.
pub fn line_right<'a>(buffer: &mut Buffer, area: Rect, row: u16, spans: impl Into<Line<'a>>) {
    let spans = spans.into();
    let width = (spans.width() as u16).min(area.width);
    let area = Rect {
        x: area.x + area.width - width,
        width,
        ..area
    };
    line(buffer, area, row, spans);
}

/// Draws a panel's title into the first row of an area, in a rule over its whole width, with notes
/// at the right end; gives back what is left below.
pub fn title(
    buffer: &mut Buffer,
    area: Rect,
    theme: &Theme,
    focused: bool,
    title: Line<'_>,
    notes: Line<'_>,
) -> Rect {
    let glyphs = theme.glyphs();
    let (rule, mark) = if focused {
        (theme.style(Role::Accent), glyphs.focus)
    } else {
        (theme.muted(), glyphs.rule)
    };
    line(
        buffer,
        area,
        0,
        Span::styled(glyphs.rule.repeat(usize::from(area.width)), rule),
    );
    let mut words = vec![Span::styled(format!("{mark} "), rule)];
    words.extend(styled(title));
    words.push(Span::raw(" "));
    let words = Line::from(words);
    let room = usize::from(area.width).saturating_sub(words.width());
    line(buffer, area, 0, words);
    if notes.width() > 0 && notes.width() + 4 <= room {
        let mut spans = vec![Span::raw(" ")];
        spans.extend(styled(notes));
        spans.push(Span::styled(format!(" {}", glyphs.rule), rule));
        line_right(buffer, area, 0, spans);
    }
    Rect {
        y: area.y + area.height.min(1),
        height: area.height.saturating_sub(1),
        ..area
    }
}

/// The parts of a line, each with the line's own style below its own.
fn styled(line: Line<'_>) -> impl Iterator<Item = Span<'_>> {
    // Not in the colour of the rule that lies below.
    let style = Style::default().fg(Color::Reset).patch(line.style);
    line.spans.into_iter().map(move |span| {
        let own = span.style;
        span.style(style.patch(own))
    })
}

/// Draws the lines of a list that a frame has room for, from the line `scroll` on but never beyond the last, and where these
/// are not all says below which they are. `lines` gives those from a line on.
pub fn scrolled<'a>(
    buffer: &mut Buffer,
    (area, inside): (Rect, Rect),
    theme: &Theme,
    count: usize,
    scroll: u16,
    lines: impl FnOnce(usize) -> Vec<Line<'a>>,
) {
    let room = usize::from(inside.height);
    // The last line is never scrolled further up than to the end of the frame.
    let last = count.saturating_sub(room);
    let first = usize::from(scroll).min(last);
    for (row, words) in lines(first).into_iter().take(room).enumerate() {
        line(buffer, inside, row as u16, words);
    }
    if last > 0 {
        let shown = (first + room).min(count);
        let words = format!(" {}-{shown} of {count} ", first + 1);
        let below = Rect {
            y: area.bottom().saturating_sub(1),
            height: 1,
            width: area.width.saturating_sub(2),
            ..area
        };
        line_right(buffer, below, 0, Span::styled(words, theme.muted()));
    }
}

/// Clears an area, draws a frame around it with a title, and gives back the inside, which has a
/// free column at either side.
pub fn frame(buffer: &mut Buffer, area: Rect, theme: &Theme, title: &str, style: Style) -> Rect {
    let area = area.intersection(buffer.area);
    Clear.render(area, buffer);
    let block = Block::bordered()
        .border_set(theme.glyphs().border)
        .border_style(style)
        .title(Line::styled(format!(" {title} "), theme.strong()));
    let inside = block.inner(area);
    block.render(area, buffer);
    Rect {
        x: inside.x + inside.width.min(1),
        width: inside.width.saturating_sub(2),
        ..inside
    }
}

/// A bar that is filled to a share of its width.
pub fn bar(share: f64, width: u16, theme: &Theme) -> String {
    let glyphs = theme.glyphs();
    let parts = glyphs.shares.len() - 1;
    let share = if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let filled = (share * f64::from(width) * parts as f64).round() as usize;
    let full = glyphs.shares[parts];
    let mut bar = full.repeat(filled / parts);
    bar.push_str(glyphs.shares[filled % parts].trim_end());
    bar
}

/// Breaks a text into lines of at most `width` characters, at spaces where there are any; the lines
/// that the text has stay, with what they are indented by.
pub fn wrap(text: &str, width: usize) -> Vec<String> {
    let options = Options::new(width.max(1))
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation);
    let lines = text.lines().flat_map(|line| textwrap::wrap(line, &options));
    lines.map(Cow::into_owned).collect()
}

/// The first cells of a text as a number of bytes, at least one character.
fn cut(text: &str, width: usize) -> usize {
    let mut cells = 0;
    for (index, character) in text.char_indices() {
        cells += Span::raw(character.encode_utf8(&mut [0; 4]) as &str).width();
        if cells > width && index > 0 {
            return index;
        }
    }
    text.len()
}

/// A text in `width` cells, its end cut and marked where it is too long.
pub fn shorten(text: &str, width: usize) -> String {
    let end = cut(text, width);
    if end == text.len() {
        return text.to_owned();
    }
    let end = cut(text, width.saturating_sub(2).max(1));
    format!("{}..", &text[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_broken_at_spaces_and_words_that_are_too_long_anywhere() {
        assert_eq!(wrap("one two three", 8), ["one two", "three"]);
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("abcdefgh", 3), ["abc", "def", "gh"]);
        assert_eq!(wrap("  a b\n\nc", 4), ["  a", "b", "", "c"]);
        assert_eq!(wrap("", 4), Vec::<String>::new());
        assert_eq!(wrap("漢字漢字", 4), ["漢字", "漢字"]);
        assert_eq!(wrap("漢", 1), ["漢"]);
        assert_eq!(wrap("ab", 0), ["a", "b"]);
    }

    #[test]
    fn what_is_too_long_says_so() {
        assert_eq!(shorten("abcdef", 6), "abcdef");
        assert_eq!(shorten("abcdefg", 6), "abcd..");
        assert_eq!(shorten("", 0), "");
    }

    #[test]
    fn a_number_is_whole_or_not_there() {
        let draw = |text: &str| {
            let mut buffer = Buffer::empty(Rect::new(0, 0, 9, 1));
            line(&mut buffer, Rect::new(0, 0, 8, 1), 0, text);
            buffer
        };
        let shown = |text| Buffer::with_lines([format!("{text:<9}")]);
        assert_eq!(draw("waist 0.75"), shown("waist"));
        assert_eq!(draw("waist 07"), shown("waist 07"));
        assert_eq!(draw("waist 07 x"), shown("waist 07"));
        assert_eq!(draw("0.123456789"), shown(""));
        assert_eq!(draw("a longer one"), shown("a longer"));
        assert_eq!(draw("an alphabet"), shown("an alpha"));
    }

    #[test]
    fn nothing_is_drawn_outside() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 6, 2));
        line(&mut buffer, Rect::new(2, 0, 3, 1), 0, "abcdef");
        line(&mut buffer, Rect::new(2, 0, 3, 1), 1, "abcdef");
        line_right(&mut buffer, Rect::new(0, 1, 5, 1), 0, "xy");
        line(&mut buffer, Rect::new(9, 9, 3, 1), 0, "abcdef");
        assert_eq!(buffer, Buffer::with_lines(["  abc ", "   xy "]));
    }
}
