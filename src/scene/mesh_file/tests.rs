use super::*;
use crate::geometry::doubled_area;

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
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
    assert_eq!(mesh.nodes, corners.map(Point::from));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.turned, 1);
    assert_eq!(mesh.places, [Some(0), Some(1), None, Some(2), Some(3)]);
}

#[test]
fn what_is_written_reads_back_exactly() {
    let mut mesh = parse(SQUARE).expect("a square");
    mesh.nodes[2] = Point::new(2.0 / 3.0, 1e-300 + 1.0 / 7.0);
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
    let older = include_bytes!("../../../tests/meshes/binary-22.msh");
    for binary in [&binary[..], &older[..]] {
        is_the_same(&Triangulation::parse(binary).expect("binary"), &text);
    }
    let area: f64 = text
        .triangles
        .iter()
        .map(|corners| area(&text, *corners))
        .sum();
    assert!((area - 1.0).abs() < 1e-12);
}

/// Whether a mesh from binary data is one from a text, where Gmsh writes sixteen digits.
#[track_caller]
fn is_the_same(binary: &Triangulation, text: &Triangulation) {
    assert_eq!(
        (&binary.triangles, &binary.places),
        (&text.triangles, &text.places)
    );
    for (one, other) in binary.nodes.iter().zip(&text.nodes) {
        assert!((one - other).abs().max() < 2e-16, "{one} {other}");
    }
}

#[test]
fn places_on_curves_and_surfaces_are_passed_over() {
    let text = Triangulation::parse(include_bytes!("../../../tests/meshes/parametric-22.msh"));
    let text = text.expect("$ParametricNodes");
    assert_eq!((text.nodes.len(), text.triangles.len()), (12, 14));
    let binary = include_bytes!("../../../tests/meshes/parametric-22-binary.msh");
    is_the_same(&Triangulation::parse(binary).expect("binary"), &text);
    let four = include_bytes!("../../../tests/meshes/parametric-41.msh");
    assert_eq!(Triangulation::parse(four), Ok(text));
}

#[test]
fn a_mesh_in_partitions_is_read_whole_or_not_at_all() {
    let two = Triangulation::parse(include_bytes!("../../../tests/meshes/partitioned-22.msh"));
    let two = two.expect("MSH 2.2");
    let areas = two.triangles.iter().map(|corners| area(&two, *corners));
    assert!((areas.sum::<f64>() - 1.0).abs() < 1e-12);
    let binary = include_bytes!("../../../tests/meshes/partitioned-22-binary.msh");
    is_the_same(&Triangulation::parse(binary).expect("binary"), &two);
    let four = Triangulation::parse(include_bytes!("../../../tests/meshes/partitioned-41.msh"));
    let four = four.expect("MSH 4.1");
    let binary = include_bytes!("../../../tests/meshes/partitioned-41-binary.msh");
    is_the_same(&Triangulation::parse(binary).expect("binary"), &four);
    assert_eq!(four.triangles.len(), two.triangles.len());

    let parts: [(&[u8], &str); 4] = [
        (
            include_bytes!("../../../tests/meshes/part-22_2.msh"),
            "several",
        ),
        (
            include_bytes!("../../../tests/meshes/part-22-binary_2.msh"),
            "several",
        ),
        (include_bytes!("../../../tests/meshes/part-41_2.msh"), "3"),
        (
            include_bytes!("../../../tests/meshes/part-41-binary_2.msh"),
            "3",
        ),
    ];
    for (part, of) in parts {
        let error = Triangulation::parse(part).expect_err("a part").to_string();
        let words =
            format!("the file has 1 of {of} partitions of a mesh: give the file of the whole");
        assert!(error.contains(&words), "{error}");
    }
}

#[test]
fn what_editors_and_scripts_leave_is_read() {
    let plain = parse(SQUARE).expect("a square");
    let marked = [b"\xef\xbb\xbf", SQUARE.as_bytes()].concat();
    assert_eq!(Triangulation::parse(&marked).as_ref(), Ok(&plain));
    let commented = format!("$Comments\nmade by hand $End\n$EndComments\n{SQUARE}");
    assert_eq!(parse(&commented).as_ref(), Ok(&plain));
    let windows = SQUARE.replace('\n', "\r\n");
    assert_eq!(parse(&windows).as_ref(), Ok(&plain));
    // More nodes in the head than follow.
    let more = SQUARE.replacen("\n5\n", "\n7\n", 1);
    assert_eq!(parse(&more).as_ref(), Ok(&plain));
    let four = include_str!("../../../tests/meshes/parametric-41.msh");
    let head = four
        .split("$Nodes\n")
        .nth(1)
        .and_then(|rest| rest.lines().next());
    let head = head.expect("a head");
    let more = four.replacen(head, &head.replacen(" 12 ", " 19 ", 1), 1);
    assert_ne!(four, more);
    assert_eq!(parse(&more), parse(four));
    // A surface in two physical groups.
    let groups = SQUARE.replace("\n4\n1", "\n6\n1").replace(
        "10 40 30\n",
        "10 40 30\n5 2 2 8 1 10 20 30\n6 2 2 8 1 10 40 30\n",
    );
    assert_eq!(parse(&groups).as_ref(), Ok(&plain));
    let twice = groups.replace("2 2 8 1", "2 2 0 1");
    let twice = parse(&twice).expect_err("in one group").to_string();
    assert!(
        twice.contains("the triangles 3 and 5 have the same nodes"),
        "{twice}"
    );
    let wide: Vec<u8> = SQUARE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let wide = Triangulation::parse(&[b"\xff\xfe", &wide[..]].concat());
    let wide = wide.expect_err("UTF-16").to_string();
    assert!(wide.contains("UTF-16: save it in UTF-8"), "{wide}");
}

#[test]
fn what_cannot_be_read_is_named_with_its_section_and_a_remedy() {
    for (error, section) in [
        (error("40 0 1 0", "40 0 x 0"), "Nodes"),
        (error("1 15 2", "1 fifteen 2"), "Elements"),
        (error("2.2 0 8", "2.2 2 8"), "MeshFormat"),
        (error("\n5\n", "\n99999999999\n"), "Nodes"),
    ] {
        let words = format!("in the section ${section}; Gmsh writes a file that is read: gmsh");
        assert!(error.contains(&words), "{error}");
    }
    let without = error("$Nodes", "$Vertices").to_string();
    assert!(without.contains("the end of the section"), "{without}");
    let old = "$NOD\n1\n1 0 0 0\n$ENDNOD\n";
    let old = parse(old).expect_err("MSH 1").to_string();
    assert!(
        old.contains("MSH 1.0 in ASCII is not supported") && old.contains("convert"),
        "{old}"
    );
}

#[test]
fn noise_across_the_plane_is_flat_and_another_plane_is_named() {
    let noisy = SQUARE
        .replace("20 2 0 0", "20 2 0 2e-7")
        .replace("30 2 1 0", "30 2 1 -2e-7");
    assert_eq!(parse(&noisy), parse(SQUARE));
    let plane = |nodes: [&str; 4]| {
        let old = ["10 0 0 0", "20 2 0 0", "30 2 1 0", "40 0 1 0"];
        let text = old
            .iter()
            .zip(nodes)
            .fold(SQUARE.to_owned(), |text, (old, new)| text.replace(old, new));
        parse(&text).expect_err("another plane").to_string()
    };
    let upright = plane(["10 3 0 0", "20 3 2 0", "30 3 2 1", "40 3 0 1"]);
    assert!(
        upright.contains("flat, but lies in the plane of y and z, x = 3"),
        "{upright}"
    );
    let other = plane(["10 0 0 0", "20 2 0 0", "30 2 0 1", "40 0 0 1"]);
    assert!(other.contains("in the plane of x and z, y = 0"), "{other}");
    let tilted = plane(["10 0 0 0", "20 2 0 2", "30 2 1 2", "40 0 1 0"]);
    assert!(
        tilted.contains("with the normal (-0.707, 0.000, 0.707)"),
        "{tilted}"
    );
    let bent = plane(["10 0 0 0", "20 2 0 0", "30 2 1 1", "40 0 1 0"]);
    assert!(bent.contains("lies at z = 1, others at z = 0"), "{bent}");
}

fn area(mesh: &Triangulation, corners: [u32; 3]) -> f64 {
    0.5 * doubled_area(corners.map(|node| mesh.nodes[node as usize]))
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

/// The square with `nodes` (from 50 on) and `elements` (from 5 on) in addition.
fn with_more(nodes: &str, elements: &str) -> String {
    let counts = [5 + nodes.lines().count(), 4 + elements.lines().count()];
    SQUARE
        .replacen("\n5\n", &format!("\n{}\n", counts[0]), 1)
        .replacen("\n4\n1 15", &format!("\n{}\n1 15", counts[1]), 1)
        .replacen("$EndNodes", &format!("{nodes}\n$EndNodes"), 1)
        .replacen("$EndElements", &format!("{elements}\n$EndElements"), 1)
}

#[test]
fn what_overlaps_is_refused_with_both_triangles_and_the_place() {
    let refused = |nodes: &str, elements: &str| {
        let error = parse(&with_more(nodes, elements)).expect_err("no domain");
        error.to_string()
    };
    // The domain of the square and of a triangle on it, from one of its corners.
    let over = refused("50 1.5 0.2 0\n60 0.3 0.6 0", "5 2 2 0 2 10 50 60");
    assert!(
        over.contains("the triangles 3 and 5 overlap at their common node 10, (0, 0)"),
        "{over}"
    );
    // The same from a corner that is not shared: the edges cross.
    let beside = refused(
        "50 -1 0 0\n60 0.5 0.5 0",
        "5 2 2 0 2 10 40 50\n6 2 2 0 2 50 40 60",
    );
    assert!(beside.contains("overlap"), "{beside}");
    // A strip that goes down, turns round and comes up over the square.
    let strip = refused(
        "50 3 -1 0\n60 2 -1 0\n70 1 -1.2 0\n80 2 -2 0\n90 1.25 0.25 0",
        "5 2 2 0 2 20 60 50\n6 2 2 0 2 20 50 30\n7 2 2 0 2 60 80 50\n8 2 2 0 2 60 70 80\n\
         9 2 2 0 2 60 90 70",
    );
    assert!(
        strip.contains("the triangles 3 and 9 overlap: their edges cross at (1."),
        "{strip}"
    );
}

#[test]
fn parts_that_meet_in_a_corner_are_refused() {
    let error = parse(&with_more("50 3 1 0\n60 3 2 0", "5 2 2 0 2 30 50 60"));
    let error = error.expect_err("two parts").to_string();
    assert!(
        error.contains(
            "with the triangles 3 and 5 meet in nothing but the node 30 there, at (2, 1)"
        ),
        "{error}"
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

/// A section of a file with its name and its end.
fn section<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
    let at = |words: &str| {
        let mut windows = file.windows(words.len());
        windows.position(|window| window == words.as_bytes())
    };
    let end = format!("$End{name}\n");
    let range = at(&format!("${name}\n")).zip(at(&end));
    let (begin, last) = range.expect("the section is there");
    &file[begin..last + end.len()]
}

/// Nothing of a file is left out unnoticed: a second section might be half of the mesh.
#[test]
fn a_second_section_is_refused_in_every_format() {
    let files: [(&[u8], &str); 5] = [
        (SQUARE.as_bytes(), "line "),
        (
            include_bytes!("../../../tests/meshes/square-22.msh"),
            "line ",
        ),
        (
            include_bytes!("../../../tests/meshes/square-41.msh"),
            "line ",
        ),
        (
            include_bytes!("../../../tests/meshes/binary-22.msh"),
            "byte ",
        ),
        (
            include_bytes!("../../../tests/meshes/square-41-binary.msh"),
            "byte ",
        ),
    ];
    for (file, place) in files {
        for name in ["Nodes", "Elements", "MeshFormat"] {
            let twice = [file, section(file, name)].concat();
            let error = Triangulation::parse(&twice).expect_err("twice").to_string();
            assert!(error.starts_with(place), "{error}");
            let words = format!("a second section ${name}, after that at ");
            assert!(error.contains(&words), "{error}");
        }
    }
    let more = SQUARE.replace(
        "$Elements\n",
        "$ParametricNodes\n0\n$EndParametricNodes\n$Elements\n",
    );
    assert_eq!(
        parse(&more).expect_err("nodes twice").to_string(),
        "line 16: the file has a second section $ParametricNodes, after that at line 8, and a mesh has one of \
         each: put what it holds into the first one; of two meshes make one in Gmsh, from one geometry"
    );
}

#[test]
fn a_section_before_the_format_is_named() {
    for name in ["Nodes", "Elements"] {
        let moved = section(SQUARE.as_bytes(), name);
        let text = [moved, SQUARE.as_bytes()].concat();
        let error = Triangulation::parse(&text).expect_err("too early");
        assert_eq!(
            error.to_string(),
            format!(
                "line 1: the section ${name} stands before any $MeshFormat, which says how it is to be read: \
                 begin the file with $MeshFormat"
            )
        );
    }
}

#[test]
fn a_part_within_another_overlaps_it() {
    let refused = |nodes: &str, element: &str| {
        let error = parse(&with_more(nodes, element)).expect_err("no domain");
        error.to_string()
    };
    assert_eq!(
        refused(
            "50 1.2 0.2 0\n60 1.4 0.2 0\n70 1.3 0.3 0",
            "5 2 2 0 2 50 60 70"
        ),
        "line 25: the triangles 3 and 5 overlap: node 50 of triangle 5 lies within triangle 3, at (1.2, 0.2) \
         (in Gmsh: BooleanFragments, before it meshes)"
    );
    // Over the edge that two triangles share, with all nodes on it or beside it.
    let across = refused(
        "50 0.2 0.1 0\n60 1.4 0.7 0\n70 1.3 0.3 0",
        "5 2 2 0 2 50 60 70",
    );
    assert!(across.contains("and 5 overlap: node 50"), "{across}");
    // Around the whole square.
    let around = refused("50 -9 -9 0\n60 20 -9 0\n70 0 20 0", "5 2 2 0 2 50 60 70");
    assert!(
        around.contains(
            "the triangles 5 and 3 overlap: node 10 of triangle 3 lies within triangle 5"
        ),
        "{around}"
    );
}
