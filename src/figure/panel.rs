//! The picture of a state: a field in colour, the membrane, the director.

use super::canvas::{
    Image, Page, Rectangle, draw_line, font, part, pieces, stroke, units, write_label,
};
use super::colour::Scale;
use super::data::Field;
use super::elements::{arrow, raster};
use super::number::{Axis, extent, number};
use super::outline::chain;
use super::sampling::{Frame, sample, sample_each};
use super::text::Label;
use super::{Director, FigureError, needs};
use crate::fem::{Contour, Mesh, Wall};
use crate::geometry::BoundingBox;
use crate::physics::bending_energy_density;
use crate::scene::Geometry;
use crate::scheme::State;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::PathElement;
use plotters::series::LineSeries;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, ShapeStyle, WHITE};
use std::borrow::Cow;
use std::iter::once;

/// A picture is sampled at so many points a side at least: an SVG may be shown larger.
const LEAST_SAMPLES: f64 = 480.0;
/// An arrow of a unit vector, in steps of its lattice.
const ARROW: f64 = 0.82;
/// No arrow is longer, in steps of its lattice.
const LONGEST: f64 = 1.3;
/// How much finer than the lattice the inside is known.
const FINER: usize = 8;
/// Shorter ones are not drawn: they have no direction to see.
const SHORTEST: f64 = 0.05;

/// How the pictures of a figure are drawn: the same for all in it.
pub(super) struct Style<'a> {
    pub scale: &'a Scale,
    pub field: Field,
    pub director: Director,
    /// The size of the text.
    pub size: f64,
}

/// The width of a line of weight 1 in a picture whose text has this size.
pub(super) fn line_weight(size: f64) -> f64 {
    (size / 18.0).max(0.6)
}

/// The nodal values of a field.
pub(super) fn values(state: &State, field: Field) -> Cow<'_, [f64]> {
    match (field, &state.director) {
        (Field::DirectorLength, Some([x, y])) => {
            x.iter().zip(y).map(|(x, y)| x.hypot(*y)).collect()
        }
        (Field::Phase | Field::DirectorLength, _) => Cow::Borrowed(&state.phi),
        (Field::Bending, _) => Cow::Borrowed(&state.omega),
        (Field::Potential, _) => Cow::Borrowed(&state.mu),
        (Field::BendingDensity { interface_width }, _) => (state.omega.iter())
            .map(|omega| bending_energy_density(interface_width, *omega))
            .collect(),
    }
}

/// The symbol of a field.
pub(super) fn symbol(state: &State, field: Field) -> Label {
    match (field, &state.director) {
        (Field::DirectorLength, Some(_)) => Label::text("|").and_symbol("d").and("|"),
        (Field::Phase | Field::DirectorLength, _) => Label::symbol("φ"),
        (Field::Bending, _) => Label::symbol("ω"),
        (Field::Potential, _) => Label::symbol("μ"),
        (Field::BendingDensity { .. }, _) => {
            Label::symbol("ε").and("/2 ").and_symbol("ω").above("2")
        }
    }
}

/// Draws a state in a square.
///
/// # Errors
/// [`FigureError::Memory`] for its colours.
pub(super) fn draw(
    page: &Page,
    place: Rectangle,
    mesh: &Mesh,
    state: &State,
    style: &Style,
) -> Result<(), FigureError> {
    let Frame { corner, side } = Frame::around(mesh);
    let [x, y] = corner.map(|low| low..low + side);
    let corners = [(x.start, y.start), (x.end, y.end)];
    let mut chart = ChartBuilder::on(&part(page, place)).build_cartesian_2d(x, y)?;
    let is_rotated = mesh.geometry() == Geometry::Axisymmetric;
    let section = is_rotated.then(|| section(mesh, state));
    let (mesh, state) = match &section {
        Some((mesh, state)) => (mesh, state),
        None => (mesh, state),
    };
    let values = values(state, style.field);
    let field = |place| field_image(place, mesh, &values, style.scale);
    chart.draw_series(once(raster(corners, field)))?;
    let line = |width: f64| stroke(BLACK, width * line_weight(style.size));
    if let Some(director) = &state.director {
        let ends = director_ends(place, mesh, (&state.phi, director), style.size);
        match style.director {
            Director::Arrows => {
                chart.draw_series(ends.map(|ends| arrow(ends, line(0.75))))?;
            }
            Director::Strokes => {
                chart.draw_series(ends.map(|ends| PathElement::new(ends, line(1.0))))?;
            }
            Director::Off => {}
        }
    }
    let mut curves = |contour: &Contour, line: ShapeStyle| {
        for curve in chain(contour) {
            for piece in pieces(curve.into_iter().map(<(f64, f64)>::from)) {
                chart.draw_series(LineSeries::new(piece, line))?;
            }
        }
        Ok::<(), FigureError>(())
    };
    curves(&Contour::new(mesh, &state.phi), line(1.6))?;
    // A domain that does not fill the frame has its own line.
    let area: f64 = mesh.areas().iter().sum();
    if area < (1.0 - 1e-9) * side * side {
        let segments = Wall::of(mesh).edges().to_vec();
        let wall = Contour {
            segments,
            ..Contour::default()
        };
        curves(&wall, line(0.8))?;
    }
    if is_rotated {
        let region = mesh.bounding_box();
        for (number, from) in axis_dashes(&region).enumerate() {
            let to = from + AXIS_DASH * region.extent().y * [1.0, 0.2][number % 2];
            let ends = [(0.0, from), (0.0, to)];
            chart.draw_series(once(PathElement::new(ends, line(0.5))))?;
        }
    }
    let frame = plotters::element::Rectangle::new(corners, line(0.8));
    chart.draw_series(once(frame))?;
    Ok(())
}

/// Of the height of a body of rotation, the longer dashes of the line that marks its axis, and from one dash to the next.
const AXIS_DASH: f64 = 0.02;
const AXIS_STEP: f64 = 0.018;

/// Where the dashes of the axis begin, long and short ones in turn.
fn axis_dashes(region: &BoundingBox) -> impl Iterator<Item = f64> {
    let (low, height) = (region.lower.y, region.extent().y);
    let count = (1.0 / (2.0 * AXIS_STEP)) as u32;
    (0..count).flat_map(move |number| {
        let at = low + height * 2.0 * AXIS_STEP * f64::from(number);
        [at, at + height * (AXIS_DASH + 0.3 * AXIS_STEP)]
    })
}

/// The full cross-section of a body of rotation: d is mirrored with it.
fn section(mesh: &Mesh, state: &State) -> (Mesh, State) {
    let (whole, images) = mesh.section();
    let with_images = |field: &[f64], sign: f64| -> Vec<f64> {
        let mirrored = images.iter().map(|node| sign * field[*node as usize]);
        field.iter().copied().chain(mirrored).collect()
    };
    let director = state.director.as_ref();
    let state = State {
        phi: with_images(&state.phi, 1.0),
        omega: with_images(&state.omega, 1.0),
        mu: with_images(&state.mu, 1.0),
        director: director.map(|[x, y]| [with_images(x, -1.0), with_images(y, 1.0)]),
    };
    (whole, state)
}

/// The colours of a P1 function on the pixels of a place.
fn field_image(
    place: Rectangle,
    mesh: &Mesh,
    values: &[f64],
    scale: &Scale,
) -> Result<Image, FigureError> {
    let finer = (LEAST_SAMPLES / place.width()).ceil().max(1.0);
    // An odd factor: the centre of a pixel is then the centre of a cell.
    let finer = finer as usize | 1;
    let size = [place.width(), place.height()].map(|pixels| pixels as usize * finer);
    let _claim = needs::colours(size)?;
    // What no value is put into is outside of the domain.
    let mut cells = vec![WHITE; size[0] * size[1]];
    sample_each(mesh, [values], size[0], size[1], |cell, [value]| {
        cells[cell] = scale.at(value);
    });
    Ok(Image { place, size, cells })
}

/// Where the director begins and ends inside the vesicle, on a lattice.
fn director_ends(
    place: Rectangle,
    mesh: &Mesh,
    (phi, director): (&[f64], &[Vec<f64>; 2]),
    size: f64,
) -> impl Iterator<Item = [(f64, f64); 2]> {
    // As many as can be told apart.
    let cells = (place.width() / (0.42 * size)).clamp(10.0, 34.0) as usize;
    let frame = Frame::around(mesh);
    let spacing = frame.side / cells as f64;
    let [x, y] = director;
    let fine = FINER * cells;
    let inside = sample(mesh, [phi], fine, fine);
    // Whether φ > 0 there, to a fraction of the lattice's step.
    let is_inside = move |end: [f64; 2]| {
        let [x, y] = frame.share(end);
        let [column, row] = [x, 1.0 - y].map(|share| (fine as f64 * share).max(0.0) as usize);
        let number = (fine * row + column).min(inside.len() - 1);
        inside[number][0] > 0.0
    };
    let sampled = sample(mesh, [phi, x, y], cells, cells);
    let ends = move |(number, [phi, dx, dy]): (usize, [f64; 3])| {
        let length = dx.hypot(dy);
        // What is no number is not drawn either.
        let is_seen = phi > 0.0 && length > SHORTEST && length.is_finite();
        let center = [number % cells, cells - 1 - number / cells].map(|it| it as f64 + 0.5);
        let half = 0.5 * spacing * (ARROW * length).min(LONGEST) / length;
        let end = |sign: f64| {
            let step = [dx, dy].map(|part| sign * half * part);
            [0, 1].map(|axis| frame.corner[axis] + spacing * center[axis] + step[axis])
        };
        let ends = [-1.0, 1.0].map(end);
        // What belongs to the inside does not reach over the membrane.
        let is_drawn = is_seen && ends.into_iter().all(&is_inside);
        is_drawn.then(|| ends.map(<(f64, f64)>::from))
    };
    sampled.into_iter().enumerate().filter_map(ends)
}

/// How long ticks are, in sizes of the text.
const TICK: f64 = 0.28;
/// Between a tick and its number at the side.
const TICK_GAP: f64 = 0.25;
/// Between a tick and its number below.
const NUMBER_GAP: f64 = 0.1;

/// A number that is wider than this, in sizes of the text, would meet that of the next picture.
const LONG_NUMBER: f64 = 0.9;

/// The room that the numbers of the y axis take at the left of a picture.
pub(super) fn left_room(size: f64) -> f64 {
    Label::text("0.5").width(size) + (TICK + TICK_GAP) * size
}

/// The room that the numbers of the x axis take below a picture.
pub(super) fn lower_room(size: f64) -> f64 {
    super::text::line_height(size) + (TICK + NUMBER_GAP) * size
}

/// Ticks at the square's lower and left side; `numbers` says which of the two has numbers.
pub(super) fn draw_axes(
    page: &Page,
    place: Rectangle,
    mesh: &Mesh,
    size: f64,
    numbers: [bool; 2],
) -> Result<(), FigureError> {
    let Frame { corner, side } = Frame::around(mesh);
    let names = match mesh.geometry() {
        Geometry::Planar => ["x", "y"],
        Geometry::Axisymmetric => ["r", "z"],
    };
    for (axis, name) in names.into_iter().enumerate() {
        // So many sizes of the text away from the square.
        let at = |share: f64, out: f64| match axis {
            0 => [
                place.left + share * place.width(),
                place.bottom + out * size,
            ],
            _ => [
                place.left - out * size,
                place.bottom - share * place.height(),
            ],
        };
        let gap = TICK + [NUMBER_GAP, TICK_GAP][axis];
        let beside = [(HPos::Center, VPos::Top), (HPos::Right, VPos::Center)][axis];
        for share in [0.0, 0.5, 1.0] {
            let width = 0.8 * line_weight(size);
            draw_line(page, &[at(share, 0.0), at(share, TICK)], width)?;
            let label = tick_label(corner[axis] + share * side, side);
            // Long numbers at the ends keep out of the next picture.
            let is_long = axis == 0 && label.width(size) >= LONG_NUMBER * size;
            let anchor = match share {
                0.0 if is_long => (HPos::Left, VPos::Top),
                1.0 if is_long => (HPos::Right, VPos::Top),
                _ => beside,
            };
            if numbers[axis] {
                write_label(page, &label, size, at(share, gap), anchor)?;
            }
        }
        if numbers[axis] {
            // The axis' name stands between the numbers.
            write_label(page, &Label::symbol(name), size, at(0.75, gap), beside)?;
        }
    }
    Ok(())
}

/// A coordinate in at most two decimals, or in three digits where the domain is too small for that.
fn tick_label(value: f64, span: f64) -> Label {
    if span < 0.05 {
        return number(value, 3);
    }
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    Label::text(&match text {
        "-0" => "0".to_owned(),
        text => text.replace('-', "\u{2212}"),
    })
}

/// The ticks of a colour bar that is `height` high: two at least, for one number is no scale.
pub(super) fn bar_axis(scale: &Scale, height: f64, size: f64) -> Axis {
    let (least, most) = (*BAR_TICKS.start(), *BAR_TICKS.end());
    let room = ((height / (2.2 * size)) as usize).clamp(least, most);
    let axis = |ticks: usize| Axis::new(scale.range(), ticks);
    let enough = (room..=most).map(axis).find(|axis| axis.ticks.len() > 1);
    enough.unwrap_or_else(|| axis(room))
}

/// The room that a colour bar takes, from its left side to the end of its numbers.
///
/// How high it is, and so which numbers it has, depends on the room for the pictures beside it: there
/// is room for the numbers of any height.
pub(super) fn bar_room(scale: &Scale, size: f64, name: &Label) -> f64 {
    let room = |most: usize| {
        let axis = Axis::new(scale.range(), most);
        // plotters writes the numbers two ticks away.
        let numbers = axis.widest(size) + (BAR + 2.0 * TICK) * size;
        numbers.max(axis.name(name.clone()).width(size))
    };
    BAR_TICKS.map(room).fold(0.0, f64::max)
}

/// Ticks of a colour bar, at most.
const BAR_TICKS: std::ops::RangeInclusive<usize> = 2..=6;

/// The width of a colour bar, in sizes of the text.
const BAR: f64 = 0.9;

/// Draws a colour bar whose upper left corner is `corner`, with its name above.
pub(super) fn draw_bar(
    page: &Page,
    scale: &Scale,
    corner: [f64; 2],
    height: f64,
    size: f64,
    name: &Label,
) -> Result<(), FigureError> {
    let bar = Rectangle::new(corner, [BAR * size, height]).on_pixels();
    let axis = bar_axis(scale, height, size);
    let [low, high] = scale.range();
    let room = bar_room(scale, size, name);
    let mut chart = ChartBuilder::on(&part(page, bar.with_room([0.0, room, 0.0])))
        .right_y_label_area_size(units(room))
        .build_cartesian_2d(0.0..1.0, axis.clone())?;
    let corners = [(0.0, low), (1.0, high)];
    chart.draw_series(once(raster(corners, |place| Ok(bar_image(place, scale)))))?;
    let line = stroke(BLACK, 0.8 * line_weight(size));
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(line)
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Right, units(TICK * size))
        .draw()?;
    // plotters draws the fourth side, as an axis.
    let sides = [(1.0, high), (0.0, high), (0.0, low), (1.0, low)];
    chart.draw_series(once(PathElement::new(sides, line)))?;
    let at = [bar.left, bar.top - 1.35 * size];
    let name = axis.name(name.clone());
    write_label(page, &name, size, at, (HPos::Left, VPos::Top))
}

/// The colours of a scale from the top of a place to its bottom.
fn bar_image(place: Rectangle, scale: &Scale) -> Image {
    // A single column would do, but some programs blur it to the sides when they show an SVG.
    let size @ [columns, rows] = [place.width(), place.height()].map(|pixels| pixels as usize);
    let [low, high] = scale.range();
    let value = |row: usize| high - (high - low) * (row as f64 + 0.5) / rows as f64;
    let row = |row: usize| std::iter::repeat_n(scale.at(value(row)), columns);
    let cells = (0..rows).flat_map(row).collect();
    Image { place, size, cells }
}

/// The scale for some states of one figure: the same for all, and wide enough for each.
pub(super) fn scale<'a>(
    states: impl Iterator<Item = &'a State>,
    field: Field,
    map: super::ColourMap,
) -> Scale {
    let mut bound = 0.0_f64;
    // Of |d| − 1 inside; without a director |d| is not there, and φ is shown.
    let mut departure = None;
    for state in states {
        let values = values(state, field);
        if let Some([low, high]) = extent(values.iter().copied()) {
            bound = bound.max(-low).max(high);
        }
        if field == Field::DirectorLength && state.director.is_some() {
            let inside = values.iter().zip(&state.phi).filter(|(_, phi)| **phi > 0.0);
            let departures = inside.map(|(length, _)| (length - 1.0).abs());
            let finite = departures.filter(|departure| departure.is_finite());
            let least = departure.unwrap_or(super::LEAST_DEPARTURE);
            departure = Some(finite.fold(least, f64::max));
        }
    }
    if let Some(departure) = departure {
        return Scale::around(1.0, map, departure.min(1.0));
    }
    if bound == 0.0 || (field == Field::Phase && (0.5..1.0).contains(&bound)) {
        // φ is about ±1 in a vesicle and around it: the bar reaches there.
        bound = 1.0;
    }
    match field {
        Field::BendingDensity { .. } => Scale::unsigned(bound),
        _ => Scale::signed(map, bound),
    }
}
