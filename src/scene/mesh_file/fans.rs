//! Whether the triangles about every node are one fan, that goes round once at most.

use std::f64::consts::TAU;

use crate::geometry::Point;

/// By so much the angles about a node may be more than a full turn, for rounding.
const ROUNDING: f64 = 1e-9;

/// What is wrong about a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FanFault {
    /// The node.
    pub(super) node: u32,
    /// Two triangles about it, of two fans or one over the other.
    pub(super) triangles: [usize; 2],
    /// Whether they overlap.
    pub(super) overlap: bool,
}

/// A triangle as it is seen from a node: from the direction to its next corner it goes on,
/// counter-clockwise, to that of the last.
#[derive(Debug, Clone, Copy)]
struct Sector {
    triangle: usize,
    next: u32,
    last: u32,
    begin: f64,
    extent: f64,
}

/// The first node whose triangles, all counter-clockwise, are not one fan that goes round once at most.
pub(super) fn check_fans(
    nodes: &[Point],
    triangles: &[[u32; 3]],
    boundary: &[[u32; 2]],
) -> Option<FanFault> {
    let mut turns = vec![0.0; nodes.len()];
    for corners in triangles {
        for corner in 0..3 {
            let sector = Sector::new(nodes, 0, *corners, corner);
            turns[corners[corner] as usize] += sector.extent;
        }
    }
    // A fan that does not go round has two edges of the boundary.
    let mut ends = vec![0_u32; nodes.len()];
    for node in boundary.iter().flatten() {
        ends[*node as usize] += 1;
    }
    let is_wrong = |node: usize| ends[node] > 2 || turns[node] > TAU + ROUNDING;
    let node = (0..nodes.len()).find(|node| is_wrong(*node))? as u32;
    let mut sectors = Vec::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(corner) = corners.iter().position(|it| *it == node) {
            sectors.push(Sector::new(nodes, triangle, *corners, corner));
        }
    }
    Some(fault(node, sectors))
}

impl Sector {
    fn new(nodes: &[Point], triangle: usize, corners: [u32; 3], corner: usize) -> Self {
        let [own, next, last] = [0, 1, 2].map(|further| corners[(corner + further) % 3]);
        let [u, v] = [next, last].map(|node| nodes[node as usize] - nodes[own as usize]);
        Self {
            triangle,
            next,
            last,
            begin: u.y.atan2(u.x),
            extent: u.perp(&v).atan2(u.dot(&v)),
        }
    }
}

/// Two triangles that overlap, or else two with a gap between them.
fn fault(node: u32, mut sectors: Vec<Sector>) -> FanFault {
    sectors.sort_unstable_by(|one, other| one.begin.total_cmp(&other.begin));
    let neighbours = (0..sectors.len()).map(|place| {
        let next = (place + 1) % sectors.len();
        // Round once behind the last one.
        let turn = if next == 0 { TAU } else { 0.0 };
        (sectors[place], sectors[next], turn)
    });
    // If any two overlap, two neighbours do: one begins before the other has ended.
    let over = |(one, other, turn): &(Sector, Sector, f64)| {
        one.last != other.next && one.begin + one.extent > other.begin + turn + ROUNDING
    };
    let gap = |(one, other, _): &(Sector, Sector, f64)| one.last != other.next;
    let overlapping = neighbours.clone().find(over);
    let (one, other, overlap) = match overlapping {
        Some((one, other, _)) => (one, other, true),
        None => {
            // About a node with several fans and nothing over another there are gaps.
            let found = neighbours.clone().find(gap);
            let (one, other) =
                found.map_or((sectors[0], sectors[0]), |(one, other, _)| (one, other));
            (one, other, false)
        }
    };
    FanFault {
        node,
        triangles: [
            one.triangle.min(other.triangle),
            one.triangle.max(other.triangle),
        ],
        overlap,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: usize) -> Vec<Point> {
        let corner = |n: usize| {
            let angle = TAU * n as f64 / 12.0 - 3.0;
            Point::new(angle.cos(), angle.sin())
        };
        (0..count).map(corner).collect()
    }

    /// Triangles about node 0 between neighbours on a ring of twelve places, from one to another.
    fn found(steps: &[[u32; 2]]) -> Option<FanFault> {
        let nodes: Vec<Point> = std::iter::once(Point::origin()).chain(ring(24)).collect();
        let triangles: Vec<[u32; 3]> = steps
            .iter()
            .flat_map(|&[from, to]| from..to)
            .map(|n| [n + 1, n + 2, 0])
            .collect();
        let mut boundary: Vec<[u32; 2]> = triangles.iter().map(|it| [it[0], it[1]]).collect();
        boundary.extend(steps.iter().flat_map(|it| it.map(|end| [0, end + 1])));
        check_fans(&nodes, &triangles, &boundary)
    }

    #[test]
    fn one_fan_is_fine_and_two_are_not() {
        assert_eq!(found(&[[0, 1]]), None);
        assert_eq!(found(&[[3, 11]]), None);
        let two = found(&[[0, 3], [6, 8]]).expect("two fans");
        assert_eq!((two.node, two.triangles, two.overlap), (0, [2, 3], false));
    }

    #[test]
    fn what_lies_over_another_is_found() {
        // The places 12 to 23 are those of 0 to 11 once more.
        let over = found(&[[0, 2], [13, 14]]).expect("two fans, one over the other");
        assert!(over.overlap, "{over:?}");
        let wound = found(&[[0, 14]]).expect("one that goes round more than once");
        assert!(wound.overlap, "{wound:?}");
    }
}
