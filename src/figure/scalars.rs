//! Which scalars of a run are plotted, and how they are called.

use super::colour::LINE_COLOURS;
use super::curves::{Curve, Event, Look, Mark, Pattern, Plot};
use super::data::{RunData, RunLabel};
use super::number::extent;
use super::table::Table;
use super::text::Label;
use crate::fem::center_and_axis;
use crate::geometry::Point;
use crate::record::{MarkKind, RunMark};
use crate::scene::{Boundary, Mesh, Timetable};
use crate::theory::{RoundBody, RoundVesicle, ShapeAtRest};
use std::f64::consts::PI;

/// A figure of scalars: its plots, and the same as a table.
pub(super) struct ScalarFigure {
    /// In the name of its files.
    pub file: &'static str,
    /// In its title.
    pub what: &'static str,
    /// What its plots are over, if that is not t.
    pub abscissa: Option<Label>,
    pub plots: Vec<Plot>,
    pub table: Table,
}

/// A scalar of each run, in the order of the runs; `None` where a run does not have it.
struct Scalar {
    /// In the table.
    column: String,
    name: Label,
    note: Label,
    values: Vec<Option<Vec<f64>>>,
    /// What is aimed at or expected, of each run, dashed, with its column.
    target: Option<(String, Vec<Option<Vec<f64>>>)>,
}

impl Scalar {
    fn new(runs: &[RunData], column: &str, name: Label) -> Scalar {
        let values = |run: &RunData| run.history.known(column).map(<[f64]>::to_vec);
        Scalar {
            column: column.to_owned(),
            name,
            note: Label::default(),
            values: runs.iter().map(values).collect(),
            target: None,
        }
    }

    fn is_known(&self) -> bool {
        self.values.iter().any(Option::is_some)
    }
}

/// What the lines of several runs stand for.
pub(super) fn keys(labels: &[RunLabel]) -> Vec<(Label, Look)> {
    let key = |(label, look): (&RunLabel, Look)| (Label::text(&label.title), look);
    labels.iter().zip(looks(labels.len())).map(key).collect()
}

/// How the lines of the runs are broken, group by group.
const PATTERNS: [Pattern; 3] = [Pattern::Solid, Pattern::Long, Pattern::Dots];

/// How the lines of so many runs look. Where there are more than colours, they make groups that are
/// equal but for the dashes: the paper's four cases with one anchoring and then with the other have the
/// colours in pairs, and where a line of the second group covers one of the first, both are seen.
fn looks(count: usize) -> impl Iterator<Item = Look> {
    let groups = count.div_ceil(LINE_COLOURS.len()).clamp(1, PATTERNS.len());
    let in_a_group = count.div_ceil(groups).clamp(1, LINE_COLOURS.len());
    let colours = &LINE_COLOURS[..in_a_group];
    PATTERNS
        .into_iter()
        .flat_map(move |pattern| colours.iter().map(move |&colour| Look { colour, pattern }))
        .cycle()
}

/// What the files of these figures are called by.
pub(super) const FILES: [&str; 4] = ["energies", "volume-area", "outline", AREA_OVER_TARGET];

/// B over β, where β changes.
const AREA_OVER_TARGET: &str = "area-target";

/// The figures of scalars that the runs have data for.
pub(super) fn figures(runs: &[RunData], labels: &[RunLabel]) -> Vec<ScalarFigure> {
    let titles = ["Energies", "Volume and surface area", "Size of the vesicle"];
    let scalars = [energies(runs), volume_and_area(runs), outline(runs)];
    FILES
        .into_iter()
        .zip(titles)
        .zip(scalars)
        .filter_map(|((file, what), scalars)| figure(file, what, scalars, runs, labels))
        .chain(area_over_target(runs, labels))
        .collect()
}

/// B over β of the runs whose β changes: whether the shape comes back with it.
fn area_over_target(runs: &[RunData], labels: &[RunLabel]) -> Option<ScalarFigure> {
    let mut table = Table::new(&["scene", "step", "t", "beta", "B"].map(str::to_owned));
    let mut curves = Vec::new();
    for ((run, label), look) in runs.iter().zip(labels).zip(looks(runs.len())) {
        let Some(targets) = target_area(run).filter(|targets| changes(targets)) else {
            continue;
        };
        let [steps, times, areas] =
            ["step", "t", "B"].map(|column| run.history.known(column).unwrap_or_default());
        let points = targets.iter().copied().zip(areas.iter().copied());
        curves.push(Curve {
            points: points.clone().collect(),
            look,
        });
        for ((step, t), (target, area)) in steps.iter().zip(times).zip(points) {
            let cells = [*step, *t, target, area].map(Some);
            table.row(&label.file, cells);
        }
    }
    let plot = Plot {
        name: Label::symbol("B"),
        note: Label::default(),
        curves,
        // Over β a time has no place.
        marks: Vec::new(),
    };
    (!plot.curves.is_empty()).then(|| ScalarFigure {
        file: AREA_OVER_TARGET,
        what: "Surface area over its target",
        abscissa: Some(Label::symbol("β")),
        plots: vec![plot],
        table,
    })
}

/// Whether not all values are the same.
fn changes(values: &[f64]) -> bool {
    values.windows(2).any(|pair| pair[0] != pair[1])
}

fn figure(
    file: &'static str,
    what: &'static str,
    scalars: Vec<Scalar>,
    runs: &[RunData],
    labels: &[RunLabel],
) -> Option<ScalarFigure> {
    let scalars: Vec<Scalar> = scalars.into_iter().filter(Scalar::is_known).collect();
    if scalars.is_empty() {
        return None;
    }
    Some(ScalarFigure {
        file,
        what,
        abscissa: None,
        table: table(&scalars, runs, labels),
        plots: scalars
            .into_iter()
            .map(|scalar| plot(scalar, runs))
            .collect(),
    })
}

/// E_total, and every part that a run has.
fn energies(runs: &[RunData]) -> Vec<Scalar> {
    let mut columns: Vec<&str> = vec!["E_total"];
    for name in runs.iter().flat_map(|run| run.history.names()) {
        if name.starts_with("E_") && !columns.contains(&name) {
            columns.push(name);
        }
    }
    let scalar = |column: &str| Scalar::new(runs, column, energy_symbol(column));
    columns.into_iter().map(scalar).collect()
}

/// The symbol of a part of the energy, by the name that it has on the screen and in the tables. Parts are weighted as in
/// E_total.
fn energy_symbol(column: &str) -> Label {
    Label::symbol("E").below(column.trim_start_matches("E_"))
}

/// ∫φ against its first value, and B with β.
fn volume_and_area(runs: &[RunData]) -> Vec<Scalar> {
    let phase = Label::text("∫").and_symbol("φ");
    let start = phase.clone().above("0");
    let name = Label::text("(")
        .and_label(phase)
        .and(" − ")
        .and_label(start)
        .and(")");
    let mut drift = Scalar::new(runs, "A", name);
    drift.column = "A_drift".to_owned();
    for values in drift.values.iter_mut().flatten() {
        let start = values.first().copied().unwrap_or(0.0);
        values.iter_mut().for_each(|value| *value -= start);
    }
    let mut area = Scalar::new(runs, "B", Label::symbol("B"));
    let targets: Vec<Option<Vec<f64>>> = runs.iter().map(target_area).collect();
    if targets.iter().any(Option::is_some) {
        area.note = Label::text("  (dashed: ").and_symbol("β").and(")");
        area.target = Some(("beta".to_owned(), targets));
    }
    vec![drift, area]
}

/// β = area.target·B(φ⁰) in each row, if the run's history begins at φ⁰; no number where there is no target.
fn target_area(run: &RunData) -> Option<Vec<f64>> {
    let is_whole = run.history.column("step")?.first() == Some(&0.0);
    let start = *run.history.known("B")?.first().filter(|_| is_whole)?;
    run.scene.area.as_ref()?;
    let timetable = Timetable::of(&run.scene);
    let target = |t: &f64| timetable.at(*t).area.map_or(f64::NAN, |area| area.target);
    let times = run.history.column("t")?;
    Some(times.iter().map(|t| target(t) * start).collect())
}

/// Length, waist and greatest width of the vesicle, and how it becomes round where theory says how fast.
fn outline(runs: &[RunData]) -> Vec<Scalar> {
    let sizes = ["length", "waist", "width"];
    let mut scalars = Vec::from(sizes.map(|column| Scalar::new(runs, column, Label::text(column))));
    scalars.push(amplitude(runs));
    scalars
}

/// ln a of the vesicles that become round, r = R(1 + a cos 2θ), or r = R(1 + a P₂(cos θ)) in space, with the line of theory from its first value on.
fn amplitude(runs: &[RunData]) -> Scalar {
    let mut lines = Vec::new();
    let mut values = Vec::new();
    for run in runs {
        let rate = decay_rate(run);
        let amplitude = rate.and_then(|_| log_amplitude(run));
        let start = amplitude
            .as_ref()
            .and_then(|values| values.first().copied());
        let times = run.history.column("t").unwrap_or_default();
        let first = times.first().copied().unwrap_or_default();
        let line = start.zip(rate).map(|(start, rate)| {
            let expected = times.iter().map(|t| start - rate * (t - first));
            expected.collect::<Vec<f64>>()
        });
        lines.push(line);
        values.push(amplitude);
    }
    Scalar {
        column: "ln_a".to_owned(),
        name: Label::text("ln ").and_symbol("a"),
        note: Label::text("  (dashed: theory)"),
        values,
        target: Some(("ln_a_theory".to_owned(), lines)),
    }
}

/// Above this amplitude the rate of theory, which is of the first order in it, does not hold.
const LARGEST_AMPLITUDE: f64 = 0.1;

/// ln of (length − waist)/(length + waist); no number where the vesicle is round.
fn log_amplitude(run: &RunData) -> Option<Vec<f64>> {
    let [length, waist] = ["length", "waist"].map(|column| run.history.known(column));
    let pairs = length?.iter().zip(waist?);
    Some(
        pairs
            .map(|(length, waist)| ((length - waist) / (length + waist)).ln())
            .collect(),
    )
}

/// The rate at which the mode n = 2 of a run's vesicle decays, where theory foresees a circle or a sphere, the amplitude is small at
/// the start, and no parameter changes.
fn decay_rate(run: &RunData) -> Option<f64> {
    let start = log_amplitude(run)?.first().copied()?;
    let has_changes = !Timetable::of(&run.scene).is_empty();
    if start.is_nan() || start >= LARGEST_AMPLITUDE.ln() || has_changes {
        return None;
    }
    let membrane = &run.scene.membrane;
    let (mobility, interface_width) = (membrane.mobility, membrane.interface_width);
    let shape = match run.theory.as_deref()? {
        ShapeAtRest::Curve(shape) if shape.elastica.reduced_area == 1.0 => shape,
        ShapeAtRest::Body(body) if body.surface.reduced_volume == 1.0 => {
            let vesicle = RoundBody {
                radius: body.radius,
                mobility,
                interface_width,
                tension: body.tension,
            };
            return vesicle.decay_rate(2);
        }
        _ => return None,
    };
    let first = run.snapshots.first()?;
    let (center, axis) = center_and_axis(&first.mesh, &first.state.phi);
    let is_square =
        !matches!(run.scene.mesh, Mesh::File(_)) && run.scene.boundary == Boundary::Natural;
    let is_in_the_middle = (center - Point::new(0.5, 0.5)).norm() < 0.01;
    let is_along_a_side = (axis.x * axis.y).abs() < 0.05;
    let vesicle = RoundVesicle {
        radius: (shape.enclosed / PI).sqrt(),
        mobility,
        interface_width,
        tension: shape.tension,
        is_in_unit_square: is_square && is_in_the_middle && is_along_a_side,
    };
    vesicle.decay_rate(2)
}

fn plot(scalar: Scalar, runs: &[RunData]) -> Plot {
    let (mut curves, mut events) = (Vec::new(), Vec::new());
    let empty = Vec::new();
    let targets = match &scalar.target {
        Some((_, targets)) => targets,
        None => &empty,
    };
    for (number, (run, look)) in runs.iter().zip(looks(runs.len())).enumerate() {
        let times = run.history.column("t").unwrap_or_default();
        if let Some(Some(target)) = targets.get(number) {
            let mut points: Vec<_> = times.iter().copied().zip(target.iter().copied()).collect();
            if !changes(target) && points.len() > 2 {
                points.drain(1..points.len() - 1);
            }
            curves.push(Curve {
                points,
                look: Look {
                    pattern: Pattern::Short,
                    ..look
                },
            });
        }
        if let Some(values) = &scalar.values[number] {
            let points = times.iter().zip(values).map(|(t, value)| (*t, *value));
            curves.push(Curve {
                points: points.collect(),
                look,
            });
            events.extend(marks(run, values));
        }
    }
    Plot {
        name: scalar.name,
        note: scalar.note,
        curves,
        marks: events,
    }
}

/// An upright line at each mark of a run, as high as its curve; none where there is no value.
fn marks(run: &RunData, values: &[f64]) -> Vec<Mark> {
    let Some(range) = extent(values.iter().copied()) else {
        return Vec::new();
    };
    let line = |mark: &RunMark| Mark {
        event: match mark.kind {
            MarkKind::Mesh => Event::Mesh,
            MarkKind::Change { .. } => Event::Change,
            MarkKind::Vesicles(_) | MarkKind::Wall => Event::Vesicles,
        },
        t: mark.t,
        range,
    };
    run.marks.iter().map(line).collect()
}

fn table(scalars: &[Scalar], runs: &[RunData], labels: &[RunLabel]) -> Table {
    let mut columns = vec!["scene".to_owned(), "step".to_owned(), "t".to_owned()];
    for scalar in scalars {
        columns.push(scalar.column.clone());
        columns.extend(scalar.target.iter().map(|(column, _)| column.clone()));
    }
    let mut table = Table::new(&columns);
    for (number, (run, label)) in runs.iter().zip(labels).enumerate() {
        let [steps, times] =
            ["step", "t"].map(|column| run.history.column(column).unwrap_or_default());
        for (row, (step, t)) in steps.iter().zip(times).enumerate() {
            let mut cells = vec![Some(*step), Some(*t)];
            for scalar in scalars {
                cells.push(
                    scalar.values[number]
                        .as_ref()
                        .and_then(|values| values.get(row).copied()),
                );
                cells.extend(
                    (scalar.target.iter())
                        .map(|(_, targets)| targets[number].as_ref()?.get(row).copied()),
                );
            }
            table.row(&label.file, cells);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_runs_look_alike() {
        for count in 1..=18 {
            let looks: Vec<Look> = looks(count).take(count).collect();
            for (number, look) in looks.iter().enumerate() {
                assert!(!looks[..number].contains(look), "{count}: {look:?}");
            }
        }
        // The paper's eight runs: a colour a case, a dash an anchoring.
        let eight: Vec<Look> = looks(8).take(8).collect();
        for case in 0..4 {
            assert_eq!(eight[case].colour, eight[case + 4].colour);
            assert_ne!(eight[case].pattern, eight[case + 4].pattern);
        }
    }
}
