//! Segments found by place.

use super::{BoundingBox, Point, Segment, segment_distance};

/// Segments sorted into the cells of a grid, so that those near a place are found at once.
#[derive(Debug, Clone)]
pub struct SegmentGrid {
    segments: Vec<Segment>,
    reach: f64,
    origin: Point,
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
    pub fn new(segments: Vec<Segment>, reach: f64) -> Self {
        let hull = BoundingBox::around(segments.iter().flatten());
        let extent = hull.extent();
        // About as many cells as segments.
        let fair = extent.max() / (segments.len() as f64).sqrt().max(1.0);
        let size = fair.max(reach).max(f64::MIN_POSITIVE);
        let cells = |extent: f64| (extent / size) as usize + 1;
        let mut grid = Self {
            segments,
            reach,
            origin: hull.lower,
            size,
            columns: cells(extent.x),
            rows: cells(extent.y),
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

    /// All of them, in the order in which they were given.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The numbers of the segments that may be within reach of a place: all that are, and others.
    pub fn near(&self, place: Point) -> impl Iterator<Item = usize> + '_ {
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
    pub fn is_near(&self, place: Point) -> bool {
        self.near(place)
            .any(|number| segment_distance(place, self.segments[number]) <= self.reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_within_reach_is_found() {
        let at = |n: i32| {
            let angle = f64::from(n) * 0.1;
            Point::new(angle.cos(), 0.3 * angle.sin())
        };
        let segments: Vec<_> = (0..63).map(|n| [at(n), at(n + 1)]).collect();
        for reach in [1e-3, 0.05, 0.6] {
            let grid = SegmentGrid::new(segments.clone(), reach);
            for n in 0..400 {
                let place = Point::new(
                    f64::from(n % 20) * 0.13 - 1.3,
                    f64::from(n / 20) * 0.05 - 0.5,
                );
                let nearest = segments.iter().map(|s| segment_distance(place, *s));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert_eq!(grid.is_near(place), nearest <= reach, "{place:?} {reach}");
            }
        }
    }
}
