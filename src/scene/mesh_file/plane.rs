//! Whether the nodes lie in the plane of x and y.

use nalgebra::{Point3, Vector3};

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
    let plane = first.at.z;
    let leaves = |node: &&FileNode| (node.at.z - plane).abs() > FLAT * extent;
    let Some(node) = nodes.iter().find(leaves) else {
        return Ok(());
    };
    let problem = match normal(nodes) {
        Some(normal) if all_on_plane(nodes, normal, extent) => MeshFileProblem::OtherPlane {
            plane: words(normal, first.at),
        },
        _ => MeshFileProblem::NotFlat {
            node: node.number,
            z: node.at.z,
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

/// The unit normal of the plane through the first node, the one farthest from it, and the one farthest
/// from the line through these; `None` where all are on a line.
fn normal(nodes: &[FileNode]) -> Option<Vector3<f64>> {
    let first = nodes.first()?.at;
    let longest = |one: &Vector3<f64>, other: &Vector3<f64>| {
        one.norm_squared().total_cmp(&other.norm_squared())
    };
    let offsets = || nodes.iter().map(|node| node.at - first);
    let along = offsets().max_by(longest)?;
    let normal = offsets()
        .map(|offset| along.cross(&offset))
        .max_by(longest)?;
    let length = normal.norm();
    (length > 0.0 && length.is_finite()).then(|| normal / length)
}

fn all_on_plane(nodes: &[FileNode], normal: Vector3<f64>, extent: f64) -> bool {
    let first = nodes.first().map_or(Point3::origin(), |node| node.at);
    nodes
        .iter()
        .all(|node| (node.at - first).dot(&normal).abs() <= FLAT * extent)
}

/// A plane in words.
fn words(normal: Vector3<f64>, at: Point3<f64>) -> String {
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
            let [x, y, z] = normal.into();
            format!("with the normal ({x:.3}, {y:.3}, {z:.3})")
        }
    }
}
