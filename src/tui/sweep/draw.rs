//! The map of a sweep on the screen.

use super::help;
use super::labels::{self, label, labels};
use super::state::{SAMPLES, SweepMap};
use crate::record::ShortNumber;
use crate::study::sweep::{PointState, SweepFolder, plain};
use crate::tui::glyphs::Parts;
use crate::tui::numbers::significant;
use crate::tui::panel::wrap;
use crate::tui::theme::{Role, Theme};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Widget};

/// The colours of the vesicles: viridis, among the app's maps.
const MAP: usize = 1;
const LEVELS: usize = crate::tui::colour_map::LEVELS;

/// A small picture with its frame is at least so wide and so high, in cells of the terminal,
const LEAST: [u16; 2] = [7, 4];
/// and at most so wide.
const WIDEST: u16 = 26;
/// The list of values beside the map.
const LIST: u16 = 36;

/// Draws everything.
pub(super) fn draw(
    map: &SweepMap,
    folder: &SweepFolder,
    theme: &Theme,
    screen: Rect,
    buffer: &mut Buffer,
) {
    if screen.width < 30 || screen.height < 10 {
        put(buffer, screen, 0, Line::raw("too small"));
        return;
    }
    put(buffer, screen, 0, header(map, folder, theme));
    put(buffer, screen, screen.height - 1, footer(map, theme));
    let has_list = screen.width >= 80;
    let below = if has_list { 0 } else { 1 };
    let mut area = Rect {
        y: screen.y + 2,
        height: screen.height - 3 - below,
        ..screen
    };
    put(buffer, screen, 1, titles(map, theme));
    if has_list {
        area.width -= LIST;
        let list = Rect {
            x: area.right(),
            width: LIST,
            ..area
        };
        values(map, theme, list, buffer);
    } else if let Some(line) = short_values(map) {
        put(buffer, screen, screen.height - 2, line);
    }
    grid(map, theme, area, buffer);
    if let Some(scroll) = map.help {
        help::draw(scroll, theme, screen, buffer);
    }
}

/// What the colours are, and which panel it is.
fn titles<'a>(map: &SweepMap, theme: &Theme) -> Line<'a> {
    let mut spans = vec![Span::raw(" ")];
    if let Some(ends) = map.arranged.extent.filter(|_| theme.paints()) {
        let [low, high] = labels::both(ends);
        let end = |share| Span::styled(theme.word("■", "#"), colour(theme, Some(share)));
        spans.extend([
            Span::styled(format!("colour: {} ", map.column), theme.muted()),
            end(0.0),
            Span::raw(format!(" {low} {} {high} ", theme.word("…", "..."))),
            end(1.0),
            Span::raw("   "),
        ]);
    }
    let panel = &map.arranged.panels[map.panel];
    if !panel.title.is_empty() {
        let words = format!("{} of {}  ", map.panel + 1, map.arranged.panels.len());
        spans.extend([
            Span::styled(words, theme.muted()),
            Span::raw(panel.title.clone()),
        ]);
    }
    Line::from(spans)
}

/// The colour of a share of the column's range; of a point without a number that in the middle.
fn colour(theme: &Theme, share: Option<f64>) -> Color {
    // The dark end of the colours is hard to see.
    let level = share.map_or(LEVELS / 2, |share| {
        3 + (share * (LEVELS - 4) as f64) as usize
    });
    theme.level(theme.map(MAP), level)
}

fn put(buffer: &mut Buffer, area: Rect, row: u16, line: Line<'_>) {
    if row < area.height {
        buffer.set_line(area.x, area.y + row, &line, area.width);
    }
}

fn header<'a>(map: &SweepMap, folder: &SweepFolder, theme: &Theme) -> Line<'a> {
    let mut spans = vec![
        Span::styled(" vesica ", theme.style(Role::Accent)),
        Span::styled(folder.title().to_owned(), theme.strong()),
        Span::styled("  ", theme.muted()),
    ];
    let count = |word: &str| {
        let rows = map.table.rows.iter();
        rows.filter(|row| row.state.word() == word).count()
    };
    let words = [
        ("done", Role::Good),
        ("running", Role::Accent),
        ("saved", Role::Warning),
        ("failed", Role::Bad),
        ("damaged", Role::Bad),
        ("waiting", Role::Warning),
    ];
    for (word, role) in words {
        let count = count(word);
        if count > 0 {
            spans.push(Span::styled(format!("{count} {word}  "), theme.style(role)));
        }
    }
    Line::from(spans)
}

fn footer<'a>(map: &'a SweepMap, theme: &Theme) -> Line<'a> {
    if let Some(remark) = &map.remark {
        return Line::styled(format!(" {remark}"), theme.style(Role::Warning));
    }
    let arrows = theme.word("← → ↑ ↓", "arrows");
    let mut keys = vec![(arrows, "point"), ("Enter", "open its run")];
    if map.arranged.panels.len() > 1 {
        keys.push(("Tab", "next panel"));
    }
    keys.extend([("?", "all keys"), ("q", "quit")]);
    let mut spans = vec![Span::raw(" ")];
    for (key, words) in keys {
        spans.push(Span::styled(key, theme.strong()));
        spans.push(Span::styled(format!(" {words}   "), theme.muted()));
    }
    Line::from(spans)
}

/// The places of an axis that are shown: those around the cursor, if there is no room for all.
fn window(count: usize, room: usize, cursor: usize) -> std::ops::Range<usize> {
    let shown = count.min(room.max(1));
    let first = cursor.saturating_sub(shown / 2).min(count - shown);
    first..first + shown
}

/// The small vesicles at their places, and the values of both axes.
fn grid(map: &SweepMap, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let arranged = &map.arranged;
    let y_labels = arranged
        .y
        .as_ref()
        .map_or_else(Vec::new, |y| labels(&y.values));
    let x_labels = labels(&arranged.x.values);
    let widest = |labels: &[String]| {
        let widths = labels.iter().map(|label| label.chars().count());
        widths.max().unwrap_or(0) as u16
    };
    let left = widest(&y_labels).min(area.width / 2) + 2;
    let names = 2;
    if area.width < left + LEAST[0] || area.height < names + LEAST[1] + 1 {
        return;
    }
    let (room_x, room_y) = (area.width - left, area.height - names - 1);
    let [x, y] = map.cursor;
    // A column is as wide as its value.
    let least = LEAST[0].max(widest(&x_labels) + 1).min(room_x);
    let columns = window(arranged.x.values.len(), usize::from(room_x / least), x);
    let rows = window(arranged.rows(), usize::from(room_y / LEAST[1]), y);
    let width = (room_x / columns.len() as u16).clamp(least, WIDEST.max(least));
    // A cell of the terminal is twice as high as wide; the vesicles have a shape of their own.
    let [[x0, x1], [y0, y1]] = map.region;
    let aspect = (y1 - y0 + 1) as f64 / (x1 - x0 + 1) as f64;
    let wanted = (0.5 * aspect * f64::from(width - 2)).round() as u16 + 1;
    let height = (room_y / rows.len() as u16).min(wanted).max(LEAST[1]);
    let name = arranged.y.as_ref().map_or("", |y| &*y.key);
    put(
        buffer,
        area,
        0,
        Line::styled(format!(" {name}"), theme.muted()),
    );
    let panel = &arranged.panels[map.panel];
    for (down, row) in rows.clone().rev().enumerate() {
        let top = area.y + 1 + down as u16 * height;
        if let Some(value) = y_labels.get(row) {
            let text = format!("{value:>width$}", width = usize::from(left) - 1);
            let line = Line::styled(text, theme.muted());
            buffer.set_line(area.x, top + height / 2, &line, left);
        }
        for (across, column) in columns.clone().enumerate() {
            let place = Rect {
                x: area.x + left + across as u16 * width,
                y: top,
                width,
                height,
            };
            let cell = arranged.cell(panel, column, row);
            // A line on either side costs no height, and the vesicles are higher than wide. The last row is the gap.
            let inner = Rect {
                x: place.x + 1,
                y: place.y,
                width: width - 2,
                height: height - 1,
            };
            if map.cursor == [column, row] {
                let sides = Rect {
                    height: inner.height,
                    ..place
                };
                let block = Block::new().borders(Borders::LEFT | Borders::RIGHT);
                block
                    .border_set(theme.glyphs().border)
                    .border_style(theme.style(Role::Accent))
                    .render(sides, buffer);
            }
            vesicle(map, cell.row, cell.value, theme, inner, buffer);
        }
    }
    let bottom = 1 + rows.len() as u16 * height;
    for (across, column) in columns.clone().enumerate() {
        let text = &x_labels[column];
        let indent = width.saturating_sub(text.chars().count() as u16) / 2;
        let x = area.x + left + across as u16 * width + indent;
        if bottom < area.height {
            let line = Line::styled(text, theme.muted());
            buffer.set_line(x, area.y + bottom, &line, width);
        }
    }
    let end = left + columns.len() as u16 * width;
    let key = format!("{} ", arranged.x.key);
    let indent = end.saturating_sub(key.chars().count() as u16);
    if bottom + 1 < area.height {
        let line = Line::styled(key, theme.muted());
        buffer.set_line(
            area.x + indent,
            area.y + bottom + 1,
            &line,
            area.width - indent,
        );
    }
}

/// A vesicle in a rectangle, coloured by its value; in place of one that is not there how the point stands.
fn vesicle(
    map: &SweepMap,
    row: Option<usize>,
    value: Option<f64>,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let Some(row) = row else { return };
    let Some(picture) = map.thumbnails.get(&row) else {
        let state = &map.table.rows[row].state;
        let word: String = state.word().chars().take(usize::from(area.width)).collect();
        let line = Line::styled(word, theme.muted());
        buffer.set_line(area.x, area.y + area.height / 2, &line, area.width);
        return;
    };
    let share = value.zip(map.arranged.extent).map(|(value, [low, high])| {
        let span = (high - low).max(f64::MIN_POSITIVE);
        ((value - low) / span).clamp(0.0, 1.0)
    });
    let colour = colour(theme, share);
    let [[x0, x1], [y0, y1]] = map.region;
    // As large as fits, with the same scale in x and y.
    let (columns, rows) = (f64::from(area.width), f64::from(area.height) * 2.0);
    let samples = ((x1 - x0 + 1) as f64 / columns).max((y1 - y0 + 1) as f64 / rows);
    let center = [0.5 * (x0 + x1) as f64, 0.5 * (y0 + y1) as f64];
    // Whether the greater part of a quarter of a cell is inside.
    let is_inside = |column: f64, row: f64| {
        let part = |center: f64, of: f64, at: f64, size: f64| {
            let first = center + 0.5 + (at - 0.5 * of) * samples;
            // The casts saturate.
            let end = (first + size * samples).round().max(0.0) as usize;
            let first = first.round().max(0.0) as usize;
            first.min(SAMPLES)..end.clamp(first + 1, SAMPLES.max(first + 1)).min(SAMPLES)
        };
        let xs = part(center[0], columns, column, 0.5);
        let ys = part(center[1], rows, row, 1.0);
        let all = xs.len() * ys.len();
        let inside = ys.flat_map(|y| xs.clone().map(move |x| y * SAMPLES + x));
        2 * inside.filter(|sample| picture[*sample]).count() > all
    };
    let has_blocks = theme.glyphs().upper_half.is_some();
    for row in 0..area.height {
        for column in 0..area.width {
            let quarters = [(0.0, 0.0), (0.5, 0.0), (0.0, 1.0), (0.5, 1.0)].map(|(right, down)| {
                is_inside(f64::from(column) + right, 2.0 * f64::from(row) + down)
            });
            let shape = (0..4)
                .filter(|it| quarters[*it])
                .map(|it| 1 << it)
                .sum::<u8>();
            let Some(cell) = buffer.cell_mut((area.x + column, area.y + row)) else {
                continue;
            };
            match (has_blocks, shape.count_ones()) {
                (_, 0) | (false, 1) => continue,
                (true, _) => cell.set_char(Parts::Quadrants.glyph(shape)),
                (false, _) => cell.set_symbol(theme.glyphs().contour),
            };
            if theme.paints() {
                cell.set_fg(colour);
            }
        }
    }
}

/// The values of the point under the cursor, beside the map.
fn values(map: &SweepMap, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let Some(row) = map.selected().map(|row| &map.table.rows[row]) else {
        return;
    };
    let room = usize::from(area.width).saturating_sub(2);
    // What is too long for a line goes on in the next ones.
    let wrapped = |words: &str, style: Style| -> Vec<Line<'_>> {
        let lines = wrap(words, room).into_iter();
        lines
            .map(|line| Line::styled(format!(" {line}"), style))
            .collect()
    };
    let entry = |name: &str, value: &str| -> Vec<Line<'_>> {
        let name = Span::styled(format!(" {name} "), theme.muted());
        let mut lines = vec![Line::from(name)];
        match lines[0].width() + value.chars().count() <= room + 1 {
            true => lines[0].push_span(Span::raw(value.to_owned())),
            false => lines.extend(wrapped(value, Style::default())),
        }
        lines
    };
    let mut lines = vec![Line::styled(format!(" {}", row.name), theme.strong())];
    let (words, role) = match &row.state {
        PointState::Running(holder) => (format!("running: {holder}"), Role::Accent),
        PointState::Failed(reason) => (format!("failed: {reason}"), Role::Bad),
        PointState::Damaged(damage) => (format!("damaged: {damage}"), Role::Bad),
        PointState::Done => ("done".to_owned(), Role::Good),
        state => (state.word().to_owned(), Role::Warning),
    };
    lines.extend(wrapped(&words, theme.style(role)));
    lines.push(Line::default());
    for (key, value) in map.table.keys.iter().zip(&row.values) {
        lines.extend(entry(key, &plain(value)));
    }
    lines.push(Line::default());
    for (name, number) in map.table.columns.iter().zip(&row.numbers) {
        if let Some(number) = number {
            let strong = theme.strong().add_modifier(Modifier::BOLD);
            let own = entry(name, &ShortNumber(*number).to_string()).into_iter();
            lines.extend(own.map(|line| match *name == map.column {
                true => line.style(strong),
                false => line,
            }));
        }
    }
    paged(lines, map.page, theme, area, buffer);
}

/// A page of lines: one after the other, and after the last the first again. Where not all have room it says so below.
fn paged(lines: Vec<Line<'_>>, page: usize, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let (count, height) = (lines.len(), usize::from(area.height));
    let room = match count <= height {
        true => height,
        false => height.saturating_sub(1).max(1),
    };
    let page = page % count.div_ceil(room).max(1);
    // The last page is as full as the others.
    let first = (page * room).min(count.saturating_sub(room));
    for (number, line) in lines.into_iter().skip(first).take(room).enumerate() {
        put(buffer, area, number as u16, line);
    }
    if count > height {
        let words = format!(" {}-{} of {count}: space turns on", first + 1, first + room);
        put(
            buffer,
            area,
            area.height - 1,
            Line::styled(words, theme.muted()),
        );
    }
}

/// The same in one line.
fn short_values<'a>(map: &SweepMap) -> Option<Line<'a>> {
    let row = &map.table.rows[map.selected()?];
    let keys = map.table.keys.iter().zip(&row.values);
    let mut words: Vec<String> = keys
        .map(|(key, value)| format!("{key} {}", label(value)))
        .collect();
    let number = map.table.column(&map.column).and_then(|it| row.numbers[it]);
    words.extend(number.map(|it| format!("{} {}", map.column, significant(it, 3))));
    Some(Line::raw(format!(
        " {}: {}, {}",
        row.name,
        row.state.word(),
        words.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::super::state::Wish;
    use super::*;
    use crate::tui::theme::ColorTier;
    use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
    use std::fs;

    fn sweep(plan: &str) -> (tempfile::TempDir, SweepFolder) {
        let here = tempfile::tempdir().expect("a folder");
        let path = here.path().join("plan.toml");
        fs::write(&path, format!("scene = \"case3-quick\"\n{plan}")).expect("written");
        let sweep = crate::study::sweep::Sweep::read(&path).expect("a plan");
        let needs = sweep.needs.clone();
        let folder = SweepFolder::create(&here.path().join("out"), &sweep, needs).expect("written");
        (here, folder)
    }

    fn screen(map: &SweepMap, folder: &SweepFolder, size: (u16, u16), unicode: bool) -> String {
        screen_of(map, folder, size, &Theme::new(ColorTier::None, unicode))
    }

    fn screen_of(map: &SweepMap, folder: &SweepFolder, size: (u16, u16), theme: &Theme) -> String {
        let area = Rect::new(0, 0, size.0, size.1);
        let mut buffer = Buffer::empty(area);
        draw(map, folder, theme, area, &mut buffer);
        let row = |y: u16| {
            (0..size.0)
                .map(|x| buffer[(x, y)].symbol())
                .collect::<String>()
                + "\n"
        };
        (0..size.1).map(row).collect()
    }

    /// A disc of a radius in samples.
    fn disc(radius: f64) -> Vec<bool> {
        let middle = 0.5 * (SAMPLES - 1) as f64;
        let sample = |at: usize| {
            let [x, y] = [at % SAMPLES, at / SAMPLES].map(|it| it as f64 - middle);
            x.hypot(y) < radius
        };
        (0..SAMPLES * SAMPLES).map(sample).collect()
    }

    #[test]
    fn the_map_shows_every_point_and_keys_move_through_it() {
        let (_here, folder) = sweep(
            "[vary]\n\"area.target\" = [0.9, 1.0, 1.1]\n\"anchoring.weight\" = [1, 10]\n\
             \"anchoring.kind\" = [\"parallel\", \"homeotropic\"]\n",
        );
        let mut map = SweepMap::new(&folder).expect("it has axes");
        let text = screen(&map, &folder, (120, 40), true);
        assert_eq!(text.matches("waiting").count(), 8, "{text}");
        assert!(text.contains("1 of 2  anchoring.kind = parallel"), "{text}");
        map.show([(0, disc(40.0)), (2, disc(20.0))]);
        let text = screen(&map, &folder, (120, 40), true);
        assert_eq!(text.matches("waiting").count(), 6, "{text}");
        // A disc is as wide as high: a cell is twice as high, and has two halves.
        let inked = |line: &&str| line.contains('│') && line.contains('█');
        let rows = text.lines().filter(inked).count();
        let widest = text
            .lines()
            .map(|line| line.matches('█').count())
            .max()
            .unwrap_or(0);
        assert!(
            (1.4..2.8).contains(&(widest as f64 / rows as f64)),
            "{widest} × {rows}\n{text}"
        );

        let mut key = |code| map.key(KeyEvent::new(code, KeyModifiers::NONE));
        for code in [
            KeyCode::Right,
            KeyCode::Right,
            KeyCode::Right,
            KeyCode::Up,
            KeyCode::Up,
        ] {
            assert_eq!(key(code), None);
        }
        // The last of both axes: area 1.1, weight 10, parallel.
        assert_eq!(key(KeyCode::Enter), Some(Wish::Open(10)));
        key(KeyCode::Tab);
        assert_eq!(key(KeyCode::Enter), Some(Wish::Open(11)));
        assert_eq!(key(KeyCode::Char('q')), Some(Wish::Quit));
        let text = screen(&map, &folder, (120, 40), false);
        assert!(
            text.contains("anchoring.weight 10") && text.contains("homeotropic"),
            "{text}"
        );
        assert!(text.is_ascii(), "{text}");
        for size in [(1, 1), (30, 10), (60, 20), (80, 24), (200, 60)] {
            screen(&map, &folder, size, true);
        }
    }

    /// The sweep of the next tests, with a number in every column of its first point.
    fn with_numbers() -> (tempfile::TempDir, SweepFolder, SweepMap) {
        let (here, folder) = sweep(
            "[vary]\n\"area.target\" = [1.0, 1.0625, 1.125]\n\"anchoring.weight\" = [1, 10]\n\
             [result]\nzenith = \"max(waist)\"\n",
        );
        let mut map = SweepMap::new(&folder).expect("it has axes");
        let numbers = (0..map.table.columns.len()).map(|it| Some(it as f64));
        map.table.rows[0].numbers = numbers.collect();
        map.arranged.extent = Some([0.112_345, 0.341_987]);
        (here, folder, map)
    }

    #[test]
    fn the_map_says_what_its_axes_and_colours_are() {
        let (_here, folder, map) = with_numbers();
        let text = screen(&map, &folder, (80, 24), true);
        for value in [" 1 ", " 1.0625 ", " 1.125 "] {
            assert!(text.contains(value), "{value}:\n{text}");
        }
        assert!(!text.contains("colour"), "there are none:\n{text}");
        for (unicode, words) in [
            (true, "colour: waist/length ■ 0.112 … 0.342 ■"),
            (false, "colour: waist/length # 0.112 ... 0.342 #"),
        ] {
            let theme = Theme::new(ColorTier::True, unicode);
            let text = screen_of(&map, &folder, (80, 24), &theme);
            assert!(text.contains(words), "{text}");
        }
    }

    #[test]
    fn all_values_of_a_point_can_be_reached() {
        let (_here, folder, mut map) = with_numbers();
        let last = format!(" zenith {}", map.table.columns.len() - 1);
        assert!(screen(&map, &folder, (80, 40), true).contains(&last));
        // Not all have room, which is said; the next page has them, and then comes the first again.
        let mut seen = String::new();
        for _ in 0..2 {
            let text = screen(&map, &folder, (80, 16), true);
            assert!(text.contains(": space turns on"), "{text}");
            seen += &text;
            map.key(KeyEvent::new(KeyCode::Char(' '), KeyModifiers::NONE));
        }
        assert!(seen.contains(&last), "{seen}");
        for name in &map.table.columns {
            assert!(seen.contains(&format!(" {name} ")), "{name}:\n{seen}");
        }
        let again = screen(&map, &folder, (80, 16), true);
        assert!(seen.starts_with(&again), "{again}");
        // A long reason is whole.
        map.table.rows[0].state =
            PointState::Failed("one word after the other, until the lines end".to_owned());
        let text = screen(&map, &folder, (80, 40), true);
        assert!(
            text.contains("until") && text.contains("the lines end"),
            "{text}"
        );
    }

    #[test]
    fn all_keys_are_listed_and_the_list_is_closed_by_what_quits_elsewhere() {
        let (_here, folder, mut map) = with_numbers();
        let mut key = |code| {
            let wish = map.key(KeyEvent::new(code, KeyModifiers::NONE));
            (wish, screen(&map, &folder, (80, 24), false))
        };
        for close in [KeyCode::Char('?'), KeyCode::Esc, KeyCode::Char('q')] {
            let (wish, text) = key(KeyCode::Char('?'));
            assert_eq!(wish, None);
            assert!(text.contains("Help") && text.contains("The map"), "{text}");
            let (wish, text) = key(KeyCode::End);
            assert_eq!(wish, None);
            assert!(text.contains("Ctrl-Z") && text.is_ascii(), "{text}");
            let (wish, text) = key(close);
            assert_eq!(wish, None);
            assert!(!text.contains("Help"), "{text}");
        }
        assert_eq!(key(KeyCode::Char('q')).0, Some(Wish::Quit));
        key(KeyCode::Char('?'));
        for size in [(30, 10), (40, 12)] {
            screen(&map, &folder, size, true);
        }
    }

    #[test]
    fn the_window_is_around_the_cursor() {
        assert_eq!(window(9, 20, 4), 0..9);
        assert_eq!(window(9, 4, 0), 0..4);
        assert_eq!(window(9, 4, 5), 3..7);
        assert_eq!(window(9, 4, 8), 5..9);
        assert_eq!(window(3, 0, 2), 2..3);
    }
}
