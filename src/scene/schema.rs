//! The tables of a scene, from TOML to a [`Scene`].

use std::sync::Arc;

use super::document;
use super::error::{Problem, SceneError};
use super::expression::Expression;
use super::keys;
use super::keywords::{
    ANCHORINGS, BOUNDARIES, ITERATIONS, LINEAR_METHODS, Names, QUADRATURES, name_of,
};
use super::mesh_file::{MeshFile, Triangulation};
use super::model as scene;
use super::model::{
    Anchoring, AnchoringKind, Area, Boundary, Defect, InitialDirector, LinearMethod, Membrane,
    Mesh, Nematic, NodalValues, Noise, Order, Pull, Refinement, ScalarField, Scene, Shape, Solver,
    Time,
};
use super::nodal_file;
use super::nodal_files::NodalKey;
use super::reader::{FINITE, Field, JITTER, NOT_NEGATIVE, POSITIVE, Reader};
use super::vesicle::read_vesicle;
use super::{defaults, document::Value};

/// With fewer there is hardly an interior.
const FEWEST_CELLS: u64 = 4;
/// The longest and the shortest edge that a generated mesh may be asked for, as with cells.
const LONGEST_EDGE: f64 = 1.0 / FEWEST_CELLS as f64;
const SHORTEST_EDGE: f64 = 1.0 / MOST_CELLS as f64;
/// 4·10⁸ nodes: ten gigabytes for φ, μ and ω alone.
const MOST_CELLS: u64 = 20_000;
/// Formulas are tried at the nodes of the mesh, or of this one if that is finer.
const MOST_TRIED_CELLS: usize = 256;

/// The contents of a file, by its path as the scene gives it (relative to the scene's file).
pub(super) type ReadFile<'a> = dyn FnMut(&str) -> std::io::Result<Vec<u8>> + 'a;

/// What reading a value needs besides the value.
pub(super) struct Context<'a> {
    /// Reads files.
    pub read: &'a mut ReadFile<'a>,
    /// The mesh, whose nodes have values.
    pub mesh: &'a Mesh,
}

impl Scene {
    /// Reads a scene.
    ///
    /// - `text` is TOML with the tables and keys of docs/guide/scenes.md; `origin` names it in messages: the
    ///   file's name, or `preset case3`.
    /// - `overrides` are arguments `KEY=VALUE`, applied in their order before anything is checked.
    ///   KEY is dotted, VALUE is TOML or a bare word. A key of a table that is not there makes the
    ///   table; `area=false`, `nematic=false` and so on remove that of an effect; a `vesicle.shape`
    ///   or `vesicle.parts` takes the place of the whole shape in `text`.
    /// - `read` gives the contents of a file of nodal values or of a mesh, by its path as the scene
    ///   gives it.
    ///
    /// # Errors
    ///
    /// Whatever is not TOML, not known, of the wrong type or without sense, with its place.
    pub fn parse<'a>(
        text: &str,
        origin: &str,
        overrides: &[String],
        read: &'a mut ReadFile<'a>,
    ) -> Result<Self, SceneError> {
        let (sources, node) = document::read(text, origin, overrides)?;
        let top = Reader::top(&sources, &node);
        top.allow(keys::TOP)?;

        let mesh = read_mesh(&top.table("mesh")?, read)?;
        let mut context = Context { read, mesh: &mesh };
        let nematic = top.present("nematic")?;
        let scene = Self {
            name: top
                .get("name")
                .map_or(Ok(Scene::default().name), |field| read_name(&field))?,
            boundary: read_boundary(&top.table("domain")?)?,
            vesicle: read_vesicle(&top.table("vesicle")?, &mut context)?,
            time: read_time(&top.table("time")?)?,
            membrane: read_membrane(&top.table("membrane")?, &mut context)?,
            area: top.present("area")?.as_ref().map(read_area).transpose()?,
            nematic: nematic
                .map(|table| read_nematic(&table, &mut context))
                .transpose()?,
            anchoring: top
                .present("anchoring")?
                .as_ref()
                .map(read_anchoring)
                .transpose()?,
            field: top.present("field")?.as_ref().map(read_field).transpose()?,
            pull: top
                .present("pull")?
                .map(|table| read_pull(&table, &mut context))
                .transpose()?,
            noise: top.present("noise")?.as_ref().map(read_noise).transpose()?,
            solver: read_solver(&top.table("solver")?)?,
            mesh,
        };
        check_refinement(&scene, &top)?;
        check_anchoring(&scene, &top)?;
        check_director(&scene, &top)?;
        check_transform(&scene, &top)?;
        Ok(scene)
    }
}

fn read_name(field: &Field<'_>) -> Result<String, SceneError> {
    let name = field.text()?;
    if name.trim().is_empty() || name.contains(char::is_control) {
        return Err(field.out_of_range("one line of text"));
    }
    Ok(name.to_owned())
}

fn read_boundary(table: &Reader<'_>) -> Result<Boundary, SceneError> {
    table.allow(keys::DOMAIN)?;
    table.choice("boundary", Boundary::Natural, BOUNDARIES)
}

/// The word after `mesh.kind =`.
#[derive(Clone, Copy)]
enum MeshKind {
    Structured,
    Delaunay,
    File,
}

const MESH_KINDS: &Names<MeshKind> = &[
    ("structured", MeshKind::Structured),
    ("delaunay", MeshKind::Delaunay),
    ("file", MeshKind::File),
];

fn read_mesh(table: &Reader<'_>, read: &mut ReadFile<'_>) -> Result<Mesh, SceneError> {
    let field = table.get("kind");
    let kind = match &field {
        Some(field) => field.choice(MESH_KINDS)?,
        None => MeshKind::Structured,
    };
    let (owner, allowed) = match kind {
        MeshKind::Structured => ("mesh.kind = \"structured\"", keys::STRUCTURED),
        MeshKind::Delaunay => ("mesh.kind = \"delaunay\"", keys::DELAUNAY),
        MeshKind::File => ("mesh.kind = \"file\"", keys::MESH_FILE),
    };
    table.allow(keys::MESH)?;
    // An override of the kind leaves what belongs to another one in the file.
    let is_overridden = field.is_some_and(|field| field.is_override());
    for (key, field) in table.fields() {
        let is_left_over = is_overridden && !field.is_override();
        if !allowed.contains(&key) && !is_left_over {
            return Err(field.key_error(Problem::MisplacedKey {
                key: key.to_owned(),
                owner: owner.to_owned(),
                allowed: allowed.to_vec(),
            }));
        }
    }
    match kind {
        MeshKind::Structured => {
            let cells = table
                .get("cells")
                .map_or(Ok(defaults::CELLS as u64), |field| {
                    field.integer(FEWEST_CELLS..=MOST_CELLS)
                })?;
            Ok(Mesh::Structured {
                // At most MOST_CELLS: no digit is lost on any machine.
                cells: cells as usize,
                jitter: table.number("jitter", 0.0, JITTER)?,
                seed: table.seed(defaults::SEED)?,
            })
        }
        MeshKind::Delaunay => {
            let size = read_edge(table, "size", LONGEST_EDGE)?.unwrap_or(defaults::SIZE);
            let refine = table.present("refine")?;
            let refine = refine.map(|table| read_refinement(&table, size));
            Ok(Mesh::Delaunay {
                size,
                seed: table.seed(defaults::SEED)?,
                refine: refine.transpose()?,
            })
        }
        MeshKind::File => read_mesh_file(&table.require("path", owner)?, read).map(Mesh::File),
    }
}

/// The length of an edge, at most `longest`.
fn read_edge(
    table: &Reader<'_>,
    key: &'static str,
    longest: f64,
) -> Result<Option<f64>, SceneError> {
    let Some(field) = table.get(key) else {
        return Ok(None);
    };
    let edge = field.number(POSITIVE)?;
    if (SHORTEST_EDGE..=longest).contains(&edge) {
        return Ok(Some(edge));
    }
    Err(field.out_of_range(format!("a number from {SHORTEST_EDGE} to {longest}")))
}

fn read_refinement(table: &Reader<'_>, size: f64) -> Result<Refinement, SceneError> {
    table.allow(&["band", "size"])?;
    let band = table.require("band", "mesh.refine")?.number(POSITIVE)?;
    table.require("size", "mesh.refine")?;
    Ok(Refinement {
        band,
        size: read_edge(table, "size", size)?.unwrap_or(size),
    })
}

fn read_mesh_file(field: &Field<'_>, read: &mut ReadFile<'_>) -> Result<MeshFile, SceneError> {
    let path = field.text()?;
    let bytes = read(path).map_err(|error| unreadable(field, path, &error))?;
    match Triangulation::parse(&bytes) {
        Ok(triangulation) => Ok(MeshFile {
            path: path.to_owned(),
            triangulation: Arc::new(triangulation),
        }),
        Err(error) => Err(field.error(Problem::MeshFile {
            path: path.to_owned(),
            error,
        })),
    }
}

/// A file that cannot be read.
fn unreadable(field: &Field<'_>, path: &str, error: &std::io::Error) -> SceneError {
    field.error(Problem::UnreadableFile {
        key: field.path.clone(),
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

/// There must be a membrane to refine about.
fn check_refinement(scene: &Scene, top: &Reader<'_>) -> Result<(), SceneError> {
    let is_outline = matches!(scene.vesicle.shape, Shape::Outlines(_));
    match (&scene.mesh, top.table("mesh")?.get("refine")) {
        (
            Mesh::Delaunay {
                refine: Some(_), ..
            },
            Some(refine),
        ) if !is_outline => Err(refine.key_error(Problem::RefineWithoutOutline)),
        _ => Ok(()),
    }
}

fn read_time(table: &Reader<'_>) -> Result<Time, SceneError> {
    table.allow(keys::TIME)?;
    let default = Time::default();
    // An override of the one takes the place of the other.
    let (step, tolerance, replaces) = match (table.get("step"), table.get("tolerance")) {
        (Some(step), Some(tolerance)) => match (step.is_override(), tolerance.is_override()) {
            (false, true) => (None, Some(tolerance), true),
            (true, false) => (Some(step), None, true),
            _ => return Err(tolerance.key_error(Problem::StepAndTolerance)),
        },
        (step, tolerance) => (step, tolerance, false),
    };
    let tolerance = tolerance.map(|field| field.number(POSITIVE)).transpose()?;
    // So does the order that belongs to it.
    let order = table
        .get("order")
        .filter(|field| field.is_override() || !replaces);
    let order = match order {
        Some(field) => match field.integer(1..=3)? {
            1 => Order::First,
            2 => Order::Second,
            _ => Order::Third,
        },
        None if tolerance.is_some() => Order::Third,
        None => default.order,
    };
    Ok(Time {
        step: step.map_or(Ok(default.step), |field| field.number(POSITIVE))?,
        tolerance,
        order,
        end: table.number("end", default.end, POSITIVE)?,
    })
}

fn read_membrane(table: &Reader<'_>, context: &mut Context<'_>) -> Result<Membrane, SceneError> {
    table.allow(keys::MEMBRANE)?;
    let default = Membrane::default();
    Ok(Membrane {
        interface_width: table.number("interface_width", default.interface_width, POSITIVE)?,
        mobility: table.number("mobility", default.mobility, POSITIVE)?,
        spontaneous_curvature: match table.get("spontaneous_curvature") {
            Some(field) => read_scalar_field(&field, NodalKey::SpontaneousCurvature, context)?,
            None => default.spontaneous_curvature,
        },
    })
}

/// A number, an expression in x and y, or `{ file = PATH }`.
fn read_scalar_field(
    field: &Field<'_>,
    key: NodalKey,
    context: &mut Context<'_>,
) -> Result<ScalarField, SceneError> {
    match field.value() {
        Value::Number { .. } => field.number(FINITE).map(ScalarField::Constant),
        Value::Text(text) => read_expression(field, text, context).map(ScalarField::Expression),
        Value::Table(_) => {
            let table = field.table()?;
            table.allow(&["file"])?;
            let file = table.require("file", &field.path)?;
            read_nodal_values(&file, key, context).map(ScalarField::File)
        }
        _ => Err(field.wrong_type(
            "a number, an expression in x and y such as \"sin(pi*x)\", or { file = \"k.txt\" }",
        )),
    }
}

fn read_expression(
    field: &Field<'_>,
    text: &str,
    context: &Context<'_>,
) -> Result<Expression, SceneError> {
    text.parse::<Expression>()
        .and_then(|expression| {
            match context.mesh {
                Mesh::Structured { cells, .. } => {
                    expression.check_finite((*cells).min(MOST_TRIED_CELLS))
                }
                Mesh::Delaunay { .. } => expression.check_finite(MOST_TRIED_CELLS),
                Mesh::File(file) => expression.check_finite_at(&file.triangulation.nodes),
            }
            .map(|()| expression)
        })
        .map_err(|error| {
            let key = field.path.clone();
            field.error_within(
                text,
                error.range.clone(),
                Problem::Expression { key, error },
            )
        })
}

/// Reads the file that `field` names.
pub(super) fn read_nodal_values(
    field: &Field<'_>,
    key: NodalKey,
    context: &mut Context<'_>,
) -> Result<NodalValues, SceneError> {
    let path = field.text()?;
    let bytes = (context.read)(path).map_err(|error| unreadable(field, path, &error))?;
    let text = String::from_utf8(bytes).map_err(|_| {
        let error = std::io::Error::new(std::io::ErrorKind::InvalidData, "it is no text in UTF-8");
        unreadable(field, path, &error)
    })?;
    let wanted = nodal_file::Wanted {
        key: &field.path,
        columns: key.columns(),
        mesh: context.mesh,
    };
    nodal_file::parse(path, &text, wanted)
}

fn read_area(table: &Reader<'_>) -> Result<Area, SceneError> {
    table.allow(keys::AREA)?;
    let default = Area::default();
    Ok(Area {
        target: table.number("target", default.target, POSITIVE)?,
        penalty: table.number("penalty", default.penalty, POSITIVE)?,
    })
}

fn read_nematic(table: &Reader<'_>, context: &mut Context<'_>) -> Result<Nematic, SceneError> {
    table.allow(keys::NEMATIC)?;
    let default = Nematic::default();
    Ok(Nematic {
        weight: table.number("weight", default.weight, NOT_NEGATIVE)?,
        mobility: table.number("mobility", default.mobility, POSITIVE)?,
        penalty: table.number("penalty", default.penalty, POSITIVE)?,
        initial: match table.get("initial") {
            Some(field) => read_initial_director(&field, context)?,
            None => default.initial,
        },
    })
}

/// `[x, y]`, or a table whose `kind` says the rest.
fn read_initial_director(
    field: &Field<'_>,
    context: &mut Context<'_>,
) -> Result<InitialDirector, SceneError> {
    match field.value() {
        Value::List(_) => return field.vector(FINITE).map(InitialDirector::Uniform),
        Value::Table(_) => {}
        _ => {
            return Err(field.wrong_type(
                "a vector such as [0.0, 1.0], or a table with kind = \"defects\", \"random\" or \
                 \"file\"",
            ));
        }
    }
    #[derive(Clone, Copy)]
    enum Kind {
        Defects,
        Random,
        File,
    }
    let table = field.table()?;
    let kinds = [
        ("defects", Kind::Defects),
        ("random", Kind::Random),
        ("file", Kind::File),
    ];
    match table.require("kind", &field.path)?.choice(&kinds)? {
        Kind::Defects => {
            table.allow(&["kind", "at", "angle"])?;
            let defects = table.require("at", "kind = \"defects\"")?;
            Ok(InitialDirector::Defects {
                at: defects
                    .items("an array such as [{ center = [0.5, 0.5], winding = 1.0 }]")?
                    .iter()
                    .map(read_defect)
                    .collect::<Result<_, _>>()?,
                angle: table.number("angle", 0.0, FINITE)?,
            })
        }
        Kind::Random => {
            table.allow(&["kind", "seed", "length"])?;
            Ok(InitialDirector::Random {
                seed: table.seed(defaults::SEED)?,
                length: table.number("length", 1.0, NOT_NEGATIVE)?,
            })
        }
        Kind::File => {
            table.allow(&["kind", "values"])?;
            let values = table.require("values", "kind = \"file\"")?;
            read_nodal_values(&values, NodalKey::Director, context).map(InitialDirector::File)
        }
    }
}

fn read_defect(field: &Field<'_>) -> Result<Defect, SceneError> {
    let table = field.table()?;
    table.allow(&["center", "winding"])?;
    Ok(Defect {
        center: table.vector("center", defaults::CENTER)?,
        winding: table.number("winding", 1.0, FINITE)?,
    })
}

fn read_anchoring(table: &Reader<'_>) -> Result<Anchoring, SceneError> {
    table.allow(keys::ANCHORING)?;
    let default = Anchoring::default();
    Ok(Anchoring {
        kind: table.choice("kind", default.kind, ANCHORINGS)?,
        weight: table.number("weight", default.weight, NOT_NEGATIVE)?,
    })
}

fn read_field(table: &Reader<'_>) -> Result<scene::Field, SceneError> {
    table.allow(keys::FIELD)?;
    let default = scene::Field::default();
    let from = table.number("from", default.from, NOT_NEGATIVE)?;
    let until = match table.get("until") {
        None => default.until,
        Some(field) => match field.number(FINITE)? {
            until if until > from => Some(until),
            _ => return Err(field.out_of_range(format!("a number > field.from = {from}"))),
        },
    };
    Ok(scene::Field {
        weight: table.number("weight", default.weight, FINITE)?,
        strength: table.number("strength", default.strength, NOT_NEGATIVE)?,
        angle: table.number("angle", default.angle, FINITE)?,
        from,
        until,
    })
}

fn read_pull(table: &Reader<'_>, context: &mut Context<'_>) -> Result<Pull, SceneError> {
    table.allow(keys::PULL)?;
    let potential = table.require("potential", "[pull]")?;
    Ok(Pull {
        potential: read_scalar_field(&potential, NodalKey::Pull, context)?,
    })
}

fn read_noise(table: &Reader<'_>) -> Result<Noise, SceneError> {
    table.allow(keys::NOISE)?;
    let default = Noise::default();
    Ok(Noise {
        strength: table.number("strength", default.strength, NOT_NEGATIVE)?,
        seed: table.seed(default.seed)?,
    })
}

/// There must be a director for the effects that act on it alone.
fn check_director(scene: &Scene, top: &Reader<'_>) -> Result<(), SceneError> {
    if scene.nematic.is_some() {
        return Ok(());
    }
    for table in ["field", "noise"] {
        if let Some(field) = top.get(table) {
            return Err(field.key_error(Problem::DirectorWithoutNematic { table }));
        }
    }
    Ok(())
}

/// There must be a director to anchor.
fn check_anchoring(scene: &Scene, top: &Reader<'_>) -> Result<(), SceneError> {
    let (Some(anchoring), None) = (scene.anchoring, &scene.nematic) else {
        return Ok(());
    };
    let (AnchoringKind::Homeotropic | AnchoringKind::Parallel) = anchoring.kind else {
        return Ok(());
    };
    let problem = Problem::AnchoringWithoutNematic {
        kind: name_of(ANCHORINGS, anchoring.kind),
    };
    match (top.table("anchoring")?.get("kind"), top.get("anchoring")) {
        (Some(kind), _) => Err(kind.error(problem)),
        (None, Some(table)) => Err(table.key_error(problem)),
        (None, None) => Ok(()),
    }
}

/// The transform is for the regular mesh and the natural boundary, the shifted Laplacians for the latter.
fn check_transform(scene: &Scene, top: &Reader<'_>) -> Result<(), SceneError> {
    let is_natural = scene.boundary == Boundary::Natural;
    let problem = match scene.solver.linear {
        LinearMethod::Transform if !(is_natural && scene.mesh.is_grid()) => {
            Problem::TransformDoesNotApply
        }
        LinearMethod::Shifted if !is_natural => Problem::ShiftedDoesNotApply,
        _ => return Ok(()),
    };
    match top.table("solver")?.get("linear") {
        Some(linear) => Err(linear.error(problem)),
        None => Ok(()),
    }
}

fn read_solver(table: &Reader<'_>) -> Result<Solver, SceneError> {
    table.allow(keys::SOLVER)?;
    let default = Solver::default();
    Ok(Solver {
        quadrature: table.choice("quadrature", default.quadrature, QUADRATURES)?,
        iteration: table.choice("iteration", default.iteration, ITERATIONS)?,
        linear: table.choice("linear", default.linear, LINEAR_METHODS)?,
        tolerance: table.number("tolerance", default.tolerance, POSITIVE)?,
        law_tolerance: table.number("law_tolerance", default.law_tolerance, POSITIVE)?,
    })
}
