//! How good the triangles of a mesh are.

use super::Mesh;

/// Angles and sizes of the triangles of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// The smallest angle, in degrees.
    pub least_angle: f64,
    /// The greatest angle, in degrees.
    pub greatest_angle: f64,
    /// The shortest edge, the mean one and the longest.
    pub edges: [f64; 3],
}

impl Quality {
    /// Of a mesh; an edge between two triangles counts twice in the mean.
    pub fn of(mesh: &Mesh) -> Self {
        let mut quality = Self {
            least_angle: 180.0,
            greatest_angle: 0.0,
            edges: [f64::INFINITY, 0.0, 0.0],
        };
        let mut sum = 0.0;
        for triangle in mesh.triangles() {
            let corners = triangle.map(|node| mesh.nodes()[node as usize]);
            for corner in 0..3 {
                let [from, one, other] =
                    [0, 1, 2].map(|further: usize| corners[(corner + further) % 3]);
                let [u, v] = [one, other].map(|to| [to[0] - from[0], to[1] - from[1]]);
                let (cross, dot) = (u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
                let angle = cross.atan2(dot).to_degrees();
                quality.least_angle = quality.least_angle.min(angle);
                quality.greatest_angle = quality.greatest_angle.max(angle);
                let length = u[0].hypot(u[1]);
                sum += length;
                quality.edges[0] = quality.edges[0].min(length);
                quality.edges[2] = quality.edges[2].max(length);
            }
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
        let quality = Quality::of(&mesh);
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
}
