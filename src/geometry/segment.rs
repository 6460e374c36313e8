//! Segments: how far a point is from them, and whether they cross.

use super::{Point, Vector, doubled_area, length};

/// A straight line from one point to another.
pub type Segment = [Point; 2];

/// The shortest way from a segment to a point.
pub fn segment_offset(point: Point, [a, b]: Segment) -> Vector {
    let along = b - a;
    let square = along.norm_squared();
    let offset = point - a;
    let share = if square > 0.0 {
        (offset.dot(&along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    offset - share * along
}

/// The distance of a point from a segment.
pub fn segment_distance(point: Point, segment: Segment) -> f64 {
    length(segment_offset(point, segment))
}

/// The first two segments found that cross, each on either side of the other, and where. Those that
/// have an end in common do not.
pub fn first_crossing(segments: &[Segment]) -> Option<([usize; 2], Point)> {
    // A line sweeps over the plane, such that few segments are parallel to it; those that it meets at
    // one time are compared.
    let along = |point: Point| 0.8 * point.x + 0.6 * point.y;
    let mut sorted: Vec<(f64, f64, usize)> = segments
        .iter()
        .enumerate()
        .map(|(number, ends)| {
            let [a, b] = ends.map(along);
            (a.min(b), a.max(b), number)
        })
        .collect();
    sorted.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
    for (place, &(_, end, first)) in sorted.iter().enumerate() {
        let met = sorted[place + 1..].iter();
        for &(.., second) in met.take_while(|(begin, ..)| *begin <= end) {
            if let Some(at) = crossing(segments[first], segments[second]) {
                return Some(([first.min(second), first.max(second)], at));
            }
        }
    }
    None
}

/// Where two segments cross, each on either side of the other.
fn crossing([a, b]: Segment, [c, d]: Segment) -> Option<Point> {
    let (of_c, of_d) = (doubled_area([a, b, c]), doubled_area([a, b, d]));
    let (of_a, of_b) = (doubled_area([c, d, a]), doubled_area([c, d, b]));
    let are_apart = |one: f64, other: f64| (one > 0.0 && other < 0.0) || (one < 0.0 && other > 0.0);
    (are_apart(of_c, of_d) && are_apart(of_a, of_b)).then(|| {
        let share = of_a / (of_a - of_b);
        a + share * (b - a)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(ends: [[f64; 2]; 2]) -> Segment {
        ends.map(Point::from)
    }

    #[test]
    fn the_distance_is_to_the_segment_and_not_to_its_line() {
        let distance = |x, y, ends| segment_distance(Point::new(x, y), segment(ends));
        let ends = [[0.0, 0.0], [2.0, 0.0]];
        assert_eq!(distance(1.0, 3.0, ends), 3.0);
        assert_eq!(distance(5.0, 4.0, ends), 5.0);
        assert_eq!(distance(-3.0, -4.0, ends), 5.0);
        assert_eq!(distance(3.0, 4.0, [[0.0, 0.0]; 2]), 5.0);
    }

    #[test]
    fn segments_cross_within_both() {
        let cross = [[[0.0, 0.0], [2.0, 2.0]], [[0.0, 1.0], [4.0, 1.0]]].map(segment);
        let at = Point::new(1.0, 1.0);
        assert_eq!(first_crossing(&cross), Some(([0, 1], at)));
        for apart in [
            [[2.5, 1.0], [4.0, 1.0]],
            [[0.0, 0.0], [4.0, 1.0]],
            [[1.0, 1.0], [4.0, 1.0]],
            [[3.0, 3.0], [4.0, 4.0]],
            [[0.0, 1.0], [2.0, 3.0]],
        ] {
            assert_eq!(
                first_crossing(&[cross[0], segment(apart)]),
                None,
                "{apart:?}"
            );
        }
        // A regular polygon, and one that is closed with a star's step.
        let corner = |n: i32| {
            let angle = f64::from(n) * std::f64::consts::TAU / 30.0;
            Point::new(angle.cos(), angle.sin())
        };
        let polygon: Vec<_> = (0..30).map(|n| [corner(n), corner(n + 1)]).collect();
        assert_eq!(first_crossing(&polygon), None);
        let star: Vec<_> = (0..30).map(|n| [corner(n), corner(n + 7)]).collect();
        assert!(first_crossing(&star).is_some());
    }
}
