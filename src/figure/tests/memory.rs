//! What drawing and saving take of memory, against what is set aside for it.

use super::super::needs::bytes_of_picture;
use super::super::provenance::Provenance;
use super::super::*;
use super::*;
use crate::study::memory;

/// The most that the heap held beyond what it held before, in bytes.
fn most<T>(work: impl FnOnce() -> T) -> (u64, T) {
    let before = memory::forget_most();
    let done = work();
    (
        u64::try_from(memory::most() - before).expect("it took some"),
        done,
    )
}

/// At least what it takes, and no more than three times that (of small pictures).
#[test]
fn what_a_picture_takes_is_foreseen() {
    let run = run("case3", "Case 3", 5);
    for width in [400, 2000] {
        let mut drawn = drawings(std::slice::from_ref(&run), width);
        drawn.extend(views(&run, width, 0..1));
        for (name, drawing) in drawn {
            let provenance = Provenance::plain("a", "b");
            let (png, _) = most(|| {
                let pixels = pixels::pixels(&drawing).expect("it is drawn");
                png::encode(&pixels, drawing.width, drawing.height, 300, &provenance)
                    .expect("it is encoded")
            });
            let (svg, _) =
                most(|| svg::encode(&drawing, false, 300, &provenance).expect("it is encoded"));
            let foreseen = bytes_of_picture(&drawing);
            let [png, svg, foreseen] = [png, svg, foreseen].map(|bytes| bytes as f64 / 1e6);
            println!(
                "{name:>24} {width:>5} × {:>5}: PNG {png:6.2}, SVG {svg:6.2}, foreseen {foreseen:6.2}",
                drawing.height
            );
            let taken = png.max(svg);
            assert!(taken <= foreseen, "{name} at {width}");
            assert!(foreseen <= 3.0 * taken + 2.1, "{name} at {width}");
        }
    }
}

/// All of a set: the claims are made one after the other, and none is far below what is taken in its time.
#[test]
fn what_a_set_takes_is_a_picture_and_its_drawing() {
    let run = run("case3", "Case 3", 5);
    let folder = tempfile::tempdir().expect("a folder");
    for (width, bound) in [(400, 16e6), (2000, 40e6)] {
        let folder = folder.path().join(width.to_string());
        let (taken, files) =
            most(|| save_set(std::slice::from_ref(&run), &options(width), &folder));
        files.expect("it is saved");
        println!("a set at {width} px: {:.2}", taken as f64 / 1e6);
        assert!((taken as f64) < bound, "{taken}");
    }
}
