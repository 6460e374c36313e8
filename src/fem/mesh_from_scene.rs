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
        let mesh = match &scene.mesh {
            scene::Mesh::Structured {
                cells,
                jitter,
                seed,
            } => Self::structured(*cells, *jitter, *seed),
            scene::Mesh::Delaunay { size, seed, refine } => {
                let size = MeshSize::new(*size, *refine, &scene.vesicle.shape);
                delaunay(&size, *seed, leave)
            }
            scene::Mesh::File(file) => Self::from_triangulation(&file.triangulation),
        };
        mesh.map(Arc::new)
    }
}
