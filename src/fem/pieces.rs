//! The region φ > 0 of a P1 function: in how many pieces it is, and which way it is long.

use super::Mesh;
use crate::geometry::{Point, SymmetricTensor, Vector};

/// Counts the pieces of the region φ > 0; what it needs for that is kept from one count to the next.
#[derive(Debug, Clone, Default)]
pub struct Pieces {
    /// Of each node another one of the same piece, or itself (a union–find forest).
    parents: Vec<u32>,
}

impl Pieces {
    /// The number of pieces.
    ///
    /// Within a triangle the region is convex, and it goes on across an edge if φ > 0 at an end of the
    /// edge: so its pieces are those of the graph that the edges make of the nodes with φ > 0.
    pub fn count(&mut self, mesh: &Mesh, values: &[f64]) -> usize {
        self.parents.clear();
        self.parents.extend(0..values.len() as u32);
        let is_inside = |node: u32| values[node as usize] > 0.0;
        let mut count = values.iter().filter(|value| **value > 0.0).count();
        for &[a, b, c] in mesh.triangles() {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if is_inside(from) && is_inside(to) && self.join(from, to) {
                    count -= 1;
                }
            }
        }
        count
    }

    /// Makes two pieces one; whether they were two.
    fn join(&mut self, one: u32, other: u32) -> bool {
        let [one, other] = [one, other].map(|node| self.root(node));
        self.parents[one.max(other) as usize] = one.min(other);
        one != other
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

/// The direction in which the region φ > 0 is longest, by its second moments; a unit vector.
pub fn long_axis(mesh: &Mesh, values: &[f64]) -> Vector {
    center_and_axis(mesh, values).1
}

/// The centre of the region φ > 0, by its first moments, and the direction in which it is longest.
pub fn center_and_axis(mesh: &Mesh, values: &[f64]) -> (Point, Vector) {
    // Of max(φ, 0), lumped: the mean, and about it ∫ x⊗x.
    let weighted = || {
        let triangles = mesh.triangles().iter().zip(mesh.areas());
        triangles.flat_map(|(corners, area)| {
            corners.map(|node| {
                let node = node as usize;
                (mesh.nodes()[node], area * values[node].max(0.0))
            })
        })
    };
    let (mass, sum) = weighted().fold((0.0, Vector::zeros()), |(mass, sum), (place, weight)| {
        (mass + weight, sum + weight * place.coords)
    });
    let center = Point::from(sum / mass);
    let mut moments = SymmetricTensor::default();
    for (place, weight) in weighted() {
        moments += SymmetricTensor::outer(weight, place - center);
    }
    let [xx, xy, yy] = moments.entries();
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    // Of no region there is none: any will do.
    let axis = match angle.is_finite() {
        true => Vector::new(angle.cos(), angle.sin()),
        false => Vector::x(),
    };
    (center, axis)
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
        let mut count = |phi: &dyn Fn(f64, f64) -> f64| pieces.count(&mesh, &values(&mesh, phi));
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
