//! `[vesicle]`: which keys it has depends on the shape.

use super::{Geometry, Rules, Scene, Table};
use crate::geometry::{Vector, direction};
use crate::scene::error::{Problem, SceneError};
use crate::scene::nodal_file::{Context, NodalKey, NodalValues, read_nodal_values};
use crate::scene::outline::{OutlineDistance, least_opening};
use crate::scene::parameter::{
    Choice, DefaultValue, PATH, Parameter, SEED, SEEDS, Value, choice, parameters,
};
use crate::scene::reader::{Bound, FINITE, Field, POSITIVE, Reader};
use crate::scene::write::{inline, number, quoted, vector};

/// The centre of the domain.
pub(super) const CENTER: [f64; 2] = [0.5, 0.5];
/// The paper's vesicle, the Cassini oval, stands upright; every other shape lies along x.
const CASSINI_ANGLE: f64 = 90.0;
const ANGLE: f64 = 0.0;
/// c/a of the Cassini oval.
const RATIO: f64 = 0.92;
/// sqrt(a² + c²) of the Cassini oval.
const HALF_LENGTH: f64 = 0.32;
const RATIOS: Bound = Bound::new("a number ≥ 0 and < 1", |v| (0.0..1.0).contains(&v));
const OPENINGS: Bound = Bound::new("a number > 0 and < 360", |v| v > 0.0 && v < 360.0);
const PARTS: &str =
    "an array of one or more shapes, such as [{ shape = \"circle\", radius = 0.1 }]";
const VALUES: NodalKey = NodalKey::scalar("vesicle.values", "vesicle.txt");

/// The initial phase field φ⁰.
#[derive(Debug, Clone, PartialEq)]
pub struct Vesicle {
    /// Where φ⁰ comes from.
    pub shape: Shape,
    /// How φ⁰ is brought onto the P1 space.
    pub projection: Projection,
    /// φ⁰ is multiplied by this (1 but in tests).
    pub scale: f64,
}

/// Where φ⁰ comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// tanh(s/(√2 ε)) of the largest signed distance s to any of the outlines.
    Outlines(Vec<Outline>),
    /// Independent nodal values, uniform in (−amplitude, amplitude).
    Random {
        /// Bound of the values.
        amplitude: f64,
        /// Of the generator.
        seed: u64,
    },
    /// Nodal values from a file.
    File(NodalValues),
}

/// A closed curve in the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Its kind and size.
    pub curve: Curve,
    /// Its centre.
    pub center: [f64; 2],
    /// The angle to the x axis of the axis that the curve has along x, in degrees.
    pub angle: f64,
}

impl Outline {
    /// The direction of its long axis, a unit vector.
    pub fn long_axis(&self) -> Vector {
        let axis = direction(self.angle);
        match self.curve {
            Curve::Ellipse {
                half_axes: [first, second],
            } if first < second => Vector::new(-axis.y, axis.x),
            _ => axis,
        }
    }
}

/// The kind and the size of a closed curve, centred at the origin; its long axis is along x, but for an
/// ellipse whose second axis is the longer one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// A circle.
    Circle {
        /// Its radius.
        radius: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Half its axes; the first is the one along `Outline::angle`.
        half_axes: [f64; 2],
    },
    /// A Cassini oval: the points whose distances to the foci (±c, 0) have the product a².
    Cassini {
        /// c/a, in [0, 1): at 1 the oval falls into two.
        ratio: f64,
        /// sqrt(a² + c²).
        half_length: f64,
    },
    /// The Evans–Fung discocyte: half-thickness ½·R·sqrt(1−t²)(0.207 + 2.003 t² − 1.123 t⁴), t = x/R.
    Discocyte {
        /// R.
        radius: f64,
    },
    /// The section of a cup: what lies within half a thickness of an arc of a circle about the origin. It is open towards +y.
    Stomatocyte {
        /// Of the arc.
        radius: f64,
        /// Of the wall.
        thickness: f64,
        /// The angle without arc, in degrees.
        opening: f64,
    },
}

choice! {
    /// How φ⁰ is brought onto the P1 space.
    pub enum Projection {
        /// (∇φ_h, ∇v) = (∇φ⁰, ∇v) with ∫φ_h = ∫φ⁰.
        Ritz = "ritz",
        /// (φ_h, v) = (φ⁰, v): the paper's (3.15).
        L2 = "l2",
        /// Interpolation at the nodes.
        Nodal = "nodal",
    }
}

impl Default for Vesicle {
    fn default() -> Self {
        Self {
            shape: Shape::Outlines(vec![Outline::default()]),
            projection: Projection::Ritz,
            scale: 1.0,
        }
    }
}

impl Default for Outline {
    fn default() -> Self {
        let curve = Curve::Cassini {
            ratio: RATIO,
            half_length: HALF_LENGTH,
        };
        Self {
            curve,
            center: CENTER,
            angle: CASSINI_ANGLE,
        }
    }
}

choice! {
    /// The word after `shape =`.
    enum ShapeKind {
        /// See [`Curve`].
        Circle = "circle",
        /// See [`Curve`].
        Ellipse = "ellipse",
        /// See [`Curve`].
        Cassini = "cassini",
        /// See [`Curve`].
        Discocyte = "discocyte",
        /// See [`Curve`].
        Stomatocyte = "stomatocyte",
        /// See [`Shape`].
        Random = "random",
        /// See [`Shape`].
        File = "file",
    }
}

const OUTLINES: &[&str] = &["circle", "ellipse", "cassini", "discocyte", "stomatocyte"];
impl ShapeKind {
    /// How the user chose it, for messages.
    fn phrase(self) -> String {
        format!("shape = \"{}\"", self.word())
    }
}

impl Table for Vesicle {
    fn words() -> &'static str {
        "The vesicle at the start, the initial phase field φ⁰."
    }

    fn parameters() -> Vec<Parameter> {
        let [ratio, half_length, angle, scale] =
            [RATIO, HALF_LENGTH, CASSINI_ANGLE, 1.0].map(|value| DefaultValue::of(&value));
        let default = Self::default();
        parameters! {
            shape of &["circle", "ellipse", "cassini", "discocyte", "stomatocyte", "random", "file"], DefaultValue::of(&ShapeKind::Cassini), ShapeKind::words(&()), "Its shape";
            parts of &["parts"], DefaultValue::Absent, PARTS, "Several shapes, in place of one";
            ratio of &["cassini"], ratio, RATIOS.words, "c/a of the foci (±c, 0) and the product a²";
            half_length of &["cassini"], half_length, POSITIVE.words, "sqrt(a² + c²)";
            radius of &["circle", "discocyte", "stomatocyte"], DefaultValue::Required, POSITIVE.words, "the radius; of a stomatocyte that of the middle of its wall";
            thickness of &["stomatocyte"], DefaultValue::Required, POSITIVE.words, "of the wall";
            opening of &["stomatocyte"], DefaultValue::Required, OPENINGS.words, "the angle from rim to rim, seen from the centre, in degrees";
            half_axes of &["ellipse"], DefaultValue::Required, "an array of two numbers > 0", "half its axes";
            center of OUTLINES, DefaultValue::of(&CENTER), <[f64; 2]>::words(&FINITE), "its centre; of a stomatocyte that of the arc";
            angle of OUTLINES, angle, FINITE.words, "of the long axis (of an ellipse, its first axis) to the x axis, in degrees; 0 by default but for `cassini`";
            amplitude of &["random"], DefaultValue::Required, POSITIVE.words, "the bound of independent nodal values";
            seed of &["random"], DefaultValue::of(&SEED), u64::words(&SEEDS), "of the random numbers";
            values of &["file"], DefaultValue::Required, PATH, "φ⁰ at the nodes, one value a line for each", VALUES;
            projection of &[], DefaultValue::of(&default.projection), Projection::words(&()), "How φ⁰ is brought onto the mesh";
            scale of &[], scale, FINITE.words, "φ⁰ is multiplied by this; 1 but in tests";
        }
    }

    fn read(mut table: Reader<'_>, context: &mut Context<'_>) -> Result<Self, SceneError> {
        let default = Self::default();
        Ok(Self {
            shape: read_shape(&mut table, context)?,
            projection: table.choice("projection", default.projection)?,
            scale: table.number("scale", default.scale, FINITE)?,
        })
    }

    fn write(&self) -> Vec<(&'static str, String)> {
        let shape = |kind: ShapeKind| ("shape", quoted(kind.word()));
        let mut keys = match &self.shape {
            Shape::Outlines(outlines) => match &outlines[..] {
                [outline] => outline_keys(outline),
                outlines => {
                    let parts = outlines.iter().map(|part| inline(&outline_keys(part)));
                    let parts: String = parts.map(|part| format!("    {part},\n")).collect();
                    vec![("parts", format!("[\n{parts}]"))]
                }
            },
            Shape::Random { amplitude, seed } => vec![
                shape(ShapeKind::Random),
                ("amplitude", number(*amplitude)),
                ("seed", seed.to_string()),
            ],
            Shape::File(nodal) => vec![shape(ShapeKind::File), ("values", quoted(&nodal.path))],
        };
        keys.push(("projection", quoted(self.projection.word())));
        keys.push(("scale", number(self.scale)));
        keys
    }

    fn nodal_files(&mut self) -> Vec<(NodalKey, &mut NodalValues)> {
        match &mut self.shape {
            Shape::File(file) => vec![(VALUES, file)],
            Shape::Outlines(_) | Shape::Random { .. } => Vec::new(),
        }
    }
}

impl Rules for Vesicle {
    /// What reaches the axis of rotation must be smooth there.
    fn check_scene(&self, scene: &Scene, table: &Reader<'_>) -> Result<(), SceneError> {
        let (Geometry::Axisymmetric, Shape::Outlines(outlines)) = (scene.geometry, &self.shape)
        else {
            return Ok(());
        };
        let is_askew = |outline: &Outline| {
            // A stomatocyte has one axis of symmetry, the others have two.
            let period = match outline.curve {
                Curve::Stomatocyte { .. } => 180.0,
                _ => 90.0,
            };
            let is_upright = outline.angle.rem_euclid(period) == 0.0;
            let is_on_axis = outline.center[0] == 0.0 && is_upright;
            !is_on_axis && OutlineDistance::new(outline).bounding_box().lower.x <= 0.0
        };
        let Some(part) = outlines.iter().position(is_askew) else {
            return Ok(());
        };
        // Of several outlines the table of this one.
        let parts = table.get("parts").map(|parts| parts.items("tables"));
        let part_table = match parts
            .transpose()?
            .and_then(|parts| parts.into_iter().nth(part))
        {
            Some(field) => Some(field.table()?),
            None => None,
        };
        let table = part_table.as_ref().unwrap_or(table);
        let wrong = match outlines[part].center[0] == 0.0 {
            true => "angle",
            false => "center",
        };
        let key = [wrong, "shape"].into_iter().find_map(|key| table.get(key));
        Err(match key {
            Some(field) => field.error(Problem::AskewOnAxis),
            None => table.error(Problem::AskewOnAxis),
        })
    }
}

fn read_shape(table: &mut Reader<'_>, context: &mut Context<'_>) -> Result<Shape, SceneError> {
    let problem = Problem::Conflict {
        first: "vesicle.shape",
        second: "vesicle.parts",
    };
    table.choose(["shape", "parts"], problem)?;
    let parameters = Vesicle::parameters();
    if let Some(parts) = table.get("parts") {
        table.allow_kind(&parameters, ["parts"; 2], parts.is_override())?;
        return read_parts(&parts).map(Shape::Outlines);
    }
    let kind = table.choice("shape", ShapeKind::Cassini)?;
    let overridden = table.get("shape").is_some_and(|field| field.is_override());
    table.allow_kind(&parameters, [kind.word(), &kind.phrase()], overridden)?;
    match kind {
        ShapeKind::Random => Ok(Shape::Random {
            amplitude: table
                .require("amplitude", &kind.phrase())?
                .number(POSITIVE)?,
            seed: table.seed()?,
        }),
        ShapeKind::File => {
            let values = table.require("values", &kind.phrase())?;
            read_nodal_values(&values, VALUES, context).map(Shape::File)
        }
        _ => {
            // The angle of the shape that an override has replaced is not that of the new one.
            let angle = table
                .get("angle")
                .filter(|field| field.is_override() || !overridden);
            Ok(Shape::Outlines(vec![read_outline(table, kind, angle)?]))
        }
    }
}

fn read_parts(parts: &Field<'_>) -> Result<Vec<Outline>, SceneError> {
    let items = parts.items(PARTS)?;
    if items.is_empty() {
        return Err(parts.out_of_range(PARTS));
    }
    items.iter().map(read_part).collect()
}

fn read_part(part: &Field<'_>) -> Result<Outline, SceneError> {
    let table = part.table()?;
    let mut outlines = ShapeKind::NAMES.to_vec();
    outlines.retain(|(name, _)| OUTLINES.contains(name));
    let kind = table.require("shape", &part.path)?.choice(&outlines)?;
    let mut parameters = Vesicle::parameters();
    parameters.retain(|parameter| !parameter.kinds.is_empty());
    table.allow_kind(&parameters, [kind.word(), &kind.phrase()], false)?;
    read_outline(&table, kind, table.get("angle"))
}

fn read_outline(
    table: &Reader<'_>,
    kind: ShapeKind,
    angle: Option<Field<'_>>,
) -> Result<Outline, SceneError> {
    let required = |key| table.require(key, &kind.phrase());
    let radius = || required("radius")?.number(POSITIVE);
    let curve = match kind {
        ShapeKind::Circle => Curve::Circle { radius: radius()? },
        ShapeKind::Discocyte => Curve::Discocyte { radius: radius()? },
        ShapeKind::Ellipse => Curve::Ellipse {
            half_axes: required("half_axes")?.vector(POSITIVE)?,
        },
        ShapeKind::Stomatocyte => {
            let radius = radius()?;
            let thickness = required("thickness")?.number(POSITIVE)?;
            let field = required("opening")?;
            let opening = field.number(OPENINGS)?;
            let least = least_opening(radius, thickness);
            if least.is_none_or(|least| opening <= least) {
                return Err(match least {
                    Some(least) => field.out_of_range(format!(
                        "greater than {least:.1} degrees, where the rim of this radius and thickness closes"
                    )),
                    None => required("thickness")?
                        .out_of_range(format!("less than twice the radius, {:?}", 2.0 * radius)),
                });
            }
            Curve::Stomatocyte {
                radius,
                thickness,
                opening,
            }
        }
        // The two others have no outline, and no caller asks for one.
        ShapeKind::Cassini | ShapeKind::Random | ShapeKind::File => Curve::Cassini {
            ratio: table.number("ratio", RATIO, RATIOS)?,
            half_length: table.number("half_length", HALF_LENGTH, POSITIVE)?,
        },
    };
    Ok(Outline {
        curve,
        center: table.vector("center", CENTER)?,
        angle: match (angle, kind) {
            (Some(angle), _) => angle.number(FINITE)?,
            (None, ShapeKind::Cassini) => CASSINI_ANGLE,
            (None, _) => ANGLE,
        },
    })
}

fn outline_keys(outline: &Outline) -> Vec<(&'static str, String)> {
    let key = |key, value| vec![(key, number(value))];
    let (kind, size) = match outline.curve {
        Curve::Circle { radius } => (ShapeKind::Circle, key("radius", radius)),
        Curve::Discocyte { radius } => (ShapeKind::Discocyte, key("radius", radius)),
        Curve::Ellipse { half_axes } => {
            let half_axes = ("half_axes", vector(half_axes));
            (ShapeKind::Ellipse, vec![half_axes])
        }
        Curve::Stomatocyte {
            radius,
            thickness,
            opening,
        } => {
            let size = [
                key("radius", radius),
                key("thickness", thickness),
                key("opening", opening),
            ];
            (ShapeKind::Stomatocyte, size.concat())
        }
        Curve::Cassini { ratio, half_length } => {
            let size = [key("ratio", ratio), key("half_length", half_length)];
            (ShapeKind::Cassini, size.concat())
        }
    };
    let mut keys = vec![("shape", quoted(kind.word()))];
    keys.extend(size);
    keys.extend([
        ("center", vector(outline.center)),
        ("angle", number(outline.angle)),
    ]);
    keys
}
