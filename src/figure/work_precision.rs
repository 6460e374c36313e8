//! The work–precision diagram of a study: the error of φ against the seconds that it took, both
//! logarithmic.
//!
//! A line for each mesh through the tolerances, its spatial floor dashed; the points that no other
//! beats joined by a broad grey line; the scene's own choice a star; other steps, rules and iterations
//! open squares; a run without result a cross at the top, at the time that it took.

use super::canvas::{
    Drawing, Page, Rectangle, font, in_pixels, part, stroke, units, write_paragraph,
};
use super::colour::{GREY, LINE_COLOURS};
use super::curves::TICKS;
use super::elements::{Mark, marker};
use super::legend::{Entry, draw_legend};
use super::number::extent;
use super::panel::line_weight;
use super::provenance::Provenance;
use super::save::Files;
use super::text::{Label, line_height};
use super::{FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use crate::study::{ErrorSize, Point, StepControl, Study};
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange, LogCoord, WithKeyPoints};
use plotters::element::{EmptyElement, PathElement, Text};
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, RGBColor, ShapeStyle};
use std::iter::once;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The height of the plot to its width.
const ASPECT: f64 = 0.62;

/// Saves the diagram of a study in a folder as `<name>-accuracy` PNG and SVG, with its data as CSV and
/// JSON. Gives the files.
///
/// # Errors
/// [`FigureError`]; the files that were written before it stay.
pub fn save_study(
    study: &Study,
    name: &str,
    command: &str,
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, FigureError> {
    options.check()?;
    let stem = format!("{name}-accuracy");
    let mut files = Files::claim(folder, vec![stem], &["png", "svg", "csv", "json"], options)?;
    let stem = files.stem(0);
    let title = format!("What accuracy costs: {}", study.scene);
    let provenance = Provenance::plain(&title, command);
    // The numbers first: the picture may be what there is no memory for.
    files.text(&stem, "csv", &study.to_csv())?;
    let mut json = serde_json::to_string_pretty(study).unwrap_or_default();
    json.push('\n');
    files.text(&stem, "json", &json)?;
    let words = |cells: usize| (cells, study.mesh_words(cells));
    let diagram = Diagram {
        title,
        points: &study.points,
        floors: &study.floors,
        meshes: study.meshes().into_iter().map(words).collect(),
        size: text_size(options.width, TEXT_SIZES_A_WIDTH),
    };
    files.picture(&stem, &diagram.draw(options.width)?, options, &provenance)?;
    Ok(files.written)
}

/// An axis of powers of ten.
#[derive(Debug, Clone, Copy)]
struct Decades {
    low: i32,
    high: i32,
}

/// The powers of ten that are numbers as precise as others.
const DECADES: std::ops::RangeInclusive<i32> = -307..=308;

impl Decades {
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let Some([low, high]) = extent(values.map(f64::log10)) else {
            return Self { low: -1, high: 0 };
        };
        let (least, most) = (*DECADES.start(), *DECADES.end());
        let low = ((low - 0.05).floor() as i32).clamp(least, most - 1);
        Self {
            low,
            high: ((high + 0.05).ceil() as i32).clamp(low + 1, most),
        }
    }

    /// The values at its ends.
    fn range(&self) -> Range<f64> {
        10_f64.powi(self.low)..10_f64.powi(self.high)
    }

    /// A value on the axis. What is beyond an end, as a time of zero is, stands at the end.
    fn on_axis(&self, value: f64) -> f64 {
        let Range { start, end } = self.range();
        if value.is_nan() {
            return start;
        }
        value.clamp(start, end)
    }

    /// The powers of ten that have a number, if there is room for `most` of them, and the values between
    /// them that have a line.
    fn ticks(&self, most: f64) -> (Vec<f64>, Vec<f64>) {
        let decades = f64::from(self.high - self.low);
        // The cast saturates.
        let stride = (decades / most.max(1.0)).ceil().max(1.0) as usize;
        let power = |exponent: i32| 10_f64.powi(exponent);
        let numbers = (self.low..=self.high).step_by(stride).map(power).collect();
        let parts = (self.low..self.high)
            .filter(|_| stride == 1)
            .flat_map(|exponent| (2..10).map(move |part| f64::from(part) * power(exponent)));
        (numbers, parts.collect())
    }

    /// For plotters, with room for so many numbers.
    fn coordinate(&self, most: f64) -> WithKeyPoints<LogCoord<f64>> {
        let (numbers, parts) = self.ticks(most);
        let logarithmic = self.range().log_scale();
        logarithmic
            .with_key_points(numbers)
            .with_light_points(parts)
    }
}

/// A power of ten as print has it.
fn power_label(value: &f64) -> String {
    let exponent = value.log10().round().to_string().replace('-', "−");
    Label::text("10").above(&exponent).into()
}

/// Behind the points: the Pareto front, the lines at powers of ten, those between.
const FRONT: RGBColor = RGBColor(205, 205, 205);
const BOLD: RGBColor = RGBColor(222, 222, 222);
const LIGHT: RGBColor = RGBColor(242, 242, 242);

/// The room for the numbers at the left, in sizes of the text.
const LEFT_ROOM: f64 = 4.5;
/// For those below, and the name of the axis.
const LOWER_ROOM: f64 = 3.6;

/// What is drawn of a study.
struct Diagram<'a> {
    title: String,
    points: &'a [Point],
    floors: &'a [(usize, ErrorSize)],
    /// Each mesh by its 1/h, and in words.
    meshes: Vec<(usize, String)>,
    /// The size of the text.
    size: f64,
}

impl Diagram<'_> {
    fn draw(&self, width: u32) -> Result<Drawing, FigureError> {
        let size = self.size;
        let margin = 0.7 * size;
        let (left, right) = (margin, f64::from(width) - 2.0 * margin);
        Drawing::compose(width, |page| {
            let title = Label::text(&self.title);
            let mut top = write_paragraph(page, &title, size, [left, margin], right)?;
            top = draw_legend(page, self.entries(), [left, top + 0.2 * size], size)?;
            let name = Label::text("error of ")
                .and_symbol("φ")
                .and(" at the end, in L2");
            let at = [left + LEFT_ROOM * size, top + 0.5 * size];
            top = write_paragraph(page, &name, size, at, right - at[0])?;
            let width = right - at[0];
            let plot = Rectangle::new([at[0], top], [width, ASPECT * width]).on_pixels();
            let place = plot.with_room([LEFT_ROOM * size, 0.0, LOWER_ROOM * size]);
            self.draw_chart(&part(page, place))?;
            Ok(place.bottom + margin)
        })
    }

    fn colour(&self, cells: usize) -> RGBColor {
        let number = self.meshes.iter().position(|(mesh, _)| *mesh == cells);
        LINE_COLOURS[number.unwrap_or(0) % LINE_COLOURS.len()]
    }

    /// A line so many times as wide as others.
    fn stroke(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        stroke(colour, width * line_weight(self.size))
    }

    /// The lengths in units of a dash of a floor and of the space after it.
    fn dashes(&self) -> [i32; 2] {
        [units(0.5 * self.size); 2]
    }

    /// How a point is drawn in the colour of its mesh.
    fn mark(&self, point: &Point, colour: RGBColor) -> (Mark, ShapeStyle) {
        match point.error() {
            None => (Mark::Cross, self.stroke(colour, 1.6)),
            Some(_) if point.is_own => (Mark::Star, colour.filled()),
            Some(_) if point.run.is_some() => (Mark::Disc, BLACK.filled()),
            Some(_) if self.is_plain(point) => (Mark::Disc, colour.filled()),
            Some(_) => (Mark::Square, self.stroke(colour, 1.4)),
        }
    }

    /// Whether a point belongs to the line of its mesh.
    fn is_plain(&self, point: &Point) -> bool {
        let first = self.points.first();
        point.run.is_none()
            && matches!(point.pace, StepControl::Tolerance(_))
            && first.is_some_and(|first| {
                (first.quadrature, first.iteration) == (point.quadrature, point.iteration)
            })
    }

    /// What the lines and marks stand for that are in the chart.
    fn entries<'e>(&self) -> Vec<Entry<'e>> {
        let size = self.size;
        let line =
            |words: &str, dashes, style| Entry::line(Label::text(words), dashes, style, size);
        let mut entries = Vec::new();
        for (cells, words) in &self.meshes {
            entries.push(line(words, None, self.stroke(self.colour(*cells), 1.6)));
        }
        if !self.floors.is_empty() {
            let style = self.stroke(GREY, 0.8);
            entries.push(line("floor of the mesh", Some(self.dashes()), style));
        }
        if self.points.iter().any(|point| point.is_pareto) {
            entries.push(line("Pareto front", None, self.stroke(FRONT, 5.0)));
        }
        for (words, wanted) in [
            ("the scene’s own", (Mark::Star, GREY.filled())),
            (
                "other steps, rule or iteration",
                (Mark::Square, self.stroke(GREY, 1.4)),
            ),
            ("a finished run, named", (Mark::Disc, BLACK.filled())),
            ("no result", (Mark::Cross, self.stroke(GREY, 1.6))),
        ] {
            if self
                .points
                .iter()
                .any(|point| self.mark(point, GREY) == wanted)
            {
                entries.push(Entry::mark(Label::text(words), wanted, size));
            }
        }
        entries
    }

    fn draw_chart(&self, page: &Page) -> Result<(), FigureError> {
        let size = self.size;
        let seconds = Decades::around(self.points.iter().map(|point| point.seconds));
        let floors = self.floors.iter().map(|(_, floor)| *floor);
        let errors = self.points.iter().filter_map(Point::error).chain(floors);
        let errors = Decades::around(errors.map(ErrorSize::get));
        let (width, height) = page.dim_in_pixel();
        let [width, height] = [width, height].map(in_pixels);
        let mut chart = ChartBuilder::on(page)
            .y_label_area_size(units(LEFT_ROOM * size))
            .x_label_area_size(units(LOWER_ROOM * size))
            .build_cartesian_2d(
                seconds.coordinate(width / (3.5 * size)),
                errors.coordinate(height / (1.3 * line_height(size))),
            )?;
        let thin = self.stroke(BLACK, 0.8);
        chart
            .configure_mesh()
            .bold_line_style(self.stroke(BOLD, 0.8))
            .light_line_style(self.stroke(LIGHT, 0.8))
            .axis_style(thin)
            .label_style(font(size))
            .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
            .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
            .x_label_formatter(&power_label)
            .y_label_formatter(&power_label)
            .x_desc("computing time in seconds")
            .draw()?;
        let (across, along) = (seconds.range(), errors.range());
        let at = |point: &Point| {
            let error = point.error()?.get();
            Some((seconds.on_axis(point.seconds), errors.on_axis(error)))
        };
        // In the order of their times.
        let joined = |is_on: &dyn Fn(&Point) -> bool| {
            let points = self.points.iter().filter(|point| is_on(point));
            let mut line: Vec<(f64, f64)> = points.filter_map(at).collect();
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            line
        };
        let front = joined(&|point| point.is_pareto);
        chart.draw_series(LineSeries::new(front, self.stroke(FRONT, 5.0)))?;
        for &(cells, _) in &self.meshes {
            let colour = self.colour(cells);
            if let Some((_, floor)) = self.floors.iter().find(|(mesh, _)| *mesh == cells) {
                let floor = errors.on_axis(floor.get());
                let ends = [(across.start, floor), (across.end, floor)];
                let ([dash, space], style) = (self.dashes(), self.stroke(colour, 0.8));
                chart.draw_series(DashedLineSeries::new(ends, dash, space, style))?;
            }
            let points = joined(&|point| point.cells == cells && self.is_plain(point));
            chart.draw_series(LineSeries::new(points, self.stroke(colour, 1.6)))?;
        }
        for point in self.points {
            let (mark, style) = self.mark(point, self.colour(point.cells));
            // What has no error stands at the top.
            let (place, lower) = match at(point) {
                Some(place) => (place, 0.0),
                None => ((seconds.on_axis(point.seconds), along.end), 0.8),
            };
            let at = (0, units(lower * size));
            if mark == Mark::Star {
                // It stands out from the line that it is on.
                let edge = marker(at, mark, 1.35 * size, BLACK.filled());
                chart.draw_series(once(EmptyElement::at(place) + edge))?;
            }
            let marker = marker(at, mark, size, style);
            chart.draw_series(once(EmptyElement::at(place) + marker))?;
            if let Some(name) = point.run.as_ref().filter(|_| point.error().is_some()) {
                // On the side where there is room.
                let label = Label::text(name);
                let (x, _) = chart.backend_coord(&place);
                let end = chart.plotting_area().get_x_axis_pixel_range().end;
                let fits = 0.6 * size + label.width(size) < in_pixels(end - x);
                let (gap, side) = match fits {
                    true => (0.6, HPos::Left),
                    false => (-0.6, HPos::Right),
                };
                let style = font(size).pos(Pos::new(side, VPos::Center));
                let name = Text::new(String::from(label), (units(gap * size), 0), style);
                chart.draw_series(once(EmptyElement::at(place) + name))?;
            }
        }
        // plotters draws the other two sides, as axes.
        let (right, top) = (across.end, along.end);
        let sides = [(across.start, top), (right, top), (right, along.start)];
        chart.draw_series(once(PathElement::new(sides, thin)))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{WIDTHS, assert_tidy};
    use super::*;
    use crate::study::Errors;
    use plotters::coord::ranged1d::Ranged;

    #[test]
    fn decades_hold_all_values() {
        let axis = Decades::around([0.02, 3.0, 250.0, f64::NAN].into_iter());
        assert_eq!((axis.low, axis.high), (-2, 3));
        assert_eq!(axis.range(), 1e-2..1e3);
        let one = Decades::around(std::iter::once(0.5));
        assert!(one.range().start < 0.5 && one.range().end > 0.5);
        let none = Decades::around(std::iter::empty());
        assert!(none.low < none.high);
    }

    /// Nothing that is no number, nor what has no logarithm, reaches the drawing.
    #[test]
    fn every_value_has_a_place_on_the_axis() {
        let least = f64::from_bits(1);
        for ends in [
            [0.02, 250.0],
            [least, 1e-300],
            [1e300, f64::MAX],
            [least, f64::MAX],
        ] {
            let axis = Decades::around(ends.into_iter());
            let limits = (0, 10_000);
            let coordinate = axis.coordinate(12.0);
            let place = |value| coordinate.map(&axis.on_axis(value), limits);
            for value in [f64::NAN, f64::INFINITY, 0.0, -1.0, least, 1e-3, f64::MAX] {
                let place = place(value);
                assert!((0..=10_000).contains(&place), "{value} at {place}");
            }
            assert_eq!([f64::NAN, 0.0, f64::INFINITY].map(place), [0, 0, 10_000]);
            assert!(place(ends[0]) < place(ends[1]));
            let (numbers, parts) = axis.ticks(12.0);
            assert!(numbers.len() <= 13 && parts.len() <= 12 * 8, "{ends:?}");
        }
    }

    fn point(cells: usize, seconds: f64, error: f64) -> Point {
        let phase = ErrorSize::new(error);
        Point {
            cells,
            mesh: format!("{cells} cells"),
            nodes: 0,
            pace: StepControl::Tolerance(1e-3),
            quadrature: "consistent",
            iteration: "newton",
            run: None,
            is_own: false,
            seconds,
            memory: None,
            steps: 0,
            refused: 0,
            newton: 0,
            krylov: 0,
            errors: phase.is_some().then_some(Errors {
                phase,
                membrane: None,
                director: None,
                energy: None,
                surface_area: None,
            }),
            time_error: None,
            estimated_time: None,
            estimated_space: None,
            estimated_algebra: None,
            failure: None,
            is_pareto: true,
        }
    }

    /// Every kind of mark and line, and values that have no logarithm.
    #[test]
    fn the_diagram_has_a_place_for_everything() {
        let plain = [
            (60, 3.0, 0.03),
            (60, 9.0, 0.02),
            (120, 20.0, 8e-3),
            (120, 70.0, 3e-3),
        ];
        let mut points: Vec<Point> = plain.map(|(cells, s, e)| point(cells, s, e)).into();
        points.push(point(120, f64::NAN, 0.01));
        points.push(point(60, 0.0, f64::INFINITY));
        points.push(point(60, 30.0, 0.0));
        let own = points[2].clone();
        points.push(Point {
            is_own: true,
            ..own
        });
        let stepped = Point {
            pace: StepControl::Step(1e-7),
            is_pareto: false,
            ..point(60, 40.0, 0.05)
        };
        points.push(stepped);
        for (name, seconds) in [("left", 5.0), ("a run with a long name", 90.0)] {
            let run = Some(name.to_owned());
            points.push(Point {
                run,
                ..point(120, seconds, 0.01)
            });
        }
        let floors = [(60, 0.015), (120, f64::from_bits(1))];
        let floors = floors.map(|(cells, floor)| (cells, ErrorSize::new(floor).expect("one")));
        for (width, floors) in WIDTHS
            .into_iter()
            .flat_map(|it| [(it, &floors[..1]), (it, &floors)])
        {
            let diagram = Diagram {
                title: "What accuracy costs: Case 3".to_owned(),
                points: &points,
                floors,
                meshes: [60, 120]
                    .map(|cells| (cells, format!("h = 1/{cells}")))
                    .into(),
                size: text_size(width, TEXT_SIZES_A_WIDTH),
            };
            let drawing = diagram.draw(width).expect("it is drawn");
            if floors.len() == 1 {
                assert_tidy("diagram", &drawing);
            }
            let entries = [
                "h = 1/60",
                "floor of the mesh",
                "Pareto front",
                "the scene’s own",
                "other steps, rule or iteration",
                "a finished run, named",
                "no result",
                "left",
                "a run with a long name",
            ];
            for entry in entries {
                assert!(
                    drawing.texts.iter().any(|text| text.text == entry),
                    "{entry}"
                );
            }
            let of = |cells| {
                let colour = diagram.colour(cells);
                drawing
                    .shapes
                    .iter()
                    .filter(|shape| shape.colour == colour)
                    .count()
            };
            assert!(of(60) > 10 && of(120) > 5, "lines, dashes and marks");
        }
        let nothing = Diagram {
            title: String::new(),
            points: &[],
            floors: &[],
            meshes: Vec::new(),
            size: 20.0,
        };
        assert!(nothing.draw(1000).is_ok());
    }
}
