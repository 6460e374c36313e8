//! `[mesh]`: which keys it has depends on its kind.

use std::ops::RangeInclusive;
use std::sync::Arc;

use super::{Geometry, Rules, Scene, Shape, Table};
use crate::scene::error::{Problem, SceneError};
use crate::scene::mesh_file::{MeshFile, Triangulation};
use crate::scene::nodal_file::Context;
use crate::scene::parameter::{
    Choice, DefaultValue, PATH, Parameter, SEED, SEEDS, Value, choice, parameters,
};
use crate::scene::reader::{Bound, Field, POSITIVE, Reader};
use crate::scene::write::{inline, number, quoted};

/// With fewer there is hardly an interior.
const FEWEST_CELLS: u64 = 4;
/// 4·10⁸ nodes: ten gigabytes for φ, μ and ω alone.
const MOST_CELLS: u64 = 20_000;
const CELL_COUNTS: RangeInclusive<u64> = FEWEST_CELLS..=MOST_CELLS;
/// The longest and the shortest edge that a generated mesh may be asked for, as with cells.
pub(in crate::scene) const LONGEST_EDGE: f64 = 1.0 / FEWEST_CELLS as f64;
pub(in crate::scene) const SHORTEST_EDGE: f64 = 1.0 / MOST_CELLS as f64;
const JITTER: Bound = Bound::new("a number ≥ 0 and < 0.9", |v| (0.0..0.9).contains(&v));
/// 1/h.
const CELLS: usize = 120;
/// h of a generated mesh.
const SIZE: f64 = 1.0 / 120.0;
/// Of a mesh that follows the membrane: edges far from it, edges at it, and how far those reach.
const FAR: f64 = 0.08;
const INTERFACE: f64 = 0.008;
const BAND: f64 = 0.03;

/// The triangulation of Ω.
#[derive(Debug, Clone, PartialEq)]
pub enum Mesh {
    /// Right triangles, `cells` squares along each side, diagonals from lower left to upper right.
    Structured {
        /// 1/h.
        cells: usize,
        /// Interior nodes are moved by up to this fraction of h in x and in y.
        jitter: f64,
        /// Of the generator that moves them.
        seed: u64,
    },
    /// A Delaunay triangulation of the unit square, by its size, graded where it is asked for.
    Delaunay {
        /// The wanted length of an edge.
        size: f64,
        /// Of the generator that scatters the nodes.
        seed: u64,
        /// Finer about the initial membrane.
        refine: Option<Refinement>,
    },
    /// A Delaunay triangulation of the unit square that is fine about the membrane, wherever that is: it is made
    /// again when the membrane has moved.
    Adaptive {
        /// The wanted length of an edge far from the membrane.
        size: f64,
        /// Finer about the membrane.
        refine: Refinement,
        /// Of the generator that scatters the nodes.
        seed: u64,
    },
    /// From a file.
    File(MeshFile),
}

/// Smaller triangles about the membrane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// So far from the membrane, on either side.
    pub band: f64,
    /// The wanted length of an edge there.
    pub size: f64,
}

impl Default for Mesh {
    fn default() -> Self {
        Self::Structured {
            cells: CELLS,
            jitter: 0.0,
            seed: SEED,
        }
    }
}

impl Mesh {
    /// The wanted length of an edge at the membrane; not known of a mesh from a file.
    pub fn edge_at_membrane(&self) -> Option<f64> {
        match self {
            Self::Structured { cells, .. } => Some((*cells as f64).recip()),
            Self::Delaunay { size, refine, .. } => {
                Some(refine.map_or(*size, |refinement| refinement.size.min(*size)))
            }
            Self::Adaptive { refine, .. } => Some(refine.size),
            Self::File(_) => None,
        }
    }

    /// Squares along a side of the structured mesh.
    pub fn cells(&self) -> Option<usize> {
        match self {
            Self::Structured { cells, .. } => Some(*cells),
            Self::Delaunay { .. } | Self::Adaptive { .. } | Self::File(_) => None,
        }
    }

    /// Whether it is the structured mesh with every node in its place.
    pub fn is_grid(&self) -> bool {
        matches!(self, Self::Structured { jitter, .. } if *jitter == 0.0)
    }
}

choice! {
    /// The word after `mesh.kind =`.
    enum Kind {
        /// Squares, each cut into two.
        Structured = "structured",
        /// A Delaunay triangulation.
        Delaunay = "delaunay",
        /// A Delaunay triangulation that follows the membrane.
        Adaptive = "adaptive",
        /// That of a file.
        File = "file",
    }
}

impl Table for Mesh {
    fn words() -> &'static str {
        "The triangulation of Ω: squares, each cut into two triangles; a Delaunay triangulation; one that is fine about the membrane and follows it; or that of a file."
    }

    fn parameters() -> Vec<Parameter> {
        let of = |value: u64| DefaultValue::of(&value);
        let [zero, size, far, interface, band] =
            [0.0, SIZE, FAR, INTERFACE, BAND].map(|value| DefaultValue::of(&value));
        let edge = format!("a number from {SHORTEST_EDGE} to {LONGEST_EDGE}");
        parameters! {
            kind of &[], DefaultValue::of(&Kind::Structured), Kind::words(&()), "Its kind";
            cells of &["structured"], of(CELLS as u64), u64::words(&CELL_COUNTS), "squares along a side, 1/h";
            jitter of &["structured"], zero, JITTER.words, "interior nodes are moved by up to this fraction of h in x and in y";
            size of &["delaunay"], size, edge.clone(), "the wanted length of an edge";
            size of &["adaptive"], far, edge.clone(), "the wanted length of an edge far from the membrane";
            interface of &["adaptive"], interface, edge, "the wanted length of an edge at the membrane, at most `size`";
            band of &["adaptive"], band, POSITIVE.words, "how far from the membrane edges have that length; the mesh is made again when the membrane has moved by a third of it";
            refine of &["delaunay"], DefaultValue::Absent, "such as `{ band = 0.1, size = 0.005 }`", "the length of an edge nearer to the initial membrane than `band`";
            path of &["file"], DefaultValue::Required, PATH, "a mesh of Gmsh";
            seed of &["structured", "delaunay", "adaptive"], of(SEED), u64::words(&SEEDS), "of the random numbers that move or scatter the nodes";
        }
    }

    fn read(table: Reader<'_>, context: &mut Context<'_>) -> Result<Self, SceneError> {
        let kind = table.choice("kind", Kind::Structured)?;
        let parameters = Self::parameters();
        let mut keys: Vec<&'static str> = parameters.iter().map(|it| it.key).collect();
        // Of a key that means something else with another kind there is a parameter each.
        keys.dedup();
        table.allow(&keys)?;
        let owner = format!("mesh.kind = \"{}\"", kind.word());
        let is_overridden = table.get("kind").is_some_and(|field| field.is_override());
        table.allow_kind(&parameters, [kind.word(), &owner], is_overridden)?;
        match kind {
            Kind::Structured => {
                let cells = table.get("cells");
                let cells = cells.map(|field| field.integer(&CELL_COUNTS)).transpose()?;
                Ok(Self::Structured {
                    // At most MOST_CELLS: no digit is lost on any machine.
                    cells: cells.map_or(CELLS, |cells| cells as usize),
                    jitter: table.number("jitter", 0.0, JITTER)?,
                    seed: table.seed()?,
                })
            }
            Kind::Delaunay => {
                let size = read_edge(&table, "size", LONGEST_EDGE)?.unwrap_or(SIZE);
                let refine = table.present("refine")?;
                let refine = refine.map(|table| read_refinement(&table, size));
                Ok(Self::Delaunay {
                    size,
                    seed: table.seed()?,
                    refine: refine.transpose()?,
                })
            }
            Kind::Adaptive => {
                let size = read_edge(&table, "size", LONGEST_EDGE)?.unwrap_or(FAR);
                let refine = Refinement {
                    band: table.number("band", BAND, POSITIVE)?,
                    size: read_edge(&table, "interface", size)?.unwrap_or(INTERFACE.min(size)),
                };
                Ok(Self::Adaptive {
                    size,
                    refine,
                    seed: table.seed()?,
                })
            }
            Kind::File => read_file(&table.require("path", &owner)?, context).map(Self::File),
        }
    }

    fn write(&self) -> Vec<(&'static str, String)> {
        let kind = |kind: Kind| ("kind", quoted(kind.word()));
        match self {
            Self::Structured {
                cells,
                jitter,
                seed,
            } => vec![
                kind(Kind::Structured),
                ("cells", cells.to_string()),
                ("jitter", number(*jitter)),
                ("seed", seed.to_string()),
            ],
            Self::Delaunay { size, seed, refine } => {
                let mut keys = vec![kind(Kind::Delaunay), ("size", number(*size))];
                keys.extend(refine.map(|Refinement { band, size }| {
                    let keys = [("band", number(band)), ("size", number(size))];
                    ("refine", inline(&keys))
                }));
                keys.push(("seed", seed.to_string()));
                keys
            }
            Self::Adaptive { size, refine, seed } => vec![
                kind(Kind::Adaptive),
                ("size", number(*size)),
                ("interface", number(refine.size)),
                ("band", number(refine.band)),
                ("seed", seed.to_string()),
            ],
            Self::File(file) => vec![kind(Kind::File), ("path", quoted(&file.path))],
        }
    }
}

impl Rules for Mesh {
    /// There must be a membrane to refine about, and no values at nodes that come and go.
    fn check_scene(&self, scene: &Scene, table: &Reader<'_>) -> Result<(), SceneError> {
        if let (Self::Adaptive { .. }, Some(kind), Some((key, file))) =
            (self, table.get("kind"), scene.nodal_files().first())
        {
            return Err(kind.error(Problem::NodalValuesOnAdaptiveMesh {
                key: key.name.to_owned(),
                path: file.path.clone(),
            }));
        }
        if let (Self::File(file), Geometry::Axisymmetric, Some(path)) =
            (self, scene.geometry, table.get("path"))
        {
            let nodes = file.triangulation.nodes.iter().map(|node| node.x);
            let least = nodes.fold(f64::INFINITY, f64::min);
            if least < 0.0 {
                return Err(path.error(Problem::MeshBeyondAxis { x: least }));
            }
        }
        let is_outline = matches!(scene.vesicle.shape, Shape::Outlines(_));
        match (self, table.get("refine")) {
            (
                Self::Delaunay {
                    refine: Some(_), ..
                },
                Some(refine),
            ) if !is_outline => Err(refine.key_error(Problem::RefineWithoutOutline)),
            _ => Ok(()),
        }
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

fn read_file(field: &Field<'_>, context: &mut Context<'_>) -> Result<MeshFile, SceneError> {
    let (path, bytes) = context.read_file(field)?;
    match Triangulation::parse(&bytes) {
        Ok(triangulation) => Ok(MeshFile {
            path,
            triangulation: Arc::new(triangulation),
        }),
        Err(error) => Err(field.error(Problem::MeshFile { path, error })),
    }
}
