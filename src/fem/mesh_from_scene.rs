//! The mesh that a scene asks for.

use std::sync::Arc;

use super::delaunay::{adapted, delaunay};
use super::{FemError, Mesh};
use crate::scene::{self, MeshSize, Scene};

impl Mesh {
    /// The mesh of a scene.
    ///
    /// # Errors
    /// [`FemError`]: it cannot be made.
    pub fn of(scene: &Scene) -> Result<Arc<Self>, FemError> {
        Self::of_unless(scene, &mut || false)
    }

    /// The mesh of a scene; `leave` is asked now and then whether to give up.
    ///
    /// # Errors
    /// [`FemError`]: it cannot be made, or was left.
    pub fn of_unless(
        scene: &Scene,
        leave: &mut dyn FnMut() -> bool,
    ) -> Result<Arc<Self>, FemError> {
        let shape = &scene.vesicle.shape;
        let mesh = match &scene.mesh {
            scene::Mesh::Structured {
                cells,
                jitter,
                seed,
            } => Self::structured(*cells, *jitter, *seed),
            scene::Mesh::Delaunay { size, seed, refine } => {
                delaunay(&MeshSize::new(*size, *refine, shape), *seed, leave)
            }
            scene::Mesh::Adaptive { size, seed, refine } => {
                delaunay(&MeshSize::at_start(*size, *refine, shape), *seed, leave)
            }
            scene::Mesh::File(file) => Self::from_triangulation(&file.triangulation),
        };
        mesh.map(|mesh| Arc::new(mesh.in_geometry(scene.geometry)))
    }

    /// A mesh of the unit square of another size, made from this one; the seed is that of the nodes that come.
    ///
    /// # Errors
    /// [`FemError`]: it cannot be made.
    pub fn adapted(&self, size: &MeshSize, seed: u64) -> Result<Arc<Self>, FemError> {
        let mesh = adapted(self, size, seed)?;
        Ok(Arc::new(mesh.in_geometry(self.geometry())))
    }
}
