//! The sections of MSH 2.2.

use super::element::{Element, Kind, NODE};
use super::error::{MeshFileError, MeshFileProblem};
use super::read::{Content, FileNode, read_place};
use super::source::{Encoding, Source};

/// Reads `$Nodes` or, with places on curves and surfaces behind the coordinates, `$ParametricNodes`.
/// There may be fewer than the section's head says: Gmsh reads such files too.
pub(super) fn nodes(
    source: &mut Source<'_>,
    is_parametric: bool,
    nodes: &mut Vec<FileNode>,
) -> Result<(), MeshFileError> {
    // "1 0 0 0" and the end of the line.
    let count = count(source, "nodes")?;
    nodes.reserve(count);
    for _ in 0..count {
        if source.is_at_end_of_section() {
            break;
        }
        let place = source.place();
        let number = number(source, "the number of a node")?;
        let at = read_place(source)?;
        nodes.push(FileNode { number, at, place });
        if is_parametric {
            let dimension = source.int("the dimension of a node's curve or surface")?;
            source.int("the number of a node's curve or surface")?;
            // Within a volume a node has none.
            let parameters = if dimension < 3 { dimension.max(0) } else { 0 };
            for _ in 0..parameters {
                source.double("a parameter of a node")?;
            }
        }
    }
    Ok(())
}

/// Reads `$Elements`.
pub(super) fn elements(
    source: &mut Source<'_>,
    content: &mut Content,
) -> Result<(), MeshFileError> {
    // "1 15 0 1" and the end of the line.
    let count = count(source, "elements")?;
    let mut left = count;
    while left > 0 {
        // In binary those of one type have a head in common.
        let (head, size) = match source.encoding {
            Encoding::Text => (None, 1),
            Encoding::Binary { .. } => {
                let place = source.place();
                let kind = source.int("the type of elements")?;
                let size = source.int("how many elements follow")?;
                let tags = source.int("tags of an element")?;
                let Some(size) = usize::try_from(size)
                    .ok()
                    .filter(|it| (1..=left).contains(it))
                else {
                    let found = size.to_string();
                    let expected = "how many elements follow";
                    return Err(MeshFileProblem::Unexpected { expected, found }.at(place));
                };
                (Some((kind, tags)), size)
            }
        };
        left -= size;
        for _ in 0..size {
            element(source, head, content)?;
        }
    }
    Ok(())
}

/// Reads an element, its type and the number of its tags unless the head has them.
fn element(
    source: &mut Source<'_>,
    head: Option<(i64, i64)>,
    content: &mut Content,
) -> Result<(), MeshFileError> {
    source.skip_blanks_of_text();
    let place = source.place();
    let number = number(source, "the number of an element")?;
    let (kind, tags) = match head {
        Some(head) => head,
        None => (
            source.int("the type of an element")?,
            source.int("tags of an element")?,
        ),
    };
    let kind = Kind::of(kind);
    // The physical group, the curve or surface, then in how many parts of the mesh it is, and in which.
    let mut known = [0; 4];
    for tag in 0..tags {
        let value = source.int("a tag of an element")?;
        if let Some(known) = usize::try_from(tag).ok().and_then(|tag| known.get_mut(tag)) {
            *known = value;
        }
    }
    let [group, _, parts, part] = known;
    if matches!(kind, Kind::Triangle) && parts > 0 && tags > 3 {
        content.partitions.found.insert(part);
    }
    let element = Element {
        number,
        group,
        place,
    };
    element.read(&kind, &mut content.triangles, || self::number(source, NODE))
}

/// How many things follow, which is text in a binary file as well.
fn count(source: &mut Source<'_>, what: &'static str) -> Result<usize, MeshFileError> {
    let encoding = std::mem::replace(&mut source.encoding, Encoding::Text);
    // The shortest ones, "1 0 0 0" and "1 15 0 1" with the end of the line, have this many bytes.
    let count = source.count(what, 8);
    source.encoding = encoding;
    if encoding != Encoding::Text {
        source.skip_line_end();
    }
    count
}

/// The number of a node or an element: four bytes, or a word.
fn number(source: &mut Source<'_>, expected: &'static str) -> Result<u64, MeshFileError> {
    if source.encoding == Encoding::Text {
        return source.size(expected);
    }
    let place = source.place();
    let number = source.int(expected)?;
    u64::try_from(number).map_err(|_| {
        let found = number.to_string();
        MeshFileProblem::Unexpected { expected, found }.at(place)
    })
}
