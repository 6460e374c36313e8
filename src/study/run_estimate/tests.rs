//! Prices: what is counted, and how it is reported.

use super::chosen::{Further, Step};
use super::fixed::{Later, TimedStep, Work};
use super::*;
use crate::study::tests::{CALM, scene};

#[test]
fn what_a_run_still_takes_is_counted_from_where_it_stands() {
    let scene = scene(CALM);
    assert_eq!(
        coarse(&scene, LinearMethod::Automatic),
        None,
        "it is coarse itself"
    );
    let new = || Simulation::new(&scene).expect("a simulation");
    let mut whole = new();
    let mut steps = Vec::new();
    while whole.report().t < scene.time.end {
        let report = whole.advance().expect("a step");
        steps.push(Step::of(report));
    }
    let made = steps[2];
    let rest = &steps[3..];
    let mut go_on = || true;
    let mut patience = Patience::new(Duration::MAX, &mut go_on);
    let all = Further::of(new(), made, Duration::MAX, &mut patience).expect("solved");
    assert_eq!(all.steps, rest.len() as f64);
    let corrections: f64 = rest.iter().map(|step| step.corrections).sum();
    assert_eq!(all.corrections, corrections);
    let begun = |steps: usize| {
        let mut simulation = new();
        for _ in 0..steps {
            simulation.advance().expect("a step");
        }
        simulation
    };
    let more = Further::of(begun(3), made, Duration::MAX, &mut patience).expect("solved");
    assert_eq!((more.steps, more.corrections), (all.steps, all.corrections));
    // Without time the rest is extrapolated.
    let half = steps.len() / 2;
    let cut = Further::of(begun(half), made, Duration::ZERO, &mut patience).expect("solved");
    let left = (steps.len() - half) as f64;
    assert!(
        cut.steps > 0.3 * left && cut.steps < 3.0 * left,
        "{cut:?} {left}"
    );
    // Without even one step, from what was made elsewhere.
    let mut no_more = Patience::new(Duration::ZERO, &mut go_on);
    let none = Further::of(begun(half), steps[half - 1], Duration::MAX, &mut no_more);
    let none = none.expect("not one step").steps;
    assert!(none > 0.25 * left && none < 4.0 * left, "{none} {left}");
}

#[test]
fn seconds_are_told_to_two_digits() {
    let told = |seconds: f64| {
        let price = RunEstimate {
            steps: 7,
            seconds,
            memory: 50_000_000,
        };
        price.to_string()
    };
    assert_eq!(told(0.34), "about 0.3 s and 50 MB, 7 steps");
    assert_eq!(told(1.43), "about 1.4 s and 50 MB, 7 steps");
    assert_eq!(told(11.6), "about 12 s and 50 MB, 7 steps");
    assert_eq!(told(900.0), "about 15 min and 50 MB, 7 steps");
}

#[test]
fn a_later_step_is_cheaper_by_the_work_that_it_does_not_do() {
    let work = |corrections, iterations| Work {
        corrections,
        iterations,
    };
    let step = TimedStep {
        seconds: 2.0,
        work: work(2.0, 20.0),
        // Half of the time on the clock was somebody else's; a fifth of it is for other parts.
        parts: [0.6, 0.6, 2.0, 4.0],
    };
    assert_eq!(step.seconds_with(work(2.0, 20.0)), 2.0);
    // A residual of three, a linearisation of two, and half of the iterations less.
    let wanted = 2.0 * (1.0 - (0.2 + 0.3 + 1.0) / 4.0);
    assert!((step.seconds_with(work(1.0, 10.0)) - wanted).abs() < 1e-12);
}

/// The coarse run solves as the scene does, or is not asked.
#[test]
fn later_steps_are_told_of_by_steps_that_are_solved_alike() {
    let finer = |settings: &str| {
        let mut scene = scene(&format!("time.step = 1e-7\n{settings}"));
        scene.mesh = Mesh::Structured {
            cells: 56,
            jitter: 0.0,
            seed: 1,
        };
        scene
    };
    let later = |scene: &Scene, method| {
        let mut go_on = || true;
        Later::of(
            scene,
            40,
            method,
            &mut Patience::new(Duration::MAX, &mut go_on),
        )
    };
    let fast = later(&finer(""), "transform");
    let factor = later(&finer(""), "factor");
    let work = |later: Later| later.work.expect("it can be told");
    assert!(!fast.with_factor && factor.with_factor);
    assert!(work(factor).iterations < work(fast).iterations);
    assert!(later(&finer(""), "shifted").work.is_some());
    // At a wall that is clamped there is the factor alone.
    let clamped = finer("domain.boundary = 'clamped'");
    assert_eq!(later(&clamped, "transform").work, None);
}

/// k jumps so much that the first step takes minutes, in parts of it.
fn hard(settings: &str) -> Scene {
    let text = format!(
        "
        mesh.cells = 12
        membrane = {{ interface_width = 0.08, spontaneous_curvature = '1e6*sign(x - 0.5)' }}
        vesicle = {{ shape = 'circle', radius = 0.25 }}
        area = {{ target = 1.25 }}
        {settings}"
    );
    Scene::of_text(&text, &[])
}

#[test]
fn a_hard_first_step_is_left_when_the_time_is_over() {
    for settings in [
        "time = { step = 1e-6, end = 1.0 }",
        "time = { tolerance = 1e-9, end = 1.0 }",
    ] {
        let scene = hard(settings);
        let mut go_on = || true;
        let mut patience = Patience::new(Duration::ZERO, &mut go_on);
        let price = match step_count(&scene.time) {
            Some(steps) => fixed::price(&scene, steps, &mut patience),
            None => chosen::price(&scene, &mut patience),
        };
        assert_eq!(price, Ok(None), "{settings}");
        assert!(!patience.is_ended());
        assert_eq!(patience.unsolved().underway, None);
    }
    let told = Unsolved {
        seconds: 10.0,
        underway: Some(StepProgress {
            step: 1,
            t: 2e-9,
            end: 1e-7,
            dt: 1e-12,
            parts: 7,
            refused: 9,
        }),
    };
    assert_eq!(
        told.to_string(),
        "the first step was not solved in 10 s: it is at t = 2.00e-9 of 1.00e-7, after 7 parts and 9 attempts \
         that failed, with \u{394}t = 1.0e-12 next"
    );
}

#[test]
fn a_price_that_nobody_waits_for_is_measured_no_further() {
    let mut asked = 0;
    let price = run_estimate(&hard("time = { step = 1e-6, end = 1.0 }"), &mut || {
        asked += 1;
        asked < 5
    });
    assert_eq!((price, asked), (Ok(Foresight::Ended), 5));
    // The thread that measures ends as well.
    let mut asked = 0;
    let price = calibrate(
        &hard("time = { step = 1e-6, end = 1.0 }"),
        LONGEST,
        &mut || {
            asked += 1;
            asked < 5
        },
    );
    assert_eq!((price, asked), (Ok(Foresight::Ended), 5));
}

#[test]
fn a_scene_that_fails_at_its_first_step_has_no_price() {
    let mut scene = scene("solver.law_tolerance = 1e-300");
    scene.mesh = Mesh::Structured {
        cells: 8,
        jitter: 0.0,
        seed: 1,
    };
    let price = run_estimate(&scene, &mut || true);
    let is_first = matches!(price, Err(SimulationError::Step { step: 1, .. }));
    assert!(is_first, "{price:?}");
}
