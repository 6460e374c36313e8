//! P1 functions at the points of a lattice, exactly.

use super::Zoom;
use crate::fem::{Mesh, extent_of_inside};
use crate::geometry::{BoundingBox, crop};
use crate::scheme::State;
use crate::simulation::outline_beside;
use crate::theory::ShapeAtRest;

/// Points within this of a triangle's edge, in barycentric coordinates, count as inside: no point
/// may fall between two triangles by rounding.
const SLACK: f64 = 1e-9;

/// The greatest width of a picture around a vesicle over its height: its y axis and the colour bar need the height of two
/// numbers.
const GREATEST_ASPECT: f64 = 2.5;

/// The rectangle in the plane that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    /// Its lower left corner.
    pub corner: [f64; 2],
    /// Its width and its height.
    pub sides: [f64; 2],
}

impl Frame {
    /// A part of the plane.
    pub fn of(region: &BoundingBox) -> Self {
        Self {
            corner: region.lower.into(),
            sides: region.extent().into(),
        }
    }

    /// The part of a domain that shows some states, each with its shape at rest if that is drawn: the vesicle with its
    /// margin, widened if its aspect (width by height) is less than `least_aspect`, made higher if the picture were too
    /// low for its numbers; for a domain as a whole a square about it.
    pub fn around<'a>(
        domain: &BoundingBox,
        states: impl IntoIterator<Item = (&'a Mesh, &'a State, Option<&'a ShapeAtRest>)>,
        zoom: Zoom,
        least_aspect: f64,
    ) -> Self {
        let extents = states.into_iter().filter_map(|(mesh, state, theory)| {
            let inside = extent_of_inside(mesh, &state.phi)?;
            let outline = theory.map(|shape| outline_beside(shape, mesh, &state.phi));
            Some(inside.union(&BoundingBox::around(outline.into_iter().flatten())))
        });
        let vesicle = extents.reduce(|one, other| one.union(&other));
        let Some(vesicle) = vesicle.filter(|_| zoom != Zoom::Domain) else {
            return Self::square(domain);
        };
        let own = Self::of(&crop(domain, &vesicle)).aspect();
        let aspect = own.max(least_aspect).min(GREATEST_ASPECT);
        Self::of(&zoom.region(domain, Some(&vesicle), aspect))
    }

    /// The smallest square that has a domain in its middle.
    pub fn square(domain: &BoundingBox) -> Self {
        let side = domain.extent().max();
        let corner = [0, 1].map(|axis| {
            let room = side - domain.extent()[axis];
            domain.lower[axis] - 0.5 * room
        });
        Self {
            corner,
            sides: [side; 2],
        }
    }

    /// Its width by its height.
    pub fn aspect(&self) -> f64 {
        self.sides[0] / self.sides[1]
    }

    /// Where a place is in the frame, from 0 to 1 in both directions.
    pub fn share(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (place[axis] - self.corner[axis]) / self.sides[axis])
    }
}

/// Gives `put` the values of P1 functions at the centres of `columns` × `rows` equal cells of the frame, each
/// with the cell's number, row by row from above: none where the mesh has no triangle, and twice where two
/// meet.
pub(super) fn sample_each<const N: usize>(
    (mesh, frame): (&Mesh, Frame),
    fields: [&[f64]; N],
    [columns, rows]: [usize; 2],
    mut put: impl FnMut(usize, [f64; N]),
) {
    let center = |cell: usize, cells: usize| (cell as f64 + 0.5) / cells as f64;
    for (corners, gradients) in mesh.triangles().iter().zip(mesh.gradients()) {
        let places = corners.map(|node| mesh.nodes()[node as usize]);
        let nodal = corners.map(|node| fields.map(|field| field[node as usize]));
        let shares = places.map(|place| frame.share(place.into()));
        let across = cells_between(shares.map(|[x, _]| x), columns);
        let up = cells_between(shares.map(|[_, y]| y), rows);
        for from_below in up {
            let y = frame.corner[1] + frame.sides[1] * center(from_below, rows);
            let row = rows - 1 - from_below;
            for column in across.clone() {
                let x = frame.corner[0] + frame.sides[0] * center(column, columns);
                // ψ_a(x) = 1 + ∇ψ_a·(x − x_a).
                let shares = [0, 1, 2].map(|a: usize| {
                    let ([gx, gy], [px, py]): ([f64; 2], [f64; 2]) =
                        (gradients[a].into(), places[a].into());
                    1.0 + gx * (x - px) + gy * (y - py)
                });
                if shares.iter().any(|share| *share < -SLACK) {
                    continue;
                }
                let value = |field: usize| (0..3).map(|a| shares[a] * nodal[a][field]).sum();
                put(row * columns + column, std::array::from_fn(value));
            }
        }
    }
}

/// Those values, NaN where the mesh has no triangle.
pub(super) fn sample<const N: usize>(
    place: (&Mesh, Frame),
    fields: [&[f64]; N],
    [columns, rows]: [usize; 2],
) -> Vec<[f64; N]> {
    let mut values = vec![[f64::NAN; N]; columns * rows];
    sample_each(place, fields, [columns, rows], |cell, sampled| {
        values[cell] = sampled
    });
    values
}

/// The cells whose centres lie between the least and the greatest of three coordinates.
fn cells_between(coordinates: [f64; 3], cells: usize) -> std::ops::Range<usize> {
    let least = coordinates.into_iter().fold(f64::INFINITY, f64::min);
    let greatest = coordinates.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let scale = cells as f64;
    // A cast from f64 saturates: what lies outside of the square is cut off.
    let first = (least * scale - 0.5 - SLACK * scale).ceil().max(0.0) as usize;
    let last = (greatest * scale - 0.5 + SLACK * scale).floor();
    let end = if last < 0.0 { 0 } else { last as usize + 1 };
    first..end.min(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(mesh: &Mesh) -> (&Mesh, Frame) {
        (mesh, Frame::square(&mesh.bounding_box()))
    }

    /// A thin vesicle, and the circle of a larger area.
    #[test]
    fn a_frame_holds_the_shape_at_rest_too() {
        use crate::theory::CurveAtRest;
        let mesh = Mesh::structured(40, 0.0, 0).expect("a fair mesh");
        let inside =
            |at: &crate::geometry::Point| 0.1 - (at.x - 0.5).abs().max(0.3 * (at.y - 0.5).abs());
        let phi: Vec<f64> = mesh.nodes().iter().map(inside).collect();
        let zeros = vec![0.0; phi.len()];
        let state = State {
            phi,
            omega: zeros.clone(),
            mu: zeros,
            director: None,
        };
        let circle = CurveAtRest::new(0.2, None).map(ShapeAtRest::Curve);
        let circle = circle.expect("a circle");
        let domain = mesh.bounding_box();
        let frame = |theory| Frame::around(&domain, [(&mesh, &state, theory)], Zoom::Fit, 0.1);
        let [without, with] = [None, Some(&circle)].map(|theory| frame(theory).sides[0]);
        let diameter = 2.0 * (0.2 / std::f64::consts::PI).sqrt();
        assert!(
            without < 0.4 && with > diameter,
            "{without} {with} {diameter}"
        );
    }

    #[test]
    fn an_affine_function_is_exact_everywhere() {
        for jitter in [0.0, 0.2] {
            let mesh = Mesh::structured(7, jitter, 3).expect("a fair mesh");
            let affine = |x: f64, y: f64| 2.0 * x - 3.0 * y + 0.25;
            let values: Vec<f64> = mesh.nodes().iter().map(|p| affine(p.x, p.y)).collect();
            let ones = vec![1.0; values.len()];
            let (columns, rows) = (31, 14);
            let sampled = sample(whole(&mesh), [&values, &ones], [columns, rows]);
            for (cell, [value, one]) in sampled.into_iter().enumerate() {
                let x = (f64::from((cell % columns) as u32) + 0.5) / columns as f64;
                let y = 1.0 - (f64::from((cell / columns) as u32) + 0.5) / rows as f64;
                assert!((value - affine(x, y)).abs() < 1e-12, "({x}, {y})");
                assert!((one - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_frame_is_cropped_to_a_vesicle_in_both_directions() {
        let mesh = Mesh::structured(40, 0.0, 0).expect("a fair mesh");
        let domain = mesh.bounding_box();
        let frame = |[half_width, half_height]: [f64; 2]| {
            let inside = |at: &crate::geometry::Point| {
                let [x, y] = [(at.x - 0.5) / half_width, (at.y - 0.5) / half_height];
                1.0 - x.hypot(y)
            };
            let phi: Vec<f64> = mesh.nodes().iter().map(inside).collect();
            let zeros = vec![0.0; phi.len()];
            let state = State {
                phi,
                omega: zeros.clone(),
                mu: zeros,
                director: None,
            };
            Frame::around(&domain, [(&mesh, &state, None)], Zoom::Fit, 0.6)
        };
        let wide = frame([0.4, 0.2]);
        assert!(wide.sides[0] < 1.0 && wide.sides[1] < 0.6, "{wide:?}");
        // A high one is in a picture that is not too high, a flat one in a picture that is not too low.
        for (half_axes, aspect) in [([0.1, 0.4], 0.6), ([0.4, 0.06], GREATEST_ASPECT)] {
            let frame = frame(half_axes);
            assert!((frame.aspect() - aspect).abs() < 1e-12, "{frame:?}");
        }
    }

    #[test]
    fn the_frame_is_a_square_about_the_domain() {
        let unit = Mesh::structured(4, 0.2, 1).expect("a fair mesh");
        let corner = [0.0, 0.0];
        let sides = [1.0; 2];
        assert_eq!(whole(&unit).1, Frame { corner, sides });
        // A triangle, twice as wide as high.
        let nodes = [[-3.0, 1.0], [1.0, 1.0], [1.0, 3.0]].map(Into::into);
        let wide = Mesh::new(nodes.to_vec(), vec![[0, 1, 2]]).expect("counter-clockwise");
        let frame = whole(&wide).1;
        assert_eq!((frame.corner, frame.sides), ([-3.0, 0.0], [4.0; 2]));
        let x = [-3.0, 1.0, 1.0];
        let sampled = sample(whole(&wide), [&x], [4, 4]);
        let row = |row: usize| {
            sampled[4 * row..][..4]
                .iter()
                .map(|[x]| *x)
                .collect::<Vec<_>>()
        };
        assert!(row(0).iter().chain(&row(3)).all(|x| x.is_nan()));
        assert!((row(1)[3] - 0.5).abs() < 1e-12 && row(1)[1].is_nan());
        assert!((row(2)[1] + 1.5).abs() < 1e-12 && row(2)[0].is_nan());
    }

    #[test]
    fn the_points_of_the_mesh_itself_are_covered() {
        // Centres that fall on nodes and edges.
        let mesh = Mesh::structured(8, 0.0, 1).expect("a fair mesh");
        let ones = vec![1.0; mesh.nodes().len()];
        for cells in [1, 4, 8, 16, 24, 100] {
            let sampled = sample(whole(&mesh), [&ones], [cells; 2]);
            assert!(sampled.iter().all(|[one]| (one - 1.0).abs() < 1e-12));
        }
    }
}
