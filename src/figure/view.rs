//! The picture of one state alone.

use super::data::{RunLabel, View};
use super::drawing::{Drawing, Rectangle};
use super::number::number;
use super::panel::{self, Numbers, Style};
use super::text::{Across, Along, Label, line_height};
use super::{FigureError, FigureOptions, VIEW_TEXT_SIZES_A_WIDTH, text_size};

/// Draws the view, with its title and its time above.
///
/// # Errors
/// [`FigureError::Memory`].
pub(super) fn draw(
    view: &View,
    label: &RunLabel,
    options: &FigureOptions,
) -> Result<Drawing, FigureError> {
    let size = text_size(options.width, VIEW_TEXT_SIZES_A_WIDTH);
    let scale = panel::scale(std::iter::once(view.state), view.field, options.colours);
    let style = Style {
        scale: &scale,
        field: view.field,
        director: options.director,
        size,
    };
    let name = panel::symbol(view.state, view.field);
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 0.9 * size);
    let left = margin + panel::left_room(size);
    let bar = panel::bar_room(&scale, size, &name);
    let side = (width - left - gap - bar - margin).floor();

    let mut drawing = Drawing {
        width: options.width,
        ..Drawing::default()
    };
    let mut top = margin;
    let energy = Label::symbol("E")
        .below("total")
        .and(" = ")
        .and_label(number(view.report.total_energy, 6));
    let time = Label::symbol("t")
        .and(" = ")
        .and_label(number(view.report.t, 6))
        .and(&format!(", step {}, ", view.report.step))
        .and_label(energy);
    for label in [Label::text(&label.title), time] {
        for line in label.wrapped(size, width - 2.0 * margin) {
            drawing.label(&line, size, [margin, top], Across::Left, Along::Top);
            top += line_height(size);
        }
    }
    // The name of the colour bar stands above it.
    top += 1.2 * size;
    let square = Rectangle {
        left,
        top,
        right: left + side,
        bottom: top + side,
    }
    .on_pixels();
    panel::draw(&mut drawing, square, view.mesh, view.state, &style)?;
    let numbers = Numbers {
        left: true,
        below: true,
    };
    panel::draw_axes(&mut drawing, square, view.mesh, size, numbers);
    let corner = [square.right + gap, square.top];
    panel::draw_bar(&mut drawing, &scale, corner, square.height(), size, &name);
    drawing.height = (square.bottom + panel::lower_room(size) + margin).ceil() as u32;
    Ok(drawing)
}
