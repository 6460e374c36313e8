//! The kinds of elements.

use super::error::{MeshFileError, MeshFileProblem, MeshPlace};
use super::read::FileTriangle;

/// What an element is, by Gmsh's number of its type.
pub(super) enum Kind {
    Triangle,
    /// A point or a line, of so many nodes: it is left out.
    Less(usize),
    Other(String),
}

impl Kind {
    pub(super) fn of(number: i64) -> Self {
        let other = |words: &str| Self::Other(words.to_owned());
        match number {
            2 => Self::Triangle,
            15 => Self::Less(1),
            1 => Self::Less(2),
            8 => Self::Less(3),
            26 => Self::Less(4),
            3 => other("a quadrilateral"),
            10 | 16 => other("a quadrilateral of second order"),
            9 => other("a triangle of second order"),
            20..=25 => other("a triangle of higher order"),
            4 | 11 | 29..=31 => other("a tetrahedron (a cell in 3D)"),
            5 | 12 | 17 => other("a hexahedron (a cell in 3D)"),
            6 | 13 | 18 => other("a prism (a cell in 3D)"),
            7 | 14 | 19 => other("a pyramid (a cell in 3D)"),
            number => Self::Other(format!("of Gmsh's type {number}")),
        }
    }
}

/// An element of which the nodes are still to be read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element {
    pub(super) number: u64,
    /// Its physical group, where the format says that.
    pub(super) group: i64,
    pub(super) place: MeshPlace,
}

impl Element {
    /// Reads its nodes, each as `node` does; takes it if it is a triangle.
    pub(super) fn read(
        self,
        kind: &Kind,
        triangles: &mut Vec<FileTriangle>,
        mut node: impl FnMut() -> Result<u64, MeshFileError>,
    ) -> Result<(), MeshFileError> {
        match kind {
            Kind::Triangle => {
                let nodes = [node()?, node()?, node()?];
                triangles.push(FileTriangle {
                    number: self.number,
                    nodes,
                    group: self.group,
                    place: self.place,
                });
                Ok(())
            }
            Kind::Less(nodes) => {
                for _ in 0..*nodes {
                    node()?;
                }
                Ok(())
            }
            Kind::Other(kind) => Err(MeshFileProblem::NotSupported {
                element: self.number,
                kind: kind.clone(),
            }
            .at(self.place)),
        }
    }
}

/// What stands where a node of an element should.
pub(super) const NODE: &str = "the number of an element's node";
