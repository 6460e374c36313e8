//! Why a run's folder cannot be read back.

use super::super::LoadError;
use super::super::shortened::shortened_to;
use crate::fem::FemError;
use std::io;
use std::path::PathBuf;

/// Letters of what is wrong with XML, in which names are quoted, at most.
const LONGEST_REASON: usize = 160;

/// A run's folder cannot be read back.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It is not the folder of a run.
    #[error("{} is not the folder of a run: it has no {missing}", folder.display())]
    NotARun {
        /// The folder.
        folder: PathBuf,
        /// The file that it does not have.
        missing: &'static str,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// The scene is not one.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// A file is not the JSON that it should be.
    #[error("{} is damaged, or not by vesica: {reason}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Where, and what is wrong.
        #[source]
        reason: serde_json::Error,
    },
    /// A table has no header.
    #[error("{} is empty: a table begins with the names of its columns", path.display())]
    EmptyTable {
        /// The file.
        path: PathBuf,
    },
    /// A table lacks a column.
    #[error("{} has no column {name}", path.display())]
    NoColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        name: &'static str,
    },
    /// A line of a table has too few or too many cells.
    #[error(
        "{} is damaged: line {line} has {found} cells, the header has {expected}",
        path.display()
    )]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, the header being 1.
        line: usize,
        /// Its cells.
        found: usize,
        /// The cells of the header.
        expected: usize,
    },
    /// A cell of a table is not a number.
    #[error(
        "{} is damaged: line {line}, column {column} has {text:?}, which is no number",
        path.display()
    )]
    Cell {
        /// The file.
        path: PathBuf,
        /// The line, the header being 1.
        line: usize,
        /// The column.
        column: String,
        /// What stands there.
        text: String,
    },
    /// A VTU file is not XML.
    #[error(
        "{} is damaged: it is not XML: {}",
        path.display(),
        shortened_to(&reason.to_string(), LONGEST_REASON)
    )]
    Xml {
        /// The file.
        path: PathBuf,
        /// Where, and what is wrong.
        #[source]
        reason: roxmltree::Error,
    },
    /// An array of a VTU file is not what it should be.
    #[error("{} is damaged, or not by vesica: the array {array} {problem}", path.display())]
    Array {
        /// The file.
        path: PathBuf,
        /// Its name.
        array: &'static str,
        /// What is wrong.
        problem: WrongArray,
    },
    /// The mesh of a VTU file is not a mesh.
    #[error("{} is damaged: {reason}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        reason: FemError,
    },
    /// The fields of a run are on different meshes.
    #[error(
        "{} is not on the mesh of {}: the run's folder has files of different runs",
        path.display(), first.display()
    )]
    OtherMesh {
        /// The file.
        path: PathBuf,
        /// The file whose mesh is taken for that of the run.
        first: PathBuf,
    },
}

/// What is wrong with an array of a VTU file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WrongArray {
    /// It is not there.
    #[error("is missing")]
    Missing,
    /// It is stored in another way.
    #[error("is not stored as {0} in base64")]
    Stored(&'static str),
    /// It is not base64.
    #[error("is not base64: {0}")]
    Base64(#[from] base64::DecodeError),
    /// It is cut short or too long.
    #[error("has {found} bytes where {expected} are expected")]
    Length {
        /// The bytes there are.
        found: usize,
        /// The bytes there should be.
        expected: usize,
    },
    /// It names a node that is not there.
    #[error("names the node {node}, and there are {nodes}")]
    Node {
        /// The node.
        node: i64,
        /// How many there are.
        nodes: usize,
    },
    /// Not all cells are triangles.
    #[error("has cells that are no triangles")]
    NotTriangles,
}
