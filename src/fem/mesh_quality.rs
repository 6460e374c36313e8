//! How good the triangles of a mesh are.

use super::Mesh;
use crate::geometry;

/// A triangle with an angle below this, in degrees, is a sliver: so is every one with an angle near 180°.
pub const SLIVER: f64 = 1.0;

/// Angles and sizes of the triangles of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshQuality {
    /// The smallest angle, in degrees.
    pub least_angle: f64,
    /// The greatest angle, in degrees.
    pub greatest_angle: f64,
    /// The shortest edge, the mean one and the longest.
    pub edges: [f64; 3],
    /// How many triangles have an angle below [`SLIVER`].
    pub slivers: usize,
    /// The triangle with the smallest angle.
    pub worst: WorstTriangle,
}

/// The triangle of a mesh with the smallest angle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WorstTriangle {
    /// Its middle.
    pub at: [f64; 2],
    /// Its smallest and its greatest angle, in degrees.
    pub angles: [f64; 2],
}

impl MeshQuality {
    /// Of a mesh; an edge between two triangles counts twice in the mean.
    pub fn of(mesh: &Mesh) -> Self {
        let mut quality = Self {
            least_angle: 180.0,
            greatest_angle: 0.0,
            edges: [f64::INFINITY, 0.0, 0.0],
            slivers: 0,
            worst: WorstTriangle::default(),
        };
        let mut sum = 0.0;
        for triangle in mesh.triangles() {
            let corners = triangle.map(|node| mesh.nodes()[node as usize]);
            let mut angles = [180.0_f64, 0.0];
            for corner in 0..3 {
                let [from, one, other] =
                    [0, 1, 2].map(|further: usize| corners[(corner + further) % 3]);
                let [u, v] = [one, other].map(|to| to - from);
                let angle = u.perp(&v).atan2(u.dot(&v)).to_degrees();
                angles = [angles[0].min(angle), angles[1].max(angle)];
                let length = geometry::length(u);
                sum += length;
                quality.edges[0] = quality.edges[0].min(length);
                quality.edges[2] = quality.edges[2].max(length);
            }
            quality.slivers += usize::from(angles[0] < SLIVER);
            if angles[0] < quality.least_angle {
                quality.least_angle = angles[0];
                let middle = |axis: usize| corners.iter().map(|at| at[axis]).sum::<f64>() / 3.0;
                let at = [middle(0), middle(1)];
                quality.worst = WorstTriangle { at, angles };
            }
            quality.greatest_angle = quality.greatest_angle.max(angles[1]);
        }
        quality.edges[1] = sum / (3 * mesh.triangles().len()).max(1) as f64;
        quality
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_triangles_have_their_angles() {
        let mesh = Mesh::structured(4, 0.0, 1).expect("a regular mesh");
        let quality = MeshQuality::of(&mesh);
        let root = 2.0_f64.sqrt();
        let wanted = [45.0, 90.0, 0.25, 0.25 * (2.0 + root) / 3.0, 0.25 * root];
        let [shortest, mean, longest] = quality.edges;
        let found = [
            quality.least_angle,
            quality.greatest_angle,
            shortest,
            mean,
            longest,
        ];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{quality:?}");
        }
    }

    /// A flat triangle and a needle, beside fair ones.
    #[test]
    fn slivers_are_counted_and_the_worst_is_found() {
        assert_eq!(
            MeshQuality::of(&Mesh::structured(4, 0.0, 1).expect("a regular mesh")).slivers,
            0
        );
        let mesh = |low: f64, right: f64| {
            let nodes = [[0.0, 0.0], [1.0, 0.0], [0.5, low], [0.5, 1.0], [right, 0.5]];
            let nodes = nodes.map(geometry::Point::from).to_vec();
            Mesh::new(nodes, vec![[0, 1, 2], [1, 3, 2], [1, 4, 3], [0, 2, 3]])
        };
        let fair = MeshQuality::of(&mesh(0.3, 1.0).expect("a mesh"));
        assert_eq!(fair.slivers, 0, "{fair:?}");
        let flat = MeshQuality::of(&mesh(1e-3, 1.0).expect("a mesh"));
        assert_eq!(flat.slivers, 1, "{flat:?}");
        let WorstTriangle { at, angles } = flat.worst;
        assert!((at[0] - 0.5).abs() < 1e-12 && at[1] < 1e-3, "{flat:?}");
        assert!((angles[0] - 0.1146).abs() < 1e-4, "{flat:?}");
        assert!((angles[1] - 179.7708).abs() < 1e-4, "{flat:?}");
        let two = MeshQuality::of(&mesh(1e-3, 0.7501).expect("a mesh"));
        assert_eq!(two.slivers, 2, "{two:?}");
        assert!(two.worst.at[0] > 0.7, "{two:?}");
    }
}
