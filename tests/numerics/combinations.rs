//! The energy law with every combination of effects: it is an identity of each one alone, so of any
//! together.

use crate::common::{SMALL, TIGHT, energy_scale, mesh, named, scene, scheme};
use vesica::internal::scene::{TableInfo, tables};
use vesica::{Scheme, StepReport};

const STEPS: usize = 3;

/// Each effect, with the settings that take it away. (SMALL has area, nematic, anchoring.)
const EFFECTS: [(&str, &str, &str); 7] = [
    ("area", "", "area=false"),
    (
        "curvature",
        "membrane.spontaneous_curvature='2*sin(3*x) - y'",
        "",
    ),
    (
        "nematic",
        "nematic.initial={ kind = 'random', seed = 3, length = 1.2 }",
        "nematic=false",
    ),
    ("anchoring", "anchoring.kind=homeotropic", "anchoring=false"),
    (
        "field",
        "field={ weight = 300, angle = 35, from = 1e-6 }",
        "",
    ),
    ("pull", "pull.potential='100*x - 300*y^2'", ""),
    ("noise", "noise={ strength = 1e-3, seed = 5 }", ""),
];

/// Work that is done from outside: by noise, and where the field is switched on.
const WORKS: [&str; 2] = ["noise_work", "change_work"];

/// Whether an effect is nothing without a director.
fn needs_director(name: &str) -> bool {
    let table = tables().into_iter().find(|table| table.name == name);
    table.is_some_and(|table| table.needs_director)
}

#[test]
fn every_effect_is_combined() {
    let mut combined: Vec<&str> = EFFECTS.iter().map(|(name, ..)| *name).collect();
    combined.retain(|name| *name != "curvature");
    let tables = tables().into_iter().filter(TableInfo::is_effect);
    assert_eq!(combined, tables.map(|table| table.name).collect::<Vec<_>>());
}

/// The combination of this number, unless it makes no sense.
fn combination(number: usize) -> Option<Vec<&'static str>> {
    let named = EFFECTS.iter().enumerate();
    let on: Vec<&str> = named
        .filter(|(bit, _)| number >> bit & 1 == 1)
        .map(|(_, (name, ..))| *name)
        .collect();
    let needs_director = on.iter().any(|name| needs_director(name));
    (on.contains(&"nematic") || !needs_director).then_some(on)
}

fn settings(on: &[&str]) -> Vec<&'static str> {
    // Tables that need the director go before it does.
    let rest = EFFECTS.iter().map(
        |(name, with, without)| {
            if on.contains(name) { *with } else { *without }
        },
    );
    rest.filter(|setting| !setting.is_empty()).collect()
}

#[track_caller]
fn check(report: &StepReport, place: &str) {
    let scale = energy_scale(report);
    let residual = report.law_residual;
    assert!(
        residual.abs() <= 1e-12,
        "{place}: law_residual {residual:e}"
    );
    for term in &report.ledger {
        let outside = term.name == "dE" || WORKS.contains(&term.name);
        assert!(outside || term.value >= -1e-14 * scale, "{place}: {term:?}");
    }
    let works = report.ledger.iter();
    let works = works.filter(|term| WORKS.contains(&term.name));
    let given: f64 = works.map(|work| -work.value).sum();
    let rise = named(&report.ledger, "dE");
    assert!(
        rise <= given + 1e-12 * scale,
        "{place}: E rises by {rise:e}, given {given:e}"
    );
}

fn check_all(quadrature: &str) {
    let mut checked = 0;
    for on in (0..1 << EFFECTS.len()).filter_map(combination) {
        for field in ["field.weight=300", "field.weight=-300"] {
            let has_field = on.contains(&"field");
            if !has_field && field.contains('-') {
                continue;
            }
            let mut settings = settings(&on);
            settings.extend(TIGHT);
            settings.push(quadrature);
            if has_field {
                settings.push(field);
            }
            let scene = scene(SMALL, &settings);
            let mut scheme = scheme(&scene);
            for step in 1..=STEPS {
                let place = format!("{on:?}, {field}, {quadrature}, step {step}");
                match scheme.step(1e-6) {
                    Ok(report) => check(report, &place),
                    Err(error) => panic!("{place}: {error}"),
                }
                let energies = &scheme.report().energies;
                let mut names: Vec<&str> = energies.iter().map(|energy| energy.name).collect();
                names.sort_unstable();
                let mut expected: Vec<&str> = on
                    .iter()
                    .copied()
                    .filter(|name| !["curvature", "noise"].contains(name))
                    // It is on from the end of the first step, and is no effect before.
                    .filter(|name| *name != "field" || step > 1)
                    .chain(["bending"])
                    .collect();
                expected.sort_unstable();
                assert_eq!(names, expected, "{place}");
            }
            checked += 1;
        }
    }
    // 2³ without a director, 2³ · 2² with one and no field, and as many with each sign of the field.
    assert_eq!(checked, 8 + 3 * 32);
}

#[test]
fn every_combination_keeps_the_law_with_the_consistent_quadrature() {
    check_all("solver.quadrature=consistent");
}

#[test]
fn every_combination_keeps_the_law_with_the_lumped_quadrature() {
    check_all("solver.quadrature=lumped");
}

/// Without its work in the ledger, noise would break the law: the checks above are not empty.
#[test]
fn noise_does_work_that_the_law_needs() {
    let settings = [&TIGHT[..], &["noise={ strength = 1e-3, seed = 5 }"]].concat();
    let mut scheme = scheme(&scene(SMALL, &settings));
    let report = scheme.step(1e-6).expect("a solved step");
    let work = named(&report.ledger, "noise_work");
    assert!(work < -1e-6 * energy_scale(report), "{work:e}");
}

/// In a step noise does about 2T of work for every value of the director, however short the step. Where that is a
/// thousand times the energy, the law closes over both, and no Δt is too short for it.
#[test]
fn the_law_closes_where_noise_works_far_more_than_there_is_energy() {
    let text = "
        mesh.cells = 10
        vesicle = { shape = 'circle', radius = 0.25 }
        membrane = { interface_width = 0.1 }
        nematic = { weight = 10, mobility = 0.5, penalty = 0.3 }
        noise = { strength = 1e-6, seed = 3 }
    ";
    let schemes = ["time.scheme=first-order", "time.scheme=secant"];
    let quadratures = ["solver.quadrature=consistent", "solver.quadrature=lumped"];
    for [quadrature, how] in quadratures
        .iter()
        .flat_map(|it| schemes.map(|how| [*it, how]))
    {
        let scene = scene(text, &[quadrature, how]);
        let mesh = mesh(&scene);
        let nodes = mesh.nodes().len();
        for dt in [4e-6, 4e-8, 4e-10] {
            let inside = vec![1.0; nodes];
            let director = [vec![0.0; nodes], vec![1.0; nodes]];
            let mut scheme =
                Scheme::new(&scene, mesh.clone(), inside, Some(director)).expect("a scheme");
            let mut most = 0.0_f64;
            for step in 1..=6 {
                let place = format!("{quadrature}, {how}, {dt:e}, step {step}");
                let before = scheme.report().total_energy;
                if let Err(error) = scheme.step(dt) {
                    panic!("{place}: {error}");
                }
                let report = scheme.report();
                let given = -named(&report.ledger, "noise_work");
                let scale = energy_scale(report) + given.abs();
                assert!(report.law_residual.abs() <= 1e-8, "{place}");
                let rise = report.total_energy - before;
                assert!(
                    rise <= given + 1e-8 * scale,
                    "{place}: {rise:e}, given {given:e}"
                );
                most = most.max(given / energy_scale(report));
            }
            assert!(dt > 1e-7 || most > 300.0, "{quadrature} {dt:e}: {most:e}");
        }
    }
}

/// The same seed gives the same bits, another seed another run.
#[test]
fn noise_repeats_with_its_seed() {
    let run = |seed: u64| {
        let noise = format!("noise={{ strength = 1e-3, seed = {seed} }}");
        let mut scheme = scheme(&scene(SMALL, &[noise]));
        for _ in 0..3 {
            scheme.step(1e-6).expect("a solved step");
        }
        scheme.state().clone()
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5).director, run(6).director);
}
