//! Meshes that are no grid: the energy law holds on them, what comes from a file is in that file's
//! order, and a run on them can be recorded, gone on with and drawn like any other.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{TIGHT, energy_scale, scheme};
use vesica::internal::record::read_fields;
use vesica::internal::scene::{Triangulation, write_mesh};
use vesica::{Point, Scene, Simulation};

/// Every effect; the mesh and the vesicle are to be added.
const EFFECTS: &str = r#"
    [time]
    step = 1e-6
    end = 1e-5
    [membrane]
    interface_width = 0.06
    spontaneous_curvature = "2*sin(3*x) - y"
    [area]
    target = 1.1
    [nematic]
    initial = { kind = "random", seed = 3, length = 1.5 }
    [anchoring]
    kind = "homeotropic"
"#;

const IN_SQUARE: &str =
    "[vesicle]\nshape = \"ellipse\"\nhalf_axes = [0.3, 0.2]\ncenter = [0.48, 0.51]\nangle = 70\n";
const IN_CHANNEL: &str =
    "[vesicle]\nshape = \"ellipse\"\nhalf_axes = [0.4, 0.2]\ncenter = [-0.6, -0.1]\nangle = 10\n";

fn meshes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes")
}

fn scene(mesh: &str, vesicle: &str, settings: &[&str]) -> Scene {
    let text = format!("name = \"Unstructured\"\n[mesh]\n{mesh}\n{vesicle}{EFFECTS}");
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    let mut read = |path: &str| fs::read(meshes().join(path));
    Scene::parse(&text, "the test", &settings, &mut read).unwrap_or_else(|error| panic!("{error}"))
}

const DELAUNAY: &str = "kind = \"delaunay\"\nsize = 0.06";
const GRADED: &str = "kind = \"delaunay\"\nsize = 0.12\nrefine = { band = 0.1, size = 0.04 }";
const SQUARE: &str = "kind = \"file\"\npath = \"square-41-binary.msh\"";
const CHANNEL: &str = "kind = \"file\"\npath = \"channel.msh\"";

#[test]
fn the_energy_law_holds_and_the_volume_stays() {
    for (mesh, vesicle) in [
        (DELAUNAY, IN_SQUARE),
        (GRADED, IN_SQUARE),
        (SQUARE, IN_SQUARE),
        (CHANNEL, IN_CHANNEL),
    ] {
        for boundary in ["domain.boundary=natural", "domain.boundary=clamped"] {
            for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
                for step in [1e-8, 1e-6, 1e-4] {
                    let settings = [&TIGHT[..], &[boundary, quadrature]].concat();
                    let scene = scene(mesh, vesicle, &settings);
                    let mut scheme = scheme(&scene);
                    let start = scheme.report().phase_integral;
                    for number in 1..=3 {
                        let place = format!("{mesh} {settings:?} {step:e} {number}");
                        let before = scheme.report().total_energy;
                        let report = scheme.step(step).unwrap_or_else(|e| panic!("{place}: {e}"));
                        assert!(report.law_residual.abs() <= 1e-12, "{place}: {report:?}");
                        let scale = energy_scale(report);
                        assert!(report.total_energy - before <= 1e-12 * scale, "{place}");
                        for term in report.ledger.iter().filter(|t| t.name.starts_with("ND")) {
                            assert!(term.value >= -1e-14 * scale, "{place}: {term:?}");
                        }
                        let drift = report.phase_integral - start;
                        assert!(drift.abs() < 2e-13, "{place}: {drift:e}");
                    }
                }
            }
        }
    }
}

/// By rotation the nodes of the file at x = 0 are the axis.
#[test]
fn a_gmsh_mesh_can_be_rotated() {
    const ON_AXIS: &str = "[vesicle]\nshape = \"ellipse\"\nhalf_axes = [0.3, 0.2]\ncenter = [0.0, 0.51]\n\
                           [domain]\ngeometry = \"axisymmetric\"\n";
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        for boundary in ["domain.boundary=natural", "domain.boundary=clamped"] {
            let settings = [&TIGHT[..], &[boundary, quadrature]].concat();
            let mut scheme = scheme(&scene(SQUARE, ON_AXIS, &settings));
            let start = scheme.report().phase_integral;
            for number in 1..=3 {
                let place = format!("{settings:?} {number}");
                let report = scheme.step(1e-6).unwrap_or_else(|e| panic!("{place}: {e}"));
                assert!(report.law_residual.abs() <= 1e-12, "{place}: {report:?}");
                let drift = report.phase_integral - start;
                assert!(drift.abs() < 2e-13, "{place}: {drift:e}");
            }
            let mesh = scheme.space().mesh();
            // The cylinder of radius and height 1.
            let volume: f64 = mesh.measures().iter().sum();
            assert!((volume / std::f64::consts::PI - 1.0).abs() < 1e-13);
            let director = scheme.state().director.as_ref().expect("a nematic");
            let on_axis = || director[0].iter().zip(mesh.on_axis()).filter(|(_, on)| *on);
            assert!(on_axis().count() > 5 && on_axis().all(|(radial, _)| *radial == 0.0));
        }
    }
    let mut read = |path: &str| fs::read(meshes().join(path));
    let text = format!("[mesh]\n{CHANNEL}\n{ON_AXIS}");
    let error = Scene::parse(&text, "the test", &[], &mut read).expect_err("it has x < 0");
    assert!(
        error.to_string().contains("none may be at x < 0"),
        "{error}"
    );
}

fn vesica(folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_vesica"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("it starts");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {told}");
    output
}

/// The mesh of a file with its nodes and triangles in another order, and which node went where.
fn shuffled(mesh: &Triangulation) -> (Triangulation, Vec<usize>) {
    let count = mesh.nodes.len();
    // A step that has no factor in common with the number of nodes visits all of them.
    let stride =
        (count / 3..).find(|s| (2..=*s).all(|f| !s.is_multiple_of(f) || !count.is_multiple_of(f)));
    let stride = stride.expect("there is a prime");
    let to: Vec<usize> = (0..count).map(|node| node * stride % count).collect();
    let mut other = mesh.clone();
    for (node, place) in mesh.nodes.iter().zip(&to) {
        other.nodes[*place] = *node;
    }
    other.triangles.reverse();
    for triangle in &mut other.triangles {
        *triangle = triangle.map(|node| to[node as usize] as u32);
        triangle.rotate_left(1);
    }
    (other, to)
}

/// The same mesh in another order is the same run, value by value, and the order is that of the file
/// in what is read and in what is written.
#[test]
fn values_are_in_the_order_of_the_file() {
    let bytes = fs::read(meshes().join("square-22.msh")).expect("a mesh");
    let mesh = Triangulation::parse(&bytes).expect("a mesh");
    let (other, to) = shuffled(&mesh);
    let value = |at: Point| (8.0 * (0.3 - (at.x - 0.5).hypot(0.8 * (at.y - 0.5)))).tanh();
    let folder = tempfile::tempdir().expect("a folder");
    let text = |mesh: &str| {
        let [_, rest] = EFFECTS
            .split_once("[nematic]")
            .map(|(a, b)| [a, b])
            .expect("it is there");
        let before = EFFECTS.split("[nematic]").next().expect("a part");
        let rest = rest
            .split_once('\n')
            .and_then(|(_, rest)| rest.split_once('\n'));
        let after = rest.expect("a line").1;
        let director = format!("initial = {{ kind = \"file\", values = \"d-{mesh}.txt\" }}");
        let curvature = format!("spontaneous_curvature = {{ file = \"phi-{mesh}.txt\" }}");
        let before: String = before
            .lines()
            .filter(|line| !line.contains("spontaneous"))
            .map(|line| format!("{line}\n"))
            .collect();
        let before = before.replace("[membrane]", &format!("[membrane]\n{curvature}"));
        format!(
            "[mesh]\nkind = \"file\"\npath = \"{mesh}.msh\"\n\
             [vesicle]\nshape = \"file\"\nvalues = \"phi-{mesh}.txt\"\n\
             {before}[nematic]\n{director}\n{after}"
        )
    };
    for (name, mesh) in [("one", &mesh), ("other", &other)] {
        let mut file = Vec::new();
        write_mesh(&mut file, mesh).expect("a vector takes everything");
        fs::write(folder.path().join(format!("{name}.msh")), file).expect("written");
        let phi: String = mesh
            .nodes
            .iter()
            .map(|at| format!("{:?}\n", value(*at)))
            .collect();
        fs::write(folder.path().join(format!("phi-{name}.txt")), phi).expect("written");
        let director = |at: &Point| format!("{:?} {:?}\n", at.x, 1.0 - at.y);
        let director: String = mesh.nodes.iter().map(director).collect();
        fs::write(folder.path().join(format!("d-{name}.txt")), director).expect("written");
        fs::write(folder.path().join(format!("{name}.toml")), text(name)).expect("written");
        let arguments = [
            "run",
            &format!("{name}.toml"),
            "--out",
            name,
            "--steps",
            "3",
        ];
        vesica(folder.path(), &arguments);
    }
    let fields = |run: &str, file: &str| {
        let path = folder.path().join(run).join(file);
        read_fields(&path).unwrap_or_else(|error| panic!("{error}"))
    };
    let initial = fields("one", "fields/step-0000000.vtu");
    assert_eq!(initial.mesh.nodes(), mesh.nodes);
    for (phi, at) in initial.state.phi.iter().zip(&mesh.nodes) {
        assert_eq!(*phi, value(*at));
    }
    let [one, other] = ["one", "other"].map(|run| fields(run, "final.vtu"));
    for (node, place) in to.iter().enumerate() {
        assert_eq!(one.mesh.nodes()[node], other.mesh.nodes()[*place]);
        for ((_, a), (_, b)) in crate::common::fields(&one.state)
            .iter()
            .zip(crate::common::fields(&other.state))
        {
            assert_eq!(a[node].to_bits(), b[*place].to_bits());
        }
    }
    // The folder alone gives the same run again, and the run can be gone on with.
    vesica(
        folder.path(),
        &["run", "other/scene.toml", "--out", "again", "--steps", "2"],
    );
    vesica(
        folder.path(),
        &[
            "run",
            "other/scene.toml",
            "--out",
            "again",
            "--steps",
            "3",
            "--resume",
        ],
    );
    let again = fields("again", "final.vtu");
    assert_eq!(again.state, other.state);
    // Figures of the folder.
    vesica(folder.path(), &["figures", "again", "--out", "figures"]);
}

#[test]
fn the_check_tells_how_good_the_triangles_are() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::copy(
        meshes().join("channel.msh"),
        folder.path().join("channel.msh"),
    )
    .expect("copied");
    let text = format!(
        "[mesh]\n{CHANNEL}\n[vesicle]\nshape = \"circle\"\nradius = 0.2\ncenter = [0.25, 0.2]\n{EFFECTS}"
    );
    fs::write(folder.path().join("channel.toml"), text).expect("written");
    let output = vesica(folder.path(), &["check", "--quick", "channel.toml"]);
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(
        told.contains("triangles with angles from ") && told.contains("198 nodes"),
        "{told}"
    );
    let warned = String::from_utf8_lossy(&output.stderr);
    assert!(
        warned.contains("the membrane comes within 0.050 of the wall"),
        "{warned}"
    );
    assert!(warned.contains("the interface spans 0."), "{warned}");
    let settings = ["mesh.kind=delaunay", "mesh.size=0.05"]
        .map(|s| ["--set", s])
        .concat();
    let arguments = [&["check", "--quick", "case3"][..], &settings].concat();
    let told = vesica(folder.path(), &arguments);
    let told = String::from_utf8_lossy(&told.stdout);
    assert!(told.contains("triangles with angles from "), "{told}");
}

#[test]
fn a_circle_outside_of_the_domain_is_refused() {
    let scene = scene(
        CHANNEL,
        "[vesicle]\nshape = \"circle\"\nradius = 0.1\ncenter = [-1.0, 0.6]\n",
        &[],
    );
    let error = Simulation::new(&scene).expect_err("no vesicle").to_string();
    assert!(
        error.contains("lies outside of the domain, which reaches from ("),
        "{error}"
    );
}
