//! The keys of a scene's tables, in the order in which they are written.

/// Keys of a table.
pub(super) type Keys = [&'static str];

pub(super) const TOP: &Keys = &[
    "name",
    "domain",
    "mesh",
    "vesicle",
    "time",
    "membrane",
    "area",
    "nematic",
    "anchoring",
    "field",
    "pull",
    "noise",
    "solver",
];
pub(super) const DOMAIN: &Keys = &["boundary"];
/// Of [mesh], whatever its kind.
pub(super) const MESH: &Keys = &["kind", "cells", "jitter", "size", "refine", "path", "seed"];
pub(super) const STRUCTURED: &Keys = &["kind", "cells", "jitter", "seed"];
pub(super) const DELAUNAY: &Keys = &["kind", "size", "refine", "seed"];
pub(super) const MESH_FILE: &Keys = &["kind", "path"];
pub(super) const TIME: &Keys = &["step", "tolerance", "order", "end"];
pub(super) const MEMBRANE: &Keys = &["interface_width", "mobility", "spontaneous_curvature"];
pub(super) const AREA: &Keys = &["target", "penalty"];
pub(super) const NEMATIC: &Keys = &["weight", "mobility", "penalty", "initial"];
pub(super) const ANCHORING: &Keys = &["kind", "weight"];
pub(super) const FIELD: &Keys = &["weight", "strength", "angle", "from", "until"];
pub(super) const PULL: &Keys = &["potential"];
pub(super) const NOISE: &Keys = &["strength", "seed"];
pub(super) const SOLVER: &Keys = &[
    "quadrature",
    "iteration",
    "linear",
    "tolerance",
    "law_tolerance",
];

/// Of [vesicle], whatever its shape.
pub(super) const VESICLE: &Keys = &["shape", "parts", "projection", "scale"];
/// Of one outline: [vesicle] or an item of its `parts`.
pub(super) const CIRCLE: &Keys = &["shape", "radius", "center", "angle"];
pub(super) const ELLIPSE: &Keys = &["shape", "half_axes", "center", "angle"];
pub(super) const CASSINI: &Keys = &["shape", "ratio", "half_length", "center", "angle"];
pub(super) const DISCOCYTE: &Keys = &["shape", "radius", "center", "angle"];
/// Of [vesicle] alone.
pub(super) const RANDOM: &Keys = &["shape", "amplitude", "seed"];
pub(super) const FILE: &Keys = &["shape", "values"];

/// Every key that some shape has.
pub(super) const SHAPES: &Keys = &[
    "shape",
    "parts",
    "ratio",
    "half_length",
    "radius",
    "half_axes",
    "center",
    "angle",
    "amplitude",
    "seed",
    "values",
];

/// The first table that has a key of this name.
pub(super) fn table_with(key: &str) -> Option<&'static str> {
    let tables = [
        ("domain", DOMAIN),
        ("mesh", MESH),
        ("vesicle", VESICLE),
        ("vesicle", SHAPES),
        ("time", TIME),
        ("membrane", MEMBRANE),
        ("area", AREA),
        ("nematic", NEMATIC),
        ("anchoring", ANCHORING),
        ("field", FIELD),
        ("pull", PULL),
        ("noise", NOISE),
        ("solver", SOLVER),
    ];
    tables
        .iter()
        .find(|(_, keys)| keys.contains(&key))
        .map(|(table, _)| *table)
}
