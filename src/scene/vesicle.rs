//! The table [vesicle]: which keys it has depends on the shape.

use super::defaults;
use super::error::{Problem, SceneError};
use super::keys::{self, Keys};
use super::keywords::{Names, PROJECTIONS, name_of};
use super::model::{Curve, Outline, Shape, Vesicle};
use super::nodal_files::NodalKey;
use super::reader::{FINITE, Field, POSITIVE, RATIO, Reader};
use super::schema::{Context, read_nodal_values};

/// The word after `shape =`.
#[derive(Clone, Copy, PartialEq)]
enum ShapeKind {
    Circle,
    Ellipse,
    Cassini,
    Discocyte,
    Random,
    File,
}

const SHAPES: &Names<ShapeKind> = &[
    ("circle", ShapeKind::Circle),
    ("ellipse", ShapeKind::Ellipse),
    ("cassini", ShapeKind::Cassini),
    ("discocyte", ShapeKind::Discocyte),
    ("random", ShapeKind::Random),
    ("file", ShapeKind::File),
];

impl ShapeKind {
    fn keys(self) -> &'static Keys {
        match self {
            Self::Circle => keys::CIRCLE,
            Self::Ellipse => keys::ELLIPSE,
            Self::Cassini => keys::CASSINI,
            Self::Discocyte => keys::DISCOCYTE,
            Self::Random => keys::RANDOM,
            Self::File => keys::FILE,
        }
    }

    /// How the user chose it, for messages.
    fn phrase(self) -> String {
        format!("shape = \"{}\"", name_of(SHAPES, self))
    }
}

/// Reads [vesicle].
pub(super) fn read_vesicle(
    table: &Reader<'_>,
    context: &mut Context<'_>,
) -> Result<Vesicle, SceneError> {
    let default = Vesicle::default();
    Ok(Vesicle {
        shape: read_shape(table, context)?,
        projection: table.choice("projection", default.projection, PROJECTIONS)?,
        scale: table.number("scale", default.scale, FINITE)?,
    })
}

fn read_shape(table: &Reader<'_>, context: &mut Context<'_>) -> Result<Shape, SceneError> {
    let (shape, parts) = match (table.get("shape"), table.get("parts")) {
        // The one of an override takes the place of the scene's.
        (Some(shape), Some(parts)) if shape.is_override() && !parts.is_override() => {
            (Some(shape), None)
        }
        (Some(shape), Some(parts)) if parts.is_override() && !shape.is_override() => {
            (None, Some(parts))
        }
        (Some(shape), Some(_)) => {
            let problem = Problem::Conflict {
                first: "vesicle.shape",
                second: "vesicle.parts",
            };
            return Err(shape.key_error(problem));
        }
        either => either,
    };
    if let Some(parts) = parts {
        allow(table, "parts", &["parts"], parts.is_override())?;
        return read_parts(&parts).map(Shape::Outlines);
    }
    let kind = shape
        .as_ref()
        .map_or(Ok(ShapeKind::Cassini), |field| field.choice(SHAPES))?;
    let overridden = shape.is_some_and(|field| field.is_override());
    allow(table, &kind.phrase(), kind.keys(), overridden)?;
    match kind {
        ShapeKind::Random => Ok(Shape::Random {
            amplitude: table
                .require("amplitude", &kind.phrase())?
                .number(POSITIVE)?,
            seed: table.seed(defaults::SEED)?,
        }),
        ShapeKind::File => {
            let values = table.require("values", &kind.phrase())?;
            read_nodal_values(&values, NodalKey::Vesicle, context).map(Shape::File)
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

/// Refuses keys of [vesicle] that do not go with the shape. Where an override chose the shape, keys
/// that went with the scene's own shape are passed over.
fn allow(
    table: &Reader<'_>,
    owner: &str,
    own: &'static Keys,
    overridden: bool,
) -> Result<(), SceneError> {
    let common = keys::VESICLE
        .iter()
        .filter(|key| !keys::SHAPES.contains(key));
    let allowed: Vec<&'static str> = own.iter().chain(common).copied().collect();
    for (key, field) in table.fields() {
        let superseded = overridden && !field.is_override() && keys::SHAPES.contains(&key);
        if !superseded {
            check_key(table, key, &field, owner, &allowed)?;
        }
    }
    Ok(())
}

fn check_key(
    table: &Reader<'_>,
    key: &str,
    field: &Field<'_>,
    owner: &str,
    allowed: &[&'static str],
) -> Result<(), SceneError> {
    if allowed.contains(&key) {
        Ok(())
    } else if keys::SHAPES.contains(&key) {
        let (key, owner, allowed) = (key.to_owned(), owner.to_owned(), allowed.to_vec());
        Err(field.key_error(Problem::MisplacedKey {
            key,
            owner,
            allowed,
        }))
    } else {
        table.allow(allowed)
    }
}

fn read_parts(parts: &Field<'_>) -> Result<Vec<Outline>, SceneError> {
    let words = "an array of one or more shapes, such as [{ shape = \"circle\", radius = 0.1 }]";
    let items = parts.items(words)?;
    if items.is_empty() {
        return Err(parts.out_of_range(words));
    }
    items.iter().map(read_part).collect()
}

fn read_part(part: &Field<'_>) -> Result<Outline, SceneError> {
    let table = part.table()?;
    let outlines: Vec<_> = SHAPES
        .iter()
        .filter(|(_, kind)| !matches!(kind, ShapeKind::Random | ShapeKind::File))
        .copied()
        .collect();
    let kind = table.require("shape", &part.path)?.choice(&outlines)?;
    for (key, field) in table.fields() {
        check_key(&table, key, &field, &kind.phrase(), kind.keys())?;
    }
    read_outline(&table, kind, table.get("angle"))
}

fn read_outline(
    table: &Reader<'_>,
    kind: ShapeKind,
    angle: Option<Field<'_>>,
) -> Result<Outline, SceneError> {
    let curve = match kind {
        ShapeKind::Circle => Curve::Circle {
            radius: table.require("radius", &kind.phrase())?.number(POSITIVE)?,
        },
        ShapeKind::Ellipse => Curve::Ellipse {
            half_axes: table
                .require("half_axes", &kind.phrase())?
                .vector(POSITIVE)?,
        },
        ShapeKind::Discocyte => Curve::Discocyte {
            radius: table.require("radius", &kind.phrase())?.number(POSITIVE)?,
        },
        // The two others have no outline, and no caller asks for one.
        ShapeKind::Cassini | ShapeKind::Random | ShapeKind::File => Curve::Cassini {
            ratio: table.number("ratio", defaults::RATIO, RATIO)?,
            half_length: table.number("half_length", defaults::HALF_LENGTH, POSITIVE)?,
        },
    };
    Ok(Outline {
        curve,
        center: table.vector("center", defaults::CENTER)?,
        angle: match (angle, kind) {
            (Some(angle), _) => angle.number(FINITE)?,
            (None, ShapeKind::Cassini) => defaults::CASSINI_ANGLE,
            (None, _) => defaults::ANGLE,
        },
    })
}
