//! What a scene's numbers alone do not tell: the vesicle's place, and whether β can be reached.

use crate::fem::{Contour, Mesh};
use crate::scene::{self, OutlineDistance, Scene, Shape, Warning, wall_distance};

/// The interface of a vesicle reaches this many ε beyond φ = 0: tanh(2√2) = 0.993.
const INTERFACE_REACH: f64 = 4.0;

/// All that is allowed in a scene but probably not meant, given φ⁰.
pub fn warnings(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> Vec<Warning> {
    let mut warnings = scene::warnings(scene);
    let interface_width = scene.membrane.interface_width;
    let contour = Contour::new(mesh, phi);
    let distance = match &scene.vesicle.shape {
        Shape::Outlines(outlines) => {
            let outlines: Vec<OutlineDistance> =
                outlines.iter().map(OutlineDistance::new).collect();
            Some(wall_distance(&outlines))
        }
        _ => contour.wall_distance(),
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

/// The nodes within ε of the wall, and whether the vesicle has been seen there.
#[derive(Debug)]
pub(super) struct NearWall {
    nodes: Vec<u32>,
    reached: bool,
}

impl NearWall {
    pub(super) fn new(mesh: &Mesh, interface_width: f64) -> Self {
        let near = |(node, [x, y]): (usize, &[f64; 2])| {
            let distance = x.min(1.0 - x).min(*y).min(1.0 - y);
            (distance <= interface_width).then_some(node as u32)
        };
        let nodes = mesh.nodes().iter().enumerate().filter_map(near).collect();
        Self {
            nodes,
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
