//! Pictures of states beside each other, for one run or for several under each other.

use super::axes::{Axes, lower_room};
use super::canvas::{Drawing, Rectangle, write_label, write_paragraph};
use super::data::{Field, Snapshot};
use super::number::{letter, number};
use super::panel::{self, Style};
use super::sampling::Frame;
use super::text::Label;
use super::{FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use crate::fem::Mesh;
use crate::scene::Geometry;
use crate::theory::ShapeAtRest;
use plotters::style::text_anchor::{HPos, VPos};

/// A run's strip.
pub(super) struct Strip<'a> {
    pub title: Label,
    pub snapshots: Vec<&'a Snapshot>,
    pub theory: Option<&'a ShapeAtRest>,
}

/// A picture is at most so high for its width: the vesicle is seen with what is around it.
const LEAST_ASPECT: f64 = 0.6;

/// A picture is at least so wide and so high, in sizes of the text: the numbers of its axes and of the colour bar beside
/// it have room.
const LEAST_SIDES: [f64; 2] = [5.0, 3.6];

/// Digits of a time above a picture.
const TIME_DIGITS: usize = 4;

/// The letter of a picture and its time.
fn time_label(picture: usize, t: f64) -> Label {
    letter(picture)
        .and_symbol("t")
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
    let meshes = || states().map(|snapshot| &*snapshot.mesh);
    let domains = meshes().map(Mesh::section_box);
    let Some(domain) = domains.reduce(|one, other| one.union(&other)) else {
        return Drawing::compose(options.width, |_| Ok(1.0));
    };
    let shown = strips.iter().flat_map(|strip| {
        let states = strip.snapshots.iter();
        states.map(|snapshot| (&*snapshot.mesh, &*snapshot.state, strip.theory))
    });
    let frame = Frame::around(&domain, shown, options.zoom, LEAST_ASPECT);
    let style = Style {
        scale: &scale,
        field: Field::Phase,
        director: options.director,
        frame,
        size,
    };
    let name = Label::symbol("φ");
    let (width, margin, gap) = (f64::from(options.width), 0.7 * size, 1.7 * size);
    let bar = panel::bar_room(&scale, size, &name);
    let room = |left: f64| width - left - gap - bar - margin;

    let titles = (states().enumerate()).map(|(number, it)| time_label(number, it.t).width(size));
    let widest_title = titles.fold(0.0, f64::max);
    let [least_width, least_height] = LEAST_SIDES.map(|side| side * size);
    let least_side = (widest_title + 0.3 * size)
        .max(least_width)
        .max(least_height * frame.aspect());
    let counts = strips.iter().map(|strip| strip.snapshots.len());
    let most = counts.fold(1, usize::max);
    let geometry = meshes().next().map_or(Geometry::Planar, Mesh::geometry);
    let left = margin + Axes::left_room(geometry, frame, size);
    let side_of = |columns: usize| (room(left) - gap * (columns as f64 - 1.0)) / columns as f64;
    let fits = |columns: &usize| side_of(*columns) >= least_side;
    let columns = (1..=most).rev().find(fits).unwrap_or(1);
    // Lines of much the same length: of five, three and two, not four and one.
    let columns = most.div_ceil(most.div_ceil(columns));
    // Two or three pictures alone are not to fill the width.
    let side = side_of(columns.max(most.min(3))).floor();
    let height = side / frame.aspect();
    let beside = (columns > 1).then_some(gap);
    let axes = Axes::new(geometry, frame, [side, height], beside, size);

    Drawing::compose(options.width, |page| {
        let mut top = margin;
        let mut pictures = 0;
        for (number, strip) in strips.iter().enumerate() {
            let title = panel::title(&strip.title, strip.theory);
            top = write_paragraph(page, &title, size, [margin, top], width - 2.0 * margin)?;
            top += 0.25 * size;
            let lines = strip.snapshots.chunks(columns);
            let count = lines.len();
            for (line, snapshots) in lines.enumerate() {
                top += 1.35 * size;
                let is_last = line + 1 == count;
                let numbers_below = count > 1 || number + 1 == strips.len();
                for (column, snapshot) in snapshots.iter().enumerate() {
                    let left = left + column as f64 * (side + gap);
                    let area = Rectangle::new([left, top], [side, height]).on_pixels();
                    panel::draw(
                        page,
                        area,
                        &snapshot.mesh,
                        &snapshot.state,
                        strip.theory,
                        &style,
                    )?;
                    let numbers = [numbers_below, column == 0];
                    axes.draw(page, area, size, numbers)?;
                    let at = [0.5 * (area.left + area.right), top - 1.35 * size];
                    let place = (HPos::Center, VPos::Top);
                    write_label(page, &time_label(pictures, snapshot.t), size, at, place)?;
                    pictures += 1;
                }
                if line == 0 {
                    let corner = [left + columns as f64 * (side + gap), top.round()];
                    panel::draw_bar(page, &scale, corner, height.round(), size, &name)?;
                }
                top += height;
                if number + 1 == strips.len() && is_last {
                    let picture = Rectangle::new([left, top - height], [side, height]);
                    let states = states().map(|snapshot| &*snapshot.state);
                    panel::draw_unit(page, picture, [width - margin, top], states, &style)?;
                }
                top += match numbers_below {
                    true => lower_room(size) + if is_last { 0.0 } else { 0.5 * size },
                    false => 0.5 * size,
                };
            }
            top += 0.6 * size;
        }
        Ok(top)
    })
}
