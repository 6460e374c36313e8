//! φ⁰ and d⁰ of a scene, on a mesh.

use std::sync::Arc;

use thiserror::Error;

use crate::fem::{FemError, Mesh, l2_projection, ritz_projection};
use crate::geometry::Point;
use crate::scene::{
    Boundary, InitialDirector, OutlineDistance, Projection, Scene, Shape, initial_director,
    phase_profile, random_phase, union_distance,
};

/// Initial fields that could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InitialError {
    /// A projection failed.
    #[error(transparent)]
    Projection(#[from] FemError),
    /// A file has another number of values than the mesh has nodes.
    #[error(
        "{path} has {found} rows, but the mesh has {nodes} nodes; give one row a node, in the mesh's order"
    )]
    WrongCount {
        /// The file.
        path: String,
        /// Rows found.
        found: usize,
        /// Nodes of the mesh.
        nodes: usize,
    },
}

/// Nodal φ⁰ and, with a [nematic] table, d⁰.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialFields {
    /// φ⁰.
    pub phi: Vec<f64>,
    /// d⁰, component by component.
    pub director: Option<[Vec<f64>; 2]>,
}

/// The initial fields of a scene.
///
/// # Errors
/// [`InitialError`]: the projection failed, or a file does not fit the mesh.
pub fn initial_fields(scene: &Scene, mesh: &Arc<Mesh>) -> Result<InitialFields, InitialError> {
    check_counts(scene, mesh)?;
    let wall = (scene.boundary == Boundary::Clamped).then_some(-1.0);
    let nodes = mesh.nodes();
    let mut phi = match &scene.vesicle.shape {
        Shape::Outlines(outlines) => {
            let distances: Vec<OutlineDistance> =
                outlines.iter().map(OutlineDistance::new).collect();
            let width = scene.membrane.interface_width;
            let given = |place: Point| phase_profile(union_distance(&distances, place), width);
            match scene.vesicle.projection {
                Projection::Ritz => ritz_projection(mesh, &given, wall)?,
                Projection::L2 => l2_projection(mesh, &given, wall)?,
                Projection::Nodal => nodes.iter().map(|&node| given(node).0).collect(),
            }
        }
        Shape::Random { amplitude, seed } => {
            mesh.inward(random_phase(*amplitude, *seed, nodes.len()))
        }
        Shape::File(file) => mesh.inward(file.values.to_vec()),
    };
    phi.iter_mut()
        .for_each(|value| *value *= scene.vesicle.scale);
    if let Some(wall) = wall {
        for (value, on) in phi.iter_mut().zip(mesh.on_boundary()) {
            *value = if *on { wall } else { *value };
        }
    }
    let mut director = match &scene.nematic {
        None => None,
        Some(nematic) => {
            let initial = &nematic.initial;
            Some(match initial {
                // Node by node, in the order of the file that the mesh may be from.
                InitialDirector::File(_) | InitialDirector::Random { .. } => {
                    let places = mesh.outward(nodes);
                    initial_director(initial, &places).map(|component| mesh.inward(component))
                }
                _ => initial_director(initial, nodes),
            })
        }
    };
    if let Some([radial, _]) = &mut director {
        keep_to_axis(mesh, radial);
    }
    Ok(InitialFields { phi, director })
}

/// d_r = 0 on the axis of rotation, whatever d⁰ is beside it.
pub(super) fn keep_to_axis(mesh: &Mesh, radial: &mut [f64]) {
    for (value, on) in radial.iter_mut().zip(mesh.on_axis()) {
        *value = if on { 0.0 } else { *value };
    }
}

/// Every file of nodal values must have one for each node of the mesh.
fn check_counts(scene: &Scene, mesh: &Mesh) -> Result<(), InitialError> {
    let nodes = mesh.nodes().len();
    for (_, file) in scene.nodal_files() {
        let found = file.values.len() / file.columns.max(1);
        if found != nodes {
            return Err(InitialError::WrongCount {
                path: file.path,
                found,
                nodes,
            });
        }
    }
    Ok(())
}
