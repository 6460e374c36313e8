//! The work–precision diagram of a study: the error of φ against the seconds that it took, both
//! logarithmic.
//!
//! A line for each mesh through the tolerances, its spatial floor dashed; the points that no other
//! beats joined by a broad grey line; the scene's own choice a star; other steps, rules and iterations
//! open squares; a run without result a cross at the top, at the time that it took.

use super::colour::{Colour, LINE_COLOURS};
use super::curves::dashes;
use super::drawing::{Drawing, Rectangle};
use super::panel::stroke;
use super::provenance::Provenance;
use super::save::Files;
use super::text::{Across, Along, Label, line_height};
use super::{FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use crate::study::{ErrorSize, Point, StepControl, Study};
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
    files.picture(&stem, &draw(study, &title, options), options, &provenance)?;
    Ok(files.written)
}

/// An axis of powers of ten.
#[derive(Debug, Clone, Copy)]
struct Decades {
    low: i32,
    high: i32,
}

impl Decades {
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let values = values.filter(|value| value.is_finite() && *value > 0.0);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value.log10()), high.max(value.log10()))
        });
        if low > high {
            return Self { low: -1, high: 0 };
        }
        let low = (low - 0.05).floor() as i32;
        Self {
            low,
            high: ((high + 0.05).ceil() as i32).max(low + 1),
        }
    }

    /// From 0 to 1. What is beyond an end, as a time of zero is, stands at the end.
    fn place(&self, value: f64) -> f64 {
        let share = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        if share.is_nan() {
            return 0.0;
        }
        share.clamp(0.0, 1.0)
    }

    /// The powers of ten that have a number, if there is room for `most` of them, and the values between
    /// them that have a tick.
    fn ticks(&self, most: f64) -> (Vec<i32>, Vec<f64>) {
        let decades = f64::from(self.high - self.low);
        // The cast saturates.
        let stride = (decades / most.max(1.0)).ceil().max(1.0) as usize;
        let numbers = (self.low..=self.high).step_by(stride).collect();
        let parts = (self.low..self.high)
            .filter(|_| stride == 1)
            .flat_map(|exponent| (2..10).map(move |part| f64::from(part) * 10_f64.powi(exponent)));
        (numbers, parts.collect())
    }
}

fn draw(study: &Study, title: &str, options: &FigureOptions) -> Drawing {
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    let (width, margin) = (f64::from(options.width), 0.7 * size);
    let mut drawing = Drawing {
        width: options.width,
        ..Drawing::default()
    };
    let mut top = margin;
    for line in Label::text(title).wrapped(size, width - 2.0 * margin) {
        drawing.label(&line, size, [margin, top], Across::Left, Along::Top);
        top += line_height(size);
    }
    let meshes = study.meshes();
    let colour = |cells: usize| {
        let number = meshes.iter().position(|mesh| *mesh == cells).unwrap_or(0);
        LINE_COLOURS[number % LINE_COLOURS.len()]
    };
    let mut x = margin;
    for &cells in &meshes {
        let label = Label::text(&study.mesh_words(cells));
        let middle = top + 0.56 * size;
        drawing.line(
            vec![[x, middle], [x + 1.8 * size, middle]],
            1.6 * stroke(size),
            colour(cells),
        );
        let at = [x + 2.3 * size, top];
        drawing.label(&label, size, at, Across::Left, Along::Top);
        x += 3.8 * size + label.width(size);
    }
    let notes = "star: the scene’s own; square: other steps, rule or iteration; black, named: a finished \
                 run; dashed: floor of the mesh; grey: Pareto front; cross: no result";
    top += line_height(size);
    for line in Label::text(notes).wrapped(size, width - 2.0 * margin) {
        drawing.label(&line, size, [margin, top], Across::Left, Along::Top);
        top += line_height(size);
    }
    let place = Rectangle {
        left: margin + 4.5 * size,
        top: top + 1.6 * line_height(size),
        right: width - 2.0 * margin,
        bottom: top + 1.6 * line_height(size) + ASPECT * (width - 3.0 * margin - 4.5 * size),
    }
    .on_pixels();
    let seconds = Decades::around(study.points.iter().map(|point| point.seconds));
    let floors = study.floors.iter().map(|(_, floor)| *floor);
    let errors = study.points.iter().filter_map(Point::error).chain(floors);
    let errors = Decades::around(errors.map(ErrorSize::get));
    let axes = Axes {
        place,
        seconds,
        errors,
        size,
    };
    axes.draw(&mut drawing);
    let name = Label::text("error of ")
        .and_symbol("φ")
        .and(" at the end, in L2");
    let at = [place.left, place.top - 1.3 * line_height(size)];
    drawing.label(&name, size, at, Across::Left, Along::Top);
    let at = [0.5 * (place.left + place.right), place.bottom + 1.9 * size];
    let name = Label::text("computing time in seconds");
    drawing.label(&name, size, at, Across::Middle, Along::Top);

    axes.draw_points(&mut drawing, study, &meshes, colour);
    drawing.line(place.corners().to_vec(), 0.8 * stroke(size), Colour::BLACK);
    drawing.height = (place.bottom + 2.2 * size + line_height(size) + margin).ceil() as u32;
    drawing
}

/// Where things are.
struct Axes {
    place: Rectangle,
    seconds: Decades,
    errors: Decades,
    size: f64,
}

impl Axes {
    fn at(&self, seconds: f64, error: f64) -> [f64; 2] {
        [
            self.place.left + self.seconds.place(seconds) * self.place.width(),
            self.place.bottom - self.errors.place(error) * self.place.height(),
        ]
    }

    /// Ticks with their numbers at powers of ten, shorter ones between.
    fn draw(&self, drawing: &mut Drawing) {
        let Self { place, size, .. } = *self;
        let thin = 0.8 * stroke(size);
        let power = |exponent: i32| {
            let digits = exponent.to_string().replace('-', "−");
            Label::text("10").above(&digits)
        };
        let (exponents, parts) = self.seconds.ticks(place.width() / (3.5 * size));
        let mut tick = |value: f64, length: f64| {
            let [x, _] = self.at(value, 1.0);
            let ends = vec![[x, place.bottom], [x, place.bottom + length * size]];
            drawing.line(ends, thin, Colour::BLACK);
            [x, place.bottom + 0.5 * size]
        };
        parts.into_iter().for_each(|value| {
            tick(value, 0.2);
        });
        let places: Vec<_> = exponents
            .iter()
            .map(|it| tick(10_f64.powi(*it), 0.4))
            .collect();
        for (exponent, at) in exponents.into_iter().zip(places) {
            drawing.label(&power(exponent), size, at, Across::Middle, Along::Top);
        }
        let (exponents, parts) = self
            .errors
            .ticks(place.height() / (1.3 * line_height(size)));
        let mut tick = |value: f64, length: f64| {
            let [_, y] = self.at(1.0, value);
            let ends = vec![[place.left, y], [place.left - length * size, y]];
            drawing.line(ends, thin, Colour::BLACK);
            [place.left - 0.6 * size, y]
        };
        parts.into_iter().for_each(|value| {
            tick(value, 0.2);
        });
        let places: Vec<_> = exponents
            .iter()
            .map(|it| tick(10_f64.powi(*it), 0.4))
            .collect();
        for (exponent, at) in exponents.into_iter().zip(places) {
            drawing.label(&power(exponent), size, at, Across::Right, Along::Middle);
        }
    }

    /// A name beside a point, on the side where there is room.
    fn name(&self, drawing: &mut Drawing, name: &str, [x, y]: [f64; 2]) {
        let label = Label::text(name);
        let gap = 0.6 * self.size;
        let fits = x + gap + label.width(self.size) < self.place.right;
        let (x, across) = if fits {
            (x + gap, Across::Left)
        } else {
            (x - gap, Across::Right)
        };
        drawing.label(&label, self.size, [x, y], across, Along::Middle);
    }

    fn draw_points(
        &self,
        drawing: &mut Drawing,
        study: &Study,
        meshes: &[usize],
        colour: impl Fn(usize) -> Colour,
    ) {
        let size = self.size;
        let mut front: Vec<(f64, f64)> = study
            .points
            .iter()
            .filter(|point| point.is_pareto)
            .filter_map(|point| Some((point.seconds, point.error()?.get())))
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        let front = front
            .into_iter()
            .map(|(seconds, error)| self.at(seconds, error));
        let light = Colour([205, 205, 205]);
        drawing.line(front.collect(), 5.0 * stroke(size), light);
        for &cells in meshes {
            let floor = study.floors.iter().find(|(mesh, _)| *mesh == cells);
            if let Some((_, floor)) = floor {
                let [_, y] = self.at(1.0, floor.get());
                let line = [[self.place.left, y], [self.place.right, y]];
                for dash in dashes(&line, &[0.5 * size, 0.5 * size]) {
                    drawing.line(dash, 0.8 * stroke(size), colour(cells));
                }
            }
            let mut line: Vec<(f64, [f64; 2])> = study
                .points
                .iter()
                .filter(|point| point.cells == cells && is_plain(study, point))
                .filter_map(|point| {
                    let error = point.error()?.get();
                    Some((point.seconds, self.at(point.seconds, error)))
                })
                .collect();
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            let line = line.into_iter().map(|(_, at)| at).collect();
            drawing.line(line, 1.6 * stroke(size), colour(cells));
        }
        for point in &study.points {
            let colour = colour(point.cells);
            let Some(error) = point.error() else {
                let [x, _] = self.at(point.seconds, 1.0);
                let y = self.place.top + 0.8 * size;
                let arm = 0.35 * size;
                for sign in [1.0, -1.0] {
                    let cross = vec![[x - arm, y - sign * arm], [x + arm, y + sign * arm]];
                    drawing.line(cross, 1.6 * stroke(size), colour);
                }
                continue;
            };
            let at = self.at(point.seconds, error.get());
            match &point.run {
                Some(run) => {
                    drawing.polygon(disc(at, 0.3 * size), Colour::BLACK);
                    self.name(drawing, run, at);
                }
                None if point.is_own => {}
                None if is_plain(study, point) => drawing.polygon(disc(at, 0.3 * size), colour),
                None => drawing.line(square(at, 0.3 * size), 1.4 * stroke(size), colour),
            }
            if point.is_own {
                drawing.polygon(star(at, 0.75 * size), Colour::BLACK);
                drawing.polygon(star(at, 0.55 * size), colour);
            }
        }
    }
}

/// Whether a point belongs to the line of its mesh.
fn is_plain(study: &Study, point: &Point) -> bool {
    let first = study.points.first();
    point.run.is_none()
        && matches!(point.pace, StepControl::Tolerance(_))
        && first.is_some_and(|first| {
            (first.quadrature, first.iteration) == (point.quadrature, point.iteration)
        })
}

fn around([x, y]: [f64; 2], corners: usize, radius: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    let corner = |number: usize| {
        let angle = std::f64::consts::TAU * number as f64 / corners as f64;
        let radius = radius(number);
        [x + radius * angle.sin(), y - radius * angle.cos()]
    };
    (0..=corners).map(corner).collect()
}

fn disc(at: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    around(at, 16, |_| radius)
}

fn star(at: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    around(at, 10, |number| {
        if number % 2 == 0 {
            radius
        } else {
            0.42 * radius
        }
    })
}

fn square([x, y]: [f64; 2], half: f64) -> Vec<[f64; 2]> {
    [
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [-1.0, 1.0],
        [-1.0, -1.0],
    ]
    .map(|[across, along]| [x + half * across, y + half * along])
    .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_hold_all_values() {
        let axis = Decades::around([0.02, 3.0, 250.0, f64::NAN].into_iter());
        assert_eq!((axis.low, axis.high), (-2, 3));
        assert_eq!(axis.place(1e-2), 0.0);
        assert_eq!(axis.place(1e3), 1.0);
        let one = Decades::around(std::iter::once(0.5));
        assert!(one.place(0.5) > 0.0 && one.place(0.5) < 1.0);
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
            for value in [f64::NAN, f64::INFINITY, 0.0, -1.0, least, 1e-3, f64::MAX] {
                let place = axis.place(value);
                assert!((0.0..=1.0).contains(&place), "{value} at {place}");
            }
            assert!(axis.place(ends[0]) < axis.place(ends[1]));
            let (numbers, parts) = axis.ticks(12.0);
            assert!(numbers.len() <= 13 && parts.len() <= 12 * 8, "{ends:?}");
        }
    }
}
