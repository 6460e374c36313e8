//! The distance from a set of segments in the unit square, for many places.

use super::{Point, Segment, segment_offset};

/// Cells along a side of the grid.
const CELLS: usize = 128;

/// No segment is known yet.
const NONE: u32 = u32::MAX;

/// For each corner of a grid over the unit square the segment nearest to it.
#[derive(Debug, Clone)]
pub struct NearestSegments {
    segments: Vec<Segment>,
    /// Row after row from below.
    nearest: Vec<u32>,
}

impl NearestSegments {
    /// Of these segments.
    pub fn new(segments: &[Segment]) -> Self {
        let mut nearest = Self {
            segments: segments.to_vec(),
            nearest: vec![NONE; (CELLS + 1) * (CELLS + 1)],
        };
        // Of the distances.
        let mut squares = vec![f64::INFINITY; nearest.nearest.len()];
        for (number, [a, b]) in segments.iter().enumerate() {
            let range = |axis: usize| {
                let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
                let cell = |at: f64| (at * CELLS as f64).clamp(0.0, CELLS as f64);
                cell(low).floor() as usize..=cell(high).ceil() as usize
            };
            for row in range(1) {
                for column in range(0) {
                    nearest.offer(&mut squares, [column, row], number as u32);
                }
            }
        }
        // What is nearest to a corner is nearest, or nearly so, to a neighbour on the way there: two sweeps bring it
        // along in all directions.
        let forward = || 0..=CELLS;
        for _ in 0..2 {
            for (row, column) in forward().flat_map(|row| forward().map(move |it| (row, it))) {
                nearest.take_over(&mut squares, [column, row], [-1, -1]);
            }
            for (row, column) in
                (forward().rev()).flat_map(|row| forward().rev().map(move |it| (row, it)))
            {
                nearest.take_over(&mut squares, [column, row], [1, 1]);
            }
            for (row, column) in forward().flat_map(|row| forward().rev().map(move |it| (row, it)))
            {
                nearest.take_over(&mut squares, [column, row], [1, -1]);
            }
            for (row, column) in
                (forward().rev()).flat_map(|row| forward().map(move |it| (row, it)))
            {
                nearest.take_over(&mut squares, [column, row], [-1, 1]);
            }
        }
        nearest
    }

    /// Takes the segment for a corner, if it is nearer than the one that is known.
    fn offer(&mut self, squares: &mut [f64], [column, row]: [usize; 2], segment: u32) {
        let corner = row * (CELLS + 1) + column;
        if self.nearest[corner] == segment {
            return;
        }
        let place = Point::new(column as f64, row as f64) / CELLS as f64;
        let square = segment_offset(place, self.segments[segment as usize]).norm_squared();
        if square < squares[corner] {
            squares[corner] = square;
            self.nearest[corner] = segment;
        }
    }

    /// Offers a corner the segments of its neighbours on two sides.
    fn take_over(
        &mut self,
        squares: &mut [f64],
        [column, row]: [usize; 2],
        [across, up]: [isize; 2],
    ) {
        let neighbour = |column: Option<usize>, row: Option<usize>| {
            let (column, row) = column.zip(row)?;
            (column <= CELLS && row <= CELLS).then(|| row * (CELLS + 1) + column)
        };
        let (beside, above) = (
            column.checked_add_signed(across),
            row.checked_add_signed(up),
        );
        for neighbour in [
            neighbour(beside, Some(row)),
            neighbour(Some(column), above),
            neighbour(beside, above),
        ] {
            let segment = neighbour.map_or(NONE, |corner| self.nearest[corner]);
            if segment != NONE {
                self.offer(squares, [column, row], segment);
            }
        }
    }

    /// The distance of a place of the unit square from the nearest segment: exactly that, or more by no more than a
    /// part of a cell. Infinite without segments.
    pub fn distance(&self, place: Point) -> f64 {
        let [column, row] = [place.x, place.y]
            .map(|at| ((at * CELLS as f64).clamp(0.0, CELLS as f64) as usize).min(CELLS - 1));
        let corner = row * (CELLS + 1) + column;
        let mut known = [0, 1, CELLS + 1, CELLS + 2].map(|offset| self.nearest[corner + offset]);
        known.sort_unstable();
        let mut last = NONE;
        let mut square = f64::INFINITY;
        for segment in known {
            if segment != NONE && segment != last {
                let offset = segment_offset(place, self.segments[segment as usize]);
                square = offset.norm_squared().min(square);
            }
            last = segment;
        }
        square.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::segment_distance;
    use super::*;

    #[test]
    fn distances_are_those_of_the_nearest_segment() {
        let at = |n: i32| {
            let angle = f64::from(n) * std::f64::consts::TAU / 100.0;
            Point::new(0.45 + 0.3 * angle.cos(), 0.55 + 0.12 * angle.sin())
        };
        let mut segments: Vec<_> = (0..100).map(|n| [at(n), at(n + 1)]).collect();
        segments.push([Point::new(0.9, 0.05), Point::new(0.9, 0.051)]);
        let nearest = NearestSegments::new(&segments);
        let mut worst: f64 = 0.0;
        for n in 0..10_000 {
            let place = Point::new(f64::from(n % 100) / 99.0, f64::from(n / 100) / 99.0);
            let wanted = segments.iter().map(|s| segment_distance(place, *s));
            let wanted = wanted.fold(f64::INFINITY, f64::min);
            let found = nearest.distance(place);
            assert!(
                found >= wanted * (1.0 - 1e-14),
                "{place:?}: {found} {wanted}"
            );
            worst = worst.max(found - wanted);
        }
        assert!(worst < 0.3 / CELLS as f64, "{worst}");
        assert_eq!(NearestSegments::new(&[]).distance(at(0)), f64::INFINITY);
    }
}
