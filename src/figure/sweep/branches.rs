//! W over the reduced volume of bodies of rotation: the branches of the sharp-interface theory as lines, the ends of a sweep's
//! runs as points, and below them their shapes.

use super::{SweepFigureError, SweepView, numeric};
use crate::fem::Contour;
use crate::figure::FigureError;
use crate::figure::canvas::{
    Drawing, Page, Rectangle, font, part, stroke, units, write_label, write_paragraph,
};
use crate::figure::colour::LINE_COLOURS;
use crate::figure::curves::TICKS;
use crate::figure::elements::{Mark, marker};
use crate::figure::legend::{Entry, draw_legend};
use crate::figure::number::Axis;
use crate::figure::outline::chain;
use crate::figure::panel::line_weight;
use crate::figure::text::{Label, line_height};
use crate::study::sweep::{SweepFolder, Table, last_fields, plain};
use crate::theory::{Branch, CROSSINGS, ClosedSurface, MEMBRANE_FACTOR};
use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::element::{EmptyElement, PathElement, Polygon, Text};
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color, RGBColor};
use std::f64::consts::PI;
use std::iter::once;

/// The height of the plot to its width.
const ASPECT: f64 = 0.5;
/// The axes: v and W.
const RANGES: [[f64; 2]; 2] = [[0.5, 1.0], [1.0, 2.2]];
/// The part of the room between two shapes that they take at most.
const FILLED: f64 = 0.92;
/// R₀ of a shape at most, in sizes of the text.
const LARGEST: f64 = 2.0;

/// The end of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RestPoint {
    /// Its folder's name.
    pub name: String,
    pub branch: Branch,
    /// v of the surface φ = 0.
    pub reduced_volume: f64,
    /// E_bending over that of a sphere, (2√2/3)·8π.
    pub energy: f64,
    /// The cross-section in parts of R₀, about the middle of its box.
    pub curves: Vec<Vec<[f64; 2]>>,
}

/// The ends of the runs of a sweep that are bodies of rotation with one vesicle.
pub(super) fn rest_points(
    sweep: &SweepFolder,
    table: &Table,
    view: &SweepView,
) -> Result<Vec<RestPoint>, SweepFigureError> {
    let fixed: Vec<(usize, &str)> = view
        .fixed
        .iter()
        .map(|(key, value)| {
            let place = table.keys.iter().position(|it| it == key);
            let no_axis = || SweepFigureError::NoAxis {
                key: key.clone(),
                keys: table.keys.clone(),
            };
            Ok((place.ok_or_else(no_axis)?, value.as_str()))
        })
        .collect::<Result<_, SweepFigureError>>()?;
    let is_same = |own: &str, wanted: &str| match (numeric(own), numeric(wanted)) {
        (Some(own), Some(wanted)) => own == wanted,
        _ => plain(own) == plain(wanted),
    };
    let bending = table.column("E_bending");
    let mut points = Vec::new();
    for (row, point) in table.rows.iter().zip(sweep.points()) {
        let is_wanted = |(place, value): &(usize, &str)| is_same(&row.values[*place], value);
        let energy = bending.and_then(|column| row.numbers[column]);
        let Some(energy) = energy.filter(|_| fixed.iter().all(is_wanted)) else {
            continue;
        };
        let Some(fields) = last_fields(&sweep.run(point)) else {
            continue;
        };
        let half = Contour::new(&fields.mesh, &fields.state.phi);
        points.extend(rest_point(row.name.clone(), energy, half));
    }
    match points.is_empty() {
        true => Err(SweepFigureError::NoBodies),
        false => Ok(points),
    }
}

/// What is drawn of the surface that a contour makes by rotation; `None` for one that is no vesicle on the axis, or no body at all.
pub(super) fn rest_point(name: String, bending: f64, mut contour: Contour) -> Option<RestPoint> {
    let reduced_volume = contour.reduced_size()?;
    let length = (contour.surface()? / (4.0 * PI)).sqrt();
    let [one, other] = contour.poles()[..] else {
        return None;
    };
    contour.mirror();
    let ends = || contour.segments.iter().flatten();
    let lowest = ends().map(|it| it.y).fold(f64::INFINITY, f64::min);
    let highest = ends().map(|it| it.y).fold(f64::NEG_INFINITY, f64::max);
    let widest = ends().map(|it| it.x).fold(f64::NEG_INFINITY, f64::max);
    let middle = 0.5 * (lowest + highest);
    let branch = Branch::of_extents([one, other], [lowest, highest], widest);
    let curves = chain(&contour).into_iter().map(|curve| {
        let place = |[x, y]: [f64; 2]| [x / length, (y - middle) / length];
        curve.into_iter().map(place).collect()
    });
    Some(RestPoint {
        name,
        branch,
        reduced_volume,
        energy: bending / (MEMBRANE_FACTOR * 8.0 * PI),
        curves: curves.collect(),
    })
}

/// The branch, v, W of theory and of the runs, as CSV.
pub(super) fn to_csv(points: &[RestPoint], branches: &[(Branch, Vec<ClosedSurface>)]) -> String {
    let mut text = "branch,point,v,W,W of theory\n".to_owned();
    for (branch, surfaces) in branches {
        for ClosedSurface {
            reduced_volume,
            energy,
            ..
        } in surfaces
        {
            text += &format!("{},,{reduced_volume},,{energy}\n", branch.name());
        }
    }
    for point in points {
        let theory = point.branch.surface(point.reduced_volume);
        let theory = theory.map_or(String::new(), |it| it.energy.to_string());
        text += &format!(
            "{},{},{},{},{theory}\n",
            point.branch.name(),
            point.name,
            point.reduced_volume,
            point.energy
        );
    }
    text
}

fn colour(branch: Branch) -> RGBColor {
    LINE_COLOURS[match branch {
        Branch::Prolate => 0,
        Branch::Oblate => 1,
        Branch::Stomatocyte => 2,
    }]
}

/// # Errors
/// [`FigureError::Draw`].
pub(super) fn draw(
    title: &Label,
    points: &[RestPoint],
    branches: &[(Branch, Vec<ClosedSurface>)],
    width: u32,
    size: f64,
) -> Result<Drawing, FigureError> {
    let margin = 0.7 * size;
    let most = |pixels: f64, room: f64| ((pixels / (room * size)) as usize).clamp(2, 10);
    let whole = f64::from(width) - 2.0 * margin;
    let y = Axis::new(RANGES[1], most(ASPECT * whole, 1.8));
    let left_room = y.widest(size) + 2.0 * TICKS[0] * size;
    let inner = whole - left_room - 1.5 * size;
    let x = Axis::new(RANGES[0], most(inner, 5.0));
    let lower_room = (2.0 * TICKS[1] + 0.25) * size + 2.0 * line_height(size);
    let line = 1.6 * line_weight(size);
    Drawing::compose(width, |page| {
        let mut top = write_paragraph(page, title, size, [margin, margin], whole)?;
        let lines = branches.iter().map(|(branch, _)| {
            let label = Label::text(&format!("{} (theory)", branch.name()));
            Entry::line(label, None, stroke(colour(*branch), line), size)
        });
        let mark = (Mark::Disc, BLACK.filled());
        let runs = Entry::mark(Label::text("runs at rest"), mark, 0.7 * size);
        let corner = [margin, top + 0.2 * size];
        top = draw_legend(page, lines.chain([runs]).collect(), corner, size)?;
        let at = [margin, top + 0.3 * size];
        top = write_paragraph(page, &Label::symbol("W"), size, at, whole)?;
        let corner = [margin + left_room, top + 0.9 * size];
        let plot = Rectangle::new(corner, [inner, ASPECT * inner]).on_pixels();
        let place = plot.with_room([left_room, 0.0, lower_room]);
        draw_plot(
            &part(page, place),
            [&x, &y],
            [left_room, lower_room],
            (points, branches),
            size,
        )?;
        top = plot.bottom + lower_room + 0.5 * size;
        let unit = unit(points, &x, plot.width(), size);
        for (branch, _) in branches {
            let row: Vec<&RestPoint> = points.iter().filter(|it| it.branch == *branch).collect();
            if row.is_empty() {
                continue;
            }
            let at = [plot.left, top];
            write_label(
                page,
                &Label::text(branch.name()),
                size,
                at,
                (HPos::Left, VPos::Top),
            )?;
            let height = row.iter().map(|it| extent(it)[1]).fold(0.0, f64::max) * unit;
            let middle = top + line_height(size) + 0.5 * height;
            for point in row {
                let center = plot.left + x.place(point.reduced_volume) * plot.width();
                draw_shape(page, point, [center, middle], unit, size)?;
            }
            top += line_height(size) + height + 0.4 * size;
        }
        Ok(top + margin)
    })
}

/// The extents of a shape in x and y, in parts of R₀.
fn extent(point: &RestPoint) -> [f64; 2] {
    let ends = || point.curves.iter().flatten();
    [0, 1].map(|axis| 2.0 * ends().map(|at| at[axis].abs()).fold(0.0, f64::max))
}

/// R₀ in pixels: as large as neighbours have room for.
fn unit(points: &[RestPoint], x: &Axis, width: f64, size: f64) -> f64 {
    let mut unit = LARGEST * size;
    for (number, one) in points.iter().enumerate() {
        for other in &points[number + 1..] {
            if one.branch == other.branch {
                let [a, b] = [one, other].map(|it| x.place(it.reduced_volume));
                let both = 0.5 * (extent(one)[0] + extent(other)[0]);
                unit = unit.min(FILLED * (a - b).abs() * width / both);
            }
        }
    }
    unit.max(0.1 * size)
}

fn draw_shape(
    page: &Page,
    point: &RestPoint,
    [x, y]: [f64; 2],
    unit: f64,
    size: f64,
) -> Result<(), FigureError> {
    for curve in &point.curves {
        let places = curve.iter();
        let places: Vec<(i32, i32)> = places
            .map(|at| (units(x + unit * at[0]), units(y - unit * at[1])))
            .collect();
        let filled = colour(point.branch).filled();
        page.draw(&Polygon::new(places.clone(), filled))?;
        page.draw(&PathElement::new(
            places,
            stroke(BLACK, 0.9 * line_weight(size)),
        ))?;
    }
    Ok(())
}

fn draw_plot(
    page: &Page,
    [x, y]: [&Axis; 2],
    [left_room, lower_room]: [f64; 2],
    (points, branches): (&[RestPoint], &[(Branch, Vec<ClosedSurface>)]),
    size: f64,
) -> Result<(), FigureError> {
    let mut chart = ChartBuilder::on(page)
        .y_label_area_size(units(left_room))
        .x_label_area_size(units(lower_room))
        .build_cartesian_2d(x.clone(), y.clone())?;
    let thin = stroke(BLACK, 0.8 * line_weight(size));
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(thin)
        .label_style(font(size))
        .set_tick_mark_size(LabelAreaPosition::Left, units(TICKS[0] * size))
        .set_tick_mark_size(LabelAreaPosition::Bottom, units(TICKS[1] * size))
        .x_desc(Label::symbol("v"))
        .draw()?;
    let [(left, right), (low, high)] = RANGES.map(<(f64, f64)>::from);
    let is_shown = |v: f64, w: f64| (left..=right).contains(&v) && (low..=high).contains(&w);
    for (branch, surfaces) in branches {
        let line = surfaces.iter().map(|it| (it.reduced_volume, it.energy));
        // The symmetric branches begin at the sphere.
        let sphere = (*branch != Branch::Stomatocyte).then_some((1.0, 1.0));
        let line = sphere
            .into_iter()
            .chain(line)
            .filter(|(v, w)| is_shown(*v, *w));
        let style = stroke(colour(*branch), 1.6 * line_weight(size));
        chart.draw_series(LineSeries::new(line, style))?;
    }
    for (_, v, w) in CROSSINGS {
        let [dash, space] = [0.25, 0.25].map(|length| units(length * size).max(1));
        let down = [(v, w), (v, low)];
        chart.draw_series(DashedLineSeries::new(down, dash, space, thin))?;
        let label = Label::text(&format!("{v:.3}"));
        let style = font(0.85 * size);
        let text = Text::new(
            String::from(label),
            (units(0.3 * size), units(-1.3 * size)),
            style,
        );
        chart.draw_series(once(EmptyElement::at((v, low)) + text))?;
    }
    for point in points {
        let at = (point.reduced_volume, point.energy);
        if is_shown(at.0, at.1) {
            let fill = colour(point.branch).filled();
            let disc = marker((0, 0), Mark::Disc, size, BLACK.filled());
            let inner = marker((0, 0), Mark::Disc, 0.7 * size, fill);
            chart.draw_series(once(EmptyElement::at(at) + disc + inner))?;
        }
    }
    let sides = [(left, high), (right, high), (right, low)];
    chart.draw_series(once(PathElement::new(sides, thin)))?;
    Ok(())
}
