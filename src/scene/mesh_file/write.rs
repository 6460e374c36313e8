//! A mesh as a file: MSH 2.2 in ASCII, which every program reads.

use std::io::{self, Write};

use super::Triangulation;

/// Writes a mesh such that it reads back as the same one, bit for bit. Nodes and triangles are
/// numbered from 1 in their order.
///
/// # Errors
/// Those of `file`.
pub fn write_mesh(file: &mut dyn Write, mesh: &Triangulation) -> io::Result<()> {
    writeln!(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes")?;
    writeln!(file, "{}", mesh.nodes.len())?;
    for (number, node) in mesh.nodes.iter().enumerate() {
        writeln!(file, "{} {:?} {:?} 0", number + 1, node.x, node.y)?;
    }
    writeln!(file, "$EndNodes\n$Elements\n{}", mesh.triangles.len())?;
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|node| node + 1);
        writeln!(file, "{} 2 2 1 1 {a} {b} {c}", triangle + 1)?;
    }
    writeln!(file, "$EndElements")
}
