//! Fields as VTU files, which ParaView and meshio open, and their list in time, a PVD file.
//!
//! The format is VTK's XML for unstructured grids (`UnstructuredGrid`, version 1.0) with each
//! array in place, base64 of its length in bytes (`UInt64`) followed by its values, little-endian
//! and uncompressed: every number is exact. To see that another program reads it:
//!
//! ```text
//! python3 -m venv /tmp/venv && /tmp/venv/bin/pip install meshio
//! /tmp/venv/bin/meshio info runs/case3/final.vtu
//! ```

use super::atomic::write_whole;
use super::{Number, RecordError};
use crate::fem::{Contour, Mesh};
use crate::scene::Geometry;
use crate::scheme::State;
use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use std::f64::consts::TAU;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// VTK's numbers for a triangle and for a quadrangle.
const TRIANGLE: u8 = 5;
const QUADRANGLE: u8 = 9;

/// The array that says that x and y are r and z of a body of rotation.
pub(super) const AXISYMMETRIC: &str = "Axisymmetric";

/// How a file ends.
const END: &str = "</VTKFile>";

/// Writes φ, ω, μ and, where there is one, the director to the file `path`.
///
/// # Errors
/// [`RecordError::Write`].
pub fn write_fields(path: &Path, mesh: &Mesh, state: &State, t: f64) -> Result<(), RecordError> {
    write_whole(path, |file| fields(file, mesh, state, t))
}

/// Writes the surface of a body of rotation in space, the contour φ = 0 at `around` angles about the z axis, to the file `path`.
///
/// # Errors
/// [`RecordError::Write`].
pub fn write_surface(
    path: &Path,
    contour: &Contour,
    around: u32,
    t: f64,
) -> Result<(), RecordError> {
    write_whole(path, |file| surface(file, contour, around, t))
}

/// Writes the list of VTU files with their times to the file `path`.
///
/// # Errors
/// [`RecordError::Write`].
pub fn write_series(path: &Path, snapshots: &[(f64, String)]) -> Result<(), RecordError> {
    write_whole(path, |file| {
        writeln!(file, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            file,
            r#"<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">"#
        )?;
        writeln!(file, "<Collection>")?;
        for (t, name) in snapshots {
            let t = Number(*t);
            writeln!(file, r#"<DataSet timestep="{t}" part="0" file="{name}"/>"#)?;
        }
        writeln!(file, "</Collection>")?;
        writeln!(file, "</VTKFile>")
    })
}

/// Whether a VTU file is there and has its end.
pub(super) fn is_whole(path: &Path) -> bool {
    // A pipe would wait for a writer.
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    is_file && last_bytes(path).is_ok_and(|bytes| bytes.trim_ascii_end().ends_with(END.as_bytes()))
}

fn last_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(64)))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn surface(file: &mut dyn Write, contour: &Contour, around: u32, t: f64) -> io::Result<()> {
    let segments = &contour.segments;
    // Both ends of each segment at each angle, then those of the next segment.
    let places = segments.iter().flat_map(|ends| {
        (0..around).flat_map(move |number| {
            let (sine, cosine) = (TAU * f64::from(number) / f64::from(around)).sin_cos();
            ends.map(move |place| [place.x * cosine, place.x * sine, place.y])
        })
    });
    let ring = i64::from(around);
    let cells = (0..segments.len() as i64).flat_map(|segment| {
        (0..ring).flat_map(move |number| {
            let at = |number: i64, end: i64| 2 * (segment * ring + number % ring) + end;
            [
                at(number, 0),
                at(number + 1, 0),
                at(number + 1, 1),
                at(number, 1),
            ]
        })
    });
    let count = segments.len() * around as usize;
    head(file, t, [2 * count, count], |_| Ok(()))?;
    writeln!(file, "<Points>")?;
    let name = r#"Name="points" NumberOfComponents="3""#;
    array(file, name, places.flatten())?;
    writeln!(file, "</Points>")?;
    writeln!(file, "<Cells>")?;
    array(file, r#"Name="connectivity""#, cells)?;
    let ends = (1..=count).map(|cell| 4 * cell as i64);
    array(file, r#"Name="offsets""#, ends)?;
    array(
        file,
        r#"Name="types""#,
        std::iter::repeat_n(QUADRANGLE, count),
    )?;
    writeln!(file, "</Cells>")?;
    tail(file)
}

/// What a file begins with: its time, what else belongs to all of it, its points and cells.
fn head(
    file: &mut dyn Write,
    t: f64,
    [points, cells]: [usize; 2],
    more: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    writeln!(file, r#"<?xml version="1.0"?>"#)?;
    writeln!(
        file,
        r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#
    )?;
    writeln!(file, "<UnstructuredGrid>")?;
    // ParaView takes the time of a single file from here.
    writeln!(file, "<FieldData>")?;
    array(file, r#"Name="TimeValue" NumberOfTuples="1""#, [t])?;
    more(file)?;
    writeln!(file, "</FieldData>")?;
    writeln!(
        file,
        r#"<Piece NumberOfPoints="{points}" NumberOfCells="{cells}">"#
    )?;
    writeln!(file)
}

/// What it ends with.
fn tail(file: &mut dyn Write) -> io::Result<()> {
    writeln!(file, "</Piece>")?;
    writeln!(file, "</UnstructuredGrid>")?;
    writeln!(file, "{END}")
}

fn fields(file: &mut dyn Write, mesh: &Mesh, state: &State, t: f64) -> io::Result<()> {
    let nodes = mesh.nodes().len();
    let triangles = mesh.triangles().len();
    head(file, t, [nodes, triangles], |file| {
        if mesh.geometry() == Geometry::Planar {
            return Ok(());
        }
        let name = format!(r#"Name="{AXISYMMETRIC}" NumberOfTuples="1""#);
        array(file, &name, [1.0])
    })?;
    writeln!(file, "<Points>")?;
    let places = mesh.outward(mesh.nodes());
    let points = places.iter().flat_map(|place| [place.x, place.y, 0.0]);
    array(file, r#"Name="points" NumberOfComponents="3""#, points)?;
    writeln!(file, "</Points>")?;

    writeln!(file, "<Cells>")?;
    let corners = mesh.triangles().iter().flatten();
    let corners = corners.map(|&node| i64::from(mesh.outer_number(node)));
    array(file, r#"Name="connectivity""#, corners)?;
    let ends = (1..=triangles).map(|triangle| 3 * triangle as i64);
    array(file, r#"Name="offsets""#, ends)?;
    let kinds = std::iter::repeat_n(TRIANGLE, triangles);
    array(file, r#"Name="types""#, kinds)?;
    writeln!(file, "</Cells>")?;

    let vectors = match state.director {
        Some(_) => r#" Vectors="director""#,
        None => "",
    };
    writeln!(file, r#"<PointData Scalars="phi"{vectors}>"#)?;
    for (attributes, field) in [
        (r#"Name="phi""#, &state.phi),
        (r#"Name="omega""#, &state.omega),
        (r#"Name="mu""#, &state.mu),
    ] {
        array(file, attributes, mesh.outward(field).iter().copied())?;
    }
    if let Some(director) = &state.director {
        let [x, y] = director.each_ref().map(|component| mesh.outward(component));
        let vectors = x.iter().zip(y.iter()).flat_map(|(&x, &y)| [x, y, 0.0]);
        array(file, r#"Name="director" NumberOfComponents="3""#, vectors)?;
    }
    writeln!(file, "</PointData>")?;
    writeln!(file)?;
    tail(file)
}

/// A number that VTK has a type for.
trait Value: Copy {
    const VTK_TYPE: &str;
    type Bytes: AsRef<[u8]>;
    fn little_endian(self) -> Self::Bytes;
}

macro_rules! value {
    ($type:ty, $name:literal) => {
        impl Value for $type {
            const VTK_TYPE: &str = $name;
            type Bytes = [u8; size_of::<$type>()];
            fn little_endian(self) -> Self::Bytes {
                self.to_le_bytes()
            }
        }
    };
}
value!(f64, "Float64");
value!(i64, "Int64");
value!(u8, "UInt8");

fn array<V: Value>(
    file: &mut dyn Write,
    attributes: &str,
    values: impl IntoIterator<Item = V>,
) -> io::Result<()> {
    let mut bytes = Vec::new();
    for value in values {
        bytes.extend_from_slice(value.little_endian().as_ref());
    }
    let vtk_type = V::VTK_TYPE;
    writeln!(
        file,
        r#"<DataArray type="{vtk_type}" {attributes} format="binary">"#
    )?;
    let mut encoder = EncoderWriter::new(&mut *file, &STANDARD);
    encoder.write_all(&(bytes.len() as u64).to_le_bytes())?;
    encoder.write_all(&bytes)?;
    encoder.finish()?;
    drop(encoder);
    writeln!(file, "\n</DataArray>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;

    /// The bytes of the array `name`, without the length in front of them.
    fn bytes(text: &str, name: &str) -> Vec<u8> {
        let start = text.find(&format!("Name=\"{name}\"")).expect(name);
        let content = text[start..].lines().nth(1).unwrap();
        let bytes = STANDARD.decode(content).unwrap();
        let (length, bytes) = bytes.split_first_chunk::<8>().unwrap();
        assert_eq!(u64::from_le_bytes(*length), bytes.len() as u64);
        bytes.to_vec()
    }

    fn doubles(text: &str, name: &str) -> Vec<f64> {
        let bytes = bytes(text, name);
        let (chunks, rest) = bytes.as_chunks::<8>();
        assert!(rest.is_empty());
        chunks
            .iter()
            .map(|&chunk| f64::from_le_bytes(chunk))
            .collect()
    }

    fn integers(text: &str, name: &str) -> Vec<i64> {
        doubles(text, name)
            .into_iter()
            .map(|bits| bits.to_bits() as i64)
            .collect()
    }

    fn example(director: Option<[Vec<f64>; 2]>) -> (Mesh, State, String) {
        let mesh = Mesh::structured(2, 0.0, 0).unwrap();
        let nodes = mesh.nodes().len();
        let third = |scale: f64| (0..nodes).map(|n| scale * n as f64 / 3.0).collect();
        let state = State {
            phi: third(1.0),
            omega: third(1e300),
            mu: third(-1e-300),
            director,
        };
        let mut file = Vec::new();
        fields(&mut file, &mesh, &state, 1e-7).unwrap();
        (mesh, state, String::from_utf8(file).unwrap())
    }

    #[test]
    fn every_value_reads_back_bit_for_bit() {
        let director = [vec![0.1; 9], vec![-0.7; 9]];
        let (mesh, state, text) = example(Some(director));
        assert!(text.contains(r#"<Piece NumberOfPoints="9" NumberOfCells="8">"#));
        assert_eq!(doubles(&text, "phi"), state.phi);
        assert_eq!(doubles(&text, "omega"), state.omega);
        assert_eq!(doubles(&text, "mu"), state.mu);
        assert_eq!(doubles(&text, "director"), [0.1, -0.7, 0.0].repeat(9));
        assert_eq!(doubles(&text, "TimeValue"), [1e-7]);
        let points = doubles(&text, "points");
        for (point, node) in points.chunks(3).zip(mesh.nodes()) {
            assert_eq!(point, [node[0], node[1], 0.0]);
        }
        let corners = integers(&text, "connectivity");
        for (corners, triangle) in corners.chunks(3).zip(mesh.triangles()) {
            assert_eq!(corners, triangle.map(i64::from));
        }
        assert_eq!(integers(&text, "offsets"), [3, 6, 9, 12, 15, 18, 21, 24]);
        assert_eq!(bytes(&text, "types"), [TRIANGLE; 8]);
    }

    #[test]
    fn tags_are_closed_in_order() {
        let (_, _, text) = example(None);
        let mut open = Vec::new();
        for line in text.lines().skip(1).filter(|line| line.starts_with('<')) {
            let name = line.trim_matches(['<', '>']).split(' ').next().unwrap();
            match name.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name)),
                None => open.push(name),
            }
        }
        assert!(open.is_empty());
    }

    #[test]
    fn a_scene_without_a_director_has_none_in_the_file() {
        let (_, _, text) = example(None);
        assert!(!text.contains("director"));
    }

    #[test]
    fn the_series_lists_each_file_with_its_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fields.pvd");
        let snapshots = [(0.0, "a.vtu".to_owned()), (2.5e-7, "b.vtu".to_owned())];
        write_series(&path, &snapshots).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains(r#"<DataSet timestep="0" part="0" file="a.vtu"/>"#));
        assert!(text.contains(r#"<DataSet timestep="2.5e-7" part="0" file="b.vtu"/>"#));
    }

    /// A cone's frustum: two rings of radii 1 and 2.
    #[test]
    fn a_surface_is_the_contour_at_every_angle() {
        let contour = Contour {
            segments: vec![[[1.0, 0.0], [2.0, 3.0]].map(Into::into)],
            ..Contour::default()
        };
        let mut file = tempfile::tempfile().expect("a file");
        surface(&mut file, &contour, 4, 0.5).expect("written");
        file.seek(SeekFrom::Start(0)).expect("a file");
        let mut text = String::new();
        file.read_to_string(&mut text).expect("text");
        let points = doubles(&text, "points");
        let points = points.as_chunks::<3>().0;
        assert_eq!(points.len(), 8);
        for [x, y, z] in points {
            let radius = if *z == 0.0 { 1.0 } else { 2.0 };
            assert!((x.hypot(*y) - radius).abs() < 1e-15);
        }
        let corners = bytes(&text, "connectivity");
        let corners = corners
            .as_chunks::<8>()
            .0
            .iter()
            .map(|it| i64::from_le_bytes(*it));
        let corners: Vec<i64> = corners.collect();
        assert_eq!(corners[..4], [0, 2, 3, 1]);
        assert_eq!(corners[12..], [6, 0, 1, 7]);
        assert!(text.contains(r#"NumberOfPoints="8" NumberOfCells="4""#));
    }
}
