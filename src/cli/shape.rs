//! `vesica shape SCENE`: the shape at rest that theory foresees.

use super::error::CliError;
use super::figures::quoted;
use super::output;
use super::picture_size::PictureSize;
use super::set_up::{Outcome, set_up};
use super::signals::EndSignal;
use crate::figure::{Existing, FigureOptions, View, save_shape};
use crate::geometry::{BoundingBox, Point};
use crate::record::load_scene;
use crate::scene::{Scene, Timetable};
use crate::simulation::{Simulation, check_memory, check_outlines, outline_beside, shape_at_rest};
use crate::theory::{BodyAtRest, Branch, CurveAtRest, MEMBRANE_FACTOR, ShapeAtRest};
use std::ffi::OsString;
use std::path::PathBuf;

/// Arguments of `vesica shape`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The shape is a closed elastica: the curve of least bending energy about the area of the vesicle, as long as the penalty of \
the membrane's area has it. By rotation it is a surface on the branch that the initial shape is like: prolate, oblate or \
stomatocyte. It is the limit of ε → 0 for the membrane alone: nematic, anchoring, fields and noise are left out. The area (the \
volume) and the membrane at the start are those of the initial state on the mesh of the scene; parameters that change have \
their last values.")]
pub(super) struct Arguments {
    /// A preset's name (see `vesica presets`) or a TOML file
    scene: OsString,

    /// Override a value of the scene, such as area.target=1.1
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    /// Write the outline as CSV and a figure into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    size: PictureSize,

    /// Replace the files that the folder holds
    #[arg(long, requires = "out")]
    force: bool,
}

/// Solves for the shape and prints it.
pub(super) fn shape(arguments: &Arguments) -> Result<(), CliError> {
    let loaded = load_scene(&arguments.scene, &arguments.set)?;
    let scene = &loaded.scene;
    check_memory(scene).map_err(CliError::SetUp)?;
    check_outlines(scene).map_err(CliError::SetUp)?;
    let signal = EndSignal::listen()?;
    let simulation = match set_up(scene, &signal)? {
        Outcome::Ready(simulation) => simulation,
        Outcome::Signal(signal) => {
            return Err(CliError::StudyEnded {
                signal: signal.name,
                number: signal.number,
            });
        }
        Outcome::Failed(error) => return Err(CliError::SetUp(error)),
    };
    let (mesh, report) = (simulation.mesh(), simulation.report());
    let start = [report.phase_integral, report.surface_area];
    let at_end = Scene {
        name: scene.name.clone(),
        ..Timetable::of(scene).at(scene.time.end)
    };
    simulation.warnings().iter().for_each(output::warning);
    let shape = shape_at_rest(&at_end, (mesh, &simulation.state().phi), start)?;
    let outline = outline_beside(&shape, mesh, &simulation.state().phi);
    let domain = mesh.section_box();
    if domain.union(&BoundingBox::around(&outline)) != domain {
        output::warning("the shape at rest does not fit into the domain");
    }
    output::print(&description(&at_end, &shape))?;
    if let Some(folder) = &arguments.out {
        let name = loaded.name.to_string_lossy();
        save(arguments, &name, &simulation, (&shape, &outline), folder)?;
    }
    Ok(())
}

/// The numbers of the shape, one a line.
fn description(scene: &Scene, shape: &ShapeAtRest) -> String {
    let mut text = format!(
        "{}: the shape at rest of the membrane alone (ε → 0)\n\n",
        scene.name
    );
    let mut line = |words: &str, value: f64, note: &str| {
        let note = if note.is_empty() {
            String::new()
        } else {
            format!("   {note}")
        };
        text += &format!("{words:<22}{value:>11.6}{note}\n");
    };
    match shape {
        ShapeAtRest::Curve(curve) => describe_curve(curve, &mut line),
        ShapeAtRest::Body(body) => describe_body(body, &mut line),
    }
    let (bending, [stretching, tension], surface_area) = match shape {
        ShapeAtRest::Curve(it) => (
            (it.bending, "c/2 ∫κ² ds"),
            [it.stretching, it.tension],
            MEMBRANE_FACTOR * it.perimeter,
        ),
        ShapeAtRest::Body(it) => (
            (it.bending, "c/2 ∫(2H)² dS"),
            [it.stretching, it.tension],
            MEMBRANE_FACTOR * it.surface_area(),
        ),
    };
    line("E_bending", bending.0, bending.1);
    if let Some(area) = scene.area {
        line("E_area", stretching, "(B − β)²/(2η)");
        let strain = tension / MEMBRANE_FACTOR * area.penalty / surface_area;
        line("tension σ", tension, &tension_note(strain));
    } else {
        line("tension σ", 0.0, "the area is free");
    }
    let left_out: Vec<&str> = scene.effects().filter(|name| *name != "area").collect();
    if !left_out.is_empty() {
        text += &format!("\nleft out: {}\n", left_out.join(", "));
    }
    text
}

/// The numbers that only a curve has.
fn describe_curve(shape: &CurveAtRest, line: &mut impl FnMut(&str, f64, &str)) {
    let elastica = &shape.elastica;
    let [length, waist, width] = shape.extents();
    line("length", length, "along the long axis");
    line("waist", waist, "across, half way along");
    line("width", width, "the greatest across");
    line("area inside A", shape.enclosed, "(|Ω| + ∫φ)/2");
    line("perimeter L", shape.perimeter, "B/c, c = 2√2/3");
    line(
        "reduced area",
        elastica.reduced_area,
        "4πA/L²: 1 for a circle",
    );
    line("Ê", elastica.energy, "½∫κ² ds · L/(2π²): 1 for a circle");
}

/// The numbers that only a body of rotation has.
fn describe_body(body: &BodyAtRest, line: &mut impl FnMut(&str, f64, &str)) {
    let [height, diameter] = body.extents();
    let v = body.surface.reduced_volume;
    let kind = match v {
        1.0 => "a sphere".to_owned(),
        _ => format!("{}, from pole to pole", body.branch.name()),
    };
    line("height on the axis", height, &kind);
    line("diameter", diameter, "of the equator");
    line("volume inside V", body.enclosed, "(|Ω| + ∫φ)/2");
    line("surface S", body.surface_area(), "B/c, c = 2√2/3");
    line(
        "reduced volume v",
        v,
        "3V/(4πR₀³), S = 4πR₀²: 1 for a sphere",
    );
    line("W", body.surface.energy, "½∫(2H)² dS / 8π: 1 for a sphere");
    for branch in Branch::ALL.into_iter().filter(|it| *it != body.branch) {
        if let Ok(other) = branch.surface(v) {
            line("", other.energy, &format!("{} at this v", branch.name()));
        }
    }
}

/// What the tension means: by how much the membrane is longer than β has it.
fn tension_note(strain: f64) -> String {
    let words = if strain < 0.0 { "smaller" } else { "larger" };
    format!(
        "c(B − β)/η: the membrane is {:.2} % {words} than its target",
        100.0 * strain.abs()
    )
}

/// Writes the outline and the figure.
fn save(
    arguments: &Arguments,
    name: &str,
    simulation: &Simulation,
    (shape, outline): (&ShapeAtRest, &[Point]),
    folder: &std::path::Path,
) -> Result<(), CliError> {
    let state = simulation.state();
    let mut command = format!(
        "vesica shape {}",
        quoted(&arguments.scene.to_string_lossy())
    );
    for set in &arguments.set {
        command += &format!(" --set {}", quoted(set));
    }
    let view = View {
        name,
        scene: simulation.scene(),
        mesh: simulation.mesh(),
        state,
        report: simulation.report(),
        field: Default::default(),
        theory: Some(shape),
        command: &command,
    };
    let options = FigureOptions {
        existing: if arguments.force {
            Existing::Replace
        } else {
            Existing::Refuse
        },
        ..arguments.size.options()
    };
    let files = save_shape(&view, outline, &options, folder)?;
    let names: Vec<String> = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    output::summary(format_args!("\n{}", names.join("\n")))
}
