//! Four runs side by side, at a common time.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::plot::Plot;
use super::shown::Shown;
use super::text;
use super::{chart, external_field};
use crate::geometry::{BoundingBox, Point};
use crate::tui::canvas::Canvas;
use crate::tui::layout::{centred, take_left, take_top};
use crate::tui::numbers::{percent, significant};
use crate::tui::state::{App, Slot, View};
use crate::tui::theme::{Role, Theme};
use crate::tui::update::common_time;
use crate::tui::window::Window;

/// Rows of a tile below a picture: the frame, and scalars if they do not stand beside it.
const BELOW: u16 = 6;

/// Draws the gallery: a header with the common clock, and the cases in the arrangement that makes
/// the pictures largest.
pub fn draw(app: &App, theme: &Theme, canvas: &mut Canvas, area: Rect, buffer: &mut Buffer) {
    let mut area = area;
    let header = take_top(&mut area, 1);
    let slots = &app.slots[app.gallery()];
    let common = common_time(app);
    clock(slots, common, theme, header, buffer);
    if slots.is_empty() || area.is_empty() {
        return;
    }
    let runs = || slots.iter().filter_map(|slot| slot.run.as_ref());
    // All on the same scale.
    let vesicles = runs().filter_map(|run| run.past.vesicle());
    let picture = runs().find_map(|run| run.picture.as_ref());
    let view = TileView {
        view: app.view,
        domain: picture.map_or(UNIT, |picture| canvas.region(&picture.mesh)),
        vesicles: vesicles.reduce(|one, other| one.union(&other)),
    };
    for (index, tile) in tiles(area, slots.len(), &view).into_iter().enumerate() {
        let focused = app.gallery().start + index == app.active;
        if let Some(slot) = slots.get(index) {
            let shown = Shown::at(slot, common);
            draw_tile(&view, &shown, focused, theme, canvas, tile, buffer);
        }
    }
}

/// The domain before there is a mesh.
const UNIT: BoundingBox = BoundingBox {
    lower: Point::new(0.0, 0.0),
    upper: Point::new(1.0, 1.0),
};

/// What all tiles have in common.
struct TileView {
    view: View,
    /// The domain of the first.
    domain: BoundingBox,
    /// The rectangle around the vesicles of all, at all times up to now.
    vesicles: Option<BoundingBox>,
}

impl TileView {
    fn window(&self, domain: BoundingBox, room: (u16, u16)) -> Window {
        Window::new(domain, self.vesicles, self.view.zoom, room)
    }

    /// How large a picture is within so many cells: the greater, the larger.
    fn size(&self, room: (u16, u16)) -> u32 {
        let window = self.window(self.domain, room);
        (window.scale() * self.domain.extent().x).round() as u32
    }
}

/// The common clock, and how fast the runs are together.
fn clock(slots: &[Slot], common: Option<f64>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let runs = slots.iter().filter_map(|slot| slot.run.as_ref());
    let rate: f64 = runs.map(|run| run.pace.steps_per_second).sum();
    let mut spans = vec![
        Span::styled(" vesica ", theme.style(Role::Accent)),
        Span::styled("gallery", theme.strong()),
    ];
    if let Some(t) = common {
        spans.push(Span::styled("   common time t ", theme.muted()));
        spans.push(Span::raw(format!("{t:.3e}")));
    }
    text::line(buffer, area, 0, Line::from(spans));
    if rate > 0.0 && area.width > 60 {
        let rate = Line::from(vec![
            Span::raw(significant(rate, 3)),
            Span::styled(" steps/s in all ", theme.muted()),
        ]);
        text::line_right(buffer, area, 0, rate);
    }
}

/// The tiles of `count` pictures: in the number of columns that makes the pictures largest.
fn tiles(area: Rect, count: usize, view: &TileView) -> Vec<Rect> {
    let size = |columns: usize| {
        let rows = count.div_ceil(columns);
        let width = area.width / columns as u16;
        let height = area.height / rows as u16;
        (width, height)
    };
    let picture = |columns: &usize| {
        let (width, height) = size(*columns);
        view.size((width.saturating_sub(3), height.saturating_sub(1 + BELOW)))
    };
    // Of equals the one with the fewest columns: it has more room beside each picture.
    let columns = (1..=count).rev().max_by_key(picture).unwrap_or(1);
    let (width, height) = size(columns);
    let tile = |index: usize| Rect {
        x: area.x + (index % columns) as u16 * width,
        y: area.y + (index / columns) as u16 * height,
        width: width.saturating_sub(1),
        height,
    };
    (0..count).map(tile).collect()
}

/// A picture, its name above it, its scalars beside or below it.
fn draw_tile(
    view: &TileView,
    shown: &Shown<'_>,
    focused: bool,
    theme: &Theme,
    canvas: &mut Canvas,
    area: Rect,
    buffer: &mut Buffer,
) {
    let (word, role) = shown.status();
    let mut title = Line::from(Span::styled(shown.slot.name.as_str(), theme.strong()));
    let anchoring = shown
        .anchoring
        .map_or(String::new(), |kind| format!(" {}", kind.name()));
    // With the marks and gaps around it.
    let fits = |width: usize| width <= usize::from(area.width);
    if fits(title.width() + anchoring.len() + 3) {
        title.push_span(Span::raw(anchoring));
    }
    let has_state = fits(title.width() + word.len() + 7);
    let state = Line::styled(word, theme.style(role));
    // Where there is no room for it in the title, the state stands beside the time.
    let beside_time = Some(&state).filter(|_| !has_state);
    let mut scalars = scalars(shown, beside_time, false, theme);
    let area = text::title(buffer, area, theme, focused, title, state.clone());
    let beside = scalars.iter().map(Line::width).max().unwrap_or(0) as u16 + 2;
    // Beside the picture if it does not become smaller by that.
    let rooms = [(beside + 2, 2), (2, BELOW)].map(|(columns, rows)| {
        (
            area.width.saturating_sub(columns),
            area.height.saturating_sub(rows),
        )
    });
    let [with, without] = rooms.map(|room| view.size(room));
    let below = without > with;
    if !scalars.iter().all(|line| fits(line.width())) {
        scalars = self::scalars(shown, beside_time, true, theme);
    }
    let Some((setting, picture)) = shown.setting.zip(shown.picture) else {
        let words = match shown.run {
            None => "not yet set up",
            Some(run) if run.is_over() => "not set up",
            Some(_) => "setting up",
        };
        let area = centred(area, words.len() as u16, 1);
        return text::line(buffer, area, 0, Span::styled(words, theme.muted()));
    };
    let domain = canvas.region(&picture.mesh);
    let window = view.window(domain, rooms[usize::from(below)]);
    let Window { columns, rows, .. } = window;
    if columns < 2 || rows < 1 {
        return;
    }
    let frame = Rect {
        width: columns + 2,
        height: rows + 2,
        ..area
    };
    let plot = Plot {
        mesh: &picture.mesh,
        state: &picture.state,
        setting,
        region: window.region,
        view: view.view,
    };
    plot.draw(theme, canvas, frame, buffer);
    external_field::draw(shown, frame, theme, buffer);
    let mut list = area;
    if below {
        take_top(&mut list, frame.height);
    } else {
        take_left(&mut list, frame.width + 1);
        take_top(&mut list, 1);
    }
    let rows = scalars.len() as u16;
    if list.height < 3 {
        let spans = scalars.into_iter().flat_map(|scalar| scalar.spans);
        return text::line(buffer, list, 0, spans.collect::<Line<'_>>());
    }
    for (row, scalar) in scalars.into_iter().enumerate() {
        text::line(buffer, list, row as u16, scalar);
    }
    energy_curve(shown, rows, view.view.logarithmic, theme, list, buffer);
}

/// The curve of the energy, where there is room for it below the scalars.
fn energy_curve(
    shown: &Shown<'_>,
    below: u16,
    logarithmic: bool,
    theme: &Theme,
    list: Rect,
    buffer: &mut Buffer,
) {
    const HEIGHT: u16 = 6;
    let Some(run) = shown.run.filter(|_| list.height > below + HEIGHT + 1) else {
        return;
    };
    let words = Span::styled(" total energy", theme.muted());
    text::line(buffer, list, below + 1, words);
    let area = Rect {
        width: list.width.min(48),
        y: list.y + below + 2,
        height: HEIGHT.min(list.height - below - 2),
        ..list
    };
    let curves = shown.curves(logarithmic);
    let colour = theme.colour(Role::Total);
    let series = &run.history.total_energy;
    chart::draw(series, &curves, colour, theme, area, buffer);
}

/// The scalars of a run, the most telling first; in short words where there is little room.
fn scalars<'a>(
    shown: &Shown<'_>,
    state: Option<&Line<'a>>,
    is_short: bool,
    theme: &Theme,
) -> Vec<Line<'a>> {
    let Some(report) = shown.report else {
        return Vec::new();
    };
    let entry = |name: &str, value: String, note: String| {
        Line::from(vec![
            Span::styled(format!(" {name} "), theme.muted()),
            Span::raw(value),
            Span::styled(note, theme.muted()),
        ])
    };
    let mut time = entry("t", format!("{:.3e}", report.t), String::new());
    if let Some(state) = state {
        time.push_span(Span::raw(" "));
        time.extend(
            state
                .iter()
                .map(|span| span.clone().patch_style(state.style)),
        );
    }
    let mut lines = vec![time];
    let energy = report.total_energy;
    let change = shown
        .energy_at_start()
        .map(|start| percent(energy - start, start));
    let change = change.map_or(String::new(), |change| format!(" {change}"));
    lines.push(match is_short {
        false => entry("total energy", significant(energy, 5), change),
        true => entry("energy", significant(energy, 5), String::new()),
    });
    if let Some(words) = shown.vesicles() {
        lines.push(Line::styled(format!(" {words}"), theme.muted()));
    }
    if let Some(outline) = report.outline() {
        let ratio = outline.waist / outline.width;
        lines.push(entry("waist/width", significant(ratio, 3), String::new()));
        lines.push(entry(
            "length",
            significant(outline.length, 3),
            String::new(),
        ));
    }
    if let Some(target) = shown.target() {
        let share = significant(report.surface_area / target, 4);
        lines.push(entry("area/target", share, String::new()));
    }
    lines.push(entry("step", report.step.to_string(), String::new()));
    lines
}
