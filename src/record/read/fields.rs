//! The fields of a VTU file, as this program writes it.

use super::super::bounded_read::read_file_text;
use super::super::vtu::AXISYMMETRIC;
use super::{LARGEST, ReadError, WrongArray};
use crate::fem::Mesh;
use crate::geometry::Point;
use crate::scene::Geometry;
use crate::scheme::State;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use roxmltree::{Document, Node};
use std::path::Path;

/// What a VTU file holds.
#[derive(Debug, Clone)]
pub struct StoredFields {
    /// The mesh.
    pub mesh: Mesh,
    /// The fields.
    pub state: State,
    /// Their time.
    pub t: f64,
}

/// Reads the fields of a VTU file.
///
/// # Errors
/// `ReadError`: which file, which array, and what is wrong with it.
pub fn read_fields(path: &Path) -> Result<StoredFields, ReadError> {
    let text = read_file_text(path, LARGEST).map_err(|reason| ReadError::Unreadable {
        path: path.to_owned(),
        reason,
    })?;
    let document = Document::parse(&text).map_err(|reason| ReadError::Xml {
        path: path.to_owned(),
        reason,
    })?;
    let arrays = Arrays {
        document: &document,
        path,
    };
    let points = arrays.doubles("points", None)?;
    let nodes: Vec<Point> = points
        .chunks_exact(3)
        .map(|point| Point::new(point[0], point[1]))
        .collect();
    let triangles = triangles(&arrays, nodes.len())?;
    let scalar = |name| arrays.doubles(name, Some(nodes.len()));
    let state = State {
        phi: scalar("phi")?,
        omega: scalar("omega")?,
        mu: scalar("mu")?,
        director: match arrays.find("director") {
            None => None,
            Some(_) => {
                let vectors = arrays.doubles("director", Some(3 * nodes.len()))?;
                let part = |axis: usize| vectors.chunks_exact(3).map(|d| d[axis]).collect();
                Some([part(0), part(1)])
            }
        },
    };
    let time = arrays.doubles("TimeValue", Some(1))?;
    let mesh = Mesh::new(nodes, triangles).map_err(|reason| ReadError::Mesh {
        path: path.to_owned(),
        reason,
    })?;
    let geometry = match arrays.find(AXISYMMETRIC) {
        Some(_) => Geometry::Axisymmetric,
        None => Geometry::Planar,
    };
    Ok(StoredFields {
        mesh: mesh.in_geometry(geometry),
        state,
        t: time.first().copied().unwrap_or(f64::NAN),
    })
}

fn triangles(arrays: &Arrays, nodes: usize) -> Result<Vec<[u32; 3]>, ReadError> {
    let name = "connectivity";
    let corners = arrays.integers(name)?;
    // The offsets say where each cell ends: of triangles, after every third corner.
    let offsets = arrays.integers("offsets")?;
    let is_triangle = |(number, end): (usize, &i64)| *end == 3 * (number as i64 + 1);
    if 3 * offsets.len() != corners.len() || !offsets.iter().enumerate().all(is_triangle) {
        return Err(arrays.wrong("offsets", WrongArray::NotTriangles));
    }
    let node = |&node: &i64| {
        u32::try_from(node)
            .ok()
            .filter(|&number| (number as usize) < nodes)
            .ok_or_else(|| arrays.wrong(name, WrongArray::Node { node, nodes }))
    };
    corners
        .chunks_exact(3)
        .map(|cell| Ok([node(&cell[0])?, node(&cell[1])?, node(&cell[2])?]))
        .collect()
}

struct Arrays<'a> {
    document: &'a Document<'a>,
    path: &'a Path,
}

impl<'a> Arrays<'a> {
    fn wrong(&self, array: &'static str, problem: WrongArray) -> ReadError {
        ReadError::Array {
            path: self.path.to_owned(),
            array,
            problem,
        }
    }

    fn find(&self, name: &str) -> Option<Node<'a, 'a>> {
        self.document
            .descendants()
            .find(|node| node.has_tag_name("DataArray") && node.attribute("Name") == Some(name))
    }

    /// The eight bytes of each value of an array: as many values as are expected, if that is known.
    fn values(
        &self,
        name: &'static str,
        vtk_type: &'static str,
        expected: Option<usize>,
    ) -> Result<Vec<[u8; 8]>, ReadError> {
        let wrong = |problem| self.wrong(name, problem);
        let array = self.find(name).ok_or_else(|| wrong(WrongArray::Missing))?;
        if array.attribute("type") != Some(vtk_type) || array.attribute("format") != Some("binary")
        {
            return Err(wrong(WrongArray::Stored(vtk_type)));
        }
        let bytes = STANDARD
            .decode(array.text().unwrap_or_default().trim())
            .map_err(|reason| wrong(reason.into()))?;
        let Some((length, bytes)) = bytes.split_first_chunk::<8>() else {
            let (found, expected) = (bytes.len(), 8);
            return Err(wrong(WrongArray::Length { found, expected }));
        };
        let told = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let expected = expected.map_or(told, |values| 8 * values);
        let (values, rest) = bytes.as_chunks::<8>();
        if bytes.len() != expected || told != expected || !rest.is_empty() {
            let found = bytes.len();
            return Err(wrong(WrongArray::Length { found, expected }));
        }
        Ok(values.to_vec())
    }

    fn doubles(&self, name: &'static str, expected: Option<usize>) -> Result<Vec<f64>, ReadError> {
        let values = self.values(name, "Float64", expected)?;
        Ok(values.into_iter().map(f64::from_le_bytes).collect())
    }

    fn integers(&self, name: &'static str) -> Result<Vec<i64>, ReadError> {
        let values = self.values(name, "Int64", None)?;
        Ok(values.into_iter().map(i64::from_le_bytes).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::vtu::write_fields;
    use super::*;
    use std::fs;

    fn example(director: bool) -> (Mesh, State) {
        let mesh = Mesh::structured(3, 0.1, 5).expect("a fair mesh");
        let nodes = mesh.nodes().len();
        let third =
            |scale: f64| -> Vec<f64> { (0..nodes).map(|n| scale * n as f64 / 3.0).collect() };
        let state = State {
            phi: third(1.0),
            omega: third(1e300),
            mu: third(-1e-300),
            director: director.then(|| [third(0.1), third(-0.7)]),
        };
        (mesh, state)
    }

    fn written(director: bool) -> (Mesh, State, String) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.vtu");
        let (mesh, state) = example(director);
        write_fields(&path, &mesh, &state, 2.5e-7).expect("it is written");
        let text = fs::read_to_string(path).expect("it is there");
        (mesh, state, text)
    }

    fn read(text: &str) -> Result<StoredFields, ReadError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.vtu");
        fs::write(&path, text).expect("it is written");
        read_fields(&path)
    }

    #[test]
    fn what_was_written_reads_back_exactly() {
        for director in [false, true] {
            let (mesh, state, text) = written(director);
            let stored = read(&text).expect("it reads back");
            assert_eq!(stored.state, state);
            assert_eq!(stored.mesh.nodes(), mesh.nodes());
            assert_eq!(stored.mesh.triangles(), mesh.triangles());
            assert_eq!(stored.t, 2.5e-7);
        }
    }

    #[test]
    fn damage_is_told_with_file_and_array() {
        let (_, _, text) = written(true);
        let error = |text: &str| read(text).expect_err("damaged").to_string();
        for (damaged, part) in [
            (text[..text.len() / 2].to_owned(), "is not XML"),
            (String::new(), "is not XML"),
            ("<a/>".to_owned(), "the array points is missing"),
            (text.replace("Name=\"mu\"", "Name=\"nu\""), "mu is missing"),
            (
                text.replace("Float64", "Float32"),
                "points is not stored as Float64",
            ),
            (
                text.replace("format=\"binary\"", "format=\"ascii\""),
                "is not stored as",
            ),
            (text.replacen("AAAA", "A?AA", 1), "is not base64"),
        ] {
            let error = error(&damaged);
            assert!(error.contains(part) && error.contains("a.vtu"), "{error}");
        }
    }

    #[test]
    fn an_array_of_another_length_or_with_a_wrong_node_is_an_error() {
        let (_, _, text) = written(false);
        let encode = |values: &[u64]| {
            let mut bytes = (8 * values.len() as u64).to_le_bytes().to_vec();
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            STANDARD.encode(bytes)
        };
        let replaced = |name: &str, content: &str| {
            let start = text.find(&format!("Name=\"{name}\"")).expect("it is there");
            let begin = start + text[start..].find('\n').expect("a line") + 1;
            let end = begin + text[begin..].find('\n').expect("a line");
            format!("{}{content}{}", &text[..begin], &text[end..])
        };
        let error = |text: String| read(&text).expect_err("damaged").to_string();
        let short = error(replaced("phi", &encode(&[0; 15])));
        assert!(short.contains("phi has 120 bytes where 128"), "{short}");
        let mut corners = vec![0; 54];
        corners[7] = 16;
        let node = error(replaced("connectivity", &encode(&corners)));
        assert!(
            node.contains("names the node 16, and there are 16"),
            "{node}"
        );
        corners[7] = 0;
        let flat = error(replaced("connectivity", &encode(&corners)));
        assert!(flat.contains("signed area"), "{flat}");
        let cells = error(replaced("offsets", &encode(&[4; 18])));
        assert!(cells.contains("no triangles"), "{cells}");
        assert!(error(replaced("mu", "AAA=")).contains("mu has 2 bytes"));
    }
}
