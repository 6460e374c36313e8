//! Finite elements: triangulations, the P1 space with one quadrature rule, assembly, the projection
//! of φ⁰, and what can be read off a P1 function (its zero set, its values on a grid).

mod assembly;
mod contour;
mod delaunay;
mod error;
mod mass;
mod mass_inverse;
mod mesh;
mod numbering;
mod of_scene;
mod patch;
mod pieces;
mod projection;
mod quadtree;
mod quality;
mod raster;
mod recovery;
mod rule;
mod space;
mod wall;

pub use assembly::{Assembly, SymmetricTensor};
pub use contour::{Contour, OutlineMeasure};
pub use error::FemError;
pub use mass::MassForm;
pub use mass_inverse::MassInverse;
pub use mesh::{Grid, Mesh};
pub use patch::Patch;
pub use pieces::{Pieces, long_axis};
pub use projection::{GivenFunction, l2_projection, ritz_projection};
pub use quality::{Quality, SLIVER, WorstTriangle};
pub use raster::{Raster, Rectangle};
pub use recovery::Recovery;
pub use rule::Rule;
pub use space::Space;
pub use wall::{Wall, is_in_hole};
