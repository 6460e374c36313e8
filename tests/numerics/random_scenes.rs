//! Random scenes of everything that a scene may say, a few steps each on a small mesh: no panic, and
//! either the energy law closes, the energy falls, the volume stays and every value is finite, or there
//! is a typed error that says what was tried. Of the scenes at most one in twenty may end so, or be left for
//! the many parts that a step of theirs takes (19 of 900 were).
//!
//! Some seconds of it run with all tests, more with
//!
//!     PROPTEST_CASES=3000 cargo test --release --test numerics random_scenes

use std::cell::Cell;

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use vesica::internal::scene::{NodalValues, Shape};
use vesica::internal::simulation::StepProgress;
use vesica::{Mesh, NamedValue, Report, Scene, Simulation, SimulationError, initial_fields};

/// One of these texts.
fn one_of(words: &'static [&'static str]) -> impl Strategy<Value = &'static str> {
    proptest::sample::select(words)
}

/// A table, or none.
fn or_none(table: impl Strategy<Value = String>) -> impl Strategy<Value = String> {
    prop_oneof![Just(String::new()), table]
}

/// A number between powers of ten.
fn between(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|exponent| 10_f64.powf(exponent))
}

/// Where the membrane is, how it is resolved, and how the linear systems are solved there.
fn domain_and_mesh() -> impl Strategy<Value = (String, &'static str)> {
    let jitter = prop_oneof![Just(0.0), 0.0..0.89];
    let structured = (4_usize..=9, jitter, any::<u8>()).prop_map(|(cells, jitter, seed)| {
        (
            format!("mesh = {{ cells = {cells}, jitter = {jitter:?}, seed = {seed} }}\n"),
            jitter == 0.0,
        )
    });
    let delaunay = (0.12..0.25, any::<u8>()).prop_map(|(size, seed): (f64, u8)| {
        (
            format!("mesh = {{ kind = 'delaunay', size = {size:?}, seed = {seed} }}\n"),
            false,
        )
    });
    (
        one_of(&["natural", "clamped"]),
        prop_oneof![3 => structured, 1 => delaunay],
        one_of(&["automatic", "factor", "shifted", "transform"]),
    )
        .prop_map(|(boundary, (mesh, is_grid), linear)| {
            let linear = match linear {
                "transform" if !is_grid || boundary == "clamped" => "automatic",
                "shifted" if boundary == "clamped" => "automatic",
                linear => linear,
            };
            (format!("domain.boundary = '{boundary}'\n{mesh}"), linear)
        })
}

fn outline() -> impl Strategy<Value = String> {
    let shape = prop_oneof![
        (0.02..0.6).prop_map(|r: f64| format!("shape = 'circle', radius = {r:?}")),
        (0.02..0.6, 0.02..0.6).prop_map(|(a, b): (f64, f64)| format!(
            "shape = 'ellipse', half_axes = [{a:?}, {b:?}]"
        )),
        (0.0..0.999, 0.05..0.6).prop_map(|(ratio, length): (f64, f64)| {
            format!("shape = 'cassini', ratio = {ratio:?}, half_length = {length:?}")
        }),
        (0.05..0.6).prop_map(|r: f64| format!("shape = 'discocyte', radius = {r:?}")),
        (0.05..0.4, 0.1..0.6, 40.0..300.0).prop_map(|(r, part, angle): (f64, f64, f64)| format!(
            "shape = 'stomatocyte', radius = {r:?}, thickness = {:?}, opening = {angle:?}",
            part * r
        )),
    ];
    (shape, -0.1..1.1, -0.1..1.1)
        .prop_map(|(shape, x, y): (String, f64, f64)| format!("{shape}, center = [{x:?}, {y:?}]"))
}

fn vesicle() -> impl Strategy<Value = String> {
    let shape = prop_oneof![
        outline(),
        proptest::collection::vec(outline(), 1..4).prop_map(|parts| {
            let parts: Vec<String> = parts.iter().map(|part| format!("{{ {part} }}")).collect();
            format!("parts = [{}]", parts.join(", "))
        }),
        (0.0..4.0, any::<u8>()).prop_map(|(amplitude, seed): (f64, u8)| format!(
            "shape = 'random', amplitude = {amplitude:?}, seed = {seed}"
        )),
    ];
    let scale = prop_oneof![Just(1.0), 0.1..3.0];
    let projection = one_of(&["ritz", "l2", "nodal"]);
    (shape, scale, projection).prop_map(|(shape, scale, projection)| {
        format!("vesicle = {{ {shape}, scale = {scale:?}, projection = '{projection}' }}\n")
    })
}

fn membrane() -> impl Strategy<Value = String> {
    let curvature = one_of(&[
        "0.0",
        "50.0",
        "-7.5",
        "'10*sign(x - 0.5)'",
        "'20*sin(30*x)*y'",
    ]);
    (between(-2.0, 0.3), between(-5.0, 2.0), curvature).prop_map(|(width, mobility, curvature)| {
        format!(
            "membrane = {{ interface_width = {width:?}, mobility = {mobility:?}, \
             spontaneous_curvature = {curvature} }}\n"
        )
    })
}

fn area() -> impl Strategy<Value = String> {
    let area = (0.1..4.0, between(-8.0, 0.0)).prop_map(|(target, penalty)| {
        format!("area = {{ target = {target:?}, penalty = {penalty:?} }}\n")
    });
    or_none(area)
}

fn nematic() -> impl Strategy<Value = String> {
    let initial = one_of(&[
        "[0.0, 1.0]",
        "[0.0, 0.0]",
        "[1.8, -2.4]",
        "{ kind = 'random', seed = 4, length = 1.0 }",
        "{ kind = 'defects', at = [{ center = [0.5, 0.5], winding = 1.0 }] }",
        "{ kind = 'defects', at = [{ center = [0.0, 0.5], winding = -0.5 }, { winding = 0.5 }], angle = 20 }",
    ]);
    let weight = prop_oneof![Just(0.0), between(-1.0, 4.0)];
    let anchoring = prop_oneof![Just(0.0), between(-1.0, 4.0)];
    let kind = one_of(&["parallel", "homeotropic", "none"]);
    let nematic = (weight, between(-3.0, 0.0), between(-2.0, 3.0), initial, kind, anchoring)
        .prop_map(|(weight, penalty, mobility, initial, kind, anchoring)| {
            format!(
                "nematic = {{ weight = {weight:?}, penalty = {penalty:?}, mobility = {mobility:?}, \
                 initial = {initial} }}\nanchoring = {{ kind = '{kind}', weight = {anchoring:?} }}\n"
            )
        });
    let field = (one_of(&["", "-"]), between(0.0, 3.0), 0.0..180.0).prop_map(
        |(sign, weight, angle): (&str, f64, f64)| {
            format!("field = {{ weight = {sign}{weight:?}, angle = {angle:?} }}\n")
        },
    );
    let noise = (between(-8.0, 2.0), any::<u8>()).prop_map(|(strength, seed): (f64, u8)| {
        format!("noise = {{ strength = {strength:?}, seed = {seed} }}\n")
    });
    let nematic = (nematic, or_none(field), or_none(noise))
        .prop_map(|(nematic, field, noise)| [nematic, field, noise].concat());
    or_none(nematic)
}

fn pull() -> impl Strategy<Value = String> {
    or_none(
        one_of(&["'100*x'", "'sin(20*x)*y'", "'1e4*(x - 0.5)^2'"])
            .prop_map(|potential| format!("pull = {{ potential = {potential} }}\n")),
    )
}

/// Steps of a fixed length or chosen ones, by each scheme.
fn time() -> impl Strategy<Value = String> {
    let fixed = between(-10.0, 0.0).prop_map(|step| format!("step = {step:?}"));
    let chosen = between(-6.0, -1.0).prop_map(|tolerance| format!("tolerance = {tolerance:?}"));
    let scheme = one_of(&["first-order", "secant"]);
    (prop_oneof![fixed, chosen], scheme).prop_map(|(steps, scheme)| {
        format!("time = {{ {steps}, scheme = '{scheme}', end = 10.0 }}\n")
    })
}

fn solver(linear: &str) -> impl Strategy<Value = String> + use<> {
    let linear = linear.to_owned();
    let quadrature = one_of(&["consistent", "lumped"]);
    (quadrature, one_of(&["newton", "lagged"])).prop_map(move |(quadrature, iteration)| {
        format!(
            "solver = {{ quadrature = '{quadrature}', iteration = '{iteration}', linear = '{linear}' }}\n"
        )
    })
}

/// Each with a mesh of its own, and in one of four on a mesh refined at the membrane.
fn scene() -> impl Strategy<Value = String> {
    let refined = (outline(), 0.02..0.1, 0.03..0.08, any::<u8>()).prop_map(
        |(outline, band, size, seed): (String, f64, f64, u8)| {
            let mesh = format!(
                "mesh = {{ kind = 'delaunay', size = 0.2, seed = {seed}, \
                 refine = {{ band = {band:?}, size = {size:?} }} }}\n"
            );
            (format!("{mesh}vesicle = {{ {outline} }}\n"), "automatic")
        },
    );
    let plain = (domain_and_mesh(), vesicle())
        .prop_map(|((mesh, linear), vesicle)| ([mesh, vesicle].concat(), linear));
    let place = prop_oneof![3 => plain, 1 => refined];
    let place = place.prop_flat_map(|(place, linear)| (Just(place), solver(linear)));
    (place, membrane(), area(), nematic(), pull(), time()).prop_map(
        |((place, solver), membrane, area, nematic, pull, time)| {
            [place, solver, membrane, area, nematic, pull, time].concat()
        },
    )
}

/// How the steps of a scene ended, where all was well.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ending {
    Solved,
    /// With a typed error that says what was tried.
    Refused,
    /// A step takes too many attempts.
    Left,
    /// There is no vesicle in its domain, which is said before any step.
    Empty,
}

/// So many attempts at a step are waited for.
const ATTEMPTS: u32 = 300;

/// Takes two steps of a scene; what does not hold, in words.
fn take_steps(text: &str) -> Result<Ending, String> {
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, "random", &[], &mut no_files).map_err(|e| e.to_string())?;
    let mut simulation = match Simulation::new(&scene) {
        Ok(simulation) => simulation,
        // Outside of the domain, all around it, or between the nodes of the mesh.
        Err(SimulationError::NoVesicle(_)) => return Ok(Ending::Empty),
        Err(error) => return Err(error.to_string()),
    };
    let volume = simulation.report().phase_integral;
    let phi = &simulation.state().phi;
    let size = phi.iter().fold(1.0_f64, |size, phi| size.max(phi.abs()));
    for _ in 0..2 {
        let attempts = Cell::new(0);
        let before = sum(&simulation.report().energies);
        let mut leave = |_: &StepProgress| {
            attempts.set(attempts.get() + 1);
            attempts.get() > ATTEMPTS
        };
        let advanced = loop {
            match simulation.advance_unless(&mut leave) {
                // Left to tell of an event.
                Ok(false) if attempts.get() <= ATTEMPTS => {}
                advanced => break advanced,
            }
        };
        match advanced {
            Ok(true) => {}
            Ok(false) => return Ok(Ending::Left),
            Err(error @ SimulationError::Step { .. }) => {
                let words = error.to_string();
                let tells = words.contains("tried were");
                return if tells {
                    Ok(Ending::Refused)
                } else {
                    Err(words)
                };
            }
            Err(error) => return Err(error.to_string()),
        }
        check(simulation.report(), before, volume, size)?;
        if let Some(field) = simulation.state().first_not_finite() {
            return Err(format!("{field} is not finite"));
        }
    }
    Ok(Ending::Solved)
}

/// The sum of the absolute values.
fn sum<'a>(values: impl IntoIterator<Item = &'a NamedValue>) -> f64 {
    values.into_iter().map(|value| value.value.abs()).sum()
}

/// What must hold of every step, from the sum of the absolute energies before it, ∫φ⁰ and the largest |φ⁰|. A
/// comparison with NaN is false.
fn check(report: &Report, before: f64, volume: f64, size: f64) -> Result<(), String> {
    let works = sum(report.ledger.iter().filter(|term| term.is_work()));
    let scale = sum(&report.energies).max(before) + works;
    let scale = scale.max(f64::MIN_POSITIVE);
    let rise = report.unexplained_rise().unwrap_or(f64::NAN) / scale;
    let drift = (report.phase_integral - volume).abs() / size;
    let dissipations = report.ledger.iter();
    let mut dissipations = dissipations.filter(|term| term.name.starts_with("ND_"));
    let law = report.law_residual.abs();
    let falls = dissipations.all(|term| term.value / scale >= -1e-14);
    if law <= 1e-8 && rise <= 1e-12 && drift <= 1e-13 && falls {
        return Ok(());
    }
    Err(format!(
        "law {law:.1e}, rise {rise:.1e}, drift {drift:.1e}, {:?}",
        report.ledger
    ))
}

/// The checks see what they are to see, NaN too.
#[test]
fn the_checks_can_fail() {
    let term = |name, value| NamedValue { name, value };
    let good = Report {
        energies: vec![term("bending", 1.0)],
        ledger: vec![term("dE", -0.1), term("ND_omega", 0.1)],
        ..Report::default()
    };
    assert_eq!(check(&good, 1.0, 0.0, 1.0), Ok(()));
    for bad in [1.0, f64::NAN] {
        let mut broken = [const { None }; 4].map(|_: Option<()>| good.clone());
        broken[0].law_residual = bad;
        broken[1].phase_integral = bad;
        broken[2].ledger[0].value = bad;
        broken[3].ledger[1].value = -bad;
        for report in broken {
            assert!(check(&report, 1.0, 0.0, 1.0).is_err(), "{report:?}");
        }
    }
    assert!(are_solved(48, 40, 2) && are_solved(48, 24, 0));
    assert!(!are_solved(48, 40, 3) && !are_solved(48, 23, 0));
}

/// How many scenes: the same 48 every time, or by PROPTEST_CASES more, and others each time.
fn config() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok();
    let cases = cases.and_then(|cases| cases.parse().ok());
    ProptestConfig {
        failure_persistence: None,
        rng_seed: cases.map_or(RngSeed::Fixed(1), |_: u32| RngSeed::Random),
        max_shrink_iters: 200,
        ..ProptestConfig::with_cases(cases.unwrap_or(48))
    }
}

/// Of so many scenes one may be refused or left.
const FEW: u32 = 20;

/// Whether enough scenes have a vesicle, and few of these are not solved.
fn are_solved(cases: u32, taken: u32, unsolved: u32) -> bool {
    2 * taken >= cases && FEW * unsolved <= taken
}

#[test]
fn any_scene_is_solved_or_refused_with_reasons() {
    let (taken, unsolved) = (Cell::new(0), Cell::new(0));
    let config = config();
    let cases = config.cases;
    let outcome = TestRunner::new(config).run(&scene(), |text| {
        let ending =
            take_steps(&text).map_err(|words| TestCaseError::fail(format!("{words}\n{text}")))?;
        if ending == Ending::Empty {
            return Ok(());
        }
        taken.set(taken.get() + 1);
        if ending != Ending::Solved {
            unsolved.set(unsolved.get() + 1);
            eprintln!("{ending:?}:\n{text}");
        }
        Ok(())
    });
    outcome.unwrap_or_else(|error| panic!("{error}"));
    let (taken, unsolved) = (taken.get(), unsolved.get());
    println!("of {cases} scenes {taken} have a vesicle, {unsolved} of these are not solved");
    assert!(
        are_solved(cases, taken, unsolved),
        "of {cases} scenes {taken} have a vesicle, and {unsolved} of these are not solved"
    );
}

/// A discocyte for which Newton's method is damped in nearly all of some 500 iterations.
const DAMPED: &str = "
    domain.boundary = 'natural'
    mesh = { kind = 'delaunay', size = 0.13530354281791257, seed = 50 }
    vesicle = { shape = 'discocyte', radius = 0.5575824614689584, \
                center = [0.23976181348621184, 0.15792460468712952], scale = 2.4985971473071635 }
    membrane = { interface_width = 0.03830135412051155, mobility = 1.0, \
                 spontaneous_curvature = '20*sin(30*x)*y' }
    area = { target = 3.315506371027456, penalty = 0.0035695793466126915 }
    time = { step = 0.015948485483149206, end = 10.0 }
    solver = { quadrature = 'lumped' }
";

/// A vesicle outside of the domain, where only the tail of φ is: −0.9 throughout, nearly.
const DRIFTING: &str = "
    domain.boundary = 'natural'
    mesh = { kind = 'delaunay', size = 0.2069, seed = 419 }
    vesicle = { parts = [{ shape = 'cassini', ratio = 0.136, half_length = 0.1, \
                center = [-0.12444830242533517, 0.10900268690741782], angle = 260.5 }], \
                scale = 0.9, projection = 'ritz' }
    membrane = { interface_width = 0.0082, mobility = 0.42, \
                 spontaneous_curvature = '20*sin(30*x)*y' }
    area = { target = 0.147, penalty = 0.027 }
    time = { step = 0.00187, end = 1.8727261290136479 }
    solver = { quadrature = 'consistent', iteration = 'newton', linear = 'automatic', tolerance = 2e-7 }
";

/// A run of a scene from its φ⁰ as nodal values: from those a run may begin though no vesicle is in the domain.
fn from_nodal_values(text: &str, overrides: &[&str]) -> Simulation {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let mut scene = Scene::parse(text, "random", &overrides, &mut no_files).expect("a scene");
    let mesh = Mesh::of(&scene).expect("a mesh");
    let initial = initial_fields(&scene, &mesh).expect("initial fields");
    scene.vesicle.shape = Shape::File(NodalValues {
        path: "phi.txt".to_owned(),
        values: mesh.outward(&initial.phi).into(),
        columns: 1,
    });
    scene.vesicle.scale = 1.0;
    let simulation = Simulation::new(&scene).expect("a run");
    assert_eq!(simulation.state().phi, initial.phi);
    simulation
}

/// Takes steps; ∫φ must stay what it is but for this.
#[track_caller]
fn keep_volume(simulation: &mut Simulation, steps: u64, tolerance: f64) {
    let volume = simulation.report().phase_integral;
    for step in 1..=steps {
        let report = simulation.advance().expect("a step");
        let drift = (report.phase_integral - volume).abs();
        assert!(drift <= tolerance, "step {step}: {drift:e}");
    }
}

/// Found at random: every damped iteration leaves a part of what the guess's ∫φ is off by, 6e-15 to 2e-14 here in
/// all if the guess is not put right.
#[test]
fn the_volume_stays_where_newton_s_method_is_damped() {
    assert_eq!(take_steps(DAMPED), Ok(Ending::Solved));
    for scheme in ["time.scheme=first-order", "time.scheme=secant"] {
        keep_volume(&mut from_nodal_values(DAMPED, &[scheme]), 5, 5e-15);
    }
}

/// Found at random: rounding let the residual of a solved step fall no further, so that each was divided into
/// hundreds of parts, each of which moved ∫φ by rounding.
#[test]
fn the_volume_stays_in_long_steps() {
    let mut simulation = from_nodal_values(DRIFTING, &[]);
    // The first steps are hard, until the wall is reached.
    keep_volume(&mut simulation, 16, 1e-14);
    let volume = simulation.report().phase_integral;
    for _ in 17..=40 {
        keep_volume(&mut simulation, 1, 1e-14);
        let effort = &simulation.report().effort;
        assert_eq!(effort.parts, 1, "{effort:?}");
    }
    let drift = (simulation.report().phase_integral - volume).abs();
    assert!(drift <= 1e-14, "{drift:e}");
    // The secant scheme's steps are hard throughout: μ stays far from rest.
    let mut simulation = from_nodal_values(DRIFTING, &["time.scheme=secant"]);
    keep_volume(&mut simulation, 12, 1e-14);
}
