//! Pictures as a whole: their text, their pixels, their files.

use super::canvas::{Drawing, Rectangle, write_label};
use super::colour::Scale;
use super::curves::Event;
use super::data::RunLabel;
use super::strip::Strip;
use super::text::Label;
use super::*;
use crate::fem::Mesh;
use crate::geometry::Point;
use crate::record::Columns;
use crate::record::{MarkKind, RunMark, ShortNumber};
use crate::scene::{Anchoring, AnchoringKind, Area, Assignment, Change, ParameterValue, Scene};
use crate::scheme::State;
use crate::simulation::{NamedValue, OutlineMeasure, Report, Vesicle};
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;
use std::sync::Arc;

mod axes;
mod files;
mod memory;

/// Two frames' places, in pixels.
const ROUNDING: f64 = 1.0 / super::canvas::UNITS;

pub const WIDTHS: [u32; 5] = [400, 640, 1200, 2000, 4000];

fn scene(name: &str) -> Scene {
    Scene {
        name: name.to_owned(),
        area: Some(Area::default()),
        nematic: Some(crate::scene::Nematic::default()),
        anchoring: Some(Anchoring {
            kind: AnchoringKind::Homeotropic,
            weight: 10.1,
        }),
        ..Scene::default()
    }
}

/// A circle of this radius with a director that turns.
fn state(mesh: &Mesh, radius: f64) -> State {
    let phi = |p: &Point| ((radius - (p.x - 0.5).hypot(p.y - 0.5)) / 0.06).tanh();
    let phi: Vec<f64> = mesh.nodes().iter().map(phi).collect();
    let angle = |p: &Point| 3.0 * p.x - 2.0 * p.y;
    let part = |turn: fn(f64) -> f64| mesh.nodes().iter().map(|p| turn(angle(p))).collect();
    State {
        omega: phi.iter().map(|phi| 400.0 * phi).collect(),
        mu: phi.iter().map(|phi| -1e5 * phi).collect(),
        director: Some([part(f64::cos), part(f64::sin)]),
        phi,
    }
}

fn report(step: u64) -> Report {
    let t = step as f64 * 2.5e-7;
    let decay = (-(step as f64) / 300.0).exp();
    let energies = [
        ("bending", 36.0 + decay),
        ("area", 1e-5 * decay),
        ("nematic", 55.0 * (1.0 - decay)),
        ("anchoring", 500.0 * decay),
    ];
    Report {
        step,
        t,
        energies: energies
            .map(|(name, value)| NamedValue { name, value })
            .into(),
        total_energy: energies.iter().map(|(_, value)| value).sum(),
        phase_integral: -0.75 + 1e-16 * (step % 7) as f64,
        surface_area: 1.5 + 0.2 * (1.0 - decay),
        vesicles: vec![Vesicle {
            area: 0.12,
            perimeter: 1.478,
            outline: Some(OutlineMeasure {
                length: 0.64,
                waist: 0.18 * decay,
                width: 0.25,
            }),
            ..Vesicle::default()
        }],
        ..Report::default()
    }
}

fn run(name: &str, title: &str, snapshots: u64) -> RunData {
    let mesh = Arc::new(Mesh::structured(24, 0.0, 1).expect("a fair mesh"));
    let mut history = Columns::default();
    for step in 0..=1000 {
        history.push(&report(step));
    }
    let snapshot = |number: u64| Snapshot {
        step: 250 * number,
        t: report(250 * number).t,
        mesh: mesh.clone(),
        state: Arc::new(state(&mesh, 0.2 + 0.05 * number as f64)),
    };
    RunData {
        name: name.to_owned(),
        scene: Arc::new(scene(title)),
        snapshots: (0..snapshots).map(snapshot).collect(),
        history,
        marks: Vec::new(),
        theory: None,
        command: format!("vesica figures {name}"),
    }
}

fn options(width: u32) -> FigureOptions {
    FigureOptions {
        width,
        ..FigureOptions::default()
    }
}

/// Every drawing of these runs at this width.
fn drawings(runs: &[RunData], width: u32) -> Vec<(&'static str, Drawing)> {
    let options = options(width);
    let labels = RunLabel::of_all((runs.iter()).map(|run| (&*run.name, &*run.scene)));
    let mut strips = Vec::new();
    for (run, label) in runs.iter().zip(&labels) {
        strips.push(Strip {
            title: Label::text(&label.title),
            snapshots: data::five(&run.snapshots),
            theory: run.theory.as_deref(),
        });
    }
    let mut drawings = vec![(
        "strip",
        strip::draw(&strips, &options).expect("room for it"),
    )];
    let keys = scalars::keys(&labels);
    for figure in scalars::figures(runs, &labels) {
        let title = Label::text(&labels[0].title);
        drawings.push((
            figure.file,
            curves::draw(&title, &keys, (&figure.plots, None), &options).expect("it is drawn"),
        ));
    }
    drawings
}

/// The view of a run's first snapshot.
fn first_view<'a>(run: &'a RunData, report: &'a Report, field: Field) -> View<'a> {
    View {
        name: &run.name,
        scene: &run.scene,
        mesh: &run.snapshots[0].mesh,
        state: &run.snapshots[0].state,
        report,
        field,
        theory: None,
        command: "",
    }
}

/// How many fields there are views of.
const FIELDS: usize = 5;

/// The views of a run at this width, of these of the fields.
fn views(run: &RunData, width: u32, which: Range<usize>) -> Vec<(&'static str, Drawing)> {
    let mut drawings = Vec::new();
    let label = RunLabel::new(&run.name, &run.scene, f64::INFINITY);
    let interface_width = run.scene.membrane.interface_width;
    let density = Field::BendingDensity { interface_width };
    let fields: [_; FIELDS] = [
        (Field::Phase, "view of φ"),
        (Field::DirectorLength, "view of |d|"),
        (Field::Bending, "view of ω"),
        (Field::Potential, "view of μ"),
        (density, "view of ε/2 ω²"),
    ];
    for &(field, name) in &fields[which] {
        let report = report(run.snapshots[0].step);
        let view = first_view(run, &report, field);
        let drawing = view::draw(&view, &label, &options(width));
        drawings.push((name, drawing.expect("room for it")));
    }
    drawings
}

/// All text is inside of the picture, no text is on another or on an image, nothing is outside.
#[track_caller]
pub fn assert_tidy(name: &str, drawing: &Drawing) {
    let (width, height) = (f64::from(drawing.width), f64::from(drawing.height));
    let place = format!("{name} at {width} × {height}");
    assert!(!drawing.texts.is_empty(), "{place} has no text");
    for (number, text) in drawing.texts.iter().enumerate() {
        let frame = text.frame;
        assert!(
            frame.left >= 0.0 && frame.top >= 0.0 && frame.right <= width && frame.bottom <= height,
            "{place}: '{}' leaves the picture: {frame:?}",
            text.text
        );
        let meets = |other: &Rectangle| {
            // Lines under each other touch, to the rounding of their places.
            frame.left + ROUNDING < other.right
                && other.left + ROUNDING < frame.right
                && frame.top + ROUNDING < other.bottom
                && other.top + ROUNDING < frame.bottom
        };
        for other in &drawing.texts[number + 1..] {
            assert!(
                !meets(&other.frame),
                "{place}: '{}' {frame:?} and '{}' {:?} overlap",
                text.text,
                other.text,
                other.frame
            );
        }
        for image in &drawing.images {
            assert!(
                !meets(&image.place),
                "{place}: '{}' is on an image",
                text.text
            );
        }
    }
    for shape in &drawing.shapes {
        let (bounds, half) = (shape.path.bounds(), 0.5 * shape.stroke.unwrap_or(0.0));
        let sides = [bounds.left(), bounds.top()].map(|side| f64::from(side - half));
        let [right, bottom] = [bounds.right(), bounds.bottom()].map(|side| f64::from(side + half));
        assert!(
            sides.iter().all(|side| *side >= 0.0) && right <= width && bottom <= height,
            "{place}: something is drawn at {bounds:?}"
        );
    }
}

#[test]
fn text_is_whole_and_apart_at_every_size() {
    let long = "A vesicle whose name is far too long for one line of any picture of a small size, \
                and which goes onwithoutanyspaceforquiteawhileasnamesthatmachinesmakeoftendo";
    for width in WIDTHS {
        for snapshots in [1, 2, 3, 5] {
            let runs = [run("a", "Case 3", snapshots)];
            for (name, drawing) in drawings(&runs, width) {
                assert_tidy(name, &drawing);
            }
        }
        // Their pictures of sixteen million pixels differ in a word: the one with the longest will do.
        let first = if width == 4000 { FIELDS - 1 } else { 0 };
        for (name, drawing) in views(&run("a", long, 1), width, first..FIELDS) {
            assert_tidy(name, &drawing);
        }
        let runs = [
            run("a", long, 5),
            run("b", "Case 2", 3),
            run("c", "c", 5),
            run("d", long, 4),
        ];
        for (name, drawing) in drawings(&runs, width) {
            assert_tidy(name, &drawing);
        }
    }
}

#[test]
fn text_is_whole_and_apart_around_the_whole_domain_and_the_middle_of_the_vesicle() {
    let runs = [run("a", "Case 3", 5), run("b", "Case 2", 3)];
    for zoom in [Zoom::Domain, Zoom::Double] {
        for width in [400, 1200] {
            let options = FigureOptions {
                zoom,
                ..options(width)
            };
            let strips = runs.each_ref().map(|run| Strip {
                title: Label::text(&run.name),
                snapshots: data::five(&run.snapshots),
                theory: None,
            });
            assert_tidy(
                "strip",
                &strip::draw(&strips, &options).expect("room for it"),
            );
            let (label, report) = (RunLabel::new("a", &runs[0].scene, f64::INFINITY), report(0));
            let view = first_view(&runs[0], &report, Field::Phase);
            let drawing = view::draw(&view, &label, &options).expect("room for it");
            assert_tidy("view", &drawing);
        }
    }
}

#[test]
fn what_is_logarithmic_leaves_out_the_start() {
    let options = FigureOptions {
        logarithmic_time: true,
        ..options(1200)
    };
    let runs = [run("a", "Case 3", 1)];
    let labels = [RunLabel::new("a", &runs[0].scene, f64::INFINITY)];
    let figure = &scalars::figures(&runs, &labels)[0];
    let title = Label::text("Energies");
    let drawing = curves::draw(&title, &[], (&figure.plots, None), &options).expect("it is drawn");
    assert_tidy("energies", &drawing);
    let texts: Vec<&str> = drawing.texts.iter().map(|text| &*text.text).collect();
    for text in ["10−6", "10−5", "10−4", "(a) Etotal", "(b) Ebending"] {
        assert!(texts.contains(&text), "{text} in {texts:?}");
    }
}

#[test]
fn the_check_of_text_finds_what_is_wrong() {
    let outcome = |at: [f64; 2]| {
        std::panic::catch_unwind(|| {
            let drawing = Drawing::compose(400, |page| {
                let place = (HPos::Left, VPos::Top);
                write_label(page, &Label::text("one"), 20.0, [10.0, 10.0], place)?;
                write_label(page, &Label::text("two"), 20.0, at, place)?;
                Ok(100.0)
            });
            let drawing = drawing.expect("it is drawn");
            assert_tidy("test", &drawing);
        })
    };
    assert!(outcome([100.0, 10.0]).is_ok());
    assert!(outcome([30.0, 15.0]).is_err(), "on each other");
    assert!(outcome([380.0, 10.0]).is_err(), "cut off at the right");
    assert!(outcome([100.0, 90.0]).is_err(), "cut off below");
}

/// Where β changes, its line follows the change, and B is also drawn over it.
#[test]
fn the_target_of_the_area_is_that_of_each_time() {
    let runs = [run("a", "Case 3", 1), {
        let mut squeezed = run("b", "Squeezed", 1);
        let change = Change {
            at: report(500).t,
            over: 0.0,
            set: vec![Assignment {
                key: "area.target".to_owned(),
                value: ParameterValue::Number(0.5),
            }],
        };
        Arc::make_mut(&mut squeezed.scene).changes.push(change);
        squeezed
    }];
    let labels = RunLabel::of_all(runs.iter().map(|run| (&*run.name, &*run.scene)));
    let figures = scalars::figures(&runs, &labels);
    let figure = figures.iter().find(|figure| figure.file == "area-target");
    let [plot] = &figure.expect("one has a target that changes").plots[..] else {
        panic!("one plot");
    };
    let [curve] = &plot.curves[..] else {
        panic!("of the run that changes alone");
    };
    let (start, area) = curve.points[0];
    let target = runs[1].scene.area.expect("it has one").target;
    assert!((start / (target * area) - 1.0).abs() < 1e-12);
    let at = |row: usize| curve.points[row].0 / area;
    for (row, expected) in [(499, target), (500, 0.5), (1000, 0.5)] {
        assert!((at(row) - expected).abs() < 1e-12, "{row}: {}", at(row));
    }
    let alone = scalars::figures(&runs[..1], &labels[..1]);
    assert!(alone.iter().all(|figure| figure.file != "area-target"));
}

#[test]
fn a_scene_has_only_the_energies_of_its_effects() {
    let mut bare = run("a", "Bare", 1);
    bare.history = Columns::default();
    bare.history.push(&Report {
        energies: vec![NamedValue {
            name: "bending",
            value: 1.0,
        }],
        ..Report::default()
    });
    let labels = [RunLabel::new("a", &bare.scene, f64::INFINITY)];
    let figures = scalars::figures(std::slice::from_ref(&bare), &labels);
    let names: Vec<String> = figures[0]
        .plots
        .iter()
        .map(|plot| plot.name.plain())
        .collect();
    assert_eq!(names, ["Etotal", "Ebending"]);
    let files: Vec<&str> = figures.iter().map(|figure| figure.file).collect();
    assert_eq!(files, ["energies", "volume-area"], "it has no outline");
}

#[test]
fn beta_is_the_target_times_the_first_area() {
    let runs = [run("a", "Case 3", 1)];
    let labels = [RunLabel::new("a", &runs[0].scene, f64::INFINITY)];
    let figure = &scalars::figures(&runs, &labels)[1];
    let plot = &figure.plots[1];
    let dashed = plot
        .curves
        .iter()
        .find(|curve| curve.look.pattern == curves::Pattern::Short)
        .expect("β");
    assert_eq!(
        dashed.points,
        [(0.0, 1.25 * 1.5), (report(1000).t, 1.25 * 1.5)]
    );
    let mut lines = figure.table.text().lines();
    assert_eq!(lines.next(), Some("scene,step,t,A_drift,B,beta"));
    assert_eq!(lines.next(), Some("a-homeotropic,0,0,0,1.5,1.875"));
}

#[test]
fn what_is_no_number_does_no_harm() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = run("a", "Case 3", 1);
    let mut broken = state(&run.snapshots[0].mesh, 0.3);
    broken.phi[300] = f64::NAN;
    broken.phi[301] = f64::MAX;
    broken.mu[2] = f64::INFINITY;
    if let Some([x, _]) = &mut broken.director {
        x[310] = f64::NAN;
    }
    run.snapshots[0].state = Arc::new(broken);
    run.history.push(&Report {
        step: 1001,
        t: f64::NAN,
        total_energy: f64::INFINITY,
        ..Report::default()
    });
    for total_energy in [f64::MAX, f64::MIN, 1e300, -1e300] {
        run.history.push(&Report {
            step: 1002,
            t: report(1002).t,
            total_energy,
            ..Report::default()
        });
    }
    save_set(&[run], &options(400), folder.path()).expect("it is saved");
}

#[test]
fn a_colour_bar_has_two_numbers_however_low_it_is() {
    for bound in [0.013, 0.97, 1.0, 1.1, 3.7, 250.0] {
        for height in [10.0, 40.0, 90.0, 400.0] {
            let scale = Scale::signed(super::ColourMap::default(), bound);
            let ticks = panel::bar_axis(&scale, height, 16.0).ticks;
            assert!(ticks.len() > 1, "±{bound}, {height}: {ticks:?}");
        }
    }
}

#[test]
fn a_switched_anchoring_is_named_and_marked() {
    let mut switched = run("a", "A", 3);
    let scene = Arc::make_mut(&mut switched.scene);
    scene.anchoring.get_or_insert_default().kind = AnchoringKind::Homeotropic;
    let t = switched.history.column("t").unwrap()[1];
    let change = |kind: AnchoringKind| Change {
        at: t,
        over: 0.0,
        set: Change::of_anchoring(kind),
    };
    scene.changes = vec![change(AnchoringKind::Parallel)];
    let mark = |kind: MarkKind| RunMark { step: 1, t, kind };
    let changed = MarkKind::Change {
        label: "parallel".to_owned(),
        work: None,
    };
    switched.marks = vec![mark(changed), mark(MarkKind::Mesh)];
    let label = RunLabel::new(&switched.name, &switched.scene, f64::INFINITY);
    assert_eq!(label.file, "a-homeotropic-parallel");
    assert_eq!(
        label.title,
        format!("A, homeotropic, from t = {} parallel", ShortNumber(t))
    );
    let before = RunLabel::new(&switched.name, &switched.scene, t);
    assert_eq!(before.title, "A, homeotropic");

    let runs = [switched];
    for figure in scalars::figures(&runs, &[label]) {
        for plot in &figure.plots {
            let marks: Vec<_> = plot.marks.iter().map(|mark| (mark.event, mark.t)).collect();
            assert_eq!(marks, [(Event::Change, t), (Event::Mesh, t)]);
        }
    }

    let mut often = (*runs[0].scene).clone();
    often.changes = [AnchoringKind::None; 9].map(change).to_vec();
    let label = RunLabel::new("a", &often, f64::INFINITY);
    assert_eq!(label.file, "a-homeotropic-none-none-none-and-so-on");
    assert!(label.title.ends_with(", and 6 more"), "{}", label.title);
}

/// Marks are grey and thin, each kind with a line of its own that the foot of the figure explains; only those that are there.
#[test]
fn what_the_marks_of_curves_mean_is_said_at_the_foot() {
    let mark = |kind: MarkKind| RunMark {
        step: 500,
        t: report(500).t,
        kind,
    };
    let words = |marks: Vec<RunMark>, width: u32| {
        let mut run = run("a", "Case 3", 1);
        run.marks = marks;
        let runs = [run];
        let all = drawings(&runs, width);
        let (_, drawing) = all.iter().find(|(name, _)| *name == "energies").unwrap();
        assert_tidy("energies", drawing);
        let grey = (drawing.shapes.iter()).filter(|shape| shape.colour == super::colour::GREY);
        let strokes: Vec<f32> = grey.filter_map(|shape| shape.stroke).collect();
        let curve = super::colour::LINE_COLOURS[0];
        let curves = (drawing.shapes.iter()).filter(|shape| shape.colour == curve);
        let thinnest = curves
            .filter_map(|shape| shape.stroke)
            .fold(f32::MAX, f32::min);
        assert!(strokes.iter().all(|width| *width < thinnest));
        let last = drawing.texts.iter().map(|text| text.text.clone());
        let last: String = last.collect::<Vec<_>>().join(" ");
        let is_said = [
            "the anchoring changes",
            "touch the wall",
            "the mesh follows",
        ];
        (is_said.map(|words| last.contains(words)), strokes.len())
    };
    let change = || MarkKind::Change {
        label: "parallel".to_owned(),
        work: None,
    };
    assert_eq!(words(vec![], 1200), ([false; 3], 0));
    // A line in each of the five plots, and the one of the legend.
    assert_eq!(words(vec![mark(change())], 1200), ([true, false, false], 6));
    // At the start it would lie on the axis.
    let at_the_start = RunMark {
        t: report(1).t,
        ..mark(change())
    };
    assert_eq!(words(vec![at_the_start], 1200), ([false; 3], 0));
    let (said, strokes) = words(vec![mark(MarkKind::Mesh)], 1200);
    assert!(
        said == [false, false, true] && strokes > 60,
        "{strokes} dots"
    );
    for width in WIDTHS {
        let all = vec![mark(change()), mark(MarkKind::Wall), mark(MarkKind::Mesh)];
        assert_eq!(words(all, width).0, [true; 3]);
    }
}
