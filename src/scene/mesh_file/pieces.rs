//! Whether all triangles hang together; where they do not, whether a piece lies over another one.

use crate::geometry::{Point, length};

/// What is wrong with a mesh in several pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PieceFault {
    /// No piece lies over another one.
    Apart {
        /// The first triangle that does not hang together with the first of all.
        triangle: usize,
    },
    /// Two pieces overlap.
    Over {
        /// A triangle of the one.
        triangle: usize,
        /// An edge of the boundary of the other, whose first node lies within the triangle.
        edge: usize,
    },
}

/// What is wrong with triangles (counter-clockwise) that do not hang together. No two edges of their boundary
/// cross, and no node of it is within `tolerance` of another edge: so where two pieces overlap, a whole curve
/// of the boundary of one lies in the other.
pub(super) fn check_pieces(
    nodes: &[Point],
    triangles: &[[u32; 3]],
    boundary: &[[u32; 2]],
    tolerance: f64,
) -> Option<PieceFault> {
    let pieces = pieces(nodes.len(), triangles);
    let piece = |node: u32| pieces[node as usize];
    let first = piece(triangles.first()?[0]);
    let apart = triangles
        .iter()
        .position(|corners| piece(corners[0]) != first)?;
    let mut starts: Vec<(f64, usize)> = boundary
        .iter()
        .enumerate()
        .map(|(edge, ends)| (nodes[ends[0] as usize][0], edge))
        .collect();
    starts.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
    for (triangle, corners) in triangles.iter().enumerate() {
        let places = corners.map(|node| nodes[node as usize]);
        let xs = places.map(|place| place[0]);
        let left = xs.into_iter().fold(f64::INFINITY, f64::min) - tolerance;
        let right = xs.into_iter().fold(f64::NEG_INFINITY, f64::max) + tolerance;
        let from = starts.partition_point(|(x, _)| *x < left);
        let near = starts[from..].iter().take_while(|(x, _)| *x <= right);
        for &(_, edge) in near {
            let node = boundary[edge][0];
            if piece(node) != piece(corners[0]) && is_in(places, nodes[node as usize], tolerance) {
                return Some(PieceFault::Over { triangle, edge });
            }
        }
    }
    Some(PieceFault::Apart { triangle: apart })
}

/// Whether a place is in a triangle, or nearer to it than that.
fn is_in(corners: [Point; 3], place: Point, tolerance: f64) -> bool {
    (0..3).all(|corner| {
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let along = b - a;
        along.perp(&(place - a)) >= -tolerance * length(along)
    })
}

/// For each node one that stands for all of its piece.
fn pieces(nodes: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut leader: Vec<u32> = (0..nodes as u32).collect();
    fn find(leader: &mut [u32], mut node: u32) -> u32 {
        while leader[node as usize] != node {
            leader[node as usize] = leader[leader[node as usize] as usize];
            node = leader[node as usize];
        }
        node
    }
    for corners in triangles {
        let first = find(&mut leader, corners[0]);
        for node in &corners[1..] {
            let other = find(&mut leader, *node);
            leader[other as usize] = first;
        }
    }
    (0..nodes as u32)
        .map(|node| find(&mut leader, node))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: u32 = 8;

    fn around(radius: f64) -> impl Iterator<Item = Point> {
        (0..CORNERS).map(move |corner| {
            let angle = f64::from(corner) * std::f64::consts::TAU / f64::from(CORNERS);
            Point::new(radius * angle.cos(), radius * angle.sin())
        })
    }

    /// A ring between the radii 1 and 3, and a disc of another radius in its middle.
    fn found(radius: f64) -> Option<PieceFault> {
        let nodes: Vec<Point> = around(1.0)
            .chain(around(3.0))
            .chain(around(radius))
            .chain([Point::origin()])
            .collect();
        let edge = |corner: u32, first: u32| [first + corner, first + (corner + 1) % CORNERS];
        let (outer, disc, center) = (CORNERS, 2 * CORNERS, 3 * CORNERS);
        let ring = (0..CORNERS).flat_map(|corner| {
            let ([a, b], [c, d]) = (edge(corner, 0), edge(corner, outer));
            [[a, c, d], [a, d, b]]
        });
        let fan = (0..CORNERS).map(|corner| {
            let [a, b] = edge(corner, disc);
            [center, a, b]
        });
        let triangles: Vec<[u32; 3]> = ring.chain(fan).collect();
        let curves = [0, outer, disc].into_iter();
        let boundary: Vec<[u32; 2]> = curves
            .flat_map(|first| (0..CORNERS).map(move |corner| edge(corner, first)))
            .collect();
        check_pieces(&nodes, &triangles, &boundary, 1e-10)
    }

    #[test]
    fn pieces_that_overlap_are_told_from_those_that_do_not() {
        let first_of_disc = 2 * CORNERS as usize;
        assert_eq!(
            found(0.5),
            Some(PieceFault::Apart {
                triangle: first_of_disc
            })
        );
        // No node of the ring lies in the disc where it is small, none of the disc in the ring where it is large.
        for radius in [2.0, 4.0] {
            let Some(PieceFault::Over { triangle, edge }) = found(radius) else {
                panic!("{radius}");
            };
            let of_disc = triangle >= first_of_disc;
            assert_ne!(of_disc, edge >= 2 * CORNERS as usize, "{radius}");
        }
    }
}
