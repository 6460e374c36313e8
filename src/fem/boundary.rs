//! The boundary of a mesh, ∂Ω: straight edges, and how far places are from them.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::Mesh;
use crate::geometry::{Point, Segment, SegmentGrid, segment_distance};

/// The edges of the boundary of a mesh.
#[derive(Debug, Clone)]
pub struct Wall {
    edges: Vec<Segment>,
}

impl Wall {
    /// Of a mesh: the edges that belong to one triangle only, with the domain on their left.
    pub fn of(mesh: &Mesh) -> Self {
        let place = |node: u32| mesh.nodes()[node as usize];
        let edges = mesh.boundary_edges().into_iter();
        Self {
            edges: edges.map(|edge| edge.map(place)).collect(),
        }
    }

    /// The edges.
    pub fn edges(&self) -> &[Segment] {
        &self.edges
    }

    /// How far a place is from the wall.
    pub fn distance(&self, place: Point) -> f64 {
        let distances = self.edges.iter().map(|edge| segment_distance(place, *edge));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The numbers of the nodes of a mesh that are within `reach` of the wall.
    pub fn nodes_within(&self, mesh: &Mesh, reach: f64) -> Vec<u32> {
        let grid = SegmentGrid::new(self.edges.clone(), reach);
        let nodes = mesh.nodes().iter().enumerate();
        nodes
            .filter(|(_, place)| grid.is_near(**place))
            .map(|(node, _)| node as u32)
            .collect()
    }

    /// How far a curve keeps from the wall, by its signed distance (positive inside of it): negative
    /// where it reaches across. Taken at eight places of every edge.
    pub fn clearance(&self, signed_distance: impl Fn(Point) -> f64) -> f64 {
        const PARTS: usize = 8;
        let places = self.edges.iter().flat_map(|[from, to]| {
            (0..PARTS).map(move |part| {
                let share = part as f64 / PARTS as f64;
                from + share * (to - from)
            })
        });
        places
            .map(|place| -signed_distance(place))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Whether a place that no triangle covers lies in a hole of the mesh: a closed curve of the boundary goes round
/// it clockwise, with the domain on its left.
pub fn is_in_hole(mesh: &Mesh, place: Point) -> bool {
    let edges = mesh.boundary_edges();
    // Every node of the boundary has one edge that begins there: no two curves share one.
    let mut next: HashMap<u32, u32> = edges.iter().map(|[from, to]| (*from, *to)).collect();
    let angle = |from: u32, to: u32| {
        let [u, v] = [from, to].map(|node| mesh.nodes()[node as usize] - place);
        u.perp(&v).atan2(u.dot(&v))
    };
    edges.iter().any(|[start, _]| {
        let (mut turn, mut at) = (0.0, *start);
        while let Some(to) = next.remove(&at) {
            turn += angle(at, to);
            at = to;
        }
        turn < -0.5 * TAU
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::length;

    #[test]
    fn the_wall_of_the_square_is_its_four_sides() {
        let mesh = Mesh::structured(6, 0.2, 1).expect("a fair mesh");
        let wall = Wall::of(&mesh);
        assert_eq!(wall.edges().len(), 24);
        for place in [[0.5_f64, 0.25], [0.1, 0.7], [0.95, 0.9]] {
            let ([x, y], place) = (place, Point::from(place));
            let wanted = x.min(1.0 - x).min(y).min(1.0 - y);
            assert!((wall.distance(place) - wanted).abs() < 1e-15);
        }
        // With the domain on the left the sum over the edges is twice the area.
        let crosses = wall.edges().iter().map(|[a, b]| a.coords.perp(&b.coords));
        assert!((crosses.sum::<f64>() - 2.0).abs() < 1e-14);
        let near = wall.nodes_within(&mesh, 0.22);
        let brute = (0..49).filter(|n| wall.distance(mesh.nodes()[*n as usize]) <= 0.22);
        assert_eq!(near, brute.collect::<Vec<u32>>());
        // A circle about the middle, and one that reaches out.
        let center = Point::new(0.5, 0.5);
        let circle = |radius: f64| wall.clearance(|place| radius - length(place - center));
        assert!((circle(0.3) - 0.2).abs() < 1e-12);
        assert!((circle(0.6) + 0.1).abs() < 1e-12);
    }

    /// A square with a square hole, and a notch.
    #[test]
    fn a_hole_is_told_from_what_is_outside() {
        let mesh = Mesh::structured(8, 0.0, 0).expect("a regular mesh");
        let kept: Vec<u32> = (0..mesh.triangles().len() as u32)
            .filter(|triangle| {
                let corners = mesh.triangles()[*triangle as usize];
                let middle = |axis: usize| {
                    let at = corners.map(|node| mesh.nodes()[node as usize][axis]);
                    at.iter().sum::<f64>() / 3.0
                };
                let (x, y) = (middle(0), middle(1));
                let is_hole = (0.25..0.5).contains(&x) && (0.25..0.5).contains(&y);
                let is_notch = x > 0.75 && (0.25..0.5).contains(&y);
                !is_hole && !is_notch
            })
            .collect();
        let (mesh, _) = mesh.part(&kept).expect("a part");
        for (place, wanted) in [
            ([0.4, 0.3], true),
            ([0.26, 0.49], true),
            ([0.9, 0.4], false),
            ([1.2, 0.4], false),
            ([-3.0, 7.0], false),
        ] {
            assert_eq!(is_in_hole(&mesh, place.into()), wanted, "{place:?}");
        }
    }
}
