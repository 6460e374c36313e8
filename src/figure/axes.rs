//! The axes of a picture: where its ticks stand, and which of them have numbers.

use super::FigureError;
use super::canvas::{Page, Rectangle, draw_line, write_label};
use super::number::Axis;
use super::panel::line_weight;
use super::sampling::Frame;
use super::text::{Label, line_height};
use crate::scene::Geometry;
use plotters::style::text_anchor::{HPos, VPos};

/// How long ticks are, in sizes of the text.
const TICK: f64 = 0.28;
/// Between a tick and its number at the side.
const TICK_GAP: f64 = 0.25;
/// Between a tick and its number below.
const NUMBER_GAP: f64 = 0.4;
/// An axis has a tick for each length of this many sizes of the text, if that gives it two numbers.
const TICK_ROOM: f64 = 2.6;
/// The greatest number of ticks on an axis. With it every range has at least two.
const MOST_TICKS: usize = 6;
/// The least gap between two numbers that stand side by side, in sizes of the text: the width of a digit.
const NUMBERS_APART: f64 = 0.6;

/// The axes of a picture: where its ticks stand, and which of them have numbers.
pub(super) struct Axes {
    of: [Numbered; 2],
    names: [&'static str; 2],
}

/// An axis, and those of its ticks that have numbers.
struct Numbered {
    axis: Axis,
    numbers: Vec<f64>,
}

impl Axes {
    /// Those of a part of the plane in a picture of this width and height, whose text has a size. With a gap another
    /// picture, with the same axes, stands so far to the right.
    pub fn new(
        geometry: Geometry,
        frame: Frame,
        sides: [f64; 2],
        gap: Option<f64>,
        size: f64,
    ) -> Self {
        let of = [0, 1].map(|number| {
            let length = sides[number];
            let room = ((length / (TICK_ROOM * size)) as usize).clamp(2, MOST_TICKS);
            let with_numbers = |most: usize| {
                let axis = axis(frame, number, most);
                let numbers = match number {
                    0 => {
                        let width =
                            |tick: f64| (axis.label(tick).width(size), NUMBERS_APART * size);
                        numbers(&axis, length, width, gap)
                    }
                    _ => numbers(&axis, length, |_| (line_height(size), 0.0), None),
                };
                Numbered { axis, numbers }
            };
            // Finer ticks where there would be one number alone: it does not tell the scale.
            let is_scale = |it: &Numbered| it.numbers.len() > 1;
            let mut choices = (room..=MOST_TICKS).map(with_numbers);
            choices.find(is_scale).unwrap_or_else(|| with_numbers(room))
        });
        let names = names(geometry);
        Self { of, names }
    }

    /// The room that the y axis takes at the left of a picture of any size.
    pub fn left_room(geometry: Geometry, frame: Frame, size: f64) -> f64 {
        let [_, name] = names(geometry);
        let room = |most: usize| {
            let axis = axis(frame, 1, most);
            axis.widest(size) + axis.name(Label::symbol(name)).width(size)
        };
        (2..=MOST_TICKS).map(room).fold(0.0, f64::max) + (TICK + 3.0 * TICK_GAP) * size
    }

    /// Draws ticks at the lower and left side of a picture; `numbers` says which of the two has numbers and a name.
    ///
    /// # Errors
    /// Those of plotters.
    pub fn draw(
        &self,
        page: &Page,
        place: Rectangle,
        size: f64,
        numbers: [bool; 2],
    ) -> Result<(), FigureError> {
        for (number, (it, name)) in self.of.iter().zip(self.names).enumerate() {
            let axis = &it.axis;
            // So many sizes of the text away from the picture.
            let at = |share: f64, out: f64| match number {
                0 => [
                    place.left + share * place.width(),
                    place.bottom + out * size,
                ],
                _ => [
                    place.left - out * size,
                    place.bottom - share * place.height(),
                ],
            };
            let gap = TICK + [NUMBER_GAP, TICK_GAP][number];
            let beside = [(HPos::Center, VPos::Top), (HPos::Right, VPos::Center)][number];
            for tick in &axis.ticks {
                let share = axis.place(*tick);
                let width = 0.8 * line_weight(size);
                draw_line(page, &[at(share, 0.0), at(share, TICK)], width)?;
            }
            if numbers[number] {
                for tick in &it.numbers {
                    let at = at(axis.place(*tick), gap);
                    write_label(page, &axis.label(*tick), size, at, beside)?;
                }
                // The axis' name stands in its middle, beyond the numbers.
                let beyond = match number {
                    0 => gap + line_height(1.0),
                    _ => gap + axis.widest(size) / size + 2.0 * TICK_GAP,
                };
                let name = axis.name(Label::symbol(name));
                write_label(page, &name, size, at(0.5, beyond), beside)?;
            }
        }
        Ok(())
    }
}

/// The room that the x axis takes below a picture.
pub(super) fn lower_room(size: f64) -> f64 {
    2.0 * line_height(size) + (TICK + NUMBER_GAP) * size
}

fn names(geometry: Geometry) -> [&'static str; 2] {
    match geometry {
        Geometry::Planar => ["x", "y"],
        Geometry::Axisymmetric => ["r", "z"],
    }
}

/// The axis of a part of the plane, with at most `most` ticks: number 0 is x, number 1 is y.
fn axis(frame: Frame, number: usize, most: usize) -> Axis {
    let low = frame.corner[number];
    Axis::new([low, low + frame.sides[number]], most)
}

/// The ticks of an axis of this length that have numbers: from the low end on, those whose number, of an extent along
/// the axis, has at least some space before it; `room` gives both for a tick. With a gap a picture with the same
/// numbers stands so far beyond the high end: there the last ones give way.
fn numbers(
    axis: &Axis,
    length: f64,
    room: impl Fn(f64) -> (f64, f64),
    gap: Option<f64>,
) -> Vec<f64> {
    let place = |tick: f64| length * axis.place(tick);
    // Whether a number and one so far on have their space.
    let are_apart = |one: f64, other: f64, distance: f64| {
        let ((before, apart), (after, _)) = (room(one), room(other));
        distance >= 0.5 * (before + after) + apart
    };
    let mut numbers: Vec<f64> = Vec::new();
    for &tick in &axis.ticks {
        let has_space = |last: &f64| are_apart(*last, tick, place(tick) - place(*last));
        if numbers.last().is_none_or(has_space) {
            numbers.push(tick);
        }
    }
    if let Some(gap) = gap {
        while let [first, .., last] = numbers[..] {
            if are_apart(last, first, length + gap + place(first) - place(last)) {
                break;
            }
            numbers.pop();
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: f64 = 10.0;

    /// The numbers in x and in y of a picture of a region, with the picture beside it so far away.
    fn written(range: [[f64; 2]; 2], sides: [f64; 2], gap: Option<f64>) -> [Vec<String>; 2] {
        let frame = Frame {
            corner: range.map(|[low, _]| low),
            sides: range.map(|[low, high]| high - low),
        };
        let axes = Axes::new(Geometry::Planar, frame, sides, gap, SIZE);
        axes.of.map(|it| {
            let label = |tick: &f64| it.axis.label(*tick).plain();
            it.numbers.iter().map(label).collect()
        })
    }

    #[test]
    fn a_number_at_the_end_gives_way_to_that_of_the_next_picture() {
        let unit = [[0.0, 1.0]; 2];
        let [x, y] = written(unit, [95.0; 2], Some(17.0));
        assert_eq!(x, ["0.0", "0.5"]);
        assert_eq!(y, ["0.0", "0.5", "1.0"], "nothing is above it");
        let [x, _] = written(unit, [95.0; 2], None);
        assert_eq!(x, ["0.0", "0.5", "1.0"], "nothing is beside it");
        let [x, _] = written(unit, [95.0; 2], Some(30.0));
        assert_eq!(x, ["0.0", "0.5", "1.0"], "it has room");
    }

    #[test]
    fn an_axis_has_two_numbers_where_two_have_room() {
        for [low, high] in [
            [0.275, 0.725],
            [0.2, 0.8],
            [0.3, 0.7],
            [0.45, 0.55],
            [0.0, 1.0],
            [0.125, 0.875],
            [-0.5, 0.5],
            [0.0, 12.4],
            [-3.0, 1.0],
        ] {
            let [x, y] = written([[low, high]; 2], [80.0, 40.0], Some(17.0));
            assert!(x.len() > 1 && y.len() > 1, "{low}, {high}: {x:?} {y:?}");
        }
    }

    #[test]
    fn numbers_that_have_no_room_are_left_out() {
        let [x, y] = written([[0.3, 0.7]; 2], [25.0, 12.0], None);
        assert_eq!((x.len(), y.len()), (1, 1), "{x:?} {y:?}");
    }
}
