//! Scalars against time: small plots beside and under each other.

use super::colour::Colour;
use super::drawing::{Drawing, Rectangle};
use super::number::{Axis, roomy_range};
use super::panel::stroke;
use super::text::{Across, Along, Label, line_height};
use super::{FigureOptions, TEXT_SIZES_A_WIDTH, text_size};

/// The height of a plot to its width.
const ASPECT: f64 = 0.66;
/// A plot with all around it is at least so wide, in sizes of the text.
const LEAST_WIDTH: f64 = 14.0;
/// Plots beside each other.
const MOST_COLUMNS: usize = 3;
const TICK: f64 = 0.28;
/// Between a tick and its number below, in sizes of the text: the lowest number at the left has room.
const NUMBER_GAP: f64 = 0.42;

/// A line in a plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    /// t and the value, in the order of t.
    pub points: Vec<[f64; 2]>,
    pub look: Look,
}

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Look {
    pub colour: Colour,
    pub pattern: Pattern,
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    Solid,
    /// For what is no run: a target, a mark.
    Short,
    Long,
    DashDot,
}

impl Pattern {
    /// What is drawn and what is left out in turn, in sizes of the text; empty: all is drawn.
    fn lengths(self) -> &'static [f64] {
        match self {
            Pattern::Solid => &[],
            Pattern::Short => &[0.5, 0.35],
            Pattern::Long => &[1.2, 0.5],
            Pattern::DashDot => &[0.9, 0.3, 0.15, 0.3],
        }
    }
}

/// Draws a line as it is to look.
fn draw_line(drawing: &mut Drawing, points: Vec<[f64; 2]>, look: Look, size: f64) {
    let width = 1.6 * stroke(size);
    let lengths: Vec<f64> = look.pattern.lengths().iter().map(|it| it * size).collect();
    if lengths.is_empty() {
        drawing.line(points, width, look.colour);
    } else {
        for dash in dashes(&points, &lengths) {
            drawing.line(dash, width, look.colour);
        }
    }
}

/// A plot of curves against t.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    pub name: Label,
    /// What else is to be said of it.
    pub note: Label,
    pub curves: Vec<Curve>,
}

/// An entry above the plots: what a line stands for.
pub(super) type Key = (Label, Look);

/// Draws the plots under `title`, with `keys` if there are several.
pub(super) fn draw(
    title: &Label,
    keys: &[Key],
    plots: &[Plot],
    options: &FigureOptions,
) -> Drawing {
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 1.4 * size);
    let mut drawing = Drawing {
        width: options.width,
        ..Drawing::default()
    };
    let mut top = margin;
    for line in title.wrapped(size, width - 2.0 * margin) {
        drawing.label(&line, size, [margin, top], Across::Left, Along::Top);
        top += line_height(size);
    }
    if keys.len() > 1 {
        top = draw_keys(&mut drawing, keys, top + 0.2 * size, margin, size);
    }
    top += 0.5 * size;

    let columns = ((width / (LEAST_WIDTH * size)) as usize).clamp(1, MOST_COLUMNS);
    let columns = columns.min(plots.len().max(1));
    let cell = (width - 2.0 * margin - gap * (columns as f64 - 1.0)) / columns as f64;
    // A single plot is not to fill the width.
    let cell = cell.min((width - 2.0 * margin - gap) / 2.0_f64.min(MOST_COLUMNS as f64));
    let most = ((ASPECT * cell / (1.8 * size)) as usize).clamp(2, 7);
    let axes: Vec<Axis> = plots.iter().map(|plot| value_axis(plot, most)).collect();
    let numbers = |axis: &Axis| {
        let widths = axis.ticks.iter().map(|tick| axis.label(*tick).width(size));
        widths.fold(0.0, f64::max)
    };
    let left_room = axes.iter().map(numbers).fold(0.0, f64::max) + (TICK + 0.25) * size;
    let inner = (cell - left_room).max(2.0 * size);
    let time = time_axis(plots, inner, size);
    // A number at the end of the axis reaches beyond it by half its width.
    let overhang = 0.5 * numbers(&time);
    let inner = inner - overhang;

    let names: Vec<Vec<Label>> = plots
        .iter()
        .zip(&axes)
        .map(|(plot, axis)| {
            let name = axis.name(plot.name.clone()).and_label(plot.note.clone());
            name.wrapped(size, inner + overhang)
        })
        .collect();
    for first in (0..plots.len()).step_by(columns) {
        let row = first..(first + columns).min(plots.len());
        let lines = names[row.clone()].iter().map(Vec::len).max().unwrap_or(1);
        let names_height = line_height(size) * lines as f64;
        for (column, number) in row.enumerate() {
            let left = margin + column as f64 * (cell + gap);
            for (line, name) in names[number].iter().enumerate() {
                // Over the plot, where no number of an axis is in the way.
                let at = [left + left_room, top + line_height(size) * line as f64];
                drawing.label(name, size, at, Across::Left, Along::Top);
            }
            let place = Rectangle {
                left: left + left_room,
                top: top + names_height,
                right: left + left_room + inner,
                bottom: top + names_height + ASPECT * cell,
            };
            draw_plot(
                &mut drawing,
                &plots[number],
                place.on_pixels(),
                [&time, &axes[number]],
                size,
            );
        }
        top += names_height
            + ASPECT * cell
            + (TICK + NUMBER_GAP + 0.25) * size
            + 2.0 * line_height(size)
            + 0.8 * size;
    }
    drawing.height = (top - 0.8 * size + margin).ceil() as u32;
    drawing
}

/// Draws what the lines stand for, and gives where it ends.
fn draw_keys(drawing: &mut Drawing, keys: &[Key], top: f64, margin: f64, size: f64) -> f64 {
    // Two long dashes and more.
    let (sample, space) = (3.0 * size, 0.5 * size);
    let width = f64::from(drawing.width);
    let (mut x, mut y) = (margin, top);
    for (label, look) in keys {
        let most = width - 2.0 * margin - sample - space;
        let lines = label.wrapped(size, most);
        let widest = lines
            .iter()
            .map(|line| line.width(size))
            .fold(0.0, f64::max);
        if x > margin && x + sample + space + widest > width - margin {
            x = margin;
            y += line_height(size);
        }
        let middle = y + 0.56 * size;
        let ends = vec![[x, middle], [x + sample, middle]];
        draw_line(drawing, ends, *look, size);
        for (number, line) in lines.iter().enumerate() {
            if number > 0 {
                y += line_height(size);
            }
            let at = [x + sample + space, y];
            drawing.label(line, size, at, Across::Left, Along::Top);
        }
        x += sample + space + widest + 1.5 * size;
    }
    y + line_height(size)
}

fn value_axis(plot: &Plot, most: usize) -> Axis {
    let values = plot.curves.iter().flat_map(|curve| &curve.points);
    Axis::new(roomy_range(values.map(|[_, value]| *value)), most)
}

/// From the first time to the last, with as many ticks as have room for their numbers.
fn time_axis(plots: &[Plot], width: f64, size: f64) -> Axis {
    let times = plots
        .iter()
        .flat_map(|plot| &plot.curves)
        .flat_map(|curve| &curve.points);
    let (first, last) = times
        .map(|[t, _]| *t)
        .filter(|t| t.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), t| {
            (first.min(t), last.max(t))
        });
    let range = match first < last {
        true => [first, last],
        // One moment, or none.
        false if first.is_finite() => [first, first + first.abs().max(1e-7)],
        false => [0.0, 1.0],
    };
    (1..=6)
        .rev()
        .map(|most| Axis::new(range, most))
        .find(|axis| {
            let labels: Vec<f64> = axis
                .ticks
                .iter()
                .map(|t| axis.label(*t).width(size))
                .collect();
            let places: Vec<f64> = axis.ticks.iter().map(|t| axis.place(*t) * width).collect();
            let fits = |k: usize| {
                places[k + 1] - places[k] > 0.5 * (labels[k] + labels[k + 1]) + 0.7 * size
            };
            (1..labels.len()).all(|k| fits(k - 1))
        })
        .unwrap_or_else(|| Axis::new(range, 1))
}

fn draw_plot(
    drawing: &mut Drawing,
    plot: &Plot,
    place: Rectangle,
    [time, value]: [&Axis; 2],
    size: f64,
) {
    let thin = 0.8 * stroke(size);
    let tick = TICK * size;
    for &t in &time.ticks {
        let x = place.left + time.place(t) * place.width();
        drawing.line(
            vec![[x, place.bottom], [x, place.bottom + tick]],
            thin,
            Colour::BLACK,
        );
        let at = [x, place.bottom + tick + NUMBER_GAP * size];
        drawing.label(&time.label(t), size, at, Across::Middle, Along::Top);
    }
    for &tick_value in &value.ticks {
        let y = place.bottom - value.place(tick_value) * place.height();
        drawing.line(
            vec![[place.left, y], [place.left - tick, y]],
            thin,
            Colour::BLACK,
        );
        let at = [place.left - tick - 0.25 * size, y];
        drawing.label(
            &value.label(tick_value),
            size,
            at,
            Across::Right,
            Along::Middle,
        );
    }
    let at = [
        0.5 * (place.left + place.right),
        place.bottom + tick + (NUMBER_GAP + 0.25) * size + line_height(size),
    ];
    drawing.label(
        &time.name(Label::symbol("t")),
        size,
        at,
        Across::Middle,
        Along::Top,
    );

    for curve in &plot.curves {
        let on_picture = |[t, v]: [f64; 2]| {
            [
                place.left + time.place(t) * place.width(),
                place.bottom - value.place(v) * place.height(),
            ]
        };
        // Where a value is no number the line has a gap.
        for piece in curve
            .points
            .split(|point| point.iter().any(|x| !x.is_finite()))
        {
            let points: Vec<_> = piece.iter().copied().map(on_picture).collect();
            draw_line(drawing, thinned(&points), curve.look, size);
        }
    }
    drawing.line(place.corners().to_vec(), thin, Colour::BLACK);
}

/// The points that show: of those within half a pixel across, the first, the lowest, the highest
/// and the last, so that no peak is lost.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let column = |point: &[f64; 2]| (2.0 * point[0]).floor();
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let position = |wanted: Option<&[f64; 2]>| {
            wanted.and_then(|w| group.iter().position(|point| std::ptr::eq(point, w)))
        };
        let mut numbers = vec![0, group.len() - 1];
        numbers.extend(position(group.iter().min_by(by_value)));
        numbers.extend(position(group.iter().max_by(by_value)));
        numbers.sort_unstable();
        numbers.dedup();
        kept.extend(numbers.into_iter().map(|number| group[number]));
    }
    kept
}

/// A line is not broken into more pieces than this: they would be shorter than what is seen.
const MOST_DASHES: f64 = 1e5;

/// Pieces of a line: of `lengths` the first is drawn, the second left out, the third drawn, and so on
/// for ever. A line that has no length, or more pieces than can be seen, is one.
pub(super) fn dashes(points: &[[f64; 2]], lengths: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let along = points.windows(2).map(|pair| distance(pair[0], pair[1]));
    let pieces = lengths.len() as f64 * along.sum::<f64>() / lengths.iter().sum::<f64>();
    // Not so for what is no number either.
    let is_fit = pieces <= MOST_DASHES && lengths.iter().all(|length| *length > 0.0);
    if !is_fit {
        return vec![points.to_vec()];
    }
    let mut pieces = Vec::new();
    let mut piece: Vec<[f64; 2]> = points.first().copied().into_iter().collect();
    let mut turns = lengths.iter().copied().cycle();
    let (mut is_on, mut left) = (true, turns.next().unwrap_or(f64::INFINITY));
    for pair in points.windows(2) {
        let mut from = pair[0];
        loop {
            let length = distance(from, pair[1]);
            if length < left {
                left -= length;
                if is_on {
                    piece.push(pair[1]);
                }
                break;
            }
            let share = left / length;
            from = [0, 1].map(|axis| from[axis] + share * (pair[1][axis] - from[axis]));
            if is_on {
                piece.push(from);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![from];
            }
            is_on = !is_on;
            left = turns.next().unwrap_or(f64::INFINITY);
        }
    }
    if is_on && piece.len() > 1 {
        pieces.push(piece);
    }
    // What rounding leaves at the end of a dash is none.
    pieces.retain(|piece| distance(piece[0], piece[piece.len() - 1]) > 1e-6);
    pieces
}

fn distance(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_survives_thinning() {
        let points: Vec<[f64; 2]> = (0..10_000)
            .map(|n| [f64::from(n) * 0.01, if n == 4321 { 99.0 } else { 1.0 }])
            .collect();
        let kept = thinned(&points);
        assert!(kept.len() < 1000, "{}", kept.len());
        assert!(kept.contains(&[43.21, 99.0]));
        assert_eq!(kept.first(), points.first());
        assert_eq!(kept.last(), points.last());
        assert!(kept.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    }

    #[test]
    fn dashes_cover_their_share_of_the_line() {
        let pieces = dashes(&[[0.0, 0.0], [30.0, 40.0], [30.0, 90.0]], &[3.0, 2.0]);
        let length: f64 = pieces
            .iter()
            .flat_map(|piece| piece.windows(2))
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum();
        assert!((length - 60.0).abs() < 1e-9, "{length}");
        assert_eq!(pieces.len(), 20);
        // A dash and a dot: 6 of 10 and twice as many pieces.
        let pieces = dashes(&[[0.0, 0.0], [100.0, 0.0]], &[5.0, 2.0, 1.0, 2.0]);
        let lengths: Vec<f64> = pieces
            .iter()
            .map(|it| it[it.len() - 1][0] - it[0][0])
            .collect();
        assert_eq!(lengths, [5.0, 1.0].repeat(10));
    }

    /// Each of these took memory without end.
    #[test]
    fn dashes_end_whatever_the_line() {
        for end in [f64::NAN, f64::INFINITY, 1e300] {
            let line = [[0.0, 0.0], [end, 0.0]];
            let pieces = dashes(&line, &[3.0, 2.0]);
            assert_eq!(pieces.len(), 1, "{end}");
        }
        for lengths in [&[0.0, 0.0][..], &[f64::NAN, 1.0], &[3.0, -2.0], &[]] {
            let line = [[0.0, 0.0], [30.0, 0.0]];
            assert_eq!(dashes(&line, lengths), [line.to_vec()], "{lengths:?}");
        }
        assert!(dashes(&[[0.0; 2]; 2], &[3.0, 2.0]).is_empty());
        assert!(dashes(&[], &[3.0, 2.0]).is_empty());
    }
}
