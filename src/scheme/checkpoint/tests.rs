use super::*;
use crate::fem::Mesh;
use crate::scene::Scene;
use crate::scene::Timetable;
use crate::scheme::{StepError, initial_fields};

const TEXT: &str = r#"
    mesh.cells = 12
    vesicle = { shape = "ellipse", half_axes = [0.3, 0.2], angle = 70 }
    time = { step = 1e-6, end = 1 }
    membrane.interface_width = 0.08
    area.target = 1.1
    nematic.initial = [0.6, 0.8]
    anchoring.kind = "parallel"
"#;

fn scene(settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|s| (*s).to_owned()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(TEXT, "the test", &settings, &mut no_files).expect("a scene")
}

fn scheme(scene: &Scene) -> Scheme {
    let mesh = Mesh::of(scene).expect("a mesh");
    let initial = initial_fields(scene, &mesh).expect("initial fields");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("a scheme")
}

fn checkpoint(scheme: &Scheme) -> SchemeCheckpoint {
    let mut checkpoint = SchemeCheckpoint::default();
    scheme.save(&mut checkpoint);
    checkpoint
}

/// Takes steps; everything that they leave, bit by bit, and the work that they were.
fn run(scheme: &mut Scheme, steps: usize) -> Vec<u64> {
    try_run(scheme, steps).expect("steps")
}

fn try_run(scheme: &mut Scheme, steps: usize) -> Result<Vec<u64>, StepError> {
    const DT: f64 = 1e-6;
    let mut bits = Vec::new();
    for step in 0..steps {
        // Not every step is as long as the one before.
        let dt = if step % 5 == 3 { 0.5 * DT } else { DT };
        let report = scheme.step(dt)?;
        bits.extend(report.energies.iter().map(|energy| energy.value.to_bits()));
        bits.extend(report.ledger.iter().map(|term| term.value.to_bits()));
        let counts = [report.newton, report.krylov, report.director_iterations];
        bits.extend(counts.map(u64::from));
    }
    let state = scheme.state();
    let director = state.director.iter().flatten();
    for field in [&state.phi, &state.omega, &state.mu]
        .into_iter()
        .chain(director)
    {
        bits.extend(field.iter().map(|value| value.to_bits()));
    }
    Ok(bits)
}

/// The same with steps that change, each third of them refused at first.
fn run_with_refusals(scheme: &mut Scheme, steps: usize) -> Vec<u64> {
    let mut bits = Vec::new();
    for step in 0..steps {
        let dt = 1e-6 * (1.0 + 0.1 * (step % 5) as f64);
        if step % 3 == 1 {
            scheme.try_step(2.0 * dt, &mut |_| ()).expect("a step");
        }
        let error = scheme.try_step(dt, &mut |_| ()).expect("a step");
        bits.extend(error.map(f64::to_bits));
        let report = scheme.accept();
        bits.extend(report.energies.iter().map(|energy| energy.value.to_bits()));
        let counts = [report.newton, report.krylov, report.director_iterations];
        bits.extend(counts.map(u64::from));
    }
    let state = scheme.state();
    let director = state.director.iter().flatten();
    let fields = [&state.phi, &state.omega, &state.mu];
    for field in fields.into_iter().chain(director) {
        bits.extend(field.iter().map(|value| value.to_bits()));
    }
    bits
}

/// Saves a scheme, continues, and continues once more from the checkpoint: in the same scheme, in
/// a new one, and in a new one after a way over bytes.
fn check(scene: &Scene, scheme: Scheme, name: &str) {
    check_by(run, scene, scheme, name);
}

/// Takes this many steps and returns everything that they leave.
type Run = fn(&mut Scheme, usize) -> Vec<u64>;

fn check_by(run: Run, scene: &Scene, mut scheme: Scheme, name: &str) {
    let checkpoint = checkpoint(&scheme);
    let wanted = run(&mut scheme, 12);
    scheme.restore(&checkpoint).expect("the same scene");
    assert!(run(&mut scheme, 12) == wanted, "{name}: in the same scheme");
    let mut new = self::scheme(scene);
    new.restore(&checkpoint).expect("the same scene");
    assert!(run(&mut new, 12) == wanted, "{name}: in a new scheme");
    let bytes = postcard::to_stdvec(&checkpoint).expect("bytes");
    let checkpoint: SchemeCheckpoint = postcard::from_bytes(&bytes).expect("a checkpoint");
    let mut new = self::scheme(scene);
    new.restore(&checkpoint).expect("the same scene");
    assert!(run(&mut new, 12) == wanted, "{name}: over bytes");
}

#[test]
fn what_follows_is_bit_for_bit_what_it_was() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        for other in [
            "solver.linear=automatic",
            "solver.linear=factor",
            "domain.boundary=clamped",
            "mesh.jitter=0.3",
            "solver.iteration=lagged",
            "anchoring=false",
            "membrane.spontaneous_curvature=1.5",
        ] {
            let scene = scene(&[quadrature, other]);
            let mut scheme = scheme(&scene);
            for steps in [0, 1, 6] {
                run(&mut scheme, steps);
                let copy = checkpoint(&scheme);
                let mut again = self::scheme(&scene);
                again.restore(&copy).expect("the same scene");
                check(&scene, again, &format!("{quadrature}, {other}, +{steps}"));
            }
        }
        let without = scene(&[quadrature, "anchoring=false", "nematic=false", "area=false"]);
        let mut scheme = scheme(&without);
        run(&mut scheme, 5);
        check(&without, scheme, "only bending");
    }
}

#[test]
fn also_after_a_switched_anchoring_and_on_and_after_a_detour() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        let scene = scene(&[quadrature]);
        let mut switched = scheme(&scene);
        run(&mut switched, 5);
        let homeotropic = "change=[{ at = 5e-6, set = { anchoring.kind = 'homeotropic', anchoring.weight = 20 } }]";
        let scene = self::scene(&[quadrature, homeotropic]);
        switched.set_timetable(Timetable::of(&scene));
        check(&scene, scheme_like(&scene, &switched), "just switched");
        run(&mut switched, 2);
        check(&scene, scheme_like(&scene, &switched), "switched");

        // The detour ends after 16 steps: within the steps that the check takes.
        let mut fallback = scheme(&scene);
        run(&mut fallback, 5);
        fallback
            .membrane
            .fall_back(&fallback.space)
            .expect("a sparse factor");
        fallback.selection.fast_failed(0.9e-6);
        run(&mut fallback, 8);
        assert!(!fallback.uses_transform());
        check(&scene, scheme_like(&scene, &fallback), "on a fallback");
        run(&mut fallback, 9);
        assert!(fallback.uses_transform());
        // Only while the fast path is slow is the factor kept beside it.
        assert!(checkpoint(&fallback).linear.has_no_factor());
        check(&scene, scheme_like(&scene, &fallback), "after a fallback");
        fallback
            .membrane
            .fall_back(&fallback.space)
            .expect("a sparse factor");
        check(
            &scene,
            scheme_like(&scene, &fallback),
            "on the next fallback",
        );
    }
}

#[test]
fn also_with_noise_and_a_field_that_is_switched() {
    for settings in [
        &["noise.strength=1"][..],
        &["field.strength=1", "field.from=5e-6", "field.until=12e-6"],
        &["noise.strength=1", "field.strength=1", "field.from=5e-6"],
    ] {
        let scene = scene(settings);
        let mut scheme = scheme(&scene);
        for steps in [0, 4, 5] {
            run(&mut scheme, steps);
            check(&scene, scheme_like(&scene, &scheme), &settings.join(" "));
        }
    }
}

#[test]
fn also_with_the_secant_scheme_and_steps_that_are_refused() {
    for settings in [
        &["solver.quadrature=consistent"][..],
        &["solver.linear=factor"],
        &["anchoring=false", "nematic=false"],
        &["noise.strength=1", "field.strength=1", "field.from=5e-6"],
    ] {
        let scene = scene(&[settings, &["time.scheme=secant"]].concat());
        let mut scheme = scheme(&scene);
        let name = settings.join(" ");
        for steps in [0, 1, 6] {
            run_with_refusals(&mut scheme, steps);
            let copy = scheme_like(&scene, &scheme);
            check_by(run_with_refusals, &scene, copy, &name);
        }
    }
}

/// A negative control: a run that is resumed must know how many steps of first order are still to come.
#[test]
fn the_steps_that_are_still_to_be_damped_may_not_be_left_out() {
    let scene = scene(&["time.scheme=secant"]);
    let mut scheme = scheme(&scene);
    run_with_refusals(&mut scheme, 1);
    let mut checkpoint = checkpoint(&scheme);
    assert_eq!(checkpoint.starting, 1);
    let wanted = run_with_refusals(&mut scheme, 3);
    checkpoint.starting = 0;
    let mut new = self::scheme(&scene);
    new.restore(&checkpoint).expect("the same scene");
    assert!(run_with_refusals(&mut new, 3) != wanted);
}

/// A new scheme that has restored the state of another.
fn scheme_like(scene: &Scene, other: &Scheme) -> Scheme {
    let mut new = scheme(scene);
    new.restore(&checkpoint(other)).expect("the same scene");
    new
}

/// Negative controls: each item is needed.
#[test]
fn nothing_may_be_left_out() {
    let transform = scene(&[]);
    let factor = scene(&["solver.linear=factor"]);
    type Spoil = fn(&mut SchemeCheckpoint);
    let controls: [(&str, &Scene, Spoil); 6] = [
        ("history", &transform, |checkpoint| {
            checkpoint.history.forget()
        }),
        ("time", &transform, |checkpoint| checkpoint.t += 1e-6),
        ("increments", &transform, |checkpoint| {
            checkpoint.increments.as_mut().expect("a director").forget();
        }),
        ("energies", &transform, |checkpoint| {
            checkpoint.total_energy += 1e-9
        }),
        ("phi", &factor, |checkpoint| {
            checkpoint.state.phi[30] += 1e-9
        }),
        ("factor", &factor, |checkpoint| {
            checkpoint.linear.forget_factor()
        }),
    ];
    for (name, scene, spoil) in controls {
        let mut scheme = scheme(scene);
        run(&mut scheme, 7);
        let mut checkpoint = checkpoint(&scheme);
        let wanted = run(&mut scheme, 12);
        spoil(&mut checkpoint);
        let mut new = self::scheme(scene);
        new.restore(&checkpoint).expect("the same scene");
        assert!(try_run(&mut new, 12) != Ok(wanted), "{name} is not needed");
    }
}

#[test]
fn a_memory_of_another_scene_is_refused_and_changes_nothing() {
    let scene = scene(&[]);
    let mut scheme = scheme(&scene);
    run(&mut scheme, 3);
    let mine = postcard::to_stdvec(&checkpoint(&scheme)).expect("bytes");
    for other in [
        "mesh.cells=13",
        "nematic=false",
        "area=false",
        "solver.linear=factor",
    ] {
        let settings = if other.starts_with("nematic") {
            vec![other, "anchoring=false"]
        } else {
            vec![other]
        };
        let mut foreign = self::scheme(&self::scene(&settings));
        run(&mut foreign, 2);
        let outcome = scheme.restore(&checkpoint(&foreign));
        if other == "solver.linear=factor" {
            // The same equations, solved otherwise: the factor is taken over with the rest.
            assert_eq!(outcome, Ok(()));
            assert!(!scheme.uses_transform());
        } else {
            assert!(matches!(outcome, Err(RestoreError::Foreign(_))), "{other}");
            let bytes = postcard::to_stdvec(&checkpoint(&scheme)).expect("bytes");
            assert!(bytes == mine, "{other}");
        }
    }
    let mut factored = self::scheme(&self::scene(&["solver.linear=factor"]));
    let outcome = factored.restore(&checkpoint(&self::scheme(&scene)));
    assert!(matches!(outcome, Err(RestoreError::Foreign(_))));
    assert!(matches!(
        factored.restore(&SchemeCheckpoint::default()),
        Err(RestoreError::Foreign(_))
    ));
}
