//! The numbers of the axes of pictures beside each other.

use super::*;
use crate::figure::canvas::PlacedText;

/// Numbers beside each other are at least so far apart, in sizes of the text.
const APART: f64 = 0.5;

/// A strip of five states of a circle of this radius.
fn strip_of(radius: f64, width: u32, zoom: Zoom) -> Drawing {
    let mut run = run("a", "Case 3", 5);
    for snapshot in &mut run.snapshots {
        snapshot.state = Arc::new(state(&snapshot.mesh, radius));
    }
    let strip = Strip {
        title: Label::text("Case 3"),
        snapshots: data::five(&run.snapshots),
        theory: None,
    };
    let options = FigureOptions {
        zoom,
        ..options(width)
    };
    strip::draw(&[strip], &options).expect("room for it")
}

#[test]
fn numbers_of_neighbours_are_apart_and_each_axis_has_two() {
    for width in WIDTHS {
        for (zoom, radius) in [
            (Zoom::Domain, 0.2),
            (Zoom::Fit, 0.15),
            (Zoom::Fit, 0.2),
            (Zoom::Fit, 0.3),
            (Zoom::Double, 0.3),
        ] {
            let drawing = strip_of(radius, width, zoom);
            let place = format!("{width} pixels, {zoom:?}, radius {radius}");
            assert_tidy(&place, &drawing);
            let size = text_size(width, TEXT_SIZES_A_WIDTH);
            let is_number = |text: &&PlacedText| text.text.replace('−', "-").parse::<f64>().is_ok();
            let numbers: Vec<&PlacedText> = drawing.texts.iter().filter(is_number).collect();
            for one in &numbers {
                for other in &numbers {
                    let is_next =
                        one.frame.top == other.frame.top && one.frame.left < other.frame.left;
                    let gap = other.frame.left - one.frame.right;
                    let (one, other) = (&one.text, &other.text);
                    assert!(
                        !is_next || gap > APART * size,
                        "{place}: {one} and {other}: {gap}"
                    );
                }
            }
            // The colour bar is an image too, but narrow.
            let pictures = drawing.images.iter().map(|image| image.place);
            let pictures: Vec<_> = pictures.filter(|it| it.width() > 3.0 * size).collect();
            assert_eq!(pictures.len(), 5, "{place}");
            for picture in pictures {
                let is_below = |text: &&&PlacedText| {
                    let middle = 0.5 * (text.frame.left + text.frame.right);
                    // Where pictures stand under each other the numbers are below each.
                    (picture.left - 1.0..=picture.right + 1.0).contains(&middle)
                        && (picture.bottom..picture.bottom + 1.5 * size).contains(&text.frame.top)
                };
                let below = numbers.iter().filter(is_below).count();
                assert!(below > 1, "{place}: {below} numbers in x");
            }
            let first = drawing.images[0].place;
            let is_beside = |text: &&&PlacedText| {
                let middle = 0.5 * (text.frame.top + text.frame.bottom);
                text.frame.right < first.left
                    && (first.top - 1.0..=first.bottom + 1.0).contains(&middle)
            };
            let beside = numbers.iter().filter(is_beside).count();
            assert!(beside > 1, "{place}: {beside} numbers in y");
        }
    }
}
