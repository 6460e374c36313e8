//! Scalars against time: small charts beside and under each other.

use super::canvas::{
    Drawing, Page, Rectangle, font, in_pixels, part, pieces, stroke, units, write_paragraph,
};
use super::colour::GREY;
use super::legend::{Entry, draw_legend};
use super::number::{Axis, extent, letter, roomy_range};
use super::panel::line_weight;
use super::text::{Label, line_height};
use super::{FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::PathElement;
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::{BLACK, RGBColor, ShapeStyle};
use std::borrow::Cow;
use std::cmp::Ordering;
use std::iter::once;

/// The height of a plot to its width.
const ASPECT: f64 = 0.66;
/// A plot with all around it is at least so wide, in sizes of the text.
const LEAST_WIDTH: f64 = 14.0;
/// Plots beside each other.
const MOST_COLUMNS: usize = 3;
/// The lengths of ticks, at the left and below, in sizes of the text. plotters writes the numbers two ticks
/// away: below so that the lowest number at the left has room.
pub(super) const TICKS: [f64; 2] = [0.28, 0.35];

/// A line in a plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    /// t and the value, in the order of t.
    pub points: Vec<(f64, f64)>,
    pub look: Look,
}

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Look {
    pub colour: RGBColor,
    pub pattern: Pattern,
}

impl Look {
    /// In a picture whose text has this size.
    fn style(self, size: f64) -> ShapeStyle {
        stroke(self.colour, 1.6 * line_weight(size))
    }
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    Solid,
    /// For what is no run: a target, theory.
    Short,
    Long,
    Dots,
}

impl Pattern {
    /// The lengths in units of a dash and of the space after it; none where all is drawn.
    fn dashes(self, size: f64) -> Option<[i32; 2]> {
        let lengths = match self {
            Pattern::Solid => return None,
            Pattern::Short => [0.5, 0.35],
            Pattern::Long => [1.2, 0.5],
            Pattern::Dots => [0.05, 0.35],
        };
        Some(lengths.map(|length| units(length * size).max(1)))
    }
}

/// What is marked at a time of a run, by an upright grey line, in the order of the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Event {
    /// Parameters or the anchoring became others.
    Change,
    /// Vesicles merged, split, appeared, vanished, or reached the wall.
    Vesicles,
    /// The mesh has followed the membrane.
    Mesh,
}

impl Event {
    const ALL: [Event; 3] = [Event::Change, Event::Vesicles, Event::Mesh];

    /// How its line is broken.
    fn pattern(self) -> Pattern {
        match self {
            Event::Change => Pattern::Solid,
            Event::Vesicles => Pattern::Long,
            Event::Mesh => Pattern::Dots,
        }
    }

    /// In a picture whose text has this size: thinner than a curve, and of no curve's colour.
    fn style(self, size: f64) -> ShapeStyle {
        stroke(GREY, 1.1 * line_weight(size))
    }

    /// What the legend says.
    fn words(self) -> &'static str {
        match self {
            Event::Change => "a parameter or the anchoring changes",
            Event::Vesicles => "vesicles merge, split, appear, vanish, or touch the wall",
            Event::Mesh => "the mesh follows the membrane",
        }
    }
}

/// An upright line that marks an event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    pub event: Event,
    pub t: f64,
    /// From which value to which.
    pub range: [f64; 2],
}

impl Mark {
    /// Whether it is seen in a plot of this width: not where it lies on the plot's own side, nor beyond.
    fn is_seen(&self, time: &Axis, width: f64, size: f64) -> bool {
        let at = time.place(self.t) * width;
        let side = 2.0 * line_weight(size);
        at > side && at < width - side
    }
}

/// A plot of curves against t.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    pub name: Label,
    /// What else is to be said of it.
    pub note: Label,
    pub curves: Vec<Curve>,
    pub marks: Vec<Mark>,
}

/// Draws the plots under `title`, with `keys` for their lines if there are several; over t, or what the abscissa is called.
/// What their marks mean stands at the foot.
///
/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw(
    title: &Label,
    keys: &[(Label, Look)],
    (plots, abscissa): (&[Plot], Option<&Label>),
    options: &FigureOptions,
) -> Result<Drawing, FigureError> {
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 1.4 * size);
    let columns = ((width / (LEAST_WIDTH * size)) as usize).clamp(1, MOST_COLUMNS);
    let columns = columns.min(plots.len().max(1));
    let cell = (width - 2.0 * margin - gap * (columns as f64 - 1.0)) / columns as f64;
    // A single plot is not to fill the width.
    let cell = cell.min((width - 2.0 * margin - gap) / 2.0_f64.min(MOST_COLUMNS as f64));
    let most = ((ASPECT * cell / (1.8 * size)) as usize).clamp(2, 7);
    let axes: Vec<Axis> = plots.iter().map(|plot| value_axis(plot, most)).collect();
    let numbers = axes.iter().map(|axis| axis.widest(size));
    let left_room = numbers.fold(0.0, f64::max) + 2.0 * TICKS[0] * size;
    let inner = (cell - left_room).max(2.0 * size);
    let is_logarithmic = options.logarithmic_time && abscissa.is_none();
    let time = time_axis(plots, is_logarithmic, inner, size);
    let abscissa = abscissa.cloned().unwrap_or_else(|| Label::symbol("t"));
    // A number at the end of the axis reaches beyond it by half its width.
    let overhang = 0.5 * time.widest(size);
    let inner = inner - overhang;
    let lower_room = (2.0 * TICKS[1] + 0.25) * size + 2.0 * line_height(size);

    let name = |number: usize| {
        let (plot, axis) = (&plots[number], &axes[number]);
        let letter = match plots.len() {
            1 => Label::default(),
            _ => letter(number),
        };
        letter
            .and_label(axis.name(plot.name.clone()))
            .and_label(plot.note.clone())
    };
    Drawing::compose(options.width, |page| {
        let room = width - 2.0 * margin;
        let mut top = write_paragraph(page, title, size, [margin, margin], room)?;
        if keys.len() > 1 {
            let entries = keys.iter().cloned();
            let entries = entries.map(|(label, look)| {
                Entry::line(label, look.pattern.dashes(size), look.style(size), size)
            });
            top = draw_legend(page, entries.collect(), [margin, top + 0.2 * size], size)?;
        }
        top += 0.5 * size;
        for first in (0..plots.len()).step_by(columns) {
            let row = first..(first + columns).min(plots.len());
            let lines = |number| name(number).wrapped(size, inner + overhang).len();
            let lines = row.clone().map(lines).fold(1, usize::max);
            let names_height = line_height(size) * lines as f64;
            for (column, number) in row.enumerate() {
                // Over the plot, where no number of an axis is in the way.
                let left = margin + column as f64 * (cell + gap) + left_room;
                write_paragraph(page, &name(number), size, [left, top], inner + overhang)?;
                let plot = Rectangle::new([left, top + names_height], [inner, ASPECT * cell]);
                let place = plot.on_pixels().with_room([left_room, 0.0, lower_room]);
                let (page, plot) = (&part(page, place), &plots[number]);
                let rooms = [left_room, lower_room];
                draw_plot(page, plot, ([&time, &axes[number]], &abscissa), rooms, size)?;
            }
            top += names_height + ASPECT * cell + lower_room + 0.8 * size;
        }
        let mut bottom = top - 0.8 * size;
        let marks = || plots.iter().flat_map(|plot| &plot.marks);
        let is_marked = |event: &Event| {
            marks().any(|mark| mark.event == *event && mark.is_seen(&time, inner, size))
        };
        let events = Event::ALL.into_iter().filter(is_marked);
        let entry = |event: Event| {
            let (dashes, style) = (event.pattern().dashes(size), event.style(size));
            Entry::line(Label::text(event.words()), dashes, style, size)
        };
        let entries: Vec<Entry> = events.map(entry).collect();
        if !entries.is_empty() {
            bottom = draw_legend(page, entries, [margin, bottom + 0.6 * size], size)?;
        }
        Ok(bottom + margin)
    })
}

fn value_axis(plot: &Plot, most: usize) -> Axis {
    let values = plot.curves.iter().flat_map(|curve| &curve.points);
    Axis::new(roomy_range(values.map(|(_, value)| *value)), most)
}

/// From the first time to the last, with as many ticks as have room for their numbers.
fn time_axis(plots: &[Plot], is_logarithmic: bool, width: f64, size: f64) -> Axis {
    let points = plots.iter().flat_map(|plot| &plot.curves);
    let times = points.flat_map(|curve| &curve.points).map(|(t, _)| *t);
    // t = 0 has no place on a logarithmic axis.
    let times = times.filter(|t| !is_logarithmic || *t > 0.0);
    let range = match extent(times) {
        Some([first, last]) if first < last => [first, last],
        // One moment, or none.
        Some([first, _]) => [first, first + first.abs().max(1e-7)],
        None if is_logarithmic => [0.1, 1.0],
        None => [0.0, 1.0],
    };
    let axis = |most: usize| match is_logarithmic {
        true => Axis::logarithmic(range, most),
        false => Axis::new(range, most),
    };
    (1..=6)
        .rev()
        .map(axis)
        .find(|axis| {
            let fits = |pair: &[f64]| {
                let labels: f64 = pair.iter().map(|t| axis.label(*t).width(size)).sum();
                (axis.place(pair[1]) - axis.place(pair[0])) * width > 0.5 * labels + 0.7 * size
            };
            axis.ticks.windows(2).all(fits)
        })
        .unwrap_or_else(|| axis(1))
}

/// Draws a chart on a part of a page, with so much room for the numbers at the left and below.
fn draw_plot(
    page: &Page,
    plot: &Plot,
    ([time, value], abscissa): ([&Axis; 2], &Label),
    [left_room, lower_room]: [f64; 2],
    size: f64,
) -> Result<(), FigureError> {
    let [(first, last), (low, high)] = [time, value].map(|axis| axis.range.into());
    let mut chart = ChartBuilder::on(page)
        .y_label_area_size(units(left_room))
        .x_label_area_size(units(lower_room))
        .build_cartesian_2d(time.clone(), value.clone())?;
    let line = stroke(BLACK, 0.8 * line_weight(size));
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(line)
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
        .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
        .x_desc(time.name(abscissa.clone()))
        .draw()?;
    let width = in_pixels(chart.plotting_area().dim_in_pixel().0);
    let columns = 2.0 * width;
    // Marks lie below all curves.
    let marks = (plot.marks.iter()).filter(|mark| mark.is_seen(time, width, size));
    let marks = marks.map(|mark| {
        let [low, high] = mark.range;
        let points = vec![(mark.t, low), (mark.t, high)];
        (
            Cow::Owned(points),
            mark.event.pattern(),
            mark.event.style(size),
        )
    });
    let curves = plot.curves.iter().map(|curve| {
        let points = Cow::Borrowed(&*curve.points);
        (points, curve.look.pattern, curve.look.style(size))
    });
    for (points, pattern, style) in marks.chain(curves) {
        // Where a value is no number the line has a gap.
        let points = points
            .iter()
            .filter(|(t, _)| t.partial_cmp(&first) != Some(Ordering::Less));
        for piece in pieces(points.copied()) {
            let points = thinned(&piece, |t| (columns * time.place(t)).floor());
            match pattern.dashes(size) {
                None => chart.draw_series(LineSeries::new(points, style))?,
                Some([dash, space]) => {
                    chart.draw_series(DashedLineSeries::new(points, dash, space, style))?
                }
            };
        }
    }
    // plotters draws the other two sides, as axes.
    let sides = [(first, high), (last, high), (last, low)];
    chart.draw_series(once(PathElement::new(sides, line)))?;
    Ok(())
}

/// The points that show: of those in one column, half a pixel wide, the first, the lowest, the highest
/// and the last, so that no peak is lost.
fn thinned(points: &[(f64, f64)], column: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by_value = |a: &usize, b: &usize| group[*a].1.total_cmp(&group[*b].1);
        let mut numbers = vec![0, group.len() - 1];
        numbers.extend((0..group.len()).min_by(by_value));
        numbers.extend((0..group.len()).max_by(by_value));
        numbers.sort_unstable();
        numbers.dedup();
        kept.extend(numbers.into_iter().map(|number| group[number]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiny_skia::Point;

    #[test]
    fn a_peak_survives_thinning() {
        let points: Vec<(f64, f64)> = (0..10_000)
            .map(|n| (f64::from(n) * 0.01, if n == 4321 { 99.0 } else { 1.0 }))
            .collect();
        let kept = thinned(&points, |t| (2.0 * t).floor());
        assert!(kept.len() < 1000, "{}", kept.len());
        assert!(kept.contains(&(43.21, 99.0)));
        assert_eq!(kept.first(), points.first());
        assert_eq!(kept.last(), points.last());
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    const COLOUR: RGBColor = RGBColor(1, 2, 3);

    /// What is drawn of a curve in a plot of 100 × 100 pixels of the square from 0 to 1, with text of size 10.
    fn drawn(points: &[(f64, f64)], pattern: Pattern) -> Vec<Vec<Point>> {
        let look = Look {
            colour: COLOUR,
            pattern,
        };
        let curve = Curve {
            points: points.to_vec(),
            look,
        };
        let axis = Axis::new([0.0, 1.0], 2);
        let place = Rectangle::new([0.0; 2], [120.0, 150.0]);
        let drawing = Drawing::compose(200, |page| {
            let plot = Plot {
                name: Label::default(),
                note: Label::default(),
                curves: vec![curve],
                marks: Vec::new(),
            };
            draw_plot(
                &part(page, place),
                &plot,
                ([&axis, &axis], &Label::symbol("t")),
                [20.0, 50.0],
                10.0,
            )?;
            Ok(200.0)
        });
        let drawing = drawing.expect("it is drawn");
        let shapes = drawing.shapes.iter();
        let own = shapes.filter(|shape| shape.colour == COLOUR);
        own.map(|shape| shape.path.points().to_vec()).collect()
    }

    fn length(piece: &[Point]) -> f64 {
        let pairs = piece.windows(2);
        f64::from(pairs.map(|pair| pair[0].distance(pair[1])).sum::<f32>())
    }

    #[test]
    fn dashes_cover_their_share_of_the_line() {
        // 100 pixels up and 50 to the right.
        let line = [(0.0, 0.0), (0.0, 1.0), (0.5, 1.0)];
        for (pattern, dash, space) in [
            (Pattern::Short, 5.0, 3.5),
            (Pattern::Long, 12.0, 5.0),
            (Pattern::Dots, 0.5, 3.5),
        ] {
            let pieces = drawn(&line, pattern);
            let count = 150.0 / (dash + space);
            assert!((pieces.len() as f64 - count).abs() <= 1.0, "{pattern:?}");
            // The last may be cut off.
            for piece in &pieces[..pieces.len() - 1] {
                let length = length(piece);
                assert!((length - dash).abs() < 0.1, "{pattern:?}: {length}");
            }
            let total: f64 = pieces.iter().map(|piece| length(piece)).sum();
            assert!((total - count * dash).abs() <= dash, "{pattern:?}: {total}");
        }
        let [whole] = &drawn(&line, Pattern::Solid)[..] else {
            panic!("one line");
        };
        assert!((length(whole) - 150.0).abs() < 0.1);
    }

    /// What is no place is a gap, and no pattern takes for ever.
    #[test]
    fn a_line_ends_whatever_its_points() {
        for pattern in [Pattern::Solid, Pattern::Short, Pattern::Long, Pattern::Dots] {
            for end in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
                let line = [(0.0, 0.0), (0.5, 0.0), (end, 0.0), (0.5, end), (1.0, 1.0)];
                let whole: f64 = drawn(&line, pattern).iter().map(|it| length(it)).sum();
                assert!(whole <= 50.1, "{pattern:?} to {end}: {whole}");
                assert!(whole > 4.0, "{pattern:?} to {end}: {whole}");
            }
            assert!(
                drawn(&[(0.5, 0.5); 2], pattern)
                    .iter()
                    .all(|it| length(it) == 0.0)
            );
            assert!(drawn(&[], pattern).is_empty());
        }
        for size in [0.0, f64::NAN, f64::MIN_POSITIVE] {
            assert_eq!(Pattern::Long.dashes(size), Some([1, 1]));
        }
    }
}
