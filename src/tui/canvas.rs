//! What drawing keeps from one frame to the next: where the samples of a picture lie in a mesh.
//! Nothing of the physics and nothing of the app is in it; without it every frame would look the
//! same and take longer.

use std::sync::{Arc, Weak};

use crate::fem::{Mesh, Raster};
use crate::geometry::BoundingBox;

/// Rasters kept: those of a gallery of four and of the single view, twice over for a resize.
const KEPT: usize = 16;

/// What was found of some meshes.
type Kept<T> = Vec<(Weak<Mesh>, T)>;

/// The rasters of the meshes that were last drawn. It belongs to the drawing code, next to the terminal.
#[derive(Debug, Default)]
pub struct Canvas {
    /// The last used last.
    rasters: Kept<(BoundingBox, Arc<Raster>)>,
    regions: Kept<BoundingBox>,
}

impl Canvas {
    /// The rectangle that the cross-section of what a mesh stands for covers.
    pub fn region(&mut self, mesh: &Arc<Mesh>) -> BoundingBox {
        let region = take(&mut self.regions, mesh, |_| true);
        let region = region.unwrap_or_else(|| mesh.section_box());
        keep(&mut self.regions, mesh, region);
        region
    }

    /// Samples of these columns and rows over a rectangle of a mesh.
    pub fn raster(
        &mut self,
        mesh: &Arc<Mesh>,
        region: BoundingBox,
        (columns, rows): (usize, usize),
    ) -> Arc<Raster> {
        let fits = |(of, raster): &(BoundingBox, Arc<Raster>)| {
            *of == region && raster.columns() == columns && raster.rows() == rows
        };
        let kept = take(&mut self.rasters, mesh, fits);
        let raster = kept.map_or_else(
            || Arc::new(Raster::new(mesh, region, columns, rows)),
            |(_, raster)| raster,
        );
        keep(&mut self.rasters, mesh, (region, raster.clone()));
        raster
    }
}

/// Takes what was kept of a mesh out. A mesh is known by its address; the weak reference sees to it
/// that no other mesh can come to lie there.
fn take<T>(kept: &mut Kept<T>, mesh: &Arc<Mesh>, fits: impl Fn(&T) -> bool) -> Option<T> {
    let same = |(of, value): &(Weak<Mesh>, T)| of.as_ptr() == Arc::as_ptr(mesh) && fits(value);
    let index = kept.iter().position(same)?;
    Some(kept.remove(index).1)
}

/// Keeps something of a mesh, and forgets what was not used for the longest time.
fn keep<T>(kept: &mut Kept<T>, mesh: &Arc<Mesh>, value: T) {
    kept.retain(|(of, _)| of.strong_count() > 0);
    if kept.len() >= KEPT {
        kept.remove(0);
    }
    kept.push((Arc::downgrade(mesh), value));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    const REGION: BoundingBox = BoundingBox {
        lower: Point::new(0.0, 0.0),
        upper: Point::new(1.0, 1.0),
    };
    const PART: BoundingBox = BoundingBox {
        lower: Point::new(0.25, 0.0),
        upper: Point::new(1.0, 1.0),
    };

    fn mesh() -> Arc<Mesh> {
        Arc::new(Mesh::structured(4, 0.0, 0).expect("a regular mesh"))
    }

    #[test]
    fn a_raster_is_built_once() {
        let (mut canvas, mesh, other) = (Canvas::default(), mesh(), mesh());
        let first = canvas.raster(&mesh, REGION, (6, 3));
        assert!(Arc::ptr_eq(&first, &canvas.raster(&mesh, REGION, (6, 3))));
        assert!(!Arc::ptr_eq(&first, &canvas.raster(&mesh, REGION, (3, 6))));
        assert!(!Arc::ptr_eq(&first, &canvas.raster(&mesh, PART, (6, 3))));
        assert!(!Arc::ptr_eq(&first, &canvas.raster(&other, REGION, (6, 3))));
        assert!(Arc::ptr_eq(&first, &canvas.raster(&mesh, REGION, (6, 3))));
    }

    #[test]
    fn what_is_not_needed_is_forgotten() {
        let mut canvas = Canvas::default();
        let long_lived = mesh();
        let first = canvas.raster(&long_lived, REGION, (1, 1));
        for columns in 2..100 {
            canvas.raster(&long_lived, REGION, (columns, 1));
        }
        assert_eq!(canvas.rasters.len(), KEPT);
        canvas.region(&long_lived);
        canvas.region(&long_lived);
        assert_eq!(canvas.regions.len(), 1);
        assert!(!Arc::ptr_eq(
            &first,
            &canvas.raster(&long_lived, REGION, (1, 1))
        ));
        drop(long_lived);
        canvas.raster(&mesh(), REGION, (2, 2));
        assert_eq!(canvas.rasters.len(), 1);
    }
}
