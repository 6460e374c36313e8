use super::*;

/// What Gmsh says of tests/meshes/square.geo.
const NODES: usize = 177;
const TRIANGLES: usize = 316;

/// A square of two triangles, and a node that none uses, as MSH 2.2; lines are replaced for errors.
const SQUARE: &str = "\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
2 1 \"inside\"
$EndPhysicalNames
$Nodes
5
10 0 0 0
20 2 0 0
99 7 7 7
30 2 1 0
40 0 1 0
$EndNodes
$Elements
4
1 15 2 0 1 10
2 1 2 0 1 10 20
3 2 2 0 1 10 20 30
4 2 2 0 1 10 40 30
$EndElements
";

fn parse(text: &str) -> Result<Triangulation, MeshFileError> {
    Triangulation::parse(text.as_bytes())
}

#[track_caller]
fn error(old: &str, new: &str) -> String {
    assert!(SQUARE.contains(old), "{old}");
    parse(&SQUARE.replacen(old, new, 1))
        .expect_err(new)
        .to_string()
}

#[test]
fn nodes_are_in_the_files_order_and_triangles_are_turned() {
    let mesh = parse(SQUARE).expect("a square");
    assert_eq!(mesh.nodes, [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.turned, 1);
    assert_eq!(mesh.places, [Some(0), Some(1), None, Some(2), Some(3)]);
}

#[test]
fn what_is_written_reads_back_exactly() {
    let mut mesh = parse(SQUARE).expect("a square");
    mesh.nodes[2] = [2.0 / 3.0, 1e-300 + 1.0 / 7.0];
    let mut text = Vec::new();
    write_mesh(&mut text, &mesh).expect("a vector takes everything");
    let again = Triangulation::parse(&text).expect("what was written");
    assert_eq!(
        (&again.nodes, &again.triangles),
        (&mesh.nodes, &mesh.triangles)
    );
    assert_eq!(again.turned, 0);
}

#[test]
fn every_format_of_gmsh_gives_the_same_mesh() {
    let text = Triangulation::parse(include_bytes!("../../../tests/meshes/square-22.msh"));
    let text = text.expect("MSH 2.2");
    assert_eq!((text.nodes.len(), text.triangles.len()), (NODES, TRIANGLES));
    let four = Triangulation::parse(include_bytes!("../../../tests/meshes/square-41.msh"));
    assert_eq!(four.expect("MSH 4.1"), text);
    let binary = include_bytes!("../../../tests/meshes/square-41-binary.msh");
    let binary = Triangulation::parse(binary).expect("binary");
    assert_eq!(
        (&binary.triangles, &binary.places),
        (&text.triangles, &text.places)
    );
    // Gmsh writes sixteen digits as text.
    for (one, other) in binary
        .nodes
        .iter()
        .flatten()
        .zip(text.nodes.iter().flatten())
    {
        assert!((one - other).abs() < 2e-16, "{one} {other}");
    }
    let area: f64 = text
        .triangles
        .iter()
        .map(|corners| area(&text, *corners))
        .sum();
    assert!((area - 1.0).abs() < 1e-12);
}

fn area(mesh: &Triangulation, corners: [u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|node| mesh.nodes[node as usize]);
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

#[test]
fn a_point_of_the_geometry_is_no_node_of_the_mesh() {
    let mesh = Triangulation::parse(include_bytes!("../../../tests/meshes/channel.msh"));
    let mesh = mesh.expect("a polygon");
    assert_eq!(mesh.places.len(), mesh.nodes.len() + 1);
    let area: f64 = mesh
        .triangles
        .iter()
        .map(|corners| area(&mesh, *corners))
        .sum();
    assert!((area - 1.775).abs() < 1e-12, "{area}");
}

#[test]
fn what_is_not_supported_is_named() {
    let quads = Triangulation::parse(include_bytes!("../../../tests/meshes/quads.msh"));
    let quads = quads.expect_err("quadrilaterals").to_string();
    assert!(
        quads.contains("is a quadrilateral, which is not supported"),
        "{quads}"
    );
    let binary = Triangulation::parse(include_bytes!("../../../tests/meshes/binary-22.msh"));
    let binary = binary.expect_err("MSH 2.2 in binary").to_string();
    assert!(
        binary.starts_with("line 2: MSH 2.2 in binary is not supported"),
        "{binary}"
    );
    assert!(
        error("4 2 2 0 1 10 40 30", "4 4 2 0 1 10 40 30 20")
            .starts_with("line 21: element 4 is a tetra")
    );
    assert!(error("4 2 2", "4 9 2").contains("a triangle of second order"));
    assert!(error("2.2 0 8", "4.0 0 8").contains("MSH 4.0 in ASCII is not supported"));
    assert!(error("$MeshFormat", "solid cube").starts_with("line 1: this is no mesh of Gmsh"));
}

#[test]
fn what_is_no_mesh_is_refused_with_its_place() {
    assert_eq!(
        error("20 2 0 0", "10 2 0 0"),
        "line 11: there are two nodes with the number 10"
    );
    assert_eq!(
        error("10 20 30", "10 21 30"),
        "line 20: element 3 has the node 21, which does not exist"
    );
    assert!(error("20 2 0 0", "20 nan 0 0").starts_with("line 11: node 20 has the coordinate NaN"));
    assert!(error("30 2 1 0", "30 2 1 1").starts_with("line 13: node 30 lies at z = 1"));
    assert!(error("40 0 1 0", "40 2 1 0").contains("nodes 30 and 40 are both at (2, 1)"));
    assert!(error("40 0 1 0", "40 4 2 0").contains("triangle 4 (nodes [10, 40, 30]) has no area"));
    assert!(error("10 40 30", "30 10 20").contains("the triangles 3 and 4 have the same nodes"));
    assert!(error("40 0 1 0", "40 4 1 0").contains("overlap: both lie on the same side"));
    assert!(error("40 0 1 0", "40 0 x 0").contains("line 14: expected a coordinate, found 'x'"));
    assert!(error("\n5\n", "\n6\n").contains("line 15: expected the number of a node"));
    assert!(error("\n5\n", "\n99999999999\n").contains("nodes cannot stand in what is left"));
    assert!(error("$EndElements", "$EndElement").contains("expected $EndElements"));
    assert!(
        error("$EndPhysicalNames", "$End").contains("where the end of the section should follow")
    );
    assert!(error("$Elements", "$ElementData").contains("the end of the section"));
    let cut = parse(&SQUARE[..SQUARE.len() - 40])
        .expect_err("cut off")
        .to_string();
    assert!(cut.contains("the file ends where"), "{cut}");
    let empty = SQUARE
        .replace("3 2 2 0 1 10 20 30\n4 2 2 0 1 10 40 30\n", "")
        .replace("\n4\n1", "\n2\n1");
    assert!(
        parse(&empty)
            .expect_err("lines only")
            .to_string()
            .contains("no triangle")
    );
}

#[test]
fn a_node_that_hangs_is_refused() {
    // The upper triangle's edge from 10 to 30 is divided by node 50, the lower one's is not.
    let divided = SQUARE
        .replace("99 7 7 7", "50 1 0.5 0")
        .replace("\n4\n1", "\n5\n1")
        .replace(
            "4 2 2 0 1 10 40 30",
            "4 2 2 0 1 10 50 40\n5 2 2 0 1 50 30 40",
        );
    let error = parse(&divided).expect_err("a hanging node").to_string();
    assert_eq!(
        error,
        "line 12: node 50 hangs: it lies within the edge of the nodes 10 and 30 of triangle 3, \
         which must be divided there"
    );
}

#[test]
fn a_mesh_in_pieces_is_refused() {
    let pieces = SQUARE
        .replace("99 7 7 7", "50 9 0 0\n60 9 1 0\n70 8 0 0")
        .replace("\n5\n10", "\n7\n10")
        .replace("\n4\n1", "\n5\n1")
        .replace("10 40 30", "10 40 30\n5 2 2 0 1 50 60 70");
    let error = parse(&pieces).expect_err("two pieces").to_string();
    assert!(
        error.contains("the mesh is in pieces: triangle 5"),
        "{error}"
    );
}
