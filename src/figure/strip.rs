//! Pictures of states beside each other, for one run or for several under each other.

use super::data::{Field, Snapshot};
use super::drawing::{Drawing, Rectangle};
use super::number::number;
use super::panel::{self, Numbers, Style};
use super::text::{Across, Along, Label, line_height};
use super::{FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use crate::fem::Mesh;

/// A run's strip.
pub(super) struct Strip<'a> {
    pub title: Label,
    pub mesh: &'a Mesh,
    pub snapshots: Vec<&'a Snapshot>,
}

/// Digits of a time above a picture.
const TIME_DIGITS: usize = 4;

fn time_label(t: f64) -> Label {
    Label::symbol("t")
        .and(" = ")
        .and_label(number(t, TIME_DIGITS))
}

/// Draws the strips under each other, with one scale of colours.
///
/// # Errors
/// [`FigureError::Memory`].
pub(super) fn draw(strips: &[Strip], options: &FigureOptions) -> Result<Drawing, FigureError> {
    let states = || strips.iter().flat_map(|strip| &strip.snapshots);
    let scale = panel::scale(
        states().map(|snapshot| &*snapshot.state),
        Field::Phase,
        options.colours,
    );
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    let style = Style {
        scale: &scale,
        field: Field::Phase,
        director: options.director,
        size,
    };
    let name = Label::symbol("φ");
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 1.7 * size);
    let bar = panel::bar_room(&scale, size, &name);
    let left = margin + panel::left_room(size);
    let room = width - left - gap - bar - margin;

    let widest_title = states()
        .map(|snapshot| time_label(snapshot.t).width(size))
        .fold(0.0, f64::max);
    let least_side = (widest_title + 0.3 * size).max(5.0 * size);
    let most = strips
        .iter()
        .map(|strip| strip.snapshots.len())
        .max()
        .unwrap_or(1)
        .max(1);
    let side_of = |columns: usize| (room - gap * (columns as f64 - 1.0)) / columns as f64;
    let columns = (1..=most)
        .rev()
        .find(|&columns| side_of(columns) >= least_side)
        .unwrap_or(1);
    // Lines of much the same length: of five, three and two, not four and one.
    let columns = most.div_ceil(most.div_ceil(columns));
    // Two or three pictures alone are not to fill the width.
    let side = side_of(columns.max(most.min(3))).floor();

    let mut drawing = Drawing {
        width: options.width,
        ..Drawing::default()
    };
    let mut top = margin;
    for (number, strip) in strips.iter().enumerate() {
        for line in strip.title.wrapped(size, width - 2.0 * margin) {
            drawing.label(&line, size, [margin, top], Across::Left, Along::Top);
            top += line_height(size);
        }
        top += 0.25 * size;
        let lines = strip.snapshots.chunks(columns);
        let count = lines.len();
        for (line, snapshots) in lines.enumerate() {
            top += 1.35 * size;
            let is_last = line + 1 == count;
            let numbers_below = count > 1 || number + 1 == strips.len();
            let mut place = Rectangle {
                left,
                top,
                right: left + side,
                bottom: top + side,
            };
            for (column, snapshot) in snapshots.iter().enumerate() {
                place.left = left + column as f64 * (side + gap);
                place.right = place.left + side;
                let square = place.on_pixels();
                panel::draw(&mut drawing, square, strip.mesh, &snapshot.state, &style)?;
                let numbers = Numbers {
                    left: column == 0,
                    below: numbers_below,
                };
                panel::draw_axes(&mut drawing, square, strip.mesh, size, numbers);
                let at = [0.5 * (square.left + square.right), top - 1.35 * size];
                let title = time_label(snapshot.t);
                drawing.label(&title, size, at, Across::Middle, Along::Top);
            }
            if line == 0 {
                let corner = [left + columns as f64 * (side + gap), top.round()];
                panel::draw_bar(&mut drawing, &scale, corner, side.round(), size, &name);
            }
            top += side;
            top += match numbers_below {
                true => panel::lower_room(size) + if is_last { 0.0 } else { 0.5 * size },
                false => 0.5 * size,
            };
        }
        top += 0.6 * size;
    }
    drawing.height = top.ceil() as u32;
    Ok(drawing)
}
