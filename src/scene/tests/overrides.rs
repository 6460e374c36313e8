//! Arguments `--set KEY=VALUE`.

use super::{read, read_with};
use crate::scene::{
    AnchoringKind, Curve, InitialDirector, Origin, Outline, ScalarField, Scene, Shape, TimeScheme,
    preset,
};

fn case3(overrides: &[&str]) -> Scene {
    let text = preset("case3").expect("a preset");
    read_with(text, overrides, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn message(overrides: &[&str]) -> String {
    let text = preset("case3").expect("a preset");
    match read_with(text, overrides, &[]) {
        Ok(_) => panic!("{overrides:?} were taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn values_take_the_place_of_the_scenes() {
    let scene = case3(&[
        "time.step=2e-7",
        " mesh . cells = 60 ",
        "nematic.initial=[1,0]",
    ]);
    assert_eq!(scene.time.step, 2e-7);
    assert_eq!(scene.time.end, 1e-3, "the other keys of the table stay");
    assert_eq!(scene.mesh, read("mesh.cells = 60").mesh);
    let initial = scene.nematic.map(|nematic| nematic.initial);
    assert_eq!(initial, Some(InitialDirector::Uniform([1.0, 0.0])));
    assert_eq!(
        case3(&["time.step=1", "time.step=2"]).time.step,
        2.0,
        "the last one holds"
    );
}

#[test]
fn a_chosen_step_takes_the_place_of_a_given_one_and_the_other_way_round() {
    let given = case3(&[]);
    assert_eq!(
        (given.time.tolerance, given.time.scheme),
        (None, TimeScheme::FirstOrder)
    );
    let chosen = case3(&["time.tolerance=1e-4"]);
    assert_eq!(
        (chosen.time.tolerance, chosen.time.scheme),
        (Some(1e-4), TimeScheme::Secant)
    );
    assert_eq!(
        case3(&["time.tolerance=1e-4", "time.scheme=first-order"])
            .time
            .scheme,
        TimeScheme::FirstOrder
    );
    assert_eq!(
        case3(&["time.scheme=secant"]).time.scheme,
        TimeScheme::Secant
    );
    let written = given.to_toml();
    let again = read_with(&written, &["time.tolerance=1e-4"], &[]).expect("right");
    assert_eq!(again, chosen);
    let back = read_with(&chosen.to_toml(), &["time.step=1e-7"], &[]).expect("right");
    assert_eq!(back, given);
    for both in [
        message(&["time.tolerance=1e-4", "time.step=1e-7"]),
        read_with("time = { step = 1e-7, tolerance = 1e-4 }", &[], &[])
            .expect_err("both")
            .to_string(),
    ] {
        assert!(both.contains("give one of them, not both"), "{both}");
    }
}

#[test]
fn bare_words_are_strings() {
    let kind = |text: &str| case3(&[text]).anchoring.map(|anchoring| anchoring.kind);
    assert_eq!(
        kind("anchoring.kind=parallel"),
        Some(AnchoringKind::Parallel)
    );
    assert_eq!(
        kind("anchoring.kind=\"parallel\""),
        Some(AnchoringKind::Parallel)
    );
    assert_eq!(case3(&["name=Case 3, finer"]).name, "Case 3, finer");
    let formula = case3(&["membrane.spontaneous_curvature=2*x + y"]);
    let ScalarField::Expression(formula) = formula.membrane.spontaneous_curvature else {
        panic!("not a formula");
    };
    assert_eq!(formula.text(), "2*x + y");
}

#[test]
fn tables_are_made_and_taken_away() {
    let bending = read_with("", &["area.target=1.1"], &[]).expect("a scene");
    assert_eq!(
        bending.area.map(|area| (area.target, area.penalty)),
        Some((1.1, 1e-3))
    );
    assert_eq!(case3(&["area=false"]).area, None);
    let bare = case3(&["anchoring=false", "nematic=false"]);
    assert_eq!((bare.anchoring, bare.nematic), (None, None));
    assert_eq!(
        read_with("", &["area=false"], &[])
            .expect("no area to remove")
            .area,
        None
    );
    assert!(message(&["nematic=false"]).contains("--set anchoring=false"));
    assert!(message(&["mesh=false"]).contains("mesh must be a table"));
    assert!(message(&["aera=false"]).contains("did you mean 'area'?"));
}

#[test]
fn a_shape_takes_the_place_of_the_scenes_shape() {
    let circle = Curve::Circle { radius: 0.2 };
    let outline = |center| Outline {
        curve: circle,
        center,
        // Not that of the scene's own shape.
        angle: 0.0,
    };
    let scene = case3(&[
        "vesicle.radius=0.2",
        "vesicle.shape=circle",
        "vesicle.scale=1.5",
    ]);
    assert_eq!(
        scene.vesicle.shape,
        Shape::Outlines(vec![outline([0.5, 0.5])])
    );
    assert_eq!(scene.vesicle.scale, 1.5);

    let turned = case3(&[
        "vesicle.radius=0.2",
        "vesicle.shape=circle",
        "vesicle.angle=30",
    ]);
    let Shape::Outlines(turned) = turned.vesicle.shape else {
        panic!("{turned:?}");
    };
    assert_eq!(turned[0].angle, 30.0);

    let parts = "vesicle.parts=[{shape='circle',radius=0.2,center=[0.2,0.2]}]";
    assert_eq!(
        case3(&[parts]).vesicle.shape,
        Shape::Outlines(vec![outline([0.2, 0.2])])
    );

    let whole = "vesicle={shape='circle',radius=0.2}";
    assert_eq!(
        case3(&[whole]).vesicle.shape,
        Shape::Outlines(vec![outline([0.5, 0.5])])
    );

    let text = "[[vesicle.parts]]\nshape = 'circle'\nradius = 0.1";
    let scene = read_with(text, &["vesicle.shape=cassini"], &[]).expect("a shape");
    assert_eq!(scene.vesicle.shape, Scene::default().vesicle.shape);

    assert!(message(&["vesicle.radius=0.2"]).contains("'radius' does not belong to"));
    let ratio = message(&[
        "vesicle.shape=circle",
        "vesicle.radius=0.2",
        "vesicle.ratio=0.5",
    ]);
    assert!(
        ratio.contains("'ratio' does not belong to shape = \"circle\""),
        "{ratio}"
    );
    let both = message(&["vesicle.shape=circle", parts]);
    assert!(both.contains("exclude each other"), "{both}");
}

#[test]
fn errors_name_the_argument() {
    assert_eq!(
        message(&["mesh.cells=60", "time.step=-1"]),
        "--set time.step=-1: time.step must be a finite number > 0, not -1\n      \
               |\n\
         --set | time.step=-1\n      \
               |           ^^",
    );
    let text = preset("case3").expect("a preset");
    let error = read_with(text, &["area.penality = 1"], &[]).expect_err("no such key");
    assert_eq!(
        (&error.place.origin, error.place.column),
        (&Origin::Override, 6)
    );
    assert!(
        error.to_string().contains("did you mean 'penalty'?"),
        "{error}"
    );
    assert!(message(&["anchoring.kind=paralel"]).contains("did you mean 'parallel'?"));
    assert!(message(&["anchoring.kind=inf"]).contains("not a number"));
    assert!(message(&["time.step=fast"]).contains("must be a finite number > 0, not a string"));
}

#[test]
fn what_is_no_override() {
    let expected = "an override is KEY=VALUE, such as time.step=2e-7";
    for text in [
        "",
        "time.step",
        "=1",
        "time.=1",
        ".step=1",
        "time..step=1",
        "time.step=",
        "a= ",
    ] {
        assert!(message(&[text]).contains(expected), "{text}");
    }
    assert!(message(&[&format!("{}x=1", "a.".repeat(10_000))]).contains("more parts than any key"));
    assert!(message(&["nematic.initial=[1,0"]).contains("this is not valid TOML"));
    assert!(message(&["name=\"x"]).contains("this is not valid TOML"));
    assert!(message(&["vesicle={shape='circle'"]).contains("this is not valid TOML"));
    let through = message(&["nematic.initial.kind=random"]);
    assert!(through.contains("nematic.initial must be a table, to hold this key, not an array"));
}
