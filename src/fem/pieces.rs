//! The region φ > 0 of a P1 function: in how many pieces it is, and which way it is long.

use super::Mesh;
use crate::geometry::{Point, SymmetricTensor, Vector};

/// The pieces of the region φ > 0; what is needed to find them is kept from one time to the next.
#[derive(Debug, Clone, Default)]
pub struct Pieces {
    /// Of each node another one of the same piece, or itself (a union–find forest).
    parents: Vec<u32>,
    /// Of each node the number of its piece, from 0 in the order of the nodes; [`OUTSIDE`] elsewhere.
    of_nodes: Vec<u32>,
    count: usize,
}

/// The number of no piece: φ ≤ 0.
const OUTSIDE: u32 = u32::MAX;

/// What became of pieces: how often each of these happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PieceChanges {
    /// A piece that was several.
    pub merged: usize,
    /// A piece that is several now.
    pub split: usize,
    /// A piece where there was none.
    pub appeared: usize,
    /// A piece of which there is nothing left.
    pub vanished: usize,
}

impl Pieces {
    /// Finds the pieces; returns their number.
    ///
    /// Within a triangle the region is convex, and it goes on across an edge if φ > 0 at an end of the
    /// edge: so its pieces are those of the graph that the edges make of the nodes with φ > 0.
    pub fn find(&mut self, mesh: &Mesh, values: &[f64]) -> usize {
        self.parents.clear();
        self.parents.extend(0..values.len() as u32);
        let is_inside = |node: u32| values[node as usize] > 0.0;
        for &[a, b, c] in mesh.triangles() {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if is_inside(from) && is_inside(to) {
                    self.join(from, to);
                }
            }
        }
        self.count = 0;
        self.of_nodes.clear();
        self.of_nodes.resize(values.len(), OUTSIDE);
        for node in (0..values.len() as u32).filter(|node| is_inside(*node)) {
            // The root is the first node of its piece.
            let root = self.root(node);
            let piece = match self.of_nodes[root as usize] {
                OUTSIDE => {
                    self.count += 1;
                    self.count as u32 - 1
                }
                known => known,
            };
            self.of_nodes[node as usize] = piece;
        }
        self.count
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The number of the piece that a node is in; `None`: φ ≤ 0 there.
    pub fn of_node(&self, node: u32) -> Option<usize> {
        let piece = *self.of_nodes.get(node as usize)?;
        (piece != OUTSIDE).then_some(piece as usize)
    }

    /// What has become of the pieces `before`, which were found on the same mesh: pieces are the same where they have
    /// a node in common.
    pub fn changes_since(&self, before: &Self) -> PieceChanges {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (old, new) in before.of_nodes.iter().zip(&self.of_nodes) {
            let pair = (*old, *new);
            if *old != OUTSIDE && *new != OUTSIDE && pairs.last() != Some(&pair) {
                pairs.push(pair);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let (mut of_old, mut of_new) = (vec![0; before.count], vec![0; self.count]);
        for (old, new) in pairs {
            of_old[old as usize] += 1;
            of_new[new as usize] += 1;
        }
        let several = |counts: &[usize]| counts.iter().filter(|count| **count > 1).count();
        let none = |counts: &[usize]| counts.iter().filter(|count| **count == 0).count();
        PieceChanges {
            merged: several(&of_new),
            split: several(&of_old),
            appeared: none(&of_new),
            vanished: none(&of_old),
        }
    }

    /// Makes two pieces one.
    fn join(&mut self, one: u32, other: u32) {
        let [one, other] = [one, other].map(|node| self.root(node));
        self.parents[one.max(other) as usize] = one.min(other);
    }

    /// The node that stands for the piece of this one.
    fn root(&mut self, mut node: u32) -> u32 {
        while self.parents[node as usize] != node {
            let parent = self.parents[node as usize];
            let next = self.parents[parent as usize];
            // Half as far the next time.
            self.parents[node as usize] = next;
            node = next;
        }
        node
    }
}

/// Centre and second moments of max(φ, 0), lumped.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moments {
    mass: f64,
    sum: Vector,
    /// ∫ x⊗x about the centre.
    second: SymmetricTensor,
}

impl Moments {
    /// Those of each of `count` pieces; `piece_of` has the number of a node's piece.
    pub fn of_pieces(
        mesh: &Mesh,
        values: &[f64],
        count: usize,
        piece_of: impl Fn(u32) -> Option<usize>,
        moments: &mut Vec<Moments>,
    ) {
        moments.clear();
        moments.resize(count, Self::default());
        let weighted = || {
            let triangles = mesh.triangles().iter().zip(mesh.areas());
            let corners = triangles.flat_map(|(corners, area)| corners.map(|node| (node, area)));
            corners.filter_map(|(node, area)| {
                let weight = area * values[node as usize].max(0.0);
                Some((piece_of(node)?, mesh.nodes()[node as usize], weight))
            })
        };
        for (piece, place, weight) in weighted() {
            moments[piece].mass += weight;
            moments[piece].sum += weight * place.coords;
        }
        for (piece, place, weight) in weighted() {
            let offset = place - moments[piece].center();
            moments[piece].second += SymmetricTensor::outer(weight, offset);
        }
    }

    /// The centre.
    pub fn center(&self) -> Point {
        Point::from(self.sum / self.mass)
    }

    /// The direction in which it is longest, a unit vector.
    pub fn long_axis(&self) -> Vector {
        let [xx, xy, yy] = self.second.entries();
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        // Of no region there is none: any will do.
        if angle.is_finite() {
            Vector::new(angle.cos(), angle.sin())
        } else {
            Vector::x()
        }
    }
}

/// The direction in which the region φ > 0 is longest, by its second moments; a unit vector.
pub fn long_axis(mesh: &Mesh, values: &[f64]) -> Vector {
    center_and_axis(mesh, values).1
}

/// The centre of the region φ > 0, by its first moments, and the direction in which it is longest.
pub fn center_and_axis(mesh: &Mesh, values: &[f64]) -> (Point, Vector) {
    let mut moments = Vec::new();
    Moments::of_pieces(mesh, values, 1, |_| Some(0), &mut moments);
    (moments[0].center(), moments[0].long_axis())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(mesh: &Mesh, phi: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        mesh.nodes().iter().map(|at| phi(at.x, at.y)).collect()
    }

    #[test]
    fn pieces_are_counted_as_they_part_and_merge() {
        let mesh = Mesh::structured(40, 0.2, 3).expect("a fair mesh");
        let circle = |x: f64, y: f64, at: f64| 0.15 - (x - at).hypot(y - 0.5);
        let mut pieces = Pieces::default();
        let mut count = |phi: &dyn Fn(f64, f64) -> f64| pieces.find(&mesh, &values(&mesh, phi));
        assert_eq!(count(&|x, y| circle(x, y, 0.25).max(circle(x, y, 0.75))), 2);
        assert_eq!(count(&|x, y| circle(x, y, 0.4).max(circle(x, y, 0.6))), 1);
        assert_eq!(count(&|_, _| -1.0), 0);
        assert_eq!(count(&|_, _| f64::NAN), 0);
        assert_eq!(count(&|_, _| 1.0), 1);
        // A ring is one piece, though its membrane is two curves.
        assert_eq!(count(&|x, y| 0.05 - circle(x, y, 0.5).abs()), 1);
        // The positive fields of a checkerboard.
        let wave = |x: f64| (4.0 * std::f64::consts::PI * x).sin();
        assert_eq!(count(&|x, y| wave(x) * wave(y) - 0.3), 8);
    }

    #[test]
    fn what_became_of_pieces_is_known() {
        let mesh = Mesh::structured(40, 0.2, 3).expect("a fair mesh");
        let found = |centres: &[f64]| {
            let circle = |x: f64, y: f64, at: f64| 0.12 - (x - at).hypot(y - 0.5);
            let phi = |x: f64, y: f64| {
                let distances = centres.iter().map(|at| circle(x, y, *at));
                distances.fold(-1.0, f64::max)
            };
            let mut pieces = Pieces::default();
            pieces.find(&mesh, &values(&mesh, phi));
            pieces
        };
        let none = PieceChanges::default();
        let (apart, near) = (found(&[0.3, 0.7]), found(&[0.4, 0.6]));
        let left = found(&[0.3]);
        for (before, after, changes) in [
            (&apart, &apart, none),
            (&apart, &near, PieceChanges { merged: 1, ..none }),
            (&near, &apart, PieceChanges { split: 1, ..none }),
            (
                &apart,
                &left,
                PieceChanges {
                    vanished: 1,
                    ..none
                },
            ),
            (
                &left,
                &apart,
                PieceChanges {
                    appeared: 1,
                    ..none
                },
            ),
        ] {
            assert_eq!(after.changes_since(before), changes, "{changes:?}");
        }
        assert_eq!(apart.count(), 2);
        assert_eq!(Pieces::default().of_node(0), None);
    }

    #[test]
    fn the_long_axis_of_an_ellipse_is_found_at_every_angle() {
        let mesh = Mesh::structured(60, 0.0, 0).expect("a regular mesh");
        for degrees in [0.0_f64, 30.0, 90.0, 135.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let ellipse = |x: f64, y: f64| {
                let [x, y] = [x - 0.5, y - 0.5];
                let [along, across] = [cosine * x + sine * y, cosine * y - sine * x];
                1.0 - (along / 0.35).hypot(across / 0.2)
            };
            let [x, y] = long_axis(&mesh, &values(&mesh, ellipse)).into();
            let aligned = (x * cosine + y * sine).abs();
            assert!(aligned > 1.0 - 1e-4, "{degrees}: [{x}, {y}]");
        }
        assert_eq!(long_axis(&mesh, &vec![-1.0; 61 * 61]), Vector::x());
    }
}
