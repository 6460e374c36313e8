//! What a scene's numbers alone do not tell: the vesicle's place, and whether β can be reached.

use crate::fem::{Contour, Mesh, Wall};
use crate::scene::{
    self, OutlineDistance, Scene, Shape, Warning, thin_interface, union_distance, wall_distance,
};

/// The interface of a vesicle reaches this many ε beyond φ = 0: tanh(2√2) = 0.993.
const INTERFACE_REACH: f64 = 4.0;

/// All that is allowed in a scene but probably not meant, given φ⁰.
pub fn warnings(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> Vec<Warning> {
    let mut warnings = scene::warnings(scene);
    let interface_width = scene.membrane.interface_width;
    let contour = Contour::new(mesh, phi);
    if let scene::Mesh::File(_) = scene.mesh {
        let edge = edge_at_membrane(mesh, phi);
        warnings.extend(edge.and_then(|edge| thin_interface(interface_width, edge, None)));
    }
    let distance = match &scene.vesicle.shape {
        Shape::Outlines(outlines) => {
            let outlines: Vec<OutlineDistance> =
                outlines.iter().map(OutlineDistance::new).collect();
            Some(match scene.mesh {
                scene::Mesh::File(_) => distance_in_polygon(&outlines, mesh, &contour),
                _ => wall_distance(&outlines),
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
        let bound = match &scene.vesicle.shape {
            Shape::Outlines(outlines) if outlines.len() == 1 => {
                Some(OutlineDistance::new(&outlines[0]).isoperimetric_quotient())
            }
            Shape::Random { .. } => None,
            _ => contour.isoperimetric_quotient(),
        };
        let target_squared = area.target * area.target;
        if let Some(bound) = bound.filter(|bound| target_squared < *bound) {
            warnings.push(Warning::TargetOutOfReach {
                target_squared,
                bound,
            });
        }
    }
    warnings
}

/// The least distance of outlines to the wall of any domain: negative if one lies across it, or outside.
fn distance_in_polygon(outlines: &[OutlineDistance], mesh: &Mesh, contour: &Contour) -> f64 {
    let wall = Wall::of(mesh);
    let distance = wall.clearance(|place| union_distance(outlines, place).value);
    if contour.area > 0.0 {
        distance
    } else {
        // Nothing of the vesicle is in the domain.
        -distance.abs()
    }
}

/// The mean length of an edge of the triangles that φ = 0 crosses; `None` where there are none.
fn edge_at_membrane(mesh: &Mesh, phi: &[f64]) -> Option<f64> {
    let crossed = mesh.triangles().iter().filter(|corners| {
        let inside = corners.map(|node| phi[node as usize] > 0.0);
        inside.contains(&true) && inside.contains(&false)
    });
    let lengths = crossed.flat_map(|corners| {
        let [a, b, c] = corners.map(|node| mesh.nodes()[node as usize]);
        [[a, b], [b, c], [c, a]].map(|[from, to]| (to[0] - from[0]).hypot(to[1] - from[1]))
    });
    let (sum, count) = lengths.fold((0.0, 0.0), |(sum, count), length| {
        (sum + length, count + 1.0)
    });
    (count > 0.0).then(|| sum / count)
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

    /// Whether the vesicle has been seen there.
    pub(super) fn reached(&self) -> bool {
        self.reached
    }

    /// For a run that goes on from another.
    pub(super) fn set_reached(&mut self, reached: bool) {
        self.reached = reached;
    }
}
