//! The sections of a file: nodes and triangles as they stand there.

use std::collections::BTreeSet;

use nalgebra::Point3;

use super::error::{MeshFileError, MeshFileProblem, MeshPlace};
use super::source::{Encoding, Source};
use super::{version_2, version_4};

/// Nodes and triangles as they stand in a file, with where they do.
#[derive(Debug, Default)]
pub(super) struct Content {
    pub(super) nodes: Vec<FileNode>,
    pub(super) triangles: Vec<FileTriangle>,
    pub(super) partitions: Partitions,
    pub(super) end: Option<MeshPlace>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FileNode {
    pub(super) number: u64,
    pub(super) at: Point3<f64>,
    pub(super) place: MeshPlace,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FileTriangle {
    pub(super) number: u64,
    pub(super) nodes: [u64; 3],
    /// The physical group for which it stands there, where the format has a triangle once for each.
    pub(super) group: i64,
    pub(super) place: MeshPlace,
}

/// The parts into which Gmsh has divided a mesh, to be computed on by as many processes.
#[derive(Debug, Default)]
pub(super) struct Partitions {
    /// How many there are, where the file says so.
    pub(super) declared: Option<u64>,
    /// Those of the triangles that the file has.
    pub(super) found: BTreeSet<i64>,
}

impl Partitions {
    /// Refuses a file that does not have all parts.
    fn check(&self, end: MeshPlace) -> Result<(), MeshFileError> {
        let found = self.found.len() as u64;
        let (has_all, of) = match self.declared {
            Some(declared) => (found == 0 || found >= declared, declared.to_string()),
            // Parts are numbered from 1. One alone is not known to be the only one.
            None => {
                let last = self.found.last().copied().unwrap_or(0);
                let has_all = found == 0 || (found > 1 && last == found as i64);
                (has_all, "several".to_owned())
            }
        };
        if has_all {
            return Ok(());
        }
        Err(MeshFileProblem::Part { found, of }.at(end))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    /// 2.2
    Two,
    /// 4.1
    Four,
}

/// What a text in UTF-8 may begin with.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The sections that are read, each in the way that the format says.
const NEEDS_FORMAT: [&[u8]; 4] = [
    b"Nodes",
    b"ParametricNodes",
    b"Elements",
    b"PartitionedEntities",
];

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Content, MeshFileError> {
    if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = bytes {
        return Err(MeshFileProblem::Utf16.at(MeshPlace::Line(1)));
    }
    let mut source = Source::new(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes));
    let (format, version) = find_format(&mut source)?;
    let mut content = Content::default();
    let mut formats = Once(Some(format));
    let [mut nodes, mut elements, mut partitions] = [Once(None); 3];
    // What stands between the sections is text, in a binary file as well.
    while let Some((place, word)) = source.word() {
        match (word, version) {
            (b"$MeshFormat", _) => formats.note("MeshFormat", place)?,
            (b"$Nodes", _) | (b"$ParametricNodes", Version::Two) => {
                let is_parametric = word != b"$Nodes";
                let (section, end) = match is_parametric {
                    false => ("Nodes", "$EndNodes"),
                    true => ("ParametricNodes", "$EndParametricNodes"),
                };
                nodes.note(section, place)?;
                read_section(&mut source, (section, end), |source| match version {
                    Version::Two => version_2::nodes(source, is_parametric, &mut content.nodes),
                    Version::Four => version_4::nodes(source, &mut content.nodes),
                })?;
            }
            (b"$Elements", _) => {
                elements.note("Elements", place)?;
                let name = ("Elements", "$EndElements");
                read_section(&mut source, name, |source| match version {
                    Version::Two => version_2::elements(source, &mut content),
                    Version::Four => version_4::elements(source, &mut content.triangles),
                })?;
            }
            (b"$PartitionedEntities", Version::Four) => {
                partitions.note("PartitionedEntities", place)?;
                let name = ("PartitionedEntities", "$EndPartitionedEntities");
                read_section(&mut source, name, |source| {
                    version_4::partitions(source, &mut content.partitions)
                })?;
            }
            ([b'$', name @ ..], _) => source.skip_section(name)?,
            _ => return Err(Source::unexpected("a section such as $Nodes", word).at(place)),
        }
    }
    let end = source.place();
    for (section, Once(found)) in [("Nodes", nodes), ("Elements", elements)] {
        if found.is_none() {
            return Err(MeshFileProblem::NoSection { section }.at(end));
        }
    }
    content.partitions.check(end)?;
    content.end = Some(end);
    Ok(content)
}

/// Where a section stands of which a file has one.
#[derive(Debug, Clone, Copy)]
struct Once(Option<MeshPlace>);

impl Once {
    /// Refuses the second one.
    fn note(&mut self, section: &'static str, place: MeshPlace) -> Result<(), MeshFileError> {
        match self.0.replace(place) {
            None => Ok(()),
            Some(first) => Err(MeshFileProblem::SecondSection { section, first }.at(place)),
        }
    }
}

/// Reads what stands in a section, and its end. Errors name the section.
fn read_section(
    source: &mut Source<'_>,
    (name, end): (&'static str, &'static str),
    content: impl FnOnce(&mut Source<'_>) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    if source.encoding != Encoding::Text {
        // The byte that ends the line of the section's name: what follows may be binary.
        source.skip_line_end();
    }
    content(source)
        .and_then(|()| source.expect(end))
        .map_err(|error| error.within(name))
}

/// Reads the section that says what format it is, and returns where it stands. Others, such as comments, may
/// stand before it, but none that cannot be read without it.
fn find_format(source: &mut Source<'_>) -> Result<(MeshPlace, Version), MeshFileError> {
    let begin = MeshPlace::Line(1);
    let format = loop {
        match source.word() {
            Some((place, b"$MeshFormat")) => break place,
            Some((place, b"$NOD")) => {
                let version = "1.0".to_owned();
                let binary = false;
                return Err(MeshFileProblem::Version { version, binary }.at(place));
            }
            Some((place, [b'$', name @ ..])) if NEEDS_FORMAT.contains(&name) => {
                let section = String::from_utf8_lossy(name).into_owned();
                return Err(MeshFileProblem::BeforeFormat { section }.at(place));
            }
            Some((_, [b'$', name @ ..])) => {
                let skipped = source.skip_section(name);
                skipped.map_err(|_| MeshFileProblem::NotMsh.at(begin))?;
            }
            _ => return Err(MeshFileProblem::NotMsh.at(begin)),
        }
    };
    let version = read_format(source).map_err(|error| error.within("MeshFormat"))?;
    Ok((format, version))
}

fn read_format(source: &mut Source<'_>) -> Result<Version, MeshFileError> {
    let Some((place, version)) = source.word() else {
        return Err(MeshFileProblem::NotMsh.at(source.place()));
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
    let read = match version.as_str() {
        "2.2" | "2" => Version::Two,
        "4.1" => Version::Four,
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

pub(super) fn read_place(source: &mut Source<'_>) -> Result<Point3<f64>, MeshFileError> {
    let mut at = Point3::origin();
    for value in at.iter_mut() {
        *value = source.double("a coordinate")?;
    }
    Ok(at)
}
