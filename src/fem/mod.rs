//! Finite elements: triangulations, the P1 space with one quadrature rule, assembly, the projection
//! of φ⁰, and what can be read off a P1 function (its zero set, its values on a grid).

mod assembly;
mod boundary;
mod chebyshev;
mod contour;
mod delaunay;
mod error;
mod gradient_recovery;
mod hilbert;
mod locator;
mod mass;
mod mesh;
mod mesh_from_scene;
mod mesh_quality;
mod moving_triangulation;
mod patch;
mod pieces;
mod projection;
mod quadrature;
mod quadtree;
mod raster;
mod rotation;
mod space;
mod vesicles;

pub use assembly::{Assembly, LoadEntries, MatrixEntries};
pub use boundary::{Wall, is_in_hole};
pub use chebyshev::MassInverse;
pub use contour::{Contour, OutlineMeasure, extent_of_inside};
pub use error::FemError;
pub use gradient_recovery::GradientRecovery;
pub use locator::Locator;
pub use mass::MassForm;
pub use mesh::{Grid, Mesh};
pub use mesh_quality::{MeshQuality, SLIVER};
pub use patch::Patch;
pub use pieces::{PieceChanges, Pieces, center_and_axis, long_axis};
pub use projection::{l2_projection, ritz_projection, solve_poisson};
pub use quadrature::QuadratureRule;
pub use raster::{Place, Raster};
pub use space::Space;
pub use vesicles::{Vesicle, Vesicles};

use pieces::Moments;
