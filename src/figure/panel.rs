//! The picture of a state: a field in colour, the membrane, the director.

use super::colour::{Colour, Scale};
use super::data::Field;
use super::drawing::{Drawing, Image, Rectangle};
use super::number::{Axis, number};
use super::outline::chain;
use super::sampling::{Frame, sample, sample_each};
use super::text::{Across, Along, Label};
use super::{Director, FigureError, needs};
use crate::fem::{Contour, Mesh, Wall};
use crate::physics::bending_energy_density;
use crate::scheme::State;
use std::borrow::Cow;

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

impl Style<'_> {
    /// The width of a line of weight 1.
    pub fn stroke(&self) -> f64 {
        stroke(self.size)
    }
}

/// The width of a line of weight 1 in a picture whose text has this size.
pub(super) fn stroke(size: f64) -> f64 {
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
    drawing: &mut Drawing,
    place: Rectangle,
    mesh: &Mesh,
    state: &State,
    style: &Style,
) -> Result<(), FigureError> {
    let values = values(state, style.field);
    let finer = (LEAST_SAMPLES / place.width()).ceil().max(1.0);
    // An odd factor: the centre of a pixel is then the centre of a cell.
    let finer = finer as usize | 1;
    let size = [
        place.width() as usize * finer,
        place.height() as usize * finer,
    ];
    let _claim = needs::colours(size)?;
    // What no value is put into is outside of the domain.
    let mut cells = vec![Colour::WHITE; size[0] * size[1]];
    sample_each(mesh, [&*values], size[0], size[1], |cell, [value]| {
        cells[cell] = style.scale.at(value);
    });
    drawing.images.push(Image { place, size, cells });

    let frame = Frame::around(mesh);
    let on_picture = |at: [f64; 2]| {
        let [x, y] = frame.share(at);
        [
            place.left + x * place.width(),
            place.bottom - y * place.height(),
        ]
    };
    if let Some(director) = &state.director {
        draw_director(drawing, &place, mesh, (&state.phi, director), style);
    }
    for curve in chain(&Contour::new(mesh, &state.phi)) {
        let points = curve.into_iter().map(on_picture).collect();
        drawing.line(points, 1.6 * style.stroke(), Colour::BLACK);
    }
    // A domain that does not fill the frame has its own line.
    let area: f64 = mesh.areas().iter().sum();
    if area < (1.0 - 1e-9) * frame.side * frame.side {
        let wall = Contour {
            segments: Wall::of(mesh).edges().to_vec(),
            area,
        };
        for curve in chain(&wall) {
            let points = curve.into_iter().map(on_picture).collect();
            drawing.line(points, 0.8 * style.stroke(), Colour::BLACK);
        }
    }
    drawing.line(
        place.corners().to_vec(),
        0.8 * style.stroke(),
        Colour::BLACK,
    );
    Ok(())
}

/// The director inside the vesicle, on a lattice.
fn draw_director(
    drawing: &mut Drawing,
    place: &Rectangle,
    mesh: &Mesh,
    (phi, director): (&[f64], &[Vec<f64>; 2]),
    style: &Style,
) {
    if style.director == Director::Off {
        return;
    }
    // As many as can be told apart.
    let cells = (place.width() / (0.42 * style.size)).clamp(10.0, 34.0) as usize;
    let spacing = place.width() / cells as f64;
    let [x, y] = director;
    let inside = sample(mesh, [phi], FINER * cells, FINER * cells);
    // Whether φ > 0 there, to a fraction of the lattice's step.
    let is_inside = |point: [f64; 2]| {
        let steps = |offset: f64| (FINER as f64 * offset / spacing).max(0.0) as usize;
        let (column, row) = (steps(point[0] - place.left), steps(point[1] - place.top));
        let number = (FINER * cells * row + column).min(inside.len() - 1);
        inside[number][0] > 0.0
    };
    for (number, [phi, dx, dy]) in sample(mesh, [phi, x, y], cells, cells)
        .into_iter()
        .enumerate()
    {
        let length = dx.hypot(dy);
        // What is no number is not drawn either.
        let is_seen = phi > 0.0 && length > SHORTEST && length.is_finite();
        if !is_seen {
            continue;
        }
        let center = [
            place.left + ((number % cells) as f64 + 0.5) * spacing,
            place.top + ((number / cells) as f64 + 0.5) * spacing,
        ];
        let half = 0.5 * spacing * (ARROW * length).min(LONGEST) / length;
        // y points down in a picture.
        let step = [dx * half, -dy * half];
        // What belongs to the inside does not reach over the membrane.
        let ends = [-1.0, 1.0].map(|sign| [0, 1].map(|i| center[i] + sign * step[i]));
        if !ends.into_iter().all(is_inside) {
            continue;
        }
        match style.director {
            Director::Arrows => draw_arrow(drawing, center, step, style),
            Director::Strokes | Director::Off => {
                drawing.line(ends.to_vec(), style.stroke(), Colour::BLACK);
            }
        }
    }
}

/// An arrow from `center` − `step` to `center` + `step`.
fn draw_arrow(drawing: &mut Drawing, center: [f64; 2], step: [f64; 2], style: &Style) {
    let half = step[0].hypot(step[1]);
    let head = 0.85 * half;
    let along = step.map(|part| part / half);
    let across = [-along[1], along[0]];
    let at = |forward: f64, aside: f64| {
        [0, 1].map(|i| center[i] + forward * along[i] + aside * across[i])
    };
    drawing.line(
        vec![at(-half, 0.0), at(half - 0.7 * head, 0.0)],
        0.75 * style.stroke(),
        Colour::BLACK,
    );
    let barb = 0.36 * head;
    drawing.polygon(
        vec![
            at(half, 0.0),
            at(half - head, barb),
            at(half - 0.75 * head, 0.0),
            at(half - head, -barb),
        ],
        Colour::BLACK,
    );
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

/// Ticks at the square's left and lower side, with numbers where they are asked for.
pub(super) fn draw_axes(
    drawing: &mut Drawing,
    place: Rectangle,
    mesh: &Mesh,
    size: f64,
    numbers: Numbers,
) {
    let tick = TICK * size;
    let width = 0.8 * stroke(size);
    let Frame { corner, side } = Frame::around(mesh);
    for share in [0.0, 0.5, 1.0] {
        let [across, up] = corner.map(|least| tick_label(least + share * side, side));
        let x = place.left + share * place.width();
        let y = place.bottom - share * place.height();
        drawing.line(
            vec![[x, place.bottom], [x, place.bottom + tick]],
            width,
            Colour::BLACK,
        );
        drawing.line(
            vec![[place.left, y], [place.left - tick, y]],
            width,
            Colour::BLACK,
        );
        if numbers.below {
            let at = [x, place.bottom + tick + NUMBER_GAP * size];
            // Long numbers at the ends keep out of the next picture.
            let anchor = match share {
                _ if across.width(size) < LONG_NUMBER * size => Across::Middle,
                0.0 => Across::Left,
                1.0 => Across::Right,
                _ => Across::Middle,
            };
            drawing.label(&across, size, at, anchor, Along::Top);
        }
        if numbers.left {
            let at = [place.left - tick - TICK_GAP * size, y];
            drawing.label(&up, size, at, Across::Right, Along::Middle);
        }
    }
    // The axes' names stand between the numbers.
    if numbers.below {
        let at = [
            place.left + 0.75 * place.width(),
            place.bottom + tick + NUMBER_GAP * size,
        ];
        drawing.label(&Label::symbol("x"), size, at, Across::Middle, Along::Top);
    }
    if numbers.left {
        let at = [
            place.left - tick - TICK_GAP * size,
            place.bottom - 0.75 * place.height(),
        ];
        drawing.label(&Label::symbol("y"), size, at, Across::Right, Along::Middle);
    }
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

/// Which axes of a picture have numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Numbers {
    pub left: bool,
    pub below: bool,
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
        let widths = axis.ticks.iter().map(|tick| axis.label(*tick).width(size));
        let numbers = widths.fold(0.0, f64::max) + (BAR + TICK + TICK_GAP) * size;
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
    drawing: &mut Drawing,
    scale: &Scale,
    corner: [f64; 2],
    height: f64,
    size: f64,
    name: &Label,
) {
    let place = Rectangle {
        left: corner[0],
        top: corner[1],
        right: corner[0] + BAR * size,
        bottom: corner[1] + height,
    }
    .on_pixels();
    let (columns, rows) = (place.width() as usize, place.height() as usize);
    let [low, high] = scale.range();
    let value = |row: usize| high - (high - low) * (row as f64 + 0.5) / rows as f64;
    let row = |row: usize| std::iter::repeat_n(scale.at(value(row)), columns);
    drawing.images.push(Image {
        place,
        // A single column would do, but some programs blur it to the sides when they show an SVG.
        size: [columns, rows],
        cells: (0..rows).flat_map(row).collect(),
    });
    let width = 0.8 * stroke(size);
    drawing.line(place.corners().to_vec(), width, Colour::BLACK);
    let axis = bar_axis(scale, height, size);
    for &tick in &axis.ticks {
        let y = place.bottom - axis.place(tick) * place.height();
        let end = place.right + TICK * size;
        drawing.line(vec![[place.right, y], [end, y]], width, Colour::BLACK);
        let at = [end + TICK_GAP * size, y];
        drawing.label(&axis.label(tick), size, at, Across::Left, Along::Middle);
    }
    let at = [place.left, place.top - 1.35 * size];
    drawing.label(&axis.name(name.clone()), size, at, Across::Left, Along::Top);
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
        let finite = values.iter().filter(|value| value.is_finite());
        bound = finite.fold(bound, |bound, value| bound.max(value.abs()));
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
