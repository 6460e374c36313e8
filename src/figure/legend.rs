//! What lines and marks stand for, above the charts of a figure: plotters' own labels of series, in columns,
//! for several charts at once.

use super::FigureError;
use super::canvas::{Drawing, Page, Rectangle, font, in_pixels, part, units};
use super::elements::{Mark, marker};
use super::text::Label;
use plotters::chart::{ChartBuilder, SeriesLabelPosition};
use plotters::element::{DashedPathElement, DynElement, IntoDynElement, PathElement};
use plotters::style::ShapeStyle;
use plotters_backend::BackendCoord;

/// The width of a sample of a line, in sizes of the text: two long dashes and more.
const SAMPLE: f64 = 3.0;
/// Between it and its label.
const SPACE: f64 = 0.5;
/// Between columns.
const GAP: f64 = 1.5;
/// The height of a line, that of plotters' texts of several lines.
const LINE: f64 = 1.25;
/// The middle of figures is so far below the place where plotters puts a sample.
const MIDDLE: f64 = 0.17;

/// What is drawn at a place of plotters', the left end of the sample.
type Sample<'a> = Box<dyn Fn(BackendCoord) -> DynElement<'static, &'a mut Drawing, BackendCoord>>;

/// A label and what it stands for.
pub(super) struct Entry<'a> {
    label: Label,
    sample: Sample<'a>,
}

impl<'a> Entry<'a> {
    /// A line, of dashes and spaces of these lengths in units if it is not whole, in a picture whose text has
    /// this size.
    pub fn line(label: Label, dashes: Option<[i32; 2]>, style: ShapeStyle, size: f64) -> Self {
        let (width, lower) = (units(SAMPLE * size), units(MIDDLE * size));
        let sample: Sample = Box::new(move |(x, y)| {
            let ends = [(x, y + lower), (x + width, y + lower)];
            match dashes {
                None => PathElement::new(ends, style).into_dyn(),
                Some([dash, space]) => DashedPathElement::new(ends, dash, space, style).into_dyn(),
            }
        });
        Entry { label, sample }
    }

    /// A mark and its style.
    pub fn mark(label: Label, (mark, style): (Mark, ShapeStyle), size: f64) -> Self {
        let (middle, lower) = (units(0.5 * SAMPLE * size), units(MIDDLE * size));
        let sample: Sample =
            Box::new(move |(x, y)| marker((x + middle, y + lower), mark, size, style));
        Entry { label, sample }
    }
}

/// Draws entries from a place down, in as many columns as there is room for, and gives where they end.
///
/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw_legend<'a>(
    page: &Page<'a>,
    entries: Vec<Entry<'a>>,
    [left, top]: [f64; 2],
    size: f64,
) -> Result<f64, FigureError> {
    let (width, height) = page.dim_in_pixel();
    let [width, height] = [width, height].map(in_pixels);
    let right = width - left;
    let widths = entries.iter().map(|entry| entry.label.width(size));
    let column = (SAMPLE + SPACE + GAP) * size + widths.fold(0.0, f64::max);
    let room = right - left;
    let columns = (((room + GAP * size) / column) as usize).clamp(1, entries.len().max(1));
    let rows = entries.len().div_ceil(columns);
    let most = room - (SAMPLE + SPACE) * size;
    let mut entries = entries.into_iter();
    let mut bottom = top;
    for number in 0..columns {
        let corner = [left + column * number as f64, top];
        let place = Rectangle::new(corner, [right - corner[0], height - top]);
        let mut chart =
            ChartBuilder::on(&part(page, place)).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        let mut lines = 0;
        for Entry { label, sample } in entries.by_ref().take(rows) {
            let mut sample = Some(sample);
            for line in label.wrapped(size, most) {
                let nothing = std::iter::empty::<PathElement<(f64, f64)>>();
                let series = chart.draw_series(nothing)?.label(line);
                if let Some(sample) = sample.take() {
                    series.legend(sample);
                }
                lines += 1;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::Coordinate(0, 0))
            .margin(0)
            .legend_area_size(units((SAMPLE + SPACE) * size))
            .label_font(font(size))
            .draw()?;
        bottom = f64::max(bottom, top + f64::from(lines) * LINE * size);
    }
    Ok(bottom)
}
