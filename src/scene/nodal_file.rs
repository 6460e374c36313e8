//! Files of nodal values: a line for each node, its numbers separated by blanks or commas; `#`
//! begins a comment, and empty lines do not count.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use super::error::{Origin, Problem, Quoted, SceneError};
use super::reader::Field;
use super::tables::{Mesh, Scene, tables};

/// Nodal values that were read from a file, one line a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodalValues {
    /// The path as the scene gives it.
    pub path: String,
    /// The values, `columns` of them a node, node by node.
    pub values: Arc<[f64]>,
    /// Values a node: 1 (a scalar) or 2 (a vector).
    pub columns: usize,
}

/// A key of a scene that may name a file of nodal values. It is declared with its parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodalKey {
    /// The key in the scene that names the file.
    pub name: &'static str,
    /// The name that a copy of the file has.
    pub file_name: &'static str,
    /// Values a node.
    pub columns: usize,
}

impl NodalKey {
    /// The key of a file with a number a node.
    pub(super) const fn scalar(name: &'static str, file_name: &'static str) -> Self {
        Self {
            name,
            file_name,
            columns: 1,
        }
    }

    /// The key of a file with a vector a node.
    pub(super) const fn vector(name: &'static str, file_name: &'static str) -> Self {
        Self {
            columns: 2,
            ..Self::scalar(name, file_name)
        }
    }

    /// All that the tables declare.
    pub fn all() -> Vec<Self> {
        let parameters = tables().into_iter().flat_map(|table| table.parameters);
        parameters
            .filter_map(|parameter| parameter.nodal_key)
            .collect()
    }
}

impl Scene {
    /// Every file of nodal values that the scene has.
    pub fn nodal_files(&self) -> Vec<(NodalKey, NodalValues)> {
        let mut scene = self.clone();
        let files = scene.nodal_files_mut().into_iter();
        files.map(|(key, file)| (key, file.clone())).collect()
    }

    /// Every file of nodal values that the scene has, to be changed.
    pub fn nodal_files_mut(&mut self) -> Vec<(NodalKey, &mut NodalValues)> {
        self.tables_mut()
            .flat_map(|table| table.nodal_files())
            .collect()
    }
}

/// The contents of a file, by its path as the scene gives it (relative to the scene's file).
pub(super) type ReadFile<'a> = dyn FnMut(&str) -> io::Result<Vec<u8>> + 'a;

/// What reading a value needs besides the value.
pub(super) struct Context<'a> {
    /// Reads files.
    pub read: &'a mut ReadFile<'a>,
    /// The mesh, whose nodes have values.
    pub mesh: Mesh,
}

impl Context<'_> {
    /// The path that `field` gives, and what its file has.
    pub(super) fn read_file(&mut self, field: &Field<'_>) -> Result<(String, Vec<u8>), SceneError> {
        let path = field.text()?;
        let bytes = (self.read)(path).map_err(|error| unreadable(field, path, &error))?;
        Ok((path.to_owned(), bytes))
    }
}

fn unreadable(field: &Field<'_>, path: &str, error: &io::Error) -> SceneError {
    field.error(Problem::UnreadableFile {
        key: field.path.clone(),
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

/// Reads the file that `field` names.
pub(super) fn read_nodal_values(
    field: &Field<'_>,
    key: NodalKey,
    context: &mut Context<'_>,
) -> Result<NodalValues, SceneError> {
    let (path, bytes) = context.read_file(field)?;
    let text = String::from_utf8(bytes).map_err(|_| {
        let error = io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8");
        unreadable(field, &path, &error)
    })?;
    let wanted = Wanted {
        key: &field.path,
        columns: key.columns,
        mesh: &context.mesh,
    };
    parse(&path, &text, wanted)
}

/// What a file must hold.
#[derive(Debug, Clone, Copy)]
struct Wanted<'a> {
    /// The key that names the file, for messages.
    key: &'a str,
    /// Numbers a line.
    columns: usize,
    /// Whose nodes have the values.
    mesh: &'a Mesh,
}

/// How many lines there must be.
struct Lines {
    /// One of these numbers; empty: any.
    counts: Vec<usize>,
    /// Which mesh that is, for messages.
    mesh: String,
}

impl Lines {
    fn of(mesh: &Mesh) -> Self {
        match mesh {
            Mesh::Structured { cells, .. } => Self {
                counts: vec![(cells + 1) * (cells + 1)],
                mesh: format!("(mesh.cells + 1)² with mesh.cells = {cells}"),
            },
            // Known once the mesh is made.
            Mesh::Delaunay { .. } | Mesh::Adaptive { .. } => Self {
                counts: Vec::new(),
                mesh: String::new(),
            },
            Mesh::File(file) => {
                let (used, all) = (&file.triangulation.nodes, &file.triangulation.places);
                let mut counts = vec![used.len(), all.len()];
                counts.dedup();
                let mesh = match counts[..] {
                    [_, all] => format!(
                        "in the order of {}, without the nodes that no triangle uses (or of all {all})",
                        Quoted(&file.path)
                    ),
                    _ => format!("in the order of {}", Quoted(&file.path)),
                };
                Self { counts, mesh }
            }
        }
    }

    fn most(&self) -> usize {
        self.counts.last().copied().unwrap_or(usize::MAX)
    }
}

/// Reads the `text` of the file `path`.
fn parse(path: &str, text: &str, wanted: Wanted<'_>) -> Result<NodalValues, SceneError> {
    let Wanted { key, columns, mesh } = wanted;
    let lines = Lines::of(mesh);
    let error = |range: Range<usize>, problem| {
        SceneError::new(&Origin::Text(path.to_owned()), text, range, problem)
    };
    let miscounted = |range, found| {
        Err(error(
            range,
            Problem::NodalCount {
                key: key.to_owned(),
                found,
                nodes: lines.counts.first().copied().unwrap_or_default(),
                mesh: lines.mesh.clone(),
            },
        ))
    };
    let unreadable = |range: Range<usize>| {
        let (key, found) = (key.to_owned(), text[range.clone()].to_owned());
        Err(error(
            range,
            Problem::NodalLine {
                key,
                columns,
                found,
            },
        ))
    };

    let mut values = Vec::new();
    // Some editors put a mark of the byte order first.
    let mut start = if text.starts_with('\u{feff}') { 3 } else { 0 };
    for line in text[start..].split_inclusive('\n') {
        let content = line.split('#').next().unwrap_or_default();
        let blanks = content.len() - content.trim_start().len();
        let range = start + blanks..start + blanks + content.trim().len();
        start += line.len();
        if range.is_empty() {
            continue;
        }
        if values.len() / columns == lines.most() {
            return miscounted(range, lines.most() + 1);
        }
        let before = values.len();
        for word in words(&text[range.clone()]) {
            match text[range.start..][word.clone()].parse::<f64>() {
                Ok(value) if value.is_finite() => values.push(value),
                _ => return unreadable(range.start + word.start..range.start + word.end),
            }
        }
        if values.len() != before + columns {
            return unreadable(range);
        }
    }
    let found = values.len() / columns;
    if !lines.counts.is_empty() && !lines.counts.contains(&found) {
        return miscounted(text.len()..text.len(), found);
    }
    if let Mesh::File(file) = mesh
        && found != file.triangulation.nodes.len()
    {
        values = used(&values, columns, &file.triangulation.places);
    }
    Ok(NodalValues {
        path: path.to_owned(),
        values: Arc::from(values),
        columns,
    })
}

/// The values of the nodes that triangles use.
fn used(values: &[f64], columns: usize, places: &[Option<u32>]) -> Vec<f64> {
    let nodes = values.chunks_exact(columns).zip(places);
    let used = nodes.filter(|(_, place)| place.is_some());
    used.flat_map(|(values, _)| values).copied().collect()
}

/// Where the words of a line are.
fn words(line: &str) -> impl Iterator<Item = Range<usize>> {
    let separates = |c: char| c == ',' || c.is_whitespace();
    let mut end = 0;
    line.split_inclusive(separates)
        .map(move |word| {
            let start = end;
            end += word.len();
            start..start + word.trim_end_matches(separates).len()
        })
        .filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    static SMALLEST: Mesh = Mesh::Structured {
        cells: 1,
        jitter: 0.0,
        seed: 1,
    };
    const WANTED: Wanted<'_> = Wanted {
        key: "vesicle.values",
        columns: 1,
        mesh: &SMALLEST,
    };
    const PAIRS: Wanted<'_> = Wanted {
        key: "nematic.initial.values",
        columns: 2,
        mesh: &SMALLEST,
    };

    fn error(text: &str, wanted: Wanted<'_>) -> (usize, usize, Problem) {
        let error = parse("phi0.txt", text, wanted).expect_err(text);
        (error.place.line, error.place.column, *error.problem)
    }

    #[test]
    fn blanks_commas_comments_and_empty_lines() {
        let scalar = parse("a", "# φ\n1\n\n -2.5e-1 # two\r\n3,\n4", WANTED).expect("four nodes");
        assert_eq!(
            (&scalar.values[..], scalar.columns),
            (&[1.0, -0.25, 3.0, 4.0][..], 1)
        );
        let marked = parse("a", "\u{feff}1\n2\n3\n4", WANTED).expect("four nodes");
        assert_eq!(marked.values[0], 1.0);
        let pairs = parse("a", "1 2\n3,4\n5 , 6\n7\t8\n", PAIRS).expect("four nodes");
        assert_eq!(&pairs.values[..], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn a_line_that_does_not_fit_is_named() {
        let line = |columns, found: &str| Problem::NodalLine {
            key: if columns == 1 { WANTED.key } else { PAIRS.key }.to_owned(),
            columns,
            found: found.to_owned(),
        };
        assert_eq!(error("1\n2 x\n3\n4", WANTED), (2, 3, line(1, "x")));
        assert_eq!(error("1\n 2 3\n3\n4", WANTED), (2, 2, line(1, "2 3")));
        assert_eq!(error("1 2\n3 # 4\n", PAIRS), (2, 1, line(2, "3")));
        assert_eq!(error("nan\n", WANTED), (1, 1, line(1, "nan")));
        assert_eq!(error("1e999\n", WANTED), (1, 1, line(1, "1e999")));
    }

    #[test]
    fn the_number_of_nodes_must_be_the_meshes() {
        let count = |found| Problem::NodalCount {
            key: WANTED.key.to_owned(),
            found,
            nodes: 4,
            mesh: "(mesh.cells + 1)² with mesh.cells = 1".to_owned(),
        };
        assert_eq!(error("1\n2\n3\n", WANTED), (4, 1, count(3)));
        assert_eq!(error("1\n2\n3\n4\n5\n6\n", WANTED), (5, 1, count(5)));
        assert_eq!(error("", WANTED), (1, 1, count(0)));
        let text = parse("phi0.txt", "1\n2\n3", WANTED)
            .expect_err("three")
            .to_string();
        assert!(
            text.starts_with("phi0.txt:3:2: vesicle.values must have"),
            "{text}"
        );
    }
    /// A scene with a file for just one of its values.
    fn scene(key: NodalKey) -> Scene {
        let settings = match key.name {
            "vesicle.values" => "vesicle = { shape = 'file', values = 'a.txt' }".to_owned(),
            "nematic.initial.values" => {
                "nematic.initial = { kind = 'file', values = 'a.txt' }".to_owned()
            }
            key => format!("{key} = {{ file = 'a.txt' }}"),
        };
        let text = format!("mesh.cells = 8\n{settings}");
        let line = "0.5 ".repeat(key.columns) + "\n";
        let mut read = |_: &str| Ok(line.repeat(81).into_bytes());
        Scene::parse(&text, "a test", &[], &mut read).expect("a scene")
    }

    #[test]
    fn every_file_is_found_by_its_key() {
        assert_eq!(NodalKey::all().len(), 4);
        for key in NodalKey::all() {
            let files = scene(key).nodal_files();
            let [(found, file)] = &files[..] else {
                panic!("{key:?}: {files:?}");
            };
            assert_eq!(
                (*found, file.columns, &*file.path),
                (key, key.columns, "a.txt")
            );
            assert!(scene(key).to_toml().contains("a.txt"), "{key:?}");
        }
        let none = Scene::parse("", "empty", &[], &mut |_| unreachable!());
        assert!(none.expect("a scene").nodal_files().is_empty());
    }
}
