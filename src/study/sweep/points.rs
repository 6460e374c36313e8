//! The points of a plan, each with its complete scene.

use super::error::{PointError, PointProblem, SweepError};
use super::plan::{Assignment, Plan, Repeat};
use crate::record::{LARGEST_INPUT, read_bytes, scene_identity, step_count};
use crate::scene::{Boundary, Geometry, Mesh, Problem, Scene, SceneError, Solver, Time, Vesicle};
use crate::simulation::{check_memory, check_outlines, memory_held, node_count};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Points of a sweep, at most.
pub const MOST_POINTS: usize = 100_000;

/// A scene to be simulated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Point {
    /// From 1.
    pub number: usize,
    /// Of its folder: the number and a checksum over the complete scene.
    pub name: String,
    /// What the plan says of it, seeds included.
    pub assignments: Vec<Assignment>,
    /// The value of each varied key, as TOML; of one that the plan does not set here, the scene's own.
    pub values: Vec<String>,
    /// Which repetition it is, from 1; 0 where there are none.
    pub repetition: u64,
    /// The number of an earlier point that is the same scene; it is run once.
    pub same_as: Option<usize>,
}

/// Where the scene of a sweep is from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The scene with what [`Plan::set`] says, complete.
    pub text: String,
    /// The folders to which paths in it are relative, the first that has the file.
    pub folders: Vec<PathBuf>,
}

impl Origin {
    /// The scene of a point.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn scene(&self, assignments: &[Assignment]) -> Result<Scene, SceneError> {
        let overrides: Vec<String> = assignments.iter().map(Assignment::argument).collect();
        Scene::parse(&self.text, "the plan's scene", &overrides, &mut |path| {
            // The last one is where the plan's scene was: its path is the one to report.
            let mut place = PathBuf::from(path);
            for folder in &self.folders {
                place = folder.join(path);
                if place.exists() {
                    break;
                }
            }
            read_bytes(&place, LARGEST_INPUT)
        })
    }
}

/// The points of a plan, every one checked, with what each needs; how long it takes is not known yet.
///
/// # Errors
/// [`SweepError::Points`] with all that is wrong; `Plan` where there are too many, or no seeds to repeat them with.
pub fn points(plan: &Plan, origin: &Origin) -> Result<(Vec<Point>, Vec<Needs>), SweepError> {
    let count = plan.count();
    if count > MOST_POINTS {
        let most = MOST_POINTS;
        let problem = Problem::TooManyPoints { count, most };
        let repeats = plan.repeat.as_ref().map_or(1, |it| it.count as usize);
        // What makes them too many.
        let key = match (count / repeats > most, plan.axes.is_empty()) {
            (false, _) => "repeat",
            (true, false) => "vary",
            (true, true) => "point",
        };
        return Err(plan.error_at(key, problem).into());
    }
    let keys = plan.varied_keys();
    let mut points: Vec<Point> = Vec::with_capacity(count);
    let mut all_needs = Vec::with_capacity(count);
    let mut errors = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut sizes = Sizes::default();
    for combination in plan.combinations() {
        for (repetition, assignments) in repetitions(plan, origin, &combination, points.len() + 1)?
        {
            let number = points.len() + errors.len() + 1;
            let (scene, needs) = match checked(origin, &assignments, &mut sizes) {
                Ok(checked) => checked,
                Err(reason) => {
                    errors.push(PointError {
                        number,
                        values: assignments,
                        reason,
                    });
                    continue;
                }
            };
            let text = identity(&scene);
            let name = name(number, &text);
            let complete = scene.to_toml();
            let value = |key: &String| {
                let set = assignments.iter().rev().find(|it| it.key == *key);
                set.map_or_else(|| value_in(&complete, key), |set| one_line(&set.value))
            };
            points.push(Point {
                number,
                name,
                values: keys.iter().map(value).collect(),
                assignments,
                repetition,
                same_as: known.get(&text).copied(),
            });
            known.entry(text).or_insert(number);
            all_needs.push(needs);
        }
    }
    match errors.is_empty() {
        true => Ok((points, all_needs)),
        false => Err(SweepError::Points {
            points: points.len() + errors.len(),
            errors,
        }),
    }
}

/// The same assignments with each seed.
fn repetitions(
    plan: &Plan,
    origin: &Origin,
    assignments: &[Assignment],
    point: usize,
) -> Result<Vec<(u64, Vec<Assignment>)>, SweepError> {
    let Some(Repeat {
        count,
        seeds,
        first,
    }) = &plan.repeat
    else {
        return Ok(vec![(0, assignments.to_vec())]);
    };
    let mut seeds = seeds.clone();
    // A scene that is wrong has no seeds that are known. It is reported as wrong, with what the plan says of it.
    if seeds.is_empty()
        && let Ok(scene) = origin.scene(assignments)
    {
        seeds = seeds_of(&scene);
        if seeds.is_empty() {
            let count = *count;
            let problem = Problem::NoSeed { point, count };
            return Err(plan.error_at("repeat", problem).into());
        }
    }
    let with_seed = |number: u64| {
        let seed = |key: &String| Assignment {
            key: key.clone(),
            value: (first + number).to_string(),
        };
        let all = assignments.iter().cloned().chain(seeds.iter().map(seed));
        (number + 1, all.collect())
    };
    Ok((0..*count).map(with_seed).collect())
}

/// The keys of all seeds of a scene that make a difference.
fn seeds_of(scene: &Scene) -> Vec<String> {
    fn collect(table: &toml::Table, path: &str, found: &mut Vec<String>) {
        for (key, value) in table {
            let path = match path {
                "" => key.clone(),
                path => format!("{path}.{key}"),
            };
            match value {
                toml::Value::Table(table) => collect(table, &path, found),
                toml::Value::Integer(_) if key == "seed" => found.push(path),
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    if let Ok(table) = scene.to_toml().parse() {
        collect(&table, "", &mut found);
    }
    if matches!(scene.mesh, Mesh::Structured { jitter: 0.0, .. }) {
        found.retain(|key| key != "mesh.seed");
    }
    found
}

/// The value of a key in a complete scene, as TOML; empty where it has none.
fn value_in(text: &str, key: &str) -> String {
    let Ok(table) = text.parse::<toml::Table>() else {
        return String::new();
    };
    let mut value = toml::Value::Table(table);
    for part in key.split('.') {
        match value {
            toml::Value::Table(mut table) => match table.remove(part) {
                Some(inner) => value = inner,
                None => return String::new(),
            },
            _ => return String::new(),
        }
    }
    match value {
        toml::Value::Table(_) => "{ … }".to_owned(),
        toml::Value::Float(number) => crate::record::Number(number).to_string(),
        value => value.to_string(),
    }
}

/// A value on one line.
fn one_line(value: &str) -> String {
    value.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The scene of a point, if it can be run, and what it needs.
fn checked(
    origin: &Origin,
    assignments: &[Assignment],
    sizes: &mut Sizes,
) -> Result<(Scene, Needs), PointProblem> {
    let scene = origin.scene(assignments).map_err(PointProblem::Scene)?;
    let needs = sizes.check(&scene)?;
    Ok((scene, needs))
}

/// What a point is predicted to take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Needs {
    /// Seconds of computing; `None`: not known.
    pub seconds: Option<f64>,
    /// Bytes, whichever way the run turns.
    pub memory: u64,
    /// Its size beside others, if nothing else is known: nodes times steps, with some forty of those that are
    /// chosen.
    pub work: f64,
}

/// What decides about the size of a run, and whether it can be set up: of most points it is the same.
#[derive(Debug, PartialEq)]
struct Size {
    mesh: Mesh,
    vesicle: Vesicle,
    time: Time,
    solver: Solver,
    geometry: Geometry,
    boundary: Boundary,
    has_director: bool,
}

/// The sizes that passed: counting the nodes of a mesh that is yet to be made takes its time.
#[derive(Default)]
struct Sizes {
    passed: Vec<(Size, Needs)>,
}

/// So many are kept: comparing with more takes longer than checking.
const KEPT_SIZES: usize = 16;

/// About the number of steps of a run that chooses them.
const CHOSEN_STEPS: u64 = 40;

impl Sizes {
    fn check(&mut self, scene: &Scene) -> Result<Needs, PointProblem> {
        let size = Size {
            mesh: scene.mesh.clone(),
            vesicle: scene.vesicle.clone(),
            time: scene.time,
            solver: scene.solver,
            geometry: scene.geometry,
            boundary: scene.boundary,
            has_director: scene.nematic.is_some(),
        };
        if let Some((_, needs)) = self.passed.iter().find(|(other, _)| *other == size) {
            return Ok(*needs);
        }
        let steps = step_count(&scene.time);
        if steps == Some(0) {
            let (end, step) = (scene.time.end, scene.time.step);
            return Err(PointProblem::NoStep { end, step });
        }
        check_memory(scene).map_err(PointProblem::SetUp)?;
        check_outlines(scene).map_err(PointProblem::SetUp)?;
        let needs = Needs {
            seconds: None,
            memory: memory_held(scene, true),
            work: node_count(scene) * steps.unwrap_or(CHOSEN_STEPS) as f64,
        };
        if self.passed.len() < KEPT_SIZES {
            self.passed.push((size, needs));
        }
        Ok(needs)
    }
}

/// A text by which a scene is known. The end counts as well, which the identity of a run leaves out.
pub(super) fn identity(scene: &Scene) -> String {
    format!("{}# end {:?}\n", scene_identity(scene), scene.time.end)
}

/// Of a point's folder: its number, and 24 bits of a checksum over the complete scene.
pub(super) fn name(number: usize, identity: &str) -> String {
    format!(
        "{number:04}-{:06x}",
        crc32fast::hash(identity.as_bytes()) >> 8
    )
}

/// The folder of a path, for what is relative to it.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    let parent = path.parent().unwrap_or(Path::new(""));
    std::path::absolute(parent).unwrap_or_else(|_| parent.to_owned())
}
