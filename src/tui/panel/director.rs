//! The director as lines that run along it, evenly spaced, drawn with the parts of the cells: over several cells a
//! tilt of a few degrees is seen. Where |d| is less than [`WHOLE`] a line has gaps: of each [`PERIOD`] of it the share
//! |d| is drawn.
//!
//! Lines are placed one after the other, the first through the middle, each further one beside one that is there
//! (Jobard and Lefer, 1997). So from frame to frame they stay where they are, as far as the director does.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use crate::fem::Raster;

/// Between lines, in widths of a cell: in a picture of few rows, and of many.
const SPACING: [f64; 2] = [3.0, 4.0];
/// From so many rows on a picture has many.
const MANY_ROWS: usize = 45;
/// A line ends where it comes so near to another one, in spacings.
const NEAREST: f64 = 0.6;
/// The step along a line, in widths of a cell: less than a part of a cell.
const STEP: f64 = 0.25;
/// Shorter lines are left out, in spacings: they have no direction to see.
const SHORTEST: f64 = 1.0;
/// A line is whole where the director is at least so long.
pub const WHOLE: f64 = 0.6;
/// Where it is shorter than this nothing is drawn: it has no direction to see.
const SHORTEST_DIRECTOR: f64 = 0.05;
/// From one dash of a line to the next, in widths of a cell.
const PERIOD: f64 = 4.0;
/// A line ends after so many steps.
const MOST_STEPS: usize = 8000;

/// A grid of samples, so many a cell.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Samples beside each other, and one below the other.
    pub size: [usize; 2],
    /// Samples beside each other in a cell, and one below the other.
    pub a_cell: [usize; 2],
}

impl Grid {
    /// The sample at a place, in widths of a cell from the upper left corner: a cell is twice as high as it is wide.
    fn sample(&self, [x, y]: Place) -> Option<[usize; 2]> {
        let [column, row] = self.scaled([x, y]).map(f64::floor);
        let is_there = (0.0..self.size[0] as f64).contains(&column)
            && (0.0..self.size[1] as f64).contains(&row);
        is_there.then_some([column as usize, row as usize])
    }

    /// A place, or a distance, in samples.
    fn scaled(&self, [x, y]: Place) -> Place {
        [x * self.a_cell[0] as f64, 0.5 * y * self.a_cell[1] as f64]
    }

    /// The middle of a sample.
    fn place(&self, [column, row]: [usize; 2]) -> Place {
        let unit = self.scaled([1.0; 2]);
        [
            (column as f64 + 0.5) / unit[0],
            (row as f64 + 0.5) / unit[1],
        ]
    }
}

/// In widths of a cell, y downwards.
type Place = [f64; 2];

/// The square of the distance of two places.
fn square(one: Place, other: Place) -> f64 {
    (one[0] - other[0]).powi(2) + (one[1] - other[1]).powi(2)
}

/// The samples that the lines go through. A line goes through samples for which `is_free` holds and where |d| is at
/// least [`SHORTEST_DIRECTOR`].
pub fn lines(
    grid: Grid,
    raster: &Raster,
    director: &[Vec<f64>; 2],
    is_free: impl Fn(usize, usize) -> bool,
) -> Vec<bool> {
    let rows = grid.size[1] / grid.a_cell[1].max(1);
    let spacing = SPACING[usize::from(rows >= MANY_ROWS)];
    let [dx, dy] = director;
    // The director where a line may go, and its length.
    let director = |place: Place| {
        let [x, y] = grid.sample(place)?;
        let (dx, dy) = raster.at_across(dx, x, y).zip(raster.at(dy, x, y))?;
        let length = dx.hypot(dy);
        let is_seen = length >= SHORTEST_DIRECTOR && length.is_finite() && is_free(x, y);
        is_seen.then_some(([dx, -dy], length))
    };
    let direction = |place: Place| {
        let (along, length) = director(place)?;
        Some(along.map(|part| part / length))
    };
    let mut taken = Taken::new(grid, spacing);
    let mut drawn = vec![false; grid.size[0] * grid.size[1]];
    let mut seeds = VecDeque::new();
    for seed in places_from_the_middle(grid) {
        seeds.push_back(seed);
        while let Some(seed) = seeds.pop_front() {
            if taken.is_beside_a_line(seed) {
                continue;
            }
            let (line, middle) = trace(seed, direction, |place| taken.is_near_a_line(place));
            if (line.len() as f64) * STEP < SHORTEST * spacing {
                continue;
            }
            for pair in line.windows(2) {
                let along = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]].map(|it| it / STEP);
                for side in [-spacing, spacing] {
                    // A little more, for what is exactly so far away is too near by rounding.
                    let aside = 1.001 * side;
                    seeds.push_back([pair[0][0] - aside * along[1], pair[0][1] + aside * along[0]]);
                }
            }
            taken.take(&line);
            let is_drawn = |index: usize| {
                let length = director(line[index]).map_or(0.0, |(_, length)| length);
                is_in_dash(STEP * index.abs_diff(middle) as f64, length)
            };
            let places: Vec<usize> = (0..line.len()).collect();
            for dash in places.chunk_by(|one, next| is_drawn(*one) == is_drawn(*next)) {
                if is_drawn(dash[0]) {
                    for [x, y] in thin(dash.iter().filter_map(|index| grid.sample(line[*index]))) {
                        drawn[y * grid.size[0] + x] = true;
                    }
                }
            }
        }
    }
    drawn
}

/// Whether a line is drawn so far from its middle, where the director has this length: a dash is centred there.
fn is_in_dash(distance: f64, length: f64) -> bool {
    let from_middle = (distance / PERIOD).fract();
    let from_middle = PERIOD * from_middle.min(1.0 - from_middle);
    // A dash looks longer than it is, by the half of a sample at either end.
    length >= WHOLE || 2.0 * from_middle <= (length * PERIOD - 0.5).max(0.0)
}

/// A place in each cell, those in the middle of the grid first.
fn places_from_the_middle(grid: Grid) -> Vec<Place> {
    let [columns, rows] = [0, 1].map(|axis| grid.size[axis] / grid.a_cell[axis].max(1));
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    // In the middle of a sample, for between two of them rounding would decide.
    let place =
        |[column, row]: [usize; 2]| grid.place([column * grid.a_cell[0], row * grid.a_cell[1]]);
    let mut places: Vec<Place> = all.map(place).collect();
    let middle = [0.5 * columns as f64, rows as f64];
    let distance = |place: &Place| square(*place, middle);
    places.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    places
}

/// The places of the line through a place, from one end to the other, and which of them that place is.
fn trace(
    seed: Place,
    direction: impl Fn(Place) -> Option<[f64; 2]>,
    is_near_another: impl Fn(Place) -> bool,
) -> (Vec<Place>, usize) {
    let mut line = VecDeque::new();
    let mut behind = 0;
    let Some(first) = direction(seed) else {
        return (Vec::new(), 0);
    };
    line.push_back(seed);
    // d and −d are the same line.
    let is_rightwards = first[0] > 0.0 || (first[0] == 0.0 && first[1] > 0.0);
    let first = first.map(|part| if is_rightwards { part } else { -part });
    let mut turned = 0.0_f64;
    for sign in [1.0, -1.0] {
        let (mut place, mut before) = (seed, first.map(|part| sign * part));
        // A line that closes does so once.
        while turned.abs() < TAU && line.len() < MOST_STEPS {
            let ahead =
                |by: f64, along: [f64; 2]| [place[0] + by * along[0], place[1] + by * along[1]];
            let Some(mut now) = direction(ahead(0.5 * STEP, before)) else {
                break;
            };
            if now[0] * before[0] + now[1] * before[1] < 0.0 {
                now = now.map(|part| -part);
            }
            let next = ahead(STEP, now);
            if direction(next).is_none() || is_near_another(next) {
                break;
            }
            turned += sign * (before[0] * now[1] - before[1] * now[0]);
            before = now;
            place = next;
            if sign > 0.0 {
                line.push_back(place);
            } else {
                line.push_front(place);
                behind += 1;
            }
        }
    }
    (line.into(), behind)
}

/// The samples of a line, one in each step of it: without repetitions, without those at its corners, and without those
/// of a neighbouring column or row that it touches and leaves.
fn thin(samples: impl Iterator<Item = [usize; 2]>) -> Vec<[usize; 2]> {
    let mut kept: Vec<[usize; 2]> = Vec::new();
    for sample in samples {
        let is_next_to =
            |other: &[usize; 2]| (0..2).all(|axis| other[axis].abs_diff(sample[axis]) <= 1);
        if kept.last() == Some(&sample) {
            continue;
        }
        if let [.., before, _] = &kept[..]
            && is_next_to(before)
        {
            kept.pop();
        }
        if kept.last() != Some(&sample) {
            kept.push(sample);
        }
    }
    kept
}

/// How near the lines are that were placed.
struct Taken {
    grid: Grid,
    spacing: f64,
    /// For each sample the square of the distance to the nearest line, as far as that is less than the spacing.
    squares: Vec<f64>,
}

impl Taken {
    fn new(grid: Grid, spacing: f64) -> Self {
        let squares = vec![f64::INFINITY; grid.size[0] * grid.size[1]];
        Self {
            grid,
            spacing,
            squares,
        }
    }

    fn is_nearer(&self, place: Place, distance: f64) -> bool {
        let sample = self.grid.sample(place);
        sample.is_none_or(|[x, y]| self.squares[y * self.grid.size[0] + x] < distance * distance)
    }

    /// Whether no line may begin here.
    fn is_beside_a_line(&self, place: Place) -> bool {
        self.is_nearer(place, self.spacing)
    }

    /// Whether a line ends here.
    fn is_near_a_line(&self, place: Place) -> bool {
        self.is_nearer(place, NEAREST * self.spacing)
    }

    fn take(&mut self, line: &[Place]) {
        let reach = self
            .grid
            .scaled([self.spacing; 2])
            .map(|it| it.ceil() as usize);
        // The width of a cell apart: distances are too long by a twentieth of it at most.
        for &[x, y] in line.iter().step_by(4).chain(line.last()) {
            let Some([column, row]) = self.grid.sample([x, y]) else {
                continue;
            };
            let end = |at: usize, axis: usize| (at + reach[axis] + 1).min(self.grid.size[axis]);
            for row in row.saturating_sub(reach[1])..end(row, 1) {
                for column in column.saturating_sub(reach[0])..end(column, 0) {
                    let place = self.grid.place([column, row]);
                    let nearest = &mut self.squares[row * self.grid.size[0] + column];
                    *nearest = nearest.min(square(place, [x, y]));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Mesh;
    use crate::geometry::Point;

    const QUADRANTS: [usize; 2] = [2, 2];
    const DOTS: [usize; 2] = [2, 4];

    /// The lines of a director on 40 × 20 cells with these parts.
    fn drawn(a_cell: [usize; 2], director: impl Fn(&Point) -> [f64; 2]) -> Vec<bool> {
        let mesh = Mesh::structured(20, 0.0, 0).expect("a regular mesh");
        let grid = Grid {
            size: [40 * a_cell[0], 20 * a_cell[1]],
            a_cell,
        };
        let raster = Raster::new(&mesh, mesh.bounding_box(), grid.size[0], grid.size[1]);
        let values: Vec<[f64; 2]> = mesh.nodes().iter().map(director).collect();
        let director = [0, 1].map(|axis| values.iter().map(|d| d[axis]).collect());
        lines(grid, &raster, &director, |_, _| true)
    }

    fn at_angle(degrees: f64, a_cell: [usize; 2]) -> Vec<bool> {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        drawn(a_cell, |_| [cosine, sine])
    }

    fn count(drawn: &[bool]) -> usize {
        drawn.iter().filter(|drawn| **drawn).count()
    }

    #[test]
    fn three_degrees_are_seen_and_have_no_head() {
        for parts in [QUADRANTS, DOTS] {
            for upright in [0.0, 40.0, 90.0] {
                let straight = at_angle(upright, parts);
                for tilt in [3.0, -3.0] {
                    assert_ne!(
                        straight,
                        at_angle(upright + tilt, parts),
                        "{upright} {tilt}"
                    );
                }
                let (sine, cosine) = f64::to_radians(upright).sin_cos();
                assert_eq!(straight, drawn(parts, |_| [-cosine, -sine]), "{upright}");
            }
        }
    }

    #[test]
    fn lines_run_along_the_director_at_even_distances() {
        let upright = at_angle(90.0, DOTS);
        // Every column of dots is all line or none.
        let columns: Vec<usize> = (0..80).filter(|column| upright[*column]).collect();
        assert!(columns.len() >= 12, "{columns:?}");
        for (number, drawn) in upright.iter().enumerate() {
            assert_eq!(*drawn, columns.contains(&(number % 80)), "{number}");
        }
        let gaps = columns.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(
            gaps.clone().all(|gap| (6..=7).contains(&gap)),
            "{columns:?}"
        );
        // A line that rises to the right is where y grows with x.
        let rising = at_angle(45.0, DOTS);
        let at = |x: usize, y: usize| rising[y * 80 + x];
        let neighbours = |dy: fn(usize) -> usize| {
            let places = (1..79).flat_map(|x| (1..79).map(move |y| (x, y)));
            places
                .filter(|(x, y)| at(*x, *y) && at(x + 1, dy(*y)))
                .count()
        };
        assert!(neighbours(|y| y - 1) > 300);
        assert!(neighbours(|y| y + 1) < 30);
    }

    #[test]
    fn a_line_is_one_sample_wide() {
        let line = [
            [3, 0],
            [3, 0],
            [4, 0],
            [4, 1],
            [4, 2],
            [3, 2],
            [4, 2],
            [4, 3],
            [5, 3],
            [4, 3],
            [4, 4],
        ];
        let expected = [[3, 0], [4, 1], [4, 2], [4, 3], [4, 4]];
        assert_eq!(thin(line.into_iter()), expected);
    }

    /// The share of a line that is drawn is |d|: whole at 0.6 and above, nothing below 0.05.
    #[test]
    fn the_shorter_the_director_the_more_of_a_line_is_left_out() {
        for parts in [QUADRANTS, DOTS] {
            for angle in [90.0, 0.0] {
                let (sine, cosine) = f64::to_radians(angle).sin_cos();
                let at = |length: f64| {
                    let drawn = drawn(parts, |_| [length * cosine, length * sine]);
                    count(&drawn) as f64
                };
                let whole = at(1.0);
                assert_eq!((whole, 0.0), (at(0.65), at(0.04)), "{parts:?} {angle}");
                for length in [0.25, 0.5] {
                    let share = at(length) / whole;
                    // A sample is a quarter of a period at most.
                    assert!((share - length).abs() < 0.2, "{angle}: {share} of {length}");
                }
            }
        }
        for d in [[0.0, 0.0], [f64::NAN, 1.0], [f64::INFINITY, 1.0]] {
            assert_eq!(count(&drawn(DOTS, |_| d)), 0);
        }
    }

    /// Lines that close do not run for ever, and a source is no place that they pass.
    #[test]
    fn circles_and_stars_end() {
        for turned in [false, true] {
            let drawn = drawn(QUADRANTS, |at| {
                let (x, y) = (at.x - 0.5, at.y - 0.5);
                let length = x.hypot(y).max(1e-3);
                if turned {
                    [-y / length, x / length]
                } else {
                    [x / length, y / length]
                }
            });
            let count = count(&drawn);
            assert!((200..1000).contains(&count), "{count}");
        }
    }
}
