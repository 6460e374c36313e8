//! The picture of a state: a field in colour, the membrane, the director.

use super::axes::lower_room;
use super::canvas::{Image, Page, Rectangle, font, part, pieces, stroke, units, write_label};
use super::colour::Scale;
use super::data::Field;
use super::elements::{arrow, raster};
use super::number::{Axis, extent};
use super::outline::chain;
use super::sampling::{Frame, sample, sample_each};
use super::text::Label;
use super::{Director, FigureError, needs};
use crate::fem::{Contour, Mesh, Wall};
use crate::geometry::{BoundingBox, Point, Segment};
use crate::physics::bending_energy_density;
use crate::scene::Geometry;
use crate::scheme::State;
use crate::simulation::outline_beside;
use crate::theory::ShapeAtRest;
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::PathElement;
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, RGBColor, ShapeStyle, WHITE};
use std::borrow::Cow;
use std::iter::once;

/// A picture is sampled at so many points a side at least: an SVG may be shown larger.
const LEAST_SAMPLES: f64 = 480.0;
/// The least step of the director's lattice, in sizes of the text: the head of an arrow is seen.
const LATTICE: f64 = 0.66;
/// An arrow of a unit vector, in steps of its lattice.
const ARROW: f64 = 0.82;
/// No arrow is longer, in steps of its lattice.
const LONGEST: f64 = 1.3;
/// How much finer than the lattice the inside is known.
const FINER: usize = 8;
/// What follows a title where the outline of theory is drawn.
const THEORY_NOTE: &str = " (dashed: theory, the membrane alone at rest)";
/// The colour of the outline of theory, and the lengths of its dashes and of the spaces between, in sizes of the text.
const THEORY: RGBColor = RGBColor(0, 110, 60);
const THEORY_DASHES: [f64; 2] = [0.5, 0.35];
/// Shorter ones are not drawn: they have no direction to see.
const SHORTEST: f64 = 0.05;

/// How the pictures of a figure are drawn: the same for all in it.
pub(super) struct Style<'a> {
    pub scale: &'a Scale,
    pub field: Field,
    pub director: Director,
    /// The part of the plane.
    pub frame: Frame,
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

/// A title that says what the dashed line is where the outline of theory is drawn.
pub(super) fn title(title: &Label, theory: Option<&ShapeAtRest>) -> Label {
    match theory {
        Some(_) => title.clone().and(THEORY_NOTE),
        None => title.clone(),
    }
}

/// Draws a state in a rectangle; the shape at rest of theory is dashed, about the centre of the vesicle and along it.
///
/// # Errors
/// [`FigureError::Memory`] for its colours.
pub(super) fn draw(
    page: &Page,
    place: Rectangle,
    mesh: &Mesh,
    state: &State,
    theory: Option<&ShapeAtRest>,
    style: &Style,
) -> Result<(), FigureError> {
    let Frame { corner, sides } = style.frame;
    let [x, y] = [0, 1].map(|axis| corner[axis]..corner[axis] + sides[axis]);
    let (x_end, y_end) = (x.end, y.end);
    let corners = [(x.start, y.start), (x_end, y_end)];
    let mut chart = ChartBuilder::on(&part(page, place)).build_cartesian_2d(x, y)?;
    let is_rotated = mesh.geometry() == Geometry::Axisymmetric;
    let section = is_rotated.then(|| section(mesh, state));
    let (mesh, state) = match &section {
        Some((mesh, state)) => (mesh, state),
        None => (mesh, state),
    };
    let values = values(state, style.field);
    let field = |place| field_image(place, (mesh, style.frame), &values, style.scale);
    chart.draw_series(once(raster(corners, field)))?;
    let line = |width: f64| stroke(BLACK, width * line_weight(style.size));
    if let Some(director) = &state.director {
        let ends = director_ends(
            place,
            (mesh, style.frame),
            (&state.phi, director),
            style.size,
        );
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
    let bounds = BoundingBox {
        lower: corner.into(),
        upper: [x_end, y_end].into(),
    };
    let mut curves = |contour: &Contour, line: ShapeStyle| {
        let segments = contour.segments.iter();
        let segments = segments.filter_map(|segment| clipped(*segment, &bounds));
        let contour = Contour {
            segments: segments.collect(),
            ..Contour::default()
        };
        for curve in chain(&contour) {
            for piece in pieces(curve.into_iter().map(<(f64, f64)>::from)) {
                chart.draw_series(LineSeries::new(piece, line))?;
            }
        }
        Ok::<(), FigureError>(())
    };
    curves(&Contour::new(mesh, &state.phi), line(1.6))?;
    // A domain that does not fill the frame has its own line.
    let area: f64 = mesh.areas().iter().sum();
    if area < (1.0 - 1e-9) * sides[0] * sides[1] {
        let segments = Wall::of(mesh).edges().to_vec();
        let wall = Contour {
            segments,
            ..Contour::default()
        };
        curves(&wall, line(0.8))?;
    }
    if is_rotated {
        for (number, from) in axis_dashes(&bounds).enumerate() {
            let to = from + AXIS_DASH * bounds.extent().y * [1.0, 0.2][number % 2];
            let ends = [(0.0, from), (0.0, to.min(y_end))];
            chart.draw_series(once(PathElement::new(ends, line(0.5))))?;
        }
    }
    if let Some(theory) = theory {
        let outline = outline_beside(theory, mesh, &state.phi);
        let is_shown = |at: &Point| at >= &bounds.lower && at <= &bounds.upper;
        let [dash, space] = THEORY_DASHES.map(|length| units(length * style.size).max(1));
        let shown = outline
            .chunk_by(|a, b| is_shown(a) == is_shown(b))
            .filter(|part| is_shown(&part[0]));
        for piece in shown.flat_map(|part| pieces(part.iter().map(|at| (at.x, at.y)))) {
            chart.draw_series(DashedLineSeries::new(
                piece,
                dash,
                space,
                stroke(THEORY, 1.6 * line_weight(style.size)),
            ))?;
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
    mesh: (&Mesh, Frame),
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
    sample_each(mesh, [values], size, |cell, [value]| {
        cells[cell] = scale.at(value);
    });
    Ok(Image { place, size, cells })
}

/// Steps of the director's lattice along the longer side of a picture: as many as can be told apart, with their heads.
fn lattice(place: Rectangle, size: f64) -> f64 {
    let longer = place.width().max(place.height());
    (longer / (LATTICE * size)).clamp(10.0, 34.0)
}

/// Between the arrow of a unit vector and its words, in sizes of the text.
const UNIT_GAP: f64 = 0.4;

/// Draws what the length of the director's arrows, or strokes, means, below pictures of this size whose lower side is at
/// `bottom`, in the line of the axes' names, up to `right`; nothing where no director is drawn.
///
/// # Errors
/// Those of plotters.
pub(super) fn draw_unit<'a>(
    page: &Page,
    picture: Rectangle,
    [right, bottom]: [f64; 2],
    mut states: impl Iterator<Item = &'a State>,
    style: &Style,
) -> Result<(), FigureError> {
    if style.director == Director::Off || states.all(|state| state.director.is_none()) {
        return Ok(());
    }
    let size = style.size;
    let words = Label::text("|").and_symbol("d").and("| = 1");
    let longer = picture.width().max(picture.height());
    let length = ARROW * longer / lattice(picture, size);
    let top = bottom + lower_room(size) - super::text::line_height(size);
    let left = right - words.width(size);
    let corner = [left - UNIT_GAP * size - length, top];
    let room = Rectangle::new(corner, [length, size]).on_pixels();
    let mut chart = ChartBuilder::on(&part(page, room)).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
    let ends = [(0.0, 0.5), (1.0, 0.5)];
    let line = |width: f64| stroke(BLACK, width * line_weight(size));
    match style.director {
        Director::Arrows => {
            chart.draw_series(once(arrow(ends, line(0.75))))?;
        }
        _ => {
            chart.draw_series(once(PathElement::new(ends, line(1.0))))?;
        }
    }
    write_label(page, &words, size, [left, top], (HPos::Left, VPos::Top))
}

/// Where the director begins and ends inside the vesicle, on a lattice.
fn director_ends(
    place: Rectangle,
    (mesh, frame): (&Mesh, Frame),
    (phi, director): (&[f64], &[Vec<f64>; 2]),
    size: f64,
) -> impl Iterator<Item = [(f64, f64); 2]> {
    let longer = place.width().max(place.height());
    let along = lattice(place, size);
    let cells = [place.width(), place.height()].map(|side| (along * side / longer).ceil() as usize);
    let spacing = frame.sides[0].max(frame.sides[1]) / along;
    let [x, y] = director;
    let fine = cells.map(|cells| FINER * cells);
    let inside = sample((mesh, frame), [phi], fine);
    // Whether φ > 0 there, to a fraction of the lattice's step.
    let is_inside = move |end: [f64; 2]| {
        let [x, y] = frame.share(end);
        let at = |share: f64, axis: usize| (fine[axis] as f64 * share).max(0.0) as usize;
        let (column, row) = (at(x, 0).min(fine[0] - 1), at(1.0 - y, 1).min(fine[1] - 1));
        inside[fine[0] * row + column][0] > 0.0
    };
    let sampled = sample((mesh, frame), [phi, x, y], cells);
    let ends = move |(number, [phi, dx, dy]): (usize, [f64; 3])| {
        let length = dx.hypot(dy);
        // What is no number is not drawn either.
        let is_seen = phi > 0.0 && length > SHORTEST && length.is_finite();
        let center = [number % cells[0], cells[1] - 1 - number / cells[0]];
        let center = [0, 1].map(|axis| {
            let share = (center[axis] as f64 + 0.5) / cells[axis] as f64;
            frame.corner[axis] + frame.sides[axis] * share
        });
        let half = 0.5 * spacing * (ARROW * length).min(LONGEST) / length;
        let end = |sign: f64| [center[0] + sign * half * dx, center[1] + sign * half * dy];
        let ends = [-1.0, 1.0].map(end);
        // What belongs to the inside does not reach over the membrane.
        let is_drawn = is_seen && ends.into_iter().all(&is_inside);
        is_drawn.then(|| ends.map(<(f64, f64)>::from))
    };
    sampled.into_iter().enumerate().filter_map(ends)
}

/// The part of a segment that lies in a rectangle (Liang and Barsky, 1984).
fn clipped([from, to]: Segment, bounds: &BoundingBox) -> Option<Segment> {
    let along = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in [0, 1] {
        for (room, speed) in [
            (from[axis] - bounds.lower[axis], -along[axis]),
            (bounds.upper[axis] - from[axis], along[axis]),
        ] {
            if speed == 0.0 && room < 0.0 {
                return None;
            }
            match speed {
                0.0 => {}
                speed if speed > 0.0 => last = last.min(room / speed),
                speed => first = first.max(room / speed),
            }
        }
    }
    (first < last).then(|| [from + first * along, from + last * along])
}

/// How long the ticks of a colour bar are, in sizes of the text.
const TICK: f64 = 0.28;

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
