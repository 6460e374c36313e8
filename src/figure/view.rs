//! The picture of one state alone.

use super::axes::{Axes, lower_room};
use super::canvas::{Drawing, Rectangle, write_paragraph};
use super::data::{RunLabel, View};
use super::number::number;
use super::panel::{self, Style};
use super::sampling::Frame;
use super::text::Label;
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
    let shown = [(view.mesh, view.state, view.theory)];
    let frame = Frame::around(&view.mesh.section_box(), shown, options.zoom, 1.0);
    let style = Style {
        scale: &scale,
        field: view.field,
        director: options.director,
        frame,
        size,
    };
    let name = panel::symbol(view.state, view.field);
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 0.9 * size);
    let geometry = view.mesh.geometry();
    let left = margin + Axes::left_room(geometry, frame, size);
    let bar = panel::bar_room(&scale, size, &name);
    let side = (width - left - gap - bar - margin).floor();
    let sides = [side, side / frame.aspect()];
    let axes = Axes::new(geometry, frame, sides, None, size);

    let energy = Label::symbol("E")
        .below("total")
        .and(" = ")
        .and_label(number(view.report.total_energy, 6));
    let time = Label::symbol("t")
        .and(" = ")
        .and_label(number(view.report.t, 6))
        .and(&format!(", step {}, ", view.report.step))
        .and_label(energy);
    Drawing::compose(options.width, |page| {
        let mut top = margin;
        let title = panel::title(&Label::text(&label.title), view.theory);
        for label in [title, time] {
            top = write_paragraph(page, &label, size, [margin, top], width - 2.0 * margin)?;
        }
        // The name of the colour bar stands above it.
        top += 1.2 * size;
        let place = Rectangle::new([left, top], sides).on_pixels();
        panel::draw(page, place, view.mesh, view.state, view.theory, &style)?;
        axes.draw(page, place, size, [true; 2])?;
        let corner = [place.right + gap, place.top];
        panel::draw_bar(page, &scale, corner, place.height(), size, &name)?;
        let end = [width - margin, place.bottom];
        panel::draw_unit(page, place, end, std::iter::once(view.state), &style)?;
        Ok(place.bottom + lower_room(size) + margin)
    })
}
