//! A scene that is written reads back as the same scene.

use super::{read, read_with};
use crate::scene::{DefaultValue, Parameter, TableInfo, preset, preset_names, tables};

/// Files for a mesh of 4 × 4 squares.
fn check(text: &str) {
    let scalars = "0.5\n".repeat(25);
    let vectors = "0.5 1\n".repeat(25);
    let files = [
        ("s \"1\".txt", scalars.as_str()),
        ("v.txt", vectors.as_str()),
    ];
    let scene = read_with(text, &[], &files).unwrap_or_else(|error| panic!("{error}"));
    let written = scene.to_toml();
    let again = read_with(&written, &[], &files).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again, scene, "{written}");
    assert_eq!(again.to_toml(), written);
}

#[test]
fn presets_round_trip() {
    for name in preset_names() {
        check(preset(name).expect(name));
    }
}

#[test]
fn every_form_of_every_key_round_trips() {
    let scenes = [
        "name = 'a \"b\" \\ ü'",
        "domain.boundary = 'clamped'",
        "mesh = { cells = 7, jitter = 0.123456789012345678, seed = 18446744073709551615 }",
        "vesicle = { shape = 'circle', radius = 0.1, center = [0.1, 0.2], angle = 0 }",
        "vesicle = { shape = 'ellipse', half_axes = [0.3, 1e-3], angle = -12.5, scale = -1.5 }",
        "vesicle = { shape = 'discocyte', radius = 0.1, projection = 'nodal' }",
        "vesicle = { shape = 'stomatocyte', radius = 0.3, thickness = 0.1, opening = 60 }",
        "vesicle = { shape = 'random', amplitude = 1e-2, seed = 7, projection = 'l2' }",
        "mesh.cells = 4\nvesicle = { shape = 'file', values = 's \"1\".txt' }",
        "vesicle.parts = [{ shape = 'circle', radius = 1 }, { shape = 'cassini', ratio = 0 }]",
        "time = { step = 3.3333333333333335e-9, end = 1e8 }",
        "time = { tolerance = 1e-4, end = 1e300 }",
        "time = { tolerance = 1e-4, end = 0.1 }",
        "time = { tolerance = 1e-4, scheme = 'first-order' }",
        "time = { step = 1e-8, scheme = 'secant' }",
        "time = { tolerance = 1e-4 }",
        "membrane = { interface_width = 0.02, mobility = 1e-300 }",
        "membrane.spontaneous_curvature = \"sin(2*pi*x) * exp(-y^2)\"",
        "mesh.cells = 4\nmembrane.spontaneous_curvature = { file = 's \"1\".txt' }",
        "area = { target = 0.1, penalty = 2 }",
        "nematic = { weight = 0, mobility = 1, penalty = 1, initial = [-0.0, 3] }",
        "nematic.initial = { kind = 'defects', at = [{ winding = -0.5 }, {}], angle = 45 }",
        "nematic.initial = { kind = 'defects', at = [] }",
        "nematic.initial = { kind = 'random', seed = 3, length = 0.1 }",
        "mesh.cells = 4\nnematic.initial = { kind = 'file', values = 'v.txt' }",
        "anchoring = { kind = 'none', weight = 0 }",
        "nematic = {}\nanchoring = { kind = 'parallel', weight = 1 }",
        "nematic = {}\nfield = { weight = -3, strength = 2, angle = 45, from = 1e-5, until = 2e-5 }",
        "nematic = {}\nfield = {}\nnoise = { strength = 0.1, seed = 18446744073709551615 }",
        "pull.potential = '-3*y'",
        "mesh.cells = 4\npull.potential = { file = 's \"1\".txt' }",
        "solver = { quadrature = 'lumped', iteration = 'lagged', linear = 'factor' }",
        "solver = { linear = 'transform', tolerance = 1e-12, law_tolerance = 1e30 }",
    ];
    for text in scenes {
        check(text);
    }
}

/// A scene in which a table stands, with what else it needs.
fn scene_with(table: &TableInfo) -> String {
    let is_required = |it: &&Parameter| it.default == DefaultValue::Required && it.kinds.is_empty();
    let required = table.parameters.iter().filter(is_required);
    let keys: String = required.map(|it| format!("{} = 0\n", it.key)).collect();
    let director = if table.needs_director {
        "[nematic]\n"
    } else {
        ""
    };
    format!("{director}[{}]\n{keys}", table.name)
}

#[test]
fn every_parameter_that_is_declared_is_read_written_and_checked() {
    for table in tables() {
        let text = scene_with(&table);
        let default = read(&text);
        assert!(default.to_toml().contains(&format!("\n[{}]\n", table.name)));
        check(&text);
        for parameter in table.parameters.iter().filter(|it| it.kinds.is_empty()) {
            let key = format!("{}.{}", table.name, parameter.key);
            // The default that is declared is the one that holds; --set takes the same keys.
            if let DefaultValue::Value(value) = &parameter.default {
                let setting = format!("{key}={value}");
                let set = read_with(&text, &[&setting], &[]).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(set, default, "{setting}");
                let line = format!("\n{} = {value}\n", parameter.key);
                assert!(default.to_toml().contains(&line), "{setting}");
            }
            let error = |setting: String| {
                let error = read_with(&text, &[&setting], &[]).expect_err(&setting);
                error
                    .to_string()
                    .lines()
                    .next()
                    .unwrap_or_default()
                    .to_owned()
            };
            let allowed = &parameter.allowed;
            assert_eq!(
                error(format!("{key}=1979-05-27")),
                format!("--set {key}=1979-05-27: {key} must be {allowed}, not a date or a time")
            );
            let near = error(format!("{key}x=1"));
            let hint = format!("; did you mean '{}'? Allowed: ", parameter.key);
            assert!(near.contains(&hint), "{near}");
        }
        if table.is_effect() {
            let removed = read_with(&text, &[&format!("{}=false", table.name)], &[]);
            assert!(
                !removed
                    .expect("a scene")
                    .to_toml()
                    .contains(&format!("[{}]", table.name))
            );
        }
    }
}

/// The one TOML sample of a page.
fn only_sample(page: &str) -> &str {
    let samples: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    let [sample] = samples[..] else {
        panic!("{} samples", samples.len());
    };
    sample
}

#[test]
fn the_sample_of_the_readme_is_a_scene() {
    let scene = read(only_sample(include_str!("../../../README.md")));
    assert!(scene.field.is_some() && scene.anchoring.is_none());
    check(&scene.to_toml());
}

#[test]
fn the_sample_of_the_guide_is_case_3_and_every_default() {
    let scene = read(only_sample(include_str!("../../../docs/guide/scenes.md")));
    assert_eq!(scene, read(preset("case3").expect("a preset")));
    let bare = "name = 'Case 3'\narea = {}\nnematic = {}\nanchoring = {}";
    assert_eq!(scene, read(bare));
}

#[test]
fn what_is_written_is_the_sample_with_every_default() {
    let text = read(preset("case3").expect("a preset")).to_toml();
    let expected = r#"name = "Case 3"

[domain]
geometry = "planar"
boundary = "natural"

[mesh]
kind = "structured"
cells = 120
jitter = 0.0
seed = 1

[vesicle]
shape = "cassini"
ratio = 0.92
half_length = 0.32
center = [0.5, 0.5]
angle = 90.0
projection = "ritz"
scale = 1.0

[time]
step = 1e-7
scheme = "first-order"
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
linear = "automatic"
tolerance = 1e-5
law_tolerance = 1e-8
"#;
    assert_eq!(text, expected);
}
