//! The mesh that a scene asks for.

use std::sync::Arc;

use super::delaunay::delaunay;
use super::{FemError, Mesh};
use crate::scene::{self, MeshSize, Scene};

impl Mesh {
    /// The mesh of a scene.
    ///
    /// # Errors
    /// [`FemError`]: it cannot be made.
    pub fn of(scene: &Scene) -> Result<Arc<Self>, FemError> {
        let mesh = match &scene.mesh {
            scene::Mesh::Structured {
                cells,
                jitter,
                seed,
            } => Self::structured(*cells, *jitter, *seed),
            scene::Mesh::Delaunay { size, seed, .. } => match MeshSize::of(scene) {
                Some(wanted) => delaunay(&|place| wanted.at(place), wanted.smallest(), *seed),
                None => delaunay(&|_| *size, *size, *seed),
            },
            scene::Mesh::File(file) => Self::from_triangulation(&file.triangulation),
        };
        mesh.map(Arc::new)
    }
}
