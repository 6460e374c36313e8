//! The sections of a file: nodes and triangles as they stand there.

use super::error::{MeshFileError, MeshFileProblem, MeshPlace};
use super::source::{Encoding, Source};

/// Nodes and triangles as they stand in a file, with where they do.
#[derive(Debug, Default)]
pub(super) struct Content {
    pub(super) nodes: Vec<FileNode>,
    pub(super) triangles: Vec<FileTriangle>,
    pub(super) end: Option<MeshPlace>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FileNode {
    pub(super) number: u64,
    pub(super) at: [f64; 3],
    pub(super) place: MeshPlace,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FileTriangle {
    pub(super) number: u64,
    pub(super) nodes: [u64; 3],
    pub(super) place: MeshPlace,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    /// 2.2
    Two,
    /// 4.1
    Four,
}

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Content, MeshFileError> {
    let mut source = Source::new(bytes);
    let version = read_format(&mut source)?;
    let mut content = Content::default();
    let [mut has_nodes, mut has_elements] = [false; 2];
    // What stands between the sections is text, in a binary file as well.
    while let Some((place, word)) = source.word() {
        match word {
            b"$Nodes" if !has_nodes => {
                has_nodes = true;
                begin_data(&mut source);
                match version {
                    Version::Two => read_nodes_2(&mut source, &mut content.nodes)?,
                    Version::Four => read_nodes_4(&mut source, &mut content.nodes)?,
                }
                source.expect("$EndNodes")?;
            }
            b"$Elements" if !has_elements => {
                has_elements = true;
                begin_data(&mut source);
                match version {
                    Version::Two => read_elements_2(&mut source, &mut content.triangles)?,
                    Version::Four => read_elements_4(&mut source, &mut content.triangles)?,
                }
                source.expect("$EndElements")?;
            }
            [b'$', name @ ..] => source.skip_section(name)?,
            _ => {
                let found = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
                let expected = "a section such as $Nodes";
                let found = found.replace(char::is_control, "\u{fffd}");
                return Err(MeshFileProblem::Unexpected { expected, found }.at(place));
            }
        }
    }
    let end = source.place();
    for (section, there) in [("Nodes", has_nodes), ("Elements", has_elements)] {
        if !there {
            return Err(MeshFileProblem::NoSection { section }.at(end));
        }
    }
    content.end = Some(end);
    Ok(content)
}

/// The byte that ends the line of a section's name: what follows may be binary.
fn begin_data(source: &mut Source<'_>) {
    if source.encoding != Encoding::Text {
        source.skip_line_end();
    }
}

fn read_format(source: &mut Source<'_>) -> Result<Version, MeshFileError> {
    let not_msh = |place| MeshFileProblem::NotMsh.at(place);
    match source.word() {
        Some((_, b"$MeshFormat")) => {}
        _ => return Err(not_msh(MeshPlace::Line(1))),
    }
    let Some((place, version)) = source.word() else {
        return Err(not_msh(source.place()));
    };
    let version = String::from_utf8_lossy(&version[..version.len().min(12)]).into_owned();
    let is_binary = match source.int("0 for ASCII or 1 for binary")? {
        0 => false,
        1 => true,
        other => {
            return Err(MeshFileProblem::Unexpected {
                expected: "0 for ASCII or 1 for binary",
                found: other.to_string(),
            }
            .at(place));
        }
    };
    let bytes = source.int("the size of a number in bytes")?;
    let read = match (version.as_str(), is_binary) {
        ("2.2" | "2", false) => Version::Two,
        ("4.1", _) => Version::Four,
        _ => {
            let version = version.replace(char::is_control, "\u{fffd}");
            return Err(MeshFileProblem::Version {
                version,
                binary: is_binary,
            }
            .at(place));
        }
    };
    if is_binary {
        source.skip_line_end();
        source.encoding = Encoding::Binary { is_little: true };
        let place = source.place();
        let wrong = |found: String| Err(MeshFileProblem::Binary { found }.at(place));
        match source.int("the number 1, which tells the order of bytes")? {
            1 => {}
            // 1, read the other way round.
            0x0100_0000 => source.encoding = Encoding::Binary { is_little: false },
            other => {
                return wrong(format!(
                    "{other} in place of the 1 that tells the order of bytes"
                ));
            }
        }
        if bytes != 8 {
            return wrong(format!("{bytes}-byte sizes"));
        }
    }
    source.expect("$EndMeshFormat")?;
    Ok(read)
}

fn read_nodes_2(source: &mut Source<'_>, nodes: &mut Vec<FileNode>) -> Result<(), MeshFileError> {
    // "1 0 0 0" and the end of the line.
    let count = source.count("nodes", 8)?;
    nodes.reserve(count);
    for _ in 0..count {
        source.skip_blanks();
        let place = source.place();
        let number = source.size("the number of a node")?;
        let at = read_place(source)?;
        nodes.push(FileNode { number, at, place });
    }
    Ok(())
}

fn read_place(source: &mut Source<'_>) -> Result<[f64; 3], MeshFileError> {
    let mut at = [0.0; 3];
    for value in &mut at {
        *value = source.double("a coordinate")?;
    }
    Ok(at)
}

fn read_nodes_4(source: &mut Source<'_>, nodes: &mut Vec<FileNode>) -> Result<(), MeshFileError> {
    let blocks = source.count("blocks of nodes", 8)?;
    let count = source.count("nodes", 8)?;
    source.size("the smallest number of a node")?;
    source.size("the greatest number of a node")?;
    nodes.reserve(count);
    for _ in 0..blocks {
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
            let at = [0.0; 3];
            let place = source.place();
            nodes.push(FileNode { number, at, place });
        }
        for node in &mut nodes[first..] {
            skip_blanks(source);
            node.place = source.place();
            node.at = read_place(source)?;
            for _ in 0..parameters {
                source.double("a parameter of a node")?;
            }
        }
    }
    if nodes.len() != count {
        return Err(MeshFileProblem::Unexpected {
            expected: "as many nodes in the blocks as in all",
            found: format!("{} of {count}", nodes.len()),
        }
        .at(source.place()));
    }
    Ok(())
}

fn skip_blanks(source: &mut Source<'_>) {
    if source.encoding == Encoding::Text {
        source.skip_blanks();
    }
}

/// What an element is, by Gmsh's number of its type.
enum Kind {
    Triangle,
    /// A point or a line, of so many nodes: it is left out.
    Less(usize),
    Other(String),
}

impl Kind {
    fn of(number: i64) -> Self {
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

fn read_elements_2(
    source: &mut Source<'_>,
    triangles: &mut Vec<FileTriangle>,
) -> Result<(), MeshFileError> {
    // "1 15 0 1" and the end of the line.
    let count = source.count("elements", 8)?;
    for _ in 0..count {
        source.skip_blanks();
        let place = source.place();
        let number = source.size("the number of an element")?;
        let kind = Kind::of(source.int("the type of an element")?);
        let tags = source.count("tags of an element", 2)?;
        for _ in 0..tags {
            source.int("a tag of an element")?;
        }
        read_element(source, (number, place), &kind, triangles)?;
    }
    Ok(())
}

fn read_elements_4(
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
            skip_blanks(source);
            let place = source.place();
            let number = source.size("the number of an element")?;
            read_element(source, (number, place), &kind, triangles)?;
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

/// The nodes of an element; takes it if it is a triangle.
fn read_element(
    source: &mut Source<'_>,
    (number, place): (u64, MeshPlace),
    kind: &Kind,
    triangles: &mut Vec<FileTriangle>,
) -> Result<(), MeshFileError> {
    match kind {
        Kind::Triangle => {
            let mut nodes = [0; 3];
            for node in &mut nodes {
                *node = source.size("the number of a triangle's node")?;
            }
            triangles.push(FileTriangle {
                number,
                nodes,
                place,
            });
            Ok(())
        }
        Kind::Less(nodes) => {
            for _ in 0..*nodes {
                source.size("the number of an element's node")?;
            }
            Ok(())
        }
        Kind::Other(kind) => Err(MeshFileProblem::NotSupported {
            element: number,
            kind: kind.clone(),
        }
        .at(place)),
    }
}
