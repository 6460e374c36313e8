//! Files of nodal values: a line for each node, its numbers separated by blanks or commas; `#`
//! begins a comment, and empty lines do not count.

use std::ops::Range;
use std::sync::Arc;

use super::error::{Origin, Problem, Quoted, SceneError};
use super::model::{Mesh, NodalValues};

/// What a file must hold.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// The key that names the file, for messages.
    pub key: &'a str,
    /// Numbers a line.
    pub columns: usize,
    /// Whose nodes have the values.
    pub mesh: &'a Mesh,
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
            Mesh::Delaunay { .. } => Self {
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
pub(super) fn parse(path: &str, text: &str, wanted: Wanted<'_>) -> Result<NodalValues, SceneError> {
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
}
