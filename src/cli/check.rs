//! `vesica check FILE...`: whether scenes can be run.

use super::error::CliError;
use super::output;
use super::overrides::Overrides;
use super::run::some_step;
use super::scales::scales;
use super::shell::scenes;
use crate::fem::MeshQuality;
use crate::record::{load_scene, step_count};
use crate::scene::{self, Mesh, Scene, Warning, significant};
use crate::simulation::{self, Examination, memory_needed};
use crate::study::{Foresight, MOST_NODES, reservations, run_estimate};
use clap_complete::ArgValueCompleter;
use serde::Serialize;
use std::ffi::{OsStr, OsString};

/// Arguments of `vesica check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A scene is ok when its first step was solved. That and what the run would take is tried for some ten seconds \
at most, and not on meshes of more than 60000 nodes; what was not found out is said.

Exit status: 0 every scene is ok, or well formed where no step was tried; 1 a first step was not solved in the \
time (\"undecided\"); 2 a scene cannot be run, or the arguments are wrong.")]
pub(super) struct Arguments {
    /// Scenes: TOML files or presets
    #[arg(required = true, value_name = "FILE", add = ArgValueCompleter::new(scenes))]
    scenes: Vec<OsString>,

    #[command(flatten)]
    overrides: Overrides,

    /// Try no step: whether the first can be solved and what the run would take is not found out
    #[arg(long)]
    quick: bool,

    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
}

/// What was found out about a scene, for programs.
#[derive(Debug, Default, Serialize)]
struct Verdict {
    /// As it was named.
    scene: String,
    /// "ok", "undecided", "well formed" (no step was tried) or "wrong".
    verdict: &'static str,
    /// Why it is wrong or undecided.
    reason: Option<String>,
    warnings: Vec<String>,
    /// Nodes of the mesh: estimated where the mesh was not made.
    nodes: Option<usize>,
    /// Steps; `null`: they are chosen, and how many was not found out.
    steps: Option<u64>,
    /// Computing time of the run on this machine, where a step was tried.
    seconds: Option<f64>,
    /// Memory that the run needs.
    memory_bytes: Option<u64>,
    /// The least and the greatest angle of a triangle, in degrees, where the mesh was made.
    angles: Option<[f64; 2]>,
    /// The shortest, the mean and the longest edge, where the mesh was made.
    edges: Option<[f64; 3]>,
}

impl Verdict {
    fn new(source: &OsStr, scene: &Scene, found: &Found, foresight: Option<&Foresight>) -> Self {
        let estimate = match foresight {
            Some(Foresight::Price(estimate)) => Some(estimate),
            _ => None,
        };
        let unsolved = match foresight {
            Some(Foresight::Unsolved(unsolved)) => Some(unsolved.to_string()),
            _ => None,
        };
        let quality = found.quality;
        Verdict {
            scene: source.to_string_lossy().into_owned(),
            verdict: match (estimate, &unsolved) {
                (Some(_), _) => "ok",
                (None, Some(_)) => "undecided",
                (None, None) => "well formed",
            },
            reason: unsolved,
            warnings: found.warnings.iter().map(ToString::to_string).collect(),
            nodes: Some(found.nodes),
            steps: estimate.map(|it| it.steps).or(step_count(&scene.time)),
            seconds: estimate.map(|it| it.seconds),
            memory_bytes: Some(estimate.map_or_else(|| memory_needed(scene), |it| it.memory)),
            angles: quality.map(|it| [it.least_angle, it.greatest_angle]),
            edges: quality.map(|it| it.edges),
        }
    }

    fn wrong(source: &OsStr, error: &CliError) -> Self {
        Verdict {
            scene: source.to_string_lossy().into_owned(),
            verdict: "wrong",
            reason: Some(error.to_string()),
            ..Verdict::default()
        }
    }
}

/// Checks every scene, also after one that is wrong.
pub(super) fn check(arguments: &Arguments) -> Result<(), CliError> {
    let (mut wrong, mut undecided) = (0, 0);
    let mut verdicts = Vec::new();
    for source in &arguments.scenes {
        match check_one(source, arguments) {
            Ok((is_decided, verdict)) => {
                undecided += usize::from(!is_decided);
                verdicts.push(verdict);
            }
            Err(error @ CliError::Output(_)) => return Err(error),
            Err(error) => {
                wrong += 1;
                verdicts.push(Verdict::wrong(source, &error));
                match error {
                    _ if arguments.json => {}
                    CliError::Load(_) => output::error(error),
                    _ => output::error(format_args!("{}: {error}", source.display())),
                }
            }
        }
    }
    if arguments.json {
        output::json(&verdicts)?;
    }
    ending(wrong, undecided, arguments.scenes.len())
}

/// Checks a scene; whether all was found out that was tried, and what.
fn check_one(source: &OsStr, arguments: &Arguments) -> Result<(bool, Verdict), CliError> {
    let name = source.display();
    let overrides = arguments.overrides.all();
    let (scene, found) = examine(source, &overrides)?;
    // Before the first step is tried: it may be what is warned of that makes it fail.
    for warning in found.warnings.iter().filter(|_| !arguments.json) {
        output::warning(format_args!("{name}: {warning}"));
    }
    let foresight = match arguments.quick {
        true => None,
        // Nobody is there who might not want to wait: Ctrl-C ends the process.
        false => Some(run_estimate(&scene, &mut || true).map_err(CliError::Foreseen)?),
    };
    let verdict = Verdict::new(source, &scene, &found, foresight.as_ref());
    let is_decided = !matches!(foresight, Some(Foresight::Unsolved(_)));
    if arguments.json {
        return Ok((is_decided, verdict));
    }
    if let (Some(error), Mesh::Adaptive { refine, .. }, Some(tolerance)) = (
        arguments.overrides.accuracy,
        &scene.mesh,
        scene.time.tolerance,
    ) {
        let (edge, band) = (refine.size, refine.band);
        output::line(format_args!(
            "{name}: for an error of {error:e}: mesh.interface = {edge}, mesh.band = {band}, time.tolerance = {tolerance:e}"
        ))?;
    }
    let tried = tried(foresight.as_ref(), &describe(&scene, &found));
    output::line(format_args!("{name}: {tried}"))?;
    if let Some(triangles) = triangles(&scene, &found) {
        output::line(format_args!("{name}: {triangles}"))?;
    }
    for words in &found.scales {
        output::line(format_args!("{name}: {words}"))?;
    }
    let needs = needs(foresight.as_ref(), &scene);
    output::line(format_args!("{name}: {needs}"))?;
    Ok((is_decided, verdict))
}

/// What came out of a scene's first step.
fn tried(foresight: Option<&Foresight>, size: &str) -> String {
    match foresight {
        Some(Foresight::Price(_)) => format!("ok, {size}"),
        Some(Foresight::Unsolved(unsolved)) => {
            format!(
                "undecided, {size}: {unsolved}; whether it can be run was not found out: check it again where nothing else \
                 runs, or run it"
            )
        }
        Some(Foresight::TooLarge(_)) => format!(
            "well formed, {size}; no step was tried, for the mesh has more than {MOST_NODES} nodes"
        ),
        Some(Foresight::Ended) | None => format!("well formed, {size}; no step was tried"),
    }
}

/// What a run needs, as far as it is known: the memory always.
fn needs(foresight: Option<&Foresight>, scene: &Scene) -> String {
    match foresight {
        Some(Foresight::Price(price)) => {
            format!("on this machine {price}{}", reservations(scene))
        }
        _ => format!(
            "about {:.0} MB of memory",
            memory_needed(scene) as f64 / 1e6
        ),
    }
}

/// How a check of `checked` scenes ends: `wrong` of them cannot be run, and the first steps of `undecided` were not
/// solved in the time.
fn ending(wrong: usize, undecided: usize, checked: usize) -> Result<(), CliError> {
    match (wrong, undecided) {
        (0, 0) => Ok(()),
        (0, _) => Err(CliError::Undecided { undecided, checked }),
        _ => Err(CliError::Check { wrong, checked }),
    }
}

/// Loads a scene and goes as far as a run would before its first step.
fn examine(source: &OsStr, overrides: &[String]) -> Result<(Scene, Found), CliError> {
    let scene = load_scene(source, overrides)?.scene;
    some_step(&scene.time)?;
    simulation::check_memory(&scene).map_err(CliError::SetUp)?;
    let found = if nodes(&scene) <= MOST_NODES {
        let Examination {
            warnings,
            nodes,
            quality,
            radius,
            reduced_size,
        } = simulation::examine(&scene).map_err(CliError::SetUp)?;
        Found {
            warnings,
            nodes,
            nodes_are_estimated: false,
            quality: Some(quality),
            scales: scales(&scene, radius, reduced_size),
        }
    } else {
        simulation::check_outlines(&scene).map_err(CliError::SetUp)?;
        let is_estimate = matches!(scene.mesh, Mesh::Delaunay { .. } | Mesh::Adaptive { .. });
        Found {
            warnings: scene::warnings(&scene, None),
            nodes: nodes(&scene),
            nodes_are_estimated: is_estimate,
            quality: None,
            scales: Vec::new(),
        }
    };
    Ok((scene, found))
}

/// What is reported of a scene.
struct Found {
    warnings: Vec<Warning>,
    /// How many there are,
    nodes: usize,
    /// or about.
    nodes_are_estimated: bool,
    /// Ratios of its lengths and times, if the initial state was made.
    scales: Vec<String>,
    /// Of the mesh, if it was made.
    quality: Option<MeshQuality>,
}

/// How good the triangles are, of meshes where that does not follow from the scene.
fn triangles(scene: &Scene, found: &Found) -> Option<String> {
    let quality = found.quality?;
    let turned = match &scene.mesh {
        Mesh::Structured { .. } => return None,
        Mesh::Delaunay { .. } | Mesh::Adaptive { .. } => 0,
        Mesh::File(file) => file.triangulation.turned,
    };
    let [shortest, mean, longest] = quality.edges;
    let mut words = format!(
        "triangles with angles from {}° to {:.1}°, edges from {shortest:.3e} to {longest:.3e}, \
         {mean:.3e} in the mean",
        significant(quality.least_angle, 3),
        quality.greatest_angle,
    );
    if turned > 0 {
        words += &format!("; {turned} were turned round in the file");
    }
    Some(words)
}

/// How many nodes there are, or will be about.
fn nodes(scene: &Scene) -> usize {
    simulation::node_count(scene) as usize
}

fn describe(scene: &Scene, found: &Found) -> String {
    let steps = step_count(&scene.time);
    let about = if found.nodes_are_estimated {
        "about "
    } else {
        ""
    };
    let nodes = format_args!("{about}{}", found.nodes);
    match steps {
        Some(steps) => format!("{nodes} nodes, {steps} steps"),
        None => format!("{nodes} nodes, chosen steps"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Unsolved;

    #[test]
    fn an_undecided_scene_has_a_status_of_its_own_and_its_memory_is_told() {
        let unsolved = Foresight::Unsolved(Unsolved {
            seconds: 12.0,
            underway: None,
        });
        let words = tried(Some(&unsolved), "9 nodes, 3 steps");
        assert!(
            words.starts_with("undecided, 9 nodes, 3 steps: the first step was not solved in 12 s"),
            "{words}"
        );
        let scene = Scene::default();
        let memory = format!(
            "about {:.0} MB of memory",
            memory_needed(&scene) as f64 / 1e6
        );
        for foresight in [
            None,
            Some(unsolved),
            Some(Foresight::TooLarge(70_000)),
            Some(Foresight::Ended),
        ] {
            assert_eq!(needs(foresight.as_ref(), &scene), memory);
        }
        let status = |wrong, undecided| {
            let ended = ending(wrong, undecided, 3);
            ended.map_or_else(|error| error.exit_status(), |()| 0)
        };
        assert_eq!(
            [status(0, 0), status(0, 1), status(2, 1), status(1, 0)],
            [0, 1, 2, 2]
        );
        let mut command = <Arguments as clap::Args>::augment_args(clap::Command::new("check"));
        let help = command.render_long_help().to_string();
        // It is wrapped.
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            help.contains("1 a first step was not solved in the time (\"undecided\")"),
            "{help}"
        );
    }
}
