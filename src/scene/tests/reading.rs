//! What a scene's text means.

use super::{read, read_with};
use crate::scene::{
    Anchoring, AnchoringKind, Area, Boundary, Curve, Defect, InitialDirector, Iteration,
    LinearMethod, Mesh, Nematic, NodalValues, Outline, Projection, Quadrature, ScalarField, Scene,
    Shape, Vesicle, preset, preset_names,
};

/// The sample of the interface, as it is printed there.
const SAMPLE: &str = r#"
    name = "Case 3"
    [domain]
    boundary = "natural"                       # or "clamped": φ = −1 on the wall
    [mesh]
    kind = "structured"
    cells = 120           # h = 1/cells; right triangles, diagonals from lower left to upper right
    [vesicle]
    shape = "cassini"
    ratio = 0.92
    half_length = 0.32
    center = [0.5, 0.5]
    angle = 90   # degrees, of the long axis
    projection = "ritz"
    [time]
    step = 1e-7
    end = 1e-3
    [membrane]
    interface_width = 0.01
    mobility = 0.01
    spontaneous_curvature = 0.0
    [area]
    target = 1.25
    penalty = 1e-3
    [nematic]
    weight = 10.1
    mobility = 0.5
    penalty = 0.075
    initial = [0.0, 1.0]
    [anchoring]
    kind = "homeotropic"
    weight = 10.1
    [solver]
    quadrature = "consistent"
    iteration = "newton"
    tolerance = 1e-5
    law_tolerance = 1e-8
"#;

fn preset_scene(name: &str) -> Scene {
    read(preset(name).expect(name))
}

#[test]
fn the_printed_sample_is_case_3_and_the_defaults() {
    let sample = read(SAMPLE);
    assert_eq!(sample, preset_scene("case3"));
    let named = "name = \"Case 3\"\n[area]\n[nematic]\n[anchoring]\n";
    assert_eq!(
        read(named),
        sample,
        "a table without keys has the sample's values"
    );
}

#[test]
fn what_is_not_said_is_bending_alone() {
    let scene = read("");
    assert_eq!(scene, Scene::default());
    assert_eq!(scene.name, "Untitled");
    assert!(scene.area.is_none() && scene.nematic.is_none() && scene.anchoring.is_none());
    assert_eq!(
        read("[mesh]\n[vesicle]\n[time]\n[membrane]\n[domain]\n[solver]"),
        scene
    );
}

#[test]
fn the_presets_are_the_cases_of_the_paper() {
    for name in preset_names() {
        preset_scene(name);
    }
    let cases = [
        ("case1", 0.75, [0.0, 1.0]),
        ("case2", 0.75, [1.0, 0.0]),
        ("case3", 1.25, [0.0, 1.0]),
        ("case4", 1.25, [1.0, 0.0]),
    ];
    for (name, target, director) in cases {
        let scene = preset_scene(name);
        let expected = Scene {
            name: scene.name.clone(),
            area: Some(Area {
                target,
                penalty: 1e-3,
            }),
            nematic: Some(Nematic {
                weight: 10.1,
                mobility: 0.5,
                penalty: 0.075,
                initial: InitialDirector::Uniform(director),
            }),
            anchoring: Some(Anchoring {
                kind: AnchoringKind::Homeotropic,
                weight: 10.1,
            }),
            ..Scene::default()
        };
        assert_eq!(scene, expected);
    }
    let Scene {
        area,
        nematic,
        anchoring,
        ..
    } = preset_scene("bending");
    assert_eq!((area, nematic, anchoring), (None, None, None));
}

#[test]
fn every_choice_is_understood() {
    let scene = read(
        "domain.boundary = 'clamped'
         mesh = { kind = 'structured', cells = 0x10, jitter = 0.2, seed = 18446744073709551615 }
         [anchoring]\nkind = 'none'
         [solver]\nquadrature = 'lumped'\niteration = 'lagged'\nlinear = 'factor'",
    );
    assert_eq!(scene.boundary, Boundary::Clamped);
    assert_eq!(
        scene.mesh,
        Mesh::Structured {
            cells: 16,
            jitter: 0.2,
            seed: u64::MAX
        }
    );
    assert_eq!(scene.solver.quadrature, Quadrature::Lumped);
    assert_eq!(scene.solver.iteration, Iteration::Lagged);
    assert_eq!(scene.solver.linear, LinearMethod::Factor);
    assert_eq!(
        scene.anchoring,
        Some(Anchoring {
            kind: AnchoringKind::None,
            weight: 10.1
        })
    );
    assert_eq!(
        read("solver.linear = 'transform'").solver.linear,
        LinearMethod::Transform
    );
}

#[test]
fn every_shape_is_understood() {
    let outline = |curve| Outline {
        curve,
        center: [0.5, 0.5],
        // The paper's vesicle stands upright, the others lie along x.
        angle: match curve {
            Curve::Cassini { .. } => 90.0,
            _ => 0.0,
        },
    };
    let shape = |text: &str| read(&format!("[vesicle]\n{text}")).vesicle.shape;
    let one = |curve| Shape::Outlines(vec![outline(curve)]);

    assert_eq!(
        shape("shape='circle'\nradius=0.2"),
        one(Curve::Circle { radius: 0.2 })
    );
    let ellipse = Curve::Ellipse {
        half_axes: [0.3, 0.2],
    };
    assert_eq!(shape("shape='ellipse'\nhalf_axes=[0.3,0.2]"), one(ellipse));
    let cassini = Curve::Cassini {
        ratio: 0.5,
        half_length: 0.32,
    };
    assert_eq!(shape("ratio=0.5"), one(cassini));
    assert_eq!(
        shape("shape='discocyte'\nradius=0.3"),
        one(Curve::Discocyte { radius: 0.3 })
    );
    assert_eq!(
        shape("shape='stomatocyte'\nradius=0.3\nthickness=0.1\nopening=60"),
        one(Curve::Stomatocyte {
            radius: 0.3,
            thickness: 0.1,
            opening: 60.0
        })
    );
    assert_eq!(
        shape("shape='random'\namplitude=0.1"),
        Shape::Random {
            amplitude: 0.1,
            seed: 1
        }
    );
    assert_eq!(
        shape(
            "[[vesicle.parts]]\nshape='circle'\nradius=1\ncenter=[0,1]\n\
               [[vesicle.parts]]\nshape='ellipse'\nhalf_axes=[0.3,0.2]\nangle=30"
        ),
        Shape::Outlines(vec![
            Outline {
                center: [0.0, 1.0],
                ..outline(Curve::Circle { radius: 1.0 })
            },
            Outline {
                angle: 30.0,
                ..outline(ellipse)
            },
        ]),
    );
    assert_eq!(
        read("[vesicle]\nprojection='l2'\nscale=1.5").vesicle,
        Vesicle {
            projection: Projection::L2,
            scale: 1.5,
            ..Vesicle::default()
        },
    );
}

#[test]
fn every_initial_director_is_understood() {
    let initial = |text: &str| {
        read(&format!("[nematic]\ninitial = {text}"))
            .nematic
            .map(|nematic| nematic.initial)
    };
    assert_eq!(
        initial("[3, 0]"),
        Some(InitialDirector::Uniform([3.0, 0.0]))
    );
    assert_eq!(
        initial("{ kind = 'random', length = 0.5 }"),
        Some(InitialDirector::Random {
            seed: 1,
            length: 0.5
        }),
    );
    assert_eq!(
        initial(
            "{ kind = 'defects', at = [{}, { center = [0.1, 0.2], winding = -1 }], angle = 30 }"
        ),
        Some(InitialDirector::Defects {
            at: vec![
                Defect {
                    center: [0.5, 0.5],
                    winding: 1.0
                },
                Defect {
                    center: [0.1, 0.2],
                    winding: -1.0
                },
            ],
            angle: 30.0,
        }),
    );
}

#[test]
fn spontaneous_curvature_is_a_number_a_formula_or_a_file() {
    let curvature = |text: &str, files: &[(&str, &str)]| {
        let text = format!("mesh.cells = 4\nmembrane.spontaneous_curvature = {text}");
        read_with(&text, &[], files)
            .expect(&text)
            .membrane
            .spontaneous_curvature
    };
    assert_eq!(curvature("2", &[]), ScalarField::Constant(2.0));
    let formula = curvature("'2*x - y'", &[]);
    assert!(matches!(formula, ScalarField::Expression(_)));
    assert_eq!(formula.at(7, 0.5, 0.25), 0.75);
    let values: Vec<String> = (0..25).map(|node| node.to_string()).collect();
    let file = curvature("{ file = 'k.txt' }", &[("k.txt", &values.join("\n"))]);
    assert_eq!(file.at(7, 0.5, 0.25), 7.0);
}

#[test]
fn nodal_files_are_read_by_the_path_that_the_scene_gives() {
    let scalars = "0.5\n".repeat(25);
    let vectors = "0.5, 0.25\n".repeat(25);
    let scene = read_with(
        "mesh.cells = 4\nvesicle = { shape = 'file', values = 'a/phi0.txt' }\n\
         nematic.initial = { kind = 'file', values = 'd0.txt' }",
        &[],
        &[("a/phi0.txt", &scalars), ("d0.txt", &vectors)],
    )
    .expect("two files");
    let Shape::File(NodalValues {
        path,
        values,
        columns,
    }) = scene.vesicle.shape
    else {
        panic!("not a file: {:?}", scene.vesicle.shape);
    };
    assert_eq!(
        (path.as_str(), values.len(), columns),
        ("a/phi0.txt", 25, 1)
    );
    let Some(InitialDirector::File(director)) = scene.nematic.map(|nematic| nematic.initial) else {
        panic!("not a file");
    };
    assert_eq!(
        (&director.values[..2], director.values.len()),
        (&[0.5, 0.25][..], 50)
    );
}
