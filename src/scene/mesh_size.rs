//! How large the triangles of a generated mesh are to be, place by place.

use super::outline::{OutlineDistance, union_distance};
use super::tables::{Refinement, Shape};
use crate::geometry::{NearestSegments, Point, Segment, Vector};

/// By how much the size may grow over a unit of length: neighbours then differ by less than a third, and
/// the angles suffer little.
const GROWTH: f64 = 0.3;

/// Nodes of a generated mesh in a unit of area, times the square of the wanted length of an edge, as
/// counted at sizes from 0.02 to 0.004. (Of equilateral triangles it would be 2/√3.)
const DENSITY: f64 = 1.04;

/// One value does for a square whose side is at most so many times the smallest length wanted in it.
const COARSEST: f64 = 2.0;

/// The wanted length of an edge, as a function of the place.
#[derive(Debug)]
pub struct MeshSize {
    largest: f64,
    refined: Option<(Refinement, Membrane)>,
}

/// About what it is finer.
#[derive(Debug)]
enum Membrane {
    /// The outlines of a scene.
    Outlines(Vec<OutlineDistance>),
    /// A curve.
    Curve(NearestSegments),
}

impl Membrane {
    /// How far a place is from it.
    fn distance(&self, place: Point) -> f64 {
        match self {
            Self::Outlines(outlines) => union_distance(outlines, place).value.abs(),
            Self::Curve(curve) => curve.distance(place),
        }
    }
}

impl MeshSize {
    /// Edges of the length `largest`, refined about the membrane of a vesicle of this shape.
    pub fn new(largest: f64, refine: Option<Refinement>, shape: &Shape) -> Self {
        let refined = refine.map(|refinement| {
            let outlines = match shape {
                Shape::Outlines(outlines) => outlines.iter().map(OutlineDistance::new).collect(),
                Shape::Random { .. } | Shape::File(_) => Vec::new(),
            };
            (refinement, Membrane::Outlines(outlines))
        });
        Self { largest, refined }
    }

    /// That of the first mesh of a run whose mesh follows the membrane.
    pub fn at_start(largest: f64, refinement: Refinement, shape: &Shape) -> Self {
        match shape {
            Shape::Outlines(_) => Self::new(largest, Some(refinement), shape),
            // There are membranes everywhere.
            Shape::Random { .. } | Shape::File(_) => Self::new(refinement.size, None, shape),
        }
    }

    /// Edges of the length `largest`, refined about a membrane in the unit square.
    pub fn about(largest: f64, refinement: Refinement, membrane: &[Segment]) -> Self {
        let curve = NearestSegments::new(membrane);
        Self {
            largest,
            refined: Some((refinement, Membrane::Curve(curve))),
        }
    }

    /// The smallest one.
    pub fn smallest(&self) -> f64 {
        match &self.refined {
            Some((refinement, _)) => refinement.size,
            None => self.largest,
        }
    }

    /// At a place: within the band about the membrane the smaller one, from there on growing.
    pub fn at(&self, place: Point) -> f64 {
        match &self.refined {
            Some((refinement, membrane)) => self.at_distance(*refinement, membrane.distance(place)),
            None => self.largest,
        }
    }

    fn at_distance(&self, Refinement { band, size }: Refinement, distance: f64) -> f64 {
        let beyond = (distance - band).max(0.0);
        (size + GROWTH * beyond).min(self.largest)
    }

    /// Whether values a `side` apart tell all of the square about `center` with that side: it is small
    /// beside the edges there, or they are to be equal in all of it.
    pub fn is_even(&self, center: Point, side: f64) -> bool {
        let Some((refinement, membrane)) = &self.refined else {
            return true;
        };
        if side <= COARSEST * refinement.size {
            return true;
        }
        // Nowhere in the square is the distance another one by more than its half diagonal.
        let distance = membrane.distance(center);
        let radius = side * std::f64::consts::FRAC_1_SQRT_2;
        let [least, greatest] = [(distance - radius).max(0.0), distance + radius]
            .map(|distance| self.at_distance(*refinement, distance));
        side <= COARSEST * least || least == greatest
    }

    /// About how many nodes a mesh of the unit square has.
    pub fn nodes(&self) -> f64 {
        /// Squares along a side that are divided where the size is not even in them.
        const SQUARES: usize = 200;
        // Along the wall there are half as many more.
        let wall = 2.0 / self.largest;
        if self.refined.is_none() {
            return DENSITY / (self.largest * self.largest) + wall;
        }
        let side = 1.0 / SQUARES as f64;
        let center = |index: usize| (index as f64 + 0.5) * side;
        let squares = (0..SQUARES).flat_map(|row| (0..SQUARES).map(move |column| [column, row]));
        let inside: f64 = squares
            .map(|square| self.nodes_in(Point::from(square.map(center)), side))
            .sum();
        inside + wall
    }

    /// About how many nodes there are in a square.
    fn nodes_in(&self, center: Point, side: f64) -> f64 {
        if self.is_even(center, side) {
            return DENSITY * (side / self.at(center)).powi(2);
        }
        let half = 0.5 * side;
        [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]]
            .map(|[right, up]| self.nodes_in(center + half * Vector::new(right, up), half))
            .iter()
            .sum()
    }
}
