//! Why a file is no mesh that can be used, and where.

use std::fmt;

use thiserror::Error;

use crate::geometry::Point;

/// Where something stands in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshPlace {
    /// A line of a text, from 1.
    Line(usize),
    /// A byte of binary data, from 0.
    Byte(usize),
}

impl fmt::Display for MeshPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a file is no mesh that can be used, and where.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{place}: {problem}{}", in_section(*section))]
pub struct MeshFileError {
    /// Where.
    pub place: MeshPlace,
    /// Why.
    pub problem: MeshFileProblem,
    /// The section whose content cannot be read, without the $.
    pub section: Option<&'static str>,
}

impl MeshFileError {
    /// The same, in a section. What has a remedy of its own is complete without.
    pub(super) fn within(mut self, section: &'static str) -> Self {
        let is_of_the_text = matches!(
            self.problem,
            MeshFileProblem::Unexpected { .. }
                | MeshFileProblem::Ends { .. }
                | MeshFileProblem::TooMany { .. }
        );
        if is_of_the_text {
            self.section = Some(section);
        }
        self
    }
}

/// Names the section, and how a file is had that can be read.
fn in_section(section: Option<&str>) -> String {
    section.map_or_else(String::new, |section| {
        format!(
            " (in the section ${section}; Gmsh writes a file that is read: gmsh FILE -save -format msh41)"
        )
    })
}

/// What is wrong with a file. Nodes and elements are named by the numbers (tags) that the file gives
/// them.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshFileProblem {
    /// It does not begin as such a file does.
    #[error(
        "this is no mesh of Gmsh, whose first line is $MeshFormat; write it with gmsh -2 -format msh41"
    )]
    NotMsh,
    /// A version of the format that is not read.
    #[error(
        "MSH {version} in {} is not supported, MSH 2.2 and MSH 4.1 are: convert it with gmsh FILE -save -format msh41",
        if *binary { "binary" } else { "ASCII" }
    )]
    Version {
        /// As the file says.
        version: String,
        /// Whether it is binary.
        binary: bool,
    },
    /// The text has two bytes a character.
    #[error("the file is a text in UTF-16: save it in UTF-8 or ASCII")]
    Utf16,
    /// Some parts of a mesh that was divided.
    #[error(
        "the file has {found} of {of} partitions of a mesh: give the file of the whole mesh (in Gmsh: Mesh.PartitionSplitMeshFiles = 0, or without -part)"
    )]
    Part {
        /// How many the file has.
        found: u64,
        /// How many there are, in words.
        of: String,
    },
    /// The data are of another machine's kind.
    #[error(
        "binary data with {found}; 8-byte sizes and the byte order of either kind are supported"
    )]
    Binary {
        /// What is not as it should be.
        found: String,
    },
    /// The file ends too early.
    #[error("the file ends where {expected} should follow")]
    Ends {
        /// What is missing.
        expected: &'static str,
    },
    /// A word that is not what should stand there.
    #[error("expected {expected}, found '{found}'")]
    Unexpected {
        /// What should stand there.
        expected: &'static str,
        /// What does.
        found: String,
    },
    /// More things than the rest of the file can hold.
    #[error("{count} {what} cannot stand in what is left of the file, {left} bytes")]
    TooMany {
        /// How many are told of.
        count: u64,
        /// Of what.
        what: &'static str,
        /// What is left.
        left: usize,
    },
    /// A section that is there twice.
    #[error(
        "the file has a second section ${section}, after that at {first}, and a mesh has one of each: put what it holds \
         into the first one; of two meshes make one in Gmsh, from one geometry"
    )]
    SecondSection {
        /// Its name.
        section: &'static str,
        /// Where the first one is.
        first: MeshPlace,
    },
    /// A section before that which says how it is to be read.
    #[error(
        "the section ${section} stands before any $MeshFormat, which says how it is to be read: begin the file with \
         $MeshFormat"
    )]
    BeforeFormat {
        /// Its name.
        section: String,
    },
    /// There is no such section.
    #[error("the file has no section ${section}: write the mesh with gmsh -2 -format msh41")]
    NoSection {
        /// Its name.
        section: &'static str,
    },
    /// A coordinate that is not finite.
    #[error("node {node} has the coordinate {value}")]
    NotFinite {
        /// Its number.
        node: u64,
        /// The value.
        value: f64,
    },
    /// A mesh in another plane.
    #[error(
        "the mesh is flat, but lies in the plane {plane}, not in that of x and y: turn it (in Gmsh: Rotate, or swap the coordinates of the points)"
    )]
    OtherPlane {
        /// Which plane, in words.
        plane: String,
    },
    /// A node that leaves the plane.
    #[error("node {node} lies at z = {z}, others at z = {plane}: the mesh must be flat")]
    NotFlat {
        /// Its number.
        node: u64,
        /// Its third coordinate.
        z: f64,
        /// That of the first node.
        plane: f64,
    },
    /// Two nodes of one number.
    #[error("there are two nodes with the number {node}")]
    NodeTwice {
        /// The number.
        node: u64,
    },
    /// A cell that is no triangle.
    #[error(
        "element {element} is {kind}, which is not supported: triangles of three nodes are (in Gmsh: Mesh.RecombineAll = 0, Mesh.ElementOrder = 1, and gmsh -2)"
    )]
    NotSupported {
        /// Its number.
        element: u64,
        /// What it is.
        kind: String,
    },
    /// A node that an element names and that does not exist.
    #[error("element {element} has the node {node}, which does not exist")]
    NoNode {
        /// The element's number.
        element: u64,
        /// The node's.
        node: u64,
    },
    /// No triangle at all.
    #[error("there is no triangle in the mesh")]
    NoTriangles,
    /// A triangle without an area.
    #[error("triangle {element} (nodes {nodes:?}) has no area")]
    Flat {
        /// Its number.
        element: u64,
        /// Its nodes' numbers.
        nodes: [u64; 3],
    },
    /// Two nodes at one place.
    #[error(
        "the nodes {first} and {second} are both at ({}, {}): every place must have one node (in Gmsh: Coherence Mesh)",
        at.x, at.y
    )]
    SamePlace {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
        /// Where.
        at: Point,
    },
    /// A triangle that is there twice.
    #[error("the triangles {first} and {second} have the same nodes")]
    SameTriangle {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
    },
    /// Two triangles on one side of an edge, or more than two on an edge.
    #[error(
        "the triangles {first} and {second} overlap: both lie on the same side of the edge of the nodes {} and {}, about ({}, {})",
        nodes[0], nodes[1], at.x, at.y
    )]
    Overlap {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
        /// The edge.
        nodes: [u64; 2],
        /// Its middle.
        at: Point,
    },
    /// Two triangles whose edges cross.
    #[error(
        "the triangles {first} and {second} overlap: their edges cross at ({}, {}) (in Gmsh: BooleanFragments, before it meshes)",
        at.x, at.y
    )]
    Crossing {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
        /// Where.
        at: Point,
    },
    /// Two triangles that overlap about a node.
    #[error(
        "the triangles {first} and {second} overlap at their common node {node}, ({}, {}) (in Gmsh: BooleanFragments, before it meshes)",
        at.x, at.y
    )]
    OverlapAtNode {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
        /// The node.
        node: u64,
        /// Where it is.
        at: Point,
    },
    /// Two parts of the domain that meet in a corner.
    #[error(
        "the parts of the mesh with the triangles {first} and {second} meet in nothing but the node {node} there, at ({}, {}): they must have an edge in common, or a gap between them",
        at.x, at.y
    )]
    CornerOnly {
        /// A triangle of the one.
        first: u64,
        /// A triangle of the other.
        second: u64,
        /// The node.
        node: u64,
        /// Where it is.
        at: Point,
    },
    /// A node in the middle of an edge.
    #[error(
        "node {node} hangs: it lies within the edge of the nodes {} and {} of triangle {element}, which must be divided there",
        nodes[0], nodes[1]
    )]
    Hanging {
        /// The node's number.
        node: u64,
        /// The triangle's.
        element: u64,
        /// The edge.
        nodes: [u64; 2],
    },
    /// Two triangles of which one has a node within the other.
    #[error(
        "the triangles {first} and {second} overlap: node {node} of triangle {second} lies within triangle {first}, at \
         ({}, {}) (in Gmsh: BooleanFragments, before it meshes)",
        at[0], at[1]
    )]
    NodeWithin {
        /// The one.
        first: u64,
        /// The other.
        second: u64,
        /// The node of the second.
        node: u64,
        /// Where it is.
        at: [f64; 2],
    },
    /// Several pieces.
    #[error("the mesh is in pieces: triangle {element} is not connected with the first one")]
    Pieces {
        /// The number of a triangle of another piece.
        element: u64,
    },
}

impl MeshFileProblem {
    pub(super) fn at(self, place: MeshPlace) -> MeshFileError {
        MeshFileError {
            place,
            problem: self,
            section: None,
        }
    }
}
