//! Sweeps of tables that are made up: every number has its place, and nothing is outside of the picture.

use super::branches::RestPoint;
use super::*;
use crate::figure::tests::{WIDTHS, assert_tidy};

fn dimension(key: &str, number: usize, spacing: Spacing, values: &[&str]) -> Dimension {
    Dimension {
        key: key.to_owned(),
        number,
        spacing,
        values: values.iter().map(|it| (*it).to_owned()).collect(),
    }
}

fn arranged(y: Option<Dimension>, panels: usize) -> Arranged {
    let x = dimension(
        "anchoring.weight",
        0,
        Spacing::Logarithmic,
        &["1", "10", "100"],
    );
    let rows = y.as_ref().map_or(1, |y| y.values.len());
    let cell = |number: usize| Cell {
        // One failed, and one is not there.
        value: (number != 1).then_some(number as f64),
        count: 1,
        row: (number != 2).then_some(number),
    };
    Arranged {
        title: "A study".to_owned(),
        column: "waist/length".to_owned(),
        panels: (0..panels)
            .map(|panel| Panel {
                title: match panels {
                    1 => String::new(),
                    _ => format!("anchoring.kind = {panel}"),
                },
                cells: (0..3 * rows).map(cell).collect(),
            })
            .collect(),
        x,
        y,
        columns: 2,
        extent: None,
        scale: Scale::between([0.0, 3.0 * rows as f64]),
    }
}

fn circle(radius: f64) -> Vec<[f64; 2]> {
    (0..=60)
        .map(|n| std::f64::consts::TAU * f64::from(n) / 60.0)
        .map(|angle| [0.5 + radius * angle.cos(), 0.5 + 1.5 * radius * angle.sin()])
        .collect()
}

#[test]
fn every_figure_is_tidy_at_every_width() {
    let y = || {
        dimension(
            "area.target",
            1,
            Spacing::Linear,
            &["0.9", "1", "1.1", "1.2"],
        )
    };
    let words = dimension(
        "anchoring.kind",
        1,
        Spacing::Listed,
        &["'none'", "\"parallel\""],
    );
    let outlines = Outlines {
        curves: (0..12)
            .filter(|row| *row != 1)
            .map(|row| (row, vec![circle(0.1 + 0.01 * row as f64)]))
            .collect(),
    };
    for width in WIDTHS {
        let size = text_size(width, TEXT_SIZES_A_WIDTH);
        for (y, panels) in [
            (None, 1),
            (Some(y()), 1),
            (Some(y()), 4),
            (Some(words.clone()), 2),
        ] {
            let arranged = arranged(y, panels);
            let drawing = curves::draw(&arranged, width, size).expect("it is drawn");
            assert_tidy("curves", &drawing);
            if arranged.y.is_some() {
                let drawing = map::draw(&arranged, width, size).expect("it is drawn");
                assert_tidy("map", &drawing);
            }
            let drawing = shapes::draw(&arranged, &outlines, width, size).expect("it is drawn");
            assert_tidy("shapes", &drawing);
            let colour = arranged.scale.at(0.0);
            assert!(drawing.shapes.iter().any(|shape| shape.colour == colour));
        }
    }
}

#[test]
fn logarithmic_places_are_even_and_edges_half_way() {
    let axis = PlaceAxis::new(&dimension("a.b", 0, Spacing::Listed, &["1", "10", "100"]));
    assert_eq!(axis.places, [0.0, 1.0, 2.0]);
    assert_eq!(axis.edges, [-0.5, 0.5, 1.5, 2.5]);
    let axis = PlaceAxis::new(&dimension("a.b", 0, Spacing::Listed, &["1", "2", "4.5"]));
    assert_eq!(axis.places[2], 4.5_f64.log10());
    let axis = PlaceAxis::new(&dimension("a.b", 0, Spacing::Listed, &["0.9", "1", "1.1"]));
    assert_eq!(axis.places, [0.9, 1.0, 1.1]);
    let words = dimension("a.b", 0, Spacing::Listed, &["\"x\"", "[1.0, 0.0]"]);
    assert_eq!(PlaceAxis::new(&words).places, [0.0, 1.0]);
    assert_eq!(words.place("x"), Some(0));
    assert_eq!(PlaceAxis::nothing().edges, [-0.5, 0.5]);
}

/// A point on a branch at v + `beside`, with the shape of theory.
fn rest_point(branch: Branch, v: f64) -> RestPoint {
    let surface = branch.surface(v).expect("it is on the branch");
    let meridian = surface.meridian.iter();
    let right: Vec<[f64; 2]> = meridian.map(|at| [at.x, at.y]).collect();
    let left = right.iter().rev().map(|[x, y]| [-x, *y]);
    let curve: Vec<[f64; 2]> = right.iter().copied().chain(left).collect();
    RestPoint {
        name: format!("{v}"),
        branch,
        reduced_volume: v,
        energy: surface.energy,
        curves: vec![curve],
    }
}

#[test]
fn the_branches_are_tidy_at_every_width() {
    let lines = Branch::ALL.map(|branch| (branch, branch.surfaces(0.55).expect("theory")));
    let mut points: Vec<RestPoint> = [0.9, 0.8, 0.7, 0.6]
        .iter()
        .flat_map(|v| [Branch::Prolate, Branch::Oblate].map(|branch| rest_point(branch, *v)))
        .collect();
    points.push(rest_point(Branch::Stomatocyte, 0.6));
    for width in WIDTHS {
        let size = text_size(width, TEXT_SIZES_A_WIDTH);
        let title = Label::text("A study");
        let drawing = branches::draw(&title, &points, &lines, width, size).expect("it is drawn");
        assert_tidy("branches", &drawing);
    }
    let csv = branches::to_csv(&points, &lines);
    let row = csv.lines().last().expect("a row");
    let cells: Vec<&str> = row.split(',').collect();
    assert_eq!(cells[..3], ["stomatocyte", "0.6", "0.6"]);
    let [own, theory] = [3, 4].map(|cell| cells[cell].parse::<f64>().expect("a number"));
    assert!((own / theory - 1.0).abs() < 1e-9 && (own - 1.97738).abs() < 1e-5);
}

/// Theory's own meridians as contours: each is known by its shape, and has its v.
#[test]
fn a_shape_tells_its_branch() {
    for (branch, v) in [
        (Branch::Prolate, 0.7),
        (Branch::Oblate, 0.9),
        (Branch::Oblate, 0.6),
        (Branch::Stomatocyte, 0.65),
        (Branch::Stomatocyte, 0.6),
    ] {
        let meridian = branch.surface(v).expect("it is on the branch").meridian;
        let place = |at: crate::geometry::Point| at * 0.2;
        // From the lower pole up, so that the inside is on the left.
        let pairs = meridian.windows(2).rev();
        let segments: Vec<_> = pairs.map(|pair| [place(pair[1]), place(pair[0])]).collect();
        let disc = |[a, b]: &[crate::geometry::Point; 2]| {
            let squares = a.x * a.x + a.x * b.x + b.x * b.x;
            std::f64::consts::PI / 3.0 * squares * (b.y - a.y)
        };
        let contour = Contour {
            area: 0.0,
            volume: Some(segments.iter().map(disc).sum()),
            segments,
        };
        let point = branches::rest_point(String::new(), 23.695, contour).expect("a vesicle");
        assert_eq!(point.branch, branch, "{v}");
        assert!((point.reduced_volume - v).abs() < 1e-3, "{branch:?} {v}");
        assert!((point.energy - 1.0).abs() < 1e-4);
    }
}
