//! Segments in the plane: how far a place is from them, and whether they cross.

/// The distance of a place from a segment.
pub fn segment_distance([x, y]: [f64; 2], [[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> f64 {
    let along = [bx - ax, by - ay];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 {
        (((x - ax) * along[0] + (y - ay) * along[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (x - ax - share * along[0]).hypot(y - ay - share * along[1])
}

/// The first two segments found that cross, each on either side of the other, and where. Those that
/// have an end in common do not.
pub fn first_crossing(segments: &[[[f64; 2]; 2]]) -> Option<([usize; 2], [f64; 2])> {
    // A line sweeps over the plane, such that few segments are parallel to it; those that it meets at
    // one time are compared.
    let along = |[x, y]: [f64; 2]| 0.8 * x + 0.6 * y;
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
fn crossing([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    // Twice the area of a triangle, positive where it is counter-clockwise.
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let (of_c, of_d) = (side(a, b, c), side(a, b, d));
    let (of_a, of_b) = (side(c, d, a), side(c, d, b));
    let are_apart = |one: f64, other: f64| (one > 0.0 && other < 0.0) || (one < 0.0 && other > 0.0);
    (are_apart(of_c, of_d) && are_apart(of_a, of_b)).then(|| {
        let share = of_a / (of_a - of_b);
        [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]))
    })
}

/// Segments sorted into the cells of a grid, so that those near a place are found at once.
#[derive(Debug, Clone)]
pub struct SegmentGrid {
    segments: Vec<[[f64; 2]; 2]>,
    reach: f64,
    origin: [f64; 2],
    /// The size of a cell.
    size: f64,
    columns: usize,
    rows: usize,
    /// For each cell where its segments begin in `members`; one more at the end.
    start: Vec<u32>,
    members: Vec<u32>,
}

impl SegmentGrid {
    /// For questions about what is within `reach` of a place.
    pub fn new(segments: Vec<[[f64; 2]; 2]>, reach: f64) -> Self {
        let mut lower = [f64::INFINITY; 2];
        let mut upper = [f64::NEG_INFINITY; 2];
        for end in segments.iter().flatten() {
            for axis in 0..2 {
                lower[axis] = lower[axis].min(end[axis]);
                upper[axis] = upper[axis].max(end[axis]);
            }
        }
        let extent = [0, 1].map(|axis| (upper[axis] - lower[axis]).max(0.0));
        // About as many cells as segments.
        let fair = extent[0].max(extent[1]) / (segments.len() as f64).sqrt().max(1.0);
        let size = fair.max(reach).max(f64::MIN_POSITIVE);
        let cells = |axis: usize| (extent[axis] / size) as usize + 1;
        let mut grid = Self {
            segments,
            reach,
            origin: lower,
            size,
            columns: cells(0),
            rows: cells(1),
            start: Vec::new(),
            members: Vec::new(),
        };
        grid.fill();
        grid
    }

    fn fill(&mut self) {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (number, [a, b]) in self.segments.iter().enumerate() {
            let range = |axis: usize, count: usize| {
                let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
                let cell = |at: f64| ((at - self.origin[axis]) / self.size).max(0.0) as usize;
                let (first, last) = (cell(low - self.reach), cell(high + self.reach));
                first.min(count - 1)..=last.min(count - 1)
            };
            for row in range(1, self.rows) {
                for column in range(0, self.columns) {
                    pairs.push(((row * self.columns + column) as u32, number as u32));
                }
            }
        }
        pairs.sort_unstable();
        self.start = vec![0; self.columns * self.rows + 1];
        for (cell, _) in &pairs {
            self.start[*cell as usize + 1] += 1;
        }
        for cell in 1..self.start.len() {
            self.start[cell] += self.start[cell - 1];
        }
        self.members = pairs.into_iter().map(|(_, number)| number).collect();
    }

    /// The numbers of the segments that may be within reach of a place: all that are, and others.
    pub fn near(&self, place: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        let cell = |axis: usize, count: usize| {
            let offset = (place[axis] - self.origin[axis]) / self.size;
            // What lies outside by no more than the reach belongs to the cells at the rim.
            (offset.max(0.0) as usize).min(count - 1)
        };
        let cell = cell(1, self.rows) * self.columns + cell(0, self.columns);
        let members = self.start[cell] as usize..self.start[cell + 1] as usize;
        self.members[members].iter().map(|number| *number as usize)
    }

    /// Whether a segment is within reach of a place.
    pub fn is_near(&self, place: [f64; 2]) -> bool {
        self.near(place)
            .any(|number| segment_distance(place, self.segments[number]) <= self.reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_to_the_segment_and_not_to_its_line() {
        let segment = [[0.0, 0.0], [2.0, 0.0]];
        assert_eq!(segment_distance([1.0, 3.0], segment), 3.0);
        assert_eq!(segment_distance([5.0, 4.0], segment), 5.0);
        assert_eq!(segment_distance([-3.0, -4.0], segment), 5.0);
        assert_eq!(segment_distance([3.0, 4.0], [[0.0, 0.0]; 2]), 5.0);
    }

    #[test]
    fn segments_cross_within_both() {
        let cross = [[[0.0, 0.0], [2.0, 2.0]], [[0.0, 1.0], [4.0, 1.0]]];
        assert_eq!(first_crossing(&cross), Some(([0, 1], [1.0, 1.0])));
        for apart in [
            [[2.5, 1.0], [4.0, 1.0]],
            [[0.0, 0.0], [4.0, 1.0]],
            [[1.0, 1.0], [4.0, 1.0]],
            [[3.0, 3.0], [4.0, 4.0]],
            [[0.0, 1.0], [2.0, 3.0]],
        ] {
            assert_eq!(first_crossing(&[cross[0], apart]), None, "{apart:?}");
        }
        // A regular polygon, and one that is closed with a star's step.
        let corner = |n: i32| {
            let angle = f64::from(n) * std::f64::consts::TAU / 30.0;
            [angle.cos(), angle.sin()]
        };
        let polygon: Vec<_> = (0..30).map(|n| [corner(n), corner(n + 1)]).collect();
        assert_eq!(first_crossing(&polygon), None);
        let star: Vec<_> = (0..30).map(|n| [corner(n), corner(n + 7)]).collect();
        assert!(first_crossing(&star).is_some());
    }

    #[test]
    fn what_is_within_reach_is_found() {
        let at = |n: i32| {
            let angle = f64::from(n) * 0.1;
            [angle.cos(), 0.3 * angle.sin()]
        };
        let segments: Vec<_> = (0..63).map(|n| [at(n), at(n + 1)]).collect();
        for reach in [1e-3, 0.05, 0.6] {
            let grid = SegmentGrid::new(segments.clone(), reach);
            for n in 0..400 {
                let place = [
                    f64::from(n % 20) * 0.13 - 1.3,
                    f64::from(n / 20) * 0.05 - 0.5,
                ];
                let nearest = segments.iter().map(|s| segment_distance(place, *s));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert_eq!(grid.is_near(place), nearest <= reach, "{place:?} {reach}");
            }
        }
    }
}
