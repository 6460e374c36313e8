//! What a scene's numbers alone do not say: the vesicle's place, and whether β can be reached.

use super::presence::sign;
use crate::fem::{Contour, Mesh, MeshQuality, SLIVER, Wall};
use crate::geometry::{Segment, length};
use crate::scene::{
    self, Geometry, OutlineDistance, Scene, Shape, Warning, isoperimetric_power, union_distance,
    wall_distance,
};

/// The interface of a vesicle reaches this many ε beyond φ = 0: tanh(2√2) = 0.993.
const INTERFACE_REACH: f64 = 4.0;

/// All that is allowed in a scene but probably not meant, given φ⁰.
pub fn warnings(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> Vec<Warning> {
    let contour = Contour::new(mesh, phi);
    let mut warnings = scene::warnings(scene, edge_at_membrane(mesh, phi, &contour));
    warnings.extend(slivers(scene, &MeshQuality::of(mesh)));
    let interface_width = scene.membrane.interface_width;
    warnings.extend(sign(phi).map(|inside| Warning::NoMembrane { inside }));
    let distance = match &scene.vesicle.shape {
        Shape::Outlines(outlines) => {
            let outlines: Vec<OutlineDistance> =
                outlines.iter().map(OutlineDistance::new).collect();
            Some(match scene.mesh {
                scene::Mesh::File(_) => {
                    Wall::of(mesh).clearance(|place| union_distance(&outlines, place).value)
                }
                _ => wall_distance(&outlines, scene.geometry),
            })
        }
        _ => contour.wall_distance(&Wall::of(mesh)),
    };
    if let Some(distance) =
        distance.filter(|distance| *distance < INTERFACE_REACH * interface_width)
    {
        warnings.push(Warning::VesicleAtWall {
            distance,
            interface_width,
        });
    }
    if let Some(area) = &scene.area {
        let quotient = match &scene.vesicle.shape {
            Shape::Outlines(outlines)
                if outlines.len() == 1 && scene.geometry == Geometry::Planar =>
            {
                Some(OutlineDistance::new(&outlines[0]).isoperimetric_quotient())
            }
            Shape::Random { .. } => None,
            _ => contour.isoperimetric_quotient(),
        };
        let geometry = scene.geometry;
        let reached = area.target.powi(isoperimetric_power(geometry));
        warnings.extend(quotient.filter(|least| reached < *least).map(|quotient| {
            Warning::TargetOutOfReach {
                target: area.target,
                quotient,
                geometry,
            }
        }));
    }
    warnings
}

/// The warning of triangles that are nearly flat.
fn slivers(scene: &Scene, quality: &MeshQuality) -> Option<Warning> {
    (quality.slivers > 0).then_some(Warning::Slivers {
        count: quality.slivers,
        below: SLIVER,
        at: quality.worst.at,
        angles: quality.worst.angles,
        is_jittered: !matches!(scene.mesh, scene::Mesh::File(_)),
    })
}

/// The mean length of an edge of the triangles that φ = 0 crosses, where each triangle counts by the
/// length of φ = 0 in it: many small ones do not outvote a few large ones. `None` where there are none.
fn edge_at_membrane(mesh: &Mesh, phi: &[f64], contour: &Contour) -> Option<f64> {
    let length = |[from, to]: Segment| length(to - from);
    let crossed = mesh.triangles().iter().filter(|corners| {
        let inside = corners.map(|node| phi[node as usize] > 0.0);
        inside.contains(&true) && inside.contains(&false)
    });
    // The contour has a segment for each of them, in their order.
    let parts = crossed.zip(&contour.segments).map(|(corners, segment)| {
        let [a, b, c] = corners.map(|node| mesh.nodes()[node as usize]);
        let edge = [[a, b], [b, c], [c, a]].map(length).iter().sum::<f64>() / 3.0;
        [edge, length(*segment)]
    });
    let [sum, membrane] = parts.fold([0.0; 2], |[sum, membrane], [edge, part]| {
        [sum + edge * part, membrane + part]
    });
    (membrane > 0.0).then(|| sum / membrane)
}

/// The nodes within ε of the wall, and whether the vesicle has been seen there.
#[derive(Debug)]
pub(super) struct NearWall {
    nodes: Vec<u32>,
    reached: bool,
}

impl NearWall {
    pub(super) fn new(mesh: &Mesh, interface_width: f64) -> Self {
        Self {
            nodes: Wall::of(mesh).nodes_within(mesh, interface_width),
            reached: false,
        }
    }

    /// Whether φ > 0 near the wall for the first time.
    pub(super) fn is_reached(&mut self, phi: &[f64]) -> bool {
        let now = !self.reached && self.nodes.iter().any(|node| phi[*node as usize] > 0.0);
        self.reached |= now;
        now
    }

    /// The nodes within ε of the wall.
    pub(super) fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Whether the vesicle has been seen there.
    pub(super) fn reached(&self) -> bool {
        self.reached
    }

    /// For a run that continues another.
    pub(super) fn set_reached(&mut self, reached: bool) {
        self.reached = reached;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::{Simulation, tests::small};
    use super::*;

    /// A prolate spheroid whose surface is to shrink: down to that of the sphere, which has the volume 4π/3·a²c.
    #[test]
    fn a_target_below_the_sphere_is_warned_of_by_rotation() {
        let (a, c): (f64, f64) = (0.15, 0.3);
        let eccentricity = (1.0 - (a / c).powi(2)).sqrt();
        let surface = 2.0 * PI * a * (a + c / eccentricity * eccentricity.asin());
        let least = 4.0 * PI * (a * a * c).powf(2.0 / 3.0) / surface;
        let warned = |target: f64| {
            let scene = small(&[
                "domain.geometry=axisymmetric",
                "nematic.initial=[0, 1]",
                "mesh.cells=60",
                "membrane.interface_width=0.05",
                "vesicle={ shape = 'ellipse', half_axes = [0.15, 0.3], center = [0, 0.5] }",
                &format!("area.target={target}"),
            ]);
            let simulation = Simulation::new(&scene).expect("a small scene");
            let warnings = simulation.warnings().iter();
            let mut warnings = warnings.map(ToString::to_string);
            warnings.find(|it| it.contains("never reach its target"))
        };
        assert!(least < 0.95, "{least}");
        let text = warned(least - 0.003).expect("it is out of reach");
        assert!(text.contains("36π·volume²/surface³"), "{text}");
        assert_eq!(warned(least + 0.003), None);
        assert_eq!(warned(1.0), None);
    }

    #[test]
    fn triangles_that_are_nearly_flat_are_warned_of() {
        let scene = small(&[]);
        let regular = Mesh::structured(6, 0.0, 0).expect("a regular mesh");
        let slivers = |mesh: &Mesh| -> Vec<Warning> {
            let phi: Vec<f64> = mesh.nodes().iter().map(|at| at[0] - 0.4).collect();
            let mut warnings = warnings(&scene, mesh, &phi);
            warnings.retain(|warning| matches!(warning, Warning::Slivers { .. }));
            warnings
        };
        assert_eq!(slivers(&regular), []);
        // The node in the middle, nearly on the one below it: of the six triangles about it two become flat.
        let mut nodes = regular.nodes().to_vec();
        nodes[3 * 7 + 3] = [0.5, 2.0 / 6.0 + 1e-6].into();
        let mesh = Mesh::new(nodes, regular.triangles().to_vec()).expect("a mesh");
        let [Warning::Slivers { count: 2, at, .. }] = slivers(&mesh)[..] else {
            panic!("{:?}", slivers(&mesh));
        };
        assert!(
            (at[0] - 0.5).abs() < 0.1 && (at[1] - 0.36).abs() < 0.06,
            "{at:?}"
        );
    }
}
