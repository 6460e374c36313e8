//! The figures of a sweep: curves over one key, a map over two, small multiples of it over more, and the diagram of
//! shapes, in which the vesicle of each point stands at its place in the plane of two keys.

mod axis;
mod branches;
mod curves;
mod map;
mod page;
mod shapes;

use super::canvas::Drawing;
use super::colour::Scale;
use super::number::extent;
use super::provenance::Provenance;
use super::save::Files;
use super::text::Label;
use super::{Existing, FigureError, FigureOptions, TEXT_SIZES_A_WIDTH, text_size};
use crate::fem::Contour;
use crate::scene::{Geometry, Scene};
use crate::study::sweep::{Plan, Point, Spacing, Sweep, SweepFolder, Table, last_outline, plain};
use crate::theory::{Branch, ClosedSurfaceError};
use axis::PlaceAxis;
use std::path::{Path, PathBuf};

/// Panels of a figure, at most.
const MOST_PANELS: usize = 36;

/// The files of each figure.
const EXTENSIONS: [&str; 3] = ["png", "svg", "csv"];

/// What is shown of a sweep.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SweepView {
    /// The column of the table that is drawn, and that colours the vesicles.
    pub column: String,
    /// The key along the abscissa; else one of numbers with the most values.
    pub x: Option<String>,
    /// The key along the ordinate.
    pub y: Option<String>,
    /// Keys that are held at a value, as TOML or as a bare word.
    pub fixed: Vec<(String, String)>,
    /// Curves over x, one for each y, in place of a map.
    pub curves: bool,
    /// In place of all these: the bending energy over the reduced volume of bodies of rotation, beside the branches of theory.
    pub branches: bool,
}

impl SweepView {
    /// Refuses what no run could make a figure of: to be asked before a sweep is run.
    ///
    /// # Errors
    /// [`SweepFigureError`].
    pub fn check(&self, sweep: &Sweep) -> Result<(), SweepFigureError> {
        let (plan, points, keys) = (&sweep.plan, &sweep.points, sweep.plan.varied_keys());
        if self.branches {
            self.check_keys()?;
            let mut fixed = self.fixed.iter().map(|(key, _)| key);
            if let Some(key) = fixed.find(|key| !keys.contains(key)) {
                let key = key.clone();
                return Err(SweepFigureError::NoAxis { key, keys });
            }
            let is_body = |scene: &Scene| scene.geometry == Geometry::Axisymmetric;
            let has_body = match keys.iter().any(|key| key.starts_with("domain")) {
                false => is_body(&sweep.base),
                true => {
                    let mut scenes = points.iter().filter_map(|point| sweep.scene(point).ok());
                    scenes.any(|scene| is_body(&scene))
                }
            };
            return match has_body {
                true => Ok(()),
                false => Err(SweepFigureError::NoBodies),
            };
        }
        let columns = Table::columns_of(plan);
        // The energies are those of the effects that the points have.
        if !columns.contains(&self.column) && !self.column.starts_with("E_") {
            let column = self.column.clone();
            return Err(SweepFigureError::NoColumn { column, columns });
        }
        Axes::choose(plan, &keys, points, self).map(drop)
    }

    /// Refuses a key that is asked for twice.
    fn check_keys(&self) -> Result<(), SweepFigureError> {
        let axes = [("--x", &self.x), ("--y", &self.y)];
        let axes = axes
            .into_iter()
            .filter_map(|(place, key)| Some((place, key.as_ref()?)));
        let fixed = self.fixed.iter().map(|(key, _)| ("--where", key));
        let mut seen: Vec<(&'static str, &String)> = Vec::new();
        for (place, key) in axes.chain(fixed) {
            if let Some((other, _)) = seen.iter().find(|(_, other)| *other == key) {
                return Err(SweepFigureError::Twice {
                    key: key.clone(),
                    places: [other, place],
                });
            }
            seen.push((place, key));
        }
        Ok(())
    }
}

/// Why there is no figure of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepFigureError {
    /// The table has no such column.
    #[error("the table has no column '{column}'; it has {}", columns.join(", "))]
    NoColumn {
        /// What was asked for.
        column: String,
        /// What there is.
        columns: Vec<String>,
    },
    /// No axis of the plan has this key.
    #[error("'{key}' is no axis of the sweep; they are {}", keys.join(", "))]
    NoAxis {
        /// What was asked for.
        key: String,
        /// What there is.
        keys: Vec<String>,
    },
    /// A key is asked for twice.
    #[error("the key {key} is given twice, with {}: give it once", places.join(" and "))]
    Twice {
        /// The key.
        key: String,
        /// Where: `--x`, `--y` or `--where`.
        places: [&'static str; 2],
    },
    /// An axis does not have this value.
    #[error("{key} is never {value} in the sweep; it is {}", values.join(", "))]
    NoValue {
        /// The axis.
        key: String,
        /// What was asked for.
        value: String,
        /// What there is.
        values: Vec<String>,
    },
    /// There are too many panels.
    #[error(
        "{panels} panels are too many for a figure (at most {MOST_PANELS}): hold some of {} at a value, with \
         --where KEY=VALUE",
        keys.join(", ")
    )]
    TooManyPanels {
        /// How many there would be.
        panels: usize,
        /// The axes that make them.
        keys: Vec<String>,
    },
    /// No point has the shapes that the branches are of.
    #[error(
        "no point is a body of rotation (domain.geometry = \"axisymmetric\") with one vesicle on the axis"
    )]
    NoBodies,
    /// The theory has no branch to draw.
    #[error(transparent)]
    Theory(#[from] ClosedSurfaceError),
    /// Nothing varies.
    #[error("nothing varies: a figure needs an axis, from [vary] of the plan")]
    NoAxes,
    /// No point has a number.
    #[error("no point has a value of {column} yet")]
    NoNumbers {
        /// The column.
        column: String,
    },
    /// The figure cannot be drawn or saved.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// An axis of the plan by its first key.
#[derive(Debug, Clone)]
pub(crate) struct Dimension {
    /// The key.
    pub key: String,
    /// The place of the key among the table's.
    number: usize,
    spacing: Spacing,
    /// As TOML, on one line.
    pub values: Vec<String>,
}

impl Dimension {
    fn is_of_numbers(&self) -> bool {
        self.values.iter().all(|value| numeric(value).is_some())
    }

    /// The place of a value among those of the axis.
    fn place(&self, value: &str) -> Option<usize> {
        let same = |other: &String| match (numeric(other), numeric(value)) {
            (Some(one), Some(other)) => one == other,
            _ => plain(other) == plain(value),
        };
        self.values.iter().position(same)
    }
}

/// A value of TOML that is a number.
fn numeric(value: &str) -> Option<f64> {
    let value: f64 = value.replace('_', "").parse().ok()?;
    Some(value).filter(|value| value.is_finite())
}

/// What stands at a place of the grid: the mean over repetitions.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cell {
    /// Of the column.
    pub value: Option<f64>,
    count: u32,
    /// The number of the first row there.
    pub row: Option<usize>,
}

/// A grid over x and y with the values that the other axes have in it.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    /// The values of the other axes; empty, if there are none.
    pub title: String,
    /// Row by row: y, then x.
    cells: Vec<Cell>,
}

/// A sweep, arranged for drawing.
#[derive(Debug)]
pub(crate) struct Arranged {
    title: String,
    column: String,
    /// From left to right.
    pub x: Dimension,
    /// From below upwards; none, where there is one axis only.
    pub y: Option<Dimension>,
    /// For each combination of the values of the other axes.
    pub panels: Vec<Panel>,
    /// Panels beside each other.
    columns: usize,
    /// The least and the greatest value; `None`: there is none yet.
    pub extent: Option<[f64; 2]>,
    scale: Scale,
}

impl Arranged {
    /// The cell at a place of a panel.
    pub fn cell<'p>(&self, panel: &'p Panel, x: usize, y: usize) -> &'p Cell {
        &panel.cells[y * self.x.values.len() + x]
    }

    /// How many places y has.
    pub fn rows(&self) -> usize {
        self.y.as_ref().map_or(1, |y| y.values.len())
    }

    fn axes(&self) -> [PlaceAxis; 2] {
        let y = match &self.y {
            Some(y) => PlaceAxis::new(y),
            None => PlaceAxis::nothing(),
        };
        [PlaceAxis::new(&self.x), y]
    }

    /// Arranges the rows of a table.
    pub fn new(
        sweep: &SweepFolder,
        table: &Table,
        view: &SweepView,
    ) -> Result<Self, SweepFigureError> {
        let number = table
            .column(&view.column)
            .ok_or_else(|| SweepFigureError::NoColumn {
                column: view.column.clone(),
                columns: table.columns.clone(),
            })?;
        let Axes {
            held,
            x,
            y,
            others: dimensions,
        } = Axes::choose(&sweep.plan, &table.keys, sweep.points(), view)?;
        let mut rows: Vec<usize> = grid_rows(sweep);
        for (dimension, place) in &held {
            rows.retain(|row| {
                let own = &table.rows[*row].values[dimension.number];
                dimension.place(own) == Some(*place)
            });
        }
        let panels: usize = dimensions.iter().map(|it| it.values.len()).product();
        let places = x.values.len() * y.as_ref().map_or(1, |y| y.values.len());
        let mut grids: Vec<Panel> = (0..panels)
            .map(|panel| Panel {
                title: panel_title(&dimensions, panel),
                cells: vec![Cell::default(); places],
            })
            .collect();
        for row in rows {
            let own = &table.rows[row];
            let place = |it: &Dimension| it.place(&own.values[it.number]);
            let panel = dimensions
                .iter()
                .try_fold(0, |panel, it| Some(panel * it.values.len() + place(it)?));
            let (Some(panel), Some(x_place), Some(y_place)) =
                (panel, place(&x), y.as_ref().map_or(Some(0), place))
            else {
                continue;
            };
            let cell = &mut grids[panel].cells[y_place * x.values.len() + x_place];
            cell.row.get_or_insert(row);
            if let Some(value) = own.numbers[number].filter(|it| it.is_finite()) {
                let sum = cell.value.unwrap_or(0.0) * f64::from(cell.count) + value;
                cell.count += 1;
                cell.value = Some(sum / f64::from(cell.count));
            }
        }
        let values = grids.iter().flat_map(|panel| &panel.cells);
        let extent = extent(values.filter_map(|cell| cell.value));
        let [low, high] = extent.unwrap_or([0.0, 1.0]);
        // All the same: a scale needs two ends.
        let room = if high > low {
            0.0
        } else {
            low.abs().max(1.0) * 1e-3
        };
        let columns = match &dimensions[..] {
            [.., last] if dimensions.len() > 1 => last.values.len(),
            _ => panels,
        };
        let fixed = view.fixed.iter();
        let fixed: String = fixed
            .map(|(key, value)| format!(", {key} = {value}"))
            .collect();
        Ok(Arranged {
            title: format!("{}{fixed}", sweep.title()),
            column: view.column.clone(),
            x,
            y,
            panels: grids,
            columns: columns.clamp(1, 4),
            extent,
            scale: Scale::between([low - room, high + room]),
        })
    }
}

/// The axes of a sweep as a view has them.
struct Axes {
    /// Those that are held, at the place of a value.
    held: Vec<(Dimension, usize)>,
    x: Dimension,
    y: Option<Dimension>,
    /// Those that make the panels.
    others: Vec<Dimension>,
}

impl Axes {
    /// Those of a plan with these varied keys and these points.
    fn choose(
        plan: &Plan,
        keys: &[String],
        points: &[Point],
        view: &SweepView,
    ) -> Result<Self, SweepFigureError> {
        view.check_keys()?;
        let mut dimensions = dimensions(plan, keys, points);
        let keys: Vec<String> = dimensions.iter().map(|it| it.key.clone()).collect();
        let no_axis = |key: &String| SweepFigureError::NoAxis {
            key: key.clone(),
            keys: keys.clone(),
        };
        let mut held = Vec::new();
        for (key, value) in &view.fixed {
            let at = dimensions.iter().position(|it| it.key == *key);
            let dimension = dimensions.remove(at.ok_or_else(|| no_axis(key))?);
            let place = dimension
                .place(value)
                .ok_or_else(|| SweepFigureError::NoValue {
                    key: key.clone(),
                    value: value.clone(),
                    values: dimension.values.iter().map(|it| plain(it)).collect(),
                })?;
            held.push((dimension, place));
        }
        dimensions.retain(|dimension| dimension.values.len() > 1);
        let mut choose = |key: &Option<String>| {
            let Some(key) = key else {
                return Ok::<_, SweepFigureError>(None);
            };
            let at = dimensions.iter().position(|it| it.key == *key);
            Ok(Some(dimensions.remove(at.ok_or_else(|| no_axis(key))?)))
        };
        let (x, y) = (choose(&view.x)?, choose(&view.y)?);
        let mut widest = || {
            let of_numbers = |it: &Dimension| (it.is_of_numbers(), it.values.len());
            let best = dimensions.iter().map(of_numbers).max()?;
            let at = dimensions.iter().position(|it| of_numbers(it) == best)?;
            Some(dimensions.remove(at))
        };
        let x = x.or_else(&mut widest).ok_or(SweepFigureError::NoAxes)?;
        let y = y.or_else(&mut widest);
        let panels: usize = dimensions.iter().map(|it| it.values.len()).product();
        if panels > MOST_PANELS {
            let keys = dimensions.into_iter().map(|it| it.key).collect();
            return Err(SweepFigureError::TooManyPanels { panels, keys });
        }
        Ok(Axes {
            held,
            x,
            y,
            others: dimensions,
        })
    }
}

/// The axes of a sweep, each by its first key. A plan of single points alone has one for each key.
fn dimensions(plan: &Plan, keys: &[String], points: &[Point]) -> Vec<Dimension> {
    let one_line = |value: &String| value.split_whitespace().collect::<Vec<_>>().join(" ");
    let number = |key: &String| keys.iter().position(|it| it == key);
    let axes = plan.axes.iter().filter_map(|axis| {
        let key = axis.keys.first()?;
        let values = axis.values.iter().filter_map(|values| values.first());
        Some(Dimension {
            number: number(key)?,
            key: key.clone(),
            spacing: axis.spacing,
            values: values.map(one_line).collect(),
        })
    });
    let mut dimensions: Vec<Dimension> = axes.collect();
    if dimensions.is_empty() {
        for (number, key) in keys.iter().enumerate() {
            let mut dimension = Dimension {
                key: key.clone(),
                number,
                spacing: Spacing::Listed,
                values: Vec::new(),
            };
            for point in points {
                if dimension.place(&point.values[number]).is_none() {
                    dimension.values.push(point.values[number].clone());
                }
            }
            dimensions.push(dimension);
        }
    }
    for dimension in &mut dimensions {
        if dimension.is_of_numbers() {
            let by_value = |a: &String, b: &String| {
                let [a, b] = [a, b].map(|it| numeric(it).unwrap_or(0.0));
                a.total_cmp(&b)
            };
            dimension.values.sort_by(by_value);
            dimension.values.dedup_by(|a, b| numeric(a) == numeric(b));
        }
    }
    dimensions
}

/// The rows of the points that differ in the keys of the axes alone: all that the grid has, and such single points.
fn grid_rows(sweep: &SweepFolder) -> Vec<usize> {
    let axes = &sweep.plan.axes;
    let is_of_axes = |key: &String| {
        axes.is_empty() || key.ends_with("seed") || axes.iter().any(|axis| axis.keys.contains(key))
    };
    let points = sweep.points().iter().enumerate();
    points
        .filter(|(_, point)| point.assignments.iter().all(|it| is_of_axes(&it.key)))
        .map(|(row, _)| row)
        .collect()
}

/// The values of the axes that make the panels, in one of them.
fn panel_title(dimensions: &[Dimension], mut panel: usize) -> String {
    let mut words = Vec::new();
    for dimension in dimensions.iter().rev() {
        let place = panel % dimension.values.len();
        panel /= dimension.values.len();
        words.push(format!(
            "{} = {}",
            dimension.key,
            plain(&dimension.values[place])
        ));
    }
    words.reverse();
    words.join(", ")
}

/// The name of a column on a figure.
fn column_label(column: &str) -> Label {
    match column.split_once('_') {
        Some(("E", effect)) => Label::symbol("E").below(effect),
        _ => Label::text(column),
    }
}

/// Saves the figures of a sweep in a folder, each as PNG, SVG and CSV, and gives the files:
///
/// | file | what it shows |
/// |---|---|
/// | `curves-<column>` | the column over the one axis; of several, with [`SweepView::curves`], a curve for each y |
/// | `map-<column>` | the column in colours over two axes, with contour lines; a panel for each value of the others |
/// | `shapes-<column>` | the last vesicle of each point at its place, coloured by the column |
/// | `branches` | with [`SweepView::branches`], alone: the bending energy at the end over the reduced volume, with the branches of theory |
///
/// With [`Existing::Refuse`] shapes that are there stay as they are, if the other figure is new.
///
/// # Errors
/// [`SweepFigureError`]; the files that were written before it stay.
pub fn save_sweep(
    sweep: &SweepFolder,
    view: &SweepView,
    command: &str,
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, SweepFigureError> {
    options.check()?;
    let table = Table::read(sweep);
    if view.branches {
        view.check_keys()?;
        return save_branches(sweep, &table, view, command, options, folder);
    }
    let arranged = Arranged::new(sweep, &table, view)?;
    if arranged.extent.is_none() {
        let column = view.column.clone();
        return Err(SweepFigureError::NoNumbers { column });
    }
    let outlines = Outlines::read(sweep, &arranged);
    let is_map = arranged.y.is_some() && !view.curves;
    let safe = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let column: String = view.column.chars().map(safe).collect();
    let stems = ["curves", "map"].map(|kind| format!("{kind}-{column}"));
    let mut stems = vec![
        stems[usize::from(is_map)].clone(),
        format!("shapes-{column}"),
    ];
    // Curves that are asked for after a map, or a map after curves, have the same shapes: these stay as they are.
    let [of_first, of_shapes] = [0, 1].map(|number: usize| {
        let path = |extension: &str| folder.join(format!("{}.{extension}", stems[number]));
        let there = EXTENSIONS.iter().filter(|it| path(it).exists());
        there.count()
    });
    let has_shapes = of_first == 0 && of_shapes == EXTENSIONS.len();
    if options.existing == Existing::Refuse && has_shapes {
        stems.truncate(1);
    }
    let draws_shapes = stems.len() > 1;
    let mut files = Files::claim(folder, stems, &EXTENSIONS, options)?;
    let provenance = |what: &str| {
        Provenance::plain(&format!("{what}: {}", arranged.title), command)
            .with("Scene", sweep.scene_text())
            .with("Plan", &sweep.plan.text)
    };
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    // The numbers first: a picture may be what there is no memory for.
    let stem = files.stem(0);
    files.text(&stem, "csv", &table.to_csv())?;
    let drawing: Drawing = match is_map {
        true => map::draw(&arranged, options.width, size)?,
        false => curves::draw(&arranged, options.width, size)?,
    };
    files.picture(&stem, &drawing, options, &provenance(&view.column))?;
    if !draws_shapes {
        return Ok(files.written);
    }
    let stem = files.stem(1);
    files.text(&stem, "csv", &outlines.to_csv(&table))?;
    let drawing = shapes::draw(&arranged, &outlines, options.width, size)?;
    files.picture(&stem, &drawing, options, &provenance("Shapes"))?;
    Ok(files.written)
}

/// The figure of the branches.
fn save_branches(
    sweep: &SweepFolder,
    table: &Table,
    view: &SweepView,
    command: &str,
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, SweepFigureError> {
    let points = branches::rest_points(sweep, table, view)?;
    let lines = Branch::ALL.map(|branch| Ok((branch, branch.surfaces(0.0)?)));
    let lines: Vec<_> = lines
        .into_iter()
        .collect::<Result<_, ClosedSurfaceError>>()?;
    let mut files = Files::claim(folder, vec!["branches".into()], &EXTENSIONS, options)?;
    let stem = files.stem(0);
    files.text(&stem, "csv", &branches::to_csv(&points, &lines))?;
    let title = format!("Bending energy over reduced volume: {}", sweep.title());
    let provenance = Provenance::plain(&title, command)
        .with("Scene", sweep.scene_text())
        .with("Plan", &sweep.plan.text);
    let size = text_size(options.width, TEXT_SIZES_A_WIDTH);
    let drawing = branches::draw(&Label::text(&title), &points, &lines, options.width, size)?;
    files.picture(&stem, &drawing, options, &provenance)?;
    Ok(files.written)
}

/// The outlines of the vesicles that are drawn.
struct Outlines {
    /// Closed curves by the row of the point.
    curves: Vec<(usize, Vec<Vec<[f64; 2]>>)>,
}

impl Outlines {
    fn read(sweep: &SweepFolder, arranged: &Arranged) -> Self {
        let cells = arranged.panels.iter().flat_map(|panel| &panel.cells);
        let curves = cells.filter_map(|cell| {
            let row = cell.row?;
            let contour: Contour = last_outline(&sweep.run(&sweep.points()[row]))?;
            Some((row, super::outline::chain(&contour)))
        });
        Outlines {
            curves: curves.collect(),
        }
    }

    fn of(&self, row: usize) -> Option<&[Vec<[f64; 2]>]> {
        let (_, curves) = self.curves.iter().find(|(own, _)| *own == row)?;
        Some(curves)
    }

    /// Each corner of each outline, with the point that it is of.
    fn to_csv(&self, table: &Table) -> String {
        let mut text = "point,curve,x,y\n".to_owned();
        for (row, curves) in &self.curves {
            let name = &table.rows[*row].name;
            for (number, curve) in curves.iter().enumerate() {
                for [x, y] in curve {
                    text += &format!("{name},{},{x},{y}\n", number + 1);
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests;
