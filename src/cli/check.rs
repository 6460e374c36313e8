//! `vesica check FILE...`: whether scenes can be run.

use super::error::CliError;
use super::output;
use super::overrides::Overrides;
use super::run::some_step;
use super::scales::scales;
use crate::fem::MeshQuality;
use crate::record::{load_scene, step_count};
use crate::scene::{self, Mesh, Scene, Warning, significant};
use crate::simulation::{self, Examination, memory_needed};
use crate::study::{Foresight, MOST_NODES, run_estimate};
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
    #[arg(required = true, value_name = "FILE")]
    scenes: Vec<OsString>,

    #[command(flatten)]
    overrides: Overrides,

    /// Try no step: whether the first can be solved and what the run would take is not found out
    #[arg(long)]
    quick: bool,
}

/// Checks every scene, also after one that is wrong.
pub(super) fn check(arguments: &Arguments) -> Result<(), CliError> {
    let (mut wrong, mut undecided) = (0, 0);
    for source in &arguments.scenes {
        match check_one(source, arguments) {
            Ok(true) => {}
            Ok(false) => undecided += 1,
            Err(error @ CliError::Output(_)) => return Err(error),
            Err(error) => {
                wrong += 1;
                match error {
                    CliError::Load(_) => output::error(error),
                    _ => output::error(format_args!("{}: {error}", source.display())),
                }
            }
        }
    }
    ending(wrong, undecided, arguments.scenes.len())
}

/// Checks a scene; whether all was found out that was tried.
fn check_one(source: &OsStr, arguments: &Arguments) -> Result<bool, CliError> {
    let name = source.display();
    let overrides = arguments.overrides.all();
    let (scene, found) = examine(source, &overrides)?;
    // Before the first step is tried: it may be what is warned of that makes it fail.
    for warning in &found.warnings {
        output::warning(format_args!("{name}: {warning}"));
    }
    let foresight = match arguments.quick {
        true => None,
        // Nobody is there who might not want to wait: Ctrl-C ends the process.
        false => Some(run_estimate(&scene, &mut || true).map_err(CliError::Foreseen)?),
    };
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
    Ok(!matches!(foresight, Some(Foresight::Unsolved(_))))
}

/// What came out of a scene's first step.
fn tried(foresight: Option<&Foresight>, size: &str) -> String {
    match foresight {
        Some(Foresight::Price(_)) => format!("ok, {size}"),
        Some(Foresight::Unsolved(unsolved)) => {
            format!("undecided, {size}: {unsolved}; whether it can be run was not found out")
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
        Some(Foresight::Price(price)) => format!("on this machine {price}"),
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
            enclosed,
            reduced_area,
        } = simulation::examine(&scene).map_err(CliError::SetUp)?;
        Found {
            warnings,
            nodes: nodes.to_string(),
            quality: Some(quality),
            scales: scales(&scene, enclosed, reduced_area),
        }
    } else {
        simulation::check_outlines(&scene).map_err(CliError::SetUp)?;
        let is_estimate = matches!(scene.mesh, Mesh::Delaunay { .. } | Mesh::Adaptive { .. });
        Found {
            warnings: scene::warnings(&scene, None),
            nodes: format!(
                "{}{}",
                if is_estimate { "about " } else { "" },
                nodes(&scene)
            ),
            quality: None,
            scales: Vec::new(),
        }
    };
    Ok((scene, found))
}

/// What is reported of a scene.
struct Found {
    warnings: Vec<Warning>,
    /// How many there are, in words.
    nodes: String,
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
    let nodes = &found.nodes;
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
