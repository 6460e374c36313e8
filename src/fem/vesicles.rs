//! What is measured of each vesicle, a piece of the region φ > 0: place, size and shape.

use super::contour::{OutlineMeasure, cut, mirrored, ring};
use super::pieces::{PieceChanges, Pieces};
use super::{Mesh, Moments};
use crate::geometry::{Point, Segment, Vector, length};
use crate::scene::Geometry;
use std::f64::consts::PI;

/// A vesicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vesicle {
    /// Its centre: that of max(φ, 0).
    pub center: Point,
    /// The area that it encloses.
    pub area: f64,
    /// The length of its membrane φ = 0.
    pub perimeter: f64,
    /// By rotation, volume and surface of its body.
    pub body: Option<[f64; 2]>,
    /// Its length, waist and greatest width, by rotation those of the whole section; `None` where the domain is all within it.
    pub outline: Option<OutlineMeasure>,
    /// Whether it touches the wall: its membrane is not closed then.
    pub is_at_wall: bool,
}

impl Vesicle {
    /// 4π·area/perimeter², 1 for a circle and less for every other shape, or by rotation the reduced volume
    /// 6√π·volume/surface^(3/2), 1 for a sphere; `None` at the wall, where the membrane is not closed.
    pub fn reduced_size(&self) -> Option<f64> {
        let is_closed = !self.is_at_wall && self.perimeter > 0.0;
        is_closed.then(|| match self.body {
            None => 4.0 * PI * self.area / self.perimeter.powi(2),
            Some([volume, surface]) => 6.0 * PI.sqrt() * volume / surface.powf(1.5),
        })
    }
}

/// Finds the vesicles and measures them; what is needed for that is kept from one time to the next.
#[derive(Debug, Clone, Default)]
pub struct Vesicles {
    pieces: Pieces,
    /// Those of the time that is compared with.
    before: Option<Pieces>,
    /// The membrane, vesicle by vesicle.
    segments: Vec<(usize, Segment)>,
    moments: Vec<Moments>,
}

impl Vesicles {
    /// Finds and measures the vesicles of φ, into `found`, from left to right. The long axis of a single one is
    /// `axis`, a unit vector; of several each has its own. `wall` are the nodes at the wall.
    pub fn measure(
        &mut self,
        mesh: &Mesh,
        phi: &[f64],
        axis: Vector,
        wall: &[u32],
        found: &mut Vec<Vesicle>,
    ) {
        let count = self.pieces.find(mesh, phi);
        let pieces = &self.pieces;
        let piece_of = |node: u32| pieces.of_node(node);
        let is_rotated = mesh.geometry() == Geometry::Axisymmetric;
        let none = Vesicle {
            body: is_rotated.then_some([0.0; 2]),
            ..Vesicle::default()
        };
        found.clear();
        found.resize(count, none);
        self.segments.clear();
        for (triangle, triangle_area) in mesh.triangles().iter().zip(mesh.areas()) {
            // A triangle has corners of one piece only.
            let Some(piece) = triangle.iter().find_map(|node| piece_of(*node)) else {
                continue;
            };
            let (part, segment) = cut(mesh, triangle, *triangle_area, phi);
            let vesicle = &mut found[piece];
            vesicle.area += part.area;
            vesicle.perimeter += segment.map_or(0.0, |[from, to]| length(to - from));
            if let Some([volume, surface]) = &mut vesicle.body {
                *volume += part.volume;
                *surface += segment.as_ref().map_or(0.0, ring);
            }
            self.segments
                .extend(segment.map(|segment| (piece, segment)));
        }
        for piece in wall.iter().filter_map(|node| piece_of(*node)) {
            found[piece].is_at_wall = true;
        }
        Moments::of_pieces(mesh, phi, count, piece_of, &mut self.moments);
        self.segments.sort_unstable_by_key(|(piece, _)| *piece);
        for of_piece in self.segments.chunk_by(|one, other| one.0 == other.0) {
            let piece = of_piece[0].0;
            let axis = match count {
                1 => axis,
                // Across the axis of rotation or along it.
                _ if is_rotated => axis,
                _ => self.moments[piece].long_axis(),
            };
            let other_side = of_piece.iter().filter(|_| is_rotated);
            let other_side = other_side.map(|(_, segment)| mirrored(segment));
            let segments = of_piece
                .iter()
                .map(|(_, segment)| *segment)
                .chain(other_side);
            found[piece].outline = OutlineMeasure::of(segments, axis);
        }
        for (vesicle, moments) in found.iter_mut().zip(&self.moments) {
            vesicle.center = moments.center();
        }
        // By a number that hardly depends on rounding, whether they lie beside or above each other.
        let place = |vesicle: &Vesicle| vesicle.center.x + 1e-3 * vesicle.center.y;
        found.sort_unstable_by(|one, other| place(one).total_cmp(&place(other)));
    }

    /// Compares the vesicles that were measured just now with those of the last call, unless those were on another
    /// mesh, and remembers them for the next one.
    pub fn changes(&mut self) -> PieceChanges {
        let mut changes = PieceChanges::default();
        if let Some(before) = &self.before
            && (before.count() > 1 || self.pieces.count() != before.count())
        {
            changes = self.pieces.changes_since(before);
        }
        // Without allocating: what is there now is found again before it is used.
        std::mem::swap(self.before.get_or_insert_default(), &mut self.pieces);
        changes
    }

    /// How many there were when they were compared last; `None`: on another mesh, or never.
    pub fn count_before(&self) -> Option<usize> {
        self.before.as_ref().map(Pieces::count)
    }

    /// Forgets what the next vesicles would be compared with: the mesh is another one.
    pub fn forget(&mut self) {
        self.before = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive within ellipses: center, half axes, and the angle of the first one in degrees.
    fn ellipses(mesh: &Mesh, ellipses: &[([f64; 2], [f64; 2], f64)]) -> Vec<f64> {
        let value = |at: &Point| {
            let one = |(center, half_axes, angle): &([f64; 2], [f64; 2], f64)| {
                let (sine, cosine) = angle.to_radians().sin_cos();
                let [x, y] = [at.x - center[0], at.y - center[1]];
                let [along, across] = [cosine * x + sine * y, cosine * y - sine * x];
                1.0 - (along / half_axes[0]).hypot(across / half_axes[1])
            };
            ellipses.iter().map(one).fold(f64::NEG_INFINITY, f64::max)
        };
        mesh.nodes().iter().map(value).collect()
    }

    fn measured(mesh: &Mesh, phi: &[f64], wall: &[u32]) -> Vec<Vesicle> {
        let mut found = Vec::new();
        Vesicles::default().measure(mesh, phi, Vector::x(), wall, &mut found);
        found
    }

    /// Each along its own axis, whatever the other's; a sum over both has no meaning.
    #[test]
    fn each_of_two_vesicles_has_its_own_size() {
        let mesh = Mesh::structured(120, 0.0, 0).expect("a regular mesh");
        let phi = ellipses(
            &mesh,
            &[
                ([0.72, 0.6], [0.2, 0.1], 30.0),
                ([0.25, 0.4], [0.08, 0.2], 0.0),
            ],
        );
        let found = measured(&mesh, &phi, &[]);
        assert_eq!(found.len(), 2);
        for (vesicle, [x, y], [length, width]) in [
            (&found[0], [0.25, 0.4], [0.4, 0.16]),
            (&found[1], [0.72, 0.6], [0.4, 0.2]),
        ] {
            let outline = vesicle.outline.expect("a membrane");
            let area = 0.25 * std::f64::consts::PI * length * width;
            for (value, exact) in [
                (vesicle.center.x, x),
                (vesicle.center.y, y),
                (outline.length, length),
                (outline.width, width),
                (outline.waist, width),
                (vesicle.area, area),
            ] {
                assert!((value / exact - 1.0).abs() < 0.01, "{vesicle:?}");
            }
        }
        // Ramanujan's approximation of the perimeter has an error below 1e-4 here.
        let (a, b): (f64, f64) = (0.2, 0.1);
        let perimeter =
            std::f64::consts::PI * (3.0 * (a + b) - ((3.0 * a + b) * (a + 3.0 * b)).sqrt());
        let exact = 4.0 * std::f64::consts::PI.powi(2) * a * b / perimeter.powi(2);
        let reduced = found[1].reduced_size().expect("a closed membrane");
        assert!((reduced / exact - 1.0).abs() < 5e-3, "{reduced} {exact}");
    }

    #[test]
    fn a_circle_has_the_reduced_area_one_but_not_at_the_wall() {
        let mesh = Mesh::structured(120, 0.0, 0).expect("a regular mesh");
        let wall: Vec<u32> = (0..mesh.nodes().len() as u32)
            .filter(|node| mesh.nodes()[*node as usize].x == 0.0)
            .collect();
        for (x, is_at_wall) in [(0.5, false), (0.1, true)] {
            let phi = ellipses(&mesh, &[([x, 0.5], [0.2, 0.2], 0.0)]);
            let found = measured(&mesh, &phi, &wall);
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].is_at_wall, is_at_wall);
            let reduced = found[0].reduced_size();
            assert_eq!(reduced.is_none(), is_at_wall);
            assert!(reduced.is_none_or(|value| (value - 1.0).abs() < 2e-3));
        }
        assert!(measured(&mesh, &vec![-1.0; mesh.nodes().len()], &wall).is_empty());
    }

    #[test]
    fn changes_are_those_since_the_last_comparison_on_the_same_mesh() {
        let mesh = Mesh::structured(40, 0.0, 0).expect("a regular mesh");
        let apart = [
            ([0.3, 0.5], [0.12, 0.12], 0.0),
            ([0.7, 0.5], [0.12; 2], 0.0),
        ];
        let near = [
            ([0.4, 0.5], [0.12, 0.12], 0.0),
            ([0.6, 0.5], [0.12; 2], 0.0),
        ];
        let (mut vesicles, mut found) = (Vesicles::default(), Vec::new());
        let mut changes = |ellipse: &[_], other_mesh: bool| {
            if other_mesh {
                vesicles.forget();
            }
            vesicles.measure(
                &mesh,
                &ellipses(&mesh, ellipse),
                Vector::x(),
                &[],
                &mut found,
            );
            vesicles.changes()
        };
        let none = PieceChanges::default();
        assert_eq!(changes(&apart, false), none);
        assert_eq!(changes(&near, false), PieceChanges { merged: 1, ..none });
        assert_eq!(changes(&near, false), none);
        assert_eq!(changes(&apart, false), PieceChanges { split: 1, ..none });
        assert_eq!(changes(&near, true), none);
    }
}
