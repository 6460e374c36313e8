//! Whether there is a vesicle in the domain at all.

use std::fmt;

use thiserror::Error;

use super::SimulationError;
use crate::fem::{Mesh, Wall, is_in_hole};
use crate::geometry::{BoundingBox, Point, doubled_area};
use crate::scene::{self, OutlineDistance, Scene, Shape, significant, union_distance};

/// Cells of the grid that stands for a generated mesh where that need not be made.
const CELLS: usize = 128;

/// Why there is no vesicle to simulate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoVesicle {
    /// An outline has no part in the domain.
    #[error(
        "{which} lies outside of the domain, which reaches from {} to {}: move it into the domain \
         (center), or make it larger",
        Coordinates(*lower),
        Coordinates(*upper)
    )]
    Outside {
        /// Which vesicle.
        which: Part,
        /// The least coordinates of the domain.
        lower: Point,
        /// The greatest ones.
        upper: Point,
    },
    /// An outline lies where there are no triangles, though not beyond all of them.
    #[error(
        "{which} lies {}, about {}, where the mesh has no triangles: move it into the domain (center)",
        if *is_hole { "in a hole of the domain" } else { "beside the domain" },
        Coordinates(*center)
    )]
    Gap {
        /// Which vesicle.
        which: Part,
        /// The center of its outline.
        center: Point,
        /// Whether the domain is all around it.
        is_hole: bool,
    },
    /// The domain is within the outline.
    #[error(
        "no vesicle in the domain: the outline is around all of it, from {} to {}, so there is no membrane; \
         make it smaller",
        Coordinates(*lower),
        Coordinates(*upper)
    )]
    Covers {
        /// The least coordinates of the domain.
        lower: Point,
        /// The greatest ones.
        upper: Point,
    },
    /// The outline is between the nodes.
    #[error(
        "no vesicle in the domain: the outline is so small that φ is positive at no node of the mesh; \
         make it larger, or the mesh finer"
    )]
    BetweenNodes,
    /// φ⁰ changes its sign nowhere, though the outline is in the domain.
    #[error(
        "no vesicle in the domain: the initial φ is between {} and {}, so it changes its sign nowhere; \
         look at membrane.interface_width (small against the vesicle?), vesicle.scale and domain.boundary",
        significant(*least, 3),
        significant(*greatest, 3)
    )]
    NoSign {
        /// The least value of φ⁰.
        least: f64,
        /// The greatest one.
        greatest: f64,
    },
}

/// A vesicle of a scene, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// There is only one.
    Only,
    /// The one of this number, from 1, among `vesicle.parts`.
    Number(usize),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Only => f.write_str("no vesicle in the domain: the whole outline"),
            Self::Number(number) => write!(f, "part {number} of vesicle.parts"),
        }
    }
}

/// A point in words.
struct Coordinates(Point);

impl fmt::Display for Coordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = [self.0.x, self.0.y].map(|coordinate| significant(coordinate, 3));
        write!(f, "({x}, {y})")
    }
}

/// Refuses a scene whose membrane is not in the domain, by its outlines. Of those that are generated
/// the mesh is not made.
///
/// # Errors
/// `Outside`, `Gap`, `Covers`, or the mesh cannot be made.
pub fn check_outlines(scene: &Scene) -> Result<(), SimulationError> {
    let mesh = match &scene.mesh {
        scene::Mesh::File(file) => Mesh::from_triangulation(&file.triangulation)?,
        _ => Mesh::structured(CELLS, 0.0, 0)?,
    };
    Ok(outlines_in(scene, &mesh)?)
}

/// Refuses a scene whose membrane is not in the domain, by its outlines and by φ⁰. Where φ⁰ is random
/// or from a file, that may be meant.
pub(super) fn check_vesicle(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> Result<(), NoVesicle> {
    let Shape::Outlines(outlines) = &scene.vesicle.shape else {
        return Ok(());
    };
    outlines_in(scene, mesh)?;
    if sign(phi).is_none() {
        return Ok(());
    }
    let outlines: Vec<_> = outlines.iter().map(OutlineDistance::new).collect();
    if !is_at_node(mesh, &outlines) {
        return Err(NoVesicle::BetweenNodes);
    }
    Err(NoVesicle::NoSign {
        least: phi.iter().copied().fold(f64::INFINITY, f64::min),
        greatest: phi.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// Whether φ is positive everywhere, or nowhere; `None` where it is so here and there.
pub(super) fn sign(phi: &[f64]) -> Option<bool> {
    let inside = phi.iter().filter(|value| **value > 0.0).count();
    match inside {
        0 => Some(false),
        all if all == phi.len() => Some(true),
        _ => None,
    }
}

/// Each outline must reach into the domain, and their union must not be all of it.
fn outlines_in(scene: &Scene, mesh: &Mesh) -> Result<(), NoVesicle> {
    let Shape::Outlines(outlines) = &scene.vesicle.shape else {
        return Ok(());
    };
    let distances: Vec<_> = outlines.iter().map(OutlineDistance::new).collect();
    let BoundingBox { lower, upper } = BoundingBox::around(mesh.nodes());
    let wall = Wall::of(mesh);
    for (number, (outline, distance)) in outlines.iter().zip(&distances).enumerate() {
        let one = std::slice::from_ref(distance);
        let reaches = is_at_node(mesh, one)
            || wall.clearance(|place| distance.signed_distance(place).value) < 0.0
            || covers(mesh, outline.center.into());
        if !reaches {
            let which = match outlines.len() {
                1 => Part::Only,
                _ => Part::Number(number + 1),
            };
            let center = Point::from(outline.center);
            let is_within = (0..2).all(|axis| (lower[axis]..=upper[axis]).contains(&center[axis]));
            return Err(if is_within {
                let is_hole = is_in_hole(mesh, center);
                NoVesicle::Gap {
                    which,
                    center,
                    is_hole,
                }
            } else {
                NoVesicle::Outside {
                    which,
                    lower,
                    upper,
                }
            });
        }
    }
    let is_inside = |place: &Point| union_distance(&distances, *place).value > 0.0;
    if mesh.nodes().iter().all(is_inside) {
        return Err(NoVesicle::Covers { lower, upper });
    }
    Ok(())
}

/// Whether a node lies within the outlines.
fn is_at_node(mesh: &Mesh, outlines: &[OutlineDistance]) -> bool {
    let is_inside = |place: &Point| union_distance(outlines, *place).value > 0.0;
    mesh.nodes().iter().any(is_inside)
}

/// Whether a place lies in a triangle.
fn covers(mesh: &Mesh, place: Point) -> bool {
    mesh.triangles().iter().any(|corners| {
        let corners = corners.map(|node| mesh.nodes()[node as usize]);
        (0..3)
            .all(|corner| doubled_area([corners[corner], corners[(corner + 1) % 3], place]) >= 0.0)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::tests::small;
    use super::super::{EventKind, Simulation, VesicleChange, examine};
    use super::*;
    use crate::scene::{NodalValues, Warning};

    #[test]
    fn a_scene_without_a_vesicle_in_the_domain_is_refused() {
        let outside = "vesicle={ shape = 'circle', radius = 0.1, center = [1.2, 0.5] }";
        let around = "vesicle={ shape = 'circle', radius = 0.9 }";
        let one_outside = "vesicle.parts=[{ shape = 'circle', radius = 0.2 }, \
                           { shape = 'circle', radius = 0.1, center = [0.5, -0.15] }]";
        let tiny = "vesicle={ shape = 'circle', radius = 1e-3, center = [0.54, 0.54] }";
        let clamped = "domain.boundary=clamped";
        let delaunay = "mesh={ kind = 'delaunay', size = 0.1 }";
        for (settings, words) in [
            (
                &[outside][..],
                "the whole outline lies outside of the domain, which reaches from (0, 0) to (1.00, 1.00)",
            ),
            (&[outside, clamped], "lies outside of the domain"),
            (&[outside, delaunay], "lies outside of the domain"),
            (
                &[one_outside],
                "part 2 of vesicle.parts lies outside of the domain",
            ),
            (&[around], "the outline is around all of it"),
            (&[around, clamped], "the outline is around all of it"),
            (
                &[around, clamped, "vesicle.projection=nodal"],
                "the outline is around all of it",
            ),
            (&[tiny], "φ is positive at no node of the mesh"),
            (&["vesicle.scale=0"], "the initial φ is between 0 and 0"),
        ] {
            let scene = small(settings);
            let error = Simulation::new(&scene).expect_err(words);
            assert!(matches!(error, SimulationError::NoVesicle(_)), "{error}");
            assert!(error.to_string().contains(words), "{settings:?}: {error}");
            assert_eq!(examine(&scene), Err(error.clone()));
            // What can be known without the mesh is known without it.
            let by_outline = matches!(
                error,
                SimulationError::NoVesicle(NoVesicle::Outside { .. } | NoVesicle::Covers { .. })
            );
            assert_eq!(check_outlines(&scene).is_err(), by_outline, "{settings:?}");
        }
        for across in [
            "vesicle={ shape = 'circle', radius = 0.1, center = [1.05, 0.5] }",
            "vesicle={ shape = 'circle', radius = 0.6 }",
            "vesicle.scale=-1",
        ] {
            Simulation::new(&small(&[across])).expect(across);
        }
    }

    /// A ring: what is in its hole is within its outermost points.
    #[test]
    fn a_vesicle_in_a_hole_of_the_domain_is_refused_with_these_words() {
        let corner = |corner: u32, radius: f64| {
            let angle = f64::from(corner) * std::f64::consts::TAU / 12.0;
            Point::new(radius * angle.cos(), radius * angle.sin())
        };
        let inner = (0..12).map(|n| corner(n, 0.5));
        let nodes = inner.chain((0..12).map(|n| corner(n, 1.0))).collect();
        let triangles = (0..12).flat_map(|n| {
            let next = (n + 1) % 12;
            [[n, 12 + n, 12 + next], [n, 12 + next, next]]
        });
        let triangulation = Arc::new(scene::Triangulation {
            nodes,
            triangles: triangles.collect(),
            ..scene::Triangulation::default()
        });
        for (center, words) in [
            (
                "[0.1, 0]",
                "no vesicle in the domain: the whole outline lies in a hole of the domain, about (0.100, 0), \
                 where the mesh has no triangles",
            ),
            (
                "[0.95, 0.95]",
                "lies beside the domain, about (0.950, 0.950)",
            ),
            ("[3, 0]", "lies outside of the domain, which reaches from"),
        ] {
            let vesicle =
                format!("vesicle={{ shape = 'circle', radius = 0.1, center = {center} }}");
            let mut scene = small(&[&vesicle]);
            scene.mesh = scene::Mesh::File(scene::MeshFile {
                path: "ring.msh".to_owned(),
                triangulation: Arc::clone(&triangulation),
            });
            let error = check_outlines(&scene).expect_err(words);
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(Simulation::new(&scene).expect_err(words), error);
        }
    }

    #[test]
    fn phi_of_one_sign_from_a_file_is_meant_but_reported() {
        let mut scene = small(&[]);
        for (value, words) in [
            (1.0, "positive everywhere"),
            (-1.0, "negative or 0 everywhere"),
        ] {
            scene.vesicle.shape = Shape::File(NodalValues {
                path: "phi.txt".to_owned(),
                values: Arc::from([value; 13 * 13]),
                columns: 1,
            });
            let warnings = Simulation::new(&scene)
                .expect("allowed")
                .warnings()
                .to_vec();
            let inside = value > 0.0;
            let warning = Warning::NoMembrane { inside };
            assert!(warnings.contains(&warning), "{warnings:?}");
            assert!(warning.to_string().contains(words), "{warning}");
        }
    }

    #[test]
    fn the_longer_size_is_the_length_whatever_the_angle() {
        for half_axes in ["[0.3, 0.2]", "[0.2, 0.3]"] {
            for angle in ["0", "30", "90", "135", "360000090"] {
                let vesicle = format!(
                    "vesicle={{ shape = 'ellipse', half_axes = {half_axes}, angle = {angle} }}"
                );
                let scene = small(&[&vesicle, "mesh.cells=40", "membrane.interface_width=0.03"]);
                let simulation = Simulation::new(&scene).expect("an ellipse");
                let outline = simulation.report().outline().expect("one vesicle");
                let sizes = [
                    outline.length / 0.6,
                    outline.width / 0.4,
                    outline.waist / 0.4,
                ];
                assert!(
                    sizes.iter().all(|size| (size - 1.0).abs() < 0.02),
                    "{vesicle}: {outline:?}"
                );
            }
        }
    }

    /// Two circles, with these centers in x.
    fn two([left, right]: [f64; 2]) -> Simulation {
        let parts = format!(
            "vesicle.parts=[{{ shape = 'circle', radius = 0.15, center = [{left}, 0.5] }}, \
             {{ shape = 'circle', radius = 0.15, center = [{right}, 0.5] }}]"
        );
        let scene = small(&[&parts, "mesh.cells=24", "membrane.interface_width=0.03"]);
        Simulation::new(&scene).expect("two circles")
    }

    #[test]
    fn vesicles_that_merge_or_split_are_an_event() {
        let (apart, merged) = ([0.25, 0.75], [0.4, 0.6]);
        let mut run = two(apart);
        // On the same mesh another state follows.
        let mut next = |centers| {
            run.scheme = two(centers).scheme;
            run.look();
            run.drain_events().into_iter().map(|event| event.kind)
        };
        let changed = |change, counts| Some(EventKind::VesiclesChanged { change, counts });
        assert_eq!(next(apart).next(), None);
        assert_eq!(next(merged).next(), changed(VesicleChange::Merged, [2, 1]));
        assert_eq!(next(merged).next(), None);
        assert_eq!(next(apart).next(), changed(VesicleChange::Split, [1, 2]));
    }

    #[test]
    fn each_of_two_vesicles_has_its_size_until_they_are_one() {
        let pair = |centers| two(centers).report().clone();
        let apart = pair([0.25, 0.75]);
        assert_eq!(apart.vesicles.len(), 2);
        assert_eq!(apart.outline(), None);
        for vesicle in &apart.vesicles {
            let outline = vesicle.outline.expect("a membrane");
            assert!((outline.length - 0.3).abs() < 0.01, "{outline:?}");
            let reduced = vesicle.reduced_size().expect("away from the wall");
            assert!((reduced - 1.0).abs() < 0.01, "{reduced}");
        }
        // Side by side in x, and longer that way.
        let merged = pair([0.4, 0.6]);
        let outline = merged.outline().expect("one vesicle");
        assert!((outline.length - 0.5).abs() < 0.02, "{outline:?}");
        assert!((outline.width - 0.3).abs() < 0.02, "{outline:?}");
        let reduced = merged.vesicles[0].reduced_size();
        assert!(reduced.is_some_and(|value| value < 0.95), "{reduced:?}");
    }
}
