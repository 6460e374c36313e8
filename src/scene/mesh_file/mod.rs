//! Meshes from files: Gmsh's format MSH, versions 2.2 and 4.1, in ASCII and in binary.
//!
//! Read are the nodes and the triangles; lines and points, which Gmsh writes for the boundary, are left
//! out, and so are nodes that no triangle uses. Whatever cannot be used is refused with its place: cells
//! that are no triangles, a section, a node or a triangle that is there twice, a node in the middle of another
//! triangle's edge, triangles that overlap, parts that meet in a corner alone, a mesh in several pieces, one of
//! several parts of a mesh. Triangles that are turned round are turned back.

mod check;
mod element;
mod error;
mod fans;
mod pieces;
mod plane;
mod read;
mod source;
mod version_2;
mod version_4;
mod write;

use std::sync::Arc;

use crate::geometry::Point;

pub use error::MeshFileError;
pub use write::write_mesh;

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The path as the scene gives it.
    pub path: String,
    /// What stands there.
    pub triangulation: Arc<Triangulation>,
}

/// Triangles that cover a polygonal domain once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Triangulation {
    /// The nodes that triangles use, in the file's order.
    pub nodes: Vec<Point>,
    /// The nodes of each triangle, counter-clockwise, by their places in `nodes`.
    pub triangles: Vec<[u32; 3]>,
    /// For each node of the file its place in `nodes`; `None` where no triangle uses it.
    pub places: Vec<Option<u32>>,
    /// Triangles that were turned round in the file.
    pub turned: usize,
}

impl Triangulation {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`MeshFileError`]: what is wrong, and where.
    pub fn parse(bytes: &[u8]) -> Result<Self, MeshFileError> {
        check::checked(read::read(bytes)?)
    }
}

#[cfg(test)]
mod tests;
