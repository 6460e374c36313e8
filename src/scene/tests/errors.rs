//! Every error says where, what, and what is allowed.

use super::read_with;
use crate::scene::{Origin, Scene, SceneError};

fn error(text: &str) -> SceneError {
    match read_with(text, &[], &[("phi0.txt", "1\n2\n")]) {
        Ok(scene) => panic!("{text:?} was read as {scene:?}"),
        Err(error) => error,
    }
}

/// The header of the message, without the excerpt.
fn message(text: &str) -> String {
    let message = error(text).to_string();
    message.split('\n').next().unwrap_or_default().to_owned()
}

#[test]
fn the_whole_message() {
    assert_eq!(
        error("[area]\ntarget = 1.1\npenality = 1e-3\n").to_string(),
        "a.toml:3:1: unknown key 'penality' in [area]; did you mean 'penalty'? \
         Allowed: target, penalty\n  \
           |\n\
         3 | penality = 1e-3\n  \
           | ^^^^^^^^",
    );
    let error = error("[area]\ntarget = -1");
    assert_eq!(error.place.origin, Origin::Text("a.toml".to_owned()));
    assert_eq!((error.place.line, error.place.column), (2, 10));
    assert!(
        error
            .to_string()
            .ends_with("2 | target = -1\n  |          ^^"),
        "{error}"
    );
}

#[test]
fn texts_that_are_not_toml() {
    assert!(message("[anchoring]\nkind = parallel").starts_with("a.toml:2:8: this is not valid"));
    assert!(message("[area]\n[area]").starts_with("a.toml:2:"));
    assert!(message("a = ").starts_with("a.toml:1:"));
}

#[test]
fn unknown_keys() {
    // The guide's example of an effect is there in tests only.
    assert_eq!(
        message("[aera]").replace("noise, tension,", "noise,"),
        "a.toml:1:2: unknown key 'aera' at the top level; did you mean 'area'? Allowed: name, accuracy, \
         domain, mesh, vesicle, time, rest, membrane, area, nematic, anchoring, field, pull, \
         noise, solver, change",
    );
    assert_eq!(
        message("[time]\ncells = 12"),
        "a.toml:2:1: unknown key 'cells' in [time]. It is a key of [mesh]. Allowed: step, tolerance, scheme, end",
    );
    assert!(message("[mesh]\nsze = 3").contains("jitter, size, interface, "));
    assert!(
        message("[nematic.initial]\nkind = 'random'\nseeds = 1").starts_with(
            "a.toml:3:1: unknown key 'seeds' in nematic.initial; did you mean 'seed'?"
        )
    );
    assert!(message("[vesicle]\nraito = 0.5").contains("did you mean 'ratio'?"));
    let part = message("vesicle.parts = [{ shape = 'circle', radius = 1, colour = 1 }]");
    assert!(
        part.contains("unknown key 'colour' in vesicle.parts[0]"),
        "{part}"
    );
}

#[test]
fn unknown_choices() {
    assert_eq!(
        message("anchoring.kind = 'homotropic'"),
        "a.toml:1:18: anchoring.kind cannot be 'homotropic'; did you mean 'homeotropic'? \
         Allowed: homeotropic, parallel, none",
    );
    assert!(message("vesicle.shape = 'egg'").contains(
        "vesicle.shape cannot be 'egg'. Allowed: circle, ellipse, cassini, discocyte, stomatocyte, random, file"
    ));
    let random = message("vesicle.parts = [{ shape = 'random' }]");
    assert!(
        random.ends_with("Allowed: circle, ellipse, cassini, discocyte, stomatocyte"),
        "{random}"
    );
    assert!(
        message("solver.linear = 'fast'")
            .contains("Allowed: automatic, transform, shifted, factor")
    );
    assert!(message("mesh.kind = 'unstructured'").contains("did you mean 'structured'?"));
}

#[test]
fn wrong_types() {
    assert_eq!(
        message("[area]\ntarget = 'big'"),
        "a.toml:2:10: area.target must be a finite number > 0, not a string",
    );
    assert_eq!(
        message("area = 3"),
        "a.toml:1:8: area must be a table, not a number"
    );
    assert_eq!(
        message("name = 3"),
        "a.toml:1:8: name must be a string, not a number"
    );
    assert!(message("mesh.cells = [1]").contains("must be a whole number from 4 to 20000, not an"));
    assert!(
        message("mesh.kind = true")
            .contains("must be one of \"structured\", \"delaunay\", \"adaptive\", \"file\", not")
    );
    assert!(message("[nematic]\ninitial = 1").contains("must be a vector such as [0.0, 1.0], or"));
    assert!(message("membrane.spontaneous_curvature = true").contains("an expression in x and y"));
    assert!(message("time.step = 1979-05-27").contains("not a date"));
    assert!(message("vesicle.parts = 1").contains("an array of one or more shapes"));
    assert!(message("vesicle.parts = [1]").contains("vesicle.parts[0] must be a table"));
}

#[test]
fn values_without_sense() {
    let refused = [
        ("time.step", "0", "a finite number > 0"),
        ("time.step", "-1e-7", "a finite number > 0"),
        ("time.tolerance", "0", "a finite number > 0"),
        ("time.end", "inf", "a finite number > 0"),
        ("time.end", "nan", "a finite number > 0"),
        ("time.end", "1e999", "a finite number > 0"),
        ("membrane.interface_width", "0.0", "a finite number > 0"),
        ("membrane.mobility", "0", "a finite number > 0"),
        ("membrane.spontaneous_curvature", "inf", "a finite number"),
        ("area.target", "0", "a finite number > 0"),
        ("area.penalty", "-1", "a finite number > 0"),
        ("nematic.weight", "-0.1", "a finite number ≥ 0"),
        ("nematic.mobility", "0", "a finite number > 0"),
        ("nematic.penalty", "0", "a finite number > 0"),
        ("anchoring.weight", "-1", "a finite number ≥ 0"),
        ("solver.tolerance", "0", "a finite number > 0"),
        ("solver.law_tolerance", "0", "a finite number > 0"),
        ("mesh.cells", "3", "a whole number from 4 to 20000"),
        ("mesh.cells", "20001", "a whole number from 4 to 20000"),
        ("mesh.cells", "120.0", "a whole number from 4 to 20000"),
        ("mesh.cells", "-120", "a whole number from 4 to 20000"),
        ("mesh.jitter", "0.9", "a number ≥ 0 and < 0.9"),
        (
            "mesh.seed",
            "-1",
            "a whole number from 0 to 18446744073709551615",
        ),
        ("vesicle.ratio", "1.0", "a number ≥ 0 and < 1"),
        ("vesicle.ratio", "-0.1", "a number ≥ 0 and < 1"),
        ("vesicle.half_length", "0", "a finite number > 0"),
        ("vesicle.angle", "nan", "a finite number"),
        ("vesicle.scale", "inf", "a finite number"),
        (
            "vesicle.center",
            "[0.5]",
            "an array of two numbers, such as [0.5, 0.5]",
        ),
        (
            "vesicle.parts",
            "[]",
            "an array of one or more shapes, such as \
            [{ shape = \"circle\", radius = 0.1 }]",
        ),
        ("name", "\" \"", "one line of text"),
        ("name", r#""a\nb""#, "one line of text"),
    ];
    for (key, value, allowed) in refused {
        let column = key.len() + 4;
        assert_eq!(
            message(&format!("{key} = {value}")),
            format!("a.toml:1:{column}: {key} must be {allowed}, not {value}"),
        );
    }
    assert_eq!(
        message("vesicle.center = [0.5, inf]"),
        "a.toml:1:24: vesicle.center[1] must be a finite number, not inf",
    );
    assert!(message("vesicle = { shape = 'circle', radius = 0 }").contains("vesicle.radius must"));
    assert!(
        message("vesicle = { shape = 'ellipse', half_axes = [0.1, 0] }")
            .contains("vesicle.half_axes[1] must be a finite number > 0, not 0")
    );
    assert!(message("nematic.initial = { kind = 'random', length = -1 }").contains("≥ 0, not -1"));
}

#[test]
fn keys_that_do_not_go_with_the_shape() {
    assert_eq!(
        message("[vesicle]\nshape = 'circle'\nradius = 0.2\nratio = 0.9"),
        "a.toml:4:1: 'ratio' does not belong to shape = \"circle\"; allowed: shape, radius, center, \
         angle, projection, scale",
    );
    assert_eq!(
        message("[vesicle]\nshape = 'circle'"),
        "a.toml:1:2: shape = \"circle\" needs the key 'radius'",
    );
    assert!(
        message("[vesicle]\nshape = 'file'").contains("shape = \"file\" needs the key 'values'")
    );
    assert!(message("[vesicle]\nradius = 0.2").contains("does not belong to shape = \"cassini\""));
    assert_eq!(
        message("[vesicle]\nshape = 'circle'\nparts = [{ shape = 'circle', radius = 1 }]"),
        "a.toml:2:1: vesicle.shape and vesicle.parts exclude each other: give one of them",
    );
    assert!(message("vesicle.parts = [{ radius = 1 }]").contains("vesicle.parts[0] needs the key"));
    assert!(
        message("vesicle = { center = [0, 0], parts = [{ shape = 'circle', radius = 1 }] }")
            .contains("'center' does not belong to parts")
    );
    assert!(message("[nematic.initial]").contains("nematic.initial needs the key 'kind'"));
    assert!(message("nematic.initial = { kind = 'defects' }").contains("needs the key 'at'"));
}

#[test]
fn an_anchoring_needs_a_director() {
    assert!(message("[anchoring]\nkind = 'parallel'").starts_with(
        "a.toml:2:8: anchoring.kind = \"parallel\" needs a director to anchor, and the scene has \
         no [nematic]"
    ));
    assert!(message("[anchoring]").starts_with("a.toml:1:2: anchoring.kind = \"homeotropic\""));
}

#[test]
fn the_keys_of_a_mesh_are_those_of_its_kind() {
    assert_eq!(
        message("[mesh]\nkind = 'delaunay'\ncells = 60"),
        "a.toml:3:1: 'cells' does not belong to mesh.kind = \"delaunay\"; allowed: kind, size, \
         refine, seed"
    );
    assert!(message("mesh.size = 0.1").contains("does not belong to mesh.kind = \"structured\""));
    assert!(message("mesh.kind = 'file'").contains("mesh.kind = \"file\" needs the key 'path'"));
    assert!(message("mesh.sise = 0.1").contains("did you mean 'size'?"));
    let delaunay = |rest: &str| message(&format!("mesh.kind = 'delaunay'\n{rest}"));
    assert!(delaunay("mesh.size = 0.3").contains("must be a number from 0.00005 to 0.25, not 0.3"));
    assert!(delaunay("mesh.refine.size = 0.001").contains("mesh.refine needs the key 'band'"));
    assert!(
        delaunay("mesh.size = 0.01\nmesh.refine = { band = 0.1, size = 0.02 }")
            .contains("mesh.refine.size must be a number from 0.00005 to 0.01, not 0.02")
    );
    let random = "mesh.kind = 'delaunay'\nvesicle = { shape = 'random', amplitude = 0.1 }\nmesh.refine = { band = 0.1, size = 0.005 }";
    assert!(message(random).contains("mesh.refine is about the initial membrane"));
}

#[test]
fn an_effect_on_the_director_needs_one() {
    for table in ["field", "noise"] {
        let expected = format!("a.toml:1:2: [{table}] acts on the director, and the scene has no");
        assert!(message(&format!("[{table}]")).starts_with(&expected));
    }
}

#[test]
fn what_added_effects_need() {
    assert_eq!(
        message("[nematic]\n[field]\nfrom = 1e-4\nuntil = 5e-5"),
        "a.toml:4:9: field.until must be a number > field.from = 0.0001, not 5e-5",
    );
    assert!(message("[pull]").starts_with("a.toml:1:2: [pull] needs the key 'potential'"));
    assert!(message("pull.potential = 'x +'").contains("pull.potential"));
    assert!(
        message("nematic = {}\n[noise]\nstrength = -1")
            .contains("noise.strength must be a finite number ≥ 0")
    );
}

#[test]
fn formulas_are_checked_where_they_stand() {
    let unknown = error("membrane.spontaneous_curvature = \"1 + z\"");
    assert_eq!((unknown.place.line, unknown.place.column), (1, 39));
    assert!(
        unknown
            .to_string()
            .contains("unknown name 'z' in the expression"),
        "{unknown}"
    );
    let end = error("membrane.spontaneous_curvature = '1 +'");
    assert_eq!(end.place.column, 38);
    assert_eq!(
        message("membrane.spontaneous_curvature = '1 / x'"),
        "a.toml:1:35: membrane.spontaneous_curvature: the expression is inf at (x, y) = (0, 0); it \
         must be finite in all of the domain",
    );
    let third = message("mesh.cells = 90\nmembrane.spontaneous_curvature = '1 / (90*x - 30)'");
    assert!(
        third.contains("the expression is inf at"),
        "tried at the nodes of the mesh: {third}"
    );
    let escaped = error("membrane.spontaneous_curvature = \"1 \\u002b z\"");
    assert_eq!(
        escaped.place.column, 34,
        "the whole string, where parts cannot be told"
    );
}

#[test]
fn files_of_nodal_values() {
    let missing = message("vesicle = { shape = 'file', values = 'nowhere.txt' }");
    assert!(
        missing.starts_with("a.toml:1:38: vesicle.values: the file 'nowhere.txt' cannot be read:"),
        "{missing}",
    );
    let short = message("mesh.cells = 4\nvesicle = { shape = 'file', values = 'phi0.txt' }");
    assert_eq!(
        short,
        "phi0.txt:3:1: vesicle.values must have a line for each of the 25 nodes of the mesh, \
         (mesh.cells + 1)² with mesh.cells = 4; this file has 2",
    );
    let columns = message("nematic.initial = { kind = 'file', values = 'phi0.txt' }");
    assert_eq!(
        columns,
        "phi0.txt:1:1: a line must hold 2 finite numbers (nematic.initial.values); '1' is not",
    );
}

#[test]
fn a_mesh_that_follows_the_membrane() {
    let adaptive = "[mesh]\nkind = \"adaptive\"\n";
    for (text, words) in [
        (
            "interface = 0.1",
            "mesh.interface must be a number from 0.00005 to 0.08",
        ),
        ("band = 0", "mesh.band must be"),
        ("refine = { band = 0.1, size = 0.01 }", "refine"),
        (
            "[vesicle]\nshape = \"file\"\nvalues = \"phi0.txt\"",
            "the nodes of a mesh that follows the membrane change, and 'phi0.txt' has values at nodes (vesicle.values)",
        ),
    ] {
        let message = message(&format!("{adaptive}{text}"));
        assert!(message.contains(words), "{message}");
    }
}

/// What a body of rotation cannot have.
#[test]
fn what_does_not_rotate_is_refused() {
    const SPHERE: &str = "domain.geometry = \"axisymmetric\"\nvesicle = { shape = \"circle\", radius = 0.2, center = [0.0, 0.5] }\n";
    let refused = |settings: &[&str]| -> String {
        let settings: Vec<String> = settings.iter().map(|it| (*it).to_owned()).collect();
        let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        match Scene::parse(SPHERE, "the test", &settings, &mut no_files) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    };
    assert_eq!(refused(&[]), "");
    assert_eq!(refused(&["vesicle.center=[0.5, 0.5]"]), "", "a ring");
    assert_eq!(refused(&["solver.linear=transform"]), "");
    let nematic = "nematic={}";
    assert_eq!(refused(&[nematic, "field.angle=-90"]), "");
    for (settings, words) in [
        (&["vesicle.center=[0.1, 0.5]"][..], "mirror image"),
        (
            &[
                "vesicle={ shape = 'ellipse', half_axes = [0.3, 0.2], center = [0.0, 0.5], angle = 30 }",
            ],
            "mirror image",
        ),
        (
            &[
                "vesicle={ shape = 'stomatocyte', radius = 0.3, thickness = 0.1, opening = 60, center = [0.0, 0.5], angle = 90 }",
            ],
            "of a stomatocyte 0 or 180",
        ),
        (&[nematic, "field.angle=0"], "field.angle must be 90"),
        (&[nematic, "field={}"], "field.angle must be 90"),
    ] {
        let error = refused(settings);
        assert!(error.contains(words), "{settings:?}: {error}");
    }
}

#[test]
fn a_stomatocyte_must_be_open() {
    let cup = |opening: f64, thickness: f64| {
        message(&format!(
            "vesicle = {{ shape = 'stomatocyte', radius = 0.3, thickness = {thickness}, opening = {opening} }}"
        ))
    };
    let closed = cup(38.0, 0.2);
    assert!(
        closed.contains("vesicle.opening must be greater than 38.9 degrees"),
        "{closed}"
    );
    let thick = cup(90.0, 0.6);
    assert!(
        thick.contains("vesicle.thickness must be less than twice the radius, 0.6"),
        "{thick}"
    );
    assert!(cup(360.0, 0.1).contains("a number > 0 and < 360"));
}

#[test]
fn of_an_outline_askew_on_the_axis_the_wrong_value_is_shown() {
    let axisymmetric = "[domain]\ngeometry = 'axisymmetric'\n";
    let place = |text: &str| {
        let error = error(&format!("{axisymmetric}{text}"));
        assert!(error.to_string().contains("mirror image"), "{error}");
        let lines = error.to_string();
        let shown = lines.lines().nth(2).unwrap_or_default().to_owned();
        let carets = lines.lines().nth(3).unwrap_or_default().to_owned();
        let begin = carets.find('^').expect("carets");
        shown[begin..carets.len()].to_owned()
    };
    let ellipse = "[vesicle]\nshape = 'ellipse'\nhalf_axes = [0.3, 0.2]\n";
    assert_eq!(
        place(&format!("{ellipse}center = [0.0, 0.5]\nangle = 30")),
        "30"
    );
    assert_eq!(
        place(&format!("{ellipse}center = [0.1, 0.5]\nangle = 30")),
        "[0.1, 0.5]"
    );
    // The center is not given, and is beside the axis.
    let wide = "[vesicle]\nshape = 'ellipse'\nhalf_axes = [0.3, 0.6]\nangle = 90";
    assert_eq!(place(wide), "'ellipse'");
    let first = "{ shape = 'ellipse', half_axes = [0.1, 0.05], center = [0.0, 0.2], angle = 90 }";
    let second = "{ shape = 'ellipse', half_axes = [0.1, 0.05], center = [0.0, 0.7], angle = 31 }";
    assert_eq!(
        place(&format!("[vesicle]\nparts = [\n{first},\n{second},\n]")),
        "31"
    );
}

#[test]
fn more_steps_than_can_be_counted_are_refused() {
    for (text, place) in [
        ("[time]\nstep = 1e-300", "a.toml:2:8"),
        ("[time]\nend = 1e300", "a.toml:2:7"),
        ("[time]\nstep = 1e-300\nend = 1e300", "a.toml:2:8"),
    ] {
        let message = message(text);
        assert!(message.starts_with(place), "{message}");
        assert!(message.contains("more than 1e18 steps"), "{message}");
        assert!(message.chars().count() < 200, "{message}");
    }
    let set = ["time.end=1e300"];
    let error = read_with("[time]\nstep = 1e-7", &set, &[]).expect_err("too many");
    assert!(
        error.to_string().starts_with("--set time.end=1e300"),
        "{error}"
    );
    for text in ["[time]\nend = 1e9", "[time]\ntolerance = 1e-3\nend = 1e300"] {
        assert!(read_with(text, &[], &[]).is_ok(), "{text}");
    }
}

#[test]
fn a_number_in_a_message_is_not_hundreds_of_zeros() {
    for text in [
        "[nematic]\n[field]\nfrom = 1e300\nuntil = 1e299",
        "[[change]]\nat = 1e-4\nover = 1e300\nset = { \"anchoring.kind\" = \"parallel\" }\n[nematic]\n[anchoring]",
        "[[change]]\nat = 1e-4\nover = 1e-300\nset = { \"anchoring.kind\" = \"parallel\" }\n[nematic]\n[anchoring]",
        "[domain]\ngeometry = 'axisymmetric'\n[nematic]\n[field]\nangle = 1e300",
    ] {
        let message = message(text);
        assert!(message.contains("1e"), "{message}");
        assert!(!message.contains("000000000"), "{message}");
    }
}
