//! Whether the nodes lie in the plane of x and y.

use super::error::{MeshFileError, MeshFileProblem};
use super::read::FileNode;

/// Nodes this near to a plane, over the extent of the mesh, lie in it: more than rounding in a file with
/// few digits, or by a modeller's tolerance.
const FLAT: f64 = 1e-6;

/// Refuses nodes that are not finite or do not lie in the plane of x and y, or one parallel to it; says
/// in which they do.
pub(super) fn check(nodes: &[FileNode]) -> Result<(), MeshFileError> {
    for node in nodes {
        if let Some(&value) = node.at.iter().find(|value| !value.is_finite()) {
            let number = node.number;
            let problem = MeshFileProblem::NotFinite {
                node: number,
                value,
            };
            return Err(problem.at(node.place));
        }
    }
    let Some(first) = nodes.first() else {
        return Ok(());
    };
    let extent = (0..3).map(|axis| range(nodes, axis)).fold(0.0, f64::max);
    let plane = first.at[2];
    let leaves = |node: &&FileNode| (node.at[2] - plane).abs() > FLAT * extent;
    let Some(node) = nodes.iter().find(leaves) else {
        return Ok(());
    };
    let problem = match normal(nodes) {
        Some(normal) if all_on_plane(nodes, normal, extent) => MeshFileProblem::OtherPlane {
            plane: words(normal, first.at),
        },
        _ => MeshFileProblem::NotFlat {
            node: node.number,
            z: node.at[2],
            plane,
        },
    };
    Err(problem.at(node.place))
}

fn range(nodes: &[FileNode], axis: usize) -> f64 {
    let values = nodes.iter().map(|node| node.at[axis]);
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
        [low.min(at), high.max(at)]
    });
    high - low
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        a[next] * b[last] - a[last] * b[next]
    })
}

/// The unit normal of the plane through the first node, the one farthest from it, and the one farthest
/// from the line through these; `None` where all are on a line.
fn normal(nodes: &[FileNode]) -> Option<[f64; 3]> {
    let first = nodes.first()?.at;
    let longest =
        |one: &[f64; 3], other: &[f64; 3]| dot(*one, *one).total_cmp(&dot(*other, *other));
    let offsets = || nodes.iter().map(|node| minus(node.at, first));
    let along = offsets().max_by(longest)?;
    let normal = offsets()
        .map(|offset| cross(along, offset))
        .max_by(longest)?;
    let length = dot(normal, normal).sqrt();
    (length > 0.0 && length.is_finite()).then(|| normal.map(|component| component / length))
}

fn all_on_plane(nodes: &[FileNode], normal: [f64; 3], extent: f64) -> bool {
    let first = nodes.first().map_or([0.0; 3], |node| node.at);
    nodes
        .iter()
        .all(|node| dot(minus(node.at, first), normal).abs() <= FLAT * extent)
}

/// A plane in words.
fn words(normal: [f64; 3], at: [f64; 3]) -> String {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let axis = (0..3).find(|axis| normal[*axis].abs() > 1.0 - FLAT);
    match axis {
        Some(axis) => {
            let [next, last] = [(axis + 1) % 3, (axis + 2) % 3].map(|other| AXES[other]);
            let [next, last] = if next < last {
                [next, last]
            } else {
                [last, next]
            };
            format!("of {next} and {last}, {} = {}", AXES[axis], at[axis])
        }
        None => {
            let [x, y, z] = normal;
            format!("with the normal ({x:.3}, {y:.3}, {z:.3})")
        }
    }
}
