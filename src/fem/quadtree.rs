//! Points of the unit square in a tree of squares: whether one is near a place is found at once,
//! however different the distances between the points are.

use crate::geometry::{Point, Vector, length};

/// A square of more points than this is divided.
const CAPACITY: usize = 8;

/// The smallest squares have the side 2⁻³²: points that are one and the same do not divide any.
const DEPTH: u32 = 32;

/// Points of the unit square, found by place. The memory is proportional to their number.
#[derive(Debug)]
pub(super) struct Quadtree {
    /// The whole square first.
    squares: Vec<Square>,
}

#[derive(Debug)]
enum Square {
    Whole(Vec<Point>),
    /// Its quarters follow each other from here: lower left, lower right, upper left, upper right.
    Divided(usize),
}

/// Where a square lies.
#[derive(Debug, Clone, Copy)]
struct Extent {
    center: Point,
    half: f64,
}

impl Extent {
    const UNIT: Self = Self {
        center: Point::new(0.5, 0.5),
        half: 0.5,
    };

    /// The number of the quarter in which a place lies.
    fn quarter_of(&self, place: Point) -> usize {
        usize::from(place.x >= self.center.x) + 2 * usize::from(place.y >= self.center.y)
    }

    fn quarter(&self, number: usize) -> Self {
        let half = 0.5 * self.half;
        let shift = |is_upper: bool| if is_upper { half } else { -half };
        Self {
            center: self.center + Vector::new(shift(number & 1 == 1), shift(number & 2 == 2)),
            half,
        }
    }

    /// Whether it may have points nearer than `radius`; to rounding, on the safe side.
    fn reaches(&self, place: Point, radius: f64) -> bool {
        let outside = (place - self.center).map(|offset| (offset.abs() - self.half).max(0.0));
        outside.norm_squared() <= 1.000_001 * radius * radius
    }
}

impl Quadtree {
    pub(super) fn new() -> Self {
        Self {
            squares: vec![Square::Whole(Vec::new())],
        }
    }

    /// Enters a point.
    pub(super) fn insert(&mut self, point: Point) {
        let mut number = 0;
        let mut extent = Extent::UNIT;
        let mut depth = 0;
        loop {
            match &mut self.squares[number] {
                Square::Divided(first) => {
                    let quarter = extent.quarter_of(point);
                    number = *first + quarter;
                    extent = extent.quarter(quarter);
                    depth += 1;
                }
                Square::Whole(points) if points.len() < CAPACITY || depth == DEPTH => {
                    points.push(point);
                    return;
                }
                Square::Whole(points) => {
                    let mut quarters = [const { Vec::new() }; 4];
                    for point in std::mem::take(points) {
                        quarters[extent.quarter_of(point)].push(point);
                    }
                    self.squares[number] = Square::Divided(self.squares.len());
                    self.squares.extend(quarters.map(Square::Whole));
                }
            }
        }
    }

    /// Whether a point is nearer to a place than `radius`.
    pub(super) fn is_near(&self, place: Point, radius: f64) -> bool {
        self.is_near_in(0, Extent::UNIT, place, radius)
    }

    fn is_near_in(&self, number: usize, extent: Extent, place: Point, radius: f64) -> bool {
        match &self.squares[number] {
            Square::Whole(points) => points.iter().any(|point| length(point - place) < radius),
            Square::Divided(first) => {
                // The quarter of the place itself first: it is the likeliest.
                let own = extent.quarter_of(place);
                (0..4).map(|other| own ^ other).any(|quarter| {
                    let extent = extent.quarter(quarter);
                    extent.reaches(place, radius)
                        && self.is_near_in(first + quarter, extent, place, radius)
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn what_is_near_is_found_and_nothing_else() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let mut random = move || generator.random::<f64>();
        // Ever denser towards the origin, and some points many times.
        let mut points: Vec<Point> = (0..400)
            .map(|_| {
                let shrink = 1e-6_f64.powf(random());
                Point::new(shrink * random(), shrink * random())
            })
            .collect();
        points.extend([Point::new(0.5, 0.5); 20]);
        points.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Point::from));
        let mut tree = Quadtree::new();
        for point in &points {
            tree.insert(*point);
        }
        for _ in 0..2000 {
            let shrink = 1e-6_f64.powf(random());
            let place = Point::new(shrink * random(), shrink * random());
            let radius = 1e-6_f64.powf(random());
            let is_near = points.iter().any(|point| length(point - place) < radius);
            assert_eq!(tree.is_near(place, radius), is_near, "{place:?} {radius}");
        }
        // At the distance itself a point is not nearer.
        let mut tree = Quadtree::new();
        tree.insert(Point::new(1.0, 0.0));
        let place = Point::new(1.0, 0.5);
        assert!(!tree.is_near(place, 0.5) && tree.is_near(place, 0.500_001));
    }

    /// Points of four scales take as much as their number asks for.
    #[test]
    fn the_tree_grows_with_the_number_of_points() {
        for scale in [1.0, 1e-2, 1e-4, 1e-8] {
            let mut tree = Quadtree::new();
            for row in 0..100 {
                for column in 0..100 {
                    let at = [row, column].map(|at| scale * f64::from(at) / 100.0);
                    tree.insert(at.into());
                }
            }
            let squares = tree.squares.len();
            assert!(squares < 8_000, "{scale}: {squares}");
        }
    }
}
