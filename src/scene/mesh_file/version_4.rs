//! The sections of MSH 4.1.

use nalgebra::Point3;

use super::element::{Element, Kind, NODE};
use super::error::{MeshFileError, MeshFileProblem};
use super::read::{FileNode, FileTriangle, Partitions, read_place};
use super::source::Source;

/// Reads `$Nodes`. There may be fewer than the section's head says: Gmsh reads such files too.
pub(super) fn nodes(
    source: &mut Source<'_>,
    nodes: &mut Vec<FileNode>,
) -> Result<(), MeshFileError> {
    let blocks = source.count("blocks of nodes", 8)?;
    let count = source.count("nodes", 8)?;
    source.size("the smallest number of a node")?;
    source.size("the greatest number of a node")?;
    nodes.reserve(count);
    for _ in 0..blocks {
        if source.is_at_end_of_section() {
            break;
        }
        let dimension = source.int("the dimension of a block")?;
        source.int("the number of a block")?;
        let is_parametric = source.int("whether a block has parameters")? != 0;
        let parameters = match is_parametric {
            true => dimension.clamp(0, 3),
            false => 0,
        };
        let size = source.count("nodes in a block", 8)?;
        let first = nodes.len();
        for _ in 0..size {
            let number = source.size("the number of a node")?;
            let at = Point3::origin();
            let place = source.place();
            nodes.push(FileNode { number, at, place });
        }
        for node in &mut nodes[first..] {
            source.skip_blanks_of_text();
            node.place = source.place();
            node.at = read_place(source)?;
            for _ in 0..parameters {
                source.double("a parameter of a node")?;
            }
        }
    }
    if nodes.len() > count {
        return Err(MeshFileProblem::Unexpected {
            expected: "as many nodes in the blocks as in all",
            found: format!("{} of {count}", nodes.len()),
        }
        .at(source.place()));
    }
    Ok(())
}

/// Reads `$Elements`.
pub(super) fn elements(
    source: &mut Source<'_>,
    triangles: &mut Vec<FileTriangle>,
) -> Result<(), MeshFileError> {
    let blocks = source.count("blocks of elements", 8)?;
    let count = source.count("elements", 4)?;
    source.size("the smallest number of an element")?;
    source.size("the greatest number of an element")?;
    let mut found = 0;
    for _ in 0..blocks {
        source.int("the dimension of a block")?;
        source.int("the number of a block")?;
        let kind = Kind::of(source.int("the type of a block's elements")?);
        let size = source.count("elements in a block", 4)?;
        for _ in 0..size {
            source.skip_blanks_of_text();
            let element = Element {
                place: source.place(),
                number: source.size("the number of an element")?,
                group: 0,
            };
            element.read(&kind, triangles, || source.size(NODE))?;
        }
        found += size;
    }
    if found != count {
        return Err(MeshFileProblem::Unexpected {
            expected: "as many elements in the blocks as in all",
            found: format!("{found} of {count}"),
        }
        .at(source.place()));
    }
    Ok(())
}

/// Reads `$PartitionedEntities`: into how many parts the mesh is divided, and which of them the file has.
pub(super) fn partitions(
    source: &mut Source<'_>,
    partitions: &mut Partitions,
) -> Result<(), MeshFileError> {
    partitions.declared = Some(source.size("the number of partitions")?);
    for _ in 0..source.count("ghost entities", 4)? {
        source.int("the number of a ghost entity")?;
        source.int("the partition of a ghost entity")?;
    }
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = source.count("entities in partitions", 8)?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            source.int("the number of an entity")?;
            source.int("the dimension of an entity's parent")?;
            source.int("the number of an entity's parent")?;
            for _ in 0..source.count("partitions of an entity", 2)? {
                let partition = source.int("the number of a partition")?;
                if dimension == 2 {
                    partitions.found.insert(partition);
                }
            }
            // A point's place, or the corners of the box about the entity.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                source.double("a coordinate")?;
            }
            for _ in 0..source.count("physical groups of an entity", 2)? {
                source.int("the number of a physical group")?;
            }
            if dimension > 0 {
                for _ in 0..source.count("boundaries of an entity", 2)? {
                    source.int("the number of a boundary")?;
                }
            }
        }
    }
    Ok(())
}
