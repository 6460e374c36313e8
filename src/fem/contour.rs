//! The zero set of a P1 function: exact, segment by segment, and what is measured on it.

use std::f64::consts::{PI, TAU};

use super::{Mesh, Wall};
use crate::geometry::{BoundingBox, Point, Segment, Vector, frame, length};
use crate::scene::Geometry;

/// The set φ = 0 of a P1 function and the region φ > 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contour {
    /// One segment for each triangle that the zero set crosses; φ > 0 lies on its left.
    pub segments: Vec<Segment>,
    /// The area of the region φ > 0.
    pub area: f64,
    /// By rotation the volume of the body φ > 0.
    pub volume: Option<f64>,
}

/// The size of a vesicle along and across its long axis.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct OutlineMeasure {
    /// Its extent along the axis.
    pub length: f64,
    /// Its extent across the axis, half way along it.
    pub waist: f64,
    /// Its greatest extent across the axis.
    pub width: f64,
}

/// The rectangle around the nodes at which a P1 function is positive, by rotation of the whole section; `None` where it is
/// nowhere.
pub fn extent_of_inside(mesh: &Mesh, values: &[f64]) -> Option<BoundingBox> {
    let nodes = mesh.nodes().iter().zip(values);
    let mut inside = nodes.filter(|(_, value)| **value > 0.0).peekable();
    inside.peek()?;
    let mut extent = BoundingBox::around(inside.map(|(node, _)| node));
    if mesh.geometry() == Geometry::Axisymmetric {
        extent.lower.x = -extent.upper.x;
    }
    Some(extent)
}

impl Contour {
    /// The zero set of nodal values.
    pub fn new(mesh: &Mesh, values: &[f64]) -> Self {
        let mut contour = Self::default();
        contour.trace(mesh, values);
        contour
    }

    /// Replaces the contour by the zero set of nodal values.
    pub fn trace(&mut self, mesh: &Mesh, values: &[f64]) {
        self.segments.clear();
        let (mut area, mut volume) = (0.0, 0.0);
        for (triangle, triangle_area) in mesh.triangles().iter().zip(mesh.areas()) {
            let (part, segment) = cut(mesh, triangle, *triangle_area, values);
            area += part.area;
            volume += part.volume;
            self.segments.extend(segment);
        }
        self.area = area;
        self.volume = (mesh.geometry() == Geometry::Axisymmetric).then_some(volume);
    }

    /// Adds the other side of the axis of rotation, so that it is the contour of the full cross-section, in the plane.
    pub fn mirror(&mut self) {
        let other: Vec<Segment> = self.segments.iter().map(mirrored).collect();
        self.segments.extend(other);
        self.area *= 2.0;
        self.volume = None;
    }

    /// The contour of the cross-section of what a mesh stands for: by rotation with both sides of the axis.
    pub fn of_section(mesh: &Mesh, values: &[f64]) -> Self {
        let mut contour = Self::new(mesh, values);
        if mesh.geometry() == Geometry::Axisymmetric {
            contour.mirror();
        }
        contour
    }

    /// The length of the zero set.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|[a, b]| length(b - a)).sum()
    }

    /// 4π·area/length², at most 1 for a closed curve, or by rotation 36π·volume²/surface³, the square of the reduced volume, at most
    /// 1 for a closed surface; `None` where the zero set is empty.
    pub fn isoperimetric_quotient(&self) -> Option<f64> {
        let Some(volume) = self.volume else {
            let length = self.length();
            return (length > 0.0).then(|| 4.0 * PI * self.area / (length * length));
        };
        let surface = self.surface().filter(|surface| *surface > 0.0);
        surface.map(|surface| 36.0 * PI * volume * volume / surface.powi(3))
    }

    /// The reduced area 4π·area/length², or by rotation the reduced volume 6√π·volume/surface^(3/2); `None` where the zero set is
    /// empty.
    pub fn reduced_size(&self) -> Option<f64> {
        let quotient = self.isoperimetric_quotient()?;
        Some(match self.volume {
            None => quotient,
            Some(_) => quotient.sqrt(),
        })
    }

    /// By rotation the surface of the body φ > 0.
    pub fn surface(&self) -> Option<f64> {
        self.volume
            .map(|_| self.segments.iter().map(ring).sum::<f64>())
    }

    /// The heights at which the zero set meets the axis of rotation.
    pub fn poles(&self) -> Vec<f64> {
        let ends = self.segments.iter().flatten();
        ends.filter(|it| it.x < 1e-9).map(|it| it.y).collect()
    }

    /// The least distance from the zero set to the wall; `None` where the zero set is empty.
    pub fn wall_distance(&self, wall: &Wall) -> Option<f64> {
        let places = self.segments.iter().flatten();
        places
            .map(|place| wall.distance(*place))
            .min_by(f64::total_cmp)
    }
}

/// A part of a triangle: its area, and the volume 2π r̄ |T| of the body that it makes by rotation about x = 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Part {
    pub(super) area: f64,
    pub(super) volume: f64,
}

/// The part of a triangle where φ > 0, and the piece of φ = 0 in the triangle, with φ > 0 on its left.
pub(super) fn cut(
    mesh: &Mesh,
    triangle: &[u32; 3],
    triangle_area: f64,
    values: &[f64],
) -> (Part, Option<Segment>) {
    let part = |places: [Point; 3], area: f64| Part {
        area,
        volume: TAU / 3.0 * (places[0].x + places[1].x + places[2].x) * area,
    };
    let corner_values = triangle.map(|node| values[node as usize]);
    let inside = corner_values.map(|value| value > 0.0);
    let count = inside.iter().filter(|inside| **inside).count();
    if count == 0 || count == 3 {
        let places = triangle.map(|node| mesh.nodes()[node as usize]);
        let area = if count == 3 { triangle_area } else { 0.0 };
        return (part(places, area), None);
    }
    // The corner that is alone on its side, first.
    let alone = (0..3)
        .find(|&corner| inside[corner] == (count == 1))
        .unwrap_or(0);
    let order = [alone, (alone + 1) % 3, (alone + 2) % 3];
    let places = order.map(|corner| mesh.nodes()[triangle[corner] as usize]);
    let [first, second, third] = order.map(|corner| corner_values[corner]);
    let (to_second, to_third) = (first / (first - second), first / (first - third));
    let along = |other: usize, share: f64| places[0] + share * (places[other] - places[0]);
    let (near_second, near_third) = (along(1, to_second), along(2, to_third));
    let corner = part(
        [places[0], near_second, near_third],
        to_second * to_third * triangle_area,
    );
    if count == 1 {
        return (corner, Some([near_second, near_third]));
    }
    let whole = part(places, triangle_area);
    let rest = Part {
        area: whole.area - corner.area,
        volume: whole.volume - corner.volume,
    };
    (rest, Some([near_third, near_second]))
}

/// The mirror image of a segment at the axis x = 0, with φ > 0 on its left again.
pub(super) fn mirrored([from, to]: &Segment) -> Segment {
    [to, from].map(|place| Point::new(-place.x, place.y))
}

/// The surface that a segment makes by rotation about x = 0.
pub(super) fn ring([a, b]: &Segment) -> f64 {
    PI * (a.x + b.x) * length(b - a)
}

impl OutlineMeasure {
    /// Of a curve, along an axis, a unit vector, or along the one across it if the vesicle is longer that
    /// way; `None` where there is no segment.
    pub fn of(segments: impl Iterator<Item = Segment> + Clone, axis: Vector) -> Option<Self> {
        let along = Self::along(segments.clone(), axis)?;
        if along.width > along.length {
            Self::along(segments, Vector::new(-axis.y, axis.x))
        } else {
            Some(along)
        }
    }

    fn along(segments: impl Iterator<Item = Segment> + Clone, axis: Vector) -> Option<Self> {
        segments.clone().next()?;
        // In coordinates along the axis (x) and across it (y).
        let frame = frame(axis);
        let turned = |place: Point| frame.inverse_transform_point(&place);
        let hull = BoundingBox::around(segments.clone().flatten().map(turned));
        let middle = 0.5 * (hull.lower.x + hull.upper.x);
        let mut waist = [f64::INFINITY, f64::NEG_INFINITY];
        for [a, b] in segments {
            let (a, b) = (turned(a), turned(b));
            if (a.x <= middle) != (b.x <= middle) {
                let share = (middle - a.x) / (b.x - a.x);
                let across = a.y + share * (b.y - a.y);
                waist = [waist[0].min(across), waist[1].max(across)];
            }
        }
        Some(Self {
            length: hull.extent().x,
            waist: (waist[1] - waist[0]).max(0.0),
            width: hull.extent().y,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive inside the ellipse of half axes a (along x) and b about the centre of the square.
    fn ellipse(mesh: &Mesh, a: f64, b: f64) -> Vec<f64> {
        let value = |at: &Point| 1.0 - ((at.x - 0.5) / a).hypot((at.y - 0.5) / b);
        mesh.nodes().iter().map(value).collect()
    }

    #[test]
    fn a_circle_has_its_length_and_its_area() {
        let mesh = Mesh::structured(200, 0.0, 0).expect("a regular mesh");
        let contour = Contour::new(&mesh, &ellipse(&mesh, 0.25, 0.25));
        assert!((contour.length() / (0.5 * PI) - 1.0).abs() < 1e-4);
        assert!((contour.area / (PI / 16.0) - 1.0).abs() < 2e-4);
    }

    #[test]
    fn the_extent_of_the_inside_is_that_of_the_contour_to_an_edge() {
        let mesh = Mesh::structured(100, 0.0, 0).expect("a regular mesh");
        let extent = extent_of_inside(&mesh, &ellipse(&mesh, 0.2, 0.4)).expect("an inside");
        let exact = [[0.3, 0.1], [0.7, 0.9]].map(Point::from);
        assert!((extent.lower - exact[0]).amax() <= 0.0101, "{extent:?}");
        assert!((extent.upper - exact[1]).amax() <= 0.0101, "{extent:?}");
        let nowhere = vec![f64::NAN; mesh.nodes().len()];
        assert_eq!(extent_of_inside(&mesh, &nowhere), None);
    }

    #[test]
    fn the_inside_lies_on_the_left() {
        let mesh = Mesh::structured(30, 0.2, 2).expect("a fair mesh");
        let contour = Contour::new(&mesh, &ellipse(&mesh, 0.3, 0.2));
        // Green's theorem: ½ ∮ (x dy − y dx) is the area when the inside lies on the left.
        let enclosed: f64 = contour
            .segments
            .iter()
            .map(|[a, b]| 0.5 * a.coords.perp(&b.coords))
            .sum();
        assert!(
            (enclosed - contour.area).abs() < 1e-13,
            "{enclosed} {}",
            contour.area
        );
    }

    #[test]
    fn an_ellipse_is_measured_along_its_longer_axis() {
        let mesh = Mesh::structured(100, 0.0, 0).expect("a regular mesh");
        for half_axes in [[0.2, 0.4], [0.4, 0.2]] {
            let [a, b] = half_axes;
            let contour = Contour::new(&mesh, &ellipse(&mesh, a, b));
            for axis in [Vector::y(), Vector::x()] {
                let segments = contour.segments.iter().copied();
                let measure = OutlineMeasure::of(segments, axis).expect("an outline");
                for (value, exact) in [
                    (measure.length, 0.8),
                    (measure.waist, 0.4),
                    (measure.width, 0.4),
                ] {
                    assert!((value - exact).abs() < 1e-3, "{measure:?}");
                }
            }
        }
        assert_eq!(OutlineMeasure::of(std::iter::empty(), Vector::x()), None);
    }

    /// A sphere, and a spheroid of half axes 0.3 and 0.3 about the axis, 0.15 along it: V = 4π/3·a²c.
    #[test]
    fn a_body_of_rotation_has_its_reduced_volume_and_both_sides() {
        let mesh = Mesh::structured(80, 0.0, 0).expect("a regular mesh");
        let mesh = mesh.in_geometry(Geometry::Axisymmetric);
        let values = |a: f64, c: f64| -> Vec<f64> {
            let value = |at: &Point| 1.0 - (at.x / a).hypot((at.y - 0.5) / c);
            mesh.nodes().iter().map(value).collect()
        };
        let sphere = Contour::new(&mesh, &values(0.3, 0.3));
        let quotient = sphere.isoperimetric_quotient().expect("a vesicle");
        assert!((quotient - 1.0).abs() < 1e-3, "{quotient}");
        let oblate = Contour::new(&mesh, &values(0.3, 0.15));
        let volume = oblate.volume.expect("a body");
        let exact = 4.0 * PI / 3.0 * 0.3 * 0.3 * 0.15;
        assert!((volume / exact - 1.0).abs() < 2e-3, "{volume}");
        // The surface of an oblate spheroid of eccentricity e: 2πa²(1 + (1 − e²)/e·artanh e).
        let e = 0.75_f64.sqrt();
        let surface = 2.0 * PI * 0.09 * (1.0 + 0.25 / e * e.atanh());
        let reduced = 36.0 * PI * exact * exact / surface.powi(3);
        let quotient = oblate.isoperimetric_quotient().expect("a vesicle");
        assert!((quotient / reduced - 1.0).abs() < 3e-3, "{quotient}");
        let section = Contour::of_section(&mesh, &values(0.3, 0.15));
        let segments = section.segments.iter().copied();
        let size = OutlineMeasure::of(segments, Vector::y()).expect("a vesicle");
        assert!((size.length - 0.6).abs() < 1e-3 && (size.waist - 0.3).abs() < 1e-3);
        assert_eq!(section.segments.len(), 2 * oblate.segments.len());
        // φ > 0 is on the left of both sides: twice the area by the sum over the segments.
        let crosses = section
            .segments
            .iter()
            .map(|[a, b]| a.coords.perp(&b.coords));
        assert!((0.5 * crosses.sum::<f64>() / section.area - 1.0).abs() < 1e-12);
    }
}
