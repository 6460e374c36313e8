//! What figures are made from.

use super::FigureError;
use crate::fem::Mesh;
pub use crate::record::Snapshot;
use crate::record::{Columns, RunMark, ShortNumber};
use crate::scene::{AnchoringKind, Scene};
use crate::scheme::State;
use crate::simulation::Report;
use crate::theory::ShapeAtRest;
use std::collections::HashMap;
use std::sync::Arc;

/// The pictures in a strip.
const PICTURES: usize = 5;

/// All that is drawn of a run. A run that is half done gives what there is.
#[derive(Debug, Clone)]
pub struct RunData {
    /// What its files are called by, such as `case3`.
    pub name: String,
    /// What was simulated.
    pub scene: Arc<Scene>,
    /// What its curves are marked with.
    pub marks: Vec<RunMark>,
    /// The scalars over t.
    pub history: Columns,
    /// The fields at some times, in the order of time.
    pub snapshots: Vec<Snapshot>,
    /// The shape at rest of the membrane alone, to be drawn over each state.
    pub theory: Option<Arc<ShapeAtRest>>,
    /// The command that makes its figures again.
    pub command: String,
}

/// A run as it stands at one time: what the app shows.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// What its files are called by, such as `case3`.
    pub name: &'a str,
    /// What is simulated.
    pub scene: &'a Scene,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// The fields.
    pub state: &'a State,
    /// The step, its time, its scalars.
    pub report: &'a Report,
    /// The field that is shown in colour.
    pub field: Field,
    /// The shape at rest of the membrane alone, to be drawn over it.
    pub theory: Option<&'a ShapeAtRest>,
    /// The command that makes the state again.
    pub command: &'a str,
}

/// A field that can be shown in colour. The contour is that of φ in any case.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Field {
    /// φ.
    #[default]
    Phase,
    /// |d|; φ where there is no director.
    DirectorLength,
    /// ω.
    Bending,
    /// μ.
    Potential,
    /// ε/2 ω², the density of the bending energy, at the nodes and linear between them.
    BendingDensity {
        /// ε.
        interface_width: f64,
    },
}

/// What a run is called on pictures and in the names of files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RunLabel {
    /// In names of files.
    pub file: String,
    /// On pictures.
    pub title: String,
}

impl RunLabel {
    /// That of one run, with the changes of its scene before a time.
    pub fn new(name: &str, scene: &Scene, until: f64) -> RunLabel {
        let mut file = file_name(name);
        let mut title = scene.name.clone();
        if let Some(anchoring) = &scene.anchoring {
            let in_file = in_file(anchoring.kind);
            if !file.contains(in_file) {
                file = format!("{file}-{in_file}");
            }
            title = format!("{title}, {}", in_words(anchoring.kind));
        }
        let count = scene.changes.partition_point(|change| change.at < until);
        for (number, change) in scene.changes[..count].iter().enumerate() {
            if number == CHANGES {
                let more = count - CHANGES;
                file += "-and-so-on";
                title = format!("{title}, and {more} more");
                break;
            }
            let label = change.label();
            file = format!("{file}-{}", file_name(&label.replace([' ', '"'], "")));
            title = format!("{title}, from t = {} {label}", ShortNumber(change.at));
        }
        RunLabel { file, title }
    }

    /// Those of several runs, no two with the same file.
    pub fn of_all<'a>(runs: impl Iterator<Item = (&'a str, &'a Scene)>) -> Vec<RunLabel> {
        let mut times_seen: HashMap<String, u32> = HashMap::new();
        let mut labels: Vec<RunLabel> = Vec::new();
        for (name, scene) in runs {
            let mut label = RunLabel::new(name, scene, f64::INFINITY);
            let plain = label.file.clone();
            let seen = times_seen.entry(plain.clone()).or_insert(0);
            loop {
                *seen += 1;
                if *seen > 1 {
                    label.file = format!("{plain}-{seen}");
                }
                if labels.iter().all(|other| other.file != label.file) {
                    break;
                }
            }
            labels.push(label);
        }
        labels
    }
}

/// A title names at most this number of changes; of more it says how many there are.
const CHANGES: usize = 3;

fn in_file(kind: AnchoringKind) -> &'static str {
    match kind {
        AnchoringKind::None => "none",
        AnchoringKind::Parallel => "parallel",
        AnchoringKind::Homeotropic => "homeotropic",
    }
}

fn in_words(kind: AnchoringKind) -> &'static str {
    match kind {
        AnchoringKind::None => "no anchoring",
        _ => in_file(kind),
    }
}

/// A name that any file system takes: letters, figures, and a few signs.
pub(super) fn file_name(name: &str) -> String {
    let harmless = |c: char| match c {
        c if c.is_alphanumeric() || "-_.+".contains(c) => c,
        _ => '-',
    };
    let name: String = name.chars().map(harmless).take(80).collect();
    match name.trim_matches(['.', '-']) {
        "" => "run".to_owned(),
        name => name.to_owned(),
    }
}

/// Those nearest to t = 0, T/4, T/2, 3T/4, T, where T is the time of the last; all, if there are
/// no more than five.
pub(super) fn five(snapshots: &[Snapshot]) -> Vec<&Snapshot> {
    let Some(last) = snapshots.last().filter(|_| snapshots.len() > PICTURES) else {
        return snapshots.iter().collect();
    };
    let mut chosen: Vec<usize> = (0..PICTURES)
        .filter_map(|quarter| {
            let t = last.t * quarter as f64 / (PICTURES - 1) as f64;
            let distance = |number: &usize| (snapshots[*number].t - t).abs();
            (0..snapshots.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .collect();
    chosen.dedup();
    chosen
        .into_iter()
        .map(|number| &snapshots[number])
        .collect()
}

/// Refuses fields that do not fit the mesh.
pub(super) fn check_fields(
    name: &str,
    mesh: &Mesh,
    state: &State,
    t: f64,
) -> Result<(), FigureError> {
    let nodes = mesh.nodes().len();
    let mut fields = vec![("φ", &state.phi), ("ω", &state.omega), ("μ", &state.mu)];
    if let Some([x, y]) = &state.director {
        fields.extend([("d", x), ("d", y)]);
    }
    match fields.into_iter().find(|(_, values)| values.len() != nodes) {
        Some((field, values)) => Err(FigureError::Mismatch {
            name: name.to_owned(),
            t,
            field,
            found: values.len(),
            nodes,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn snapshots(times: &[f64]) -> Vec<Snapshot> {
        let mesh = Arc::new(Mesh::structured(2, 0.0, 0).expect("a regular mesh"));
        let state = Arc::new(State {
            phi: vec![],
            omega: vec![],
            mu: vec![],
            director: None,
        });
        let snapshot = |(step, t): (usize, &f64)| Snapshot {
            step: step as u64,
            t: *t,
            mesh: mesh.clone(),
            state: state.clone(),
        };
        times.iter().enumerate().map(snapshot).collect()
    }

    #[test]
    fn five_pictures_are_at_the_quarters() {
        let chosen =
            |times: &[f64]| -> Vec<f64> { five(&snapshots(times)).iter().map(|s| s.t).collect() };
        let many: Vec<f64> = (0..=20).map(f64::from).collect();
        assert_eq!(chosen(&many), [0.0, 5.0, 10.0, 15.0, 20.0]);
        assert_eq!(chosen(&many[..12]), [0.0, 3.0, 5.0, 8.0, 11.0]);
        assert_eq!(chosen(&[0.0, 0.3]), [0.0, 0.3]);
        assert!(chosen(&[]).is_empty());
        // Where they lie close together, fewer are enough.
        assert_eq!(chosen(&[0.0, 0.1, 0.2, 0.3, 0.4, 10.0]), [0.0, 0.4, 10.0]);
    }

    #[test]
    fn names_of_files_are_harmless() {
        assert_eq!(file_name("../a b/c:d"), "a-b-c-d");
        assert_eq!(file_name("…/"), "run");
        assert_eq!(file_name("Bläschen-3"), "Bläschen-3");
    }
}
